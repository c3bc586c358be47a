"""When tracing goes on and when it gives up: rivals far off, pairs astray, knots that change nothing."""

from __future__ import annotations

import math
from types import SimpleNamespace

import pytest

from stickslip.discovery import pairs, trace, unlisted
from stickslip.discovery.pairs import ALONE, BESIDE, HOPELESS, LIKELY, RIVAL, SAME, likely_pairs
from stickslip.discovery.search import CLEAN
from stickslip.discovery.trace import BEYOND, FAR, FARTHEST, MARGIN, closely
from stickslip.discovery.unlisted import KNOTS, RESOLVED, Term, _finer, knots_for

CLEAN_COST = 1000.0


def trial(names, cost, excess=100.0, bic=None):
    bic, mean = cost if bic is None else bic, cost / CLEAN_COST
    return SimpleNamespace(
        names=names, fit=SimpleNamespace(cost=cost, readings=CLEAN_COST), excess=excess, bic=bic,
        chi2=mean, mean=mean, hypothesis=SimpleNamespace(model=None), bic_of=lambda _: bic,
        partial=False,
    )  # fmt: skip


class Search:
    """One that computes a task where it is asked for, and notes what it was asked."""

    def __init__(self, left=1e6, budget=1e6):
        self.left, self.budget, self.at_once = left, budget, 1
        self.model, self.data = None, []
        self.tried, self.fitted, self.extended, self.options, self.pairs = {}, [], [], [], {}

    def progress(self, _):
        pass

    def submit(self, function, *args):
        if function is trace.Search.close:
            function = Search.close
        return SimpleNamespace(result=lambda: function(self, *args), cancel=lambda: None)

    def close(self, one):
        self.fitted.append(one.names)
        return one

    def keep(self, one, key):
        self.tried[key] = one

    def extend(self, seconds):
        self.extended.append(seconds)

    def once(self, _what, _of, compute):
        return compute()

    def run(self, _h, **options):
        self.options.append(options)


@pytest.mark.parametrize(
    ("costs", "clean", "fitted"),
    [
        ((1000, 1000 * BEYOND * 0.99, 1000 * BEYOND * 1.01), True, 2),  # the third is measured by FAR
        ((1000, 1000 * FAR * 1.5), True, 2),  # the second of all has more patience than that
        ((1000, 1000 * BEYOND * 1.01), True, 1),
        ((1000, 1010, 1000 * FAR * 0.99), True, 3),
        ((1000, 1010, 1000 * FAR * 1.01), True, 2),
        (
            (1000, 1000 * FARTHEST * 0.99),
            False,
            2,
        ),  # where the best is above the noise, all that is not absurd
        ((1000, 1000 * FARTHEST * 1.01), False, 1),
        ((1000, 1001, 1002, 1003), True, 3),
        ((1000, 1001, 1002, 1003, 1004), False, 4),
    ],
)
def test_which_rivals_are_fitted_closely(costs, clean, fitted):
    search = Search()
    trials = [trial((f"e{i}",), cost, 0.0 if clean and i == 0 else 100.0) for i, cost in enumerate(costs)]
    assert closely(search, trials) == trials[:fitted]
    assert search.fitted == [(f"e{i}",) for i in range(fitted)]
    assert list(search.tried) == search.fitted


def test_no_second_rival_is_fitted_when_the_time_is_up():
    search = Search(left=-1.0)
    closely(search, [trial(("a",), 1000), trial(("b",), 1001)])
    assert search.fitted == [("a",)]


def test_a_rival_that_cannot_be_fitted_on_all_windows_is_left_out():
    search, rivals = Search(), [trial(("a",), 1000), trial(("b",), 1001)]
    rivals[0].partial = True
    assert closely(search, rivals) == rivals[1:]
    assert list(search.tried) == [("b",)]


@pytest.mark.parametrize(
    ("crude", "worst"),
    [
        (BESIDE * 0.99, [math.inf]),
        (BESIDE * 1.01, [ALONE * (1000.0 + MARGIN)]),
        (HOPELESS * 0.99, [ALONE * (1000.0 + MARGIN)]),
        (HOPELESS * 1.01, []),
    ],
)
def test_an_effect_that_alone_leaves_far_more_than_the_pair_is_not_fitted_to_the_end(
    monkeypatch, crude, worst
):
    search = Search()

    def run(_h, **options):
        search.options.append(options)
        return trial(("a",), crude * 1000.0)

    search.run = run
    monkeypatch.setattr(pairs, "starts_of", lambda _: [SimpleNamespace(term=SimpleNamespace(name="a"))])
    monkeypatch.setattr(pairs, "hypothesis", lambda *_: None)
    found = pairs._eliminated(search, trial(("a", "b"), 1000.0))
    assert [one.names for one in found] == [("a",)]
    assert all(one["anyway"] for one in search.options)
    assert [one["worst"] for one in search.options[1:]] == worst


def test_names_beside_a_curve_are_given_up_where_they_stall_far_above_it(monkeypatch):
    search = Search()
    monkeypatch.setattr(trace, "starts_of", lambda _: [])
    monkeypatch.setattr(trace, "hypothesis", lambda *_: None)
    trials = [trial(("a",), 9000.0), trial(("a", "b"), 9100.0), trial(("b",), 9200.0)]
    assert trace.beside(search, trials, trial(("curve",), 1000.0)) == trials
    assert [one["worst"] for one in search.options] == [trace.OUTRUN * 1000.0] * 2  # singles alone


@pytest.mark.parametrize(("ahead", "names"), [(0.9 * MARGIN, ("a",)), (1.1 * MARGIN, ("a", "b"))])
def test_a_pair_that_has_settled_is_slimmed_to_what_does_as_well_alone(monkeypatch, ahead, names):
    pair = trial(("a", "b"), 1000.0, bic=1000.0)
    alone = [trial(("a",), 1010.0, bic=1000.0 + ahead), trial(("b",), 1500.0, bic=1500.0)]
    search = SimpleNamespace(tried={one.names: one for one in alone})
    monkeypatch.setattr(pairs, "_eliminated", lambda *_: alone)
    assert pairs.slimmed(search, pair).names == names
    assert pairs.slimmed(search, alone[1]).names == ("b",)  # there is nothing to leave out


@pytest.mark.parametrize(
    ("chi2", "left", "expected"),
    [
        (60.0, 0.4, ["contact_compliance"]),  # much is left, though one explains more than half
        (60.0, 0.004, []),  # one all but reaches the noise
        (1.4, 0.4, []),  # little is missing
        (60.0, 0.6, ["sensor_lag", "contact_compliance"]),  # all are stuck
    ],
)
def test_a_contact_of_another_kind_is_also_tried_from_the_declared_law(chi2, left, expected):
    base = SimpleNamespace(chi2=chi2, excess=100.0, fit=SimpleNamespace(cost=1000.0))
    best = {
        "sensor_lag": SimpleNamespace(chi2=1 + left * (chi2 - 1), fit=SimpleNamespace(cost=1000.0)),
        "contact_compliance": SimpleNamespace(chi2=chi2, fit=SimpleNamespace(cost=1000.0)),
    }
    tried = [("sensor_lag", None), ("contact_compliance", None)]
    search, base.names = SimpleNamespace(extend=lambda _: None), ()
    assert [name for name, _ in trace._anew(search, base, tried, best)] == expected


@pytest.mark.parametrize(
    ("names", "share", "expected"),
    [
        (("belt_seam",), 0.99, ["contact_compliance"]),
        (("belt_seam",), 1.01, []),  # far slower than any other, and it explained little alone
        ((), 1.01, ["contact_compliance"]),
    ],
)
def test_another_contact_is_tried_afresh_beside_an_effect_only_if_it_explains_much_alone(
    names, share, expected
):
    base = SimpleNamespace(names=names, chi2=60.0, excess=100.0, fit=SimpleNamespace(cost=60_000.0))
    best = {"sensor_lag": SimpleNamespace(chi2=20.0, fit=SimpleNamespace(cost=20_000.0))}
    null = trial((), 90_000.0)
    alone = trial(("contact_compliance",), share * trace.LITTLE_ALONE * null.fit.cost)
    search = SimpleNamespace(tried={(): null}, screened=[alone])
    assert [name for name, _ in trace._anew(search, base, [("contact_compliance", None)], best)] == expected


@pytest.mark.parametrize(
    ("others", "stuck"),
    [
        ([1.6] * trace.MANY, True),  # whatever is added takes away the same: the base was not at its end
        ([1.6] * (trace.MANY - 1), False),
        ([2.2] * trace.MANY, False),  # the best stands out
    ],
)
def test_rivals_that_all_leave_the_same_are_stuck_with_their_base(others, stuck):
    base = SimpleNamespace(chi2=3.0, excess=100.0)
    trials = [SimpleNamespace(chi2=chi2) for chi2 in (1.55, *others)]
    assert trace._stuck(base, trials) == stuck


@pytest.mark.parametrize(
    ("worse", "least", "names"), [(1.1, 20.0, ["aging"]), (1.02, 20.0, []), (1.1, 1.1, [])]
)
def test_a_rival_that_ends_worse_than_its_own_special_case_is_tried_from_the_declared_law(
    worse, least, names
):
    """Aging beside a ripple: the law alone had taken the aging up, and from there no way led down."""
    base = SimpleNamespace(names=(), chi2=60.0, excess=100.0, fit=SimpleNamespace(cost=1000.0))
    best = {
        "lag": SimpleNamespace(chi2=least, fit=SimpleNamespace(cost=400.0)),
        "aging": SimpleNamespace(chi2=60.0 * worse, fit=SimpleNamespace(cost=1000.0 * worse)),
    }
    tried = [("lag", None), ("aging", None)]
    assert [name for name, _ in trace._anew(SimpleNamespace(), base, tried, best)] == names


def ended(cost, iterations=10, mean=50.0):
    return SimpleNamespace(mean=mean, fit=SimpleNamespace(cost=cost, iterations=iterations))


def test_the_best_rivals_and_those_not_judged_yet_are_worth_more_steps():
    base = SimpleNamespace(excess=100.0, fit=SimpleNamespace(cost=100.0))
    rest = [(f"rival {i}", ended(50.0 + i)) for i in range(trace.SHAKEN)]
    worse = ("worse", ended(97.0))
    early = ("early", ended(300.0, trace.JUDGED - 1))
    good_early = ("better than the base and slower", ended(98.0, trace.JUDGED - 1))
    idle = ("where the base is", ended(100.1, 1))
    judged = ("judged", ended(300.0, trace.JUDGED))
    quiet = ("noise", ended(1.0, mean=0.99 * trace.QUIET))
    falling = ("still falling", ended(40.0, trace.STEPS))
    found = trace._worth_more([worse, early, good_early, idle, judged, quiet, falling, *rest], base)
    assert [name for name, _ in found] == [*(name for name, _ in rest), "early"]
    many = [("early", ended(300.0 + i, 1)) for i in range(2 * trace.SHAKEN)]
    assert trace._worth_more([*many, *rest], base) == rest + many[: trace.SHAKEN]


def test_a_rival_that_stands_where_the_base_does_is_not_among_the_best():
    base = SimpleNamespace(excess=100.0, fit=SimpleNamespace(cost=100.0))
    moved = ("moved", ended(98.0))
    assert trace._worth_more([("idle", ended(99.0)), moved], base) == [moved]
    assert len(trace._worth_more([("idle", ended(99.0))], base, afresh=True)) == 1


def test_from_the_declared_law_those_not_too_far_off_are_worth_more_steps():
    base = SimpleNamespace(fit=SimpleNamespace(cost=100.0))
    rest = [(f"rival {i}", ended(150.0 + i)) for i in range(trace.SHAKEN)]
    more = ("one more", ended(300.0, 1))
    contact = ("contact_compliance", ended(99.0 * trace.FARTHEST))
    farther = ("contact_compliance", ended(101.0 * trace.FARTHEST))
    found = trace._worth_more([more, farther, contact, *rest], base, afresh=True)
    assert found == [*rest, contact]


@pytest.mark.parametrize("afresh", [False, True])
def test_a_stalled_rival_goes_on_from_where_it_is_for_the_steps_that_are_left(afresh):
    search, base, one = Search(), trial((), 5000.0), trial(("sensor_lag",), 4000.0)
    one.fit.iterations, one.fit.vector = 5, "where it is"
    trace._shaken(search, ("sensor_lag", one), base=base, afresh=afresh)
    asked = search.options[0]
    assert asked["iterations"] == (trace.STEPS // 2 if afresh else trace.STEPS) - 5
    assert (asked["rounds"], asked["vector"], asked["windows_of"]) == (1, "where it is", one)
    assert asked["worst"] == (math.inf if afresh else 0.985 * 5000.0)


@pytest.mark.parametrize(("share", "bic", "polished"), [(0.99, 2000, 1), (1.01, 2000, 0), (1.01, 1300, 1)])
def test_fine_knots_are_polished_where_they_change_something(monkeypatch, share, bic, polished):
    coarse = trial(("t",), 1400.0, bic=1400)
    added = trial(("t",), CLEAN_COST + share * RESOLVED * 400, bic=bic)
    monkeypatch.setattr(unlisted, "with_term", lambda *_, **__: added)
    monkeypatch.setattr(unlisted, "ranges", lambda _: {"x1": [0.0, 1.0]})
    asked = []
    search = SimpleNamespace(sides=lambda one: asked.append(one) or [one, one])
    term = Term("block", "x1", knots_for([0.0, 1.0], KNOTS))
    found = _finer(search, (term, coarse), base=coarse)
    assert len(asked) == polished
    assert (found is not None) == (bic < 1400)


def test_partners_that_explained_most_alone_are_tried_first():
    search = SimpleNamespace(
        screened=[trial(("belt_seam",), 500.0), trial(("static_aging",), 300.0), trial(("a", "b"), 1.0)]
    )
    order = trace._promising_first(search)
    assert order[:2] == ["static_aging", "belt_seam"]
    assert sorted(order) == sorted(trace.CATALOGUE)
    assert trace._promising_first(SimpleNamespace(screened=[])) == list(trace.CATALOGUE)


def test_likely_pairs_are_fitted_closely_only_if_one_all_but_reaches_the_noise(monkeypatch):
    fitted = []

    def polished(_search, trials):
        fitted.append(trials[0].names)
        return [trial(trials[0].names, CLEAN_COST)]

    monkeypatch.setattr(pairs, "polished", polished)
    monkeypatch.setattr(pairs, "_partner", lambda *_: None)
    monkeypatch.setattr(pairs, "_eliminated", lambda *_: [])
    monkeypatch.setattr(pairs, "explained", lambda one, _: one.chi2 < 1.01)
    both = [("a", "z"), ("a",)]
    for left, excess, names in ((0.9, 100, both), (1.1, 100, []), (1.1, 0.9 * CLEAN, both)):
        search = Search()
        search.tried[()] = trial((), 100 * CLEAN_COST)
        base = trial(("a",), 30 * CLEAN_COST)
        crude = trial(("a", "z"), (1 + 29 * left * LIKELY) * CLEAN_COST, excess)
        monkeypatch.setattr(pairs, "screen", lambda *_, crude=crude: [crude])
        assert [one.names for one in likely_pairs(search, [base])] == names
    assert fitted == 2 * [("a", "z")]


@pytest.mark.parametrize(("next_best", "sought"), [(0.99 * RIVAL, "ab"), (1.01 * RIVAL, "a")])
def test_likely_pairs_are_sought_on_the_next_effect_where_that_does_nearly_as_well(
    monkeypatch, next_best, sought
):
    search, bases = Search(), []
    search.tried[()] = trial((), 100 * CLEAN_COST)

    def screen(_search, base):
        bases.append(base.names[0])
        return [trial((*base.names, "z"), CLEAN_COST * (1 if base.names == ("b",) else 20))]

    monkeypatch.setattr(pairs, "screen", screen)
    monkeypatch.setattr(pairs, "polished", lambda _search, trials: trials)
    monkeypatch.setattr(pairs, "_eliminated", lambda *_: [])
    monkeypatch.setattr(pairs, "explained", lambda one, _: one.chi2 < 1.01)
    singles = [trial(("a",), 30 * CLEAN_COST), trial(("b",), 30 * next_best * CLEAN_COST)]
    found = likely_pairs(search, singles)
    assert "".join(bases) == sought
    assert [one.names for one in found[:1]] == ([("b", "z")] if sought == "ab" else [])


def test_pairs_on_a_base_are_sought_once_unless_it_fits_far_better(monkeypatch):
    search, sought = Search(), []
    monkeypatch.setattr(pairs, "screen", lambda _search, base: sought.append(base.fit.cost) or [])
    for share in (1.0, 1.01 * SAME, 0.99 * SAME):
        pairs._pairs_on(search, trial(("a",), 1000 * share))
    assert sought == [1000, 990 * SAME]


def test_a_contact_of_another_kind_has_the_steps_that_it_needs_from_the_declared_law(monkeypatch):
    """It still falls after 12, and a start that ends in a poor minimum would be ranked before it."""
    steps = {}
    monkeypatch.setattr(trace, "hypothesis", lambda *_: None)
    monkeypatch.setattr(trace, "starts_of", lambda _: [])
    base = SimpleNamespace(excess=100.0, fit=SimpleNamespace(cost=1.0, readings=1))
    for name in ("contact_compliance", "sensor_lag"):
        search = SimpleNamespace(
            model=None, run=lambda _, name=name, **o: steps.update({name: o["iterations"]})
        )
        trace._screened(search, (name, None), base=base, afresh=True)
    assert steps == {"contact_compliance": 24, "sensor_lag": 12}


@pytest.mark.parametrize(("cost", "fall"), [(5000.0, 40.0), (1020.0, 0.2), (990.0, 0.2)])
def test_a_rival_is_fitted_until_it_falls_by_little_of_what_there_is_to_explain(monkeypatch, cost, fall):
    """Where little is left over, a hundredth of all of chi-squared is more than a rival can gain."""
    search = Search()
    monkeypatch.setattr(trace, "hypothesis", lambda *_: None)
    monkeypatch.setattr(trace, "starts_of", lambda _: [])
    base = trial((), cost)
    trace._screened(search, ("sensor_lag", None), base=base)
    assert search.options[0]["tolerance"] * cost == pytest.approx(fall)
