"""From what was chosen to complete models: the law of the mean event, the effects with their numbers and intervals."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from stickslip.declared.effect import Effect
from stickslip.declared.friction.coulomb import CoulombFriction
from stickslip.declared.friction_law import FrictionLaw
from stickslip.declared.model import Model
from stickslip.discovery.result import Interval
from stickslip.discovery.slider.choose import Choice
from stickslip.discovery.slider.law import Law, law_beside, terms
from stickslip.discovery.slider.population import Block
from stickslip.discovery.slider.weigh import Weighed
from stickslip.errors import InputError
from stickslip.fitted.block_events.table import Measured
from stickslip.fitted.identify import identify
from stickslip.measured.case import Case


def phases(one: Weighed, runs: Sequence[Measured]) -> dict[str, float]:
    """Phase at the start of each train run, for effects that have one."""
    if not one.candidate.per_run:
        return {}
    pairs = one.theta.reshape(-1, 2)
    numbered = _numbers(one, runs)
    return {
        runs[i].run.name: float(np.arctan2(c, s) % (2 * np.pi))
        for i, (s, c) in zip(numbered, pairs, strict=True)
    }


def _numbers(one: Weighed, runs: Sequence[Measured]) -> list[int]:
    if "level" in one.candidate.columns:
        return [i for i, run in enumerate(runs) if len(run.events)]
    return [i for i, run in enumerate(runs) if np.any(run.sticks.rate > 0.3)]


def models(
    case: Case, choice: Choice, runs: Sequence[Measured]
) -> tuple[tuple[Model, Law], tuple[Model, Law]]:
    """The declared model with the law of the mean event, and the same with what was found; each law's intervals."""
    own = case.model()
    rig = choice.declared.rig
    before: FrictionLaw
    after: FrictionLaw
    if isinstance(case.declared_law, CoulombFriction | None):
        before, law_before = law_beside((), choice, runs)
        after, law = law_beside(choice.chosen, choice, runs)
    else:
        before, law_before = after, law = _fitted_law(case)

    def whole(friction: FrictionLaw, effects: Sequence[Effect]) -> Model:
        return Model(rig, friction=friction, effects=tuple(effects), channels=own.channels, noise=own.noise)

    return (whole(before, ()), law_before), (whole(after, terms(choice.chosen, choice)), law)


def _fitted_law(case: Case) -> tuple[FrictionLaw, Law]:
    """A declared law that is no Coulomb law, by simulation: the closed form of the events knows constant levels only.

    Raises
    ------
    InputError
        The slips cannot tell the law, or a run is of another rig, which the fit does not know.
    """
    other = next((run for run in case.train if run.rig != case.rig), None)
    if other is not None:
        words = f"run '{other.name}' is on a rig of its own, which only a Coulomb law is identified with"
        raise InputError(words, key="friction")
    found = identify(case)
    law = {
        name: Interval(one.value, one.low, one.high)
        for name, one in found.estimates.items()
        if one.low is not None
    }
    return found.law, law


def block_of(choice: Choice, name: str) -> Block:
    """A block by its name."""
    return next(one for one in choice.blocks if one.name == name)
