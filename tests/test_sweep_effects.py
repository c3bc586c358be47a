"""Models with effects in lanes: every effect of the catalogue against the scalar kernel, whatever the threads."""

from __future__ import annotations

import numpy as np
import pytest
import xarray as xr

import stickslip as ss
from stickslip import _core
from stickslip.lowering import READING_EFFECTS

RIG = ss.Rig(alpha1=16, alpha2=8, beta3=4, eta1=0.1, eta12=0.2)
LAW = ss.PaperFriction()
FREE = ss.BlockOnBelt(damping=0.05)
HYPERBOLIC = ss.HyperbolicFriction(scale=1, decay=3)
SHAPE = ([-0.3, -0.1, 0, 0.1, 0.3], [0.1, -0.1, 0.15, 0, 0.1])


def one(kind: str, **numbers: float) -> list[ss.Effect]:
    return [ss.effect(kind, **numbers)]


EFFECTS: dict[str, list[ss.Effect | ss.Tabulated]] = {
    "block_viscous_damping": [*one("block_viscous_damping", c=0.3)],
    "block_quadratic_damping": [*one("block_quadratic_damping", c=0.5)],
    "spring_cubic_k1": [*one("spring_cubic_k1", k=3.0)],
    "spring_cubic_k2": [*one("spring_cubic_k2", k=3.0)],
    "spring_cubic_k3": [*one("spring_cubic_k3", k=3.0)],
    "spring_gap_k3": [*one("spring_gap_k3", k=10.0, d=0.05)],
    "constant_load": [*one("constant_load", f=0.3)],
    "harmonic_forcing": [*one("harmonic_forcing", a=0.3, w=1.7, phi=0.3)],
    "pivot_dry_friction": [*one("pivot_dry_friction", f=0.05)],
    "pivot that creeps": [*one("pivot_dry_friction", f=0.05, v_c=0.002)],
    "normal_force_feedback": [*one("normal_force_feedback", beta2=2.0, eta2=1.0)],
    "a normal force that lifts": [*one("normal_force_feedback", beta2=40.0, eta2=1.0)],
    "stribeck_peak": [*one("stribeck_peak", dT=0.8, v_s=0.02)],
    "static_aging": [*one("static_aging", dT=1.0, tau=2.0)],
    "friction_memory": [*one("friction_memory", tau=0.05)],
    "friction_drift": [*one("friction_drift", r=0.001)],
    "belt_seam": [*one("belt_seam", a=0.1, L=2.0, phi=0.1)],
    "contact_compliance": [*one("contact_compliance", k=400.0, c=0.5)],
    "belt_speed_ripple": [*one("belt_speed_ripple", a=0.1, w=4.0, phi=0.2)],
    "belt_load_droop": [*one("belt_load_droop", k=0.004, tau=1.0)],
    "sensor_lag": [*one("sensor_lag", tau=0.2)],
    "a slow lag": [*one("sensor_lag", tau=20.0), *one("sensor_crosstalk", c=0.1)],
    "a table on the block": [ss.tabulated("block", "x1", *SHAPE)],
    "a table on the angle body": [ss.tabulated("angle_body", "y2", *SHAPE)],
    "a table on the contact": [ss.tabulated("contact", "y1", *SHAPE)],
    "a table in time that repeats": [ss.tabulated("block", "t", [0, 1, 2, 3], [0, 0.2, -0.1, 0], period=3)],
    "three at once": [
        *one("belt_speed_ripple", a=0.1, w=4.0, phi=0.2),
        *one("static_aging", dT=1.0, tau=2.0),
        *one("spring_gap_k3", k=10.0, d=0.05),
    ],
}
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
    known = {name.split(".")[0] for name in _core.PARAMETERS if "." in name}
    assert known - READING_EFFECTS <= set(EFFECTS)


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
