"""How far a trial is fitted on: closely, from other sides, and a curve for the report."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from stickslip.discovery import final as last
from stickslip.discovery import unlisted
from stickslip.discovery.gate import largest_gain
from stickslip.discovery.search import ALMOST, CLEAN, MORE, NEAR, SAME, SHORT, Search

READINGS = 1000


def trial(chi2, *, iterations=25, partial=False, names=(), label=""):
    return SimpleNamespace(
        names=names, chi2=chi2, mean=chi2, partial=partial, label=label, excess=(chi2 - 1) * 22.4,
        fit=SimpleNamespace(cost=chi2 * READINGS, iterations=iterations, readings=READINGS),
    )  # fmt: skip


class Scripted(Search):
    """Fits that end as they are told; it notes from where each began."""

    def __init__(self, *ends):
        super().__init__([], None, 1, lambda _: None, 1e6)
        self.ends, self.begun = list(ends), []

    def _again(self, trial, *_):
        self.begun.append(trial)
        return self.ends.pop(0)

    def with_declared_law(self, trial):
        return trial

    def trimmed(self, trial):
        return trial

    def _rephased(self, trial):
        return trial


def test_a_fit_goes_on_while_it_falls_fast():
    ends = [trial(c) for c in (60.0, 40.0, 35.0)]
    search = Scripted(*ends)
    assert search.close(trial(100.0)) is ends[2]
    assert search.begun[1:] == ends[:2]


def test_a_fit_that_hardly_falls_is_not_fitted_on():
    search = Scripted(end := trial(71.0))
    assert search.close(trial(100.0)) is end
    assert len(search.begun) == 1


@pytest.mark.parametrize("chi2", [1.0 + 0.9 * CLEAN / 22.4, 60.0])
def test_a_fit_that_ended_by_itself_or_reached_the_noise_is_not_fitted_on(chi2):
    search = Scripted(trial(chi2, iterations=24 if chi2 > 2 else 25))
    search.close(trial(100.0))
    assert len(search.begun) == 1


def test_a_fit_goes_on_so_many_times_at_most():
    search = Scripted(*(trial(100.0 * 0.6**k) for k in range(MORE + 1)))
    search.close(trial(1000.0))
    assert not search.ends


@pytest.mark.parametrize(
    ("iterations", "half", "whole", "fits"),
    [
        (24, 2 * NEAR, 2.1 * NEAR, 1),  # ended by itself
        (25, 2 * NEAR, 2.1 * NEAR, 2),
        (24, 1.1 * NEAR, 0.9 * NEAR, 2),  # and was not fitted as closely as what it is now
        (24, 0.8 * NEAR, 0.9 * NEAR, 1),
    ],
)
def test_what_has_ended_on_all_windows_is_not_fitted_there_again(iterations, half, whole, fits):
    ended = trial(whole, iterations=iterations)
    search = Scripted(*[ended] * fits)
    assert search.close(trial(half, partial=True)) is ended
    assert len(search.begun) == fits


def test_a_named_trial_is_fitted_afresh_too_and_the_better_stands():
    ends = [trial(50.0, iterations=9, names=("a",)), trial(30.0, names=("a",))]
    search = Scripted(*ends)
    assert search.close(trial(100.0, names=("a",))) is ends[1]
    assert search.begun[1].chi2 == 100.0


@pytest.mark.parametrize(("turns", "further", "fits"), [(1, 2, 3), (1, 0, 1), (0, 2, 2), (0, 0, 0)])
def test_what_comes_near_the_noise_has_further_turns(turns, further, fits):
    chi2 = 0.99 * ALMOST

    class Falling(Scripted):
        def _again(self, one, *_):
            self.begun.append(one)
            return trial(0.99 * one.chi2)

    search = Falling()
    search.polish(trial(chi2), turns=turns, closed=True, further=further)
    assert len(search.begun) == 3 * fits  # out and back, and back with the declared law


@pytest.mark.parametrize(
    ("afresh", "fits"), [(1.0 + 0.9 * SAME, 2), (1.0 - 0.9 * SAME, 2), (1.0 + 1.1 * SAME, 5), (0.9, 5)]
)
def test_a_curve_whose_two_sides_lead_to_the_same_minimum_is_not_fitted_on(afresh, fits):
    one, other = trial(2.0, iterations=9, names=("a",)), trial(2.0 * afresh, iterations=9, names=("a",))
    search = Scripted(one, other, *[trial(3.0)] * 3)
    assert unlisted._closely(search, (None, trial(2.2, names=("a",)), 1)) is min(
        one, other, key=lambda end: end.chi2
    )
    assert len(search.begun) == fits


@pytest.mark.parametrize(("chi2", "chosen"), [(1.0, "long"), (1.3, "short")])
@pytest.mark.parametrize("name", ["tabulated_block_x1", "static_aging"])
def test_the_last_fit_is_on_long_windows_if_it_fits_these_as_well(monkeypatch, chi2, chosen, name):
    short, long = trial(1.0, names=(name,), label="short"), trial(chi2, names=(name,), label="long")
    begun = []

    def finely(_search, _vector, *, cycles=SHORT, **_):
        return short if cycles == SHORT else long

    def submit(function, *args, **options):
        begun.append(function)
        return SimpleNamespace(result=lambda: function(search, *args, **options))

    monkeypatch.setattr(last, "_finely", finely)
    monkeypatch.setattr(last, "_in_order", lambda one: one.fit.vector)
    monkeypatch.setattr(last, "_onward", lambda _search, one: one)
    for one in (short, long):
        one.fit.vector = None
    search = SimpleNamespace(trimmed=lambda one: one, with_declared_law=lambda one: one, submit=submit)
    assert last.final(search, short).label == chosen
    assert len(begun) == (0 if name.startswith("tabulated") else 2)  # other sides; a curve has none


class Valley:
    """A curved valley whose floor falls to (1, 1); each fit creeps along it by at most 1 %."""

    def __init__(self, pace, most=10**6):
        self.pace, self.fits, self.most = pace, 0, most

    @property
    def left(self):
        return self.most - self.fits

    def submit(self, function, *args):
        return SimpleNamespace(result=lambda: function(self, *args))

    def run(self, _hypothesis, *, vector, **_):
        self.fits += 1
        x = vector[0] + np.clip(1.0 - vector[0], -self.pace, self.pace)
        return valley(x, last.FEW if abs(1.0 - x) > 1e-6 else 3)


def valley(x, iterations):
    engine = SimpleNamespace(low=np.full(2, -9.0), high=np.full(2, 9.0), learned=())
    fit = SimpleNamespace(
        vector=np.array([x, x * x]), cost=1000.0 + 1e3 * (x - 1) ** 2, iterations=iterations, engine=engine
    )
    return SimpleNamespace(fit=fit, names=("contact_compliance",), hypothesis=None)


@pytest.mark.parametrize("start", [0.0, -3.0, 0.93])
def test_a_fit_that_creeps_along_a_valley_is_taken_to_its_end(start):
    search = Valley(0.01)
    assert last._onward(search, valley(start, 40)).fit.cost == pytest.approx(1000.0, abs=0.2)
    assert search.fits < 40  # 7 to 400 by creeping


def test_a_valley_is_left_where_the_time_is_up():
    search = Valley(1e-4, most=3)
    assert last._onward(search, valley(0.0, 40)).fit.cost > 1000.2
    assert 3 <= search.fits <= 5


def test_a_fit_that_has_ended_is_not_taken_further():
    search = Valley(1.0)
    assert last._onward(search, valley(1.0 - 1e-9, 7)).fit.cost == pytest.approx(1000.0)
    assert search.fits == 1


@pytest.mark.parametrize(
    ("name", "chi2", "tolerance"),
    [("static_aging", 1.0, 1e-9), ("tabulated_block_x1", 1.0, 1e-7), ("static_aging", 100.0, 1e-5)],
)
def test_how_closely_the_last_fit_ends(name, chi2, tolerance):
    asked = {}
    one = trial(chi2, names=(name,))
    one.hypothesis, one.fit.engine = None, SimpleNamespace(learned=())
    last._finely(SimpleNamespace(run=lambda _, **options: asked.update(options)), None, trial=one, cycles=1.0)
    assert asked["tolerance"] == tolerance


def test_what_hidden_states_take_up_of_the_noise_is_no_gain():
    def one(names, cost, hidden):
        return SimpleNamespace(names=names, fit=SimpleNamespace(cost=cost), hidden=hidden)

    null, lag, damping = one((), 1000.0, 0), one(("lag",), 920.0, 75), one(("damping",), 988.0, 0)
    pair = one(("lag", "damping"), 500.0, 75)
    tried = {t.names: t for t in (null, lag, pair)}
    assert largest_gain(SimpleNamespace(tried=tried), null) == 5.0
    assert largest_gain(SimpleNamespace(tried={**tried, damping.names: damping}), null) == 12.0
    assert largest_gain(SimpleNamespace(tried={(): null}), null) == 0.0
