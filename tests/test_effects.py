"""The catalogue, effects with their numbers, and the tabulated term."""

import pickle

import numpy as np
import pytest

from stickslip import _core
from stickslip.declared.catalogue import CATALOGUE, CONSTANTS
from stickslip.declared.check_model import MOST_CURVES
from stickslip.declared.effect import Effect, effect, tabulated
from stickslip.declared.friction.coulomb import CoulombFriction
from stickslip.declared.friction.paper import PaperFriction
from stickslip.declared.model import Model
from stickslip.declared.rig import BlockOnBelt, Rig
from stickslip.errors import InputError
from stickslip.simulated.lowering import TABLES
from stickslip.simulated.simulate import simulate

NAMES = [
    "block_viscous_damping",
    "block_quadratic_damping",
    "spring_cubic_k1",
    "spring_cubic_k2",
    "spring_cubic_k3",
    "spring_gap_k3",
    "constant_load",
    "harmonic_forcing",
    "pivot_dry_friction",
    "normal_force_feedback",
    "stribeck_peak",
    "static_aging",
    "friction_memory",
    "friction_drift",
    "belt_seam",
    "contact_compliance",
    "belt_speed_ripple",
    "belt_load_droop",
    "sensor_lag",
    "sensor_delay",
    "sensor_crosstalk",
    "sensor_nonlinearity",
    "sensor_drift",
]


def test_names_that_files_use_stay_and_in_their_order() -> None:
    assert [name for name in CATALOGUE if name in NAMES] == NAMES
    assert all(kind.name == name for name, kind in CATALOGUE.items())


def test_phases_are_per_run_and_zero_unless_given() -> None:
    with_phase = [name for name, kind in CATALOGUE.items() if "phi" in kind.parameter_names]
    assert with_phase == [name for name, kind in CATALOGUE.items() if kind.wave]
    assert len(with_phase) >= 3
    assert all(CATALOGUE[name].parameter("phi").per_run for name in with_phase)
    assert effect("belt_seam", a=0.1, L=2).parameters == {"a": 0.1, "L": 2.0, "phi": 0.0}


def test_readings_and_motion_are_told_apart() -> None:
    sensors = {name for name, kind in CATALOGUE.items() if kind.physics == "reading"}
    assert sensors == {name for name in CATALOGUE if name.startswith("sensor_")}


@pytest.mark.parametrize("name", CATALOGUE)
def test_every_effect_can_be_declared_changed_and_pickled(name: str) -> None:
    kind = CATALOGUE[name]
    one = effect(name, **{info.name: 0.5 for info in kind.parameters})
    assert isinstance(one, Effect)
    assert one.where == kind.where
    assert tuple(one.parameters) == kind.parameter_names
    first = kind.parameter_names[0]
    changed = one.replace(**{first: 0.25})
    assert changed.parameters[first] == 0.25
    assert changed != one
    assert pickle.loads(pickle.dumps(one)) == one
    assert hash(one) == hash(effect(name, **one.parameters))


@pytest.mark.parametrize("name", CONSTANTS)
def test_wrong_constants_are_for_a_block_on_a_belt(name: str) -> None:
    one = effect(name, e=0.25)
    rig = BlockOnBelt(mass=2.0, stiffness=3.0)
    model = Model(rig, friction=CoulombFriction(), effects=[one])
    wrong = CONSTANTS[name].corrects
    expected = {
        key: (1.25 if key == wrong else 1) * size for key, size in (("mass", 2.0), ("stiffness", 3.0))
    }
    true = Model(BlockOnBelt(**expected), friction=CoulombFriction())
    start = {"belt_speed": 0.2, "initial": (0.0, 0.2), "t_end": 20.0}
    np.testing.assert_allclose(
        simulate(model, **start).state[-1], simulate(true, **start).state[-1], rtol=1e-9
    )
    if name != "rig_stiffness":  # which on (2.1) says that the unit of time is another
        with pytest.raises(InputError, match=f"'{name}' is for a BlockOnBelt"):
            Model(
                Rig(alpha1=16, alpha2=8, beta3=4, eta1=0.1, eta12=0.2),
                friction=CoulombFriction(),
                effects=[one],
            )
    with pytest.raises(InputError, match="above -1"):
        effect(name, e=-1.0)


def test_tabulated_curve_is_smooth_and_held_outside() -> None:
    knots, values = [-1.0, 0.0, 0.5, 2.0], [0.0, 1.0, -1.0, 3.0]
    term = tabulated("block", "x1", knots, values)
    np.testing.assert_allclose(term.curve(knots), values, atol=1e-14)
    np.testing.assert_allclose(term.curve([-5.0, 7.0]), [0.0, 3.0])
    h = 1e-4
    bend = (term.curve(0.0 - 2 * h) - 2 * term.curve(0.0 - h) + term.curve(0.0)) / h**2
    bend_after = (term.curve(0.0) - 2 * term.curve(h) + term.curve(2 * h)) / h**2
    assert bend == pytest.approx(bend_after, rel=1e-2)
    line = tabulated("contact", "v_w", [0.0, 1.0, 3.0], [1.0, 2.0, 4.0])
    np.testing.assert_allclose(line.curve([0.25, 2.0]), [1.25, 3.0])
    assert line.name == "tabulated_contact_v_w"
    assert line.replace(value_1=5.0).values == (1.0, 5.0, 4.0)


def test_tabulated_curve_repeats_in_time() -> None:
    t = np.linspace(0, 2.0, 9)
    wave = np.sin(np.pi * t)
    wave[-1] = wave[0]
    term = tabulated("block", "t", t, wave, period=2.0)
    at = np.linspace(-3, 9, 50)
    np.testing.assert_allclose(term.curve(at), np.sin(np.pi * at), atol=5e-3)
    np.testing.assert_allclose(term.curve(at), term.curve(at + 4.0), atol=1e-12)
    late = term.replace(phi=0.5)
    np.testing.assert_allclose(late.curve(at), term.curve(at + 0.5 / np.pi), atol=1e-12)
    slow = late.replace(w=0.5 * np.pi)
    assert slow.period == pytest.approx(4.0)
    np.testing.assert_allclose(slow.curve(2 * at), late.curve(at), atol=1e-12)
    with pytest.raises(InputError, match="only a curve that repeats has a phase"):
        tabulated("block", "t", t, wave, phi=0.5)
    with pytest.raises(InputError, match="only a curve in t repeats"):
        tabulated("block", "x1", t, wave, period=2.0)
    with pytest.raises(InputError, match="equal first and last"):
        tabulated("block", "t", t, wave + t, period=2.0)


def test_a_motion_has_two_tabulated_terms_at_most() -> None:
    assert len(TABLES) == _core.TABLES == MOST_CURVES
    places = ("contact", "block", "angle_body")
    curves = [tabulated(where, "x1", [0.0, 1.0, 2.0], [0.0, 0.1, 0.3]) for where in places]
    rig = Rig(alpha1=16, alpha2=8, beta3=4, eta1=0.1, eta12=0.2)
    with pytest.raises(InputError, match="two tabulated terms"):
        Model(rig, friction=PaperFriction(), effects=curves)
    Model(rig, friction=PaperFriction(), effects=curves[1:])


@pytest.mark.parametrize("belt_speed", [0.1, -0.1])
def test_a_constant_load_is_a_shift_of_the_law(belt_speed: float) -> None:
    """Up in one direction and down in the other: no run of the rig tells the two apart."""
    rig, law, f = Rig(alpha1=16, alpha2=8, beta3=4, eta1=0.1, eta12=0.2), PaperFriction(), 0.3
    shifted = PaperFriction(
        T_s_minus=law.T_s_minus + f,
        T_min_minus=law.T_min_minus + f,
        T_s_plus=law.T_s_plus - f,
        T_min_plus=law.T_min_plus - f,
    )
    loaded = Model(rig, friction=law, effects=[effect("constant_load", f=f)])
    t = np.linspace(0, 60, 500)
    start = (0.1 * np.sign(belt_speed), belt_speed, 0.0, 0.0)
    one, other = (
        simulate(model, belt_speed=belt_speed, initial=start, t_end=60, t_eval=t)
        for model in (loaded, Model(rig, friction=shifted))
    )
    assert len(one.transitions.t) > 10
    np.testing.assert_allclose(one.state, other.state, atol=1e-9)
