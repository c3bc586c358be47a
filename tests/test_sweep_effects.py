"""Models with effects in lanes: every effect of the catalogue against the scalar kernel, whatever the threads."""

from __future__ import annotations

import numpy as np
import pytest
import xarray as xr

import stickslip as ss
from every_effect import EFFECTS, one
from stickslip import _core
from stickslip.simulated.lowering import READING_EFFECTS

RIG = ss.Rig(alpha1=16, alpha2=8, beta3=4, eta1=0.1, eta12=0.2)
LAW = ss.PaperFriction()
FREE = ss.BlockOnBelt(damping=0.05)
HYPERBOLIC = ss.HyperbolicFriction(scale=1, decay=3)
OBSERVED = (
    "final_state",
    "stick_fraction",
    "transitions",
    "period",
    "state_max",
    "dissipated",
    "points",
    "status",
)


def swept(kind: str, **settings: object) -> xr.Dataset:
    model = ss.Model(RIG, friction=LAW, effects=EFFECTS[kind])
    over = {"belt_speed": np.linspace(-0.2, 0.3, 9), "alpha1": [12.0, 16.0, 21.0]}
    given = {
        "initial": (0.1, 0.1, 0, 0),
        "t_end": 60,
        "after": 20,
        "observe": OBSERVED,
        "rtol": 1e-10,
        "atol": 1e-10,
    }
    return ss.sweep(model, over, **(given | settings))  # type: ignore[arg-type]


def test_every_effect_that_moves_the_rig_is_tried():
    known = set(_core.EFFECTS)
    assert known - READING_EFFECTS - {"tabulated", "second_tabulated"} <= set(EFFECTS)


@pytest.mark.parametrize("kind", EFFECTS)
def test_lanes_are_the_scalar_kernel(kind):
    lanes, scalar = swept(kind), swept(kind, lanes=False)
    assert (scalar.status == 0).all()
    for name in OBSERVED:
        close = np.isclose(lanes[name], scalar[name], rtol=1e-8, atol=1e-7, equal_nan=True)
        assert close.all(), (name, int((~close).sum()))


@pytest.mark.parametrize("kind", ["three at once", "contact_compliance", "a slow lag"])
def test_threads_do_not_change_a_bit(kind):
    assert swept(kind, threads=1).identical(swept(kind, threads=3))


def test_one_degree_of_freedom_and_effects_that_are_swept():
    effects = [*one("belt_speed_ripple", a=0.1, w=2.0, phi=0), *one("block_viscous_damping", c=0.1)]
    model = ss.Model(FREE, friction=HYPERBOLIC, effects=effects)
    over = {"belt_speed_ripple.w": np.linspace(0.5, 4, 11), "belt_speed_ripple.a": [0.0, 0.1, 0.4]}
    given = {
        "belt_speed": 0.4,
        "initial": (1, 0),
        "t_end": 80,
        "observe": OBSERVED,
        "rtol": 1e-10,
        "atol": 1e-10,
    }
    lanes, scalar = ss.sweep(model, over, **given), ss.sweep(model, over, lanes=False, **given)
    for name in OBSERVED:
        np.testing.assert_allclose(lanes[name], scalar[name], rtol=1e-8, atol=1e-7, err_msg=name)


def test_a_member_that_cannot_go_on_says_so_and_the_others_go_on():
    model = ss.Model(RIG, friction=LAW, effects=one("spring_cubic_k1", k=-3.0))  # a spring that runs away
    over = {"spring_cubic_k1.k": [-3.0, 0.0, 3.0], "initial.x1": [0.1, 5.0]}
    given = {"belt_speed": 0.1, "initial": (0.1, 0.1, 0, 0), "t_end": 60, "observe": OBSERVED}
    lanes, scalar = ss.sweep(model, over, **given), ss.sweep(model, over, lanes=False, **given)
    assert lanes.status.values.tolist() == scalar.status.values.tolist()
    assert (lanes.status != 0).any()
    assert (lanes.status == 0).any()
    short = ss.sweep(model, over, max_transitions=5, **given)
    assert (short.transitions <= 5).all()


def test_a_corrected_constant_is_varied_with_its_correction() -> None:
    """The mass that moves is mass (1 + e), whether it is set, varied or differentiated by."""
    model = ss.Model(
        ss.BlockOnBelt(damping=0.1),
        friction=ss.HyperbolicFriction(scale=1, decay=3),
        effects=[ss.effect("rig_mass", e=0.5), ss.effect("rig_stiffness", e=-0.2)],
    )

    def end(**named: float) -> np.ndarray:
        one = model.replace({k.replace("_e", ".e"): v for k, v in named.items()})
        return ss.simulate(one, belt_speed=0.5, initial=(0, 0.3), t_end=5, t_eval=[5.0], rtol=1e-13).state[0]

    for name in ("mass", "stiffness"):
        swept = ss.sweep(model, {name: [1.0, 1.2]}, belt_speed=0.5, t_end=5, initial=(0, 0.3)).final_state
        np.testing.assert_allclose(swept.values, [end(**{name: 1.0}), end(**{name: 1.2})], atol=1e-7)
    names, h = ("mass", "stiffness", "rig_mass_e", "rig_stiffness_e"), 1e-6
    at = {"mass": 1.0, "stiffness": 1.0, "rig_mass_e": 0.5, "rig_stiffness_e": -0.2}
    run = ss.simulate(
        model, belt_speed=0.5, initial=(0, 0.3), t_end=5, t_eval=[5.0],
        sensitivity=[name.replace("_e", ".e") for name in names],
    )  # fmt: skip
    near = [(end(**{n: at[n] + h}) - end(**{n: at[n] - h})) / (2 * h) for n in names]
    np.testing.assert_allclose(run.sensitivity[0].T, near, atol=1e-6)
    with pytest.raises(ss.InputError, match="vary that number itself"):
        ss.sweep(model, {"rig_mass.e": [0.1]}, belt_speed=0.5, t_end=1)


@pytest.mark.parametrize("lanes", [True, False])
@pytest.mark.parametrize("place", ["block", "angle_body", "contact"])
def test_a_knot_where_the_pivot_sticks_is_no_chatter(place: str, lanes: bool) -> None:
    """Two surfaces at y2 = 0: all ends are those with the knot a little beside."""
    rig = ss.Rig(alpha1=24, alpha2=3, beta3=7.4, eta1=0.13, eta12=0.34)
    ends = []
    for knot in (0.0, 1e-11):
        table = ss.tabulated(place, "y2", [-1, knot, 1], [0.1, 0, -0.1])
        pivot = ss.effect("pivot_dry_friction", f=0.05)
        model = ss.Model(rig, friction=ss.PaperFriction(), effects=[pivot, table])
        swept = ss.sweep(
            model,
            {"belt_speed": np.linspace(0.02, 0.2, 60)},
            initial=(-0.1, 0.3, 0.14, -0.07),
            t_end=20,
            lanes=lanes,
        )
        assert (swept.status == 0).all()
        ends.append(swept.final_state.values)
    np.testing.assert_allclose(*ends, atol=1e-7)


def test_friction_that_drives_is_said_of_a_sweep_too() -> None:
    rig = ss.Rig(alpha1=16, alpha2=8, beta3=4, eta1=0.1, eta12=0.2)
    model = ss.Model(rig, friction=ss.PaperFriction(), effects=[ss.effect("friction_drift", r=0.001)])
    with pytest.warns(ss.ModelWarning, match=r"friction_drift\.r = -0\.1: .*in some members"):
        ss.sweep(model, {"friction_drift.r": [-0.1, 0.0]}, belt_speed=0.1, t_end=50)
