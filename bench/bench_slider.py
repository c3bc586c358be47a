"""How often something is named on records like the paper slider's that lack nothing, and what is found where it acts.

Usage: python bench/bench_slider.py [--draws 20] [--planted gain=0.1 mass=-0.5] [--out FILE.json]

Records are drawn as the recording shipped with the package is: a Coulomb block whose breakaway wanders along the belt
and differs from event to event by what the events of the recording do, whose slips are as long as those, sampled,
quantised and glitched alike. Nothing of the search is used to draw them. Without a planted error every name is a
false alarm.
"""

from __future__ import annotations

import argparse
import json
import time
from collections import Counter
from dataclasses import dataclass, replace
from importlib.resources import as_file, files
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from threadpoolctl import threadpool_limits

import stickslip as ss
from stickslip import build_config
from stickslip.fitted.block_events.cycle import S, duration, positions
from stickslip.fitted.block_events.table import MeasuredBlock, damping_ratio, measure, natural_rate, prepare
from stickslip.measured.case import Case, Recording, load_case

Floats = NDArray[np.float64]
SHORTEST = 0.05  # of a fall: the least climb of a stick


@dataclass(frozen=True)
class Planted:
    """Relative errors of the sensor's gain and of the mass: true over declared less 1."""

    gain: float = 0.0
    mass: float = 0.0


@dataclass(frozen=True)
class Process:
    """How breakaway differs, over its mean: a wander with its correlation length, and from event to event."""

    wander: float
    length: float
    each: float


def main() -> None:
    """Draw, search, count."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--draws", type=int, default=20)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--planted", nargs="*", default=[], help="name=value of Planted")
    parser.add_argument("--out", type=Path)
    given = parser.parse_args()
    planted = Planted(**{name: float(value) for name, value in (one.split("=") for one in given.planted)})
    with threadpool_limits(1):
        result = count(shipped(), range(given.first, given.first + given.draws), planted)
    print(json.dumps(result, indent=1))
    if given.out:
        given.out.write_text(json.dumps(result | {"build": build_config()}, indent=1, default=str) + "\n")


def shipped() -> Case:
    """The case of the recording that comes with the package."""
    with as_file(files("stickslip") / "data" / "paper_slider") as folder:
        return load_case(folder / "rig.toml")


def count(case: Case, seeds: range, planted: Planted) -> dict[str, object]:
    """Names found over draws, how many of these had none, errors on unused runs, and the processor time of one."""
    measured = [measure(prepare(one)) for one in case.runs]
    process = process_of(measured)
    names: Counter[str] = Counter()
    silent, covered, errors, began = 0, 0, [], time.process_time()
    truth = {"sensor_gain": planted.gain, "rig_mass": planted.mass}
    for seed in seeds:
        rng = np.random.default_rng(seed)
        runs = [
            as_read(recording, one, drawn(one, process, planted, rng), planted, rng)
            for recording, one in zip(case.runs, measured, strict=True)
        ]
        found = ss.discover(replace(case, runs=tuple(runs)), threads=1)
        silent += not found.effects
        names.update(one.name for one in found.effects)
        for one in found.effects:
            if truth.get(one.name):
                covered += one.parameters["e"].low <= truth[one.name] <= one.parameters["e"].high
        errors.append((found.error.before, found.error.after, found.error.floor))
    seconds = (time.process_time() - began) / max(len(seeds), 1)
    return {
        "planted": str(planted),
        "process": str(process),
        "draws": len(seeds),
        "silent": silent,
        "named": dict(names),
        "intervals that cover": covered,
        "error before, after, floor": np.median(errors, axis=0).tolist(),
        "seconds each": seconds,
    }


def process_of(measured: list[MeasuredBlock]) -> Process:
    """The process of the breakaways of all runs, by the variogram of their levels along the belt."""
    gaps, squares = [], []
    for one in measured:
        level = one.events.p[:, S] / one.events.p[:, S].mean() - 1
        i, j = np.triu_indices(len(level), 1)
        gaps.append(one.events.travel[j] - one.events.travel[i])
        squares.append((level[i] - level[j]) ** 2)
    gap, half = np.concatenate(gaps), 0.5 * np.concatenate(squares)
    edges = np.quantile(gap, np.linspace(0, 0.5, 13))
    at = np.array([gap[(gap >= a) & (gap < b)].mean() for a, b in zip(edges[:-1], edges[1:], strict=True)])
    seen = np.array([half[(gap >= a) & (gap < b)].mean() for a, b in zip(edges[:-1], edges[1:], strict=True)])
    best = min(
        (_fitted(at, seen, length) for length in np.geomspace(at[0], at[-1], 40)), key=lambda one: one[0]
    )
    return Process(*best[1:])


def _fitted(at: Floats, seen: Floats, length: float) -> tuple[float, float, float, float]:
    """Squares left by an exponential variogram of a length, and its wander, length and nugget."""
    columns = np.column_stack([1 - np.exp(-at / length), np.ones_like(at)])
    (sill, nugget), *_ = np.linalg.lstsq(columns, seen, rcond=None)
    sill, nugget = max(float(sill), 0.0), max(float(nugget), 0.0)
    left = float(((columns @ [sill, nugget] - seen) ** 2).sum())
    return left, float(np.sqrt(sill)), length, float(np.sqrt(nugget))


def drawn(one: MeasuredBlock, process: Process, planted: Planted, rng: np.random.Generator) -> Floats:
    """Deflections (n,) of one run, event after event."""
    run, e = one.run, one.events
    mean, falls = float(e.p[:, S].mean()), e.p[:, S] - e.arrest
    log_w2 = 2 * np.log(natural_rate(run.rig)) - np.log1p(planted.mass)
    x, at, t = np.empty(len(run.t)), 0, 0.0
    now, wander, last = mean - float(np.median(falls)), process.wander * rng.standard_normal(), 0.0
    while at < len(run.t):
        travel = run.belt_speed * t
        keep = np.exp(-(travel - last) / process.length)
        wander = keep * wander + process.wander * np.sqrt(1 - keep**2) * rng.standard_normal()
        last, fall = travel, float(rng.choice(falls))
        top = max(mean * (1 + wander + process.each * rng.standard_normal()), now + SHORTEST * fall)
        release = t + (top - now) / run.belt_speed
        p = np.array([[top, top - 0.5 * fall, release, run.belt_speed, log_w2, damping_ratio(run.rig)]])
        t = release + float(duration(p)[0])
        end = int(np.searchsorted(run.t, t))
        x[at:end] = positions(p, run.t[None, at:end])[0]
        now, at = float(positions(p, np.array([[t]]))[0, 0]), max(end, at)
    return x


def as_read(
    recording: Recording, one: MeasuredBlock, x: Floats, planted: Planted, rng: np.random.Generator
) -> Recording:
    """Through the sensor: gain, noise, quantisation, and the glitches where they were."""
    run = one.run
    read = (1 + planted.gain) * x
    read += np.sqrt(max(run.noise**2 - run.step**2 / 12, 0.0)) * rng.standard_normal(len(x))
    bad = np.isnan(run.x)
    read[bad] += rng.choice([-1.0, 1.0], bad.sum()) * run.noise * rng.uniform(6, 20, bad.sum())
    if run.step:
        read = run.step * np.round(read / run.step)
    return replace(recording, x1=run.sign * read)


if __name__ == "__main__":
    main()
