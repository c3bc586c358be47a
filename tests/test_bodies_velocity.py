"""Rigs of bodies of which a velocity is read, and not where the body is."""

import numpy as np
import pytest

import stickslip as ss
from stickslip.fitted.bodies_data import prepare_bodies

ARM = ss.BodiesRig(
    body={"arm": ss.Body(inertia=4e-3)},
    link=[ss.Link(between=("arm", "ground"), stiffness=90.0, damping=0.02)],
    contact=[ss.Contact(body="arm", against="belt", arm=0.2)],
)
LAW, NOISE = ss.CoulombFriction(static=4.0, kinetic=2.0), 0.01


def recorded(speed: float, seed: int) -> tuple[ss.Recording, ss.Trajectory]:
    """What a vibrometer reads of a pin on a disc, from mid-stick on."""
    t = np.arange(0.0, 3.0, 1e-3)
    made = ss.simulate(
        ss.Model(ARM, friction=LAW), belt_speed=speed, initial=(0.0, 0.0), t_end=t[-1] + 1, t_eval=t + 1
    )
    noise = NOISE * np.random.default_rng(seed).normal(size=len(t))
    return ss.load_recording({"t": t, "v_arm": made.v_arm + noise}, ARM, belt_speed=speed), made


def test_where_it_is_follows_from_the_law() -> None:
    run, made = recorded(0.012, 0)
    (found,) = prepare_bodies(ARM, [run], LAW)  # type: ignore[arg-type]
    assert found.placed == (False,)
    assert np.std(found.q[:, 0] - made.arm) < 0.1 * np.std(made.arm)
    assert np.mean(found.q[:, 0] - made.arm) == pytest.approx(0, abs=0.2 * np.std(made.arm))


def test_a_fit_that_explains_nothing_calls_no_constant_wrong() -> None:
    """A sine is no stick-slip: whatever numbers it drives a fit to are none of the rig's."""
    t = np.arange(0.0, 3.0, 1e-3)
    reading = 0.3 * np.sin(2 * np.pi * 7.3 * t) + NOISE * np.random.default_rng(5).normal(size=len(t))
    run = ss.load_recording({"t": t, "v_arm": reading}, ARM, belt_speed=0.012)
    found = ss.identify(run, rig=ARM, friction=LAW)
    assert found.reduced_chi2 > 2
    assert any("no number here can be relied on" in one for one in found.messages)
    assert not any("from what is declared" in one for one in found.messages)


@pytest.mark.parametrize(("static", "kinetic"), [(4.0, 2.0), (4.4, 1.8)])
def test_the_drop_is_found_and_constants_stay(static: float, kinetic: float) -> None:
    """Of both limits the readings show the difference alone; a gain of 0.5 and half the inertia was told."""
    runs = [recorded(speed, seed)[0] for seed, speed in enumerate((0.010, 0.015, 0.012))]
    found = ss.identify(runs, rig=ARM, friction=ss.CoulombFriction(static=static, kinetic=kinetic))
    assert isinstance(found, ss.IdentifiedRig)
    assert found.reduced_chi2 == pytest.approx(1.0, abs=0.1)
    assert found.wrong == ()
    law = found.model.friction
    assert isinstance(law, ss.CoulombFriction)
    assert law.static - law.kinetic == pytest.approx(2.0, rel=0.03)
