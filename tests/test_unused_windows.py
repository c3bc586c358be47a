"""What windows of runs never used say of a rig of bodies or matrices: their marginal likelihood, one by one."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

import stickslip as ss
from bodies_cases import CASES, recorded, recording
from stickslip.declared.uncertainty import Uncertainty
from stickslip.likelihoods.bodies_bench import bench_of
from stickslip.likelihoods.bodies_windows import BodiesWindows
from stickslip.likelihoods.contact_scatter import ContactScatter
from stickslip.likelihoods.fit import null
from stickslip.likelihoods.fit_state import Fit, soft
from stickslip.likelihoods.held_out import deviances, falls
from stickslip.likelihoods.policy import POLICY
from stickslip.likelihoods.shared import Declared

Floats = NDArray[np.float64]


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
    for sizes, noise in (((0.02, 0.02, 0.002), (1.0, 1.0)), ((0.03, 0.01, 0.001), (1.2, 0.9))):
        scatter = replace(fit.population, sizes=sizes)
        want, (found, explained) = (
            by_hand(fit, scatter, np.array(noise)),
            deviances(fit, scatter, np.array(noise)),
        )
        np.testing.assert_allclose(found - found[0], want - want[0], atol=0.05)
        assert explained.all()


def test_a_window_that_goes_astray_counts_by_its_logarithm() -> None:
    case = CASES["pin"]()
    t, read = recorded(case, 5, level=0.02, static=0.02, lasts=3.0)
    bench = bench_of(case.model, [recording(case, t, read)], Uncertainty.usual(case.model.rig))
    fit = null(BodiesWindows(case.model, bench.data, bench.stretches, [], Declared()), POLICY)
    assert fit.linear is not None
    usual, _ = deviances(fit, fit.population, fit.noise)
    gram = fit.linear.gram.copy()
    gram[0, :, -1, -1] += 1e6
    far = replace(fit, linear=replace(fit.linear, gram=gram))
    knee = POLICY.knee * fit.windows.sizes[0] * fit.windows.channels
    found, explained = deviances(far, fit.population, fit.noise)
    rise = found - usual
    left = float(soft(np.array([2e6]), np.array([knee]))[0])
    assert 0 < rise[0] < left
    np.testing.assert_allclose(rise[1:], 0.0, atol=1e-9)
    assert np.flatnonzero(~explained).tolist() == [0]
    lost = replace(fit, linear=replace(fit.linear, weight=np.where(np.arange(len(usual)) == 1, 0.0, 1.0)))
    assert np.flatnonzero(np.isnan(deviances(lost, fit.population, fit.noise)[0])).tolist() == [1]


def test_windows_that_neither_model_explains_speak_for_none() -> None:
    """Two windows gone astray under both weighed 450, all others 7."""
    was = np.array([515.0, 90.0, 91.0, np.nan, 300.0]), np.array([False, True, True, True, False])
    now = np.array([322.0, 89.0, 93.0, 80.0, 80.0]), np.array([False, True, False, True, True])
    assert falls(was, now) == [1.0, -2.0, 220.0]
