"""The numbers of a declared model that a fit of windows moves: those of its law, its constants, its sensors' gains."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from stickslip.declared.effect import effect
from stickslip.declared.model import Model
from stickslip.declared.rig import Rig
from stickslip.fitted.unknowns import HELD, SLIPPING
from stickslip.likelihoods.policy import Policy
from stickslip.likelihoods.sensors import Sensors
from stickslip.likelihoods.shared import Declared, SharedNumber
from stickslip.measured.case import Case

STRIDE_LAW, STRIDE_CONSTANT, STRIDE_GAIN = 0.5, 0.3, 0.1
# Bounds of constants, in the logarithm, and of gains about 1: masses, springs and a gain that shrink together leave the
# motion as it is, and what is further off than this is another rig.
FAR, FAR_GAIN = math.log(2.0), 0.5
IN_DOUBT = frozenset({"v_w_max"})  # at which friction is least; v_w_min is told by the law's other numbers
BESIDE = "stiffness"  # of (2.1) what the block's springs have beside alpha1, in numbers of a fit


def of_law(model: Model, policy: Policy) -> list[SharedNumber]:
    """Return the numbers of the law, held loosely about what is declared."""
    law = {name: value for name, value in model.parameters.items() if hasattr(model.friction, name)}
    return held_loosely(law, policy.law_spread)


def held_loosely(law: Mapping[str, float], spread: float) -> list[SharedNumber]:
    """Return numbers of laws under a prior `spread` wide about what is declared; positive ones in the logarithm."""
    out = []
    for name, value in law.items():
        if name.rpartition(".")[2] in HELD:
            continue
        if value > 0:
            at = math.log(value)
            out.append(SharedNumber(name, at, at, spread, True, stride=STRIDE_LAW))
        else:
            out.append(SharedNumber(name, value, value, spread, low=0.0))
    return out


def of_rig(model: Model, declared: Declared, sensors: Sensors) -> list[SharedNumber]:
    """Return the constants and gains that are not exact."""
    out = []
    for name in declared.names:
        if name in sensors.gains:
            out.append(
                SharedNumber(name, 0.0, 0.0, math.inf, low=-FAR_GAIN, high=FAR_GAIN, stride=STRIDE_GAIN)
            )
        elif name not in model.parameters:
            far = FAR_GAIN * model.parameters["alpha1"]
            out.append(SharedNumber(name, 0.0, 0.0, math.inf, low=-far, high=far))
        else:
            at = math.log(model.parameters[name])
            out.append(
                SharedNumber(
                    name, at, at, math.inf, True, low=at - FAR, high=at + FAR, stride=STRIDE_CONSTANT
                )
            )
    return [*out, *_speeds(model, declared)]


def _speeds(model: Model, declared: Declared) -> list[SharedNumber]:
    """Return speeds of the law that a fit holds, where they are counted in a unit of time that is in doubt."""
    if BESIDE in model.parameters or BESIDE not in declared.names:
        return []
    place = declared.names.index(BESIDE)
    doubt = 0.5 * math.sqrt(declared.covariance[place, place]) / model.parameters["alpha1"]
    out = []
    for name in sorted(IN_DOUBT.intersection(model.parameters)):
        at = math.log(model.parameters[name])
        out.append(SharedNumber(name, at, at, doubt, True, stride=STRIDE_CONSTANT))
    return out


def known(case: Case) -> Declared:
    """
    Return what a case says of its constants and gains, less what is exact.

    Of (2.1) in SI the unit of time follows from a mass and springs that are not exact either. Time is counted in the
    declared one: "stiffness" is what the block's springs have beside alpha1, which is its mass then.
    """
    gains = {f"gain.{channel}": channel for channel in case.uncertainty.gains}
    numbers = case.model().parameters
    names = [n for n in numbers if n in case.uncertainty.names and n not in gains.values()]
    beside = [BESIDE] if isinstance(case.rig, Rig) else []
    every = {**{n: n for n in (*names, *beside)}, **gains}
    size = sizes(case.model(), list(every))
    covariance = case.uncertainty.on_time(list(every.values())) * np.outer(size, size)
    kept = [i for i, n in enumerate(every) if covariance[i, i] > 0 and (n not in names or numbers[n] > 0)]
    return Declared(tuple(n for i, n in enumerate(every) if i in kept), covariance[kept][:, kept], gains)


def sizes(model: Model, names: Sequence[str]) -> NDArray[np.float64]:
    """Return what 1 of a relative error is in the coordinates of a fit, (n,): springs beside alpha1 are no share."""
    beside = BESIDE not in model.parameters
    return np.array([model.parameters["alpha1"] if beside and name == BESIDE else 1.0 for name in names])


def inside(numbers: Mapping[str, float]) -> dict[str, float]:
    """Return numbers of a law, those that fitted beyond its limits at them."""
    out = dict(numbers)
    for low, limit in SLIPPING.items():  # a law that does not fall has its floor at its static limit
        if low in out and limit in out:
            out[low] = min(out[low], out[limit])
    return out


def fitted_model(model: Model, values: Mapping[str, float]) -> Model:
    """
    Return the model with the values of a fit, inside the limits that rigs and laws have.

    Springs of (2.1) that belong to another unit of time than the declared one are the effect `rig_stiffness`.
    """
    numbers = inside({k: v for k, v in values.items() if k in model.parameters})
    if "eta12" in numbers:  # two dampings, each known alone: their difference is one, too
        numbers["eta12"] = max(numbers["eta12"], numbers["eta1"])
    made = model.replace(numbers)
    more = values.get(BESIDE, 0.0)
    if not isinstance(model.rig, Rig) or more == 0:
        return made
    off = effect("rig_stiffness", e=more / made.parameters["alpha1"])
    return replace(made, effects=(*made.effects, off))
