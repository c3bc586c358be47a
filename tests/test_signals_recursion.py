"""(3.1), the differentiators made of it and the chain of two."""

import numpy as np
import pytest
from scipy import signal

from stickslip import signals
from stickslip.errors import InputError
from stickslip.measured.signals import derivatives, differentiate, differentiator, first_order

RULES = ["tustin", "backward-euler", "ramp-invariant"]


def plain(x, a, k0, k1):
    y = np.zeros(np.shape(x), dtype=np.longdouble)
    for n in range(1, len(x)):
        y[n] = a * y[n - 1] + k0 * x[n] + k1 * x[n - 1]
    return y


@pytest.mark.parametrize("channels", [None, 1, 2, 3, 4, 5, 7, 8, 9, 20])
@pytest.mark.parametrize("n", [1, 2, 9, 1000])
def test_agrees_with_the_plain_loop_and_with_lfilter(channels, n):
    shape = (n,) if channels is None else (n, channels)
    x = np.random.default_rng(1).normal(size=shape)
    a, k0, k1 = 0.93, 4.0, -3.5
    y = first_order(x, a, k0, k1)
    assert y.dtype == np.float64
    bound = 8 * np.finfo(float).eps * (k0 - k1) * np.abs(x).max() / (1 - a)
    assert np.abs(y - plain(x, a, k0, k1)).max() <= bound
    rival = signal.lfilter([k0, k1], [1.0, -a], x, axis=0, zi=-k0 * x[:1])[0]
    assert np.abs(y - rival).max() <= bound


def test_a_long_slow_recursion_keeps_the_error_of_the_plain_loop():
    x = np.random.default_rng(2).normal(size=200_000).cumsum() + 1e6
    d = differentiator(1e-4, 0.5)
    y, truth = first_order(x, d.a, d.k0, d.k1), plain(np.longdouble(1) * x, d.a, d.k0, d.k1)
    assert np.abs(y - truth).max() <= 4 * np.finfo(float).eps * d.k0 * np.abs(np.diff(x)).max() / (1 - d.a)


@pytest.mark.parametrize("dtype", ["f4", "i2", "u1", "?", "f2", "g", "O", ">f8"])
def test_any_real_dtype_and_any_stride(dtype):
    full = (np.arange(120).reshape(20, 6) % 7).astype(dtype)
    for view in (full[::3], full[:, ::2], full[::-1], full.T, full[:, 2], np.asfortranarray(full)):
        given = first_order(view, 0.5, 1.0, 2.0)
        assert np.allclose(given, plain(view.astype(float), 0.5, 1.0, 2.0).astype(float), rtol=0, atol=1e-12)
        assert given.shape == view.shape


def test_nothing_and_next_to_nothing():
    assert first_order([], 0.5, 1, -1).shape == (0,)
    assert first_order(np.zeros((0, 3)), 0.5, 1, -1).shape == (0, 3)
    assert first_order(np.zeros((4, 0)), 0.5, 1, -1).shape == (4, 0)
    assert first_order([7.0], 0.5, 1, -1).tolist() == [0.0]
    assert first_order([7.0, 9.0], 0.5, 2, 3).tolist() == [0.0, 39.0]


@pytest.mark.parametrize(
    ("x", "a", "said"),
    [
        ([1.0, np.nan, 2.0], 0.5, r"x\[1\] is nan"),
        ([[1.0, 2.0], [3.0, np.inf]], 0.5, r"x\[1, 1\] is inf"),
        ([1.0, 2.0], 1.0, "unstable"),
        ([1.0, 2.0], -1.5, "unstable"),
        ([1.0, 2.0], np.nan, "a must be a finite number"),
        (["1", "2"], 0.5, "real numbers"),
        ([1j, 2], 0.5, "real numbers"),
        (np.zeros((2, 2, 2)), 0.5, "shape"),
        (3.0, 0.5, "shape"),
    ],
)
def test_what_cannot_be_used_is_refused_in_one_line(x, a, said):
    with pytest.raises(InputError, match=said) as caught:
        first_order(x, a, 1.0, -1.0)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("rule", RULES)
@pytest.mark.parametrize("tau", [0.003, 0.02, 0.5])
class TestDifferentiator:
    h = 0.01

    def test_a_line_has_its_slope_and_a_constant_nothing(self, rule, tau):
        d = differentiator(self.h, tau, rule)
        assert d.k1 == -d.k0
        n = 5 + d.settling(1e-13)
        t = np.arange(n) * self.h
        assert differentiate(3.0 - 2.5 * t, self.h, tau, rule)[-1] == pytest.approx(-2.5, rel=1e-10)
        assert not differentiate(np.full(n, 1e7 / 3), self.h, tau, rule).any()

    def test_lag_and_gain_are_those_of_the_frequency_response(self, rule, tau):
        d = differentiator(self.h, tau, rule)
        w = np.array([0.01, 0.1, 1.0, 10.0, 100.0, 250.0])
        response = signal.freqz([d.k0, d.k1], [1, -d.a], worN=w * self.h)[1] / (1j * w)
        assert d.gain(w) == pytest.approx(np.abs(response), rel=1e-7)
        assert d.phase_delay(w) == pytest.approx(-np.unwrap(np.angle(response)) / w, rel=1e-5)
        assert d.phase_delay(1e-3) == pytest.approx(d.delay, rel=1e-5)

    def test_the_lag_is_the_documented_one(self, rule, tau):
        expected = {
            "tustin": tau,
            "backward-euler": tau + self.h / 2,
            "ramp-invariant": self.h / 2 / np.tanh(self.h / (2 * tau)),
        }[rule]
        assert differentiator(self.h, tau, rule).delay == pytest.approx(expected, rel=1e-12)

    def test_noise_gain_is_the_energy_of_the_impulse_response(self, rule, tau):
        d = differentiator(self.h, tau, rule)
        impulse = np.zeros(20 + 2 * d.settling(1e-12))
        impulse[2] = 1.0
        once = differentiate(impulse, self.h, tau, rule)
        twice = differentiate(once, self.h, tau, rule)
        assert d.noise_gain(1) == pytest.approx(np.linalg.norm(once), rel=1e-9)
        assert d.noise_gain(2) == pytest.approx(np.linalg.norm(twice), rel=1e-9)

    def test_rule_realises_its_definition(self, rule, tau):
        d = differentiator(self.h, tau, rule)
        t = np.arange(40) * self.h
        if rule == "ramp-invariant":  # exact for a line switched on: 1 - exp(-t/tau)
            assert differentiate(t, self.h, tau, rule) == pytest.approx(1 - np.exp(-t / tau), abs=1e-12)
            return
        z = np.exp(1j * np.array([0.1, 1.0, 2.5]))
        s = (1 - 1 / z) / self.h if rule == "backward-euler" else 2 / self.h * (z - 1) / (z + 1)
        assert d.k0 * (1 - 1 / z) / (1 - d.a / z) == pytest.approx(s / (1 + tau * s), rel=1e-12)


def test_constants_that_make_no_differentiator_are_refused():
    for dt, tau, rule, said in [
        (0.0, 1.0, "tustin", "dt"),
        (-1.0, 1.0, "tustin", "dt"),
        (1.0, 0.0, "tustin", "tau"),
        (1.0, -2.0, "ramp-invariant", "tau"),
        (1.0, np.nan, "backward-euler", "tau"),
        (1.0, 1.0, "forward", "backward-euler"),
        (1e-30, 1.0, "tustin", "out of proportion"),
    ]:
        with pytest.raises(InputError, match=said):
            differentiator(dt, tau, rule)
    assert differentiator(0.5, 0.0, "backward-euler").a == 0.0
    with pytest.raises(InputError, match="order"):
        differentiator(1.0, 1.0).noise_gain(3)


@pytest.mark.parametrize("rule", RULES)
class TestChain:
    t = np.arange(4000) * 0.01
    x = 5.0 + 0.3 * t + np.sin(2.0 * t)
    tau = 0.05

    def truth(self, at):
        return 5 + 0.3 * at + np.sin(2 * at), 0.3 + 2 * np.cos(2 * at), -4 * np.sin(2 * at)

    def test_each_signal_is_late_by_the_lag_reported(self, rule):
        for align in ("match", "shift", "none"):
            d = derivatives(self.x, 0.01, self.tau, rule=rule, align=align)
            lags = (d.lag_x, d.lag_v, d.lag_a)
            for got, lag, order in zip((d.x, d.v, d.a), lags, range(3), strict=True):
                right = self.truth(self.t - lag)[order]
                assert np.abs(got - right)[d.settled].max() < 0.025 * np.ptp(right), (align, order)

    def test_matched_signals_have_no_phase_against_each_other(self, rule):
        d = derivatives(self.x - 0.3 * self.t, 0.01, self.tau, rule=rule)
        v, a = d.v[d.settled], d.a[d.settled]
        assert d.lag_x == d.lag_v == d.lag_a == pytest.approx(2 * d.differentiator.delay)
        quarter = np.dot(v, a) / np.linalg.norm(v) / np.linalg.norm(a)
        late = derivatives(self.x - 0.3 * self.t, 0.01, self.tau, rule=rule, align="none")
        spurious = np.dot(late.v[late.settled], late.a[late.settled])
        spurious /= np.linalg.norm(late.v[late.settled]) * np.linalg.norm(late.a[late.settled])
        assert abs(quarter) < 0.01 < 0.08 < abs(spurious)  # v and a of a sine are orthogonal

    def test_noise_comes_out_as_strong_as_reported(self, rule):
        noise = np.random.default_rng(5).normal(size=200_000)
        for align in ("match", "none"):
            d = derivatives(noise, 0.01, self.tau, rule=rule, align=align)
            for got, gain in ((d.x, d.noise_gain_x), (d.v, d.noise_gain_v), (d.a, d.noise_gain_a)):
                assert got[d.settled].std() == pytest.approx(gain, rel=0.02)


def test_damping_that_is_not_there_comes_from_lag_and_goes_with_it():
    """x'' + x = 0 has no damping; unaligned signals show the force ``2 delay x'``."""
    x = np.sin(np.arange(20_000) * 0.01)

    def damping(align):
        d = derivatives(x, 0.01, 0.1, align=align)
        force, v = (d.a + d.x)[d.settled], d.v[d.settled]
        return np.dot(force, v) / np.dot(v, v)

    assert damping("none") == pytest.approx(0.2, rel=0.02)
    assert abs(damping("match")) < 1e-4
    assert abs(damping("shift")) < 2 * (0.1 * 1.0) ** 3  # right to the next order in omega tau only


def test_a_marked_glitch_leaves_the_chain_alone():
    x = np.sin(np.arange(500) * 0.02)
    spoiled = x.copy()
    spoiled[250] += 1.0
    glitches = signals.find_glitches(spoiled)
    clean = derivatives(x, 0.02, 0.1).a
    assert np.abs(derivatives(spoiled, 0.02, 0.1).a - clean).max() > 50
    assert np.abs(derivatives(spoiled, 0.02, 0.1, glitches=glitches).a - clean).max() < 1e-3


def test_chain_refuses_what_it_cannot_align():
    with pytest.raises(InputError, match="align"):
        derivatives([1.0, 2.0, 3.0], 0.1, 0.1, align="centre")
    with pytest.raises(InputError, match="at least 2"):
        derivatives([1.0], 0.1, 0.1)
