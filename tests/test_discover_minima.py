"""How fits get out of poor minima: bounds, windows that weigh little, phases sought anew, the law held."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import lsq_linear
from scipy.signal import savgol_filter

from discover_cases import LAW, RIG, make_case
from hypotheses import Start, hypothesis
from stickslip.declared.effect import effect
from stickslip.declared.friction.paper import PaperFriction
from stickslip.declared.model import Model
from stickslip.fitted import windows as of_windows
from stickslip.fitted.data import prepare
from stickslip.fitted.engine import Engine
from stickslip.fitted.relax import relaxed
from stickslip.fitted.solve import Iterate, fit, shares, total, within
from stickslip.fitted.window import SLIPPING, STICK
from stickslip.fitted.windows import cut, with_hidden
from stickslip.measured.case import Recording
from stickslip.simulated.states import DWELL


def test_a_step_from_a_bound_is_the_constrained_one():
    rng = np.random.default_rng(2)
    root = rng.standard_normal((6, 4))
    A, target = root.T @ root, np.array([3.0, -2.0, 1.0, 0.5])
    low, high = np.full(4, -np.inf), np.array([0.0, np.inf, np.inf, np.inf])
    step = within(A, A @ target, low, high)
    known = lsq_linear(root, root @ target, (low, np.array([1e-12, np.inf, np.inf, np.inf])))
    assert step == pytest.approx(known.x, abs=1e-8)


def test_beyond_the_knee_a_window_counts_by_its_logarithm():
    costs, knee = np.array([80.0, 300.0]), np.array([100.0, 100.0])
    assert total(costs, knee) == pytest.approx(80 + 100 * (1 + math.log(3)))
    assert total(costs, None) == 380
    h = 1e-5
    slope = (total(np.array([80.0, 300 + h]), knee) - total(np.array([80.0, 300 - h]), knee)) / (2 * h)
    assert slope == pytest.approx(100 / 300, rel=1e-6)


def test_shares_are_the_slopes_of_the_total():
    data = prepare(make_case().train)
    h = hypothesis(Model(RIG, friction=PaperFriction()), [])
    engine, windows = Engine(data, h, 2), cut(data, h.model, 1.0)
    point = Iterate.at(engine, h.start(len(data)), windows)
    assert point is not None
    assert point.soften()
    size = np.array([float(b.r @ b.r) for b in point.blocks])
    expected = np.where(size > point.knee, point.knee / size, 1.0)
    assert shares(point.blocks, point.knee) == pytest.approx(expected)
    assert expected.min() < 1.0


def test_the_law_stays_about_the_declared_one():
    far = Model(RIG, friction=PaperFriction(A1=3.2345 * math.e**4))
    held = {u.name: u for u in hypothesis(far, [], Model(RIG, friction=PaperFriction())).shared}
    assert held["A1"].centre == pytest.approx(math.log(3.2345))
    assert held["A1"].start == pytest.approx(held["A1"].bounds[1])
    assert held["T_s_minus"].bounds[0] < 5.94 < held["T_s_minus"].bounds[1]


def from_stick(run: Recording) -> Recording:
    """The recording from the middle of its longest stick among the first 400 samples."""
    riding = np.abs(np.gradient(run.x1, run.t)[:400] - run.belt_speed) < 0.5 * abs(run.belt_speed)
    length = np.zeros(len(riding), dtype=int)
    for i in np.flatnonzero(riding):
        length[i] = length[i - 1] + 1 if i else 1
    first = int(np.argmax(length) - length.max() // 2)
    return replace(run, t=run.t[first:], x1=run.x1[first:], y1=run.y1[first:])


def test_a_window_that_starts_in_stick_does_not_know_for_how_long():
    case = make_case((effect("static_aging", dT=0.8, tau=1.0),))
    data = prepare([from_stick(run) for run in case.train])
    h = hypothesis(Model(RIG, friction=LAW), [Start(effect("static_aging", dT=0.5, tau=1.5))])
    windows = cut(data, h.model, 1.0, early=0.0)  # with the beginnings
    stuck = [w for w in windows if w.contact == 0]

    assert any(w.start == 0 for w in stuck)
    assert all(8 in w.free for w in stuck)
    found = fit(Engine(data, h, 2), h.start(len(data)), windows)
    assert found is not None
    assert abs(found.per_reading - 1) < 5 * math.sqrt(2 / found.readings)


def test_a_record_begins_with_its_first_slip_unless_that_is_late():
    data = prepare(make_case().train)
    h = hypothesis(Model(RIG, friction=LAW), [])
    first = {w.run: w.start for w in reversed(cut(data, h.model, 1.0))}
    assert [first[i] for i in range(len(data))] == [int(run.slips[0]) for run in data]
    assert all(run.t[run.slips[0]] <= of_windows.EARLY * run.t[-1] for run in data)
    late = [
        replace(run, slips=run.slips[run.t[run.slips] > 1.01 * of_windows.EARLY * run.t[-1]]) for run in data
    ]
    few = [replace(run, slips=run.slips[: of_windows.FEWEST - 1]) for run in data]
    for runs in (late, few):
        assert {w.run for w in cut(runs, h.model, 1.0) if w.start == 0} == set(range(len(data)))


def from_slow_slip(run: Recording) -> Recording:
    """The recording from where a slip has just begun: a quarter of the belt's speed off it, and faster soon."""
    off = np.abs(savgol_filter(run.x1, 7, 2, deriv=1, delta=0.05) - run.belt_speed) / abs(run.belt_speed)
    begins = (off[20:500] > 0.15) & (off[20:500] < 0.34) & (off[30:510] > 0.8)
    first = 20 + int(np.argmax(begins))
    assert begins.any()
    return replace(run, t=run.t[first:], x1=run.x1[first:], y1=run.y1[first:])


def test_a_window_that_only_seems_to_start_in_stick_is_found_to_slip():
    case = make_case((effect("static_aging", dT=0.8, tau=1.0),), noise=2e-4)
    data = prepare([from_slow_slip(run) for run in case.train])
    h = hypothesis(Model(RIG, friction=LAW), [Start(effect("static_aging", dT=0.8, tau=1.0))])
    windows = [w for w in cut(data, h.model, 1.0, early=0.0) if w.start == 0]
    assert all(w.contact == STICK and 1 not in w.free for w in windows)
    engine = Engine(data, h, 2)
    found = relaxed(engine, h.start(len(data)), windows)
    assert all(w.contact == SLIPPING and 1 in w.free and DWELL not in w.free for w in found)
    readings = sum(2 * (w.stop - w.start) for w in found)
    assert engine.chi2(h.start(len(data)), found).sum() / readings < 1.1
    again = [with_hidden(w, h.model, data[w.run]) for w in found]
    assert [(w.contact, w.free) for w in again] == [(w.contact, w.free) for w in found]


def test_a_window_no_rig_would_need_so_many_steps_in_is_given_up():
    data = prepare(make_case().train)
    h = hypothesis(Model(RIG, friction=LAW), [])
    window = cut(data, h.model, 1.0)[0]
    start = h.start(len(data))
    assert Engine(data, h, 2).residual(start, window) is not None
    assert Engine(data, h, 2, most_steps=5).residual(start, window) is None
