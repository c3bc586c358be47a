"""What the declared model of a case lacks: what was asked for is checked, and searched as its rig is."""

from __future__ import annotations

import os
import time
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import replace

from stickslip import arguments
from stickslip.declared.effect import FormulaEffect
from stickslip.declared.friction_law import FrictionLaw
from stickslip.declared.rig import AnyRig, DrivenSlider, Rig
from stickslip.declared.rigs.general import GeneralRig
from stickslip.declared.units import Channel
from stickslip.discovery.driven_slider import loop as driven
from stickslip.discovery.general_rig import loop as general_rig
from stickslip.discovery.laboratory import block, block_law, two_degree
from stickslip.discovery.result import Found, Verdict
from stickslip.discovery.workers import Workers
from stickslip.errors import InputError
from stickslip.fitted.data import Data, copied_words, held_words, one_rig, prepare
from stickslip.fitted.plausible import plausible
from stickslip.likelihoods.one_thread import one_thread
from stickslip.likelihoods.threads import side_by_side
from stickslip.measured.case import Case
from stickslip.measured.memory_case import Columns, case_in_memory, with_candidates
from stickslip.measured.recording import Recording
from stickslip.measured.thinning import MOST_SEARCHED, sentences, thinned_case

__all__ = ["Found", "Verdict", "discover"]

MOST_CORES = 8  # what a search can keep busy


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
        Cores to use at most, all (but at most 8) if not given: what does not wait for one another is done side by
        side in as many processes, on a driven slider nothing. The result does not depend on it.
    seed
        Of the bootstrap and of the forecasts.

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
    >>> found.error.after < 0.1 * found.error.before  # of forecasts of the run that was not fitted
    True
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
    return _discover_case(case, progress, threads, seed)


def _discover_case(
    case: Case,
    progress: Callable[[str], None] | None,
    threads: int | None,
    seed: int,
) -> Found:
    """Check what was asked for, and search."""
    if case.candidates and isinstance(case.rig, DrivenSlider):
        words = f"are not sought on a {type(case.rig).__name__}; leave them out"
        raise InputError(words, key="candidates")
    seed = arguments.whole_number("seed", seed, least=0)
    threads = None if threads is None else arguments.whole_number("threads", threads)
    if progress is not None and not callable(progress):
        raise InputError("must be a function of one sentence", key="progress")
    tell = progress or (lambda _: None)
    runs = (*case.train, *case.validate)  # a case without them is refused before anything is said
    tell("looking at the readings")
    copied = copied_words(runs) if isinstance(case.rig, Rig) else ()
    thin, less = thinned_case(case, MOST_SEARCHED)
    found = _searched(thin, copied, tell, threads, seed)
    return replace(found, case=case, thinned=less, messages=(*sentences(less), *found.messages))


@one_thread
def _searched(
    case: Case, copied: tuple[str, ...], tell: Callable[[str], None], threads: int | None, seed: int
) -> Found:
    """What is found by the search for the case's rig."""
    if isinstance(case.rig, DrivenSlider):
        return driven.discover(case, tell=tell, seed=seed)
    # first, as a case that is refused starts no processes
    checked = _checked(case, copied) if isinstance(case.rig, Rig) else None
    count = min(os.cpu_count() or 1, MOST_CORES) if threads is None else threads
    workers = Workers(count, __name__)
    try:
        return _with(workers, case, checked, tell, seed)
    except BaseException:
        workers.stop()
        raise


def _with(
    workers: Workers,
    case: Case,
    checked: tuple[list[Data], tuple[str, ...]] | None,
    tell: Callable[[str], None],
    seed: int,
) -> Found:
    """What the search for a rig with contacts finds; what waits for itself is simulated in as many threads."""
    with side_by_side(workers.count):
        if checked is not None:
            return two_degree.discover(case, *checked, tell, workers, seed)
        if isinstance(case.rig, GeneralRig):
            return general_rig.discover(case, tell, seed, workers)
        began = time.monotonic()
        found = block.discover(case, tell, seed, workers)
        said = block_law.law_to_declare(case, found, tell)
        return replace(found, messages=(*found.messages, *said), seconds=time.monotonic() - began)


def _checked(case: Case, copied: tuple[str, ...]) -> tuple[list[Data], tuple[str, ...]]:
    """The runs with what was found amiss in them, said; or a refusal."""
    recordings = (*case.train, *case.validate)
    one_rig(case.rig, recordings)
    data = prepare(recordings)
    found = (*copied, *held_words(data))
    data, notes = plausible(case, data)
    return data, (*found, *notes)
