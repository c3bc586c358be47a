"""What a call says of arguments that it cannot take, and of a model that can hardly be meant."""

import dataclasses
import pickle
import warnings

import numpy as np
import pytest

import stickslip as ss
from stickslip.arguments import explained
from stickslip.errors import CallError

RIG = ss.Rig(alpha1=16, alpha2=8, beta3=4, eta1=0.1, eta12=0.2)
MODEL = ss.Model(RIG, friction=ss.PaperFriction())


def test_a_wrong_call_is_pythons_own_kind_of_error_and_ours():
    with pytest.raises(TypeError) as caught:
        ss.Rig(alfa1=16)
    assert isinstance(caught.value, ss.InputError)
    assert isinstance(pickle.loads(pickle.dumps(caught.value)), CallError)


def test_a_type_error_within_is_not_taken_for_a_wrong_call():
    @explained
    def broken(x: int) -> int:
        return x + "1"  # type: ignore[operator]

    with pytest.raises(TypeError, match="unsupported operand") as caught:
        broken(1)
    assert not isinstance(caught.value, ss.InputError)


def test_an_explained_class_is_still_itself():
    assert dataclasses.replace(RIG, alpha1=3.0).alpha1 == 3.0
    assert pickle.loads(pickle.dumps(RIG)) == RIG
    assert ss.simulate.__name__ == "simulate"
    assert "belt_speed" in ss.simulate.__doc__


def run(*effects, t_end=40.0, **changed):
    model = MODEL.with_effects(effects)
    return ss.simulate(model, belt_speed=0.1, initial=(0.1, 0.1, 0, 0), t_end=t_end, **changed)


def test_friction_that_a_drift_turns_negative_is_said_and_is_so():
    drift = ss.effect("friction_drift", r=-0.05)
    with pytest.warns(ss.ModelWarning, match=r"1 \+ r t is below 0 from t = 20"):
        assert run(drift).status.ok
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        run(drift, t_end=19.0)


@pytest.mark.parametrize(
    ("effect", "said"),
    [
        (ss.tabulated("contact", "x1", [-1, 0, 1], [0, -1.5, 0]), "g = -1.5 at x1 = 0"),
        (ss.tabulated("contact", "t", [0, 10, 20], [0, -2, 0], period=20.0), "g = -2 at t = 10"),
        (ss.effect("stribeck_peak", dT=-6.0, v_s=0.1), "stribeck_peak.dT = -6"),
        (ss.effect("static_aging", dT=-6.0, tau=1.0), "static_aging.dT = -6"),
    ],
)
def test_friction_that_turns_negative_is_said(effect, said):
    with pytest.warns(ss.ModelWarning, match=said):
        run(effect, t_end=12.0)


@pytest.mark.parametrize(
    "effect",
    [
        ss.tabulated("contact", "x1", [-1, 0, 1], [0, -0.5, 0]),
        ss.tabulated("block", "x1", [-1, 0, 1], [0, -5.0, 0]),
        ss.tabulated("contact", "t", [0, 10, 20], [0, 0, -2]),
        ss.effect("stribeck_peak", dT=-0.5, v_s=0.1),
        ss.effect("friction_drift", r=0.05),
        ss.effect("belt_seam", a=0.9, L=2.0),
    ],
)
def test_friction_that_stays_positive_is_not_doubted(effect):
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert np.isfinite(run(effect, t_end=8.0).state).all()


@pytest.mark.parametrize(
    ("numbers", "where"),
    [
        ({"scale": 1, "decay": 3, "constant": -0.5}, 1 / 3),
        ({"scale": 1, "decay": 0, "constant": 0, "quadratic": -0.25}, 2.0),
        ({"scale": 2, "decay": 1, "constant": -1, "quadratic": 0}, 1.0),
    ],
)
def test_the_speed_from_which_a_law_is_negative_is_the_zero_of_r(numbers, where):
    with pytest.raises(ss.InputError, match=f"from u = {where:.3g} on"):
        ss.HyperbolicFriction(**numbers)


def test_a_law_that_touches_zero_is_allowed():
    # 1/(1+u) - 0.75 + q u^2 has its least value 0 where both it and its slope vanish
    u = 1.0
    q = 1 / (2 * u * (1 + u) ** 2)
    law = ss.HyperbolicFriction(scale=1, decay=1, constant=-(1 / (1 + u) + q * u * u), quadratic=q)
    assert abs(float(law.magnitude(1.0))) < 1e-15
