"""What passes the gate beside the names found is unlisted: a name must leave what scatter and noise leave."""

from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path

import numpy as np
import pytest
import scipy

import stickslip as ss
from scattering import RIG, case
from stickslip.declared.effect import Effect, Tabulated
from stickslip.discovery.laboratory import curves, search, verdicts
from stickslip.discovery.laboratory.curve_term import curve_term
from stickslip.discovery.laboratory.gate import SearchGate
from stickslip.discovery.laboratory.hypothesis import Bench, ScoredCurve, Term
from stickslip.discovery.laboratory.proven import beside, proven
from stickslip.discovery.laboratory.screen import Screen
from stickslip.discovery.laboratory.search import Searched, SearchStep
from stickslip.discovery.laboratory.trials import Trial
from stickslip.discovery.laboratory.two_degree import bench_of
from stickslip.fitted.data import prepare
from stickslip.likelihoods.fit import fitted
from stickslip.likelihoods.fit import null as fit_null
from stickslip.likelihoods.fit_state import begin
from stickslip.likelihoods.population import MOST
from stickslip.likelihoods.repeating import lost

X1 = np.linspace(-0.8, 0.8, 17)
PULL = ss.tabulated("block", "x1", X1, 0.12 / (0.9 - X1) ** 2)  # of a magnet: no power of x1
CUBIC = ss.effect("spring_cubic_k1", k=4.0)
GATE = 15.0  # of such records, as the search draws it


def fit_of(bench: Bench, terms: tuple[Term, ...]) -> Trial:
    return Trial(terms, fitted(begin(bench.windows(terms)), bench.policy))


@dataclass(frozen=True)
class Left:
    """A search that named a cubic spring where `acts` acts, and the curve that this leaves."""

    bench: Bench
    null: Trial
    named: Trial

    @property
    def searched(self) -> Searched:
        return Searched(self.null, self.named)

    @cached_property
    def curve(self) -> ScoredCurve | None:
        told = verdicts.left_over(self.bench, self.searched, 0)
        return None if told is None else told[0]


def left_by(folder: Path, acts: Effect | Tabulated) -> Left:
    read = ss.load_case(case(folder, (acts,), 0.015, 0.005, 7, few=True))
    bench = bench_of(read, prepare(read.train))
    return Left(bench, fit_of(bench, ()), fit_of(bench, (Term(CUBIC),)))


@pytest.fixture(scope="module")
def pulled(tmp_path_factory: pytest.TempPathFactory) -> Left:
    return left_by(tmp_path_factory.mktemp("pulled"), PULL)


@pytest.fixture(scope="module")
def bent(tmp_path_factory: pytest.TempPathFactory) -> Left:
    return left_by(tmp_path_factory.mktemp("bent"), CUBIC)


def test_a_name_that_only_stands_in_leaves_a_curve(pulled: Left, bent: Left) -> None:
    assert bent.curve is None
    assert pulled.curve is not None
    assert (pulled.curve.where, pulled.curve.variable) == ("block", "x1")
    every = Searched(pulled.named, pulled.named)
    told = verdicts.Verdicts(pulled.bench, every, pulled.curve, pulled.named, beside=True)
    assert told.told is pulled.named
    assert told.fit is pulled.named.fit


@pytest.mark.study
def test_what_names_leave_is_told_from_a_share_of_what_they_explain(pulled: Left) -> None:
    assert pulled.curve is not None
    found, bench = pulled.searched, pulled.bench
    share = np.sqrt(pulled.curve.gain / verdicts.explained_by_names(bench, found))
    for size, told in ((0.9 * share, True), (1.1 * share, False)):
        strict = replace(bench, policy=replace(bench.policy, stands_in=size))
        assert (verdicts.left_over(strict, found, 0) is not None) == told


def test_each_name_beyond_the_first_must_be_worth_what_is_noticed(pulled: Left, bent: Left) -> None:
    """One-way damping had three names that gained 6 more than one curve of the speed does alone."""
    bench, noticed = bent.bench, bent.bench.policy.noticed
    named = bent.named
    three = replace(named, terms=named.terms * 3)
    assert verdicts.more_than_names(bench, bent.null, None) == 0.0
    assert verdicts.more_than_names(bench, named, None) == noticed
    assert verdicts.more_than_names(bench, three, None) == -noticed
    assert pulled.curve is not None
    left = pulled.curve, pulled.named
    assert verdicts.more_than_names(bench, named, left) == 0.0
    assert verdicts.more_than_names(bench, three, left) == -2 * noticed


def test_a_fit_that_leaves_windows_out_is_no_model_of_them(tmp_path: Path) -> None:
    read = ss.load_case(case(tmp_path, (), 0.015, 0.005, 7, few=True))
    fit = fit_of(bench_of(read, prepare(read.train)), ()).fit
    weight = np.ones(len(fit.own))
    for share, gone in ((0.1, False), (0.3, True)):
        weight[: int(share * len(weight))] = 0.01
        assert lost(replace(fit, linear=replace(fit.linear, weight=weight))) == gone


def test_a_curve_beside_which_friction_scatters_without_bound_is_not_told(
    pulled: Left, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Names were held to that, curves were not: one that was next to nothing was told beside a scatter of 78 %."""
    assert pulled.curve is not None
    every = curves.leading(pulled.bench, pulled.named, pulled.named.fit, 0)

    def astray(bench: Bench, base: Trial, curve: ScoredCurve) -> tuple[ScoredCurve, Trial]:
        found, after = proven(bench, base, curve)
        return found, replace(
            after, fit=replace(after.fit, population=replace(after.fit.population, level=MOST))
        )

    assert verdicts._proven(pulled.bench, pulled.named, every) is not None
    monkeypatch.setattr(verdicts, "proven", astray)
    assert verdicts._proven(pulled.bench, pulled.named, every) is None


@pytest.mark.study
def test_a_curve_is_held_against_all_that_a_wave_explains(bent: Left) -> None:
    """What scatter may have of a wave's gain was taken off before a curve was held against it, and the curve won."""
    bench, null, named = bent.bench, bent.null, bent.named
    gain = null.fit.deviance - named.fit.deviance
    assert verdicts.curve_alone(bench, Searched(null, null), 0) is not None
    assert verdicts.curve_alone(bench, Searched(null, replace(named, known=gain - 5.0)), 0) is None


def test_a_number_that_an_effect_may_do_without_is_tried_where_no_score_reaches_it(tmp_path: Path) -> None:
    """The sign of a pivot's speed may be rounded: from 0 no slope shows it, and what it left was called unlisted."""
    rounded = ss.effect("pivot_dry_friction", f=0.1, v_c=0.01)
    read = ss.load_case(case(tmp_path, (rounded,), 0.015, 0.005, 7, few=True))
    bench = bench_of(read, prepare(read.train))
    sharp = fit_of(bench, (Term(ss.effect("pivot_dry_friction", f=0.1)),))
    (found,) = search.leader_anew(bench, Trial((), sharp.fit), [sharp])
    assert found.numbers() == sharp.numbers() + 1
    assert found.worth() < sharp.worth() - GATE
    numbers = found.fit.values()
    assert numbers["pivot_dry_friction.v_c"] == pytest.approx(0.01, rel=0.1)
    assert numbers["pivot_dry_friction.f"] == pytest.approx(0.1, rel=0.03)


@pytest.mark.study
def test_a_curve_that_only_a_score_believes_is_not_told(tmp_path: Path) -> None:
    """An offset of the x1 reading is the law's own level: a score may step along it, a fit gains nothing."""
    read = ss.load_case(case(tmp_path, (PULL,), 0.015, 0.005, 7))
    bench = bench_of(read, prepare(read.train[::2]))
    null = fit_of(bench, ())
    seen = bench.curves(null.fit)
    real = max(seen, key=lambda one: one.worth(len(bench.stretches)))
    assert (real.where, real.variable) == ("block", "x1")
    gain = null.fit.deviance - beside(bench, null, real).fit.deviance
    assert gain == pytest.approx(real.gain, rel=0.2)
    other = next(one for one in seen if (one.where, one.variable) == ("x1 channel", "t"))
    assert other.effect is not None
    for size in (0.0, 0.05):
        offset = replace(other, effect=other.effect.replace(**dict.fromkeys(other.effect.parameters, size)))
        gain = null.fit.deviance - beside(bench, null, offset).fit.deviance
        assert -1.0 < gain < bench.policy.noticed


@pytest.mark.parametrize("levelled", [False, True])
def test_what_a_stuck_fit_was_short_of_is_no_curve(levelled: bool) -> None:
    """A fit that got free beside a curve fell by thousands: that was told as a curve whose values were nothing."""
    x = np.linspace(-1.0, 1.0, 5)
    free = scipy.linalg.null_space(np.full((1, 5), 0.2)) if levelled else np.eye(5)
    known = np.diag([1.0, 1.0, 0.0 if levelled else 1.0, 1.0, 1.0])  # one value is where the law has a level
    scored = ScoredCurve("block", "x1", 2000.0, x, x, x, free.shape[1], [], free=free, threshold=10.0)
    for size, told in ((0.01, False), (1.0, True)):
        fitted_there = scored.fitted(size * x, 0.02**2 * known, 5955.0)
        assert fitted_there.worth(30) > 5000.0
        assert fitted_there.passes(30) == told
    real = scored.fitted(x, 0.02**2 * known, 5955.0)
    assert real.told == pytest.approx(x @ x / 0.02**2)


def test_the_curve_that_is_told_is_the_model_s() -> None:
    """What was left out for the law's level was no constant: the report drew a curve of another shape."""
    x, mean = np.linspace(-1.0, 1.0, 5), np.array([0.5, 0.2, 0.1, 0.1, 0.1])
    free = scipy.linalg.null_space(mean[None])
    scored = ScoredCurve("contact", "v_w", 900.0, x, x, x, 4, [], free=free, threshold=10.0)
    root = np.random.default_rng(0).standard_normal((5, 5))
    root[2] = 0.0  # one value stays where it is
    there = scored.fitted(x**2, root @ root.T, 900.0)
    np.testing.assert_array_equal(there.value, x**2)
    # errors and worth do not depend on where the law has its level: here on the mean
    shift = np.eye(5) - mean
    moved = scored.fitted(shift @ x**2, shift @ root @ root.T @ shift.T, 900.0)
    np.testing.assert_allclose(there.std, moved.std, rtol=1e-9)
    assert there.told == pytest.approx(moved.told)
    assert scored.fitted(np.full(5, 3.0), root @ root.T, 900.0).told == pytest.approx(0.0, abs=1e-9)


@pytest.mark.study
def test_names_that_stand_fall_only_to_what_is_better_by_as_much_as_is_asked(bent: Left) -> None:
    alone = Searched(bent.null, bent.null)
    told = verdicts.curve_alone(bent.bench, alone, 0)
    assert told is not None
    gain = bent.null.fit.deviance - told[1].fit.deviance
    assert verdicts.curve_alone(bent.bench, alone, 0, more=0.5 * gain) is not None
    assert verdicts.curve_alone(bent.bench, alone, 0, more=2.0 * gain) is None


def test_a_curve_that_adds_nothing_to_names_is_not_fitted_in_their_place(
    bent: Left, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Fitting curves that could not replace a right name took longer than to find it."""
    x = np.linspace(-1.0, 1.0, 5)
    scored = [
        ScoredCurve("block", variable, 900.0, x, x, x, 4, [], threshold=10.0)
        for variable in ("x1", "x2", "t")
    ]
    monkeypatch.setattr(verdicts, "leading", lambda *_: scored)
    asked = list[str]()
    monkeypatch.setattr(verdicts, "proven", lambda _, __, one: asked.append(one.variable) or (one, bent.null))
    alone = Searched(bent.null, bent.null)
    over = [replace(scored[0], gain=12.0), replace(scored[1], gain=60.0)]
    verdicts.curve_alone(bent.bench, alone, 0, more=20.0, over=over)
    assert set(asked) == {"x2", "t"}  # of the last nothing is known
    asked.clear()
    verdicts.curve_alone(bent.bench, alone, 0, over=over)
    assert set(asked) == {"x1", "x2", "t"}


@pytest.mark.parametrize(
    ("where", "variable", "name", "share"),
    [("block", "x2", "block_viscous_damping.c", -1.0), ("x1 channel", "t", "sensor_drift.r", 1.0)],
)
def test_a_straight_curve_has_the_columns_of_the_name_that_it_is(
    bent: Left, where: str, variable: str, name: str, share: float
) -> None:
    """A force was a change of friction along x1: its columns and those of a damper had a correlation of 0.1 to 0.5."""
    bench, fit, knots = bent.bench, bent.null.fit, np.array([-50.0, 0.0, 200.0])
    p, owner = len(fit.at), name.partition(".")[0]
    straight = bench.windows((curve_term(ss.tabulated(where, variable, knots, np.zeros(3))),))
    named = bench.windows((Term(ss.effect(owner, **{name.rpartition(".")[2]: 1e-12})),))
    at = np.concatenate([fit.at, np.zeros(3)])
    curve = straight.columns(at, fit.own, range(p, p + 3))
    effect = named.columns(np.concatenate([fit.at, [1e-12]]), fit.own, [p])
    for one, other in zip(curve, effect, strict=True):
        assert one is not None
        assert other is not None
        np.testing.assert_allclose(one @ (share * knots), other[:, :, 0], atol=1e-5 * np.abs(other).max())


@pytest.mark.study
def test_names_that_passed_fall_to_a_curve_beside_them_that_passes_by_more_than_is_noticed(
    pulled: Left,
) -> None:
    """A right name fell to one that was worth 4 beyond the gate."""
    assert pulled.curve is not None
    worth = pulled.curve.worth(len(pulled.bench.stretches))
    for beyond, told in ((30.0, True), (10.0, False)):
        step = SearchStep(pulled.null, Screen((), ()), [], SearchGate(np.zeros(1), worth - beyond))
        found = Searched(pulled.null, pulled.named, [step])
        assert (verdicts.left_over(pulled.bench, found, 0) is not None) == told


@pytest.mark.study
def test_a_curve_passes_no_gate_that_a_name_would_not(bent: Left) -> None:
    """Where nothing acted a curve was worth 2 beyond its own gate, of 0, and names had to be worth 17."""
    told = verdicts.curve_alone(bent.bench, Searched(bent.null, bent.null), 0)
    assert told is not None
    worth = told[0].worth(len(bent.bench.stretches))
    for gate, passes in ((0.5 * worth, True), (2.0 * worth, False)):
        step = SearchStep(bent.null, Screen((), ()), [], SearchGate(np.zeros(1), gate))
        found = verdicts.curve_alone(bent.bench, Searched(bent.null, bent.null, [step]), 0)
        assert (found is not None) == passes


@pytest.mark.study
def test_a_torque_has_a_level_of_its_own_while_all_slip_one_way(tmp_path: Path) -> None:
    """Its mean was taken for the law's: what was fitted without it had beta3 half of what it is, and another curve."""
    y1 = np.linspace(-0.9, 0.7, 17)
    acts = ss.tabulated("angle_body", "y1", y1, 0.15 + 0.3 * np.sin(3 * y1) ** 2)
    read = ss.load_case(case(tmp_path, (acts,), 0.015, 0.005, 7))
    bench = bench_of(read, prepare([one for one in (*read.train, *read.validate) if one.belt_speed > 0]))
    assert bench.one_way
    null = Trial((), fit_null(bench.windows(), bench.policy, twice=True))
    (curve,) = [one for one in bench.curves(null.fit) if (one.where, one.variable) == ("angle_body", "y1")]
    found, after = proven(bench, null, curve)
    numbers = after.fit.values()
    assert numbers["beta3"] == pytest.approx(4.0, rel=0.2)
    # a spring that is a little off is a slope
    torque = found.value - (numbers["beta3"] - RIG["beta3"]) * found.x
    np.testing.assert_allclose(torque, acts.curve(found.x), atol=0.15)


def test_a_curve_of_the_belt_begins_with_the_motions_that_there_were(pulled: Left) -> None:
    """Beside belts that had taken it already it acted twice, and a fit that began there went astray."""
    bench, null = pulled.bench, pulled.null
    (curve,) = [one for one in bench.curves(null.fit) if one.where == "belt"]
    there = replace(bench, policy=replace(bench.policy, candidate_steps=0))
    begins = beside(there, null, curve).fit
    assert begins.deviance < null.fit.deviance
    twice = replace(curve, events=[None if one is None else 2 * one for one in curve.events])
    assert beside(there, null, twice).fit.deviance > begins.deviance


@pytest.mark.study
def test_a_belt_that_warms_up_is_a_curve_of_its_speed(tmp_path: Path) -> None:
    """No name has it, and no curve of a force or a reading moves sticks."""
    path = case(tmp_path, (), 0.015, 0.005, 7, warms=lambda t: 1.0 - 0.1 * np.exp(-t / 15.0))
    read = ss.load_case(path)
    bench = bench_of(read, prepare(read.train))
    null = Trial((), fit_null(bench.windows(), bench.policy, twice=True))
    told = verdicts.curve_alone(bench, Searched(null, null), 0)
    assert told is not None
    curve, after = told
    assert (curve.where, curve.variable) == ("belt", "t")
    assert after.fit.population.belt < 0.5 * null.fit.population.belt
    there = -0.1 * np.exp(-curve.x / 15.0)
    assert curve.value[-1] - curve.value[0] == pytest.approx(there[-1] - there[0], rel=0.3)


@pytest.mark.study
def test_the_gate_of_curves_is_drawn_for_curves(tmp_path: Path) -> None:
    """Events that remember make curves in t: what is told must pass a gate that such records set."""
    read = ss.load_case(case(tmp_path, (), 0.02, 0.005, 9))
    bench = bench_of(read, prepare(read.train))
    null = fit_of(bench, ())
    every = bench.curves(null.fit)
    least = curves.drawn(bench, null.fit, null.fit, every, 0)
    assert 0.0 <= least < 60.0
    assert not curves.leading(bench, null, null.fit, 0)
    own = null.fit.own.copy()
    begins, kinetic = null.fit.windows.begins, null.fit.windows.kinetic
    for members in null.fit.windows.by_run:
        own[members, begins + kinetic.start : begins + kinetic.stop] += np.linspace(-0.1, 0.1, len(members))[
            :, None
        ]
    remembering = replace(null.fit, own=own)
    assert curves.drawn(bench, null.fit, remembering, every, 0) > least
