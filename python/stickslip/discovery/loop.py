"""The loop: fit the declared law, look at the residual, trace its cause, add it, report the error before and after."""

from __future__ import annotations

import os
import time
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from threadpoolctl import threadpool_limits  # type: ignore[import-untyped]

from stickslip import arguments
from stickslip.declared.effect import FormulaEffect
from stickslip.declared.friction_law import FrictionLaw
from stickslip.declared.model import Model
from stickslip.declared.rig import AnyRig, BlockOnBelt, DrivenSlider, Rig
from stickslip.declared.rigs.general import GeneralRig
from stickslip.declared.units import Channel
from stickslip.discovery import outcome, rig_numbers
from stickslip.discovery.choice import Choice, choose
from stickslip.discovery.cleaning import cleaned
from stickslip.discovery.driven_slider import loop as driven
from stickslip.discovery.errors import Measured, error_block
from stickslip.discovery.filtered import thinned_if_filtered
from stickslip.discovery.final import final
from stickslip.discovery.gate import gate, largest_gain
from stickslip.discovery.general_rig import loop as general_rig
from stickslip.discovery.laboratory import block
from stickslip.discovery.laboratory import loop as laboratory
from stickslip.discovery.longer import looked_at_longer
from stickslip.discovery.messages import remarks, unseen
from stickslip.discovery.next_experiment import next_experiments
from stickslip.discovery.residual import describe, spectrum
from stickslip.discovery.result import (
    Found,
    RunView,
)
from stickslip.discovery.search import CLEAN, Search, Trial
from stickslip.discovery.set_points import doubtful_set_points
from stickslip.discovery.slider import loop as slider
from stickslip.discovery.trace import MARGIN, decide_single, declared
from stickslip.discovery.views import train_view, validate_view
from stickslip.discovery.workers import Workers
from stickslip.errors import InputError, number
from stickslip.fitted.data import Data, copied_words, held_words, one_rig, prepare
from stickslip.fitted.plausible import plausible
from stickslip.measured.case import Case
from stickslip.measured.memory_case import Columns, case_in_memory, with_candidates
from stickslip.measured.recording import Recording
from stickslip.measured.thinning import sentences, thinned_case

MOST_SAMPLES = 40_000  # of the train runs, and of the others: 44 000 took 141 s and 0.9 GB
MOST_CORES = 8  # what a search can keep busy
MANY = 5  # readings taken out, from which the fits before are worth repeating
BUDGET = 51.0  # processor seconds for the tracing, so that a busy machine gives the same verdict
NAMES = 0.6  # share of them that names may take before curves and pairs are asked
LIKELY = 3  # rivals whose rest is looked at for a filter's noise
LAST = 20.0  # and beside them for the last fits
LATE, BRIEF = 0.8, 10.0  # share of the budget from which these must be brief, and how brief


@arguments.explained
def discover(
    case: Case | Recording | Sequence[Recording] | Columns,
    *,
    rig: AnyRig | None = None,
    channels: Mapping[str, Channel] | None = None,
    belt_speed: float | str | None = None,
    noise: Mapping[str, float] | None = None,
    friction: FrictionLaw | None = None,
    candidates: Iterable[FormulaEffect] = (),
    progress: Callable[[str], None] | None = None,
    threads: int | None = None,
    seed: int = 0,
    budget: float | None = None,
) -> Found:
    """Find what the declared model of a case lacks.

    Parameters
    ----------
    case
        From `stickslip.load_case`, with train and validate runs; or recordings, or the columns of one in memory, as a
        data frame has them. Of recordings none of which is to validate, the last third of each is.
    rig, channels, belt_speed, noise
        Of columns in memory, as `load_recording` takes them.
    friction
        The declared law of recordings or columns; nothing is declared if absent.
    candidates
        Effects of one's own, from `stickslip.candidate`, held against the catalogue; beside those of a case.
    progress
        Told what is being tried, a sentence at a time.
    threads
        Cores to use at most, all (but at most 8) if not given; the searches of rigs other than (2.1) use one. Rivals
        are fitted side by side in as many processes, the windows of one fit in as many threads. The result does not
        depend on it while the budget lasts.
    seed
        Of the bootstrap and of the floor's noise.
    budget
        Processor seconds that tracing may take, over all threads; of the rig of (2.1) alone, the searches of the others
        are short.

    Returns
    -------
    Found

    Raises
    ------
    InputError
        The case is not one that a verdict can be reached on, with the reason.
    StickslipError
        The declared model cannot be simulated.

    Examples
    --------
    >>> import numpy as np
    >>> import stickslip as ss
    >>> true = ss.Model(ss.BlockOnBelt(mass=1.0), friction=ss.CoulombFriction(static=0.4, kinetic=0.25))
    >>> t = np.arange(0, 100, 0.1)
    >>> x1 = ss.simulate(true, belt_speed=0.1, initial=(0, 0.1), t_end=100, t_eval=t).x1
    >>> x1 = x1 + 1e-3 * np.random.default_rng(0).standard_normal(t.size)
    >>> declared = ss.BlockOnBelt(mass=0.8)
    >>> found = ss.discover(
    ...     {"t": t, "x1": x1}, rig=declared, friction=true.friction, belt_speed=0.1, noise={"x1": 1e-3}
    ... )
    >>> print(found.verdict.value)
    effect_found
    >>> print(f"error of forecasts: {found.error.before:.2f} before, {found.error.after:.2f} after")
    error of forecasts: 0.11 before, 0.01 after
    """
    if isinstance(case, Case):
        given = {
            "rig": rig,
            "channels": channels,
            "belt_speed": belt_speed,
            "noise": noise,
            "friction": friction,
        }
        if wrong := [name for name, one in given.items() if one is not None]:
            raise InputError("is for recordings and columns in memory; a case has its own", key=wrong[0])
        case = with_candidates(case, candidates)
    else:
        if not hasattr(case, "keys") and not isinstance(case, Recording | list | tuple):
            arguments.must_be("case", case, Case, "load_case(path) gives one")
        case = case_in_memory(
            case,
            rig,
            channels=channels,
            belt_speed=belt_speed,
            noise=noise,
            friction=friction,
            candidates=candidates,
        )
    return _discover_case(case, progress, threads, seed, budget)


def _discover_case(
    case: Case,
    progress: Callable[[str], None] | None,
    threads: int | None,
    seed: int,
    budget: float | None,
) -> Found:
    """Check what was asked for, and search."""
    if case.candidates and not isinstance(case.rig, (Rig, BlockOnBelt)):
        words = f"are not sought on a {type(case.rig).__name__}; leave them out"
        raise InputError(words, key="candidates")
    seed = arguments.whole_number("seed", seed, least=0)
    if budget is not None and not isinstance(case.rig, Rig):
        raise InputError(
            "is for the rig of (2.1); the searches of other rigs are short", key="budget", value=budget
        )
    budget = BUDGET if budget is None else number("budget", budget, above=0)
    threads = None if threads is None else arguments.whole_number("threads", threads)
    if progress is not None and not callable(progress):
        raise InputError("must be a function of one sentence", key="progress")
    tell = progress or (lambda _: None)
    runs = (*case.train, *case.validate)  # a case without them is refused before anything is said
    tell("looking at the readings")
    copied = copied_words(runs) if isinstance(case.rig, Rig) else ()
    thin, less = thinned_case(case, MOST_SAMPLES)
    found = _searched(thin, copied, tell, threads, seed, budget)
    return replace(found, case=case, thinned=less, messages=(*sentences(less), *found.messages))


def _searched(
    case: Case,
    copied: tuple[str, ...],
    tell: Callable[[str], None],
    threads: int | None,
    seed: int,
    budget: float,
) -> Found:
    """What is found by the search for the case's rig."""
    began = time.monotonic()
    # products of many small matrices: threads that wait for each other cost far more
    with threadpool_limits(1):
        if isinstance(case.rig, DrivenSlider):
            return driven.discover(case, tell=tell, seed=seed)
        if isinstance(case.rig, BlockOnBelt):
            found = block.discover(case, tell, seed)
            if found is not None:
                return found
            found = slider.carried(slider.discover(case, progress=tell, seed=seed))
            return replace(found, messages=(*found.messages, *block.untold(case)))
        if isinstance(case.rig, GeneralRig):
            return general_rig.discover(case, tell, seed)
        count = min(os.cpu_count() or 1, MOST_CORES) if threads is None else threads
        data, notes = _checked(case, copied)
        workers = Workers(count, __name__)  # not for a case that is refused
        try:
            return _discover(_Asked(case, data, notes, tell, count, seed, budget, began, workers))
        except BaseException:
            workers.stop()
            raise


def _checked(case: Case, copied: tuple[str, ...]) -> tuple[list[Data], tuple[str, ...]]:
    """The runs with what was found amiss in them, said; or a refusal."""
    recordings = (*case.train, *case.validate)
    one_rig(case.rig, recordings)
    data = prepare(recordings)
    found = (*copied, *held_words(data))
    data, notes = plausible(case, data)
    return data, (*found, *notes)


@dataclass(frozen=True)
class _Asked:
    """A case with its runs, and how it is to be searched."""

    case: Case
    data: list[Data]
    notes: tuple[str, ...]
    tell: Callable[[str], None]
    threads: int
    seed: int
    budget: float
    began: float
    workers: Workers


def _discover(asked: _Asked) -> Found:
    """Where friction scatters, what is found through the scatter; else what a law that repeats lacks.

    A curve in a clean room may pose as scatter. Where the second search explains all, nothing has scattered.
    """
    case, count = asked.case, len(asked.case.train)
    bench = laboratory.bench_of(case, asked.data[:count])
    verdicts = laboratory.searched(bench, case.uncertainty, asked.tell, asked.seed)
    if verdicts is None or verdicts.doubtful:
        found = _repeating(asked)
        if verdicts is None or found.residual_after.clean:
            notes = laboratory.untold(case, len(bench.stretches))
            return replace(found, messages=(*found.messages, *notes))
    return laboratory.discovered(
        case, verdicts, asked.data[count:], asked.notes, asked.tell, asked.workers, asked.seed, asked.began
    )


def _repeating(asked: _Asked) -> Found:
    """The search for what a law lacks whose events are all alike."""
    case, data, tell = asked.case, asked.data, asked.tell
    as_read, count, budget = data, len(case.train), asked.budget
    model = Model(case.rig, friction=case.friction)
    search = Search(data[:count], model, asked.threads, tell, NAMES * budget, budget)
    tell("fitting the declared law")
    data, corrected, known = _cleaned(case, data, search)
    data, as_read, thin, known = thinned_if_filtered(case, data, as_read, search, [known] if known else [])
    search = search.afresh(data[:count])
    search.workers = asked.workers
    trials = decide_single(search, known)
    if not thin:
        data, as_read, thin, known = thinned_if_filtered(case, data, as_read, search, trials[:LIKELY])
        if thin:
            tell("what is left is a filter's noise: once more with readings that are independent")
            search = search.afresh(data[:count])
            search.extend(NAMES * budget)
            trials = decide_single(search, known)
    corrected = thin or corrected
    freed, more = _cleaned_of_what_shows(case, data, trials[0])
    if trials[0].excess > CLEAN and _masked(data, freed) > MANY:
        tell("single readings stand out from what is left: once more without them")
        data, corrected = freed, (*corrected, *more)
        known = search.tried[()]
        search = search.afresh(data[:count])
        search.extend(NAMES * budget)
        trials = decide_single(search, known)
    search, choice = looked_at_longer(search, choose(search, trials))
    if choice.trial.names:
        data, more = _cleaned_of_what_shows(case, data, choice.trial)
        search, corrected = replace(search, data=data[:count]), (*corrected, *more)
    if out := _masked(as_read, data):
        share = out / sum(run.readings.size for run in data[:count])
        which = "1 reading that stands out" if out == 1 else f"{out} readings that stand out"
        corrected = (
            *corrected,
            f"left out of the fits: {which} from both sides ({100 * share:.2g} % of all)",
        )
    return _found(
        case, choice, search, data[count:], tell, asked.seed, asked.began, (*asked.notes, *corrected)
    )


def _cleaned(
    case: Case, data: list[Data], search: Search
) -> tuple[list[Data], tuple[str, ...], Trial | None]:
    """The runs cleaned by the declared law's fit, and that; a second time if there was much, for a fit without it shows
    more.
    """
    first = declared(search)
    out, said = cleaned(data, None if first is None else first.fit, case.noise)
    if _masked(data, out) > MANY:
        first = declared(replace(search, data=out[: len(search.data)]))
        out, more = cleaned(out, None if first is None else first.fit, case.noise)
        said = said or more
    return out, said, first


def _cleaned_of_what_shows(case: Case, data: list[Data], found: Trial) -> tuple[list[Data], tuple[str, ...]]:
    """The runs cleaned by the fit of what was found, if it shows outliers that a misfit had hidden."""
    out, said = cleaned(data, found.fit, case.noise)
    return (out, said) if _masked(data, out) else (data, ())


def _masked(before: Sequence[Data], after: Sequence[Data]) -> int:
    """Readings that have been taken out."""
    return sum(int(np.sum(b.weight == 0) - np.sum(a.weight == 0)) for a, b in zip(before, after, strict=True))


def _found(
    case: Case,
    choice: Choice,
    search: Search,
    validate: list[Data],
    tell: Callable[[str], None],
    seed: int,
    began: float,
    notes: tuple[str, ...] = (),
) -> Found:
    search = _for_the_last_fits(search)
    task = search.submit(final, choice.null)
    after = None if choice.trial is choice.null else final(search, choice.trial)
    before = task.result()
    after = before if after is None else after
    before_model, after_model = outcome.model(case, before), outcome.model(case, after)
    tell("forecasting the validate runs")
    error, forecasts = error_block(before_model, after_model, validate, case.validate, search.workers, seed)
    passed = gate(
        choice.null.fit,
        largest_gain(search, choice.null),
        float(np.log(choice.null.fit.readings)) + MARGIN,
        seed,
    )
    tell("weighing the evidence")
    effects = outcome.effects(search, choice, after, passed.threshold)
    near = [said for one in effects if (said := outcome.as_declared(case, one)) is not None]
    effects, notes = (() if near else effects), (*notes, *near)
    curve = next((one.curve for one in effects if one.curve is not None), None)
    if doubt := rig_numbers.remark(case.rig, choice.trial.names, after, choice.tied, curve):
        notes = (*notes, doubt)
    was, now = describe(before.fit), describe(after.fit)
    notes = (*notes, *doubtful_set_points(case, [*search.data, *validate], effects, now, error))
    found = Found(
        title=case.title,
        verdict=outcome.verdict(choice, effects),
        effects=effects,
        before=before_model,
        after=after_model,
        law=outcome.law(after),
        law_before=outcome.law(before),
        residual_before=was,
        residual_after=now,
        error=error,
        ranking=outcome.ranking(search, choice),
        experiments=next_experiments(
            {frozenset(names): one.hypothesis.model for names, one in search.tried.items()}
            | {frozenset(choice.trial.names): choice.trial.hypothesis.model},
            frozenset(choice.trial.names),
            search.data,
            effects,
        ),
        gate=passed,
        runs=_views(case, before, after, validate, forecasts),
        spectrum=spectrum(before.fit, after.fit),
        messages=(*notes, *remarks(search.data, choice.null, effects, now, error, validate, case.noise)),
        seconds=time.monotonic() - began,
        constants=rig_numbers.each_alone(search.freed),
    )
    return replace(found, messages=(*found.messages, *unseen(found)))


def _for_the_last_fits(search: Search) -> Search:
    """The search with the time that the last fits have: less of it where tracing took most of its own."""
    spent = search.budget - search.left
    return replace(search, budget=spent + (LAST if spent < LATE * search.most else BRIEF))


def _views(
    case: Case,
    before: Trial,
    after: Trial,
    validate: Sequence[Data],
    forecasts: Mapping[str, tuple[Measured, Measured]],
) -> tuple[RunView, ...]:
    train = [train_view(run, i, before.fit, after.fit) for i, run in enumerate(before.fit.engine.data)]
    return (*train, *(validate_view(run, *forecasts[run.name], case.rig) for run in validate))
