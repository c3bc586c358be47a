"""The rig of (2.1): what its readings say of themselves, what is searched in them, and the report."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from stickslip.declared.model import Model
from stickslip.declared.si import scales_of
from stickslip.discovery import messages, rig_numbers
from stickslip.discovery.carry_over import claimed
from stickslip.discovery.cleaning import cleaned
from stickslip.discovery.laboratory import outcome, readings
from stickslip.discovery.laboratory.belt_bench import BeltBench
from stickslip.discovery.laboratory.carried import error_block, likelihood
from stickslip.discovery.laboratory.left import left
from stickslip.discovery.laboratory.rival_kind import rival
from stickslip.discovery.laboratory.said_of_constants import said_of_constants
from stickslip.discovery.laboratory.trials import Trial
from stickslip.discovery.laboratory.unused import stood_out, usable, with_windows
from stickslip.discovery.laboratory.verdicts import Verdicts, beside_a_hum, searched
from stickslip.discovery.laboratory.views import train_views
from stickslip.discovery.residual import spectrum
from stickslip.discovery.result import Found, Verdict
from stickslip.discovery.set_points import doubtful_set_points
from stickslip.discovery.views import validate_view
from stickslip.discovery.workers import Workers
from stickslip.errors import InputError, StickslipError
from stickslip.fitted.data import Data
from stickslip.likelihoods.declared_numbers import known as declared_of
from stickslip.likelihoods.fit import begun, fitted, null
from stickslip.likelihoods.policy import POLICY
from stickslip.likelihoods.rig_windows import RigSensors
from stickslip.likelihoods.stretches import stretches
from stickslip.measured.case import Case

FEWEST = 2  # windows, below which what one has of its own is all that is known
MANY = 5  # readings taken out, from which the fits before are worth repeating


@dataclass(frozen=True)
class _RigSearch:
    """
    A case as it is searched.

    Parameters
    ----------
    case, data : as declared, and its runs, those of the fit first
    tell, seed : told what is being done; of the draws
    workers : do what does not wait for one another
    """

    case: Case
    data: list[Data]
    tell: Callable[[str], None]
    seed: int
    workers: Workers

    @property
    def bench(self) -> BeltBench:
        """Its train runs, cut into windows."""
        return bench_of(self.case, self.data[: len(self.case.train)])


def discover(
    case: Case,
    data: list[Data],
    notes: tuple[str, ...],
    tell: Callable[[str], None],
    workers: Workers,
    seed: int,
) -> Found:
    """
    Return what the declared model of a rig of (2.1) lacks.

    Parameters
    ----------
    case : as declared
    data, notes : its runs, those of the fit first, and what was found amiss in them
    tell : told what is being done
    workers, seed : do what does not wait for one another; of all draws

    Raises
    ------
    InputError
        The train runs hold too little, or the declared rig is not theirs.
    """
    began, many = time.monotonic(), len(case.train)
    used, why = usable(case.train, data[:many])
    if not used:  # that there is nothing to cut is for others to say
        used = list(data[:many])
    case, unused = with_windows(case, used, stretches(used), why)
    asked, verdicts, said = _searched(_RigSearch(case, [*used, *data[many:]], tell, seed, workers))
    notes = (*notes, *unused, *said)
    return claimed(
        _found(asked, verdicts, notes, began),
        (_found(asked, less, notes, began) for less in verdicts.fewer()),
        lambda: _found(asked, verdicts.silent(), notes, began),
    )


def bench_of(case: Case, data: Sequence[Data]) -> BeltBench:
    """Return the train runs of a rig of (2.1), cut into windows."""
    model = Model(case.rig, friction=case.friction)
    scales = scales_of(case.rig, case.channels)
    rivals = tuple(rival(one, scales) for one in case.candidates)
    return BeltBench(model, data, stretches(data), declared_of(case), POLICY, RigSensors(), rivals)


def _searched(asked: _RigSearch) -> tuple[_RigSearch, Verdicts[BeltBench], tuple[str, ...]]:
    """
    What the train runs say, of readings that are cleaned by what is left of them.

    A misfit hides what readings themselves have: what was found may show it, and then all is sought once more.
    """
    as_read = asked.data[: len(asked.case.train)]
    asked.tell("fitting the declared law, its constants and its scatter")
    base = _null(bench := asked.bench, asked.workers)
    first = left(bench, base.fit)
    data, said = cleaned(asked.data, first, asked.case.noise)
    data, thin = readings.independent(asked.case, data, first)
    if _changed(asked.data, data):
        asked = replace(asked, data=data)
        base = _null(bench := asked.bench, asked.workers, base)
    verdicts = _verdicts(asked, bench, base)
    last = left(verdicts.bench, verdicts.told.fit)
    data, more = cleaned(asked.data, last, asked.case.noise)
    if not thin:
        data, thin = readings.independent(asked.case, data, last)
    many = readings.masked(asked.data, data) > MANY or len(data[0].t) < len(asked.data[0].t)
    if many:
        asked.tell("readings stand out from what is left: once more without them")
        asked, said = replace(asked, data=data), (*said, *more)
        verdicts = _verdicts(asked, bench := asked.bench, _null(bench, asked.workers))
    gone = stood_out(bench.stretches, verdicts.bench.stretches)
    out = () if thin else readings.left_out(as_read, asked.data[: len(as_read)])
    return asked, verdicts, thin or (*said, *gone, *out)


def _changed(before: Sequence[Data], after: Sequence[Data]) -> bool:
    """Whether readings were taken out, thinned, or are of another noise."""
    return any(
        len(a.t) != len(b.t) or (a.weight != b.weight).any() for a, b in zip(before, after, strict=True)
    )


def _null(bench: BeltBench, workers: Workers, near: Trial | None = None) -> Trial:
    """The declared model alone, fitted from where it stood with the same windows of other noise, if it did."""
    if len(bench.stretches) < FEWEST:
        words = f"the train runs hold {len(bench.stretches)} windows of a cycle each"
        raise InputError(f"{words}; {FEWEST} are needed to see what differs between them")
    windows = bench.windows()
    try:
        if near is not None and near.fit.windows.stretches == windows.stretches:
            there = near.fit
            first = replace(begun(windows), at=there.at, own=there.own, population=there.population)
            return Trial((), fitted(first, bench.policy, held=2))
        return Trial((), null(windows, bench.policy, twice=True, each=workers.map))
    except (FloatingPointError, np.linalg.LinAlgError):
        words = (
            "no window of the runs can be simulated with a law of this kind; are rig, units and speeds right?"
        )
        raise StickslipError(words) from None


def _verdicts(asked: _RigSearch, bench: BeltBench, base: Trial) -> Verdicts[BeltBench]:
    verdicts = searched(bench, asked.case.uncertainty, asked.tell, asked.seed, base, asked.workers)
    verdicts = beside_a_hum(verdicts, left(verdicts.bench, verdicts.searched.null.fit))
    messages.absurd(left(verdicts.bench, verdicts.told.fit), bench.model.rig)
    return verdicts


def _found(asked: _RigSearch, verdicts: Verdicts[BeltBench], notes: tuple[str, ...], began: float) -> Found:
    """Return the report of a search."""
    case, tell = asked.case, asked.tell
    bench, found, curve = verdicts.bench, verdicts.searched, verdicts.curve
    validate, declared, chosen = asked.data[len(case.train) :], case.model(), verdicts.told
    base = verdicts.before(asked.workers)
    before, after = (outcome.model(bench, one, declared) for one in (base, chosen))
    tell("forecasting the validate runs")
    error, forecasts = error_block(
        (base.fit, chosen.fit),
        (before, after),
        validate,
        case.validate,
        asked.workers,
        asked.seed,
    )
    without, beside = verdicts.without(base), verdicts.beside_others()
    held = likelihood(chosen.fit, without, verdicts.spare(), beside, validate, asked.workers)
    error = replace(error, likelihood=held)
    effects, gate = outcome.effects(bench, found), outcome.gate(found)
    if curve is not None:
        effects = (outcome.unlisted(found, curve, chosen),)
    looks = [rig_numbers.remark(case.rig, one.curve) for one in effects if one.curve is not None]
    verdict = Verdict.unlisted_effect if curve is not None else Verdict.effect_found
    was, now = (left(bench, one.fit) for one in (base, chosen))
    residual = outcome.described(now)
    views = [
        *train_views(bench, base.fit, chosen.fit),
        *(validate_view(run, *forecasts[run.name], case.rig) for run in validate),
    ]
    done = Found(
        title=case.title,
        verdict=verdict if effects else Verdict.no_effect,
        effects=effects,
        before=before,
        after=after,
        law=outcome.law(chosen.fit),
        law_before=outcome.law(base.fit),
        residual_before=outcome.described(was),
        residual_after=residual,
        error=error,
        ranking=outcome.ranking(found),
        experiments=outcome.experiments(bench, found, effects, declared),
        gate=gate,
        runs=tuple(views),
        spectrum=spectrum(was, now),
        messages=(
            *notes,
            *doubtful_set_points(case, asked.data, effects, residual, error),
            *(one for one in looks if one is not None),
            *outcome.remarks(chosen, error),
            *messages.remarks(bench, effects, now, error, validate, case.noise),
        ),
        seconds=time.monotonic() - began,
        scatter=outcome.scatter(chosen.fit),
        constants=said_of_constants(bench, chosen.fit),
    )
    return replace(done, messages=(*done.messages, *messages.unseen(done)))
