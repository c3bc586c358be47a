"""The force balance of a driven slider within the band in which its drive explains the acceleration: what is shown."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import scipy
from numpy.typing import NDArray

from stickslip.likelihoods.driven_slider.fit import Balance
from stickslip.likelihoods.driven_slider.fitted_motion import MotionFit
from stickslip.likelihoods.driven_slider.motion import Band, DrivenRun, stacked
from stickslip.likelihoods.driven_slider.noise import Whitener
from stickslip.likelihoods.policy import POLICY

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class BandedBalance:
    """The force balance of some runs within a band, in N: what a report shows, and the error is of."""

    balance: Balance
    band: Band

    @cached_property
    def force(self) -> Floats:
        """The drive (n,)."""
        return stacked(self.balance.runs, self.band, lambda run: run.drive)

    @cached_property
    def inertia(self) -> Floats:
        """The acceleration (n,)."""
        return stacked(self.balance.runs, self.band, lambda run: run.a)

    @cached_property
    def lengths(self) -> list[int]:
        """How many rows each run has."""
        return [len(self.band.kept(len(run.t))) for run in self.balance.runs]

    @cached_property
    def _free(self) -> Floats:
        blocks = [self.band(free(run, self.band.step)) for run in self.balance.runs]
        return np.asarray(scipy.linalg.block_diag(*map(basis, blocks)), dtype=np.float64)

    def unexplained(self, fit: MotionFit) -> Floats:
        """What a fit leaves of the force (n,): nothing is fitted here but friction while its sign is in doubt."""
        return self._left(fit.law.mass * self.balance.residual(fit))

    def floor(self, fit: MotionFit, *, at_rest: bool = True) -> float:
        """Root mean square of what the noise of a fit alone leaves [N]: drawn; `at_rest` with friction there free."""
        generator = np.random.default_rng(0)
        drawn = []
        for sampling, doubt in zip(self.balance.samplings, self.balance.doubts, strict=True):
            none = Whitener(fit.noise, sampling, 0.0 * doubt)
            drawn.append(none.coloured(generator.standard_normal((none.band.shape[1], POLICY.draws))))
        left = (self._left if at_rest else self._within)(fit.law.mass * np.concatenate(drawn))
        return float(np.sqrt(np.mean(left**2)))

    def _left(self, residual: Floats) -> Floats:
        y = self._within(residual)
        return np.asarray(y - self._free @ (self._free.T @ y), dtype=np.float64)

    def _within(self, residual: Floats) -> Floats:
        parts = np.split(residual, np.cumsum(self.balance.lengths)[:-1])
        return np.concatenate([self.band(np.concatenate([one[:1], one, one[-1:]])) for one in parts])


def basis(columns: Floats) -> Floats:
    """Orthonormal columns (n, r) that span some (n, m)."""
    u, sizes, _ = np.linalg.svd(columns, full_matrices=False)
    least = max(columns.shape) * np.finfo(np.float64).eps * max(sizes, default=0.0)
    return np.asarray(u[:, sizes > least], dtype=np.float64)


def free(run: DrivenRun, step: int) -> Floats:
    """Columns (n, m): while the sign of the velocity is in doubt friction may take any value (a stick's is set-valued).

    Triangles `step` samples apart over each such stretch.
    """
    at = np.flatnonzero(run.rest)
    if not at.size:
        return np.zeros((len(run.t), 0))
    out = []
    n = np.arange(len(run.t))
    for stretch in np.split(at, np.flatnonzero(np.diff(at) > 1) + 1):
        count = max(int(np.ceil(len(stretch) / step)), 1)
        for centre in np.linspace(stretch[0], stretch[-1], count):
            out.append(np.where(run.rest, np.clip(1 - np.abs(n - centre) / step, 0, None), 0.0))
    return np.column_stack(out)
