"""A mass without a spring of which only the velocity is read: nothing says where it is, and nothing depends on it."""

import numpy as np
import pytest

import stickslip as ss
from stickslip.declared.uncertainty import Uncertainty
from stickslip.discovery.general_rig.bench import bench_of
from stickslip.discovery.laboratory.hypothesis import label, of_term, term
from stickslip.discovery.laboratory.screen import _places
from stickslip.fitted.bodies_data import prepare_bodies

SPEED = 0.1
RIG = ss.BodiesRig(
    body={"a": ss.Body(mass=1.0), "b": ss.Body(mass=0.5)},
    link=[
        ss.Link(between=("a", "ground"), stiffness=40.0, damping=0.2),
        ss.Link(between=("b", "ground"), damping=2.0),
    ],
    contact=[
        ss.Contact(body="a", against="belt", law="la"),
        ss.Contact(body="b", against="a", law="lb", name="top"),
    ],
)
LAWS = {"la": ss.CoulombFriction(static=5.0, kinetic=3.0), "lb": ss.CoulombFriction(static=0.7, kinetic=0.5)}
MODEL = ss.Model(RIG, friction=LAWS)


def recorded(seed: int) -> tuple[ss.Recording, ss.Trajectory]:
    """What a laser reads of the lower mass and a vibrometer of the upper one."""
    t = np.arange(0.0, 20.0, 0.01)
    made = ss.simulate(
        MODEL, belt_speed=SPEED, initial=(0.0, 0.0, SPEED, SPEED), t_end=t[-1] + 5, t_eval=t + 5
    )
    rng = np.random.default_rng(seed)
    a, v_b = (
        one + size * rng.normal(size=len(t))
        for one, size in ((made.state[:, 0], 1e-4), (made.state[:, 3], 1e-3))
    )
    return ss.load_recording({"t": t, "a": a, "v_b": v_b}, RIG, belt_speed=SPEED), made


def test_its_motion_is_taken_from_its_velocity() -> None:
    run, made = recorded(0)
    (found,) = prepare_bodies(RIG, [run], MODEL.friction)
    assert np.std(found.v[:, 1] - made.state[:, 3]) < 2e-3
    gone = found.q[:, 1] - found.q[0, 1]
    assert np.std(gone - (made.state[:, 1] - made.state[0, 1])) < 0.02 * np.ptp(gone)


def test_its_laws_and_damping_are_identified() -> None:
    found = ss.identify([recorded(1)[0]], rig=RIG, friction=LAWS)
    assert isinstance(found, ss.IdentifiedRig)
    assert found.reduced_chi2 == pytest.approx(1.0, abs=0.1)
    numbers = found.model.parameters
    for name, true in {"la.kinetic": 3.0, "la.static": 5.0, "lb.kinetic": 0.5, "link_2.damping": 2.0}.items():
        assert numbers[name] == pytest.approx(true, rel=0.05), name


def test_every_effect_that_is_tried_has_a_size() -> None:
    """That of a mass without springs was nothing: a prior of no width, and no number that could move."""
    run, _ = recorded(2)
    bench = bench_of(MODEL, [run], Uncertainty.usual(RIG, channels=("a", "v_b")))
    for kind in bench.kinds():
        if kind.wave is None and kind.anywhere.bristle is None:
            of, numbers, _ = next(iter(_places(bench, kind)))
            assert all(one.sd > 0 for one in of_term(term(of, numbers), bench.policy)), label(kind)
