"""Learned curves: forces and friction factors for what no name of the catalogue explains."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import scipy
from numpy.typing import NDArray

from stickslip.declared.effect import Tabulated, tabulated
from stickslip.declared.uncertainty import SIGMAS_95
from stickslip.discovery.result import Curve
from stickslip.likelihoods.driven_slider.motion import DrivenRun
from stickslip.likelihoods.driven_slider.policy import STEER
from stickslip.likelihoods.driven_slider.terms import ForceTerm, Law

Floats = NDArray[np.float64]


class CurveTerm:
    """A curve as a candidate: natural cubic spline over `knots`, 0 at the knots `pinned`.

    `where` is "block" (a force) or "contact" (friction times 1 + g), `variable` x1, t or v_w. A constant force and a
    constant factor of friction are the law's own, hence the pins.
    """

    def __init__(self, where: str, variable: str, knots: Floats, pinned: Sequence[int]) -> None:
        self.where, self.variable, self.knots = where, variable, knots
        self.free = [i for i in range(len(knots)) if i not in pinned]
        self.spline = scipy.interpolate.CubicSpline(knots, np.eye(len(knots)), bc_type="natural")
        self.name = f"tabulated_{where}_{variable}"

    def basis(self, run: DrivenRun) -> Floats:
        """Values (n, k) of the spline for 1 at each free knot."""
        u = {"x1": run.x, "t": run.t, "v_w": run.v}[self.variable]
        return np.asarray(
            self.spline(np.clip(u, self.knots[0], self.knots[-1]))[:, self.free], dtype=np.float64
        )

    def term(self) -> ForceTerm:
        """The candidate."""

        def columns(run: DrivenRun, _: Floats, law: Law) -> Floats:
            scale = -np.ones(len(run.t)) if self.where == "block" else law.friction(run)
            return scale[:, None] * self.basis(run)

        def parameters(_: Floats, b: Floats, __: Law) -> dict[str, float]:
            return {f"value_{i}": float(one) for i, one in enumerate(self.values(b))}

        return ForceTerm(
            self.name,
            (),
            len(self.free),
            columns,
            parameters,
            scaled=self.where == "contact",
            sliding=self.where == "contact",
        )

    def values(self, b: Floats) -> Floats:
        """The curve at its knots, of the coefficients of the free ones."""
        out = np.zeros(len(self.knots))
        out[self.free] = b
        return out

    def curve(self, b: Floats, deviation: Floats) -> Curve:
        """The curve with its 95 % band, for a report; `deviation` is that of every value at a knot."""
        x = np.linspace(self.knots[0], self.knots[-1], 121)
        value = self.spline(x) @ self.values(b)
        spread = SIGMAS_95 * np.sqrt((self.spline(x) ** 2) @ deviation**2)
        term = "force on the slider" if self.where == "block" else "friction factor minus 1"
        return Curve(
            self.where, self.variable, term, x, value, value - spread, value + spread, self.knots, None
        )

    def effect(self, b: Floats) -> Tabulated:
        """The curve as an effect of a model."""
        return tabulated(self.where, self.variable, self.knots.tolist(), self.values(b).tolist())


def curves(runs: Sequence[DrivenRun]) -> tuple[CurveTerm, ...]:
    """The curves to try."""
    fastest = max(float(np.percentile(np.abs(run.v), 99.5)) for run in runs)
    low, high = min(float(run.x.min()) for run in runs), max(float(run.x.max()) for run in runs)
    start, end = float(runs[0].t[0]), float(runs[-1].t[-1])
    # closer towards rest, where friction bends; nearer than the first knot rest and motion are not told apart
    half = np.geomspace(STEER.middle, 1.0, STEER.knots // 2 + 1)
    speeds = np.concatenate([-half[::-1], half])
    middle = [len(half) - 1, len(half)]
    return (
        CurveTerm("block", "x1", np.linspace(low, high, STEER.knots), [0]),
        CurveTerm("contact", "x1", np.linspace(low, high, STEER.knots), [0]),
        CurveTerm("contact", "v_w", fastest * speeds, middle),
        CurveTerm("block", "t", np.linspace(start, end, STEER.knots), [0]),
    )
