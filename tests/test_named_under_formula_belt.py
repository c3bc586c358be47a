"""Every effect of the catalogue on a named rig under a belt whose speed is a formula: it acts, or says why not."""

from __future__ import annotations

import numpy as np
import pytest

import stickslip as ss
from stickslip.declared.catalogue import KINDS
from stickslip.errors import InputError

TWO = ss.Model(ss.Rig(alpha1=16, alpha2=8, beta3=4, eta1=0.1, eta12=0.2), friction=ss.PaperFriction())
BLOCK = ss.Model(ss.BlockOnBelt(damping=0.1), friction=ss.HyperbolicFriction(scale=1, decay=3))
STILL = ("friction_memory", "belt_load_droop", "sensor_delay")  # a number as the belt's speed is needed
T = np.linspace(0, 8, 81)
ON_BELT = [name for name, kind in KINDS.items() if kind.on_belt is not None or kind.corrects]


def with_effect(model: ss.Model, *names: str) -> ss.Model:
    return model.with_effects([ss.effect(name, **KINDS[name].drawn) for name in names])


def both(model: ss.Model) -> list[ss.Trajectory]:
    """The run at a number, and at a formula that is the same number."""
    return [ss.simulate(model, belt_speed=v, t_end=8, t_eval=T) for v in (0.1, "0.1 + 0*t")]  # type: ignore[arg-type]


@pytest.mark.parametrize("name", ON_BELT)
@pytest.mark.parametrize("plain", [TWO, BLOCK], ids=["two_degree", "block"])
def test_an_effect_acts_under_a_formula_as_under_a_number(plain: ss.Model, name: str) -> None:
    try:
        model = with_effect(plain, name)
    except InputError:
        pytest.skip("not for this rig")
    if name in STILL:
        with pytest.raises(InputError, match=f"'{name}' acts at a constant belt speed only"):
            both(model)
        return
    number, formula = both(model)
    seen = len(model.rig.state_names)
    np.testing.assert_allclose(formula.state[:, :seen], number.state[:, :seen], atol=1e-9)
    assert {*formula.readings} == {*number.readings}
    for channel, read in number.readings.items():
        np.testing.assert_allclose(formula.readings[channel], read, atol=1e-9)


@pytest.mark.parametrize("names", [("sensor_lag", "sensor_crosstalk"), ("sensor_drift", "sensor_crosstalk")])
def test_crosstalk_comes_first_wherever_it_stands(names: tuple[str, ...]) -> None:
    number, formula = both(with_effect(TWO, *names))
    np.testing.assert_allclose(formula.readings["x1"], number.readings["x1"], atol=1e-9)


def test_a_spring_between_both_bodies_is_in_the_reference_and_in_sweeps_too() -> None:
    model = with_effect(TWO, "spring_cubic_k2")
    belt = "0.1 + 0.02*sin(t)"
    run = ss.simulate(model, belt_speed=belt, initial=(0.1, 0.1, 0, 0), t_end=8)
    told = ss.sweep(model, {"initial.x1": [0.1]}, belt_speed=belt, initial=(0.1, 0.1, 0, 0), t_end=8)
    np.testing.assert_allclose(np.ravel(told.final_state)[:4], run.state[-1, :4], atol=1e-7)
    other = ss.simulate(TWO, belt_speed=belt, initial=(0.1, 0.1, 0, 0), t_end=8)
    assert np.abs(run.state[-1] - other.state[-1]).max() > 1e-3


def test_what_needs_a_number_beside_a_law_by_a_formula_names_the_law() -> None:
    model = ss.Model(BLOCK.rig, friction=ss.StribeckFriction(F_s=1, F_c=0.5, v_s=0.1))
    with pytest.raises(InputError, match=r"belt_load_droop.*(stribeck|no formula)"):
        ss.simulate(with_effect(model, "belt_load_droop"), belt_speed=0.1, t_end=1)
