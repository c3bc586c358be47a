"""What a run has of its own that no model was fitted to: its phases, and the speeds of its belt and drive."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from stickslip.declared.effect import Effect
from stickslip.declared.model import Model
from stickslip.declared.speeds import Speed
from stickslip.fitted.bodies_data import BodiesData
from stickslip.likelihoods.bodies_bench import of_run
from stickslip.likelihoods.bodies_cuts import Cut
from stickslip.likelihoods.bodies_windows import BELT_OFF, BodiesWindows
from stickslip.likelihoods.fit import fitted
from stickslip.likelihoods.fit_state import begin
from stickslip.likelihoods.policy import POLICY
from stickslip.likelihoods.shared import Declared, SharedNumber
from stickslip.likelihoods.single_windows import settled

TRIED = 8  # phases of a turn
TURNS = 4  # of every window alone at each
STRIDE = 0.6


def as_it_ran(model: Model, run: BodiesData, windows: Sequence[Cut]) -> tuple[Model, BodiesData]:
    """
    Return a model with the phases that a run has, and the run with the speeds that its belt and drive had.

    Parameters
    ----------
    model : of a rig of bodies or matrices
    run, windows : the run, and where it is cut
    """
    own = with_own_phases(model, run, windows)
    return own, with_own_speeds(own, run, windows)


def with_own_phases(model: Model, run: BodiesData, windows: Sequence[Cut]) -> Model:
    """
    Return a model with the phases that a run has; the model itself where nothing has any.

    Parameters
    ----------
    model : of a rig of bodies or matrices
    run, windows : the run, and where it is cut
    """
    waves = [one for one in model.effects if isinstance(one, Effect) and one.kind.wave is not None]
    for one in waves:
        name = f"{one.label}.phi"
        tried = [model.replace({name: phi}) for phi in np.arange(TRIED) * 2 * math.pi / TRIED]
        model = min(tried, key=lambda own: _cost(own, run, windows))
    if not waves:
        return model
    numbers = []
    for one in waves:
        at = model.parameters[f"{one.label}.phi"]
        numbers.append(SharedNumber(f"{one.label}.phi", at, at, math.inf, run=0, stride=STRIDE))
    fit = begin(BodiesWindows(model, [run], windows, numbers, Declared()))
    fit = fitted(replace(fit, own=settled(fit, TURNS)[0]), POLICY)
    found = fit.values()
    return model.replace({one.name: float(np.mod(found[one.name], 2 * math.pi)) for one in numbers})


def with_own_speeds(model: Model, run: BodiesData, windows: Sequence[Cut]) -> BodiesData:
    """
    Return a run with the speeds that its belt and drive had, by its readings.

    Parameters
    ----------
    model : of a rig of bodies or matrices
    run, windows : the run, and where it is cut
    """
    numbers = of_run(model, run, 0, POLICY)
    if not numbers:
        return run
    fit = begin(BodiesWindows(model, [run], windows, numbers, Declared()))
    fit = fitted(replace(fit, own=settled(fit, TURNS)[0]), POLICY)
    found, belt = fit.values(), run.belt
    if BELT_OFF in found:
        belt = run.belt.scaled(1.0, 1 + found[BELT_OFF])
    return replace(
        run, belt=belt, drive=Speed.of(found["drive_speed"]) if "drive_speed" in found else run.drive
    )


def _cost(model: Model, run: BodiesData, windows: Sequence[Cut]) -> float:
    fit = begin(BodiesWindows(model, [run], windows, [], Declared()))
    return float(settled(fit, TURNS)[2].sum())
