"""A block on a belt in a laboratory: searched in scaled numbers, said in the declared ones."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from stickslip.declared.catalogue import CONSTANTS
from stickslip.declared.effect_kind import EffectKind
from stickslip.declared.model import Model
from stickslip.declared.rig import LONG
from stickslip.declared.scale import percent
from stickslip.declared.uncertainty import GAINS
from stickslip.discovery.carry_over import claimed
from stickslip.discovery.laboratory import outcome
from stickslip.discovery.laboratory.belt_bench import BeltBench
from stickslip.discovery.laboratory.block_bench import bench_of
from stickslip.discovery.laboratory.block_errors import error_block
from stickslip.discovery.laboratory.block_views import Motion, validate_view, view
from stickslip.discovery.laboratory.block_words import absorbed, experiments, ridden, set_point
from stickslip.discovery.laboratory.carried import likelihood
from stickslip.discovery.laboratory.constants import Freed
from stickslip.discovery.laboratory.left import left
from stickslip.discovery.laboratory.rival_kind import RivalKind
from stickslip.discovery.laboratory.said_of_constants import said_of_constants
from stickslip.discovery.laboratory.scaled import found as in_declared
from stickslip.discovery.laboratory.scaled import in_units
from stickslip.discovery.laboratory.search import Searched
from stickslip.discovery.laboratory.single_events import NOWHERE, Single, single
from stickslip.discovery.laboratory.trials import Trial
from stickslip.discovery.laboratory.unused import stood_out, with_windows
from stickslip.discovery.laboratory.verdicts import Verdicts, beside_a_hum, searched
from stickslip.discovery.laboratory.wrong_constant import evidence_of, rivals_of
from stickslip.discovery.residual import spectrum
from stickslip.discovery.result import (
    Found,
    FoundEffect,
    Rival,
    RunView,
    Verdict,
)
from stickslip.discovery.set_points import doubtful_set_points
from stickslip.discovery.workers import ALONE, Workers
from stickslip.errors import StickslipError
from stickslip.fitted.block_events.table import MeasuredBlock, measure
from stickslip.fitted.block_events.table import prepare as prepare_events
from stickslip.fitted.data import Data
from stickslip.likelihoods.fit import null
from stickslip.likelihoods.fit_state import Fit, unexplained
from stickslip.likelihoods.interval import Interval
from stickslip.likelihoods.repeating import ENOUGH, lost, repeats, wild
from stickslip.likelihoods.scaled import Scaled
from stickslip.measured.case import Case
from stickslip.measured.stick_speed import NEAR, wrong_set_point

NOT_AFTER = (
    "the curve found is not in the model after: one of the reading in x2 cannot be undone where x1 alone is recorded, "
    "so that no forecast could begin"
)


@dataclass(frozen=True)
class BlockSearch:
    """
    A case as it was searched.

    Parameters
    ----------
    case, units : as declared
    data : all runs, those of the fit first, in scaled numbers
    verdicts : what was searched
    """

    case: Case
    units: Scaled
    data: Sequence[Data]
    verdicts: Verdicts[BeltBench]


def discover(case: Case, tell: Callable[[str], None], seed: int, workers: Workers = ALONE) -> Found:
    """
    Return what the declared model lacks.

    Parameters
    ----------
    case : of a `BlockOnBelt`
    tell : told what is being done
    seed : of the gate's draws
    workers : do what does not wait for one another

    Raises
    ------
    InputError
        See `bench_of`.
    StickslipError
        No law of the declared kind moves the block like the readings.
    """
    began = time.monotonic()
    bench, units, data, left_out = bench_of(case)
    case, unused = with_windows(case, bench.data, bench.stretches, left_out)
    verdicts, said = _verdicts(bench, case, tell, seed, workers)
    searched = BlockSearch(case, units, data, verdicts)
    found = claimed(
        _found(searched, tell, began, workers),
        (_found(replace(searched, verdicts=less), tell, began, workers) for less in verdicts.fewer()),
        lambda: _found(replace(searched, verdicts=verdicts.silent()), tell, began, workers),
    )
    return replace(found, messages=(*said, *unused, *found.messages))


def _verdicts(
    bench: BeltBench, case: Case, tell: Callable[[str], None], seed: int, workers: Workers
) -> tuple[Verdicts[BeltBench], tuple[str, ...]]:
    """What windows say, and why they say nothing where they are few, or where no law of this kind moves like them."""
    count, least = len(bench.stretches), bench.policy.fewest_windows
    if count < least and not _alike(alone := _untried(bench)):
        few = f"{count} stretches from stick to stick, or from slip to slip, in the train runs"
        return alone, (f"nothing is tried: {few}; {least} are needed to see how friction scatters",)
    try:
        verdicts = searched(bench, case.uncertainty, tell, seed, workers=workers)
    except (FloatingPointError, np.linalg.LinAlgError):
        verdicts = _untried(bench)
    verdicts = _told_alone(beside_a_hum(verdicts, left(verdicts.bench, verdicts.searched.null.fit)))
    out = stood_out(bench.stretches, verdicts.bench.stretches)
    return (verdicts, out) if is_a_model(verdicts) else (verdicts.silent(), (*out, _neither(verdicts.fit)))


def _alike(verdicts: Verdicts[BeltBench]) -> bool:
    """Whether every event is seen to be like every other, so that a few tell as much as many."""
    fit = verdicts.fit
    return repeats(fit) and max(len(one) for one in fit.windows.by_run) >= ENOUGH


def _untried(bench: BeltBench) -> Verdicts[BeltBench]:
    """The declared model alone, fitted."""
    try:
        alone = Trial((), null(bench.windows(), bench.policy, twice=True))
    except (FloatingPointError, np.linalg.LinAlgError):
        raise StickslipError(
            "no stretch of the runs can be simulated with a law of this kind; are rig, units and speeds right?"
        ) from None
    return Verdicts(bench, Searched(alone, alone), None, alone)


def _told_alone(verdicts: Verdicts[BeltBench]) -> Verdicts[BeltBench]:
    """
    Return the same, a curve of the reading in the block's speed told, and no effect of the model after.

    The speed behind readings of x1 alone is not known without undoing such a curve, so that no forecast begins.
    """
    if not _hides_speed(verdicts):
        return verdicts
    assert verdicts.curve is not None
    return replace(verdicts, curve=replace(verdicts.curve, effect=None))


def _hides_speed(verdicts: Verdicts[BeltBench]) -> bool:
    curve = verdicts.curve
    return curve is not None and (curve.where, curve.variable) == ("x1 channel", "x2")


def is_a_model(verdicts: Verdicts[BeltBench]) -> bool:
    """Whether what is told is a model of the windows."""
    if verdicts.curve is not None and verdicts.curve.period is not None:  # it is what windows are no model of
        return True
    fit = verdicts.fit
    rivals = [one for one in verdicts.searched.chosen.terms if isinstance(one.kind, RivalKind)]
    unlike = lost(fit) or unexplained(fit) > verdicts.bench.policy.noise_left
    return not (unlike or (wild(fit) and not rivals))


def _neither(fit: Fit) -> str:
    """Why nothing is told."""
    words = (
        "nothing is named: no effect, curve or scatter makes every stretch from stick to stick what was read"
    )
    if (left := unexplained(fit)) > fit.windows.policy.noise_left:
        return f"{words}; at best the middle one is left with {left:.2g} times the noise's chi-squared"
    friction, belt = max(fit.population.friction), fit.population.belt
    usual = f"friction that differs by {percent(friction)} and a belt's speed by {percent(belt)}"
    return f"{words}, but with {usual} from event to event, which is more than scatter"


def _displaced(units: Scaled, run: Data) -> Data:
    """A run in declared units, its displacement too, be it read as a force."""
    return replace(units.data(run), readings=run.readings * units.scales.length)


def _found(search: BlockSearch, tell: Callable[[str], None], began: float, workers: Workers) -> Found:
    bench, found, curve = search.verdicts.bench, search.verdicts.searched, search.verdicts.curve
    case, units = search.case, search.units
    chosen = search.verdicts.told
    base = search.verdicts.before(workers)
    before, after = (_model(search, one) for one in (base, chosen))
    train, validate = ([measure(prepare_events(one)) for one in runs] for runs in (case.train, case.validate))
    tell("fitting single events of the validate runs")
    # in a run whose block rides at another speed than the belt's no window is what it seems
    astray = {
        one.run.name
        for one in validate
        if not len(one.events) and wrong_set_point(case.run(one.run.name), clear=NEAR)
    }
    events = {
        run.name: tuple(
            NOWHERE if run.name in astray else single(bench, one, run, chosen.fit.population)
            for one in (base, chosen)
        )
        for run in search.data[len(bench.data) :]
    }
    tell("forecasting the validate runs")
    error, forecasts, words = error_block(case, before, after, validate, _errors(events, units))
    used = [run for run in search.data[len(bench.data) :] if run.name not in astray]
    told = search.verdicts
    held = likelihood(chosen.fit, told.without(base), told.spare(), told.beside_others(), used, workers)
    error = replace(error, likelihood=held)
    effects = _effects(search, chosen)
    data = [units.data(run) for run in bench.data]
    was, now = (left(bench, one.fit, data) for one in (base, chosen))
    views = [
        *_train_views(search, train, (before, base), (after, chosen)),
        *(validate_view(one, before, after, forecasts[one.run.name]) for one in validate),
    ]
    verdict = Verdict.unlisted_effect if curve is not None else Verdict.effect_found
    every = [_displaced(units, run) for run in search.data if not run.constants]
    after_all = outcome.described(now)
    return Found(
        title=case.title,
        verdict=verdict if effects else Verdict.no_effect,
        effects=effects,
        before=before,
        after=after,
        law=_in_units(units, outcome.law(chosen.fit)),
        law_before=_in_units(units, outcome.law(base.fit)),
        residual_before=outcome.described(was),
        residual_after=after_all,
        error=error,
        ranking=_ranking(search),
        experiments=experiments(effects),
        gate=outcome.gate(found),
        runs=tuple(views),
        spectrum=spectrum(was, now),
        messages=(
            *ridden(case, train, effects),
            *doubtful_set_points(case, every, effects, after_all, error, wild(chosen.fit)),
            *outcome.remarks(chosen, error),
            *((NOT_AFTER,) if _hides_speed(search.verdicts) else ()),
            *((absorbed(run.belt_speed > 0 for run in bench.data),) if bench.one_way else ()),
            *words,
        ),
        seconds=time.monotonic() - began,
        scatter=outcome.scatter(chosen.fit),
        constants=_in_units(units, said_of_constants(bench, chosen.fit)),
    )


def _in_units(units: Scaled, numbers: Mapping[str, Interval]) -> dict[str, Interval]:
    return {name: in_units(units, name, one) for name, one in numbers.items()}


def _errors(
    left: dict[str, tuple[Single, ...]], units: Scaled
) -> dict[str, tuple[float, float, float, float]]:
    """Before, after, floor and the spread of the readings, by run."""
    return {
        name: (was.error, now.error, now.floor, now.spread * units.scales.length)
        for name, (was, now) in left.items()
    }


def _model(search: BlockSearch, trial: Trial) -> Model:
    """The model of a hypothesis: declared constants with what the runs say of them beside, as relative errors."""
    bench = search.verdicts.bench
    made = outcome.model(bench, trial, search.case.model())
    return search.units.model(made, trial.fit.values(), bench.sensors.gains[0], search.case.candidates)


def _effects(search: BlockSearch, chosen: Trial) -> tuple[FoundEffect, ...]:
    """What was found, by weight: named effects and a constant, or a curve that no name explains."""
    bench, found, curve = search.verdicts.bench, search.verdicts.searched, search.verdicts.curve
    if curve is not None:
        if curve.effect is not None and curve.effect.of_reading:  # a window's gain scales what is added to it
            gain = 1 + chosen.fit.values().get(bench.sensors.gains[0], 0.0)
            curve = replace(curve, value=gain * curve.value, std=gain * curve.std)
        return (in_declared(search.units, outcome.unlisted(found, curve, chosen)),)
    beside = Searched(found.null, replace(chosen, freed=None), found.steps, found.without)
    named = [in_declared(search.units, one) for one in outcome.effects(bench, beside)]
    if chosen.freed is not None and (one := _constant(chosen.freed, found)) is not None:
        named.append(one)
    return tuple(sorted(named, key=lambda one: -one.evidence.weight))


def _constant(wrong: Freed, found: Searched) -> FoundEffect | None:
    """A constant that is not as declared; None for one that has no name, as what it does other effects do."""
    kind = _kind(wrong)
    if kind is None:
        return None

    def named(one: Freed) -> tuple[str, Mapping[str, Interval]] | None:
        other = _kind(one)
        return None if other is None else (other.name, {"e": _error(one)})

    return FoundEffect(
        kind.name,
        kind.where,
        kind.depends_on,
        {"e": _error(wrong)},
        evidence_of(found, wrong),
        (*set_point(kind.name), *rivals_of(wrong, named)),
        kind.formula,
    )


def _kind(one: Freed) -> EffectKind | None:
    """The effect that a wrong constant or gain is."""
    corrected = "reading" if one.name in GAINS else LONG.get(one.name, one.name)
    return next((kind for kind in CONSTANTS.values() if kind.corrects == corrected), None)


def _error(one: Freed) -> Interval:
    """Relative error, true over declared less 1."""
    at = one.interval()
    return Interval(*(None if x is None else x - 1 for x in (at.value, at.low, at.high)))  # type: ignore[arg-type]


def _ranking(search: BlockSearch) -> tuple[Rival, ...]:
    units = search.units
    rows = outcome.ranking(search.verdicts.searched)
    return tuple(
        replace(one, parameters={k: v * units.size(k) for k, v in one.parameters.items()}) for one in rows
    )


def _train_views(
    search: BlockSearch,
    train: Sequence[MeasuredBlock],
    before: tuple[Model, Trial],
    after: tuple[Model, Trial],
) -> list[RunView]:
    """The runs of the fit, before and after."""
    was, now = (_motions(search, trial, train) for _, trial in (before, after))
    return [view(m, before[0], after[0], *both) for m, *both in zip(train, was, now, strict=True)]


def _motions(search: BlockSearch, trial: Trial, train: Sequence[MeasuredBlock]) -> list[Motion]:
    """Readings, their rates and modes as a hypothesis has them, turned as the runs are; NaN between windows."""
    bench, length, omega = search.verdicts.bench, search.units.scales.length, search.units.scales.omega
    out: list[Motion] = []
    for m in train:
        none = np.full(len(m.run.t), np.nan)
        out.append((none, none.copy(), np.zeros(len(m.run.t), dtype=np.int8)))
    fit = trial.fit
    for s, one in zip(bench.stretches, fit.windows.motions(fit.at, fit.own), strict=True):
        if one is None:
            continue
        part, sign = slice(s.start, s.stop), train[s.run].run.sign
        x, v, mode = out[s.run]
        x[part] = sign * length * one.readings[:, 0]
        v[part] = sign * length * omega * np.gradient(one.readings[:, 0], one.t)
        mode[part] = (sign * one.mode).astype(np.int8)
    return out
