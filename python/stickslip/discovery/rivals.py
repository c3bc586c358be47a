"""The catalogue as rivals: which numbers each effect adds, how they are scaled, and the shapes to start from."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from stickslip.declared.effect import CATALOGUE, AnyEffect, Effect, effect
from stickslip.declared.model import Model
from stickslip.fitted.data import Data
from stickslip.fitted.unknowns import Hypothesis, Unknown, law_unknowns

SPREADS = {  # widths of the weak Gaussians on linear parameters, far beyond what a rig shows
    "block_viscous_damping.c": 5.0,
    "block_quadratic_damping.c": 50.0,
    "spring_cubic_k1.k": 200.0,
    "spring_cubic_k2.k": 200.0,
    "spring_cubic_k3.k": 400.0,
    "constant_load.f": 3.0,
    "harmonic_forcing.a": 3.0,
    "normal_force_feedback.beta2": 20.0,
    "normal_force_feedback.eta2": 20.0,
    "stribeck_peak.dT": 5.0,
    "static_aging.dT": 5.0,
    "friction_drift.r": 0.05,
    "belt_seam.a": 1.0,
    "belt_speed_ripple.a": 1.0,
    "sensor_delay.delay": 1.0,
    "sensor_crosstalk.c": 1.0,
    "sensor_nonlinearity.q": 3.0,
    "sensor_drift.r": 0.05,
}
LOGARITHMIC = 1.5  # width on positive ones, in the logarithm
BOUNDS = {  # of positive numbers: beyond, an effect is another one (or none) and its motion stiff
    "spring_gap_k3.k": (1e-2, 500.0),
    "spring_gap_k3.d": (1e-3, 2.0),
    "pivot_dry_friction.f": (1e-4, 5.0),
    "pivot_dry_friction.v_c": (2e-5, 0.05),
    "stribeck_peak.v_s": (3e-3, 0.5),
    "static_aging.tau": (0.05, 50.0),
    "friction_memory.tau": (4e-3, 2.0),
    "contact_compliance.k": (20.0, 4000.0),
    "contact_compliance.c": (1e-3, 20.0),
    "belt_load_droop.k": (1e-5, 0.2),
    "belt_load_droop.tau": (0.03, 20.0),
    "sensor_lag.tau": (4e-3, 3.0),
    "harmonic_forcing.w": (0.05, 60.0),
    "belt_speed_ripple.w": (0.05, 60.0),
    "belt_seam.L": (0.1, 60.0),
}
PERIODIC = ("harmonic_forcing", "belt_speed_ripple", "belt_seam")


@dataclass(frozen=True)
class Start:
    """An effect with starting values, and starting phases by run."""

    term: Effect
    phases: tuple[float, ...] = ()


def unknowns_of(term: Effect) -> tuple[Unknown, ...]:
    """The numbers that an effect adds."""
    out = []
    for info in term.kind.parameters:
        name, value = f"{term.name}.{info.name}", term.parameters[info.name]
        if info.optional and value == 0:
            continue
        if info.per_run:
            out.append(Unknown(name, value, False, value, 30.0, per_run=True))
        elif name in SPREADS:
            out.append(Unknown(name, value, False, 0.0, SPREADS[name], bounds=info.bounds))
        else:
            low, high = BOUNDS[name]
            positive = min(max(value, low), high)
            out.append(Unknown(name, positive, True, math.log(positive), LOGARITHMIC, bounds=(low, high)))
    return tuple(out)


def hypothesis(model: Model, starts: Sequence[Start], declared: Model | None = None) -> Hypothesis:
    """Law and effects together; the model's own effects are replaced.

    The law starts at the model's numbers and is held about those of `declared`, so that no wrong rival carries it off.
    """
    terms: list[AnyEffect] = [one.term for one in starts]
    unknowns = list(law_unknowns(model, declared or model))
    phases = {}
    for one in starts:
        unknowns += unknowns_of(one.term)
        if one.phases:
            phases[f"{one.term.name}.phi"] = one.phases
    return Hypothesis(model.with_effects(terms), tuple(unknowns), phases)


def shapes(name: str, data: Sequence[Data]) -> list[Start]:
    """Starts of an effect that is not periodic: a grid over the parameters that no linear score reaches."""
    grids = {
        "spring_gap_k3": _gap_starts(data),
        "pivot_dry_friction": [{"f": 0.08}, {"f": 0.08, "v_c": 2e-3}],
        "stribeck_peak": [{"dT": 0.3, "v_s": v} for v in (0.02, 0.07)],
        "static_aging": [{"dT": 0.3, "tau": tau} for tau in (0.5, 2.0)],
        "friction_memory": [{"tau": tau} for tau in (0.03, 0.2)],
        "contact_compliance": [{"k": k, "c": c} for k, c in ((350.0, 0.5), (1500.0, 1.0))],
        "belt_load_droop": [{"k": 0.002, "tau": tau} for tau in (0.3, 2.0)],
        "sensor_lag": [{"tau": 0.05}],
    }
    if name in grids:
        return [Start(effect(name, **one)) for one in grids[name]]
    zero = {info.name: 0.0 for info in CATALOGUE[name].parameters}
    return [Start(effect(name, **zero))]


def _gap_starts(data: Sequence[Data]) -> list[dict[str, float]]:
    size = float(np.quantile(np.abs(np.concatenate([run.readings[:, 1] for run in data])), 0.99))
    return [{"k": 3.0, "d": share * size} for share in (0.3, 0.6)]
