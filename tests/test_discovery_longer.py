"""What explains single cycles is looked at once more over two."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from discover_cases import RIG, make_case
from stickslip.declared.effect import tabulated
from stickslip.declared.friction.paper import PaperFriction
from stickslip.declared.model import Model
from stickslip.discovery import longer, loop
from stickslip.discovery.longer import LEAST, looked_at_longer
from stickslip.discovery.search import CLEAN, LONG, SHORT, Search
from stickslip.discovery.trace import MARGIN, declared
from stickslip.fitted.data import prepare

U = np.linspace(-0.9, 0.9, 19)


def test_two_cycles_show_a_wrong_law_that_single_ones_take_up_in_their_windows_states():
    """Friction that grows with speed: the law fits single cycles to the noise, and misses two by many times that."""
    bump = tabulated("contact", "v_w", U.tolist(), (3 * U**2).tolist())
    case = make_case((bump,), length=60.0)
    search = Search(prepare(case.train), Model(RIG, friction=PaperFriction()), 1, lambda _: None, 60.0)
    short = declared(search)
    long = longer._longer(search, short)
    assert short.fit.readings == long.fit.readings
    assert len(long.fit.windows) < 0.7 * len(short.fit.windows)
    assert short.excess < 0.5 * CLEAN
    assert long.excess > 20 * CLEAN


def test_the_right_law_explains_two_cycles_as_well_as_one():
    case = make_case((), length=60.0)
    search = Search(prepare(case.train), Model(RIG, friction=PaperFriction()), 1, lambda _: None, 60.0)
    short = declared(search)
    assert short.excess < CLEAN
    assert longer._longer(search, short).excess < CLEAN


def trial(names, excess, bic=1000.0):
    return SimpleNamespace(names=names, excess=excess, bic=bic)


@pytest.fixture
def look(monkeypatch):
    """Looks at a choice of `names` that leaves `short` and, over two cycles, `long`; the second finds `found`."""

    def looked(names, short, long, found, *, left=10.0, place=None):
        null, said = trial((), 100.0), []
        chosen = null if not names else trial(names, short)
        chosen.excess = short
        second = SimpleNamespace(most=51.0, budget=30.0, left=-5.0, extend=said.append)
        search = SimpleNamespace(
            left=left,
            data=[],
            most=51.0,
            progress=said.append,
            afresh=lambda _, length: said.append(length) or second,
        )
        choice = SimpleNamespace(trial=chosen, null=null, place=place)
        again = SimpleNamespace(trial=found)
        monkeypatch.setattr(longer, "_longer", lambda *_: trial(names, long))
        monkeypatch.setattr(longer, "decide_single", lambda *_: [])
        monkeypatch.setattr(longer, "choose", lambda *_, one_cause: said.append(one_cause) or again)
        found = looked_at_longer(search, choice)[1]
        return ("again" if found is again else "first"), said, second

    return looked


BETTER = trial(("b",), 0.0, 999.0 - MARGIN)


def test_what_lasts_is_not_looked_at_again(look):
    assert look(("a",), 1.0, 0.9 * CLEAN, BETTER)[:2] == ("first", [])
    assert look(("a",), 1.1 * CLEAN, 100.0, BETTER)[:2] == ("first", [])  # it did not explain single cycles
    assert look(("a",), 1.0, 100.0, BETTER, left=-1.0)[:2] == ("first", [])
    assert look(("a",), 1.0, 100.0, BETTER, place=("block", ("t",)))[:2] == ("first", [])


@pytest.mark.parametrize("names", [("a",), ()])
def test_what_does_not_last_gives_way_to_what_does_better_over_two_cycles(look, names):
    which, said, second = look(names, 1.0, 1.1 * CLEAN, BETTER)
    assert which == "again"
    assert said[1] == LONG > SHORT
    assert said[-1] == bool(names)  # one cause came near: curves before pairs
    assert second.most >= 35.0 + LEAST


@pytest.mark.parametrize("found", [trial(("b",), 0.0, 1001.0 - MARGIN), trial((), 0.0, 0.0)])
def test_what_does_not_last_stays_where_nothing_does_better(look, found):
    assert look(("a",), 1.0, 100.0, found)[0] == "first"


@pytest.mark.parametrize(("spent", "seconds"), [(0.0, loop.LAST), (39.0, loop.LAST), (42.0, loop.BRIEF)])
def test_the_last_fits_are_brief_where_tracing_took_most_of_its_time(spent, seconds):
    search = Search([], Model(RIG, friction=PaperFriction()), 1, lambda _: None, 45.0, 50.0, spent=spent)
    assert loop._for_the_last_fits(search).left == pytest.approx(seconds, abs=0.5)
