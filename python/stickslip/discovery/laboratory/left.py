"""What a fit of windows leaves, as the reports of residuals take it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from stickslip.discovery.laboratory.hypothesis import Bench
from stickslip.fitted.data import Data
from stickslip.fitted.window import WindowSpan
from stickslip.likelihoods.fit_state import Fit

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class _WindowLeft:
    r: Floats
    mode: NDArray[np.int8]


@dataclass(frozen=True)
class _Engine:
    data: Sequence[Data]


@dataclass(frozen=True)
class Left:
    """What a fit leaves, as `residual.describe` takes it."""

    engine: _Engine
    windows: Sequence[WindowSpan]
    blocks: Sequence[_WindowLeft]
    readings: int
    dof: float
    chi2: float

    @property
    def per_reading(self) -> float:
        """chi-squared per reading."""
        return self.chi2 / max(self.readings - self.dof, 1)


def left(bench: Bench, fit: Fit, data: Sequence[Data] | None = None) -> Left:
    """Return what a fit leaves, own numbers counted as those they take from the noise; `data` as a report has it."""
    motions = fit.windows.motions(fit.at, fit.own)
    spans, blocks = [], []
    for s, block, motion in zip(bench.stretches, fit.blocks, motions, strict=True):
        if block is not None and motion is not None:
            spans.append(s)
            blocks.append(_WindowLeft(block[:, :, -1].ravel(), motion.mode))
    assert fit.linear is not None
    assert fit.solution is not None
    count = int(fit.linear.count.sum())
    taken = float(fit.freedom.sum()) + len(fit.at)
    chi2 = float(sum(b.r @ b.r for b in blocks))
    return Left(_Engine(bench.data if data is None else data), spans, blocks, count, taken, chi2)
