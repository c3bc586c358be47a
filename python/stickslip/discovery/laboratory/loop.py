"""The loop in a laboratory: law, constants, scatter and effects together; the error before and after."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Generic, TypeVar

import numpy as np

from stickslip.declared.model import Model
from stickslip.declared.si import scales_of
from stickslip.declared.uncertainty import Uncertainty
from stickslip.discovery.laboratory import outcome
from stickslip.discovery.laboratory.belt_bench import BeltBench
from stickslip.discovery.laboratory.carried import error_block
from stickslip.discovery.laboratory.curves import leading
from stickslip.discovery.laboratory.hypothesis import Bench
from stickslip.discovery.laboratory.learned import Learned
from stickslip.discovery.laboratory.proven import proven
from stickslip.discovery.laboratory.rival_kind import RivalKind, rival
from stickslip.discovery.laboratory.search import Searched, Trial, search
from stickslip.discovery.laboratory.views import train_views
from stickslip.discovery.residual import spectrum
from stickslip.discovery.result import Found, Verdict
from stickslip.discovery.views import validate_view
from stickslip.discovery.workers import Workers
from stickslip.fitted.data import Data
from stickslip.likelihoods.declared_numbers import known as declared_of
from stickslip.likelihoods.fit_state import unexplained
from stickslip.likelihoods.policy import POLICY
from stickslip.likelihoods.repeating import lost, repeats, swollen
from stickslip.likelihoods.rig_windows import RigSensors
from stickslip.likelihoods.stretches import stretches
from stickslip.measured.case import Case

BenchT = TypeVar("BenchT", bound=Bench)


@dataclass(frozen=True)
class Verdicts(Generic[BenchT]):
    """
    What was searched.

    Parameters
    ----------
    bench, searched : the case, and all that was tried
    curve : what no name explains, None if there is nothing
    beside : whether the curve is what the names found leave over: they only stand in for what acts
    """

    bench: BenchT
    searched: Searched
    curve: Learned | None
    beside: bool = False

    @property
    def told(self) -> Trial:
        """What the model after has: names that stand, or stand in; nothing where a curve does better than all."""
        found = self.searched
        return found.null if self.curve is not None and not self.beside else found.chosen

    @property
    def doubtful(self) -> bool:
        """Whether no name leaves noise alone, or scatter is beyond its prior: a law that repeats may do better."""
        fit = self.searched.chosen.fit
        if self.curve is not None or unexplained(fit) > self.bench.policy.noise_left:
            return True
        return not self.searched.chosen.terms and swollen(fit)


def searched(
    bench: BenchT, known: Uncertainty, tell: Callable[[str], None], seed: int
) -> Verdicts[BenchT] | None:
    """
    Return what the train runs say where friction scatters; None where nothing does.

    Parameters
    ----------
    bench : the declared model, the runs and their windows
    known : how well its constants are known
    tell : told what is being done
    seed : of the gate's draws
    """
    if len(bench.stretches) < bench.policy.fewest_windows:
        return None
    try:
        found = search(bench, known, tell, seed)
    except (FloatingPointError, np.linalg.LinAlgError):  # no law of this kind moves like these windows
        return None
    rivals = [one for one in found.chosen.terms if isinstance(one.kind, RivalKind)]
    if lost(found.chosen.fit) or (repeats(found.chosen.fit) and not rivals):
        return None
    tell("looking for a curve that no name explains")
    alone = _curve(bench, found, seed)
    if alone is not None:
        return Verdicts(bench, found, alone)
    left = _left_over(bench, found, seed)
    return Verdicts(bench, found, left, left is not None)


def bench_of(case: Case, data: Sequence[Data]) -> BeltBench:
    """Return the train runs of a rig of (2.1), cut into windows."""
    model = Model(case.rig, friction=case.friction)
    scales = scales_of(case.rig, case.channels)
    rivals = tuple(rival(one, scales) for one in case.candidates)
    return BeltBench(model, data, stretches(data), declared_of(case), POLICY, RigSensors(), rivals)


def untold(case: Case, windows: int | None) -> tuple[str, ...]:
    """
    Return what became of a user's own effects where a law that repeats is searched without them.

    Parameters
    ----------
    case : with its candidates
    windows : that a search beside scatter has; None: it could not be made
    """
    if not case.candidates:
        return ()
    names = ", ".join(one.name for one in case.candidates)
    if windows is None or windows < POLICY.fewest_windows:
        few = "no" if windows is None else f"{windows}"
        words = f"not tried: {few} stretches from stick to stick are told in the train runs, and"
        return (f"{names}: {words} {POLICY.fewest_windows} are needed",)
    words = (
        "beside friction that may scatter nothing of it stands; the law that repeats is searched without it"
    )
    return (f"{names}: {words}",)


def _curve(bench: Bench, found: Searched, seed: int) -> Learned | None:
    """The curve that explains more than every name does, its shapes paid for."""
    count = len(bench.stretches)
    null = found.null
    best = leading(bench, null.fit, found.chosen.fit, seed)
    # as explanations they are held against each other whole: what of a wave scatter has too is the gate's question
    chosen = found.chosen
    named = null.whole() - chosen.whole()
    return _proven(bench, null, best) if best.worth(count) > max(best.threshold, named) else None


def _left_over(bench: Bench, found: Searched, seed: int) -> Learned | None:
    """
    The curve beside the names found that passes the gate: what acts is then not what they say.

    One that is next to nothing beside what they explain is what the model of the measurement is short of.
    """
    null, chosen = found.null, found.chosen
    if not chosen.terms:
        return None
    left = _proven(bench, chosen, leading(bench, chosen.fit, chosen.fit, seed))
    if left is None or left.gain < bench.policy.stands_in**2 * (null.fit.deviance - chosen.fit.deviance):
        return None
    return left


def _proven(bench: Bench, beside: Trial, best: Learned) -> Learned | None:
    """A curve that passes its gate, as scored and with all else fitted beside it; a fit that fails proves nothing."""
    count = len(bench.stretches)
    if best.worth(count) <= best.threshold:
        return None
    try:
        gain = proven(bench, beside.fit, beside.terms, best)
    except FloatingPointError:
        return None
    return best if replace(best, gain=gain).worth(count) > best.threshold else None


def discovered(
    case: Case,
    verdicts: Verdicts[BeltBench],
    validate: Sequence[Data],
    notes: tuple[str, ...],
    tell: Callable[[str], None],
    workers: Workers,
    seed: int,
    began: float,
) -> Found:
    """Return the report of a search."""
    bench, found, curve = verdicts.bench, verdicts.searched, verdicts.curve
    declared = case.model()
    chosen = verdicts.told
    before, after = (outcome.model(bench, one, declared) for one in (found.null, chosen))
    tell("forecasting the validate runs")
    error, forecasts = error_block(
        (found.null.fit, chosen.fit), (before, after), validate, case.validate, workers, seed
    )
    effects = outcome.effects(bench, found)
    if curve is not None:
        effects = (outcome.unlisted(found, curve, verdicts.told),)
    verdict = Verdict.unlisted_effect if curve is not None else Verdict.effect_found
    was, now = (outcome.left(bench, one.fit) for one in (found.null, chosen))
    views = [
        *train_views(bench, found.null.fit, chosen.fit),
        *(validate_view(run, *forecasts[run.name], case.rig) for run in validate),
    ]
    return Found(
        title=case.title,
        verdict=verdict if effects else Verdict.no_effect,
        effects=effects,
        before=before,
        after=after,
        law=outcome.law(chosen.fit),
        law_before=outcome.law(found.null.fit),
        residual_before=outcome.described(was),
        residual_after=outcome.described(now),
        error=error,
        ranking=outcome.ranking(found),
        experiments=outcome.experiments(bench, found, effects, declared),
        gate=outcome.gate(found),
        runs=tuple(views),
        spectrum=spectrum(was, now),
        messages=(*notes, *outcome.remarks(chosen, error)),
        seconds=time.monotonic() - began,
        scatter=outcome.scatter(chosen.fit),
        constants=outcome.constants(bench, chosen.fit),
    )
