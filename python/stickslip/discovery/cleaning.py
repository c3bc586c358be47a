"""What a first fit's residual says of the readings themselves: single outliers, and the size of their noise."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from math import comb

import numpy as np
from numpy.typing import NDArray

from stickslip.declared.scale import plainly
from stickslip.discovery.residual import AnyFit, by_run
from stickslip.errors import InputError
from stickslip.fitted.data import Data, refined, rounding, without_outliers

Floats = NDArray[np.float64]
LOW, HIGH = 3, 5  # orders of difference from which the noise is read
AGREE = 0.1  # by which the two may differ: a misfit shows in them very unequally, white noise alike
MOSTLY = 0.5  # noise over spread, from which a channel says nothing of the motion
OFF = 0.2  # in the logarithm, from which a declared noise is not believed


def cleaned(
    data: Sequence[Data], first: AnyFit, declared: Mapping[str, float]
) -> tuple[list[Data], tuple[str, ...]]:
    """The runs with single outliers masked and their noise corrected, and what was corrected in words.

    Parameters
    ----------
    data : all runs, those of the fit first.
    first : the declared law's fit.
    declared : noise by channel that the case gives. It is corrected only where the readings contradict it clearly.
    """
    fitted = first.engine.data
    channels = fitted[0].channels
    residuals = by_run(first)
    coarse = [rounding(run.readings) / run.noise for run in fitted]
    factor, said = np.ones(len(channels)), []
    for c, channel in enumerate(channels):
        size, sure = noise_size([r[:, c] for r in residuals])
        size = max(size, *(float(one[c]) for one in coarse))
        spread = float(np.std(np.concatenate([run.readings[:, c] for run in fitted])))
        if channel != "belt" and sure and size * float(fitted[0].noise[c]) > MOSTLY * spread:
            raise InputError(
                f"channel {channel} scatters from sample to sample nearly as much as it moves in all: is it the right "
                "column, and is the sensor alive?"
            )
        if channel not in declared:
            factor[c] = size
        elif sure and abs(np.log(size)) > OFF:
            factor[c] = size
            said.append(
                f"[noise] declares {declared[channel]:.3g} for {channel}, but its readings scatter by {plainly(size)} "
                "times that from sample to sample; taken as they scatter"
            )
    kept = without_outliers(fitted, [_bridged(r / factor) for r in residuals])
    return refined([*kept, *data[len(kept) :]], factor), tuple(said)


def _bridged(r: Floats) -> Floats:
    """Residuals (n, c) with the median of their neighbourhood where a reading is left out."""
    out = r.copy()
    for i, c in zip(*np.nonzero(~np.isfinite(r)), strict=True):
        near = r[max(0, i - 3) : i + 4, c]
        near = near[np.isfinite(near)]
        out[i, c] = np.median(near) if near.size else np.nan
    return out


def noise_size(series: Sequence[Floats]) -> tuple[float, bool]:
    """Standard deviation of the white part of residuals (n,) of several runs, and whether that is beyond doubt.

    High differences take a smooth misfit out. Two orders of them agree on white noise alone: where the sampling is so
    coarse that a misfit is left in them, they do not.
    """
    low, high = (_scatter(series, order) for order in (LOW, HIGH))
    if low is None or high is None:
        return 1.0, False
    return min(low, high), abs(float(np.log(low / high))) < AGREE


def _scatter(series: Sequence[Floats], order: int) -> float | None:
    steps = np.concatenate([np.diff(one, order) for one in series])
    steps = np.abs(steps[np.isfinite(steps) & (steps != 0)])
    if len(steps) < 100:
        return None
    return float(1.4826 * np.median(steps) / np.sqrt(comb(2 * order, order)))
