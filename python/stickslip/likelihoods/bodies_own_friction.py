"""A model of bodies whose friction each window has its own of, as the core takes it; and where its channels read."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from stickslip.declared.effect import effect
from stickslip.declared.model import Model
from stickslip.fitted.bodies_data import BodiesData
from stickslip.likelihoods.contact_scatter import scattering
from stickslip.simulated.bodies_lowering import LoweredBodies, lower_bodies
from stickslip.simulated.general import general

FASTER = effect("formula", called="belt_off", where="belt", factor="1 + share", share=0.0)
OFF = f"{FASTER.label}.share"


def places_of(quantities: Sequence[str], names: Sequence[str]) -> list[int | str]:
    """Return the place of what each channel reads among (q, v), else its name."""
    states = [*names, *(f"v_{name}" for name in names)]
    return [states.index(name) if name in states else name for name in quantities]


def lowered(model: Model, run: BodiesData) -> LoweredBodies:
    """
    Return a model as the core takes it, each contact's friction with numbers that a window has of its own.

    A belt whose speed is no number has one by what share it is faster: `OFF`.
    """
    if model.rig.equations.on_belt and run.belt.constant is None:  # type: ignore[union-attr]
        model = replace(model, effects=(*model.effects, FASTER))
    own = general(
        model,
        run.belt if model.rig.equations.on_belt else None,  # type: ignore[union-attr]
        run.drive if model.rig.equations.driven else None,  # type: ignore[union-attr]
        differing=scattering,
    )
    return lower_bodies(own, model)
