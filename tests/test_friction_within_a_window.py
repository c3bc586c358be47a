"""Friction that changes within an event, on rigs of bodies and matrices: what windows have of it, and unused runs."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

import stickslip as ss
from bodies_cases import CASES, recorded, recording
from stickslip.declared.formula.value import value
from stickslip.declared.uncertainty import Uncertainty
from stickslip.likelihoods.bodies_bench import bench_of
from stickslip.likelihoods.bodies_windows import BodiesWindows
from stickslip.likelihoods.contact_scatter import ContactScatter, scattering
from stickslip.likelihoods.fit import null
from stickslip.likelihoods.fit_state import Fit, soft
from stickslip.likelihoods.held_out import deviances
from stickslip.likelihoods.policy import POLICY
from stickslip.likelihoods.shared import Declared

Floats = NDArray[np.float64]
WAVE, OFTEN = 0.03, 10.0  # of friction, and how often it comes: slower than a window, faster than a run


def test_a_window_s_law_grows_from_its_middle_to_its_end() -> None:
    law = scattering(ss.StribeckFriction(F_c=3.0, F_s=5.0, v_s=0.2).form(), 1)
    own = {
        "own_kinetic_1": 0.1,
        "own_static_1": -0.05,
        "own_change_1": 0.03,
        "own_middle_1": 2.0,
        "own_rate_1": 4.0,
    }
    for t, along in ((1.75, -1.0), (2.0, 0.0), (2.25, 1.0)):
        of = {**law.numbers, **own, "u": 0.5, "t": t, "dwell": 0.0}
        level, static = 1.1 + 0.03 * along, 0.95 * 5.0
        assert law.plus.static is not None
        assert law.plus.kinetic is not None
        assert float(value(law.plus.static, of)) == pytest.approx(level * static, rel=1e-14)
        slides = 3.0 + (static - 3.0) * np.exp(-2.5)
        assert float(value(law.plus.kinetic, of)) == pytest.approx(level * slides, rel=1e-14)


def windows(model: ss.Model, **effects: float) -> BodiesWindows:
    """Windows of the pin under its plain law; friction swings by so much where it is asked to."""
    case = CASES["pin"]()
    wave = (
        [ss.effect("formula", called="wave", where="contact_1", factor="1 + a*sin(w*t)", **effects)]
        if effects
        else []
    )
    t = np.arange(0.0, case.settling + 6.0, case.dt)
    run = ss.simulate(
        case.model.with_effects(wave),
        **case.speeds,
        initial=case.initial,
        t_end=t[-1],
        t_eval=t,
        rtol=1e-9,
        atol=1e-12,
    )  # type: ignore[arg-type]
    kept = t >= case.settling
    read = run.state[kept][:, :2] + case.noise * np.random.default_rng(3).standard_normal(
        (int(kept.sum()), 2)
    )
    one = recording(case, t[kept] - case.settling, read)
    return bench_of(model, [one], Uncertainty.usual(model.rig, channels=case.channels)).windows()


def test_what_friction_does_within_a_window_is_found() -> None:
    own = windows(CASES["pin"]().model, a=WAVE, w=OFTEN)
    fit = null(own, POLICY)
    found = dict(zip(fit.population.names, fit.population.sizes, strict=True))
    data = own.data[0]
    half = 0.5 * float(np.median([data.t[w.stop - 1] - data.t[w.start] for w in own.stretches]))
    assert found["friction.kinetic"] == pytest.approx(WAVE / 2**0.5, rel=0.35)
    assert found["friction.change"] == pytest.approx(WAVE * OFTEN * half / 2**0.5, rel=0.35)
    middles = (
        np.array([0.5 * (data.t[w.start] + data.t[w.stop - 1]) for w in own.stretches])
        + CASES["pin"]().settling
    )
    kinetic, change = own.changes[0]
    at = fit.random
    assert np.corrcoef(at[:, kinetic], np.sin(OFTEN * middles))[0, 1] > 0.9
    assert np.corrcoef(at[:, change], np.cos(OFTEN * middles))[0, 1] > 0.9


def test_friction_that_repeats_changes_in_no_window() -> None:
    fit = null(windows(CASES["pin"]().model), POLICY)
    found = dict(zip(fit.population.names, fit.population.sizes, strict=True))
    assert found["friction.change"] < 2e-3
    assert found["friction.kinetic"] < 2e-3


def by_hand(fit: Fit, scatter: ContactScatter, noise: Floats) -> Floats:
    """-2 log marginal likelihood of each window by its whole covariance, what its start may be integrated out."""
    out = []
    sizes = np.array([scatter.sizes[k] for k in scatter.of])
    for i, block in enumerate(fit.blocks):
        assert block is not None
        begins = fit.windows.begins
        whole = (block / np.sqrt(noise)[None, :, None]).reshape(-1, block.shape[2])
        S, K = whole[:, :begins], whole[:, begins:-1]
        r = whole[:, -1] + K @ fit.random[i]
        V = np.eye(len(r)) + (K * sizes**2) @ K.T
        inverse = np.linalg.inv(V)
        inner = S.T @ inverse @ S + 1e-12 * np.eye(begins)
        pull = S.T @ inverse @ r
        chi = r @ inverse @ r - pull @ np.linalg.solve(inner, pull)
        volume = np.linalg.slogdet(V)[1] + np.linalg.slogdet(inner)[1] + len(block) * np.log(noise).sum()
        out.append(chi + volume)
    return np.array(out)


def test_what_unused_windows_say_is_their_whole_likelihood() -> None:
    case = CASES["pin"]()
    model = ss.Model(case.model.rig, friction=ss.CoulombFriction(static=4.1, kinetic=1.97))
    t, read = recorded(case, 5, level=0.02, static=0.02, lasts=3.0)
    bench = bench_of(model, [recording(case, t, read)], Uncertainty.usual(case.model.rig))
    fit = null(BodiesWindows(model, bench.data, bench.stretches, [], Declared()), POLICY)
    for sizes, noise in (((0.02, 0.02, 0.01, 0.002), (1.0, 1.0)), ((0.03, 0.01, 0.004, 0.001), (1.2, 0.9))):
        scatter = replace(fit.population, sizes=sizes)
        want, found = by_hand(fit, scatter, np.array(noise)), deviances(fit, scatter, np.array(noise))
        np.testing.assert_allclose(found - found[0], want - want[0], atol=0.05)


def test_a_window_that_goes_astray_counts_by_its_logarithm() -> None:
    case = CASES["pin"]()
    t, read = recorded(case, 5, level=0.02, static=0.02, lasts=3.0)
    bench = bench_of(case.model, [recording(case, t, read)], Uncertainty.usual(case.model.rig))
    fit = null(BodiesWindows(case.model, bench.data, bench.stretches, [], Declared()), POLICY)
    assert fit.linear is not None
    usual = deviances(fit, fit.population, fit.noise)
    gram = fit.linear.gram.copy()
    gram[0, :, -1, -1] += 1e6
    far = replace(fit, linear=replace(fit.linear, gram=gram))
    knee = POLICY.knee * fit.windows.sizes[0] * fit.windows.channels
    rise = deviances(far, fit.population, fit.noise) - usual
    left = float(soft(np.array([2e6]), np.array([knee]))[0])
    assert 0 < rise[0] < left
    np.testing.assert_allclose(rise[1:], 0.0, atol=1e-9)
    lost = replace(fit, linear=replace(fit.linear, weight=np.where(np.arange(len(usual)) == 1, 0.0, 1.0)))
    assert np.flatnonzero(np.isnan(deviances(lost, fit.population, fit.noise))).tolist() == [1]
