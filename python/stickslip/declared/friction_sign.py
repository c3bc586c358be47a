"""Does an effect turn the sign of friction? Such a model is simulated as declared, and it is said."""

from __future__ import annotations

import numpy as np

from stickslip.declared.effect import Effect, Tabulated
from stickslip.declared.model import Model

SPEEDS = np.linspace(0.0, 6.0, 601)  # in widths of a Stribeck peak
FINE = 50  # points between two knots of a curve


def driving_friction(model: Model, start: float, end: float) -> list[str]:
    """Return a sentence for each effect at the contact that can make friction negative between two times.

    Of the catalogue these are `friction_drift` (from a time on), `stribeck_peak` and `static_aging`; and a tabulated
    term at the contact. `normal_force_feedback` stops at zero by itself, a `belt_seam` has |a| <= 1.
    """
    said = []
    for term in model.effects:
        if isinstance(term, Tabulated):
            said += _by_curve(term, start, end)
        elif term.name == "friction_drift":
            said += _by_drift(term.parameters["r"], start, end)
        elif term.name in ("stribeck_peak", "static_aging"):
            said += _by_height(model, term)
    return said


DRIVES = "friction is negative then and drives the block"


def _by_drift(r: float, start: float, end: float) -> list[str]:
    if min(1 + r * start, 1 + r * end) >= 0:
        return []
    until = "from" if r < 0 else "until"
    return [f"friction_drift.r = {r:g}: 1 + r t is below 0 {until} t = {-1 / r:.4g}; {DRIVES}"]


def _by_height(model: Model, term: Effect) -> list[str]:
    height = term.parameters["dT"]
    if height >= 0:
        return []
    limits = model.friction.static_limits
    lacking = min(limits) + height < 0
    if term.name == "stribeck_peak" and not lacking:
        u = SPEEDS * term.parameters["v_s"]
        change = height * np.exp(-(SPEEDS**2))
        lacking = any(np.min(model.friction.magnitude(side * u[1:]) + change[1:]) < 0 for side in (-1.0, 1.0))
    words = f"takes more than the declared friction has (static limits {limits[0]:.4g} and {limits[1]:.4g})"
    return [f"{term.name}.dT = {height:g}: {words}; {DRIVES}"] if lacking else []


def _by_curve(term: Tabulated, start: float, end: float) -> list[str]:
    if term.where != "contact":
        return []
    knots = np.array(term.knots)
    at = np.unique(
        np.concatenate([np.linspace(a, b, FINE) for a, b in zip(knots[:-1], knots[1:], strict=True)])
    )
    if term.variable == "t" and (term.period is None or end - start < term.period):
        inside = knots[(knots >= start) & (knots <= end)]
        at = np.concatenate([np.linspace(start, end, FINE * len(knots)), inside])
    low = int(np.argmin(g := term.curve(at)))
    if g[low] >= -1:
        return []
    where = f"g = {g[low]:.4g} at {term.variable} = {at[low]:.4g}"
    return [f"{term.name}: {where}, and 1 + g is below 0; {DRIVES} wherever it comes there"]
