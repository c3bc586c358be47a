"""Steps that were too long for what they could not see: one test a symptom."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.interpolate import CubicSpline

import stickslip as ss
from stickslip.simulated.reference import integrate as reference


def test_fast_ripple_on_a_saturated_branch_moves_the_kink():
    """The floor of a branch does not feel the belt, so the step must be bounded by the belt's own series."""
    law = ss.PaperFriction(A1=4.94, A2=1.418, t1=0.0284, t2=6.13, T_s_minus=5.56, T_min_minus=1.43)
    rig = ss.Rig(alpha1=16.64, alpha2=8.14, beta3=4.1, eta1=0.11, eta12=0.23)
    model = ss.Model(rig, friction=law, effects=[ss.effect("belt_speed_ripple", a=0.1, w=6.956, phi=2.9)])
    start = (0.11, -0.22, -0.09, -0.22)
    run = ss.simulate(
        model, belt_speed=0.109, initial=start, t_end=30, t_eval=[10.0, 30.0], rtol=1e-7, atol=1e-8
    )
    told = reference.simulate(
        model, belt_speed=0.109, initial=start, t_end=30, t_eval=[10.0, 30.0], tol=1e-11
    )
    assert run.status.ok, run.status.value
    assert len(run.kinks) == len(told.kinks) == 5
    np.testing.assert_allclose(run.kinks, [t for t, _ in told.kinks], atol=1e-7)
    np.testing.assert_allclose(run.state, told.state, atol=1e-7)


def test_a_transition_at_the_end_keeps_the_last_sample():
    model = ss.Model(ss.BlockOnBelt(), friction=ss.HyperbolicFriction(scale=1, decay=3))
    whole = ss.simulate(model, belt_speed=0.2, initial=(1, 0.2), t_end=40, contact="slip-")
    for t, state in zip(whole.transitions.t, whole.transitions.state, strict=True):
        run = ss.simulate(model, belt_speed=0.2, initial=(1, 0.2), t_end=t, t_eval=[0, 1, t], contact="slip-")
        assert run.t[-1] == t
        np.testing.assert_allclose(run.state[-1], state, atol=1e-9)


@pytest.mark.parametrize("tolerance", [1e-6, 1e-9, 1e-10, 3e-11, 1e-11, 1e-12, 1e-14])
def test_return_to_the_belt_at_the_other_static_limit_is_no_chatter(tolerance):
    """The block leaves the other way with next to no velocity, comes back at once, and is then held."""
    model = ss.Model(ss.BlockOnBelt(), friction=ss.HyperbolicFriction(scale=1, decay=3))
    speeds = 0.6419889457495852 * (1 + np.linspace(-2e-12, 2e-12, 21))
    for v in speeds:
        run = ss.simulate(
            model, belt_speed=v, initial=(1, v), contact="slip-", t_end=40, rtol=tolerance, atol=tolerance
        )
        assert run.status.ok, run.status.value
        assert len(run.kinks) == 0


@pytest.mark.parametrize(
    ("stiffness", "x1"), [(1.0, 5.940000000000007), (4.0, 1.4850000000000017), (4.0, -0.907500000000001)]
)
@pytest.mark.parametrize("effects", [[], [ss.effect("block_viscous_damping", c=0.1)]])
def test_a_block_that_stands_on_its_static_limit_stays(stiffness, x1, effects):
    """Where the belt stands still the demand is constant, to the last digit on the limit: nothing moves.

    Of itself a block whose damping has nothing to do would be there in one step; `step` and `after` make it more.
    """
    rig = ss.BlockOnBelt(stiffness=stiffness)
    model = ss.Model(rig, friction=ss.PaperFriction(), effects=effects)
    run = ss.simulate(model, belt_speed=0, initial=(x1, 0), t_end=100, step=2.0)
    assert run.status.ok
    assert run.steps >= 50
    assert len(run.transitions.t) == 0
    assert run.state[-1].tolist() == [x1, 0]
    over = {"initial.x1": np.full(9, x1)}
    for lanes in (True, False):
        swept = ss.sweep(model, over, belt_speed=0, initial=(x1, 0), t_end=100, after=10, lanes=lanes)
        assert (swept["transitions"] == 0).all()
        assert (swept["final_state"].sel(state="x1") == x1).all()


@pytest.mark.parametrize("lanes", [True, False])
def test_meeting_another_surface_does_not_push_a_block_off_its_static_limit(lanes):
    """A table of zeros changes nothing, but its knots in time are surfaces."""
    table = ss.tabulated("block", "t", np.linspace(0, 100, 11), [0.0] * 11)
    model = ss.Model(ss.BlockOnBelt(), friction=ss.PaperFriction(), effects=[table])
    start = (5.940000000000007, 0)
    run = ss.simulate(model, belt_speed=0, initial=start, t_end=100)
    assert len(run.transitions.t) == 0
    assert run.state[-1].tolist() == list(start)
    over = {"initial.x1": np.full(9, start[0])}
    swept = ss.sweep(model, over, belt_speed=0, initial=start, t_end=100, lanes=lanes)
    assert (swept["transitions"] == 0).all()


def test_a_block_pushed_off_its_static_limit_goes():
    model = ss.Model(ss.BlockOnBelt(), friction=ss.PaperFriction())
    run = ss.simulate(model, belt_speed=0.0, initial=(5.94 * (1 + 1e-11), 0), t_end=100)
    assert run.transitions.after[0] != 0 or run.mode[0] != 0
    assert abs(run.state[-1, 0]) < 5.9


@pytest.mark.parametrize(
    "law", [ss.HyperbolicFriction(scale=1, decay=3), ss.CoulombFriction(static=1, kinetic=1)]
)
@pytest.mark.parametrize("c", [3.0, 100.0])
def test_quadratic_drag_opposes_the_motion_off_a_belt_at_rest(law, c):
    """A release without a drop in friction starts with neither velocity nor acceleration: its direction decides."""
    rig = ss.Rig(alpha1=2, alpha2=3, beta3=2, eta1=0, eta12=0.1)
    model = ss.Model(rig, friction=law, effects=[ss.effect("block_quadratic_damping", c=c)])
    start = np.array([0.4, 0, 0, 0.5])
    runs = [ss.simulate(model, belt_speed=0, initial=s * start, t_end=10, rtol=1e-10) for s in (1, -1)]
    told = reference.simulate(model, belt_speed=0, initial=start, t_end=10, tol=1e-12)
    np.testing.assert_allclose(runs[0].state[-1], -runs[1].state[-1], rtol=0, atol=1e-12)
    np.testing.assert_allclose(runs[0].state[-1], told.state[-1], atol=1e-8)
    np.testing.assert_allclose(runs[0].transitions.t, told.transitions.t, atol=1e-6)
    swept = ss.sweep(model, {"initial.x1": [0.4, 0.4]}, belt_speed=0, initial=start, t_end=10, rtol=1e-10)
    np.testing.assert_allclose(swept["final_state"][0], told.state[-1], atol=1e-8)


@pytest.mark.parametrize("tolerance", [1e-8, 1e-12, 1e-13])
def test_a_release_on_the_knot_of_a_table_leaves_its_interval(tolerance):
    """The block crosses the knot at the very release, and comes back through it in the same step."""
    curve = ss.tabulated("contact", "x1", [-0.6, -0.2, 0.2, 0.6, 1.0], [0, 0.05, -0.05, 0.08, 0])
    law = ss.CoulombFriction(static=1, kinetic=0.5)
    model = ss.Model(ss.BlockOnBelt(), friction=law, effects=[curve])
    run = ss.simulate(model, belt_speed=0.2, initial=(0, 0.2), t_end=60, rtol=tolerance, atol=tolerance)
    spline = CubicSpline(curve.knots, curve.values, bc_type="natural")

    def rate(_, z):
        g = spline(z[0]) if z[0] < 1 else 0.0  # constant beyond its ends
        return [z[1], -z[0] + 0.5 * (1 + g)]

    def captured(t, z):
        return z[1] - 0.2 if t > 1 else -1.0

    captured.terminal, captured.direction = True, 1
    told = solve_ivp(rate, (0, 10), [1, 0.2], events=captured, rtol=1e-11, atol=1e-11, max_step=0.01)
    slips = np.diff(run.transitions.t)[::2]
    np.testing.assert_allclose(slips, told.t_events[0][0], atol=max(1e-6, 10 * tolerance))
    np.testing.assert_allclose(run.transitions.state[1::2, 0], told.y_events[0][0][0], atol=1e-5)


def test_a_periodic_table_is_a_periodic_spline():
    knots, values = [0, 1, 2.5, 3, 4], [0, 2, 1, 0.5, 0]
    term = ss.tabulated("block", "t", knots, values, period=4.0)
    free = ss.CoulombFriction(static=0, kinetic=0)
    model = ss.Model(ss.BlockOnBelt(), friction=free, effects=[term])
    times = np.array([0.3, 3.9, 9.0])
    run = ss.simulate(model, belt_speed=0, initial=(0, 1.0), t_end=9, t_eval=times)
    force = CubicSpline(knots, values, bc_type="periodic")
    told = solve_ivp(
        lambda t, z: [z[1], -z[0] + force(t)],
        (0, 9),
        [0, 1],
        t_eval=times,
        rtol=1e-11,
        atol=1e-11,
        max_step=0.02,
    )
    np.testing.assert_allclose(run.state, told.y.T, atol=1e-8)


def test_a_gap_of_no_width_is_refused():
    with pytest.raises(ss.InputError, match="above 0"):
        ss.effect("spring_gap_k3", k=20.0, d=0.0)


def test_a_slip_that_contradicts_its_state_is_refused():
    model = ss.Model(ss.BlockOnBelt(), friction=ss.CoulombFriction())
    with pytest.raises(ss.InputError, match="slips the other way"):
        ss.simulate(model, belt_speed=0.1, initial=(0.1, 0.5), t_end=1, contact="slip-")


@pytest.mark.parametrize("v", [0.2, 0.005, 0.002, 0.001])
def test_a_slow_belt_still_has_its_cycle(v):
    """Loading the spring may take hundreds of natural periods."""
    model = ss.Model(ss.BlockOnBelt(), friction=ss.CoulombFriction(static=1, kinetic=0.5))
    period = 2 * (np.pi - np.arctan(0.5 / v)) + 1 / v
    assert abs(ss.limit_cycle(model, belt_speed=v).period - period) < 1e-9 * period


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ({"t_eval": [0, 4.0, np.nextafter(4, 5)]}, "several entries"),
        ({"t_eval": np.array(["0", "1.5"], dtype=object)}, "real numbers"),
        ({"t_eval": [0, 10**400]}, "real numbers"),
        ({"initial": np.array(["0.1", 0.1], dtype=object)}, "real numbers"),
        ({"contact": np.array(["auto", "a"])}, "must be one of"),
        ({"locator": np.array(["henon", "x"])}, "'henon' or 'bracket'"),
    ],
)
def test_what_is_no_time_number_or_word_is_refused(given, words):
    model = ss.Model(ss.BlockOnBelt(), friction=ss.CoulombFriction())
    with pytest.raises(ss.InputError, match=words):
        ss.simulate(model, **({"belt_speed": 0.1, "initial": (0.1, 0.1), "t_end": 4} | given))
