"""A block on a belt in a laboratory: searched in scaled numbers, said in the declared ones."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from stickslip.declared.catalogue import CONSTANTS
from stickslip.declared.effect_kind import EffectKind
from stickslip.declared.model import Model
from stickslip.declared.rig import LONG, BlockOnBelt
from stickslip.declared.uncertainty import GAINS, Uncertainty
from stickslip.discovery.carry_over import carries_over, instead
from stickslip.discovery.laboratory import outcome
from stickslip.discovery.laboratory.belt_bench import BeltBench
from stickslip.discovery.laboratory.constants import Freed
from stickslip.discovery.laboratory.left import left
from stickslip.discovery.laboratory.rival_kind import RivalKind, rival
from stickslip.discovery.laboratory.scaled import found as in_declared
from stickslip.discovery.laboratory.scaled import in_units
from stickslip.discovery.laboratory.search import Searched
from stickslip.discovery.laboratory.single_events import Single, single
from stickslip.discovery.laboratory.trials import Trial
from stickslip.discovery.laboratory.unused import with_windows
from stickslip.discovery.laboratory.verdicts import Verdicts, beside_a_hum, searched
from stickslip.discovery.laboratory.wrong_constant import evidence_of, rivals_of
from stickslip.discovery.residual import spectrum
from stickslip.discovery.result import (
    Found,
    FoundEffect,
    Interval,
    Rival,
    RunView,
    Verdict,
)
from stickslip.discovery.set_points import doubtful_set_points
from stickslip.discovery.slider.choose import FEWEST
from stickslip.discovery.slider.loop import experiments, idle
from stickslip.discovery.slider.outcome import error_block
from stickslip.discovery.slider.remarks import absorbed
from stickslip.discovery.slider.ties import set_point
from stickslip.discovery.slider.views import Motion, validate_view, view
from stickslip.discovery.workers import ALONE, Workers
from stickslip.fitted.block_events.table import Measured, measure
from stickslip.fitted.block_events.table import prepare as prepare_events
from stickslip.fitted.data import Data, prepare
from stickslip.likelihoods.block_windows import BlockSensors, drowned
from stickslip.likelihoods.declared_numbers import known
from stickslip.likelihoods.fit_state import unexplained
from stickslip.likelihoods.policy import POLICY
from stickslip.likelihoods.repeating import lost, wild
from stickslip.likelihoods.scaled import Scaled, scaled, start
from stickslip.likelihoods.stretches import cut, stretches
from stickslip.measured.case import Case

NOT_AFTER = (
    "the curve found is not in the model after: one of the reading in x2 cannot be undone where x1 alone is recorded, "
    "so that no forecast could begin"
)


@dataclass(frozen=True)
class Search:
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


def bench_of(case: Case) -> tuple[BeltBench, Scaled, list[Data]] | None:
    """
    Return the train runs that have windows, cut into these, the units, and the same runs with those not fitted.

    None where runs have rigs of their own, or where a run shows no slip, or is so slow that noise passes for slips.
    """
    rig, runs = case.rig, (*case.train, *case.validate)
    if not isinstance(rig, BlockOnBelt) or any(run.rig != rig or run.belt_speed == 0 for run in runs):
        return None
    units = scaled(rig, case.train)
    data = prepare([units.run(one) for one in runs])
    train = data[: len(case.train)]
    seen = [len(prepare_events(run).track.slips) for run in case.train]
    if not any(seen) or any(drowned(one) for one in train):
        return None
    declared = Model(units.block(), friction=start(case.declared_law, units, case.train))
    channel = case.train[0].channel("x1")
    sensors = BlockSensors(
        (f"gain.{channel}",), declared.parameters["stiffness"] if channel == "spring_force" else None
    )
    rivals = tuple(rival(one, units.scales) for one in case.candidates)
    used = cut(train)
    bench = BeltBench(declared, used, stretches(used), known(case), POLICY, sensors, rivals)
    return bench, units, [*used, *data[len(train) :]]


def discover(case: Case, tell: Callable[[str], None], seed: int, workers: Workers = ALONE) -> Found | None:
    """
    Return what the declared model lacks where friction scatters; None where nothing does, or where it cannot be told.

    Parameters
    ----------
    case : of a `BlockOnBelt`
    tell : told what is being done
    seed : of the gate's draws
    workers : do what does not wait for one another
    """
    began = time.monotonic()
    made = bench_of(case)
    if made is None:
        return None
    bench, units, data = made
    case, unused = with_windows(case, bench.data, bench.stretches)
    verdicts = _verdicts(bench, case.uncertainty, tell, seed, workers)
    if verdicts is None:
        return None
    said: tuple[str, ...] = ()
    if not is_a_model(verdicts):
        slips = sum(len(measure(prepare_events(run)).events) for run in case.train)
        if slips >= FEWEST:
            return None
        verdicts, said = verdicts.silent(), (_neither(slips),)
    searched = Search(case, units, data, verdicts)
    found = _found(searched, tell, began)
    if not carries_over(found):
        found = instead(found, _found(replace(searched, verdicts=verdicts.silent()), tell, began))
    return replace(found, messages=(*said, *unused, *found.messages))


def _verdicts(
    bench: BeltBench, known: Uncertainty, tell: Callable[[str], None], seed: int, workers: Workers
) -> Verdicts[BeltBench] | None:
    """What windows say; None where they are few, or where no law of this kind moves like them."""
    if len(bench.stretches) < bench.policy.fewest_windows:
        return None
    try:
        verdicts = searched(bench, known, tell, seed, workers=workers)
    except (FloatingPointError, np.linalg.LinAlgError):  # no law of this kind moves like these windows
        return None
    return _told_alone(beside_a_hum(verdicts, left(bench, verdicts.searched.null.fit)))


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


def _neither(slips: int) -> str:
    """Why nothing is told."""
    return (
        "nothing is named: no effect, curve or scatter makes every stretch from stick to stick what was read, and "
        f"{slips} slips between sticks are too few to be searched by themselves ({FEWEST} are needed)"
    )


def beside_single_slips(case: Case, found: Found) -> tuple[str, ...]:
    """
    Return what is said where the search of single slips is told: of belt speeds, few windows, and a user's own effects.

    Parameters
    ----------
    case, found : as declared, and what single slips say
    """
    made = bench_of(case)
    if made is None:
        return _untold(case, None)
    bench, units, data = made
    windows, out = len(bench.stretches), list[str]()
    if windows < POLICY.fewest_windows:
        out.append(
            f"{windows} stretches from stick to stick are told in the train runs; from {POLICY.fewest_windows} on they "
            "are searched reading by reading, which tells more than the four numbers of each slip do"
        )
    moved = [_displaced(units, run) for run in data]
    doubts = doubtful_set_points(case, moved, found.effects, found.residual_after, found.error)
    return (*doubts, *out, *_untold(case, windows))


def _displaced(units: Scaled, run: Data) -> Data:
    """A run in declared units, its displacement too, be it read as a force."""
    return replace(units.data(run), readings=run.readings * units.scales.length)


def _untold(case: Case, windows: int | None) -> tuple[str, ...]:
    """What became of a user's own effects, which the search of single slips does without."""
    if not case.candidates:
        return ()
    names = ", ".join(one.name for one in case.candidates)
    if windows is None or windows < POLICY.fewest_windows:
        few = "no" if windows is None else f"{windows}"
        words = f"not tried: {few} stretches from stick to stick are told in the train runs, and"
        return (f"{names}: {words} {POLICY.fewest_windows} are needed",)
    return (
        f"{names}: not told, as single slips are searched: windows from stick to stick are no model of the runs",
    )


def _found(search: Search, tell: Callable[[str], None], began: float) -> Found:
    bench, found, curve = search.verdicts.bench, search.verdicts.searched, search.verdicts.curve
    case, units = search.case, search.units
    chosen = search.verdicts.told
    base = search.verdicts.before
    before, after = (_model(search, one) for one in (base, chosen))
    train, validate = ([measure(prepare_events(one)) for one in runs] for runs in (case.train, case.validate))
    tell("fitting single events of the validate runs")
    events = {
        run.name: tuple(single(bench, one, run, chosen.fit.population) for one in (base, chosen))
        for run in search.data[len(case.train) :]
    }
    tell("forecasting the validate runs")
    error, forecasts, words = error_block(case, before, after, validate, _errors(events, units))
    effects = _effects(search, chosen)
    data = [units.data(run) for run in bench.data]
    was, now = (left(bench, one.fit, data) for one in (base, chosen))
    views = [
        *_train_views(search, train, (before, base), (after, chosen)),
        *(validate_view(one, before, after, forecasts[one.run.name]) for one in validate),
    ]
    verdict = Verdict.unlisted_effect if curve is not None else Verdict.effect_found
    every, after_all = [_displaced(units, run) for run in search.data], outcome.described(now)
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
            *idle(case.train, train),
            *doubtful_set_points(case, every, effects, after_all, error),
            *outcome.remarks(chosen, error),
            *((NOT_AFTER,) if _hides_speed(search.verdicts) else ()),
            *((absorbed(run.belt_speed > 0 for run in bench.data),) if bench.one_way else ()),
            *words,
        ),
        seconds=time.monotonic() - began,
        scatter=outcome.scatter(chosen.fit),
        constants=_in_units(units, outcome.constants(bench, chosen.fit)),
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


def _model(search: Search, trial: Trial) -> Model:
    """The model of a hypothesis: declared constants with what the runs say of them beside, as relative errors."""
    bench = search.verdicts.bench
    made = outcome.model(bench, trial, search.case.model())
    return search.units.model(made, trial.fit.values(), bench.sensors.gains[0], search.case.candidates)


def _effects(search: Search, chosen: Trial) -> tuple[FoundEffect, ...]:
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


def _ranking(search: Search) -> tuple[Rival, ...]:
    units = search.units
    rows = outcome.ranking(search.verdicts.searched)
    return tuple(
        replace(one, parameters={k: v * units.size(k) for k, v in one.parameters.items()}) for one in rows
    )


def _train_views(
    search: Search, train: Sequence[Measured], before: tuple[Model, Trial], after: tuple[Model, Trial]
) -> list[RunView]:
    """The runs of the fit, before and after."""
    was, now = (_motions(search, trial, train) for _, trial in (before, after))
    return [
        view(m, before[0], after[0], one, other)
        for m, one, other in zip(train, was, now, strict=True)
        if len(m.events)
    ]


def _motions(search: Search, trial: Trial, train: Sequence[Measured]) -> list[Motion]:
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
