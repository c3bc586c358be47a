"""Random rigs of 1 to 6 coordinates in the compiled core against SciPy event by event; chains; ties."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import pytest

from bodies_core import Bodies, Law
from bodies_scipy import Apart
from stickslip import _core

Speed = Callable[[float], tuple[float, float]]


def random_law(
    rng: np.random.Generator, name: str, numbers: dict[str, float]
) -> tuple[Law, Callable[[float], float], float]:
    """A law as a tape, as a function, and its static limit."""
    static, kinetic, v_s = rng.uniform(0.6, 1.2), rng.uniform(0.2, 0.5), rng.uniform(0.1, 0.5)
    numbers |= {f"s{name}": static, f"k{name}": kinetic, f"v{name}": v_s}
    s, k, v = f"s{name}", f"k{name}", f"v{name}"
    match rng.integers(4):
        case 0:
            return Law(k, s), lambda _: kinetic, static
        case 1:
            text = f"{k} + ({s} - {k})*exp(-(u/{v})**2) + 0.1*u"
            return (
                Law(text, s),
                lambda u: kinetic + (static - kinetic) * math.exp(-((u / v_s) ** 2)) + 0.1 * u,
                static,
            )
        case 2:
            text = f"{k} + ({s} - {k})/(1 + u/{v})"
            return Law(text, s), lambda u: kinetic + (static - kinetic) / (1 + u / v_s), static
        case _:
            text = f"{k} + 0.1*tanh(u/{v}) + 0.05*log(1 + u**3)"
            return (
                Law(text, s),
                lambda u: kinetic + 0.1 * math.tanh(u / v_s) + 0.05 * math.log(1 + u**3),
                static,
            )


def random_speed(rng: np.random.Generator) -> tuple[str, Speed]:
    a, b, w = rng.uniform(0.1, 0.3), rng.uniform(0.05, 0.2), rng.uniform(0.5, 2.0)
    match rng.integers(3):
        case 0:
            return repr(a), lambda _: (a, 0.0)
        case 1:
            return f"{a!r} + {b / 10!r}*t", lambda t: (a + b / 10 * t, b / 10)
        case _:
            return f"{a!r} + {b!r}*sin({w!r}*t)", lambda t: (a + b * math.sin(w * t), b * w * math.cos(w * t))


def random_rig(seed: int, n: int) -> tuple[Bodies, Apart, np.ndarray]:
    rng = np.random.default_rng(seed)
    m = int(rng.integers(1, min(n, 3) + 1))
    A, B = rng.normal(size=(n, n)), rng.normal(size=(n, n))
    M = np.diag(rng.uniform(0.5, 2.0, n)) + 0.1 * A @ A.T
    K = np.diag(rng.uniform(0.5, 2.0, n)) + 0.2 * B @ B.T
    C = 0.02 * K + 0.05 * M
    D = np.eye(n)[:m] + 0.3 * rng.normal(size=(m, n))
    numbers: dict[str, float] = {}
    laws, speeds = [random_law(rng, str(j), numbers) for j in range(m)], [random_speed(rng) for _ in range(m)]
    force = 0.1 * rng.normal(size=n)
    start = np.concatenate([2.0 * rng.normal(size=n), 1.0 * rng.normal(size=n)])
    core = Bodies(
        M,
        C,
        K,
        D,
        [law for law, _, _ in laws],
        numbers,
        [[(0.0, text)] for text, _ in speeds],
        list(range(m)),
        force,
    )
    apart = Apart(M, C, K, D, [f for _, f, _ in laws], [s for _, _, s in laws], [v for _, v in speeds], force)
    return core, apart, start


@pytest.mark.parametrize("n", [1, 2, 3, 4, 5, 6])
@pytest.mark.parametrize("seed", [1, 2, 3])
def test_random_rig_is_that_of_scipy_event_by_event(n: int, seed: int) -> None:
    core, apart, start = random_rig(100 * n + seed, n)
    times, modes, end = apart.run(start, 15.0)
    got = core.run(list(start), 15.0, rtol=1e-12, atol=1e-14, t_eval=[15.0])
    assert got["outcome"] == _core.Outcome.finished
    assert len(times) >= 2
    np.testing.assert_array_equal(got["transition_after"], np.array(modes))
    np.testing.assert_allclose(got["transition_t"], times, rtol=0, atol=2e-9)
    np.testing.assert_allclose(got["state"][0, : 2 * n], end, rtol=0, atol=2e-9)


def chain(masses: list[float], laws: list[Law], numbers: dict[str, float], speed: str = "0.05") -> Bodies:
    """Blocks on a belt, each on a spring of its own and tied to the next (Burridge and Knopoff 1967)."""
    n = len(masses)
    tie = 0.8
    K = np.eye(n) * (1 + 2 * tie) - tie * (np.eye(n, k=1) + np.eye(n, k=-1))
    K[0, 0] = K[-1, -1] = 1 + tie
    return Bodies(np.diag(masses), 0.05 * np.eye(n), K, np.eye(n), laws, numbers, [[(0.0, speed)]])


def test_chain_of_three_releases_that_trigger_each_other() -> None:
    numbers = {"Fs": 1.0, "Fk": 0.6, "vs": 0.2}
    law = Law("Fk + (Fs - Fk)/(1 + u/vs)", "Fs")
    core = chain([1.0, 1.1, 0.9], [law] * 3, numbers)
    start = np.array([0.3, 0.1, -0.2, 0.05, 0.05, 0.05])
    curve = lambda u: 0.6 + 0.4 / (1 + u / 0.2)  # noqa: E731
    apart = Apart(
        core.M, core.C, core.K, core.D, [curve] * 3, [1.0] * 3, [lambda _: (0.05, 0.0)] * 3, np.zeros(3)
    )
    times, modes, end = apart.run(start, 60.0)
    got = core.run(list(start), 60.0, rtol=1e-12, atol=1e-14, t_eval=[60.0])
    assert len(times) > 15
    np.testing.assert_array_equal(got["transition_after"], np.array(modes))
    np.testing.assert_allclose(got["transition_t"], times, rtol=0, atol=1e-8)
    np.testing.assert_allclose(got["state"][0, :6], end, rtol=0, atol=1e-8)


@pytest.mark.parametrize("coupled", [False, True])
def test_identical_blocks_let_go_and_stop_together(coupled: bool) -> None:
    """Two equal blocks from equal starts stay equal, with a mass matrix that couples them too."""
    M = np.array([[1.0, 0.3], [0.3, 1.0]]) if coupled else np.eye(2)
    K = np.array([[1.5, -0.5], [-0.5, 1.5]])
    law = Law("Fk + (Fs - Fk)*exp(-u/vs)", "Fs")
    rig = Bodies(
        M, 0.02 * np.eye(2), K, np.eye(2), [law] * 2, {"Fs": 1.0, "Fk": 0.5, "vs": 0.3}, [[(0.0, "0.1")]]
    )
    got = rig.run([0.2, 0.2, 0.1, 0.1], 40.0, rtol=1e-12, atol=1e-14)
    assert got["outcome"] == _core.Outcome.finished
    assert len(got["transition_t"]) > 4
    np.testing.assert_allclose(got["state"][:, 0], got["state"][:, 1], rtol=0, atol=1e-9)
    settled = got["mode"][np.append(np.diff(got["t"]) > 1e-9, True)]
    np.testing.assert_array_equal(settled[:, 0], settled[:, 1])


def test_what_others_pull_back_is_held_again() -> None:
    """At t = 10.6 one contact turns and, while it is held for a moment, seems to push another over its limit."""
    core, _, start = random_rig(323, 3)
    got = core.run(list(start), 20.0, rtol=1e-12, atol=1e-14)
    assert got["outcome"] == _core.Outcome.finished
    assert np.diff(got["transition_t"]).min() > 1e-9
    speeds = [float(pieces[0][1]) for pieces in core.speeds]
    for row, mode in zip(got["state"], got["mode"], strict=True):
        assert np.all((core.D @ row[3:6] - speeds) * mode >= -1e-12)
