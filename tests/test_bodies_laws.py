"""Rigs of bodies in the core: laws with states, powers of 0, ageing limits, speeds in pieces, derivatives."""

from __future__ import annotations

import math

import numpy as np
import pytest
import scipy

from bodies_core import Bodies, Law
from bodies_scipy import Apart
from stickslip import _core

LUGRE = Law(
    force="sigma0*z + sigma1*(v - sigma0*u*z/(Fc + (Fs - Fc)*exp(-(u/vs)**2))) + sigma2*v",
    rates={"z": "v - sigma0*u*z/(Fc + (Fs - Fc)*exp(-(u/vs)**2))"},
)
LUGRE_NUMBERS = {"sigma0": 400.0, "sigma1": 2.0, "sigma2": 0.1, "Fc": 0.6, "Fs": 1.0, "vs": 0.1}
RATE_STATE = Law(
    force="N*a*asinh(v/(2*V0)*exp((mu0 + b*log(V0*theta/Dc))/a))", rates={"theta": "1 - u*theta/Dc"}
)
RATE_STATE_NUMBERS = {"N": 1.0, "a": 0.02, "b": 0.03, "mu0": 0.5, "V0": 0.1, "Dc": 0.05}


def block(law: Law, numbers: dict[str, float], speed: list[tuple[float, str]], c: float = 0.0) -> Bodies:
    return Bodies(np.eye(1), np.array([[c]]), np.eye(1), np.eye(1), [law], numbers, [speed])


def test_lugre_block_is_that_of_a_stiff_solver() -> None:
    def field(_: float, y: np.ndarray) -> list[float]:
        x, w, z = y
        p, v = LUGRE_NUMBERS, w - 0.15
        g = p["Fc"] + (p["Fs"] - p["Fc"]) * math.exp(-((v / p["vs"]) ** 2))
        rate = v - p["sigma0"] * abs(v) * z / g
        return [w, -x - 0.05 * w - p["sigma0"] * z - p["sigma1"] * rate - p["sigma2"] * v, rate]

    t = np.linspace(0.5, 12.0, 20)
    want = scipy.integrate.solve_ivp(
        field, (0, 12), [0.2, 0.0, 0.0], "Radau", t_eval=t, rtol=1e-11, atol=1e-13
    )
    rig = block(LUGRE, LUGRE_NUMBERS, [(0.0, "0.15")], 0.05)
    got = rig.run([0.2, 0.0, 0.0], 12.0, t_eval=t, rtol=1e-11, atol=1e-13)
    assert got["outcome"] == _core.Outcome.finished
    np.testing.assert_allclose(got["state"][:, :3].T, want.y, rtol=0, atol=2e-8)


def test_rate_and_state_block_is_that_of_a_stiff_solver() -> None:
    def field(_: float, y: np.ndarray) -> list[float]:
        x, w, theta = y
        p, v = RATE_STATE_NUMBERS, w - 0.1
        force = (
            p["N"]
            * p["a"]
            * math.asinh(
                v
                / (2 * p["V0"])
                * math.exp((p["mu0"] + p["b"] * math.log(p["V0"] * theta / p["Dc"])) / p["a"])
            )
        )
        return [w, -x - force, 1 - abs(v) * theta / p["Dc"]]

    t = np.linspace(0.5, 20.0, 14)
    start = [0.52, 0.0, 0.5]
    want = scipy.integrate.solve_ivp(field, (0, 20), start, "Radau", t_eval=t, rtol=1e-11, atol=1e-13)
    got = block(RATE_STATE, RATE_STATE_NUMBERS, [(0.0, "0.1")]).run(
        start, 20.0, t_eval=t, rtol=1e-11, atol=1e-13
    )
    assert got["outcome"] == _core.Outcome.finished
    np.testing.assert_allclose(got["state"][:, :3].T, want.y, rtol=0, atol=2e-8)


@pytest.mark.parametrize(
    ("delta", "drop"),
    [(0.5, 0.1), (0.8, 0.0), (0.8, 0.1), (1.0, 0.0), (1.3, 0.0), (1.3, 0.1), (2.0, 0.0), (2.7, 0.0)],
)
def test_a_power_of_zero_starts_every_slip(delta: float, drop: float) -> None:
    """Stribeck's law with any exponent: u^delta has no series where slip begins."""
    numbers = {"Fs": 1.0, "Fc": 0.5, "vs": 0.3, "delta": delta, "drop": drop}
    core = block(Law("Fc + (Fs - Fc)*exp(-(u/vs)**delta)", "Fs + drop"), numbers, [(0.0, "0.2")], 0.05)
    apart = Apart(
        np.eye(1), np.array([[0.05]]), np.eye(1), np.eye(1),
        [lambda u: 0.5 + 0.5 * math.exp(-((max(u, 0.0) / 0.3) ** delta))], [1.0 + drop], [lambda _: (0.2, 0.0)],
        np.zeros(1),
    )  # fmt: skip
    times, modes, end = apart.run(np.array([0.0, 0.9]), 30.0)
    got = core.run([0.0, 0.9], 30.0, rtol=1e-11, atol=1e-13, t_eval=[30.0])
    assert got["outcome"] == _core.Outcome.finished
    assert len(times) > 4
    np.testing.assert_array_equal(got["transition_after"], np.array(modes))
    np.testing.assert_allclose(got["transition_t"], times, rtol=0, atol=3e-8)
    np.testing.assert_allclose(got["state"][0, :2], end, rtol=0, atol=3e-8)
    assert got["steps"] < 60 * len(times)


def test_a_limit_that_ages_while_the_block_sticks() -> None:
    """static = Fs (1 + b log(1 + dwell)): the stick ends where the spring has caught up, x(t) on the belt."""
    numbers = {"Fs": 1.0, "Fk": 0.5, "b": 0.1}
    got = block(Law("Fk", "Fs*(1 + b*log(1 + dwell))"), numbers, [(0.0, "0.2")]).run([0.0, 0.2], 100.0)
    lasted = scipy.optimize.brentq(lambda t: 0.2 * t - 1.0 - 0.1 * math.log(1 + t), 1, 20, xtol=1e-14)
    assert got["transition_t"][0] == pytest.approx(lasted, abs=1e-12)
    ends = got["transition_t"][got["transition_after"][:, 0] != 0]
    begins = got["transition_t"][got["transition_after"][:, 0] == 0]
    x = got["transition_state"][got["transition_after"][:, 0] != 0, 0]
    for begin, end, at in zip(begins, ends[1:], x[1:], strict=False):
        assert at == pytest.approx(1 + 0.1 * math.log(1 + end - begin), abs=1e-11)


def test_a_belt_that_steps_and_ramps() -> None:
    """Each piece is a run of its own, from where the last one ended."""
    numbers = {"Fs": 1.0, "Fk": 0.6, "vs": 0.2}
    law = Law("Fk + (Fs - Fk)/(1 + u/vs)", "Fs")
    pieces = [(0.0, "0.1"), (7.0, "-0.2"), (13.5, "0.05*t - 0.875"), (25.0, "0.2 + 0.1*sin(t)")]
    got = block(law, numbers, pieces).run(
        [0.5, 0.1], 40.0, t_eval=[7.0, 13.5, 25.0, 40.0], rtol=1e-12, atol=1e-14
    )
    assert got["outcome"] == _core.Outcome.finished
    z = np.array([0.5, 0.1])
    for (begin, text), end, row in zip(pieces, [7.0, 13.5, 25.0, 40.0], got["state"], strict=True):

        def speed(t: float, text: str = text, begin: float = begin) -> tuple[float, float]:
            at = begin + t
            rate = {"0.1": 0.0, "-0.2": 0.0, "0.05*t - 0.875": 0.05}.get(text, 0.1 * math.cos(at))
            return float(eval(text, {"t": at, "sin": math.sin})), rate

        apart = Apart(
            np.eye(1), np.zeros((1, 1)), np.eye(1), np.eye(1), [lambda u: 0.6 + 0.4 / (1 + u / 0.2)], [1.0], [speed],
            np.zeros(1),
        )  # fmt: skip
        _, _, z = apart.run(z, end - begin)
        np.testing.assert_allclose(row[:2], z, rtol=0, atol=1e-9)


def test_a_spring_pulled_by_a_drive() -> None:
    """A slider on the ground pulled through a spring: stick while k V t < static, then the closed form of Coulomb."""
    numbers = {"Fs": 1.0, "Fk": 0.5}
    rig = Bodies(
        np.eye(1), np.zeros((1, 1)), np.eye(1), np.eye(1), [Law("Fk", "Fs")], numbers, [[(0.0, "0.2")]], [-1],
        pull_x=np.array([[1.0]]),
    )  # fmt: skip
    got = rig.run([0.0, 0.0], 60.0)
    lasted = np.diff(np.concatenate([[0.0], got["transition_t"]]))
    np.testing.assert_allclose(lasted[0::2], 5.0, rtol=0, atol=1e-11)
    np.testing.assert_allclose(lasted[1::2], 2 * (math.pi - math.atan(2.5)), rtol=0, atol=1e-11)
    np.testing.assert_allclose(got["state"][:, 2], 0.2 * got["t"], rtol=0, atol=1e-12)


def test_all_stuck_costs_one_expansion_an_event() -> None:
    """Two blocks on a slow belt with a table under no friction: long sticks, few steps."""
    numbers = {"Fs": 1.0, "Fk": 0.9}
    K = np.array([[1.2, -0.2], [-0.2, 1.3]])
    rig = Bodies(np.eye(2), 0.2 * np.eye(2), K, np.eye(2), [Law("Fk", "Fs")] * 2, numbers, [[(0.0, "1e-4")]])
    got = rig.run([0.0, 0.1, 1e-4, 1e-4], 50_000.0)
    sticks = int(np.sum((got["transition_after"] == 0).all(axis=1))) + 1
    slips = len(got["transition_t"]) - sticks + 1
    assert sticks > 10
    assert got["steps"] <= sticks + 10 * slips


SEEDED = [("M", 0), ("C", 1), ("K", 1), ("K", 3), ("force", 1), ("D", 1), ("initial", 1)]
SEEDED += ["sigma0", "Fs", "Fk", "vs", "w"]


def seeded_rig() -> Bodies:
    numbers = {
        "Fs": 1.0,
        "Fk": 0.6,
        "vs": 0.2,
        "w": 1.3,
        **{k: LUGRE_NUMBERS[k] for k in ("sigma1", "sigma2", "Fc")},
    }
    numbers["sigma0"] = 20.0
    laws = [Law("Fk + (Fs - Fk)*exp(-(u/vs)**1.5)", "Fs*(1 + 0.05*log(1 + dwell))"), LUGRE]
    M, K = np.array([[1.0, 0.1], [0.1, 0.7]]), np.array([[1.5, -0.4], [-0.4, 1.1]])
    D = np.array([[1.0, 0.05], [0.0, 1.0]])
    speeds = [[(0.0, "0.2 + 0.05*sin(w*t)"), (9.0, "0.25")], [(0.0, "0.1")]]
    return Bodies(M, 0.05 * K, K, D, laws, numbers, speeds, [0, 1])


def test_derivatives_are_those_of_perturbation() -> None:
    """By matrices, laws with states and powers of 0, a speed's formula, the start; at fixed times and transitions."""
    rig, start, t = seeded_rig(), [0.9, 0.1, 0.0, 0.2, 0.01], np.array([3.0, 8.0, 16.0, 24.0])
    options = {"t_eval": t, "rtol": 1e-13, "atol": 1e-15}
    got = rig.run(start, 24.0, seeds=SEEDED, **options)
    assert len(got["transition_t"]) > 4
    for i, seed in enumerate(SEEDED):
        h = 1e-5
        moved = [rig.run(start, 24.0, shifts={seed: by * h}, **options) for by in (-2, -1, 1, 2)]
        for key, slope in (
            ("state", got["sensitivity"]),
            ("transition_t", got["transition_sensitivity"][:, 0]),
        ):
            a, b, c, d = (one[key] for one in moved)
            want = (8 * (c - b) - (d - a)) / (12 * h)
            tol = 1e-7 * max(1, np.abs(want).max())
            np.testing.assert_allclose(slope[..., i], want, rtol=0, atol=tol, err_msg=str(seed))


def test_den_hartog_forced_by_a_formula_of_time() -> None:
    """x'' + x = cos(r t) - S sgn x', non-stop, r = 0.8, S = 0.3 (Den Hartog 1931): amplitude in closed form."""
    r, S = 0.8, 0.3
    rig = Bodies(
        np.eye(1), np.zeros((1, 1)), np.eye(1), np.eye(1), [Law("S", "S")], {"S": S, "r": r},
        [[(0.0, "cos(r*t)")]], [-1], pull_v=np.array([[1.0]]),
    )  # fmt: skip
    got = rig.run([0.0, 0.0], 600.0, rtol=1e-11, atol=1e-13)
    turns = np.abs(got["transition_state"][got["transition_t"] > 500, 0])
    amplitude = math.sqrt((1 / (1 - r**2)) ** 2 - (S * math.tan(math.pi / (2 * r)) / r) ** 2)
    np.testing.assert_allclose(turns, amplitude, rtol=0, atol=1e-9)


def test_a_block_without_spring_stops_and_stays() -> None:
    rig = Bodies(
        np.eye(1),
        np.zeros((1, 1)),
        np.zeros((1, 1)),
        np.eye(1),
        [Law("Fk", "Fs")],
        {"Fk": 0.5, "Fs": 1.0},
        [],
        [-1],
    )
    got = rig.run([0.0, 1.0], 1e6)
    assert got["transition_t"] == pytest.approx([2.0], abs=1e-14)
    assert got["state"][-1] == pytest.approx([1.0, 0.0], abs=1e-14)
    assert got["steps"] <= 3


def test_a_force_that_jumps_against_the_motion_is_called_ill_posed() -> None:
    """Friction that jumps up where |v| passes 0.3 holds it there: no mode of the law does, and the run says so."""
    got = block(Law("Fk*(1 + 0.5*sign(u - 0.3))", "Fs"), {"Fk": 0.5, "Fs": 1.0}, [(0.0, "0.2")]).run(
        [1.5, 0.9], 60.0
    )
    assert got["outcome"] == _core.Outcome.chatter
