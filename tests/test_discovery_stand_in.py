"""Names that leave far more than the noise are not claimed: they stand in for what is not in the catalogue."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from discover_cases import RIG, SPEEDS, make_case
from stickslip.declared.effect import tabulated
from stickslip.declared.friction.paper import PaperFriction
from stickslip.declared.model import Model
from stickslip.discovery import choice as choices
from stickslip.discovery.choice import stood_in_for, weighed
from stickslip.discovery.place import REPEATS, Promises, place_of, promises
from stickslip.discovery.search import CLEAN, Search
from stickslip.discovery.trace import MARGIN, declared
from stickslip.discovery.unlisted import Term
from stickslip.fitted.data import prepare


def trial(chi2, cost=0.0, names=("belt_seam", "harmonic_forcing")):
    return SimpleNamespace(names=names, chi2=chi2, fit=SimpleNamespace(cost=cost))


@pytest.mark.parametrize(
    ("before", "after", "claimed"),
    [
        (100.0, 1.02, True),
        (100.0, 1.25, True),
        (100.0, 1.5, False),
        (1000.0, 2.9, True),
        (1000.0, 5.0, False),
    ],
)
def test_names_stand_only_if_little_is_left(before, after, claimed):
    tried = {("belt_seam",): trial(9.0, 500.0), ("harmonic_forcing",): trial(8.0, 400.0)}
    place = stood_in_for(SimpleNamespace(tried=tried), trial(before), trial(after))
    assert place == (None if claimed else ("block", ("t",)))


def test_the_place_is_that_of_the_name_that_explains_most_alone():
    search = SimpleNamespace(tried={("belt_seam",): trial(3.0, 100.0)})
    assert stood_in_for(search, trial(100.0), trial(4.0)) == ("contact", ("x1", "t"))


def test_names_far_ahead_of_all_others_stand():
    """Two effects of one sensor may be composed in either order: that is a detail of them, not something else."""
    pair, other = ("sensor_crosstalk", "sensor_nonlinearity"), ("belt_seam", "sensor_crosstalk")
    best = trial(1.5, 50.0, pair)
    for next_best, stands in ((9.0, True), (3.0, False)):
        tried = {pair: best, other: trial(next_best, 900.0, other), ("sensor_crosstalk",): trial(20.0, 2e3)}
        place = stood_in_for(SimpleNamespace(tried=tried), trial(70.0), best)
        assert (place is None) == stands


@pytest.mark.parametrize(("left", "kept"), [(15.0, True), (40.0, False)])
@pytest.mark.parametrize("curved", [False, True])
@pytest.mark.parametrize("wandering", [None, "contact"])
def test_what_stands_in_and_leaves_much_is_not_in_the_model(monkeypatch, left, kept, curved, wandering):
    monkeypatch.setattr(choices, "promises", lambda *_: SimpleNamespace(wandering=wandering))
    search = SimpleNamespace(tried={("belt_seam",): trial(60.0, 100.0)})
    null, names, curve = trial(100.0, names=()), trial(left), trial(left - 1, names=("tabulated_block_x1",))
    term = Term("block", "x1", (0.0, 1.0))
    choice = weighed(search, null, names, [(term, curve)] if curved else [], [])
    assert choice.trial is ((curve if curved else names) if kept else null)
    assert choice.term is (term if curved and kept else None)
    place = ("block", ("x1",)) if curved else ("contact", ("x1", "t"))
    if wandering and not kept:  # names that leave so much say little of the place
        place = ("contact", ("t",))
    assert choice.place == (None if curved and kept else place)


@pytest.mark.parametrize("where", ["angle_body", "contact"])
def test_a_line_of_its_own_phase_in_each_run_is_placed(where):
    """A sine in time on the angle body or in the friction, which no name and no curve over a run's time describes."""
    turns = np.linspace(0, 1, 9)
    size = 0.08 if where == "angle_body" else 0.05
    sine = size * np.sin(2 * np.pi * turns)
    sine[-1] = sine[0]
    case = make_case((tabulated(where, "t", 2.7 * turns, sine, period=2.7),), seed=3)
    data = prepare((*case.train, *case.validate))
    search = Search(
        data[: len(case.train)], Model(case.rig, friction=case.friction), 2, lambda _: None, 100.0
    )
    null = declared(search)
    assert null.chi2 > 1.1
    assert place_of(search, null, null) == (where, ("t",))


@pytest.mark.parametrize("where", ["block", "contact"])
def test_what_differs_from_window_to_window_is_placed(where):
    """A force or a friction that wanders: no curve over a run's time has enough knots for it, and no line shows."""
    knots, rng = np.linspace(0.0, 96.0, 24), np.random.default_rng(8)
    size = 0.2 if where == "block" else 0.06
    runs = []
    for i, speed in enumerate(SPEEDS):
        walk = size * np.convolve(rng.standard_normal(len(knots)), [0.4, 0.8, 1.0, 0.8, 0.4], "same")
        runs += make_case((tabulated(where, "t", knots, walk),), seed=i, speeds=(speed,), length=96.0).runs
    search = Search(prepare(runs), Model(RIG, friction=PaperFriction()), 2, lambda _: None, 100.0)
    null = declared(search)
    assert null.chi2 > 2
    assert promises(search, null).wandering == where
    assert place_of(search, null, null) == (where, ("t",))


@pytest.mark.parametrize(
    ("curve", "line", "window", "wandering"),
    [
        (10 * MARGIN, 0.0, 20 * MARGIN, "contact"),
        (21 * MARGIN, 0.0, 20 * MARGIN, None),
        (0.0, 1.01 * REPEATS * 20 * MARGIN, 20 * MARGIN, None),
        (0.0, 0.99 * REPEATS * 20 * MARGIN, 20 * MARGIN, "contact"),
        (-99.0, 0.0, 0.9 * MARGIN, None),
        (-99.0, 0.0, 1.1 * MARGIN, "contact"),
    ],
)
def test_what_wanders_promises_more_by_windows_than_by_any_curve_or_line(curve, line, window, wandering):
    term, other = Term("block", "x1", (0.0, 1.0)), Term("block", "y1", (0.0, 1.0))
    windows = {"block": 0.9 * window, "contact": window}
    lines = {"block": line, "contact": 0.5 * line}
    assert Promises([(curve, term), (-99.0, other)], lines, windows).wandering == wandering


def test_noise_a_little_larger_than_declared_has_no_place():
    """What is left over is white: no curve and no line anywhere takes up more of it than its numbers cost."""
    case = make_case(length=30.0, speeds=(0.06, -0.1, 0.1), seed=3)
    quiet = [replace(run, noise={name: 0.9 * size for name, size in run.noise.items()}) for run in case.train]
    search = Search(prepare(quiet), Model(case.rig, friction=case.friction), 2, lambda _: None, 100.0)
    null = declared(search)
    assert null.chi2 == pytest.approx(1 / 0.9**2, rel=0.05)
    assert null.excess > CLEAN
    assert place_of(search, null, null) is None
