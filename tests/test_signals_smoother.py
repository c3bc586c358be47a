"""The smoother against motions known exactly, and against (3.1)."""

from functools import cache

import numpy as np
import pytest

from stick_slip_truth import Truth, coulomb, paper_rig
from stickslip.errors import InputError
from stickslip.measured.signals import Smoothed, derivatives, find_glitches, smooth

DT, SAMPLES = 0.04, 2000


@cache
def paper(belt_speed: float = 0.1, samples: int = SAMPLES) -> Truth:
    return paper_rig(np.arange(samples) * DT, belt_speed=belt_speed)


@cache
def block() -> Truth:
    return coulomb(np.arange(SAMPLES) * DT + 2.0)


def noisy(truth: Truth, sigma: float, seed: int = 0):
    return truth.x + sigma * np.random.default_rng(seed).normal(size=truth.t.size)


@cache
def smoothed(sigma: float, seed: int = 0) -> Smoothed:
    truth = paper()
    return smooth(truth.t, noisy(truth, sigma, seed), belt_speed=truth.belt_speed)


def rms(error):
    return float(np.sqrt(np.mean(np.square(error))))


def close_by(found, true, within):
    """Every instant found once, none invented."""
    assert found.size == true.size
    assert np.abs(found - true).max() < within


def test_the_truth_used_here_is_a_solution():
    for truth in (paper(), block()):
        inside = np.abs(np.diff(truth.mode, prepend=9)) + np.abs(np.diff(truth.mode, append=9)) == 0
        assert np.gradient(truth.x, truth.t)[inside] == pytest.approx(truth.v[inside], abs=2e-3)
        assert np.gradient(truth.v, truth.t)[inside] == pytest.approx(truth.a[inside], abs=2e-2)
        assert (truth.v[truth.mode == 0] == truth.belt_speed).all()


@pytest.mark.sampled(1)
@pytest.mark.parametrize("sigma", [0.0005, 0.001, 0.002])
def test_sticks_slips_and_instants_of_the_paper_rig(sigma):
    truth = paper()
    found = smoothed(sigma)
    assert found.noise == pytest.approx(sigma, rel=0.1)
    close_by(found.onsets, truth.onsets, 6 * DT)
    close_by(found.captures, truth.captures[truth.captures > DT], 2 * DT)
    assert np.mean(found.mode != truth.mode) < 0.015
    assert (found.slip_direction == -1).all()
    stuck = (found.mode == 0) & (truth.mode == 0)
    assert (found.v[stuck] == truth.belt_speed).all()
    assert not found.a[stuck].any()


def test_brief_slips_ahead_of_the_belt_are_found_and_none_is_invented():
    truth = paper(0.2, 2500)  # some captures do not hold: the block overshoots by 0.01 to 0.02
    found = smooth(truth.t, noisy(truth, 0.0008), belt_speed=truth.belt_speed)
    ahead = found.slips[found.slip_direction == 1]
    middle = np.searchsorted(truth.t, ahead.mean(axis=1))
    assert 4 <= len(ahead) < np.sum(np.diff(truth.mode) == 2)
    assert (truth.mode[middle] == 1).all()


@pytest.mark.parametrize("sigma", [0.0005, 0.001, 0.002])
def test_twice_as_good_as_the_best_that_the_recursion_can_do(sigma):
    truth = paper()
    x = noisy(truth, sigma)
    found = smoothed(sigma)
    best = {"v": np.inf, "a": np.inf}
    for tau in np.geomspace(0.02, 1.0, 12):
        d = derivatives(x, DT, tau)
        then = truth.t - d.lag_v
        for name in best:
            error = getattr(d, name) - np.interp(then, truth.t, getattr(truth, name))
            best[name] = min(best[name], rms(error[d.settled]))
    assert rms(found.v - truth.v) < 0.5 * best["v"]
    assert rms(found.a - truth.a) < 0.5 * best["a"]


@pytest.mark.sampled(1)
@pytest.mark.parametrize("seed", range(3))
def test_errors_are_as_large_as_reported(seed):
    truth = paper()
    found = smoothed(0.001, seed)
    slip = truth.mode != 0
    for name in "xva":
        error = getattr(found, name) - getattr(truth, name)
        assert 0.4 < rms(error[slip] / getattr(found, name + "_std")[slip]) < 1.5, name


@pytest.mark.study
def test_instants_are_as_doubtful_as_reported():
    truth = block()
    scores = []
    for seed in range(3):
        found = smooth(truth.t, noisy(truth, 0.002, seed), belt_speed=truth.belt_speed)
        for name in ("onset", "capture"):
            instants, true = getattr(found, name + "s"), getattr(truth, name + "s")
            nearest = true[np.abs(instants[:, None] - true).argmin(axis=1)]
            scores += [*((instants - nearest) / getattr(found, name + "_std"))]
    assert 0.5 < np.median(np.abs(scores)) / 0.6745 < 2.5


def test_acceleration_jumps_and_is_not_rounded():
    truth = block()
    found = smooth(truth.t, noisy(truth, 0.001), belt_speed=truth.belt_speed)
    before, after = (found.evaluate(found.onsets + side * 1e-6)[2] for side in (-1, 1))
    assert not before.any()
    assert after == pytest.approx(-0.5, abs=0.15)
    late = found.evaluate(found.captures - 1e-6)[2]
    assert late == pytest.approx(0.5, abs=0.15)
    assert 0.5 * (late.mean() - after.mean()) == pytest.approx(0.5, abs=0.06)


def test_irregular_times_gaps_and_glitches():
    truth = block()
    random = np.random.default_rng(3)
    t = np.sort(random.choice(np.arange(truth.t[0], truth.t[-1], 0.01), SAMPLES, replace=False))
    t = t[(t < 40) | (t > 40.5)]
    exact = coulomb(t)
    x = noisy(exact, 0.002)
    x[::50] += 0.3
    out = np.zeros(t.size, dtype=bool)
    out[::50] = True
    found = smooth(t, x, belt_speed=exact.belt_speed, outliers=out)
    assert found.t.size == t.size - out.sum()
    close_by(found.onsets, truth.onsets, 0.25)
    assert rms(found.v - exact.v[~out]) < 0.01
    regular = noisy(truth, 0.002)
    regular[::50] += 0.3
    marked = find_glitches(regular).mask
    assert marked[50::50].all()
    close_by(smooth(truth.t, regular, belt_speed=0.2, outliers=marked).onsets, truth.onsets, 0.2)


@pytest.mark.sampled(1)
@pytest.mark.parametrize("belt_speed", [0.06, 0.17])
def test_measured_belt_and_a_set_point_known_only_so_well(belt_speed):
    truth = paper(belt_speed)
    x = noisy(truth, 0.001)
    belt = belt_speed + 0.002 * np.random.default_rng(8).normal(size=x.size)
    measured = smooth(truth.t, x, belt=belt, stick_speed=0.01 * belt_speed)
    nominal = smooth(truth.t, x, belt_speed=1.01 * belt_speed, stick_speed=0.01 * belt_speed)
    for found in (measured, nominal):
        close_by(found.onsets, truth.onsets, 0.3)
        assert rms(found.v - truth.v) < 0.03 * belt_speed
        stuck = (found.mode == 0) & (truth.mode == 0)
        assert found.v[stuck] == pytest.approx(belt_speed, rel=0.02)


def test_belt_the_other_way_is_the_mirror_image():
    truth = block()
    x = noisy(truth, 0.002)
    ahead = smooth(truth.t, x, belt_speed=0.2)
    back = smooth(truth.t, -x, belt_speed=-0.2)
    assert back.v == pytest.approx(-ahead.v, abs=1e-6)
    assert (back.mode == -ahead.mode).all()


def test_units_do_not_matter():
    truth = block()
    x = noisy(truth, 0.002)
    plain = smooth(truth.t, x, belt_speed=0.2)
    scaled = smooth(truth.t / 1024, 32 * x, belt_speed=0.2 * 32 * 1024)  # powers of two: no rounding
    assert scaled.onsets == pytest.approx(plain.onsets / 1024, rel=1e-6)
    assert scaled.a / (32 * 1024**2) == pytest.approx(plain.a, abs=1e-3)
    assert scaled.jerk == pytest.approx(plain.jerk * 32**2 * 1024**5, rel=1e-3)


def test_a_slip_that_turns_over_without_sticking_is_split_there():
    """A motion over a belt at rest, one slip after the other."""
    t = np.arange(1500) * 0.04
    v = np.cos(t) + 0.3 * np.cos(3 * t)
    x = np.sin(t) + 0.1 * np.sin(3 * t) + 1e-3 * np.random.default_rng(2).normal(size=t.size)
    found = smooth(t, x, belt_speed=0.0)
    turns = np.pi * (np.arange(1, 20) - 0.5)
    turns = turns[turns < t[-1]]
    assert found.sticks.size == 0
    assert found.slips[1:, 0] == pytest.approx(turns, abs=0.1)
    assert (found.slip_direction[1:] == -found.slip_direction[:-1]).all()
    assert np.mean(found.mode != np.sign(v)) < 0.02


def test_a_channel_without_sticks_is_a_smoothing_spline():
    truth = paper()
    y = truth.y + 0.001 * np.random.default_rng(4).normal(size=truth.t.size)
    found = smooth(truth.t, y)
    assert found.mode is None
    assert found.onsets.size == 0
    assert rms(found.x - truth.y) < 4e-4
    score = (found.x - truth.y) / found.x_std
    assert 0.7 < rms(score) < 1.4
    speed = np.gradient(truth.y, truth.t)
    assert rms((found.v - speed)[5:-5]) < 2e-3


def test_all_stick_and_all_noise():
    t = np.arange(400) * 0.1
    noise = 0.01 * np.random.default_rng(6).normal(size=t.size)
    found = smooth(t, 3.0 + 0.5 * t + noise, belt_speed=0.5)
    assert (found.mode == 0).all()
    assert found.x == pytest.approx(3.0 + 0.5 * t, abs=0.003)
    assert found.sticks.tolist() == [[t[0], t[-1]]]
    drifting = smooth(t, 3.0 + 0.7 * t + noise, belt_speed=0.5)
    assert (drifting.mode == 1).all()
    assert drifting.v[50:-50] == pytest.approx(0.7, abs=0.02)


def test_evaluate_agrees_with_the_samples_and_keeps_to_the_record():
    truth = block()
    found = smooth(truth.t, noisy(truth, 0.002), belt_speed=0.2)
    x, v, a = found.evaluate(truth.t)
    assert x == pytest.approx(found.x, abs=1e-12)
    assert v == pytest.approx(found.v, abs=1e-12)
    assert a == pytest.approx(found.a, abs=1e-12)
    with pytest.raises(InputError, match="within the record"):
        found.evaluate([truth.t[-1] + 1.0])


@pytest.mark.parametrize(
    ("t", "x", "keywords", "said"),
    [
        (np.arange(5.0), np.zeros(5), {}, "at least 12"),
        (np.arange(20.0), np.zeros(21), {}, "one shape"),
        (np.arange(20.0)[::-1], np.zeros(20), {}, r"t must increase; t\[1\]"),
        (np.arange(20.0), np.full(20, np.nan), {}, r"x\[0\] is nan"),
        (np.arange(20.0), np.zeros(20), {"noise": -1.0}, "noise"),
        (np.arange(20.0), np.zeros(20), {"belt_speed": np.inf}, "belt_speed"),
        (np.arange(20.0), np.zeros(20), {"stick_speed": -0.1}, "stick_speed"),
        (np.arange(20.0), np.zeros(20), {"outliers": [True]}, "outliers"),
        (np.arange(20.0), np.zeros(20), {"belt": np.zeros(19)}, "one shape"),
    ],
)
def test_what_cannot_be_used_is_refused_in_one_line(t, x, keywords, said):
    with pytest.raises(InputError, match=said):
        smooth(t, x, **keywords)
