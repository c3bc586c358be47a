"""Which learned curves are fitted closely: the two best if they come near the names, and what promised most."""

from __future__ import annotations

from types import SimpleNamespace

import pytest

from stickslip.discovery import choice, unlisted
from stickslip.discovery.choice import BETTER, DECISIVE, DOUBTFUL, MOST_LEFT, ON_TRACK, STANDS_IN, SURPASSED
from stickslip.discovery.search import CLEAN
from stickslip.discovery.trace import MARGIN
from stickslip.discovery.unlisted import OUTDONE, PROMISING, STALLED, Term, _worth, learn

TERMS = {variable: Term("block", variable, (0.0, 1.0)) for variable in ("x1", "x2", "y1", "y2")}


def trial(chi2):
    return SimpleNamespace(chi2=chi2, bic=chi2, excess=100.0, fit=SimpleNamespace(cost=100 + chi2))


def worth(promised, beat, **left):
    """Variables of the curves that are fitted closely, of those fitted; `left` is what they leave above 1."""
    found = [(TERMS[variable], trial(1 + excess)) for variable, excess in left.items()]
    best_named = None if beat is None else trial(1 + beat)
    return [term.variable for term, *_ in _worth(found, TERMS[promised], best_named)]


def test_the_two_best_are_worth_a_close_fit():
    assert worth("x1", None, x1=2.0, x2=3.0, y1=4.0) == ["x1", "x2"]
    assert worth("x1", 9.0, x1=2.0, x2=3.0, y1=4.0) == ["x1", "x2"]


def test_a_curve_that_comes_nowhere_near_the_names_is_not():
    assert worth("x1", 2.0, x1=0.5, x2=1.01 * PROMISING * 2.0) == ["x1"]
    assert worth("x1", 2.0, x1=0.5, x2=0.99 * PROMISING * 2.0) == ["x1", "x2"]


def test_what_promised_most_is_though_its_fit_stalled():
    assert worth("y1", 2.0, x1=0.5, x2=1.0, y1=1.9) == ["x1", "x2", "y1"]
    assert worth("x1", 2.0, x1=1.9, x2=1.95) == ["x1"]


def test_what_promised_most_is_not_where_it_is_hopeless():
    assert worth("x1", 2.0, x1=1.99 * STALLED) == ["x1"]
    assert worth("x1", 2.0, x1=2.01 * STALLED) == []


@pytest.fixture
def search():
    """One that notes which curves it is asked to polish."""
    polished = []

    def polish(one, *, turns, closed, further):
        assert closed
        polished.append((one, turns, further))
        return one

    def submit(function, *args):
        return SimpleNamespace(result=lambda: function(given, *args), cancel=lambda: None)

    given = SimpleNamespace(
        left=100.0, budget=100.0, progress=lambda _: None, polish=polish, polished=polished, sides=lambda one: [one],
        submit=submit, at_once=1, once=lambda _what, _of, compute: compute(),
    )  # fmt: skip
    return given


def test_the_curve_that_promises_most_is_fitted_patiently_then_closely(search, monkeypatch):
    gains = {"x1": 5.0, "x2": 50.0, "y1": 20.0, "y2": 1.0}
    trials = {"x1": trial(1.5), "x2": trial(2.9), "y1": trial(1.4), "y2": trial(2.95)}
    asked = {}

    def with_term(_search, _base, term, **options):
        asked[term.variable] = options
        return trials[term.variable]

    monkeypatch.setattr(unlisted, "terms", lambda _: list(TERMS.values()))
    monkeypatch.setattr(unlisted, "gain", lambda _, term: gains[term.variable])
    monkeypatch.setattr(unlisted, "with_term", with_term)
    base = trial(3.0)
    curves = learn(search, base, most=3, beat=base)
    assert list(asked) == ["x2", "y1", "x1"]
    patient, *quick = asked.values()
    assert "worst" not in patient
    assert all(one["worst"] < base.fit.cost for one in quick)
    assert all(patient[name] > one[name] for one in quick for name in ("iterations", "rounds"))
    assert search.polished == [(trials["y1"], 1, 0), (trials["x1"], 1, 0), (trials["x2"], 0, 0)]
    assert [term.variable for term, _ in curves] == ["y1", "x1", "x2"]


def search_of(null):
    """One whose time is up; it notes what more it is given."""
    given = []
    return SimpleNamespace(tried={(): null}, data=[], left=0.0, extend=given.append, given=given)


def quiet(monkeypatch, pairs=(), beyond=1.0):
    """No number of the rig is wrong; crude curves leave `beyond` of what the best name leaves."""
    monkeypatch.setattr(choice, "freed", lambda *_, **__: [])
    monkeypatch.setattr(choice.unlisted, "crude", lambda *_: SimpleNamespace(beyond=lambda _: beyond))
    monkeypatch.setattr(choice, "likely_pairs", lambda *_: list(pairs))


def chosen(monkeypatch, excess, curve_bic, beside_bic=1000.0):
    """Names chosen where the best named leaves `excess` and a curve has this BIC; and was one learned at all?"""
    null = SimpleNamespace(names=(), chi2=2.0, bic=9000.0, excess=900.0)

    def fitted(names, bic, chi2, excess):
        fit = SimpleNamespace(cost=bic)
        return SimpleNamespace(names=names, bic=bic, chi2=chi2, excess=excess, fit=fit)

    best = fitted(("sensor_crosstalk",), 1000.0, 1 + 0.01 * excess, excess)
    curve = fitted(("tabulated_contact_v_w",), curve_bic, 1.0, 0.0)
    again = fitted(
        ("sensor_crosstalk",), beside_bic, 1.0 + (0.01 * excess if beside_bic == 1000.0 else 0), excess
    )
    learned = []

    def learn(*_, **__):
        learned.append(True)
        return [(TERMS["x1"], curve)]

    quiet(monkeypatch)
    monkeypatch.setattr(choice.unlisted, "learn", learn)
    monkeypatch.setattr(choice, "beside", lambda *_: [again])
    monkeypatch.setattr(choice, "deepened", lambda _, trials: trials)
    monkeypatch.setattr(choice, "absurd", lambda *_: None)
    search = search_of(null)
    return choice._choose(search, [best]).trial.names, bool(learned)


def test_a_name_that_leaves_a_little_is_held_against_curves(monkeypatch):
    assert chosen(monkeypatch, 0.9 * DOUBTFUL, 500.0) == (("sensor_crosstalk",), False)
    assert chosen(monkeypatch, 1.1 * DOUBTFUL, 500.0) == (("tabulated_contact_v_w",), True)
    assert chosen(monkeypatch, 1.1 * DOUBTFUL, 1000.0 - 0.9 * MARGIN) == (("sensor_crosstalk",), True)


def test_a_name_stuck_in_a_poor_minimum_is_freed_from_where_the_curve_is(monkeypatch):
    assert chosen(monkeypatch, 1.1 * DOUBTFUL, 500.0, beside_bic=495.0) == (("sensor_crosstalk",), True)


@pytest.mark.parametrize(
    ("beyond", "names"), [(0.9 * ON_TRACK, ("c",)), (1.1 * ON_TRACK, ("sensor_lag", "sensor_crosstalk"))]
)
def test_likely_pairs_come_before_curves_unless_one_is_on_the_track(monkeypatch, beyond, names):
    def fitted(names, chi2, excess=100.0):
        fit = SimpleNamespace(cost=1000 * chi2)
        return SimpleNamespace(names=names, bic=1000 * chi2, chi2=chi2, excess=excess, fit=fit)

    null, best = fitted((), 201.0), fitted(("sensor_crosstalk",), 101.0)
    quiet(monkeypatch, [fitted(("sensor_lag", "sensor_crosstalk"), 1.0, 0.0), best], beyond)
    monkeypatch.setattr(choice.unlisted, "learn", lambda *_, **__: [(TERMS["x1"], fitted(("c",), 0.99, 0.0))])
    monkeypatch.setattr(choice, "beside", lambda _search, trials, _curve: trials)
    monkeypatch.setattr(choice, "absurd", lambda *_: None)
    search = search_of(null)
    assert choice._choose(search, [best, null]).trial.names == names


@pytest.mark.parametrize(
    ("excess", "names"), [(0.9 * DOUBTFUL, ("sensor_lag", "sensor_crosstalk")), (1.1 * DOUBTFUL, ("c",))]
)
def test_a_likely_pair_that_leaves_a_little_is_held_against_curves(monkeypatch, excess, names):
    def fitted(names, chi2, excess=100.0):
        fit = SimpleNamespace(cost=1000 * chi2)
        return SimpleNamespace(names=names, bic=1000 * chi2, chi2=chi2, excess=excess, fit=fit)

    null, best = fitted((), 201.0), fitted(("sensor_crosstalk",), 101.0)
    quiet(monkeypatch, [fitted(("sensor_lag", "sensor_crosstalk"), 1.05, excess), best])
    monkeypatch.setattr(choice.unlisted, "learn", lambda *_, **__: [(TERMS["x1"], fitted(("c",), 1.0, 0.0))])
    monkeypatch.setattr(choice, "beside", lambda _search, trials, _curve: trials)
    monkeypatch.setattr(choice, "absurd", lambda *_: None)
    search = search_of(null)
    assert choice._choose(search, [best, null]).trial.names == names


@pytest.mark.parametrize(
    ("curve_excess", "named_excess", "ahead", "surpasses"),
    [
        (0.9 * CLEAN, 1.1 * DOUBTFUL, 1.1 * DECISIVE, True),
        (1.1 * CLEAN, 9.0 * CLEAN, 1.1 * DECISIVE, False),
        (0.9 * CLEAN, 0.9 * DOUBTFUL, 1.1 * DECISIVE, False),
        (0.9 * CLEAN, 1.1 * DOUBTFUL, 0.9 * DECISIVE, False),
    ],
)
def test_a_curve_within_the_noise_surpasses_names_that_leave_a_little(
    curve_excess, named_excess, ahead, surpasses
):
    curve = SimpleNamespace(excess=curve_excess, bic=1000.0 - ahead, chi2=1.015, names=("learned_x1_x1",))
    named = SimpleNamespace(excess=named_excess, bic=1000.0, chi2=1.025, names=("sensor_lag",))
    assert choice._surpasses(curve, named) == surpasses


@pytest.mark.parametrize(
    ("curve_in", "named_excess", "v_s", "ahead", "surpasses"),
    [
        ("v_w", 1.1 * DOUBTFUL, 0.05, 1.1 * MARGIN, True),
        ("v_w", 1.1 * DOUBTFUL, 0.05, 0.9 * MARGIN, False),
        ("v_w", 0.9 * DOUBTFUL, 0.05, 1.1 * MARGIN, False),
        ("x1", 1.1 * DOUBTFUL, 0.05, 1.1 * MARGIN, False),
        ("v_w", -1.0, 0.5, -50.0, True),
        ("x1", -1.0, 0.5, 50.0, False),
    ],
)
def test_a_curve_that_has_the_name_for_a_special_case_need_only_be_more_likely(
    curve_in, named_excess, v_s, ahead, surpasses
):
    names = (f"tabulated_contact_{curve_in}",)
    curve = SimpleNamespace(excess=0.9 * CLEAN, bic=1000.0 - ahead, chi2=1.02, names=names)
    model = SimpleNamespace(parameters={"stribeck_peak.v_s": v_s})
    named = SimpleNamespace(
        excess=named_excess, bic=1000.0, chi2=1.025, names=("stribeck_peak",), model=model
    )
    assert choice._surpasses(curve, named) == surpasses


@pytest.mark.parametrize(
    ("left", "ahead", "surpasses"),
    [
        (0.9 * BETTER, 1.1 * MARGIN, True),
        (1.1 * BETTER, 1.1 * MARGIN, False),
        (0.9 * BETTER, 0.9 * MARGIN, False),
    ],
)
def test_a_curve_that_leaves_less_than_half_surpasses_names(left, ahead, surpasses):
    curve = SimpleNamespace(excess=100.0, bic=1000.0 - ahead, chi2=1 + left, names=())
    assert choice._surpasses(curve, SimpleNamespace(excess=200.0, bic=1000.0, chi2=2.0)) == surpasses


@pytest.mark.parametrize(("left", "named"), [(0.9 * CLEAN, "alpha2"), (1.1 * CLEAN, "c")])
def test_a_wrong_number_within_the_noise_ends_the_search(monkeypatch, left, named):
    def fitted(names, chi2, excess):
        fit = SimpleNamespace(cost=1000 * chi2)
        return SimpleNamespace(names=names, bic=1000 * chi2, chi2=chi2, excess=excess, fit=fit)

    null, best = fitted((), 201.0, 900.0), fitted(("sensor_crosstalk",), 101.0, 900.0)
    curve = [(TERMS["x1"], fitted(("c",), 0.99, 0.0))]
    quiet(monkeypatch)
    monkeypatch.setattr(choice, "freed", lambda *_, **__: [fitted(("alpha2",), 1.01, left)])
    monkeypatch.setattr(choice.unlisted, "learn", lambda *_, **__: curve)
    monkeypatch.setattr(choice, "beside", lambda _search, trials, _curve: trials)
    monkeypatch.setattr(choice, "absurd", lambda *_: None)
    search = search_of(null)
    assert choice._choose(search, [best, null]).trial.names == (named,)


@pytest.mark.parametrize(
    ("ahead", "excess", "name", "tied"),
    [
        (1.1 * MARGIN, 0.0, "alpha2", []),
        (1.1 * MARGIN, 900.0, "tabulated", []),
        (-0.9 * MARGIN, 0.0, "tabulated", [("alpha2",)]),
        (-1.1 * MARGIN, 0.0, "tabulated", []),
    ],
)
def test_a_wrong_number_of_the_rig_is_chosen_where_it_explains_more_with_less(
    monkeypatch, ahead, excess, name, tied
):
    """`ahead` is by how much it is better than a curve, `excess` what it leaves."""
    null = SimpleNamespace(names=(), chi2=2.0, bic=9000.0, excess=900.0)
    curve = SimpleNamespace(names=("tabulated",), chi2=1.0, bic=500.0, excess=0.0)
    wrong = SimpleNamespace(names=("alpha2",), chi2=1 + excess, bic=500.0 - ahead, excess=excess)
    monkeypatch.setattr(choice, "freed", lambda *_, **__: [wrong])
    made = choice._with_rig(SimpleNamespace(), choice.Choice(null, curve, TERMS["x1"], [curve]))
    assert made.trial.names == (name,)
    assert (made.term is None) == (name == "alpha2")
    assert [one.names for one in made.tied] == tied


@pytest.mark.parametrize(
    ("left", "named", "order", "wandering"),
    [
        (0.9 * SURPASSED, 0.5, [], None),
        (1.1 * SURPASSED, 0.5, [1], None),
        (1.1 * OUTDONE, 1.1 * MOST_LEFT, ["repeats", 3], None),
        (1.1 * OUTDONE, 0.9 * MOST_LEFT, [3, "repeats"], None),
        (1.1 * OUTDONE, 0.9 * STANDS_IN, [3], None),
        (1.1 * OUTDONE, 1.1 * MOST_LEFT, [3], "contact"),  # what wanders does not repeat
        (1.1 * OUTDONE, 0.9 * MOST_LEFT, [3], "contact"),
    ],
)
def test_what_is_sought_beyond_one_name_and_one_curve(monkeypatch, left, named, order, wandering):
    """`left` is the share that a curve leaves of what the best name leaves, `named` what that leaves of all."""

    def fitted(names, chi2):
        fit = SimpleNamespace(cost=1000 * chi2)
        return SimpleNamespace(names=names, bic=1000 * chi2, chi2=chi2, excess=100.0, fit=fit)

    null, best = fitted((), 1 + 100 / named), fitted(("sensor_crosstalk",), 101.0)
    sought = []

    def pairs(_search, trials, most):
        sought.append(most)
        return trials

    quiet(monkeypatch)
    monkeypatch.setattr(
        choice.unlisted, "learn", lambda *_, **__: [(TERMS["x1"], fitted(("c",), 1 + 100 * left))]
    )
    monkeypatch.setattr(choice, "learn_recurring", lambda *_: sought.append("repeats") or [])
    monkeypatch.setattr(choice, "promises", lambda *_: SimpleNamespace(wandering=wandering))
    monkeypatch.setattr(choice, "decide_pairs", pairs)
    monkeypatch.setattr(choice, "deepened", lambda _, trials: trials)
    monkeypatch.setattr(choice, "absurd", lambda *_: None)
    search = search_of(null)
    found = choice._choose(search, [best, null])
    assert search.given == [choice.CURVES] + [choice.REPEATS] * (order == [3, "repeats"])
    assert sought == order
    assert found.trial.names == ("c",)


@pytest.mark.parametrize(
    ("name", "chosen"), [("harmonic_forcing", "c"), ("sensor_crosstalk", "sensor_crosstalk")]
)
def test_a_periodic_name_that_leaves_a_little_is_held_against_what_repeats_elsewhere(
    monkeypatch, name, chosen
):
    def fitted(names, bic, chi2, excess):
        fit = SimpleNamespace(cost=bic)
        return SimpleNamespace(names=names, bic=bic, chi2=chi2, excess=excess, fit=fit)

    quiet(monkeypatch)
    null, best = fitted((), 9000.0, 2.0, 900.0), fitted((name,), 1000.0, 1.02, 1.4)
    monkeypatch.setattr(choice.unlisted, "learn", lambda *_, **__: [])
    monkeypatch.setattr(
        choice, "learn_recurring", lambda *_: [(TERMS["x1"], fitted(("c",), 500.0, 0.99, 0.0))]
    )
    monkeypatch.setattr(choice, "beside", lambda *_: [best])
    monkeypatch.setattr(choice, "deepened", lambda _, trials: trials)
    monkeypatch.setattr(choice, "absurd", lambda *_: None)
    assert choice._choose(search_of(null), [best]).trial.names == (chosen,)


def test_a_name_that_leaves_little_but_not_noise_is_joined_by_the_likely_partner(monkeypatch):
    def fitted(names, bic, chi2, excess):
        fit = SimpleNamespace(cost=bic)
        return SimpleNamespace(names=names, bic=bic, chi2=chi2, excess=excess, fit=fit)

    null, best = fitted((), 1e5, 101.0, 9000.0), fitted(("a",), 1000.0, 1.09, 2.0 * CLEAN)
    quiet(monkeypatch, pairs=[fitted(("a", "b"), 900.0, 1.0, 0.0), best])
    monkeypatch.setattr(choice.unlisted, "learn", lambda *_, **__: [])
    monkeypatch.setattr(choice, "deepened", lambda _, trials: trials)
    assert choice._choose(search_of(null), [best]).trial.names == ("a", "b")
