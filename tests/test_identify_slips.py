"""Slip by slip: laws of a block on a belt, told from single slips whose truth is known."""

from types import SimpleNamespace

import numpy as np
import pytest

import stickslip as ss
from recorded import recording
from slider import coulomb_record
from stickslip.fitted import decay
from stickslip.measured.sticks import plateau_speed, track


def slider(tmp_path, seed, noise=5e-4, slips=25, spread=0.05, dt=0.01):
    rng = np.random.default_rng(seed)
    static = 1.0 + spread * rng.standard_normal(slips)
    kinetic = 0.6 + 0.5 * spread * rng.standard_normal(slips)
    t, x, releases, captures = coulomb_record(static, kinetic, 0.1, dt)
    rig = ss.BlockOnBelt()
    run = recording(
        tmp_path, rig, t, x + noise * rng.standard_normal(len(t)), None, 0.1, f"slider{seed}", noise
    )
    return rig, run, static, kinetic, releases, captures


@pytest.fixture(scope="module")
def slips(tmp_path_factory):
    rig, run, *true = slider(tmp_path_factory.mktemp("slips"), 2, slips=10, dt=0.05)
    return ss.identify(run, rig=rig), *true


def test_levels_of_every_slip_are_found(slips):
    found, static, kinetic, releases, _ = slips
    assert isinstance(found.law, ss.CoulombFriction)
    assert len(found.events.t) >= len(static) - 2  # the first and the last have no stick on both sides
    index = [int(np.argmin(np.abs(releases - t))) for t in found.events.t]
    np.testing.assert_allclose(found.events.static, static[index], atol=2e-3)
    np.testing.assert_allclose(found.events.kinetic, kinetic[index], atol=2e-3)


def test_scatter_between_slips_sets_the_interval_of_the_mean(slips):
    found, static, *_ = slips
    mean = found.estimates["static"]
    assert mean.low < 1.0 < mean.high
    expected = static.std(ddof=1) / np.sqrt(len(static))
    assert 0.6 * expected < mean.std < 1.7 * expected
    assert found.estimates["static_plus"].status == "unidentified"
    assert found.covered["plus"] is None


def coulomb_run(tmp_path, belt_speed, t_end, dt, noise, seed=0, start=0.0):
    rig = ss.BlockOnBelt(mass=1.2, stiffness=850, damping=0.6)
    model = ss.Model(rig, friction=ss.CoulombFriction(static=6, kinetic=4.2))
    t = np.arange(0, t_end, dt)
    run = ss.simulate(model, belt_speed=belt_speed, initial=(start, belt_speed), t_end=t_end, t_eval=t)
    x = run.state[:, 0] + np.random.default_rng(seed).normal(0, noise, len(t))
    path = tmp_path / "run.csv"
    np.savetxt(path, np.c_[t, x], delimiter=",", header="t,x1", comments="", fmt="%.12g")
    channels = {"t": ss.Channel("t", unit="s"), "x1": ss.Channel("x1", unit="m")}
    return ss.load_recording(path, rig, channels=channels, belt_speed=belt_speed), run.transitions


@pytest.mark.study
def test_a_swing_that_only_touches_the_speed_of_the_belt_is_no_slip(tmp_path):
    """The block slips once and never sticks again: no levels can be told, and none are."""
    recording, transitions = coulomb_run(tmp_path, belt_speed=0.2, t_end=6, dt=0.001, noise=2e-6)
    assert len(transitions.t) == 1
    with pytest.raises(
        ss.InputError, match=r"0 slips found; .* most are not met by a slip that ends in stick"
    ):
        ss.identify(recording, rig=recording.rig)


@pytest.mark.sampled(1)
@pytest.mark.parametrize("seed", range(2))
def test_levels_on_a_slow_belt_are_not_drawn_up_by_noise(tmp_path, seed):
    """Noise of a twentieth of a slip is half a second of creep; the slip lasts a quarter of that."""
    recording, transitions = coulomb_run(
        tmp_path, belt_speed=1e-3, t_end=60, dt=0.002, noise=2e-4, seed=seed, start=0.004
    )
    found = ss.identify(recording, rig=recording.rig)
    assert len(found.events.t) == (len(transitions.t) - 1) // 2 + 1 == 14
    assert 0.9 < found.reduced_chi2 < 1.1
    for name, truth in (("static", 6.0), ("kinetic", 4.2)):
        assert found.estimates[name].value == pytest.approx(truth, rel=0.005)


def test_friction_that_falls_with_speed_is_told_from_coulomb(tmp_path):
    rig = ss.BlockOnBelt()
    law = ss.HyperbolicFriction(scale=0.6, decay=2.0, constant=0.4)
    t = np.arange(0, 120, 0.01)
    model = ss.Model(rig, friction=law)
    state = ss.simulate(model, belt_speed=0.1, initial=(0.5, 0.1), t_end=t[-1], t_eval=t).state
    x = state[:, 0] + 5e-4 * np.random.default_rng(0).standard_normal(len(t))
    found = ss.identify(recording(tmp_path, rig, t, x, None, 0.1, "hyperbolic", 5e-4), rig=rig)
    assert isinstance(found.law, ss.HyperbolicFriction)
    u = np.linspace(0, 0.9 * found.covered["minus"][1], 50)
    np.testing.assert_allclose(found.law.magnitude(-u), law.magnitude(-u), atol=0.02)


@pytest.mark.study
@pytest.mark.parametrize(
    ("law", "noise", "lasts"),
    [((1.0, 3.0, 0.3), 3e-3, 100), ((1.0, 3.0, 0.0), 1e-3, 150), ((0.7, 8.0, 0.3), 1e-3, 100)],
)
def test_a_hyperbolic_law_is_found_slip_by_slip(tmp_path, law, noise, lasts):
    """The decay that all slips share is told as well as the readings tell it; 0.2 % where they are clean."""
    scale, decay, constant = law
    t = np.arange(0, lasts, 0.02)
    true = ss.HyperbolicFriction(scale=scale, decay=decay, constant=constant)
    model = ss.Model(ss.BlockOnBelt(), friction=true)
    run = ss.simulate(model, belt_speed=0.2, initial=(0, 0.2), t_end=lasts, t_eval=t)
    x = run.state[:, 0] + noise * np.random.default_rng(1).standard_normal(len(t))
    found = ss.identify(
        recording(tmp_path, ss.BlockOnBelt(), t, x, None, 0.2, "hyperbolic", noise), rig=ss.BlockOnBelt()
    )
    assert found.law.decay == pytest.approx(decay, rel=0.005)
    assert found.law.constant + found.law.scale == pytest.approx(scale + constant, rel=0.002)
    assert found.reduced_chi2 == pytest.approx(1, abs=0.06)
    if constant:  # inside its bounds
        for name, value in zip(("scale", "decay", "constant"), law, strict=True):
            one = found.estimates[name]
            assert one.low <= value <= one.high, name


@pytest.mark.parametrize("true", [0.004, 0.2, 300.0])
def test_the_decay_is_sought_beyond_the_range_that_it_begins_with(true):
    noise = np.random.default_rng(0).standard_normal((100, 1))
    coulomb = SimpleNamespace(windows=[None], residuals=[noise])

    def fitted(at, *_):
        return SimpleNamespace(windows=[None], residuals=[noise * np.exp(np.log(at / true) ** 2)])

    _, found, _ = decay.profiled(1.0, coulomb, fitted, lambda *_: None)
    assert found == pytest.approx(true, rel=1e-6)


def test_modes_and_transition_times_of_a_closed_form(tmp_path):
    _, run, _, _, releases, captures = slider(tmp_path, 3)
    found = track(run.t, run.x1, belt_speed=0.1, noise=5e-4, period=2 * np.pi)
    assert len(found.releases) == len(releases)
    np.testing.assert_allclose(found.releases, releases, atol=0.12)
    np.testing.assert_allclose(found.captures, captures, atol=0.12)
    speed, std = plateau_speed(found, run.x1, 5e-4)
    assert abs(speed - 0.1) < 4 * std + 2e-4
