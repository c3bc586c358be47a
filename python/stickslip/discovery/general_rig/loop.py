"""The loop on a rig of bodies or matrices: laws, constants, scatter and effects together; errors before and after."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial

import numpy as np
from numpy.typing import NDArray

from stickslip.declared.model import Model
from stickslip.discovery.carry_over import claimed
from stickslip.discovery.general_rig import outcome
from stickslip.discovery.general_rig.bench import GeneralBench, bench_of, of_single_events
from stickslip.discovery.general_rig.errors import FittedRig, error_block, two_windows
from stickslip.discovery.general_rig.result import GeneralFound, RigView
from stickslip.discovery.laboratory import outcome as usual
from stickslip.discovery.laboratory.fewer import beside_others, fewer
from stickslip.discovery.laboratory.search import Searched, search
from stickslip.discovery.laboratory.trials import Trial
from stickslip.discovery.residual import spectrum
from stickslip.discovery.result import FoundEffect, Verdict
from stickslip.discovery.workers import ALONE, Workers
from stickslip.errors import InputError, StickslipError
from stickslip.fitted.bodies_data import BodiesData, prepare_bodies
from stickslip.likelihoods.bodies_ahead import WindowForecasts
from stickslip.likelihoods.fit import closed, null
from stickslip.likelihoods.repeating import lost
from stickslip.likelihoods.single_windows import settled
from stickslip.measured.case import Case

Floats = NDArray[np.float64]

ASTRAY = (
    "nothing is named: with what the search found best so many windows cannot be simulated that it is no model of the "
    "runs"
)


def discover(case: Case, tell: Callable[[str], None], seed: int, workers: Workers = ALONE) -> GeneralFound:
    """
    Return what the declared model of a rig of bodies or matrices lacks.

    Parameters
    ----------
    case : of such a rig
    tell : told what is being done
    seed : of the gate's draws
    workers : do what does not wait for one another

    Raises
    ------
    InputError
        A law has states that carry no load at rest; the runs are too short; a channel never changes.
    StickslipError
        No law of the declared kind moves the rig like the readings.
    """
    began = time.monotonic()
    declared = case.model()
    plain = Model(declared.rig, friction=declared.friction)
    bench = bench_of(plain, case.train, case.uncertainty, candidates=case.candidates)
    _moving(bench.data)
    if len(bench.stretches) < bench.policy.fewest_windows:
        words = f"the train runs hold {len(bench.stretches)} windows, from stick to stick or a natural period long"
        raise InputError(f"{words}; {bench.policy.fewest_windows} are needed to see how friction scatters")
    validate = prepare_bodies(declared.rig, case.validate, declared.friction)  # type: ignore[arg-type]  # a general rig's
    for run in validate:
        two_windows(run)
    try:
        tell("fitting the declared laws, their constants and their scatter")
        every, bench = bench, of_single_events(bench, null(bench.windows(), bench.policy))
        others = partial(_other_windows, every, bench)
        found = search(bench, case.uncertainty, tell, seed, workers=workers, ends=others)
        if found.chosen.terms and others(found.chosen):
            tell("beside what was found other windows stand out: once more with the rest")
            bench = beside(every, found.chosen)
            found = search(bench, case.uncertainty, tell, seed, workers=workers)
    except (FloatingPointError, np.linalg.LinAlgError):
        words = (
            "no window of the runs can be simulated with laws of this kind; are rig, units and speeds right?"
        )
        raise StickslipError(words) from None
    if lost(found.null.fit):
        words = "laws of this kind do not move the rig like the readings; are rig, units and speeds right?"
        raise StickslipError(words)
    astray = lost(found.chosen.fit)
    if astray:
        found = replace(found, chosen=found.null)
    so_far = (began, len(every.stretches) - len(bench.stretches))

    def said(some: Searched) -> GeneralFound:
        made = _found(case, bench, some, validate, tell, so_far)
        return replace(made, messages=(*([ASTRAY] if astray else []), *made.messages))

    return claimed(
        said(found), (said(less) for less in fewer(found)), lambda: said(replace(found, chosen=found.null))
    )


def beside(every: GeneralBench, trial: Trial) -> GeneralBench:
    """
    Return all windows less those in which more happens than one event, as a hypothesis tells them.

    Without what acts, windows in which it does much stand out too, and the rest tell a part of it.
    """
    windows = every.windows(trial.terms)
    own, count = windows.first(trial.fit.at), len(every.stretches)
    first = replace(trial.fit, windows=windows, own=own, knee=np.full(count, np.inf))
    return of_single_events(every, closed(replace(first, own=settled(first)[0]), every.policy, 0))


def _other_windows(every: GeneralBench, bench: GeneralBench, trial: Trial) -> bool:
    """Whether beside a hypothesis other windows hold one event each than were fitted."""
    return [*map(id, beside(every, trial).stretches)] != [*map(id, bench.stretches)]


def _moving(runs: Sequence[BodiesData]) -> None:
    """Refuse runs in which a channel never changes: how large anything is there, they do not say."""
    for c, name in enumerate(runs[0].channels):
        if name != "belt" and not any(np.ptp(run.readings[:, c]) for run in runs):
            raise InputError("reads the same at all times; leave it out, or see to its sensor", key=name)


def _found(
    case: Case,
    bench: GeneralBench,
    found: Searched,
    validate: Sequence[BodiesData],
    tell: Callable[[str], None],
    so_far: tuple[float, int],
) -> GeneralFound:
    declared, chosen, (began, out) = case.model(), found.chosen, so_far
    before, after = (outcome.model(bench, one, declared) for one in (found.null, chosen))
    tell("forecasting the validate runs")

    def told(one: Trial) -> FittedRig:
        made = (
            before if one is found.null else after if one is chosen else outcome.model(bench, one, declared)
        )
        return FittedRig(made, outcome.sensors(bench, one), one.fit.population, one.fit.noise)

    was = now = told(chosen)
    if chosen is not found.null:
        was = told(found.null)
    less = {outcome.said(k): (told(one), spare) for k, (one, spare) in beside_others(found).items()}
    proof, effects = usual.gate(found), outcome.effects(bench, found)
    spare = max(proof.observed - proof.threshold, 0.0) if chosen.terms else None
    error, forecasts = error_block(was, now, validate, case.validate, spare, less)
    left = [outcome.left(bench, one.fit) for one in (found.null, chosen)]
    return GeneralFound(
        title=case.title,
        verdict=_verdict(effects),
        effects=effects,
        before=before,
        after=after,
        law=usual.law(chosen.fit),
        law_before=usual.law(found.null.fit),
        residual_before=usual.described(left[0]),
        residual_after=usual.described(left[1]),
        error=error,
        ranking=outcome.ranking(found),
        experiments=(),
        gate=proof,
        runs=(),
        spectrum=spectrum(*left),
        messages=(*_left_out(out, bench), *outcome.remarks(bench, chosen)),
        seconds=time.monotonic() - began,
        scatter=outcome.scatter(chosen.fit),
        constants=outcome.constants(bench, chosen.fit),
        views=(*_train(bench, found), *(_view(*one) for one in zip(validate, forecasts, strict=True))),
    )


def _verdict(effects: Sequence[FoundEffect]) -> Verdict:
    if not effects:
        return Verdict.no_effect
    return Verdict.unlisted_effect if any(one.curve is not None for one in effects) else Verdict.effect_found


def _left_out(count: int, bench: GeneralBench) -> tuple[str, ...]:
    """Say how many windows were not fitted."""
    words = "left out of the fits, as more happens in them than one event: two slips parted by a stick too short to see"
    return (f"{count} of {count + len(bench.stretches)} windows were {words}",) if count else ()


def _train(bench: GeneralBench, found: Searched) -> list[RigView]:
    sides = (outcome.readings(bench, one.fit) for one in (found.null, found.chosen))
    return [_drawn(run, was, now) for run, was, now in zip(bench.data, *sides, strict=True)]


def _view(run: BodiesData, forecasts: tuple[WindowForecasts, WindowForecasts]) -> RigView:
    was, now = forecasts
    return _drawn(run, was.readings, now.readings)


def _drawn(run: BodiesData, before: Floats, after: Floats) -> RigView:
    measured, was, now = (
        dict(zip(run.channels, one.T, strict=True)) for one in (run.readings, before, after)
    )
    noise = dict(zip(run.channels, run.noise.tolist(), strict=True))
    return RigView(run.name, run.role, run.t, measured, noise, was, now)
