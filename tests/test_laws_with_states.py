"""Laws with states of their own on rigs of bodies: identified, compared, forecast and searched."""

from __future__ import annotations

import numpy as np
import pytest

import stickslip as ss
from differences import held_against_differences
from stickslip.declared.uncertainty import Uncertainty
from stickslip.likelihoods.bodies_bench import BodiesBench, bench_of
from stickslip.likelihoods.fit import null
from stickslip.likelihoods.fit_state import unexplained

RIG = ss.BodiesRig(
    body={"x": ss.Body(mass=1.0)},
    link=[ss.Link(between=("x", "ground"), stiffness=100.0, damping=0.3)],
    contact=[ss.Contact(body="x", against="belt")],
)
LUGRE = {"sigma0": 1e4, "sigma1": 50.0, "sigma2": 0.4, "F_c": 2.0, "F_s": 3.2, "v_s": 0.05}
FAR = {"sigma0": 7e3, "sigma1": 60.0, "sigma2": 0.3, "F_c": 2.2, "F_s": 3.0, "v_s": 0.07}
NOISE, DT = 2e-5, 0.005


def record(
    law: ss.FrictionLaw, speed: object, seed: int, lasts: float, start: tuple[float, float] = (0.0, 0.0)
) -> ss.Recording:
    t = np.arange(0.0, lasts, DT)
    run = ss.simulate(ss.Model(RIG, friction=law), belt_speed=speed, t_end=lasts, t_eval=t, initial=start)
    assert len(run.t) == len(t), run.status
    x = run.x + NOISE * np.random.default_rng(seed).standard_normal(len(t))
    return ss.load_recording({"t": t, "x": x}, RIG, belt_speed=speed)


@pytest.fixture(scope="module")
def runs() -> list[ss.Recording]:
    law = ss.LuGreFriction(**LUGRE)
    return [record(law, 0.05, 1, 8.0), record(law, 0.08, 2, 6.0)]


@pytest.fixture(scope="module")
def found(runs: list[ss.Recording]) -> ss.Identified:
    return ss.identify(runs, friction=ss.LuGreFriction(**FAR))


def test_lugre_is_found_from_far_off(found: ss.Identified) -> None:
    for name, size in LUGRE.items():
        one = found.estimates[name]
        assert one.low - 0.01 * size < size < one.high + 0.01 * size, name
        assert abs(one.value / size - 1) < 0.06, name
    assert found.reduced_chi2 == pytest.approx(1.0, abs=0.1)


def test_what_was_found_compares_and_forecasts(found: ss.Identified) -> None:
    law = ss.LuGreFriction(**LUGRE)
    whole = record(law, 0.065, 3, 7.0)
    past = record(law, 0.065, 3, 6.0)
    told = ss.forecast(found.model, past, horizon=0.5)
    true = whole.to_dataframe()["x"].to_numpy()[len(past.t) : len(past.t) + len(told)]
    within = (told["x_low"] <= true) & (true <= told["x_high"])
    assert within.mean() > 0.8
    assert np.sqrt(np.mean((told["x"] - true) ** 2)) < 5 * NOISE
    table = ss.compare(found.model, past).to_dataframe().set_index("quantity")
    assert table.loc["noise left", "simulated"] < 1.3


def bench(law: ss.FrictionLaw, runs: list[ss.Recording]) -> BodiesBench:
    return bench_of(ss.Model(RIG, friction=law), runs, Uncertainty.usual(RIG, channels=["x"]))


def test_windows_of_the_true_law_leave_the_noise(runs: list[ss.Recording]) -> None:
    fit = null(
        bench(ss.LuGreFriction(**LUGRE), runs).windows(), bench(ss.LuGreFriction(**LUGRE), runs).policy
    )
    assert unexplained(fit) == pytest.approx(1.0, abs=0.1)


def test_derivatives_by_the_law_and_by_its_state_are_those_of_differences(runs: list[ss.Recording]) -> None:
    windows = bench(ss.LuGreFriction(**LUGRE), runs[:1]).windows()
    assert windows.begins == 3  # x, v and the bristle
    held_against_differences(windows, np.array([one.start for one in windows.numbers]), "lugre")


@pytest.mark.parametrize("reverses", [False, True])
def test_dahl_is_found(reverses: bool) -> None:
    law = ss.DahlFriction(sigma0=5e3, F_c=2.0)
    if reverses:
        given = [record(law, f"0.05*sin({w}*t)", seed, 10.0) for seed, w in ((1, 3.1), (2, 2.3))]
    else:
        given = [record(law, 0.05, 1, 8.0, (0.03, 0.2)), record(law, 0.08, 2, 8.0, (-0.02, 0.4))]
    found = ss.identify(given, friction=ss.DahlFriction(sigma0=4e3, F_c=2.4))
    for name, size in (("sigma0", 5e3), ("F_c", 2.0)):
        assert found.estimates[name].low < size < found.estimates[name].high
        assert abs(found.estimates[name].value / size - 1) < 0.06


def test_a_bristle_of_one_s_own_is_found_as_the_one_built_in(
    found: ss.Identified, runs: list[ss.Recording]
) -> None:
    own = ss.FormulaFriction(
        force="s0*z + s1*z_rate + s2*v",
        define={"g": "Fc + (Fs - Fc)*exp(-(u/vs)**2)"},
        states={"z": {"rate": "v - s0*u*z/g", "unit": "m"}},
        s0="7000 N/m", s1="60 N s/m", s2="0.3 N s/m", Fc="2.2 N", Fs="3.0 N", vs="70 mm/s",
    )  # fmt: skip
    ours = ss.identify(runs, friction=own)
    names = {"s0": "sigma0", "s1": "sigma1", "s2": "sigma2", "Fc": "F_c", "Fs": "F_s", "vs": "v_s"}
    for one, other in names.items():
        assert ours.estimates[one].value == pytest.approx(found.estimates[other].value, rel=0.02)
