"""Does an effect turn the sign of friction? Such a model is simulated as declared, and it is said."""

from __future__ import annotations

import numpy as np

from stickslip.declared.effect import Effect, Tabulated
from stickslip.declared.lacking_friction import DRIVES
from stickslip.declared.model import Model

FINE = 50  # points between two knots of a curve


def driving_friction(model: Model, start: float, end: float) -> list[str]:
    """Return a sentence for each effect at the contact that can make friction negative between two times.

    An effect of the catalogue says so itself (`Behaves.drives`); a tabulated term at the contact is looked at here.
    """
    said = []
    for term in model.effects:
        if isinstance(term, Tabulated):
            said += _by_curve(term, start, end)
        elif (
            isinstance(term, Effect)
            and (drives := term.kind.behaves.drives)
            and (words := drives(term.parameters, model.friction, start, end))
        ):
            said.append(words)
    return said


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
