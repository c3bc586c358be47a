"""Every effect of the catalogue is used by a forecast and a comparison: with it they meet the readings, without not."""

from __future__ import annotations

import warnings
from functools import cache

import numpy as np
import pandas as pd
import pytest

import stickslip as ss
from every_effect import made
from stickslip.declared.catalogue import CATALOGUE, CONSTANTS
from stickslip.simulated.reference import integrate as reference

NOISE, SPAN, DT, SEEN = 1e-3, 45.0, 0.04, 875
RIGS = {
    "two_degree": (
        ss.Rig(alpha1=16, alpha2=8, beta3=4, eta1=0.1, eta12=0.2),
        ss.PaperFriction(),
        0.1,
        (0.1, 0.1, 0.0, 0.0),
    ),
    "block_on_belt": (
        ss.BlockOnBelt(damping=0.02),
        ss.HyperbolicFriction(scale=0.6, decay=5.0, constant=0.4),
        0.2,
        (0.1, 0.1),
    ),
}
SIZES = {
    "friction_drift": {"r": 0.003},
    "sensor_drift": {"r": 0.003},
    "contact_compliance": {"k": 100.0, "c": 0.5},
    "belt_load_droop": {"k": 0.01, "tau": 2.0},
}


def accepted(rig: str) -> list[str]:
    if rig == "two_degree":
        return list(CATALOGUE)
    return [name for name, kind in {**CATALOGUE, **CONSTANTS}.items() if not kind.two_degree]


CASES = [(rig, name) for rig in RIGS for name in accepted(rig)]


@cache
def record(rig: str, name: str) -> tuple[ss.Model, ss.Model, ss.Recording, np.ndarray]:
    """The model with the effect and without, what it recorded, and its readings without noise, by the reference."""
    declared, law, v_b, start = RIGS[rig]
    effect = ss.effect(name, **SIZES[name]) if name in SIZES else made(name)
    right = ss.Model(declared, friction=law, effects=[effect])
    t = np.arange(0, SPAN, DT)
    run = reference.simulate(right, belt_speed=v_b, initial=start, t_end=SPAN, tol=1e-10)
    shown = reference.readings(right, run, t, interpolated=True)
    noisy = shown + NOISE * np.random.default_rng(0).standard_normal(shown.shape)
    columns = {"t": t} | dict(zip(("x1", "y1"), noisy.T, strict=False))
    seen = ss.load_recording(pd.DataFrame(columns), declared, belt_speed=v_b, name="record")
    return right, right.with_effects([]), seen, shown


@pytest.mark.sampled(8)
@pytest.mark.parametrize(("rig", "name"), CASES)
def test_a_forecast_uses_it(rig: str, name: str) -> None:
    right, wrong, seen, shown = record(rig, name)
    past = seen.window(0.0, (SEEN - 0.5) * DT)

    def off(model: ss.Model) -> float:
        with warnings.catch_warnings():
            warnings.simplefilter(
                "ignore", ss.ModelWarning
            )  # the wrong one starts far off, as it is told to say
            ahead = ss.forecast(model, past, belt_speed=RIGS[rig][2], horizon=9.9)
        truth = shown[SEEN : SEEN + len(ahead)]
        return float(np.sqrt(np.mean((ahead.to_numpy()[:, 1 : 1 + truth.shape[1]] - truth) ** 2))) / NOISE

    assert off(right) < 2
    assert off(wrong) > 2 * off(right)


@pytest.mark.sampled(8)
@pytest.mark.parametrize(("rig", "name"), CASES)
def test_a_comparison_uses_it(rig: str, name: str) -> None:
    right, wrong, seen, _ = record(rig, name)

    def off(model: ss.Model) -> float:
        found = ss.compare(model, seen)
        return float(np.sqrt(np.nanmean((found.simulated_readings - found.readings) ** 2))) / NOISE

    # a free run keeps what its start is off, the unknown deflection of a bristle for one: then it is only far better
    with_it, without = off(right), off(wrong)
    assert without > 1.1 * with_it
    assert with_it < max(2.0, 0.6 * without)
