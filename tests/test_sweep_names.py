"""Names and values of what a sweep varies: a short name is its full name, and what is no number is refused."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import stickslip as ss

RIG = ss.Rig(alpha1=16, alpha2=8, beta3=4, eta1=0.1, eta12=0.2)
MODEL = ss.Model(RIG, friction=ss.PaperFriction())
HEAVIER = ss.Model(
    ss.BlockOnBelt(mass=2.0, damping=0.1),
    friction=ss.HyperbolicFriction(scale=1, decay=3),
    effects=[ss.effect("rig_mass", e=0.5)],
)


def refused(model: ss.Model, over: dict[str, Any]) -> str:
    with pytest.raises(ss.InputError) as told:
        ss.sweep(model, over, belt_speed=0.1, t_end=1)
    return str(told.value)


def test_a_short_name_of_a_correction_is_its_full_name() -> None:
    """`effect.e` lacked the mass in derivatives, and a sweep put it in the mass's place."""
    given: dict[str, Any] = {"belt_speed": 0.5, "initial": (0, 0.3), "t_end": 5, "t_eval": [5.0]}
    short, full = (
        ss.simulate(HEAVIER, **given, sensitivity=(f"{effect}.e",)) for effect in ("effect", "rig_mass")
    )
    np.testing.assert_array_equal(short.sensitivity, full.sensitivity)
    assert short.sensitivity_names == ("effect.e",)
    near = [ss.simulate(HEAVIER.replace({"effect.e": 0.5 + h}), **given).state for h in (1e-5, -1e-5)]
    np.testing.assert_allclose(short.sensitivity[..., 0], (near[0] - near[1]) / 2e-5, atol=1e-6)
    assert (
        refused(HEAVIER, {"effect.e": [0.1]})
        == "effect.e: corrects a number of the rig; vary that number itself"
    )


def test_a_short_name_is_swept_as_its_full_name() -> None:
    drift = MODEL.with_effects([ss.effect("friction_drift", r=0.001)])
    with pytest.warns(ss.ModelWarning, match=r"friction_drift\.r = -0\.1: .*in some members"):
        ds = ss.sweep(drift, {"effect.r": [-0.1, 0.0]}, belt_speed=0.1, t_end=50)
    assert set(ds.final_state.dims) == {"effect.r", "state"}
    assert "is the same number as" in refused(drift, {"effect.r": [0.0], "friction_drift.r": [0.0]})
    damped = MODEL.with_effects([ss.effect("friction_memory", tau=0.1)])
    assert "over['effect.tau']: entry 1 is -1: must be above 0" in refused(
        damped, {"effect.tau": [0.1, -1.0]}
    )


@pytest.mark.parametrize(
    ("effect", "number"),
    [
        ("sensor_delay", "delay"),
        ("sensor_drift", "r"),
        ("sensor_crosstalk", "c"),
        ("sensor_nonlinearity", "q"),
    ],
)
def test_what_acts_on_the_reading_is_refused_by_either_name(effect: str, number: str) -> None:
    read = MODEL.with_effects([ss.effect(effect, **{number: 0.1})])
    for name in (f"{effect}.{number}", f"effect.{number}"):
        assert refused(read, {name: [0.1, 0.2]}).startswith(f"{name}: acts on the reading, not on the motion")


def test_so_is_what_only_a_lag_behind_it_feels() -> None:
    chain = MODEL.with_effects([ss.effect("sensor_crosstalk", c=0.1), ss.effect("sensor_lag", tau=0.1)])
    for name in ("effect.c", "sensor_crosstalk.c", "sensor_lag.tau", "initial.m"):
        assert "acts on the reading, not on the motion" in refused(chain, {name: [0.1, 0.2]})


@pytest.mark.parametrize(
    ("values", "said"),
    [
        ([True, 8.0], "entry 0 is True, not a number"),
        (np.array([8.0, "9"], dtype=object), "entry 1 is '9', not a number"),
        ([8.0, None], "entry 1 is None, not a number"),
        (np.ma.array([8.0, 9.0], mask=[False, True]), "has masked entries, which are missing"),
        (("i", np.ma.array([8.0, 9.0], mask=[False, True])), "has masked entries, which are missing"),
    ],
)
def test_what_is_no_number_is_refused(values: object, said: str) -> None:
    assert refused(MODEL, {"alpha1": values}).startswith(f"over['alpha1']: {said}")


def test_whole_starts_and_bare_states_are_told_their_names() -> None:
    for starts in ([0, 1], [(0, 0, 0, 0), (1, 0, 0, 0)]):
        said = refused(MODEL, {"initial": starts})
        assert said.startswith("over: 'initial' is not one number; vary its states: 'initial.x1', ...")
        assert said.endswith("{'initial.x1': ('start', x1), ...}")
    assert refused(MODEL, {"x1": [0, 1]}) == "unknown parameter 'x1'; did you mean 'initial.x1'?"


def test_a_short_start_names_hidden_states_only_where_there_are_some() -> None:
    aging = MODEL.with_effects([ss.effect("friction_memory", tau=0.1)])
    for model, more in ((MODEL, ""), (aging, ", or up to 5 with the hidden state w")):
        with pytest.raises(ss.InputError) as told:
            ss.sweep(model, {"alpha1": [16.0]}, belt_speed=0.1, initial=[1], t_end=1)
        assert str(told.value) == f"initial: has 1 number; give 4 (x1, x2, y1, y2){more}"


def test_an_empty_path_is_refused() -> None:
    with pytest.raises(ss.InputError, match=r"^out: is empty; give a path$"):
        ss.sweep(MODEL, {"alpha1": [16.0]}, belt_speed=0.1, t_end=1, out="")
