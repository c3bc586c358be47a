"""What each candidate does to the four numbers of an event, as columns of a linear model.

    ln rate      = ln of (declared gain, spring, belt speed) wrong
    ln frequency = ln(k/m) wrong
    damping      = c/(2 sqrt(k m)) of whatever brakes the slip beside the declared damper
    level        = relative change of the friction along the belt, in time, with the rest before it

A parameter that acts on several of them has one column over all.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from stickslip.declared.rig import BlockOnBelt
from stickslip.discovery.slider.population import Block

Floats = NDArray[np.float64]
Columns = Mapping[str, Floats]  # by block, (n, p)
WAVES = 72  # wavelengths, or periods, tried
MOST_WAVE, LEAST_WAVE = 0.6, 5.0  # of the travel seen; of the distance between events
AGES = 3


@dataclass(frozen=True)
class Candidate:
    """One hypothesis: columns by block, linear in `count` parameters.

    `sign` +1 or -1: what the one parameter may be (0: either). `scale` is the number that the columns were made with
    (wavelength, frequency, time constant), 0 if there is none. `acts` says which blocks it touches, `per_run` whether
    the columns come in pairs, a sine and a cosine for each run.
    """

    name: str
    columns: Columns
    count: int
    sign: int = 0
    scale: float = 0.0
    per_run: bool = False
    searched: int = 0  # numbers that were found by a search over `scale`
    slope: Floats | None = None  # d column/d level, for a column that depends on the level itself

    @property
    def parameters(self) -> int:
        """How many numbers the data decide."""
        return self.count + self.searched


@dataclass(frozen=True)
class Declared:
    """The declared numbers that columns need: stiffness, mass, whether the channel is a force."""

    rig: BlockOnBelt
    force_channel: bool


def candidates(blocks: Sequence[Block], declared: Declared) -> Iterator[Candidate]:
    """All candidates for one degree of freedom."""
    by = {one.name: one for one in blocks}
    yield from _constants(by, declared)
    yield from _springs(by, declared)
    yield from _brakes(by, declared)
    yield from _belt(by, declared)
    yield from _levels(by)
    yield from _ages(by["level"])


def _ones(block: Block, factor: float = 1.0) -> Floats:
    return np.full((len(block), 1), factor)


def _constants(by: Mapping[str, Block], declared: Declared) -> Iterator[Candidate]:
    rate, frequency = by["rate"], by["frequency"]
    yield Candidate("sensor_gain", {"rate": _ones(rate)}, 1)
    yield Candidate("rig_mass", {"frequency": _ones(frequency, -1.0)}, 1)
    own = {"rate": _ones(rate)} if declared.force_channel else {}
    yield Candidate("rig_stiffness", {**own, "frequency": _ones(frequency)}, 1)


def _springs(by: Mapping[str, Block], declared: Declared) -> Iterator[Candidate]:
    """A cubic spring hardens by 3 k x^2, in the sticks too for a force sensor; curved readings; a soft contact."""
    rate, frequency = by["rate"], by["frequency"]
    stiffness = declared.rig.stiffness
    hard = {"frequency": 3 * frequency.x[:, None] ** 2 / stiffness}
    if declared.force_channel:
        hard["rate"] = 3 * rate.x[:, None] ** 2 / stiffness
    yield Candidate("spring_cubic_k1", hard, 1)
    yield Candidate("sensor_nonlinearity", {"rate": 2 * rate.x[:, None]}, 1)
    yield Candidate("contact_compliance", {"rate": _ones(rate, -1.0)}, 1, sign=1)


def _brakes(by: Mapping[str, Block], declared: Declared) -> Iterator[Candidate]:
    damping = by["damping"]
    own = 2 * np.sqrt(declared.rig.stiffness * declared.rig.mass)
    yield Candidate("block_viscous_damping", {"damping": _ones(damping, 1 / own)}, 1, sign=1)
    # a slip of largest speed U loses to -c v|v| what it loses to a viscous 8 c U/(3 pi)
    squared = 8 * damping.top[:, None] / (3 * np.pi) / own
    yield Candidate("block_quadratic_damping", {"damping": squared}, 1, sign=1)


def _belt(by: Mapping[str, Block], declared: Declared) -> Iterator[Candidate]:
    rate, level = by["rate"], by["level"]
    # what drifts in a stick has drifted since the run began
    drifted = (level.t / _means(level))[:, None]
    yield Candidate("sensor_drift", {"rate": 1 / rate.speed[:, None], "level": drifted}, 1)
    force = declared.rig.stiffness * rate.x[:, None]
    yield Candidate("belt_load_droop", {"rate": -force / rate.speed[:, None]}, 1, sign=1)
    for period in _periods(rate, rate.t):
        yield waves(tuple(by.values()), "belt_speed_ripple", 2 * np.pi / period)


def _levels(by: Mapping[str, Block]) -> Iterator[Candidate]:
    level = by["level"]
    yield Candidate("friction_drift", {"level": level.t[:, None]}, 1)
    for length in _periods(level, level.travel):
        yield waves(tuple(by.values()), "belt_seam", float(length))
    for period in _periods(level, level.t):
        yield waves(tuple(by.values()), "harmonic_forcing", 2 * np.pi / period)


def waves(blocks: Sequence[Block], name: str, scale: float) -> Candidate:
    """A periodic candidate: belt_seam of a wavelength, or another of an angular frequency."""
    block = next(one for one in blocks if one.name == ("rate" if name == "belt_speed_ripple" else "level"))
    size = 1 / _means(block) if name == "harmonic_forcing" else np.ones(len(block))
    if name == "belt_seam":
        columns = _wave(block, block.travel - block.x, scale, size)
    else:
        columns = _wave(block, block.t, 2 * np.pi / scale, size)
    return Candidate(name, {block.name: columns}, columns.shape[1], scale=scale, per_run=True, searched=1)


def _means(level: Block) -> Floats:
    """Mean force at breakaway of each event's run, over the stiffness."""
    out = np.ones(len(level))
    for run in np.unique(level.run):
        out[level.run == run] = level.load[level.run == run].mean()
    return out


def _ages(level: Block) -> Iterator[Candidate]:
    """Rest strengthens the contact: dT (1 - exp(-dwell/tau)).

    A high level makes a long rest by itself, since the spring needs longer to reach it. `slope`, how much the column
    grows when the level does, gives the determinant that keeps this from passing for ageing.
    """
    if len(level) < 8:
        return
    climb = level.speed * _rise(level) / _means(level)  # relative level per time at rest
    for tau in np.quantile(level.dwell, [0.25, 0.6, 0.95])[:AGES]:
        grown = np.exp(-level.dwell / tau)
        yield Candidate(
            "static_aging",
            {"level": (1 - grown)[:, None]},
            1,
            sign=1,
            scale=float(tau),
            searched=1,
            slope=grown / (tau * climb),
        )


def _rise(level: Block) -> float:
    """How fast the spring is really stretched over the set-point speed, from the rests themselves."""
    climbed = level.x[1:] - (level.x[:-1] - level.fall[:-1])
    same = (level.run[1:] == level.run[:-1]) & (climbed > 0)
    expected = level.speed[1:] * level.dwell[1:]
    return float(np.clip(np.median(climbed[same] / expected[same]), 0.3, 3.0)) if same.any() else 1.0


def _periods(block: Block, along: Floats) -> Floats:
    """Periods that the runs can show: a few events long at least, two thirds of the longest run at most."""
    spans, steps = [], []
    for run in np.unique(block.run):
        at = np.sort(along[block.run == run])
        if len(at) > 8:
            spans.append(float(np.ptp(at)))
            steps.append(float(np.median(np.diff(at))))
    if not spans or min(steps) <= 0:
        return np.zeros(0)
    low, high = LEAST_WAVE * min(steps), MOST_WAVE * max(spans)
    if low >= high:
        return np.zeros(0)
    # even in wave number, so that neighbours differ by a fraction of a cycle over the span; most are long
    return 1 / np.geomspace(1 / high, 1 / low, WAVES)


def _wave(block: Block, along: Floats, period: float, size: Floats) -> Floats:
    """A sine and a cosine for every run, (n, 2 runs)."""
    runs = np.unique(block.run)
    out = np.zeros((len(block), 2 * len(runs)))
    for j, run in enumerate(runs):
        at = block.run == run
        angle = 2 * np.pi * along[at] / period
        out[at, 2 * j], out[at, 2 * j + 1] = size[at] * np.sin(angle), size[at] * np.cos(angle)
    return out
