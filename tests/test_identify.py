"""Identification against laws that are known: closed forms, the reference simulator, recorded cases."""

import dataclasses
import json
import os
from pathlib import Path

import numpy as np
import pytest
from scipy.optimize import lsq_linear

import stickslip as ss
from recorded import recording
from slider_cases import KINETIC, STATIC, case_of, rig_of
from stickslip.fitted.covered_speeds import covered_speeds
from stickslip.fitted.identified import estimate, stopped
from stickslip.fitted.identify_windows import law_parameters
from stickslip.fitted.scatter import block_bootstrap, correlation_length, effective_readings
from stickslip.fitted.shooting import above_zero, shoot
from stickslip.measured.fit_window import FitWindow
from stickslip.measured.sticks import track
from stickslip.simulated.reference import integrate as reference

RIG = ss.Rig(alpha1=16, alpha2=8, beta3=4, eta1=0.1, eta12=0.2)
TRUE = ss.PaperFriction(
    T_s_minus=6.2, A1=2.9, A2=2.7, t1=0.031, t2=0.31, T_min_minus=1.5, T_s_plus=3.5, T_min_plus=0.9
)
NOISE = 8e-4
DT = 0.04
SHARED = Path(os.environ.get("STICKSLIP_SHARED", Path(__file__).parents[2] / "shared"))


def truth(belt_speed, t_end, simulator=ss.simulate):
    t = np.arange(0, t_end, DT)
    start = (0.1 * np.sign(belt_speed), belt_speed, 0.05, 0.0)
    run = simulator(
        ss.Model(RIG, friction=TRUE), belt_speed=belt_speed, initial=start, t_end=float(t[-1]), t_eval=t
    )
    return t, run.state


def noisy(tmp_path, clean, seed, speeds):
    rng = np.random.default_rng(seed)
    out = []
    for v, (t, state) in zip(speeds, clean, strict=True):
        x, y = (state[:, i] + NOISE * rng.standard_normal(len(t)) for i in (0, 2))
        out.append(recording(tmp_path, RIG, t, x, y, v, f"run_{v:g}_{seed}", NOISE))
    return out


@pytest.fixture(scope="module")
def clean():
    return [truth(v, 60.0) for v in (0.1, -0.1, 0.16)]


def test_law_of_a_run_made_by_the_reference_is_found_within_its_intervals(tmp_path):
    speeds = (0.11, -0.11)
    runs = noisy(tmp_path, [truth(v, 40.0, reference.simulate) for v in speeds], 1, speeds)
    found = ss.identify(runs, rig=RIG)
    assert found.unidentified == ()
    assert 0.85 < found.reduced_chi2 < 1.15
    for branch, sign in (("minus", -1), ("plus", 1)):
        low, high = found.covered[branch]
        u = np.linspace(low, high, 300)
        below, value, above = found.band(branch, u)
        true = TRUE.magnitude(sign * u)
        assert ((true >= below) & (true <= above)).all()
        assert np.abs(value - true).max() < 0.05
    static = found.estimates["T_s_minus"]
    assert static.low < TRUE.T_s_minus < static.high
    assert static.std < 0.02


@pytest.mark.study
def test_intervals_hold_the_truth_as_often_as_they_say(tmp_path, clean):
    speeds = (0.1, -0.1, 0.16)
    z = []
    for seed in range(5):
        found = ss.identify(noisy(tmp_path, clean, seed, speeds), rig=RIG)
        z += [(e.value - getattr(TRUE, n)) / e.std for n, e in found.estimates.items()]
    z = np.array(z)
    assert 0.87 <= np.mean(np.abs(z) < 1.96) <= 1.0
    assert 0.6 < np.mean(z**2) < 1.6


def test_a_branch_never_visited_is_unidentified_and_keeps_its_declared_start(tmp_path):
    start = ss.PaperFriction(T_s_plus=3.77, T_min_plus=0.77)
    found = ss.identify(noisy(tmp_path, [truth(0.06, 40.0)], 3, (0.06,)), rig=RIG, friction=start)
    assert found.covered["plus"] is None
    assert {"T_s_plus", "T_min_plus"} <= set(found.unidentified)
    assert "T_s_minus" not in found.unidentified
    assert (found.law.T_s_plus, found.law.T_min_plus) == (3.77, 0.77)
    assert found.estimates["T_s_plus"].low is None
    assert np.isnan(found.band("plus", np.array([0.1]))[0]).all()
    assert "branch T_plus was never visited" in found.summary()


def test_the_interval_of_a_positive_number_is_positive_and_that_of_a_sure_one_even():
    loose = estimate(236.0, 168.0, 0.0, 200.0)
    assert 0 < loose.low < 236.0 < loose.high
    assert loose.low * loose.high == pytest.approx(236.0**2)
    sure = estimate(6.0, 0.01, 0.0, 5.0)
    assert (sure.low, sure.high) == pytest.approx((6.0 - 0.0196, 6.0 + 0.0196), rel=1e-5)
    assert estimate(-1.0, 0.1, 0.0, -1.0).low == pytest.approx(-1.196, rel=1e-5)


def test_an_estimate_resting_on_its_declared_start_is_said_to_be_weak():
    assert estimate(2.0, 0.1, 0.0, 3.0).status == "identified"
    assert estimate(2.0, 1.0, 0.0, 3.0).status == "weak"
    assert estimate(2.0, 0.1, 0.5, 3.0).status == "weak"
    assert estimate(2.0, 0.1, 1.0, 3.0) == estimate(9.0, 5.0, 0.995, 3.0)


def test_a_number_that_stops_at_the_limit_of_the_search_is_open_beyond_it():
    """A1 at exactly ten times its start looked as sure as any other number."""
    top, bottom = estimate(32.345, 5.0, 0.0, 3.2345), estimate(0.32345, 0.05, 0.0, 3.2345)
    assert (top.status, top.high) == ("weak", None)
    assert 0 < top.low < 32.345
    assert (bottom.status, bottom.low) == ("weak", None)
    assert bottom.high > 0.32345
    assert (stopped(32.0, 3.2345), stopped(-10.0, -1.0), stopped(5.0, 0.0)) == (0, 1, 0)
    assert estimate(-10.0, 1.0, 0.0, -1.0).low is None


def test_what_is_not_known_to_a_factor_of_a_hundred_has_no_interval():
    lost = estimate(1e-3, 10.0, 0.0, 1e-3)
    assert (lost.low, lost.high, lost.status) == (None, None, "weak")


def test_a_start_too_low_is_said_to_stop_the_search(tmp_path, clean):
    start = dataclasses.replace(TRUE, A1=TRUE.A1 / 40)
    found = ss.identify(noisy(tmp_path, clean[:2], 4, (0.1, -0.1)), rig=RIG, friction=start)
    assert found.estimates["A1"].value == pytest.approx(TRUE.A1 / 4)
    (said,) = [one for one in found.messages if "the limit of the search" in one]
    assert said.startswith("A1 stopped at ten times the declared value, ")
    (row,) = [row for row in found.table() if row["parameter"] == "A1"]
    assert row["95 % interval"].startswith("above ")
    assert found.to_dict()["estimates"]["A1"]["high"] is None


def test_a_rig_that_no_friction_moves_so_is_refused(tmp_path, clean):
    """A wrong number of the rig gave a table of noughts and exit status 0."""
    rig = dataclasses.replace(RIG, alpha1=1.6)
    with pytest.raises(
        ss.InputError, match=r"single periods differ .* spread: no friction moves this rig so"
    ):
        ss.identify(noisy(tmp_path, clean[:2], 6, (0.1, -0.1)), rig=rig)


def test_misfit_widens_the_intervals(tmp_path, clean):
    """Damping the declared model lacks: chi2 says so and no interval is that of noise alone."""
    damped = ss.Model(RIG, friction=TRUE, effects=[ss.effect("block_viscous_damping", c=0.9)])
    t = np.arange(0, 60.0, DT)
    runs = []
    for v in (0.1, -0.1):
        state = ss.simulate(damped, belt_speed=v, initial=(0.1, v, 0, 0), t_end=t[-1], t_eval=t).state
        runs.append(noisy(tmp_path, [(t, state)], 7, (v,))[0])
    found = ss.identify(runs, rig=RIG)
    clean_fit = ss.identify(noisy(tmp_path, clean[:2], 7, (0.1, -0.1)), rig=RIG)
    assert found.reduced_chi2 > clean_fit.reduced_chi2
    assert found.estimates["T_s_minus"].std > clean_fit.estimates["T_s_minus"].std


def test_derivatives_by_differences_and_by_the_core_give_the_same_fit():
    t, state = truth(0.1, 20.0)
    rng = np.random.default_rng(0)
    readings = state[:, [0, 2]] + NOISE * rng.standard_normal((len(t), 2))
    window = FitWindow(0, 0.1, t, readings, (0, 2), state[0].copy(), ("x1", "y1", "y2"))
    model, names = ss.Model(RIG, friction=TRUE), ("T_s_minus", "A2", "T_min_minus")

    def plain(model, *, belt_speed, initial, t_end, t_eval):
        return ss.simulate(model, belt_speed=belt_speed, initial=initial, t_end=t_end, t_eval=t_eval)

    noise = np.array([NOISE, NOISE])
    exact, differences = (
        shoot(model, [window], names, noise=noise, simulator=s) for s in (ss.simulate, plain)
    )
    np.testing.assert_allclose(exact.values, differences.values, rtol=1e-5)
    np.testing.assert_allclose(exact.covariance, differences.covariance, rtol=1e-3, atol=1e-12)


def test_force_points_lie_on_the_true_law(tmp_path, clean):
    found = ss.identify(noisy(tmp_path, clean[:2], 5, (0.1, -0.1)), rig=RIG)
    points = found.force
    inside = (points.mode != 0) & (np.abs(points.v_w) > 0.06) & (np.abs(points.v_w) < 0.2)
    error = points.T[inside] - TRUE.force(points.v_w[inside])
    assert inside.sum() > 100
    assert abs(np.median(error)) < 0.1
    assert np.std(error / points.T_std[inside]) < 2.5
    stick = points.mode == 0
    low, high = np.quantile(points.T[stick], [0.03, 0.97])  # a slow departure is seen late
    assert -TRUE.T_s_minus - 0.3 < low < -TRUE.T_s_minus + 1.5
    assert TRUE.T_s_plus - 1.5 < high < TRUE.T_s_plus + 0.3


@pytest.mark.parametrize("start", [(3.99, 2.99, 1.005), (3.0, 2.0, 1.5)])
def test_a_number_declared_as_zero_does_not_hold_the_others(tmp_path, start):
    """`quadratic` is 0, the least a law may have: a step below that follows the bound instead of ending the fit."""
    t = np.arange(0, 150, DT)
    true = ss.Model(RIG, friction=ss.HyperbolicFriction(scale=4, decay=3, constant=1))
    run = ss.simulate(true, belt_speed=0.1, initial=(0.1, 0.1, 0, 0), t_end=150, t_eval=t)
    runs = noisy(tmp_path, [(t, run.state)], 3, (0.1,))
    law = ss.HyperbolicFriction(scale=start[0], decay=start[1], constant=start[2])
    found = ss.identify(runs, rig=RIG, friction=law)
    assert found.reduced_chi2 == pytest.approx(1, abs=0.05)
    for name, value in {"scale": 4.0, "decay": 3.0, "constant": 1.0}.items():
        assert found.estimates[name].value == pytest.approx(value, abs=3 * found.estimates[name].std), name


def test_a_step_below_a_number_declared_as_zero_is_the_constrained_one():
    root = np.random.default_rng(2).standard_normal((6, 4))
    A, target, shared = root.T @ root, np.array([-3.0, -2.0, 1.0, 0.5]), np.array([0.5, 0.4, 3.0, 1.0])
    for declared in ([1.0, 0, 3, 0], [1.0, 0.4, 3, 0]):
        low = np.where(np.array(declared) == 0, -shared, -np.inf)
        known = lsq_linear(root, root @ target, (low, np.inf), tol=1e-14)
        step = above_zero(shared, target, A, -A @ target, np.array(declared))
        np.testing.assert_allclose(step, known.x, atol=1e-8)
        assert (step[1] == -0.4) == (declared[1] == 0)


def test_one_sentence_where_there_is_nothing_to_identify(tmp_path):
    rig = ss.BlockOnBelt()
    t = np.arange(0, 20, 0.01)
    run = recording(tmp_path, rig, t, 0.1 * t + 1e-3 * np.sin(77 * t), None, 0.1, "stuck", 1e-3)
    with pytest.raises(ss.InputError, match="0 slips found"):
        ss.identify(run, rig=rig)
    with pytest.raises(ss.InputError, match="rig is missing"):
        ss.identify(run)
    with pytest.raises(ss.InputError, match="too few"):
        track(t[:10], t[:10], belt_speed=0.1, noise=1e-3, period=6.0)


def test_bootstrap_of_correlated_events_is_wider():
    rng = np.random.default_rng(0)
    white = rng.standard_normal((400, 1))
    red = np.empty_like(white)
    red[0] = white[0]
    for i in range(1, len(white)):
        red[i] = 0.9 * red[i - 1] + np.sqrt(1 - 0.81) * white[i]
    assert correlation_length(white[:, 0]) < 2 < correlation_length(red[:, 0])
    assert block_bootstrap(white).std() == pytest.approx(1 / 20, rel=0.25)
    # the mean of n values correlated as 0.9^k varies as (1 + 0.9)/(1 - 0.9) independent ones
    assert 2.0 < block_bootstrap(red).std() / block_bootstrap(white).std() < 6.0
    assert effective_readings([white]) > 300
    assert effective_readings([red]) < 60


def test_every_law_says_which_numbers_belong_to_which_branch():
    assert law_parameters(ss.CoulombFriction())["plus"] == ("static", "kinetic")
    assert law_parameters(ss.CoulombFriction(static_plus=1.0, kinetic_plus=0.5))["plus"] == (
        "static_plus",
        "kinetic_plus",
    )
    assert "v_w_min" not in law_parameters(ss.PaperFriction())["minus"]


def test_covered_speeds_of_a_closed_form():
    """Slip from (1, v) under Coulomb friction reaches v + sqrt(A^2 + v^2)."""
    model = ss.Model(ss.BlockOnBelt(), friction=ss.CoulombFriction(static=1, kinetic=0.5))
    t = np.linspace(0, 8, 4001)
    window = FitWindow(0, 0.2, t, np.zeros((len(t), 1)), (0,), np.array([0.9, 0.2]), ("x1",))
    covered = covered_speeds(model, [window], ss.simulate)
    assert covered["plus"] is None
    assert covered["minus"][1] == pytest.approx(0.2 + np.hypot(0.5, 0.2), rel=1e-5)


@pytest.mark.skipif(
    not (SHARED / "cases" / "answers.json").exists(), reason="the recorded cases are not here"
)
@pytest.mark.parametrize("name", ["case_00", "case_01"])
def test_cases_without_an_effect_give_their_true_branches(name):
    answers = json.loads((SHARED / "cases" / "answers.json").read_text())["cases"]
    rig = next(c["rig"] for c in answers if c["case"] == name)
    keys = {
        "T_s_minus": "Ts_m",
        "A1": "A1",
        "A2": "A2",
        "t1": "t1",
        "t2": "t2",
        "T_min_minus": "Tmin_m",
        "T_s_plus": "Ts_p",
        "T_min_plus": "Tmin_p",
    }
    true = ss.PaperFriction(**{k: rig[v] for k, v in keys.items()})
    found = ss.identify(ss.load_case(SHARED / "cases" / name))
    for branch, sign in (("minus", -1), ("plus", 1)):
        u = np.linspace(*found.covered[branch], 500)
        low, _, high = found.band(branch, u)
        R = true.magnitude(sign * u)
        assert ((low <= R) & (high >= R)).all()
    for n in ("T_s_minus", "T_s_plus"):
        assert found.estimates[n].low <= getattr(true, n) <= found.estimates[n].high


@pytest.mark.sampled(2)
@pytest.mark.parametrize(
    ("friction", "plus", "words"),
    [
        ('kind = "coulomb"\nstatic = 7.0\nkinetic = 5.0', (7.0, 5.0), "the declared ones are kept"),
        (
            'kind = "coulomb"\nstatic = 7.0\nkinetic = 5.0\nstatic_plus = 3.0\nkinetic_plus = 2.0',
            (3.0, 2.0),
            "the declared ones are kept",
        ),
        ('kind = "coulomb"', None, "T_minus's are repeated, as its own are not declared"),
        ('kind = "coulomb"\nstatic = 1.0', None, "T_minus's are repeated, as its own are not declared"),
        ("none", None, "T_minus's are repeated, as its own are not declared"),
    ],
)
def test_the_direction_never_visited_is_declared_or_repeated_and_never_a_default(
    tmp_path, friction, plus, words
):
    found = ss.identify(case_of(rig_of(0.01), tmp_path, friction=friction, length=3.0))
    law = found.law
    assert (law.static, law.kinetic) == pytest.approx((STATIC, KINETIC), rel=1e-3)
    assert (law.static_plus, law.kinetic_plus) == (plus or (law.static, law.kinetic))
    assert f"branch T_plus was never visited: its numbers are unidentified, {words}" in found.messages
    assert set(found.unidentified) == {"static_plus", "kinetic_plus"}


def test_a_backward_belt_repeats_its_own_direction_where_the_other_is_not_declared(tmp_path):
    said = ("-10 mm/s", "-20 mm/s", "-30 mm/s")
    case = case_of(rig_of(0.01), tmp_path, said=said, friction='kind = "coulomb"', sign=-1.0, length=3.0)
    found = ss.identify(case)
    assert (found.law.static_plus, found.law.kinetic_plus) == pytest.approx((STATIC, KINETIC), rel=1e-3)
    assert (found.law.static, found.law.kinetic) == (found.law.static_plus, found.law.kinetic_plus)
    assert any("T_plus's are repeated" in one for one in found.messages)


def test_a_law_of_which_only_the_kind_is_given_has_no_size_to_hold_readings_against(tmp_path):
    case = case_of(rig_of(0.01), tmp_path, friction='kind = "coulomb"')
    assert case.undeclared == ("static", "kinetic", "static_plus", "kinetic_plus")
    assert (
        case_of(rig_of(0.01), tmp_path, friction='kind = "coulomb"\nstatic = 6.0').undeclared[0] == "kinetic"
    )
    assert case.findings == ()


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"belt_speed": "plateux"}, "belt_speed = 'plateux': must be one of set-point, plateau"),
        ({"noise": {"x7": 1.0}}, "noise = 'x7': must be one of x1"),
        ({"noise": {"x1": -1.0}}, "noise.x1 = -1.0: must be at least 0"),
        ({"scatter": "no"}, "scatter: must be a bool, not str"),
    ],
)
def test_an_option_that_would_be_taken_for_another_is_refused(tmp_path, options, words):
    """A misspelt belt speed was the set-point, the noise of a channel that is not there nobody's."""
    case = case_of(rig_of(0.02), tmp_path)
    with pytest.raises(ss.InputError, match=words):
        ss.identify(case, **options)


def test_a_comparison_refuses_a_misspelt_belt_speed(tmp_path):
    case = case_of(rig_of(0.02), tmp_path)
    with pytest.raises(ss.InputError, match="belt_speed = 'plateux': must be one of set-point, plateau"):
        ss.compare(case.model(), case.validate[0], belt_speed="plateux")


def test_a_run_on_another_rig_than_its_case_is_refused(tmp_path):
    """The other spring of a run was read and not used."""
    case = case_of(rig_of(0.02), tmp_path)
    other = dataclasses.replace(case.rig, stiffness=2 * case.rig.stiffness)
    runs = (dataclasses.replace(case.runs[0], rig=other), *case.runs[1:])
    with pytest.raises(ss.InputError, match=r"b10: \[\[run\]\] rig: one rig is taken for all runs"):
        ss.identify(dataclasses.replace(case, runs=runs))
