"""Columns and scores of a search, however they are computed, and what is held against what at its end."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from discover_cases import spring_bench
from stickslip.declared.uncertainty import Uncertainty
from stickslip.discovery.laboratory import block, outcome, trials, verdicts
from stickslip.discovery.laboratory import search as searching
from stickslip.discovery.laboratory.belt_bench import BeltBench
from stickslip.discovery.laboratory.gate import SearchGate
from stickslip.discovery.laboratory.hypothesis import Term, of_term, term
from stickslip.discovery.laboratory.outcome import evidence
from stickslip.discovery.laboratory.screen import Screen, screened
from stickslip.discovery.laboratory.search import Searched, SearchStep, told_by_sizes
from stickslip.discovery.laboratory.trials import Trial, all_full
from stickslip.discovery.laboratory.waves import SMALL, waves_at
from stickslip.discovery.workers import Workers
from stickslip.likelihoods.fit import null
from stickslip.likelihoods.fit_state import Fit

W = 2.3


@pytest.fixture(scope="module")
def bench() -> BeltBench:
    return spring_bench()


@pytest.fixture(scope="module")
def fit(bench: BeltBench) -> Fit:
    return null(bench.windows(), bench.policy)


def test_columns_alone_are_those_of_the_whole_blocks(fit: Fit) -> None:
    """A gain's too, though the window's own belt is left out where no gain scales it."""
    windows = fit.windows
    for shared in ([0, 3], range(len(fit.at))):
        whole = windows.blocks(fit.at, fit.own, shared=shared, local=False)
        for a, b in zip(windows.columns(fit.at, fit.own, list(shared)), whole, strict=True):
            assert a is not None
            assert b is not None
            np.testing.assert_array_equal(a, b[:, :, :-1])
    assert any(n.name.startswith("gain.") for n in windows.numbers)


@pytest.mark.parametrize("name", ["harmonic_forcing", "belt_speed_ripple", "belt_seam"])
def test_a_wave_s_cosine_is_what_it_is_at_another_phase(bench: BeltBench, fit: Fit, name: str) -> None:
    (kind,) = [one for one in bench.kinds() if one.name == name]
    assert kind.wave is not None
    number = 2 * math.pi / W if kind.wave.along_belt else W
    turned = (0.5 * math.pi,) * len(bench.data)
    one = term(
        kind, {"a": SMALL * kind.parameter("a").unit, kind.wave.parameter: number, "phi": turned[0]}, turned
    )
    at = np.concatenate([fit.at, [n.start for n in of_term(one, bench.policy)]])
    cosine = bench.windows((one,)).blocks(at, fit.own, shared=[len(fit.at)], local=False)
    for a, b in zip(waves_at(bench, fit, (), kind, [W])[0].columns, cosine, strict=True):
        assert a is not None
        assert b is not None
        assert np.abs(b[:, :, 0]).max() > 1.0
        np.testing.assert_allclose(a[:, :, 1], b[:, :, 0], atol=5e-3 * np.abs(b[:, :, 0]).max())
        assert np.abs(a[:, :, 1] - a[:, :, 0]).max() > 0.1 * np.abs(b[:, :, 0]).max()


def test_several_processes_find_the_same_to_the_last_digit(bench: BeltBench, fit: Fit) -> None:
    workers = Workers(2)
    one, two = screened(bench, fit, ()), screened(bench, fit, (), workers)
    assert [c.term for c in one.ranked] == [c.term for c in two.ranked]
    assert [c.gain for c in one.ranked] == [c.gain for c in two.ranked]
    base, best = Trial((), fit), one.ranked[:2]
    alone, beside = (all_full(bench, base, best, each)[0] for each in (Workers(1), workers))
    assert [t.deviance for t in alone] == [t.deviance for t in beside]


def test_an_effect_alone_is_held_against_the_declared_model(bench: BeltBench, fit: Fit) -> None:
    """What was left out while it stood beside another says nothing of it alone."""
    (kind,) = [one for one in bench.kinds() if one.name == "spring_cubic_k1"]
    base = Trial((), fit)
    one = Trial((term(kind, {"k": 4.0}),), replace(fit, deviance=fit.deviance - 100.0))
    stale = Trial((), replace(fit, deviance=fit.deviance + 900.0))
    step = SearchStep(base, Screen((), ()), [one], SearchGate(np.array([5.0]), 10.0))
    said = evidence(Searched(base, one, [step], {"spring_cubic_k1": stale}), "spring_cubic_k1")
    assert said.delta_chi2 == pytest.approx(100.0)


def test_what_scatter_has_of_a_wave_its_own_gate_asks(bench: BeltBench, fit: Fit) -> None:
    """A seam that gained 430 was never asked: events that remember might have made all but 12 of it."""
    (kind,) = [one for one in bench.kinds() if one.name == "belt_seam"]
    one = Trial(
        (term(kind, {"a": 0.1, "L": 1.5, "phi": 0.0}, (0.0,) * len(bench.data)),),
        replace(fit, deviance=fit.deviance - 400.0, solution=None),
        known=395.0,
    )
    base = Trial((), fit)
    for each in (base, one):
        each.__dict__["remembered"] = 0.0
    step = SearchStep(base, Screen((), ()), [one], SearchGate(np.array([5.0]), 10.0))
    assert one.comes_and_goes
    assert step.gained(one) < step.gate.threshold < one.explains(base)
    assert step.promises(one)
    assert not step.passes(one)
    for observed, told in ((15.0, False), (25.0, True)):
        step.waves["belt_seam"] = SearchGate(np.array([5.0]), 20.0, observed)
        assert step.passes(one) == told


def test_a_size_that_only_its_width_leaves_open_is_told(bench: BeltBench, fit: Fit) -> None:
    """Of a peak narrower than the readings tell, height times width is known to 10 %, neither of them alone."""
    (kind,) = [one for one in bench.kinds() if one.name == "stribeck_peak"]
    one = term(kind, {"dT": 0.5, "v_s": 0.02})
    windows = bench.windows((one,))
    p, joint, apart = len(fit.at), 0.1, 2.0
    size = next(n.start for n in windows.numbers if n.name == "stribeck_peak.dT")
    assert [n.logarithmic for n in windows.numbers[p:]] == [False, True]
    # logarithms of height and width: their sum to `joint`, their difference to `apart`
    logs = (
        np.array([[joint**2 + apart**2, joint**2 - apart**2], [joint**2 - apart**2, joint**2 + apart**2]]) / 4
    )
    scale = np.diag([size, 1.0])
    covariance = np.eye(p + 2)
    covariance[p:, p:] = scale @ logs @ scale
    assert fit.solution is not None
    at = np.array([*fit.at, *(n.start for n in windows.numbers[p:])])
    there = replace(fit, windows=windows, at=at, solution=replace(fit.solution, covariance=covariance))
    price = math.log(len(fit.own))
    # the width held, the height is known as their product is
    held = 1 / logs[0, 0] / (1 - logs[0, 1] ** 2 / logs[0, 0] / logs[1, 1])
    assert told_by_sizes(Trial((one,), there)) + price == pytest.approx(held, rel=1e-6)
    assert held == pytest.approx(1 / joint**2, rel=0.01)
    assert size**2 / covariance[p, p] < 1.1


@pytest.mark.parametrize("name", ["friction_memory", "sensor_lag", "sensor_delay"])
def test_a_time_alone_tells_as_much_as_its_own_error_does(bench: BeltBench, fit: Fit, name: str) -> None:
    """A memory of friction 0.0052 +- 0.0025 long gained 26: its fit had come further than the one without."""
    (kind,) = [one for one in bench.kinds() if one.name == name]
    (number,) = kind.parameters
    one = term(kind, {number.name: 0.0052})
    windows = bench.windows((one,))
    (own,) = windows.numbers[len(fit.at) :]
    std = 0.0025 / own.slope(own.start)  # of the number as it is fitted
    covariance = np.eye(len(fit.at) + 1)
    covariance[-1, -1] = std**2
    assert fit.solution is not None
    at = np.array([*fit.at, own.start])
    there = replace(fit, windows=windows, at=at, solution=replace(fit.solution, covariance=covariance))
    told = (0.0052 / 0.0025) ** 2 - math.log(len(fit.own))
    assert told_by_sizes(Trial((one,), there)) == pytest.approx(told, rel=1e-6)


def test_a_contact_that_its_score_promises_nothing_stays_a_candidate(bench: BeltBench, fit: Fit) -> None:
    """Where a null is no model of the windows a score says little: one was left out for four wrong names."""
    (one,) = [c for c in screened(bench, fit, ()).ranked if c.term.name == "contact_compliance"]
    assert one.gain == 0
    assert one.worth(len(bench.stretches)) < 0


@pytest.mark.parametrize("swells", ["nothing", "the law", "its rival", "both"])
def test_the_gate_is_asked_where_the_motion_is_that_of_the_readings(
    bench: BeltBench, fit: Fit, monkeypatch: pytest.MonkeyPatch, swells: str
) -> None:
    """Records drawn where friction scatters by 30 %, of the law or of a rival, hid what gained 1,475 and 55,900."""
    usual = fit.windows.scatter()
    (kind,) = [one for one in bench.kinds() if one.name == "spring_cubic_k1"]
    wide = replace(usual, static=0.3)
    law, rival = (wide if swells in (one, "both") else usual for one in ("the law", "its rival"))
    null = Trial((), replace(fit, population=law))
    best = Trial((term(kind, {"k": 4.0}),), replace(fit, population=rival, deviance=fit.deviance - 1475.0))
    asked: list[tuple[Fit, Fit]] = []

    def gate(_: BeltBench, at: Fit, screen: Screen, __: int, like: Fit) -> SearchGate:
        asked.append((at, like))
        assert screen is screens[at.deviance]
        return SearchGate(np.array([5.0]), 1200.0 if at.deviance == fit.deviance else 9.0)

    screens = {one.fit.deviance: Screen((), ()) for one in (null, best)}
    monkeypatch.setattr(searching, "gate", gate)
    monkeypatch.setattr(searching, "screened", lambda _, at, *__: screens[at.deviance])
    monkeypatch.setattr(searching, "explained", lambda _: True)
    monkeypatch.setattr(searching, "all_full", lambda *_: ([best], ()))
    monkeypatch.setattr(searching, "leader_anew", lambda *_: [best])
    monkeypatch.setattr(searching, "told_by_sizes", lambda _: math.inf)
    monkeypatch.setattr(searching, "with_wrong_constant", lambda *_: best)
    monkeypatch.setattr(searching, "again_from", lambda _, base, __: base)
    one = replace(bench, policy=replace(bench.policy, most_effects=1))
    known = Uncertainty(bench.model.rig, {}, {}, {})
    found = searching.search(one, known, lambda _: None, base=null)
    ((at, like),), beside = asked, swells == "the law"
    assert at.deviance == (best.deviance if beside else fit.deviance)
    assert like is (null.fit if swells == "its rival" else best.fit)
    assert found.steps[0].gate.threshold == (9.0 if beside else 1200.0)


@pytest.mark.parametrize(
    ("gained", "usual", "named"), [(11.0, True, False), (60.0, True, True), (60.0, False, True)]
)
def test_a_wave_has_a_gate_of_its_own(
    bench: BeltBench, fit: Fit, monkeypatch: pytest.MonkeyPatch, gained: float, usual: bool, named: bool
) -> None:
    """A smooth field of 2.7 % had the name of a seam, as the draws scattered by the 1.2 % that the seam left."""
    (kind,) = [one for one in bench.kinds() if one.name == "belt_seam"]
    seam = term(kind, {"a": 0.1, "L": 3.0, "phi": 0.0}, (0.0,) * len(bench.data))
    scatter = fit.windows.scatter()
    null = Trial((), replace(fit, population=scatter if usual else replace(scatter, static=0.3)))
    best = Trial((seam,), replace(fit, windows=bench.windows((seam,)), deviance=fit.deviance - 60.0))
    asked: list[Fit] = []

    def refitted(
        _: BeltBench, at: Fit, __: Screen, name: str, ___: int, like: Fit, ____: Workers
    ) -> SearchGate:
        assert (at, name) == (null.fit, "belt_seam")
        asked.append(like)
        return SearchGate(np.array([5.0]), 58.0, gained)

    monkeypatch.setattr(searching, "refitted", refitted)
    monkeypatch.setattr(searching, "gate", lambda *_: SearchGate(np.array([5.0]), 6.0))
    monkeypatch.setattr(searching, "screened", lambda *_: Screen((), ()))
    monkeypatch.setattr(searching, "explained", lambda _: True)
    monkeypatch.setattr(searching, "all_full", lambda *_: ([best], ()))
    monkeypatch.setattr(searching, "leader_anew", lambda *_: [best])
    monkeypatch.setattr(searching, "told_by_sizes", lambda _: math.inf)
    monkeypatch.setattr(searching, "with_wrong_constant", lambda *given: given[-1])
    monkeypatch.setattr(searching, "again_from", lambda _, base, __: base)
    one = replace(bench, policy=replace(bench.policy, most_effects=1))
    known = Uncertainty(bench.model.rig, {}, {}, {})
    found = searching.search(one, known, lambda _: None, base=null)
    assert found.chosen.terms == ((seam,) if named else ())
    # a null that is no model of the windows has no scatter worth drawing
    assert asked == [null.fit if usual else best.fit]
    told = outcome.gate(found)
    assert (told.observed, told.threshold) == (gained, 58.0)


@pytest.mark.parametrize(("gained", "named"), [(2.0, False), (40.0, True)])
def test_a_name_stands_beside_the_wave_that_scatter_may_have_made(
    bench: BeltBench, fit: Fit, monkeypatch: pytest.MonkeyPatch, gained: float, named: bool
) -> None:
    """Friction that follows the angle body was named where nothing acted; waves as scatter has explained far more."""
    kinds = {one.name: one for one in bench.kinds()}
    own = term(kinds["spring_cubic_k1"], {"k": 4.0})
    seam = term(kinds["belt_seam"], {"a": 0.1, "L": 3.0, "phi": 0.0}, (0.0,) * len(bench.data))
    null = Trial((), replace(fit, population=fit.windows.scatter()))

    def made(terms: tuple[Term, ...], gain: float) -> Trial:
        there = replace(fit, windows=bench.windows(terms), deviance=fit.deviance - gain)
        return Trial(terms, there)

    name, wave = made((own,), 40.0), made((seam,), 90.0)
    monkeypatch.setattr(Trial, "remembered", 0.0)
    monkeypatch.setattr(searching, "screened", lambda *_: Screen((), ()))
    monkeypatch.setattr(searching, "all_full", lambda *_: ([wave, name], ()))
    monkeypatch.setattr(searching, "leader_anew", lambda _, __, found, *___: found)
    monkeypatch.setattr(searching, "again_from", lambda _, base, __: base)
    monkeypatch.setattr(searching, "told_by_sizes", lambda _: math.inf)
    monkeypatch.setattr(searching, "gate", lambda *_: SearchGate(np.array([5.0]), 6.0))
    monkeypatch.setattr(searching, "refitted", lambda *_: SearchGate(np.array([5.0]), 99.0, 80.0))
    monkeypatch.setattr(searching, "fitted_beside", lambda *_: made((seam, own), 90.0 + gained))
    monkeypatch.setattr(searching, "with_wrong_constant", lambda *given: given[-1])
    one = replace(bench, policy=replace(bench.policy, most_effects=1))
    known = Uncertainty(bench.model.rig, {}, {}, {})
    found = searching.search(one, known, lambda _: None, base=null)
    assert found.chosen.terms == ((own,) if named else ())


@pytest.mark.parametrize(
    ("named", "left", "alone", "told"),
    [
        (True, None, "a little better", (None, False)),
        (True, None, "far better", ("far better", False)),
        (True, "rest", None, ("rest", True)),
        (True, "rest", "a little better", ("a little better", False)),
        (False, None, "a little better", ("a little better", False)),
        (False, None, None, (None, False)),
    ],
)
def test_names_that_leave_no_curve_over_stand(
    bench: BeltBench,
    fit: Fit,
    monkeypatch: pytest.MonkeyPatch,
    named: bool,
    left: str | None,
    alone: str | None,
    told: tuple[str | None, bool],
) -> None:
    """
    A drift was told as any curve in t, which followed the scatter beside it a little better; it left nothing.

    An end stop was told as a cubic spring and a damping, which left nothing either.
    """
    null = Trial((), fit)
    (kind,) = [one for one in bench.kinds() if one.name == "spring_cubic_k1"]
    chosen = Trial((term(kind, {"k": 4.0}),), fit) if named else null
    monkeypatch.setattr(verdicts, "search", lambda *_: Searched(null, chosen))
    monkeypatch.setattr(verdicts, "closed", lambda one, _: one)
    monkeypatch.setattr(BeltBench, "curves", lambda *_: [])
    monkeypatch.setattr(verdicts, "left_over", lambda *_: None if left is None else (left, fit))
    better = {"a little better": 1.0, "far better": 2 * bench.policy.noticed}
    monkeypatch.setattr(
        verdicts,
        "curve_alone",
        lambda *given: (alone, fit) if alone is not None and better[alone] > given[4] else None,
    )
    found = verdicts.searched(bench, Uncertainty(bench.model.rig, {}, {}, {}), lambda _: None, 0, base=null)
    assert (found.curve, found.beside) == told


def test_what_a_wave_shares_with_events_that_remember_is_counted_once(
    bench: BeltBench, fit: Fit, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A force worth 5,000 was worth nothing: memory that it took from the null was no finding, and was so twice."""
    (kind,) = [one for one in bench.kinds() if one.name == "belt_seam"]
    seam = term(kind, {"a": 0.1, "L": 3.0, "phi": 0.0}, (0.0,) * len(bench.data))
    monkeypatch.setattr(trials, "of_scatter", lambda *_: 40.0)
    for remembers, known in ((60.0, 0.0), (30.0, 10.0), (0.0, 40.0)):
        fits = {True: fit, False: replace(fit, windows=bench.windows((seam,)))}
        gains = {id(fits[True]): remembers, id(fits[False]): 0.0}
        monkeypatch.setattr(trials, "remembered", lambda one, gains=gains: gains[id(one)])
        base = Trial((), fits[True])
        monkeypatch.setattr(trials, "terms_at", lambda terms, *_: terms)
        beside = trials.trial_beside(bench, base, fits[False], seam)
        assert beside.known == known
        price = beside.numbers() * math.log(len(fit.own))
        assert base.whole() - beside.whole() == pytest.approx(-remembers - price)
        assert base.worth() - beside.worth() == pytest.approx(-remembers - price - known)


def test_waves_of_scatter_are_those_of_what_goes_with_them_in_a_slip(bench: BeltBench, fit: Fit) -> None:
    """A slow wave is the mean's: a force of 2,467 was taken for one, and so was one much faster than a slip."""
    kinds = {one.name: one for one in bench.kinds()}
    seam = term(kinds["belt_seam"], {"a": 0.1, "L": 1e3, "phi": 0.0}, (0.0,) * len(bench.data))
    force = term(kinds["harmonic_forcing"], {"a": 0.1, "w": 1e-3, "phi": 0.0}, (0.0,) * len(bench.data))
    alone = replace(fit, own=np.zeros_like(fit.own))  # events that remember nothing

    def waves(one: Term, **scatter: float) -> float:
        made = replace(fit.population, **{"level": 0.0, "curve": 0.0} | scatter)
        return bench.scattered(replace(alone, population=made), one)

    events = len(bench.stretches) / len(bench.data)
    assert waves(seam, level=0.03) == pytest.approx(0.03 * math.sqrt(2 / events), rel=1e-3)
    assert waves(force, level=0.03) == pytest.approx(waves(seam, level=0.03) * 5.94, rel=1e-3)
    assert waves(seam, curve=0.03, length=100.0) == pytest.approx(waves(seam, level=0.03), rel=1e-3)
    # numbers that know nothing of each other
    least = waves(seam, level=0.03) / math.sqrt(bench.policy.knots)
    assert least < waves(seam, curve=0.03, length=1e-3) < 2 * least
    assert waves(seam, level=0.03, curve=0.04, length=100.0) == pytest.approx(
        waves(seam, level=0.05), rel=1e-3
    )

    # of a level what the wave leaves when it is averaged over the slip
    fast = replace(force, effect=force.effect.replace(w=9.0))
    parts = []
    for motion in fit.windows.motions(alone.at, alone.own):
        assert motion is not None
        parts.append(abs(np.exp(9j * motion.t[motion.mode != 0]).mean()) ** 2)
    assert np.mean(parts) < 0.05
    assert waves(fast, level=0.03) == pytest.approx(
        waves(force, level=0.03) * math.sqrt(np.mean(parts)), rel=1e-3
    )
    assert waves(fast, curve=0.03, length=0.1) > waves(fast, level=0.03)


@pytest.mark.parametrize(("more", "told"), [({}, True), ({"curve": 0.15}, False), ({"belt": 0.02}, False)])
def test_a_block_that_hardly_sticks_is_no_case_for_windows(
    bench: BeltBench, fit: Fit, more: dict[str, float], told: bool
) -> None:
    """Where nothing lacked, friction scattered by 13 %, the belt by all it may, and a lag was named beside it."""
    chosen = Trial((), replace(fit, population=replace(fit.windows.scatter(), **more)))
    assert block.is_a_model(verdicts.Verdicts(bench, Searched(chosen, chosen), None, chosen)) == told


def test_no_effect_is_taken_away_where_nothing_moves_without_it(
    bench: BeltBench, fit: Fit, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A fit that ends at numbers no window can be simulated with gave up the whole search."""
    kinds = {one.name: one for one in bench.kinds()}
    terms = (
        term(kinds["spring_cubic_k1"], {"k": 4.0}),
        term(kinds["pivot_dry_friction"], {"f": 0.1, "v_c": 0.0}),
    )
    windows = bench.windows(terms)
    at = np.array([*fit.at, *(n.start for n in windows.numbers[len(fit.at) :])])
    both = Trial(terms, replace(fit, windows=windows, at=at))

    def fails(*_: object, **__: object) -> None:
        raise FloatingPointError

    monkeypatch.setattr(trials, "fitted", fails)
    monkeypatch.setattr(searching, "with_wrong_constant", lambda *given: given[-1])
    one = replace(bench, policy=replace(bench.policy, most_effects=2))
    known = Uncertainty(bench.model.rig, {}, {}, {})
    assert searching.search(one, known, lambda _: None, base=both).chosen is both
    # nor does a number that the leader may do without
    one_less = Trial(terms[:1], fit)
    assert trials.leader_anew(bench, one_less, [both], done=("pivot_dry_friction",)) == [both]
