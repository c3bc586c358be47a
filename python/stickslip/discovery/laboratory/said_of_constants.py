"""What the runs say of declared constants and gains, by a fit that has them beside everything else."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np

from stickslip.declared.uncertainty import SIGMAS_95
from stickslip.discovery.laboratory.hypothesis import Bench
from stickslip.discovery.laboratory.outcome import intervals
from stickslip.likelihoods.declared_numbers import BESIDE
from stickslip.likelihoods.fit_state import Fit
from stickslip.likelihoods.interval import Interval


def said_of_constants(bench: Bench, fit: Fit) -> Mapping[str, Interval]:
    """
    Return what the runs say of every declared constant and gain; a gain as 1 + e.

    Of (2.1) in SI alpha1 is "inertia" and "stiffness", which are one number in its own unit of time alone; "eta2" is
    eta12 less eta1.
    """
    found = intervals(fit)
    springs = _springs(bench, fit, found)
    out = dict(springs)
    for name in bench.declared.names:
        one = found.get(name)
        if one is None or (springs and name in ("alpha1", BESIDE)):
            continue
        if name in bench.declared.gains:
            low, high = (None if x is None else 1 + x for x in (one.low, one.high))
            one = Interval(1 + one.value, low, high)
        out[bench.declared.gains.get(name, name)] = one
    if (apart := _less(fit, "eta12", "eta1")) is not None:
        out["eta2"] = apart
    return out


def _less(fit: Fit, first: str, second: str) -> Interval | None:
    """One fitted number less another, whose errors go together; None where not both are fitted."""
    numbers = fit.windows.numbers
    places = {n.name: i for i, n in enumerate(numbers)}
    if fit.solution is None or not {first, second} <= places.keys():
        return None
    along = np.zeros(len(fit.at))
    for name, sign in ((first, 1.0), (second, -1.0)):
        along[places[name]] = sign * numbers[places[name]].slope(float(fit.at[places[name]]))
    value = fit.values()[first] - fit.values()[second]
    half = SIGMAS_95 * math.sqrt(float(along @ fit.solution.covariance @ along))
    return Interval(value, value - half, value + half)


def _springs(bench: Bench, fit: Fit, found: Mapping[str, Interval]) -> dict[str, Interval]:
    """What the block of (2.1) has of mass and of stiffness, where these are apart."""
    if BESIDE not in found or BESIDE in bench.model.parameters:
        return {}
    assert fit.solution is not None
    places = {n.name: i for i, n in enumerate(fit.windows.numbers)}
    mass = fit.values().get("alpha1", bench.model.parameters["alpha1"])
    along = np.zeros(len(fit.at))
    along[places[BESIDE]] = 1.0
    if "alpha1" in places:  # in its logarithm
        along[places["alpha1"]] = mass
    stiff, half = (
        mass + found[BESIDE].value,
        SIGMAS_95 * math.sqrt(float(along @ fit.solution.covariance @ along)),
    )
    return {
        "inertia": found.get("alpha1", Interval(mass, mass, mass)),
        "stiffness": Interval(stiff, stiff - half, stiff + half),
    }
