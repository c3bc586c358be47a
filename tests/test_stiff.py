"""Parameters that make the equations stiff: a bound on steps, and a lag that does not set them."""

import numpy as np
import pytest
import scipy

import stickslip as ss
from stickslip.errors import InputError
from stickslip.simulated.trajectory import Status

RIG = ss.Rig(alpha1=16, alpha2=8, beta3=4, eta1=0.1, eta12=0.2)
START = (0.1, 0.1, 0, 0)


def run(*effects: ss.Effect, rig: ss.Rig = RIG, **settings: object) -> ss.Trajectory:
    model = ss.Model(rig, friction=ss.PaperFriction(), effects=list(effects))
    given = {"belt_speed": 0.1, "initial": START, "t_end": 10.0} | settings
    return ss.simulate(model, **given)  # type: ignore[arg-type]


@pytest.mark.parametrize(
    "effects", [[ss.effect("friction_memory", tau=1e-9)], [ss.effect("belt_load_droop", k=0.01, tau=1e-9)]]
)
def test_stiff_effects_end_after_max_steps(effects):
    told = run(*effects, max_steps=2000)
    assert told.status is Status.too_many_steps
    assert not told.status.ok
    assert "max_steps" in told.status.value
    assert told.steps == 2000
    assert len(told.t) > 1000
    assert np.all(np.diff(told.t) > 0)
    assert np.isfinite(told.state).all()


def test_a_stiff_leg_ends_after_max_steps_and_keeps_the_samples_before():
    times = np.linspace(0, 10, 10001)
    stiff = ss.Rig(alpha1=16, alpha2=1e-8, beta3=4, eta1=0.1, eta12=0.2)
    told = run(rig=stiff, t_eval=times, max_steps=30000)
    assert told.status is Status.too_many_steps
    assert 0 < len(told.t) < len(times)
    np.testing.assert_array_equal(told.t, times[: len(told.t)])


def test_max_steps_is_beyond_what_a_run_needs():
    free = run(t_end=100.0)
    assert free.status.ok
    assert run(t_end=100.0, max_steps=free.steps).status.ok
    short = run(t_end=100.0, max_steps=free.steps - 1)
    assert short.status is Status.too_many_steps
    assert "the run is long" in short.status.value  # nothing is stiff here


@pytest.mark.parametrize("lanes", [True, False])
def test_a_sweep_gives_up_stiff_members_alone(lanes):
    model = ss.Model(RIG, friction=ss.PaperFriction())
    over = {"alpha2": [8.0, 1e-8, 7.0, 1e-9, 6.0]}
    settings = {"belt_speed": 0.1, "initial": START, "t_end": 40, "lanes": lanes}
    ds = ss.sweep(model, over, max_steps=5000, **settings)
    flags = dict(zip(ds.status.flag_values, ds.status.flag_meanings.split(), strict=True))
    told = [flags[int(flag)] for flag in ds.status]
    assert told == ["finished", "too_many_steps", "finished", "too_many_steps", "finished"]
    assert np.isfinite(ds.final_state.values).all()
    alone = ss.sweep(model, {"alpha2": [8.0, 7.0, 6.0]}, **settings)
    np.testing.assert_allclose(ds.final_state[[0, 2, 4]], alone.final_state, atol=1e-12)


@pytest.mark.parametrize("tau", [1e-12, 1e-9, 1e-4, 0.02, 0.1, 0.5, 3.0])
def test_a_lag_does_not_set_the_steps_and_follows_its_equation(tau):
    """tau m' = x1 - m along the motion, in closed form where x1 is a line between dense times."""
    plain = run(t_end=20.0)
    times = np.linspace(0, 20, 401)
    lagged = run(ss.effect("sensor_lag", tau=tau), t_end=20.0, t_eval=times, initial=(*START, 0, 0, 0, 0.3))
    assert lagged.steps < 12 * plain.steps
    np.testing.assert_allclose(lagged.transitions.t, plain.transitions.t, atol=1e-9)
    assert lagged.hidden["m"][0] == pytest.approx(0.3, abs=1e-15)
    if tau < 1e-3:  # m = x1 - tau x1' + O(tau^2) once the start is forgotten
        told = lagged.state[:, 0] - tau * lagged.state[:, 1]
        np.testing.assert_allclose(lagged.hidden["m"][1:], told[1:], atol=1e-9 + 3 * tau**2)
        return
    dense = np.linspace(0, 20, 200001)
    x1 = run(t_end=20.0, t_eval=dense).state[:, 0]
    step = dense[1] / tau
    kept = np.exp(-step)
    now, before = 1 - (1 - kept) / step, (1 - kept) / step - kept
    m, _ = scipy.signal.lfilter([now, before], [1, -kept], x1[1:], zi=[before * x1[0] + kept * 0.3])
    np.testing.assert_allclose(lagged.hidden["m"][1:], m[499::500], atol=3e-8)


def test_derivatives_pass_through_a_short_lag():
    tau, step = 0.01, 1e-6

    def m(tau: float, x1: float = 0.1, start: float = 0.3) -> ss.Trajectory:
        names = ("sensor_lag.tau", "initial.x1", "initial.m")
        times = [0.005, 0.02, 5.0]
        initial = (x1, 0.1, 0, 0, 0, 0, 0, start)
        return run(ss.effect("sensor_lag", tau=tau), initial=initial, t_eval=times, sensitivity=names)

    exact = m(tau).hidden_sensitivity["m"]
    moved = [
        m(tau + step).hidden["m"] - m(tau - step).hidden["m"],
        m(tau, 0.1 + step).hidden["m"] - m(tau, 0.1 - step).hidden["m"],
        m(tau, 0.1, 0.3 + step).hidden["m"] - m(tau, 0.1, 0.3 - step).hidden["m"],
    ]
    np.testing.assert_allclose(exact, np.array(moved).T / (2 * step), atol=2e-6, rtol=2e-6)


def test_the_mode_at_a_limit_is_the_one_that_follows_with_and_without_t_eval():
    """A start exactly at the static limit leaves at once: the first row is the one after."""
    block = ss.Model(ss.BlockOnBelt(), friction=ss.HyperbolicFriction(scale=1, decay=3))
    settings = {"belt_speed": 0.2, "initial": (1.0, 0.2), "t_end": 5}
    own, sampled = ss.simulate(block, **settings), ss.simulate(block, **settings, t_eval=[0.0, 1.0])
    assert own.transitions.t[0] == 0
    assert own.mode[0] == sampled.mode[0] == -1
    assert np.all(np.diff(own.t) > 0)
    np.testing.assert_array_equal(own.state[0], sampled.state[0])
    for names in (("scale",), tuple(f"initial.{x}" for x in ("x1", "x2"))):
        told = ss.simulate(block, **settings, sensitivity=names)
        assert told.sensitivity.shape == (len(told.t), 2, len(names))
        np.testing.assert_allclose(told.t, own.t, rtol=1e-13)


@pytest.mark.parametrize(
    ("initial", "said"),
    [
        (np.zeros((2, 4)), "initial"),
        (np.zeros((4, 1)), "initial"),
        (0.1, r"initial"),
        (np.array([0.1 + 1j, 0, 0, 0]), "initial.*real numbers"),
        ((0.1, 0.1, 0, 0, 0.5), "w = 0.5, but no effect"),
        ((0.1, 0.1, 0, 0, 0, 0, 0, 0, 2.0), "dwell = 2, but no effect"),
    ],
)
def test_an_initial_that_is_no_state_of_the_model_is_refused(initial, said):
    with pytest.raises(InputError, match=said):
        run(initial=initial)
    model = ss.Model(RIG, friction=ss.PaperFriction())
    with pytest.raises(InputError, match=said):
        ss.sweep(model, {"belt_speed": [0.1]}, t_end=1, initial=initial)


def test_hidden_zeros_are_no_claim():
    assert run(initial=(*START, 0, 0, 0, 0, 0), t_end=1.0).status.ok
    assert run(ss.effect("friction_memory", tau=0.1), initial=(*START, 0.02), t_end=1.0).status.ok


@pytest.mark.parametrize("name", ["max_transitions", "max_steps", "order"])
@pytest.mark.parametrize("value", [2.5, 0, 10**40, "many"])
def test_counts_are_whole_numbers_in_bounds(name, value):
    with pytest.raises(InputError, match=name):
        run(**{name: value})
