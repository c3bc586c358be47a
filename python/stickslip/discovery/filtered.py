"""Noise that is alike from sample to sample, as behind a sensor's filter: seen as such, and the readings thinned."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from stickslip.discovery.residual import AnyFit, by_run
from stickslip.fitted.data import Data, read_again, refined
from stickslip.measured.case import Case

Floats = NDArray[np.float64]
ALIKE = 0.2  # correlation of neighbours, from which noise is not white
APART = 0.06  # correlation below which two readings tell two things
SOON = 0.2  # of the model's time, within which noise has forgotten itself: a motion takes longer
BACK = 0.15  # what is left of its correlation by then
LATER = 3.0  # and the time over which it must not come back
FEWEST = 4  # samples in `SOON`, to see it
PEAKED = 3.5  # kurtosis beyond which a residual is the burst of a misfit; noise has 3
MOST = 1.1  # of the noise's variance, that a channel of white noise may leave


def filtered(fit: AnyFit, data: Sequence[Data]) -> tuple[int, Floats] | None:
    """How many samples apart the noise of what a fit leaves is independent, and its size over what `data` has it as
    by channel (c,); None where it is white, or what is left is not noise.

    A misfit lasts as long as the motion that it is of, a fraction of a period; a line does not end; and at transitions
    it comes in bursts. What has none of this, and yet correlates from sample to sample, is noise.
    """
    fitted = fit.engine.data
    residuals = [r * one.noise / run.noise for r, one, run in zip(by_run(fit), fitted, data, strict=False)]
    dt = float(np.median([np.median(np.diff(run.t)) for run in data]))
    soon, later = round(SOON / dt), round(LATER / dt)
    if soon < FEWEST:
        return None
    step, size = 1, np.ones(residuals[0].shape[1])
    share = fit.readings / max(fit.readings - fit.dof, 1)  # the rest was fitted away
    for c in range(2):
        series = [r[:, c] for r in residuals]
        every = np.concatenate(series)
        variance = float(np.nanmean(every**2))
        if variance < MOST:
            continue
        alike = _correlation(series, later)
        kurtosis = float(np.nanmean(every**4)) / variance**2
        if alike[1] < ALIKE or np.abs(alike[soon:]).max() > BACK or kurtosis > PEAKED:
            return None
        step = max(step, int(np.argmax(np.append(alike, 0.0) < APART)))
        size[c] = np.sqrt(variance * share)
    return (step, size) if step > 1 else None


def _correlation(series: Sequence[Floats], most: int) -> Floats:
    """Correlation at lags 0 to `most`, of several series with gaps."""
    out = np.zeros(most + 1)
    for k in range(most + 1):
        products = np.concatenate([one[k:] * one[: len(one) - k] for one in series if len(one) > k])
        out[k] = np.nanmean(products)
    return np.asarray(out / out[0])


def thinned(data: Sequence[Data], step: int, size: Floats) -> list[Data]:
    """The runs with every `step`-th reading, their noise `size` times what it was."""
    out = []
    for run in refined(data, size):
        some = replace(
            run,
            t=run.t[::step],
            readings=run.readings[::step],
            weight=run.weight[::step],
            held=run.held[::step],
        )
        out.append(read_again(some, some.readings))
    return out


def told(case: Case, data: Sequence[Data], step: int) -> str:
    """In words; `data` as thinned."""
    run = case.train[0]
    sizes = [
        f"{data[0].noise[c] / run.factor(channel):.3g} {run.unit(channel)} in {channel}".replace(
            " 1 in", " in"
        )
        for c, channel in enumerate(("x1", "y1"))
    ]
    return (
        f"the noise is alike from sample to sample, as behind a filter ({' and '.join(sizes)}): one reading in {step} "
        "is used, which are as good as independent"
    )
