"""A block that swings out on a base at rest: its friction by the decrement, against a motion integrated by SciPy."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import stickslip as ss
from stickslip.fitted.ring_down import decrement

MASS, STIFFNESS, NOISE, DT = 1.2, 850.0, 2e-5, 0.002


def swings(friction: float, static: float, damping: float, x0: float, seed: int) -> ss.Recording:
    """Readings of m x'' + c x' + k x = -F sign(x'), at rest once |k x| is within the static limit at a turn."""
    t, x, now, place = np.arange(0.0, 3.0, DT), np.zeros(1500), 0.0, x0
    x[:] = place
    while STIFFNESS * abs(place) > static and now < t[-1]:
        way = -np.sign(place)

        def rate(_: float, z: np.ndarray, way: float = way) -> list[float]:
            return [z[1], -(STIFFNESS * z[0] + damping * z[1] + friction * way) / MASS]

        def turn(s: float, z: np.ndarray, way: float = way) -> float:
            return float(z[1] * way) if s > 1e-6 else 1.0

        turn.terminal, turn.direction = True, -1  # type: ignore[attr-defined]
        run = solve_ivp(
            rate, (0, 10), [place, 0.0], "DOP853", rtol=1e-11, atol=1e-13, events=turn, dense_output=True
        )
        part = (t >= now) & (t < now + run.t[-1])
        x[part] = run.sol(t[part] - now)[0]
        now, place = now + run.t[-1], float(run.y[0, -1])
        x[t >= now] = place
    x = x + NOISE * np.random.default_rng(seed).standard_normal(len(t))
    rig = ss.BlockOnBelt(mass=MASS, stiffness=STIFFNESS, damping=1.0)
    channels = {"t": ss.Channel("t", unit="s"), "x1": ss.Channel("x1", unit="m")}
    return ss.load_recording({"t": t, "x1": x}, rig, channels=channels, belt_speed=0.0)


@pytest.mark.parametrize(
    ("friction", "static", "damping"), [(4.2, 6.0, 0.6), (1.1, 3.0, 3.0), (2.5, 2.6, 1.5)]
)
def test_friction_and_damping_of_a_ring_down_are_found(
    friction: float, static: float, damping: float
) -> None:
    run = swings(friction, static, damping, 0.08, 3)
    found = ss.identify(run, rig=run.rig)
    assert isinstance(found.law, ss.CoulombFriction)
    one, other = found.estimates["kinetic"], found.constants["damping"]
    assert abs(one.value - friction) < 3.5 * one.std
    assert one.std < 0.005 * friction
    assert abs(other.value - damping) < 3.5 * (other.high - other.low) / 3.92
    assert other.declared == 1.0
    assert found.reduced_chi2 == pytest.approx(1.0, abs=0.1)
    assert "static" in found.unidentified
    (said,) = [m for m in found.messages if m.startswith("static friction lies between")]
    low, high = (
        float(w) for w in said.removeprefix("static friction lies between ").split(":")[0].split(" and ")
    )
    assert low * 0.999 <= static <= high * 1.001
    assert found.model.parameters["damping"] == other.value
    assert found.covered["minus"] is not None
    assert found.covered["plus"] is not None


def test_a_ring_down_of_closed_form_gives_its_decrement() -> None:
    """|X[n+1]| = rho |X[n]| - (1 + rho) F/k, exactly."""
    size, turns = 0.08, []
    for n in range(8):
        turns.append(size * (-1) ** n)
        size = 0.97 * size - 1.97 * 2.0 / STIFFNESS
    found = decrement(np.array(turns), STIFFNESS)
    assert found.friction == pytest.approx(2.0, rel=1e-9)
    assert found.ratio == pytest.approx(0.97, rel=1e-9)


def test_a_block_that_hardly_swings_is_refused_in_a_line() -> None:
    run = swings(20.0, 25.0, 0.6, 0.08, 3)
    with pytest.raises(ss.InputError, match=r"swings of a ring-down are seen; at least 3 are needed"):
        ss.identify(run, rig=run.rig)
