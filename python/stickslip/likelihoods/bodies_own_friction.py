"""A model of bodies whose friction each window has its own of, as the core takes it; and where its channels read."""

from __future__ import annotations

from collections.abc import Sequence

from stickslip.declared.law_form import LawForm
from stickslip.declared.model import Model
from stickslip.errors import InputError
from stickslip.fitted.bodies_data import BodiesData
from stickslip.likelihoods.contact_scatter import scattering
from stickslip.simulated.bodies_lowering import LoweredBodies, lower_bodies
from stickslip.simulated.general import general


def places_of(quantities: Sequence[str], names: Sequence[str]) -> list[int | str]:
    """Return the place of what each channel reads among (q, v), else its name."""
    states = [*names, *(f"v_{name}" for name in names)]
    return [states.index(name) if name in states else name for name in quantities]


def lowered(model: Model, run: BodiesData) -> LoweredBodies:
    """
    Return a model as the core takes it, each contact's friction with numbers that a window has of its own.

    Raises
    ------
    InputError
        A law has states of its own.
    """
    own = general(
        model,
        run.belt if model.rig.equations.on_belt else None,  # type: ignore[union-attr]
        run.drive if model.rig.equations.driven else None,  # type: ignore[union-attr]
        differing=_scattering,
    )
    return lower_bodies(own, model)


def _scattering(law: LawForm, place: int) -> LawForm:
    if law.states:
        words = "a law with states of its own can be simulated, and no more as yet: no reading shows them"
        raise InputError(words, key="friction")
    return scattering(law, place)
