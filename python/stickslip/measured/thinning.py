"""Long records for a fit: neighbours averaged while that loses nothing, what is longer still cut short; all said.

The mean of k readings with white noise s has noise s/sqrt(k), at the mean of their times, and white noise again: a fit
of means is a fit of the readings. A bend x'' shifts the mean by x'' (k dt)^2/24; fits simulate means for what they are
(`fit_window.half_apart`), all else takes them for readings, so that the shift is kept small. The bend is at most
omega^2 times the range at the natural frequency omega, or what the means themselves show. Where a sensor's steps are
coarser than its noise a mean is no better than a reading: one in k is kept.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from enum import Enum

import numpy as np
from numpy.typing import NDArray

from stickslip.declared.rig import AnyRig, BlockOnBelt, Rig
from stickslip.measured.case import Case
from stickslip.measured.recording import Recording
from stickslip.measured.repeats import held, held_sentence
from stickslip.measured.signals import find_clipping, find_glitches, noise_std, quantisation

Floats = NDArray[np.float64]
Mask = NDArray[np.bool_]

UNTOUCHED = 30_000  # samples of a run that a fit takes as they are: some 70 MB
FEWEST = 60  # that are left of a run
MOST = 200_000  # samples of all runs that are identified: half a gigabyte, half a minute
MOST_SEARCHED = (
    40_000  # of the train runs of a search, and of its others; of a driven slider that is identified, too
)
PER_RADIAN = 50  # samples of the natural frequency that are left: an effect five times as fast still has ten
BIAS = 0.5  # of the mean's noise, that a bend may shift it: adds an eighth to chi-squared at the sharpest bend alone
RARE = 0.999  # quantile of the bends that are seen: beyond are transitions, few and short
WHOLE = 0.75  # share of its readings that a mean is taken of at least
TOGETHER = 1.5  # of the usual span, from which neighbours lie on two sides of a gap
MOSTLY = 0.9  # share of the readings that must lie in means
WHITE = 1.15  # ratio to what white noise leaves in means, from which the noise is not white
PIECE, BESIDE = 1 << 17, 128  # samples looked at for glitches at once, and shared by neighbouring pieces
PARTS = 16  # places of a record that its noise is read at


class How(Enum):
    """What stands for k neighbours; the value is how a person calls it."""

    MEAN = "averaged"
    ONE = "one kept"
    ALL = "as they are"


@dataclass(frozen=True)
class Thinned:
    """What was done to one run.

    Attributes
    ----------
    run : str
    samples, kept : int
        Before and after.
    neighbours : int
        k.
    how : How
    share : float
        Part of the run, from its start on, that is used.
    left_out : tuple of str
        Readings of no use, in words.
    """

    run: str
    samples: int
    kept: int
    neighbours: int
    how: How
    share: float = 1.0
    left_out: tuple[str, ...] = ()

    def __str__(self) -> str:
        words = {
            How.MEAN: f"{self.neighbours} neighbours averaged",
            How.ONE: f"one of {self.neighbours} neighbours kept, the sensor's steps being coarser than its noise",
            How.ALL: "neighbours as they are, for means would bend the motion",
        }[self.how]
        cut = "" if self.share == 1 else f", of its first {100 * self.share:.2g} %"
        return f"{self.run}: thinned: {words}: {self.kept} samples for {self.samples}{cut}"


def sentences(said: Sequence[Thinned]) -> tuple[str, ...]:
    """What was done to all runs, in words."""
    return tuple(words for one in said for words in (str(one), *one.left_out))


def thinned_case(case: Case, most: int = MOST) -> tuple[Case, tuple[Thinned, ...]]:
    """A case with its long runs thinned, those of each role together; see `thinned`."""
    runs: dict[int, Recording] = {}
    said: list[Thinned] = []
    for role in ("train", "validate"):
        at = [i for i, run in enumerate(case.runs) if run.role == role]
        found, more = thinned([case.runs[i] for i in at], case.rig, most)
        runs.update(zip(at, found, strict=True))
        said += more
    return (replace(case, runs=tuple(runs[i] for i in sorted(runs))) if said else case), tuple(said)


def thinned(
    runs: Sequence[Recording], rig: AnyRig, most: int = MOST
) -> tuple[list[Recording], tuple[Thinned, ...]]:
    """Return the runs, long ones thinned, and what was done to them; the others are the same objects.

    Parameters
    ----------
    runs
        Of one rig. A run of up to 30 000 samples is left as it is, and so is one whose motion is too quick, or its
        noise too small, for means, while all together have no more than `most` samples.
    rig
        Its natural frequency says how far apart samples may be; a driven slider has none, and its readings no means.
    most
        Samples of all runs together; of more the longest runs keep their beginnings, and the others all they have.
    """
    out: list[Recording] = []
    said: list[Thinned | None] = []
    plenty = UNTOUCHED if sum(map(len, runs)) <= most else min(UNTOUCHED, most // len(runs))
    for run in runs:
        got, what = _thinned(run, rig, plenty) if len(run) > plenty else (run, None)
        out.append(got)
        said.append(what)
    longest = max(_longest([len(run) for run in out], most), FEWEST)
    for i, (whole, run) in enumerate(zip(runs, out, strict=True)):
        if len(run) > longest:
            what = said[i] or Thinned(run.name, len(whole), len(run), 1, How.ALL)
            out[i], said[i] = (
                _rows(run, slice(longest)),
                replace(what, kept=longest, share=longest / len(run)),
            )
    return out, tuple(one for one in said if one is not None)


def _longest(lengths: Sequence[int], most: int) -> int:
    """Return the samples beyond which runs are cut, so that together they have no more than `most`."""
    left, runs = most, len(lengths)
    for one in sorted(lengths):
        if one * runs > left:
            return left // runs
        left, runs = left - one, runs - 1
    return max(lengths, default=most)


def natural_rate(rig: AnyRig) -> float | None:
    """Highest natural angular frequency of a rig without damping, per unit of its time; None: it has no spring."""
    if isinstance(rig, BlockOnBelt):
        return float(np.sqrt(rig.stiffness / rig.mass))
    if not isinstance(rig, Rig):
        return None
    sign = 1.0 if rig.coupling == "reciprocal" else -1.0  # the undamped (2.1)
    squares = np.linalg.eigvals(
        np.array([[1.0, sign / rig.alpha1], [1.0 / rig.alpha2, rig.beta3 / rig.alpha2]])
    )
    return float(np.sqrt(np.abs(squares).max()))


@dataclass(frozen=True)
class _Channel:
    """A channel (n,) in the model's numbers, its bad readings bridged, and what is known of it."""

    name: str
    values: Floats
    bad: Mask
    noise: float
    coarse: bool
    limits: tuple[float | None, float | None]
    held: str | None

    def bend(self, span: int, dt: float, rate: float) -> float:
        """Largest second derivative: of an oscillation over the range at `rate`, or as seen over `span` samples."""
        whole = len(self.values) // span * span
        means = self.values[:whole].reshape(-1, span).mean(axis=1)
        seen = float(np.quantile(np.abs(np.diff(means, 2)), RARE)) / (span * dt) ** 2
        return max(seen, rate**2 * float(np.ptp(self.values)))


def _thinned(run: Recording, rig: AnyRig, plenty: int) -> tuple[Recording, Thinned | None]:
    rate = natural_rate(rig)
    if rate is None:
        return run, None
    step = np.diff(run.t)
    dt = float(np.median(step))
    widest = int(1 / (PER_RADIAN * rate * dt))
    if widest < 2:
        return run, None
    gaps = np.flatnonzero(step > TOGETHER * dt)
    channels = [
        _looked_at(run, name, gaps) for name in ("x1", "y1", "belt") if getattr(run, name) is not None
    ]
    how = How.ONE if any(one.coarse for one in channels) else How.MEAN
    if how is How.MEAN:  # a mean's noise is noise/sqrt(k), its shift bend (k dt)^2/24
        bends = [
            one.bend(widest, dt, rate) * dt**2 / one.noise if one.noise > 0 else np.inf for one in channels
        ]
        widest = min(
            widest,
            int(min((24 * BIAS / bend) ** 0.4 for bend in bends if bend > 0) if any(bends) else widest),
        )
    k = min(widest, -(-len(run) // plenty))
    while k > 1 and _together(run.t, k, dt).mean() < MOSTLY:
        k -= 1
    if k < 2:
        return run, None
    got = _means(run, channels, k, dt) if how is How.MEAN else _every(run, channels, k)
    left = tuple(one.held for one in channels if one.held)
    return got, Thinned(run.name, len(run), len(got), k, how, left_out=left)


def _looked_at(run: Recording, name: str, gaps: NDArray[np.intp]) -> _Channel:
    """What is bad in a channel, found before anything is averaged."""
    values: Floats = np.asarray(getattr(run, name), dtype=np.float64)
    bad = ~np.isfinite(values)
    values = _bridged(run.t, values, bad) if bad.any() else values
    estimated = _noise(run.t, values)
    noise = min(run.noise.get(name, np.inf), estimated) or estimated
    grid = quantisation(values)
    clipping = find_clipping(values)
    size = float(np.hypot(max(run.noise.get(name, 0.0), estimated), grid.noise))
    repeats = held(values, size) & ~clipping.mask & ~bad if size > 0 else np.zeros_like(bad)
    glitches = np.zeros_like(bad)
    for part, inner in _pieces(len(values)):
        glitches[part][inner] = find_glitches(values[part], noise=size).mask[inner]
    for i in gaps.tolist():  # neighbours beyond a gap say nothing
        glitches[max(0, i - 2) : i + 4] = False
    out = bad | repeats | (glitches & ~clipping.mask)
    sentence = held_sentence(run.name, name, run.t - run.t[0], repeats) if repeats.any() else None
    clean = _bridged(run.t, values, out) if out.any() else values
    coarse = grid.step > noise
    return _Channel(name, clean, out, noise, coarse, (clipping.low, clipping.high), sentence)


def _noise(t: Floats, values: Floats) -> float:
    """Noise of a channel, as a median over places of the record."""
    width = min(len(values) // PARTS, PIECE)
    starts = np.linspace(0, len(values) - width, PARTS).astype(int)
    return float(np.median([noise_std(values[a : a + width], t=t[a : a + width]) for a in starts]))


def _pieces(n: int) -> Iterator[tuple[slice, slice]]:
    """Overlapping pieces of n samples, and what of each is its own."""
    for first in range(0, n, PIECE):
        low, high = max(0, first - BESIDE), min(n, first + PIECE + BESIDE)
        yield slice(low, high), slice(first - low, min(first + PIECE, n) - low)


def _bridged(t: Floats, values: Floats, bad: Mask) -> Floats:
    """Values with those between the neighbours where they are bad; as they are where all are."""
    if bad.all():
        return np.zeros_like(values)
    out = values.copy()
    out[bad] = np.interp(t[bad], t[~bad], values[~bad])
    return out


def _together(t: Floats, k: int, dt: float) -> Mask:
    """Which k neighbours, side by side from the first on, have no gap among them."""
    blocks = t[: len(t) // k * k].reshape(-1, k)
    return np.asarray(blocks[:, -1] - blocks[:, 0] < TOGETHER * (k - 1) * dt)


def _means(run: Recording, channels: Sequence[_Channel], k: int, dt: float) -> Recording:
    """The means of k neighbours; NaN where too few of them are good, the sensor's limit where one is at it."""
    whole, kept = len(run) // k * k, _together(run.t, k, dt)
    t = run.t[:whole].reshape(-1, k).mean(axis=1)[kept]
    means: dict[str, Floats] = {}
    noise = dict(run.noise)
    for one in channels:
        values = one.values[:whole].reshape(-1, k)
        mean = values.mean(axis=1)
        for limit in one.limits:
            if limit is not None:
                mean[(values == limit).any(axis=1)] = limit
        mean = mean[kept]
        if one.name in noise:
            noise[one.name] *= _shrinks(t, mean, noise[one.name], k)
        mean[one.bad[:whole].reshape(-1, k).mean(axis=1)[kept] > 1 - WHOLE] = np.nan
        means[one.name] = mean
    return _with(run, t, means, noise, k * run.averaged)


def _shrinks(t: Floats, means: Floats, noise: float, k: int) -> float:
    """Noise of means over that declared of readings: 1/sqrt(k) where it is white, more where neighbours are alike."""
    white = 1 / float(np.sqrt(k))
    seen = _noise(t, means) / noise
    return min(seen, 1.0) if seen > WHITE * white else white


def _every(run: Recording, channels: Sequence[_Channel], k: int) -> Recording:
    """One reading in k; NaN where it is bad."""
    picked = {one.name: np.where(one.bad[::k], np.nan, one.values[::k]) for one in channels}
    return _with(run, run.t[::k], picked, dict(run.noise), run.averaged)


def _with(run: Recording, t: Floats, values: dict[str, Floats], noise: dict[str, float], k: int) -> Recording:
    """The run with other samples, its columns as they would read them."""
    raw = {
        name: (t if name == "t" else values["x1" if name == "spring_force" else name]) / run.factors[name]
        for name in run.raw
    }
    return replace(
        run,
        t=t,
        x1=values["x1"],
        y1=values.get("y1"),
        belt=values.get("belt"),
        raw=raw,
        noise=noise,
        averaged=k,
    )


def _rows(run: Recording, part: slice) -> Recording:
    """Some samples of a run."""

    def of(column: Floats | None) -> Floats | None:
        return None if column is None else column[part]

    return replace(
        run,
        t=run.t[part],
        x1=run.x1[part],
        y1=of(run.y1),
        belt=of(run.belt),
        drive=of(run.drive),
        raw={name: column[part] for name, column in run.raw.items()},
    )
