"""What pairs are built on, and which of them are fitted from other sides."""

from __future__ import annotations

from types import SimpleNamespace

import pytest

from stickslip.discovery import choice, pairs
from stickslip.discovery.pairs import ANOTHER, FREED, OUTSTANDING, PROMISING, RIVAL, WEAKER, decide_pairs
from stickslip.discovery.search import CLEAN
from stickslip.discovery.trace import PLAIN, STUCK

READINGS = 1000


def trial(names, mean):
    cost = mean * READINGS
    return SimpleNamespace(
        names=names, fit=SimpleNamespace(cost=cost, readings=READINGS), mean=mean, chi2=mean,
        excess=(mean - 1) * 22.4, bic=cost, bic_of=lambda _: cost, partial=False,
    )  # fmt: skip


@pytest.fixture
def decide(monkeypatch):
    """Decides pairs on single effects that leave `means`, where crude pairs on each in turn leave these shares of 99.

    One that promises to explain everything leaves `reached` once it is fitted closely; `alone` is what an effect of the
    best pair then leaves alone. What was sought, fitted and extended is noted.
    """

    def decided(*shares, means=(30.0, 31.0, 32.0), reached=0.0, alone=None, partner=None):
        singles = [trial((name,), mean) for name, mean in zip("abc", means, strict=False)]
        tried = {(): trial((), 100.0)} | {one.names: one for one in singles}
        extended = []
        search = SimpleNamespace(
            tried=tried,
            pairs={},
            extend=extended.append,
            left=1.0,
            once=lambda _what, _of, compute: compute(),
        )
        seen = SimpleNamespace(bases="", most=[], sides=[], extended=extended, found=[])

        def screen(_search, base):
            seen.bases += base.names[0]
            return [trial((*base.names, "z"), 1 + 99 * shares[len(seen.bases) - 1])]

        def closely(_search, some, most):
            seen.most.append(most)
            return [
                trial(one.names, 1 + 99 * reached) if one.chi2 - 1 < 99 * PROMISING else one
                for one in some[:most]
            ]

        def deepened(_search, some):
            seen.sides += [one.names for one in some]
            return some

        monkeypatch.setattr(pairs, "screen", screen)
        monkeypatch.setattr(pairs, "closely", closely)
        monkeypatch.setattr(pairs, "polished", closely)
        monkeypatch.setattr(pairs, "deepened", deepened)
        monkeypatch.setattr(pairs, "_eliminated", lambda *_: [] if alone is None else [trial(("z",), alone)])
        monkeypatch.setattr(pairs, "_partner", lambda *_: partner and trial(("z",), partner))
        monkeypatch.setattr(pairs, "explained", lambda one, _: one.chi2 < 1.01)
        seen.found = decide_pairs(search, singles)
        return seen

    return decided


def test_pairs_that_promise_to_explain_everything_need_no_other_base(decide):
    seen = decide(0.99 * PROMISING)
    assert seen.bases == "a"
    assert seen.extended == [ANOTHER[0]]
    assert seen.found[0].names == ("a", "z")
    assert seen.most == [4]


def test_pairs_that_do_not_keep_their_promise_leave_the_next_base_to_try(decide):
    seen = decide(0.99 * PROMISING, 0.3, 0.2, reached=0.9 * PROMISING)
    assert seen.bases == "abc"
    assert seen.found[0].names == ("a", "z")


def test_pairs_that_leave_more_may_be_built_on_the_wrong_effect(decide):
    seen = decide(1.01 * PROMISING, 0.0)
    assert seen.bases == "ab"
    assert seen.extended == list(ANOTHER)
    assert seen.found[0].names == ("b", "z")
    seen = decide(0.3, 0.2, 0.4)
    assert (seen.bases, seen.most) == ("abc", [2])  # none promises much: few are fitted closely


def test_the_best_partner_of_a_base_is_built_on_before_the_next_base(decide):
    """Of a cubic spring and a droop of the belt a seam explained most alone; the droop, by itself, never came near."""
    half, base = 0.9 * STUCK * 29 / 99, 30.0
    seen = decide(half, 0.0, partner=0.9 * RIVAL * base)
    assert seen.bases == "az"
    assert seen.found[0].names == ("z", "z")
    assert decide(half, 0.0, partner=1.1 * RIVAL * base).bases == "ab"  # alone it explains too little
    assert (
        decide(1.1 * STUCK * 29 / 99, 0.0, partner=base).bases == "ab"
    )  # beside the base it explains too little
    assert decide(half, 0.0).bases == "ab"  # alone it cannot be simulated


def test_an_effect_that_a_pair_has_brought_to_its_place_is_another_base(decide):
    seen = decide(0.3, 0.2, 0.4, 0.0, alone=0.9 * 30 * FREED)
    assert seen.bases == "abcz"
    assert seen.found[0].names == ("z", "z")
    assert decide(0.3, 0.2, 0.4, alone=1.1 * 30 * FREED).bases == "abc"
    assert decide(0.0, alone=0.9 * 30 * FREED).bases == "a"


def test_pairs_are_built_on_effects_that_are_not_far_weaker_than_the_best(decide):
    assert decide(0.2, 0.2, means=(20.0, 0.99 * WEAKER * 20.0, 1.01 * WEAKER * 20.0)).bases == "ab"


def test_where_the_best_is_near_the_noise_those_that_leave_a_plain_misfit_still_count(decide):
    assert decide(0.2, 0.2, means=(1.2, 0.99 * WEAKER * PLAIN, 1.01 * WEAKER * PLAIN)).bases == "ab"


@pytest.mark.parametrize(("share", "sides"), [(0.99 * STUCK, [("a", "z")]), (1.01 * STUCK, [])])
def test_a_pair_that_leaves_most_of_what_its_effect_does_is_not_fitted_from_other_sides(decide, share, sides):
    assert decide(share * 20 / 99, means=(21.0,)).sides == sides


def of(*chi2s):
    return [trial(("a", partner), chi2) for partner, chi2 in zip("xyz", chi2s, strict=False)]


def test_a_pair_that_stands_out_is_fitted_closely_before_another_base():
    null = trial((), 133.0)
    assert pairs._promising(of(8.0, 1 + 1.01 * 7.0 / OUTSTANDING), null)
    assert not pairs._promising(of(8.0, 1 + 0.99 * 7.0 / OUTSTANDING, 60.0), null)
    assert not pairs._promising(of(8.0), null)
    same = [*of(8.0), trial(("x", "a"), 9.0), trial(("a", "y"), 60.0)]  # found on both
    assert pairs._promising(same, null)


@pytest.mark.parametrize(
    ("excess", "pair", "names"),
    [
        (1.01 * CLEAN, 0.99 * CLEAN, ("a", "z")),
        (1.01 * CLEAN, 1.01 * CLEAN, ("a",)),
        (0.99 * CLEAN, 0.0, ("a",)),
    ],
)
def test_a_name_that_leaves_little_but_not_noise_gets_the_partner_that_takes_the_rest(
    monkeypatch, excess, pair, names
):
    single, both = trial(("a",), 1 + excess / 22.4), trial(("a", "z"), 1 + pair / 22.4)
    monkeypatch.setattr(choice, "likely_pairs", lambda _search, trials: [both, *trials])
    assert choice._with_partner(None, [single])[0].names == names
    monkeypatch.setattr(choice, "likely_pairs", lambda *_: [])
    assert choice._with_partner(None, [single]) == [single]


def test_a_pair_is_held_against_the_better_of_its_two_effects():
    search = SimpleNamespace(tried={("a",): trial(("a",), 21.0), ("z",): trial(("z",), 11.0)})
    assert pairs._no_partner(trial(("a", "z"), 1 + 1.01 * STUCK * 10.0), search)
    assert not pairs._no_partner(trial(("a", "z"), 1 + 0.99 * STUCK * 10.0), search)
    assert not pairs._no_partner(trial(("x", "y"), 100.0), search)
