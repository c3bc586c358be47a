"""A block that swings out on a base at rest: its friction by the decrement, against a motion integrated by SciPy."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from scipy.integrate import solve_ivp

import stickslip as ss
from stickslip.fitted.swings import decrement

MASS, STIFFNESS, NOISE, DT = 1.2, 850.0, 2e-5, 0.002


def swings(
    friction: float,
    static: float,
    damping: float,
    x0: float,
    seed: int,
    *,
    dt: float = DT,
    noise: float = NOISE,
    zero: float = 0.0,
    declared: float = MASS,
    c: float = 1.0,
) -> ss.Recording:
    """
    Readings of m x'' + c x' + k x = -F sign(x'), at rest once |k x| is within the static limit at a turn.

    They are off by `zero`; the rig is said to have the mass `declared` and the damping `c`.
    """
    t, now, place = np.arange(0.0, 3.0, dt), 0.0, x0
    x = np.full(len(t), place)
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
    x = x + zero + noise * np.random.default_rng(seed).standard_normal(len(t))
    rig = ss.BlockOnBelt(mass=declared, stiffness=STIFFNESS, damping=c)
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


@pytest.mark.parametrize(("dt", "noise"), [(0.0005, 1e-5), (0.002, 1e-4), (0.005, 1e-5), (0.01, 1e-5)])
def test_many_swings_are_fitted_however_they_are_sampled(dt: float, noise: float) -> None:
    """From the first that a parabola told, a fit to all swings at once ended at another number of them."""
    for seed, x0 in ((0, 0.016), (4, 0.0188), (6, 0.0222)):
        run = swings(0.5, 0.8, 0.0, x0, seed, dt=dt, noise=noise, c=0.0)
        law = ss.CoulombFriction(static=1.0, kinetic=0.4)
        found = ss.identify(run, rig=run.rig, friction=law, noise={"x1": noise})
        one = found.estimates["kinetic"]
        assert abs(one.value - 0.5) < 4 * one.std
        assert one.std < 0.002
        assert found.reduced_chi2 == pytest.approx(1.0, abs=0.15)
        assert "discover" not in " ".join(found.messages)
        again = ss.simulate(found.model, belt_speed=0.0, initial=(x0, 0.0), t_end=run.t[-1], t_eval=run.t)
        assert np.sqrt(np.mean((again.x1 - run.x1) ** 2)) < 1.2 * noise  # it rests where the block did


def test_the_swings_tell_the_mass_and_where_the_spring_is_slack() -> None:
    run = swings(1.1, 3.0, 0.6, 0.08, 5, zero=2e-3, declared=1.012 * MASS)
    found = ss.identify(run, rig=run.rig)
    mass = found.constants["mass"]
    assert mass.low < MASS < mass.high
    assert mass.high - mass.low < 1e-3 * MASS
    assert mass.declared == 1.012 * MASS
    assert abs(found.estimates["kinetic"].value - 1.1) < 0.01
    assert found.reduced_chi2 < 1.2
    (said,) = [m for m in found.messages if "where the spring is slack" in m]
    assert float(said.removeprefix("x1 reads ").split()[0]) == pytest.approx(2e-3, rel=0.01)


def test_friction_is_as_uncertain_as_the_spring(tmp_path: Path) -> None:
    run = swings(1.1, 3.0, 0.6, 0.08, 5)
    pd.DataFrame({"t": run.t, "x1": run.x1}).to_csv(tmp_path / "run.csv", index=False)
    wide = {}
    for size in ("0", "0.02"):
        (tmp_path / "rig.toml").write_text(
            f"""[rig]
kind = "block_on_belt"
m = {MASS}
k = {STIFFNESS}
c = 1.0
[uncertainty]
m = 0
k = {size}
x1 = 0
[channels]
t = {{column = "t", unit = "s"}}
x1 = {{column = "x1", unit = "m"}}
[[run]]
file = "run.csv"
role = "train"
belt_speed = 0
"""
        )
        found = ss.identify(ss.load_case(tmp_path))
        std = found.estimates["kinetic"].std
        assert std is not None
        wide[size] = std, found.constants["mass"].high - found.constants["mass"].low
    assert wide["0.02"][0] == pytest.approx(np.hypot(wide["0"][0], 0.02 * 1.1), rel=0.01)
    assert wide["0.02"][1] == pytest.approx(2 * 1.96 * 0.02 * MASS, rel=0.01)
