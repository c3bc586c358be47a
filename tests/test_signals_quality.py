"""Faults of channels and time bases, and the low-pass filters."""

import numpy as np
import pytest

from stick_slip_truth import coulomb
from stickslip.errors import InputError
from stickslip.measured.signals import (
    check_time_base,
    find_belt_speed,
    find_clipping,
    find_glitches,
    first_order,
    lowpass,
    noise_std,
    quantisation,
    remove_glitches,
)

RANDOM = np.random.default_rng(11)
TRUTH = coulomb(np.arange(4000) * 0.02 + 1.0)


class TestTimeBase:
    def test_a_regular_one_with_printed_digits_has_no_problem(self):
        base = check_time_base(np.round(np.arange(2501) * 0.003201361, 6))
        assert base.regular
        assert base.problems == []
        assert base.dt == pytest.approx(0.003201361, rel=1e-3)
        base.require_regular()

    def test_gaps_duplicates_backward_and_irregular_steps_are_each_said(self):
        t = np.arange(100.0)
        gap = np.delete(t, [40, 41, 42])
        base = check_time_base(gap)
        assert base.missing == 3
        assert base.gaps.tolist() == [[39.0, 43.0]]
        assert base.increasing
        assert "3 sample(s) missing, the first from t = 39 to 43" in base.problems[0]
        twice = np.insert(t, 10, 9.0)
        assert check_time_base(twice).duplicates.tolist() == [10]
        with pytest.raises(InputError, match="same time is given twice at sample 10"):
            check_time_base(twice).require_increasing()
        back = t.copy()
        back[50] = 20.0
        assert check_time_base(back).backward.tolist() == [50]
        assert "goes back at sample 50" in check_time_base(back).problems[0]
        jittered = t + 0.1 * np.sin(t)
        base = check_time_base(jittered)
        assert base.irregular.size > 50
        assert base.jitter == pytest.approx(np.std(np.diff(jittered)), rel=0.05)
        with pytest.raises(InputError, match="equally spaced"):
            base.require_regular()

    @pytest.mark.parametrize(
        ("t", "said"),
        [
            ([1.0], "at least 2"),
            ([0.0, np.nan, 1.0], r"t\[1\] is nan"),
            ([3.0, 2.0, 1.0], "never increases"),
            ([[0.0, 1.0]], "one channel"),
        ],
    )
    def test_what_is_no_time_base_is_refused(self, t, said):
        with pytest.raises(InputError, match=said):
            check_time_base(t)


class TestNoise:
    @pytest.mark.parametrize("sigma", [1e-3, 1e-2])
    def test_estimate_is_deaf_to_kinks_and_glitches(self, sigma):
        x = TRUTH.x + sigma * RANDOM.normal(size=TRUTH.x.size)
        assert noise_std(x) == pytest.approx(sigma, rel=0.06)
        x[::100] += 1.0
        assert noise_std(x) == pytest.approx(sigma, rel=0.12)

    def test_irregular_times_are_allowed_for(self):
        t = np.sort(RANDOM.uniform(0, 100, 5000))
        x = 1e3 * t - 3 * t**2 + 0.5 * RANDOM.normal(size=t.size)
        assert noise_std(x, t=t) == pytest.approx(0.5, rel=0.06)
        with pytest.raises(InputError, match="increase"):
            noise_std(x, t=t[::-1])


class TestGlitches:
    def test_false_alarms_stay_within_their_bound_and_near_it(self):
        x = RANDOM.normal(size=500_000)
        for rate in (1e-2, 1e-3, 1e-4):
            found = find_glitches(x, false_alarms=rate, noise=1.0).mask.mean()
            assert 0.3 * rate < found <= rate

    def test_planted_glitches_are_found_on_stick_slip_and_nothing_else(self):
        sigma = 1e-3
        x = TRUTH.x + sigma * RANDOM.normal(size=TRUTH.x.size)
        planted = np.arange(37, 3990, 61)
        spoiled = x.copy()
        spoiled[planted] += np.where(planted % 2, 1, -1) * RANDOM.uniform(10, 200, planted.size) * sigma
        found = find_glitches(spoiled)
        assert found.indices.tolist() == planted.tolist()
        mended = remove_glitches(spoiled, found)
        assert np.abs(mended - x).max() < 8 * sigma
        untouched = ~found.mask
        assert (mended[untouched] == spoiled[untouched]).all()

    def test_two_side_by_side_and_those_on_a_coarse_grid(self):
        x = 0.6e-3 * np.rint(TRUTH.x / 0.6e-3)
        x[1000] += 0.05
        x[1003] -= 0.03
        assert find_glitches(x).indices.tolist() == [1000, 1003]

    @pytest.mark.parametrize(("second", "least"), [(1.0, 25.0), (-1.0, 25.0), (0.6, 50.0)])
    def test_two_side_by_side_are_found_and_not_their_neighbours(self, second, least):
        sigma = 1e-3
        x = TRUTH.x + sigma * RANDOM.normal(size=TRUTH.x.size)
        sticks = [i for i in range(140, 3950, 67) if (TRUTH.mode[i - 60 : i + 60] == 0).all()]
        at = np.array(sticks)  # two in the midst of a slip may be motion
        assert len(at) > 10
        size = np.where(at % 2, 1, -1) * RANDOM.uniform(least, 4 * least, at.size) * sigma
        x[at] += size
        x[at + 1] += second * size
        assert find_glitches(x).indices.tolist() == sorted([*at, *(at + 1)])

    @pytest.mark.parametrize(
        ("x", "second", "share"),
        [
            (TRUTH.x, -1.0, 0.70),
            (TRUTH.x, 1.0, 0.75),
            (np.sin(np.arange(4000) * 2 * np.pi / 100), -1.0, 0.20),
        ],
        ids=["sticks and slips, of opposite sign", "of one sign", "a fast sine, of opposite sign"],
    )
    def test_two_of_fifteen_sigma_side_by_side_are_found_anywhere(self, x, second, share):
        sigma, random = 1e-3, np.random.default_rng(1)
        x = x + sigma * random.normal(size=x.size)
        assert not find_glitches(x, noise=sigma).mask.any()
        at = np.arange(20, 3980, 24)[:160]
        size = random.choice([-15.0, 15.0], at.size) * sigma
        x[at] += size
        x[at + 1] += second * size
        found = find_glitches(x, noise=sigma).mask
        assert np.mean(found[at] & found[at + 1]) > share
        if second < 0:
            assert not found[np.setdiff1d(np.arange(x.size), [*at, *(at + 1)])].any()

    @pytest.mark.parametrize("second", [1.0, -1.0])
    def test_two_with_a_good_one_between_are_found_and_that_is_kept(self, second):
        sigma, random = 1e-3, np.random.default_rng(1)
        x = TRUTH.x + sigma * random.normal(size=TRUTH.x.size)
        at = np.arange(20, 3980, 24)[:160]
        size = random.choice([-30.0, 30.0], at.size) * sigma
        x[at] += size
        x[at + 2] += second * size
        assert find_glitches(x, noise=sigma).indices.tolist() == sorted([*at, *(at + 2)])

    @pytest.mark.parametrize("size", [5.0, 10.0, 20.0])
    def test_a_jump_or_a_bend_is_no_two_glitches(self, size):
        sigma, random, t = 1e-3, np.random.default_rng(3), np.arange(4000)
        for places in range(2, 9):
            bends = np.abs(t % (24 + places) - 12.0 - places / 2)
            jumps = t // (20 + places) % 2
            for motion in (bends, jumps):
                found = find_glitches(sigma * (size * motion + random.normal(size=t.size)), noise=sigma).mask
                assert not (found[1:] & found[:-1]).any()

    def test_silent_channel_and_short_ones(self):
        x = np.zeros(200)
        assert not find_glitches(x).mask.any()
        x[77] = 1e-6
        assert find_glitches(x).indices.tolist() == [77]
        assert not find_glitches([1.0, 5.0, 1.0]).mask.any()

    def test_odd_numbers_are_refused(self):
        with pytest.raises(InputError, match="false_alarms"):
            find_glitches(np.zeros(20), false_alarms=0.0)
        with pytest.raises(InputError, match="noise"):
            find_glitches(np.zeros(20), noise=-1.0)
        with pytest.raises(InputError, match="found on a channel"):
            remove_glitches(np.zeros(20), find_glitches(np.zeros(21)))


class TestQuantisation:
    @pytest.mark.parametrize("step", [6e-4, 1e-2, 3.0])
    def test_step_of_a_rounded_noisy_channel(self, step):
        x = step * np.rint(RANDOM.normal(scale=20 * step, size=5000) / step) + 17 * step
        found = quantisation(x)
        assert found.step == pytest.approx(step, rel=1e-6)
        assert found.noise == pytest.approx(step / np.sqrt(12))
        assert found.fraction_on_grid == 1.0

    def test_rounding_noise_is_what_it_says(self):
        exact = RANDOM.normal(size=20_000)
        rounded = 0.05 * np.rint(exact / 0.05)
        assert np.std(rounded - exact) == pytest.approx(quantisation(rounded).noise, rel=0.02)

    def test_no_grid_no_step(self):
        assert quantisation(RANDOM.normal(size=3000)).step == 0.0
        assert quantisation([]).levels == 0
        assert quantisation(np.full(10, 2.0)).step == 0.0


class TestClipping:
    def test_limits_are_found(self):
        found = find_clipping(np.clip(TRUTH.x + 1e-3 * RANDOM.normal(size=4000), -0.02, 0.9))
        assert (found.low, found.high) == (-0.02, 0.9)
        assert found.mask.sum() > 100

    def test_one_side_only_and_infinities(self):
        found = find_clipping(np.where(TRUTH.x > 0.9, np.inf, TRUTH.x))
        assert found.low is None
        assert found.high == np.inf

    @pytest.mark.parametrize("grid", [0.0, 1e-3, 0.02])
    def test_a_smooth_extreme_is_no_limit(self, grid):
        x = np.sin(np.arange(5000) * 0.01) + 1e-3 * RANDOM.normal(size=5000)
        found = find_clipping(grid * np.rint(x / grid) if grid else x)
        assert found.low is None
        assert found.high is None


class TestLowpass:
    t = np.arange(4000) * 0.01

    @pytest.mark.parametrize("order", [2, 3, 4, 5])
    def test_lines_pass_late_by_the_delay_reported(self, order):
        line = 4.0 + 2.0 * self.t
        for zero_phase in (False, True):
            out = lowpass(line, 0.01, 2.0, order=order, zero_phase=zero_phase)
            middle = slice(1500, 2500)
            assert out.x[middle] == pytest.approx(4 + 2 * (self.t - out.delay)[middle], abs=2e-3)
            assert (out.delay == 0.0) == zero_phase

    def test_stop_band_is_stopped_and_channels_are_apart(self):
        fast = np.sin(2 * np.pi * 20 * self.t)
        both = np.column_stack([np.ones(4000), fast])
        for zero_phase in (False, True):
            out = lowpass(both, 0.01, 2.0, zero_phase=zero_phase).x
            assert out[:, 0] == pytest.approx(1.0, abs=1e-9)
            assert np.abs(out[1000:3000, 1]).max() < 1.1e-3

    @pytest.mark.parametrize(
        ("x", "keywords", "said"),
        [
            (np.zeros(100), {"cutoff": 50.0}, "half the sampling rate"),
            (np.zeros(100), {"cutoff": -1.0}, "cutoff"),
            (np.zeros(5), {"cutoff": 1.0}, "needs more than"),
            (np.zeros(100), {"cutoff": 1.0, "order": 0}, "order"),
            (np.array([0.0, np.nan]), {"cutoff": 1.0}, r"x\[1\] is nan"),
        ],
    )
    def test_what_it_cannot_do_is_said(self, x, keywords, said):
        with pytest.raises(InputError, match=said):
            lowpass(x, 0.01, **keywords)


class TestBeltSpeed:
    @pytest.mark.parametrize("gain", [0.85, 1.0, 1.16])
    def test_speed_of_the_sticks_near_a_wrong_set_point(self, gain):
        x = gain * TRUTH.x + 1e-3 * RANDOM.normal(size=TRUTH.x.size)
        found = find_belt_speed(TRUTH.t, x, 0.2)
        assert found.speed == pytest.approx(0.2 * gain, rel=0.005)
        assert found.std < 0.03 * 0.2
        assert found.share > 0.2

    def test_no_slope_near_is_said(self):
        with pytest.raises(InputError, match="no slope"):
            find_belt_speed(np.arange(50.0), np.zeros(50), 0.1, noise=1e-4)
        with pytest.raises(InputError, match="set-point"):
            find_belt_speed(np.arange(50.0), np.zeros(50), 0.0)


@pytest.mark.parametrize(
    ("call", "said"),
    [
        (lambda: first_order([0.0, 1.0], None, 1, 1), "a must be a finite number"),
        (lambda: first_order([0.0, 1.0], 0.5, "k", 1), "k0 must be a finite number"),
        (
            lambda: find_belt_speed(np.arange(20.0), np.arange(20.0), None),
            "set_point must be a finite",
        ),
        (lambda: lowpass(np.arange(200.0), 0.01, 1e-9), "far below one over the record"),
    ],
)
def test_numbers_that_are_none_are_refused_in_one_line(call, said) -> None:
    with pytest.raises(InputError, match=said):
        call()
