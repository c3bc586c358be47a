"""The residual of a fitted motion: its size against the noise, where it sits, its spectrum, and the arrays to draw."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import scipy
from numpy.typing import NDArray

from stickslip.discovery.driven_slider.fit import Balance
from stickslip.discovery.driven_slider.fitted_motion import MotionFit
from stickslip.discovery.driven_slider.motion import Band, DrivenRun, stacked
from stickslip.discovery.driven_slider.noise import Whitener
from stickslip.discovery.driven_slider.policy import STEER
from stickslip.discovery.driven_slider.result import ForceView
from stickslip.discovery.result import Part, Residual
from stickslip.likelihoods.policy import POLICY

Floats = NDArray[np.float64]

PARTS = 4  # of speeds, places and times that are told apart


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

    def floor(self, fit: MotionFit) -> float:
        """Root mean square of what the noise of a fit alone leaves [N]: drawn."""
        generator = np.random.default_rng(0)
        drawn = []
        for sampling, doubt in zip(self.balance.samplings, self.balance.doubts, strict=True):
            none = Whitener(fit.noise, sampling, 0.0 * doubt)
            drawn.append(none.coloured(generator.standard_normal((none.band.shape[1], POLICY.draws))))
        left = self._left(fit.law.mass * np.concatenate(drawn))
        return float(np.sqrt(np.mean(left**2)))

    def _left(self, residual: Floats) -> Floats:
        parts = np.split(residual, np.cumsum(self.balance.lengths)[:-1])
        y = np.concatenate([self.band(np.concatenate([one[:1], one, one[-1:]])) for one in parts])
        return np.asarray(y - self._free @ (self._free.T @ y), dtype=np.float64)


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


def describe(balance: Balance, fit: MotionFit) -> Residual:
    """The residual of a fit, in white units, against the noise: over all, by direction, speed, place and time."""
    w = fit.white
    chi2 = float(w @ w) / max(fit.count - fit.freedom, 1)
    error = float(np.sqrt(2 / max(fit.count, 1)))
    sure = balance.sure
    centred = np.where(sure, w - np.mean(w[sure]), 0.0) if fit.count else w
    r = [float(centred[k:] @ centred[: len(w) - k]) for k in range(2 * STEER.order)]
    whiteness = max(map(abs, r[1:])) / max(r[0], 1e-300) * np.sqrt(max(fit.count, 1)) / 1.96
    parts, clean = _parts(balance, w), chi2 < 1 + 1.96 * error
    worst = max(parts, key=lambda one: one.chi2, default=None)
    where = f"most of it at {worst.what} {worst.name} ({worst.chi2:.3g})" if worst else ""
    if clean:
        words = f"what is left is noise: chi-squared per reading is {chi2:.3g}"
    else:
        words = f"chi-squared per reading is {chi2:.3g} where the noise leaves 1; {where}"
    return Residual(chi2, error, float(whiteness), clean, parts, words)


def _parts(balance: Balance, w: Floats) -> tuple[Part, ...]:
    sure = balance.sure
    w = w[sure]
    x, v, t = (_rows(balance, name)[sure] for name in ("x", "v", "t"))
    if not w.size:
        return ()
    groups: list[tuple[str, str, NDArray[np.bool_]]] = [
        ("direction", "x2 > 0", v > 0),
        ("direction", "x2 < 0", v < 0),
    ]
    for what, u, unit in (("speed", np.abs(v), "m/s"), ("place", x, "m"), ("time", t, "s")):
        edges = np.quantile(u, np.linspace(0, 1, PARTS + 1))
        for low, high in zip(edges[:-1], edges[1:], strict=True):
            groups.append((what, f"{low:.3g} to {high:.3g} {unit}", (u >= low) & (u <= high)))
    out = []
    for what, name, chosen in groups:
        count = int(chosen.sum())
        if count > 1:
            power = float(np.mean(w[chosen] ** 2))
            out.append(Part(what, name, power, power * float(np.sqrt(2 / count)), count))
    return tuple(out)


def _rows(balance: Balance, name: str) -> Floats:
    """A quantity of the runs at the white rows (n',)."""
    return np.concatenate([getattr(run, name)[STEER.order + 2 : -1] for run in balance.runs])


def spectrum(balance: Balance, before: Floats, after: Floats) -> dict[str, Floats]:
    """Power of white residuals over angular frequency, 1 for white noise."""
    rate = 1 / balance.runs[0].dt
    unit = rate / 2 / max(float(np.mean(balance.sure)), 1e-300)  # the other rows are 0
    size = int(min(512, len(before) // 4))
    f, was = scipy.signal.welch(before, fs=rate, nperseg=size)
    _, now = scipy.signal.welch(after, fs=rate, nperseg=size)
    return {"frequency": 2 * np.pi * f[1:], "before": was[1:] * unit, "after": now[1:] * unit}


def views(role: str, shown: BandedBalance, before: MotionFit, after: MotionFit) -> tuple[ForceView, ...]:
    """The balances to draw of every run."""
    was, now = shown.unexplained(before), shown.unexplained(after)
    out, at = [], 0
    for run, n in zip(shown.balance.runs, shown.lengths, strict=True):
        kept = shown.band.kept(len(run.t))
        part = slice(at, at + n)
        force = shown.force[part]
        friction = force - after.law.mass * shown.inertia[part]
        out.append(
            ForceView(run.name, role, run.t[kept], run.x[kept], run.v[kept], force, friction, was[part], now[part])
        )  # fmt: skip
        at += n
    return tuple(out)
