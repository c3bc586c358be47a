"""Set-points that the sticks of single runs contradict are said where something is unexplained, and only there."""

from __future__ import annotations

import re
from dataclasses import replace
from types import SimpleNamespace

import pytest

import stickslip as ss
from discover_cases import SPEEDS, make_case
from stickslip.discovery.set_points import FAR, doubtful_set_points
from stickslip.fitted.data import prepare

CLEAN, LEFT = SimpleNamespace(clean=True), SimpleNamespace(clean=False)


def told(wrong, after=CLEAN, effects=(), missed=(), model=()):
    """What is said where some runs' set-points are `wrong` by a factor."""
    case = make_case(model, length=60.0)
    runs = [replace(run, belt_speed=run.belt_speed * wrong.get(i, 1.0)) for i, run in enumerate(case.runs)]
    rows = [
        SimpleNamespace(
            run=run.name, one_cycle={"after": FAR * (1.01 if i in missed else 0.99), "floor": 1.0}
        )
        for i, run in enumerate(runs)
        if run.role == "validate"
    ]
    return doubtful_set_points(case, prepare(runs), effects, after, SimpleNamespace(runs=rows))


def test_one_that_is_off_is_said_with_both_speeds():
    (said,) = told({2: 1.1}, LEFT)
    speed, share = re.match(
        r"run_2: the block sticks at (\S+), (\S+) times belt_speed, unlike in the", said
    ).groups()
    assert float(speed) == pytest.approx(SPEEDS[2], rel=0.005)
    assert float(share) == pytest.approx(1 / 1.1, rel=0.005)
    assert "check its belt_speed (-0.077)" in said


def test_two_that_were_swapped_do_not_shield_each_other():
    said = told({0: SPEEDS[1] / SPEEDS[0], 1: SPEEDS[0] / SPEEDS[1]}, LEFT)
    assert [one[:5] for one in said] == ["run_0", "run_1"]


@pytest.mark.parametrize(("missed", "count"), [((4,), 1), ((), 0)])
def test_of_a_validate_run_it_is_said_where_its_forecast_misses(missed, count):
    said = told({4: 1.25}, missed=missed)
    assert len(said) == count
    assert not count or said[0].startswith("run_4")


@pytest.mark.parametrize(("where", "count"), [("belt", 1), ("contact", 1), ("block", 0)])
def test_a_curve_of_belt_or_contact_is_doubted(where, count):
    assert len(told({2: 1.1}, effects=(SimpleNamespace(name="unlisted", where=where),))) == count


def test_nothing_is_said_where_all_is_explained_or_all_runs_are_off_alike_or_each_in_its_own_way():
    assert told({2: 1.1}) == ()
    assert told(dict.fromkeys(range(5), 1.05), LEFT) == ()
    assert told({0: 0.8, 1: 0.9, 3: 1.1, 4: 1.2}, LEFT) == ()
    yields = ss.effect("contact_compliance", k=60.0, c=0.5)
    assert told({}, LEFT, model=(yields,)) == ()
