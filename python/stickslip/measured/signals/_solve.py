"""The most probable curve through a record cut into pieces, its evidence and its standard deviations.

All unknowns of `_pieces` form one banded system. The prior takes the third derivative of a slip for a
white noise of density `jerk`; levels of sticks are free.
"""

from dataclasses import dataclass

import numpy as np
import scipy

from stickslip.measured.signals._input import Floats
from stickslip.measured.signals._pieces import TERMS, Integers, SplineSystem


@dataclass(frozen=True, eq=False)
class _SplineSamples:
    """Samples sorted into slips (interval, six values) and sticks (which, time from its middle)."""

    count: int
    in_slip: Integers
    interval: Integers
    value: Floats
    in_stick: Integers
    stick: Integers
    offset: Floats

    @classmethod
    def sort(cls, system: SplineSystem, t: Floats) -> "_SplineSamples":
        place = system.place(t)
        in_slip, in_stick = np.flatnonzero(place >= 0), np.flatnonzero(place < 0)
        interval, value = system.basis(t[in_slip], place[in_slip])
        stick = -1 - place[in_stick]
        return cls(t.size, in_slip, interval, value, in_stick, stick, t[in_stick] - system.middle[stick])

    def fitted(self, system: SplineSystem, curve: Floats, unknowns: Floats) -> Floats:
        """Belt-frame displacement at every sample; `curve`: six coefficients of every interval."""
        out = np.empty(self.count)
        out[self.in_slip] = np.einsum("nb,nb->n", self.value, curve[self.interval])
        out[self.in_stick] = unknowns[system.level[self.stick]]
        if system.creep > 0.0:
            out[self.in_stick] += unknowns[system.level[self.stick] + 1] * self.offset
        return out


def _banded(size: int, parts: list[tuple[Integers, Floats]]) -> Floats:
    """Sum of small symmetric blocks (indices (g, m), values (g, m, m)) as a banded matrix, lower form."""
    key, product, band = [], [], 0
    for index, block in parts:
        for p in range(index.shape[1]):
            for q in range(p, index.shape[1]):
                low, apart = np.minimum(index[:, p], index[:, q]), np.abs(index[:, p] - index[:, q])
                value = np.where((p != q) & (apart == 0), 2.0, 1.0) * block[:, p, q]
                apart = np.where(value == 0.0, 0, apart)  # padding may point anywhere
                band = max(band, int(apart.max(initial=0)))
                key.append(apart * size + low)
                product.append(value)
    flat = np.bincount(np.concatenate(key), np.concatenate(product), minlength=(band + 1) * size)
    return np.asarray(flat.reshape(band + 1, size))


def _by_interval(interval: Integers, values: Floats, count: int) -> Floats:
    """Sum `values` over the samples of each interval; the samples are in order of time."""
    out = np.zeros((count, *values.shape[1:]))
    if interval.size:
        start = np.flatnonzero(np.diff(interval, prepend=-1))
        out[interval[start]] = np.add.reduceat(values, start, axis=0)
    return out


def _slip_part(
    system: SplineSystem, block: Floats, pull: Floats
) -> tuple[list[tuple[Integers, Floats]], Floats]:
    """Carry blocks and right sides from the coefficients of every interval to the unknowns."""
    index, weight = system.through(system.local, np.ones(pull.shape))
    width = system.unknown.shape[1]
    right = np.bincount(
        index.ravel(), (np.repeat(pull, width, axis=1) * weight).ravel(), minlength=system.size
    ).astype(np.float64)
    if width == 1:
        return [(index, block)], right
    sloped = weight[:, 1::2].any(axis=1)  # only intervals next to a stick know of its slope
    wide = np.repeat(np.repeat(block[sloped], width, axis=1), width, axis=2)
    wide *= weight[sloped, :, None] * weight[sloped, None, :]
    return [(index[~sloped, ::2], block[~sloped]), (index[sloped], wide)], right


def _stick_part(
    system: SplineSystem, samples: _SplineSamples, x: Floats
) -> tuple[tuple[Integers, Floats], Floats]:
    """Blocks and right sides of the sticks' levels and slopes, for noise 1."""
    width = system.unknown.shape[1]
    at = system.level[:, None] + np.arange(width)
    powers = [np.ones(samples.stick.size), samples.offset][:width]
    block = np.zeros((at.shape[0], width, width))
    right = np.zeros(system.size)
    if at.size:
        for p, one in enumerate(powers):
            pull = np.bincount(samples.stick, one * x[samples.in_stick], minlength=at.shape[0])
            right[at[:, p]] = pull
            for q, other in enumerate(powers):
                block[:, p, q] = np.bincount(samples.stick, one * other, minlength=at.shape[0])
    return (at, block), right


def selected_inverse(factor: Floats) -> Floats:
    """Band of the inverse of ``L L'`` from the band of L (lower form), by Takahashi's recursion."""
    band, size = factor.shape[0] - 1, factor.shape[1]
    out = np.zeros_like(factor)
    block = np.zeros((band, band))
    for j in range(size - 1, -1, -1):
        pivot = factor[0, j]
        below = factor[1:, j] / pivot
        column = -block @ below
        out[0, j] = 1.0 / (pivot * pivot) - below @ column
        out[1:, j] = column
        if band:
            block[1:, 1:] = block[:-1, :-1].copy()
            block[0, 0] = out[0, j]
            block[0, 1:] = block[1:, 0] = column[:-1]
    return out


def variances(index: Integers, weight: Floats, inverse: Floats) -> Floats:
    """Variance of each row from the band of the inverse."""
    out = np.zeros(index.shape[0])
    band = inverse.shape[0] - 1
    for p in range(index.shape[1]):
        for q in range(index.shape[1]):
            both = weight[:, p] * weight[:, q]
            apart = np.abs(index[:, p] - index[:, q])
            out += both * inverse[np.minimum(apart, band), np.minimum(index[:, p], index[:, q])]
    return np.maximum(out, 0.0)


@dataclass(frozen=True, eq=False)
class SplineSolution:
    """Unknowns, factor, and minus twice the log evidence, in all and slip by slip."""

    system: SplineSystem
    unknowns: Floats
    factor: Floats
    evidence: float
    by_slip: Floats

    def at(self, t: Floats, derivative: int = 0) -> Floats:
        """Belt-frame displacement or a derivative of it at any times."""
        index, weight = self.system.rows(t, derivative)
        return np.asarray(np.einsum("ij,ij->i", weight, self.unknowns[index]))


def solve(system: SplineSystem, t: Floats, x: Floats, sigma: float, jerk: float) -> SplineSolution:
    """Most probable unknowns given belt-frame samples (t, x) with noise `sigma`."""
    level = float(np.mean(x))
    target = (x - level) / sigma
    prior = system.prior() * (sigma**2 / jerk)  # everything in units of the noise
    samples = _SplineSamples.sort(system, t)
    outer = samples.value[:, :, None] * samples.value[:, None, :]
    count = system.slip.size
    block = prior + _by_interval(samples.interval, outer, count)
    pull = _by_interval(samples.interval, samples.value * target[samples.in_slip, None], count)
    parts, right = _slip_part(system, block, pull)
    node, stick_right = _stick_part(system, samples, target)
    if system.creep > 0.0:
        node[1][:, 1, 1] += (sigma / system.creep) ** 2
    matrix = _banded(system.size, [*parts, node])
    factor = _factor(matrix)
    unknowns = scipy.linalg.cho_solve_banded((factor, True), right + stick_right, check_finite=False)

    curve = np.einsum("cw,cw->c", system.weight, unknowns[system.unknown])
    curve = curve[system.local[:, None] + np.arange(TERMS)]
    misfit = (samples.fitted(system, curve, unknowns) - target) ** 2
    rough = (curve[:, None, :] @ prior @ curve[:, :, None])[:, 0, 0]
    slips = max(len(system.layout.intervals), 1)
    by_slip: Floats = np.bincount(_nearest_slip(system, t), misfit, minlength=slips).astype(np.float64)
    by_slip = by_slip + np.bincount(system.owner, 2.0 * np.log(factor[0]), minlength=slips)
    if count:
        by_slip = by_slip + np.bincount(system.slip, rough, minlength=slips)
        by_slip = by_slip + system.log_prior(jerk / sigma**2)
    slope_at = system.level + 1 if system.creep > 0.0 else system.level[:0]
    offset = np.full(system.size, level)
    offset[slope_at] = 0.0
    return SplineSolution(system, unknowns * sigma + offset, factor / sigma, float(by_slip.sum()), by_slip)


def _factor(matrix: Floats) -> Floats:
    """Cholesky factor; a prior so stiff that rounding hides the data is leant a little to the mean."""
    try:
        return np.asarray(scipy.linalg.cholesky_banded(matrix, lower=True, check_finite=False))
    except scipy.linalg.LinAlgError:
        matrix[0] *= 1.0 + 1e-9
        return np.asarray(scipy.linalg.cholesky_banded(matrix, lower=True, check_finite=False))


def _nearest_slip(system: SplineSystem, t: Floats) -> Integers:
    """Slip each sample is counted with: sticks are halved between their neighbours."""
    passed = np.searchsorted(system.middle, t, side="right")
    slip = passed - (not system.layout.open_start)
    return np.clip(slip, 0, max(len(system.layout.intervals) - 1, 0)).astype(np.intp)
