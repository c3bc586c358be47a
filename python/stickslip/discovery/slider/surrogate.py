"""Surrogate records: the declared model with the process noise found, sampled, quantised and glitched as the original.

What the loop must stay silent on, and, with an effect planted, what it must find.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from stickslip.discovery.slider.population import Block, blocks
from stickslip.fitted.block_events.cycle import S, duration, positions
from stickslip.fitted.block_events.table import Measured, damping_ratio, measure, natural_rate, prepare
from stickslip.measured.case import Case, Recording

Floats = NDArray[np.float64]
SHORTEST = 0.05  # of a fall: the least climb of a stick


@dataclass(frozen=True)
class Planted:
    """What is true beside the declared model: relative errors of constants, a wave of friction, damping, ageing.

    `seam` is the amplitude and the wavelength, `ageing` the growth over the mean level and its time constant.
    """

    gain: float = 0.0
    mass: float = 0.0
    stiffness: float = 0.0
    damping: float = 0.0
    seam: tuple[float, float] = (0.0, 1.0)
    ageing: tuple[float, float] = (0.0, 1.0)


NOTHING = Planted()


@dataclass(frozen=True)
class Source:
    """A case with the events of all its runs and their process noise, from which surrogates are drawn."""

    case: Case
    measured: tuple[Measured, ...]
    noise: tuple[Block, ...]


def source(case: Case) -> Source:
    """Measure a case once."""
    measured = tuple(measure(prepare(one)) for one in case.runs)
    return Source(case, measured, tuple(blocks(measured)))


def surrogate(origin: Source, seed: int, planted: Planted = NOTHING) -> Case:
    """A case with every run drawn anew; runs cut from one recording share their set-point's error.

    Parameters
    ----------
    origin : Source
    seed : int
    planted : Planted
    """
    rng = np.random.default_rng(seed)
    rate = next(one for one in origin.noise if one.name == "rate")
    errors = {one.run.source: rate.shared * rng.standard_normal() for one in origin.measured}
    runs = []
    for number, (recording, one) in enumerate(zip(origin.case.runs, origin.measured, strict=True)):
        x = _record(one, number, origin.noise, planted, errors[one.run.source], rng)
        runs.append(_as_read(recording, one, x, planted, rng))
    return replace(origin.case, runs=tuple(runs))


def _record(
    one: Measured,
    number: int,
    noise: Sequence[Block],
    planted: Planted,
    error: float,
    rng: np.random.Generator,
) -> Floats:
    """Deflections (n,) of one run, event after event."""
    run, e = one.run, one.events
    by = {block.name: block for block in noise}
    carried = run.rig.damping * run.belt_speed / run.rig.stiffness
    mean, falls = float(e.p[:, S].mean()) + carried, e.p[:, S] - e.arrest
    w2 = 2 * np.log(natural_rate(run.rig)) + np.log((1 + planted.stiffness) / (1 + planted.mass))
    scatter = {n: _median(by[n], number) for n in ("rate", "frequency", "damping")}
    sigma, length, tau = by["level"].wander
    x, at, t = np.empty(len(run.t)), 0, 0.0
    now, wander = mean - carried - float(np.median(falls)), sigma * rng.standard_normal()
    phase, last = rng.uniform(0, 2 * np.pi), 0.0
    while at < len(run.t):
        travel = run.belt_speed * t
        keep = np.exp(-(travel - last) / length)
        wander, last = keep * wander + sigma * np.sqrt(1 - keep**2) * rng.standard_normal(), travel
        a, wave = planted.seam
        level = wander + tau * rng.standard_normal() + a * np.sin(2 * np.pi * (travel - now) / wave + phase)
        rate = run.belt_speed * np.exp(error + scatter["rate"] * rng.standard_normal())
        fall = float(rng.choice(falls))
        top = _breakaway(mean * (1 + level) - carried, now + SHORTEST * fall, now, rate, mean, planted.ageing)
        zeta = damping_ratio(run.rig) + planted.damping + scatter["damping"] * rng.standard_normal()
        log_w2 = w2 + scatter["frequency"] * rng.standard_normal()
        release = t + (top - now) / rate
        p = np.array([[top, top - 0.5 * fall, release, rate, log_w2, float(np.clip(zeta, -0.6, 0.6))]])
        t = release + float(duration(p)[0])
        end = int(np.searchsorted(run.t, t))
        x[at:end] = positions(p, run.t[None, at:end])[0]
        now, at = float(positions(p, np.array([[t]]))[0, 0]), max(end, at)
    return x


def _breakaway(
    level: float, least: float, now: float, rate: float, mean: float, ageing: tuple[float, float]
) -> float:
    """Deflection at which the spring first meets the level, grown by the rest before it."""
    grown, tau = ageing
    top = max(level, least)
    for _ in range(60 if grown else 0):
        top = max(level + grown * mean * (1 - np.exp(-(top - now) / rate / tau)), least)
    return top


def _median(block: Block, number: int) -> float:
    own = block.spread[block.run == number]
    return float(np.median(own)) if len(own) else 0.0


def _as_read(
    recording: Recording, one: Measured, x: Floats, planted: Planted, rng: np.random.Generator
) -> Recording:
    """Through the sensor: gain, noise, quantisation, and the glitches where they were."""
    run = one.run
    gain = (1 + planted.gain) * (1 + planted.stiffness if run.force_channel else 1.0)
    read = gain * x + np.sqrt(max(run.noise**2 - run.step**2 / 12, 0.0)) * rng.standard_normal(len(x))
    bad = np.isnan(run.x)
    read[bad] += rng.choice([-1.0, 1.0], bad.sum()) * run.noise * rng.uniform(6, 20, bad.sum())
    if run.step:
        read = run.step * np.round(read / run.step)
    return replace(recording, x1=run.sign * read)


__all__ = ["NOTHING", "Planted", "Source", "source", "surrogate"]
