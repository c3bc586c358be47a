"""What is drawn between the samples of a simulation is its motion."""

import numpy as np

import stickslip as ss
from stickslip.shown.plot.between import ENOUGH, between, own_steps

MODEL = ss.Model(ss.Rig(alpha1=16, alpha2=8, beta3=4, eta1=0.1, eta12=0.2), friction=ss.PaperFriction())


def test_own_steps_become_the_curve_that_was_simulated() -> None:
    few = ss.simulate(MODEL, belt_speed=0.1, t_end=40.0)
    assert len(few.t) < ENOUGH / 5
    t = np.sort(np.append(few.t, few.transitions.t))
    exact = ss.simulate(MODEL, belt_speed=0.1, t_end=40.0, t_eval=np.unique(t))
    times, q, v = between(exact.t, exact.state[:, [0, 2]], exact.state[:, [1, 3]])
    assert len(times) >= ENOUGH
    dense = ss.simulate(MODEL, belt_speed=0.1, t_end=40.0, t_eval=times)
    for made, true in ((q, dense.state[:, [0, 2]]), (v, dense.state[:, [1, 3]])):
        assert np.abs(made - true).max() < 0.02 * np.ptp(true)


def test_many_samples_stay_as_they_are() -> None:
    t = np.linspace(0.0, 1.0, ENOUGH)
    times, q, v = between(t, np.sin(t)[:, None], np.cos(t)[:, None])
    assert times is not None
    assert (times == t).all()
    assert (q[:, 0] == np.sin(t)).all()
    assert (v[:, 0] == np.cos(t)).all()


def test_what_lies_between_samples_that_were_asked_for_is_not_drawn() -> None:
    """A cubic through a few samples of many periods would be loops that nobody simulated."""
    few = ss.simulate(MODEL, belt_speed=0.1, t_end=60.0, t_eval=np.linspace(0, 60, 30))
    assert not own_steps(few)
    assert own_steps(ss.simulate(MODEL, belt_speed=0.1, t_end=60.0))
    (left, right) = few.plot().axes[:2]
    ways = few.transitions.t[few.transitions.t <= 60.0]
    assert len(left.lines[0].get_xdata()) == len(few.t) + len(ways)
    assert right.lines
