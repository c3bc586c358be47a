"""Slips one by one on a belt that runs both ways: each direction from its own runs, joined into one law."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import fields, replace
from typing import Any

import numpy as np
import scipy

from stickslip.declared.friction_law import FrictionLaw
from stickslip.declared.rig import AnyRig
from stickslip.errors import InputError
from stickslip.fitted.identified import Branch, Events, Identified
from stickslip.fitted.slip_levels import (
    MAKE,
    DeclaredLaw,
    Kind,
    identify_events,
    plateau_over_set_point,
    preferred,
)
from stickslip.measured.prepared import Measured

WAYS: Mapping[int, Branch] = {1: "minus", -1: "plus"}  # a belt that drags forward is slipped against


def identify_slips(
    runs: Sequence[Measured],
    rig: AnyRig,
    *,
    declared: FrictionLaw | None,
    undeclared: Sequence[str] = (),
    why_idle: Callable[[int], str],
    **how: Any,
) -> Identified:
    """Identify the law of a block from its slips, of one direction of the belt or of both.

    Parameters
    ----------
    runs, rig, declared, undeclared, why_idle, how
        As for `identify_events`.

    Returns
    -------
    Identified
        Its kind of law is one for both directions: as declared, or by what their BIC say together.

    Raises
    ------
    InputError
        As `identify_events`; where one direction alone has too few slips, it is said and counts as not visited.
    """
    ways = {way: [i for i, run in enumerate(runs) if np.sign(run.belt_speed) == way] for way in WAYS}
    told: dict[str, Any] = {"declared": declared, "undeclared": undeclared, **how}
    if not all(ways.values()) or any(run.belt_speed == 0 for run in runs):
        return identify_events(runs, rig, why_idle=why_idle, **told)

    def one_way(way: int, *, kind: Kind | None = None, both: bool = True) -> Identified:
        numbers = ways[way]
        of = [runs[i] for i in numbers]
        return identify_events(of, rig, why_idle=lambda k: why_idle(numbers[k]), kind=kind, both=both, **told)

    parts: dict[int, Identified] = {}
    short: dict[int, InputError] = {}
    for way in WAYS:
        try:
            parts[way] = one_way(way)
        except InputError as error:
            short[way] = error
    if len(short) == 2:
        raise short[1]
    if short:
        (way, why), (other,) = *short.items(), parts
        found = one_way(other, both=False)
        words = f"belt speeds {'above' if way > 0 else 'below'} 0: {why.what}"
        return replace(found, messages=(*found.messages, words), events=_events(found, ways[other]))
    if len({one.law.kind for one in parts.values()}) > 1:
        own = DeclaredLaw(declared, frozenset(undeclared)).kind
        kind = own or preferred(
            sum(one.diagnostics["bic_preference_for_hyperbolic"] for one in parts.values())
        )
        parts = {way: one if one.law.kind == kind else one_way(way, kind=kind) for way, one in parts.items()}
    return _joined(runs, parts, ways)


def _joined(
    runs: Sequence[Measured], parts: Mapping[int, Identified], ways: Mapping[int, Sequence[int]]
) -> Identified:
    """One law of two directions, each with its own numbers; nothing of one is told by the other."""
    both = list(parts.values())
    first = both[0]
    estimates = {name: one.estimates[name] for one in both for name in one.names}
    make = next(law for law in MAKE.values() if isinstance(first.law, law))
    slips = [_events(one, ways[way]) for way, one in parts.items()]
    events = Events(*(np.concatenate([getattr(one, each.name) for one in slips]) for each in fields(Events)))
    windows = np.array([one.diagnostics["windows"] for one in both])

    return replace(
        first,
        law=make(**{name: one.value for name, one in estimates.items()}),
        estimates=estimates,
        names=tuple(estimates),
        covariance=scipy.linalg.block_diag(*(one.covariance for one in both)),
        covered={WAYS[way]: one.covered[WAYS[way]] for way, one in parts.items()},
        noise={"x1": float(np.mean([one.noise["x1"] for one in both]))},
        reduced_chi2=float(np.average([one.reduced_chi2 for one in both], weights=windows)),
        events=events,
        diagnostics={
            **first.diagnostics,
            **events.levels(),
            "events": float(len(events.t)),
            "bic_preference_for_hyperbolic": sum(
                one.diagnostics["bic_preference_for_hyperbolic"] for one in both
            ),
            "level_correlation_events": max(one.diagnostics["level_correlation_events"] for one in both),
            "rms_residual": float(np.median(events.rms)),
            "rms_residual_of_amplitude": float(np.median(events.rms / events.amplitude)),
            "plateau_over_set_point": plateau_over_set_point(runs),
            "runs": float(len(runs)),
            "windows": float(windows.sum()),
        },
        messages=tuple(f"T_{WAYS[way]}: {words}" for way, one in parts.items() for words in one.messages),
    )


def _events(found: Identified, numbers: Sequence[int]) -> Events:
    """Slips with the numbers that their runs have among all."""
    events = found.events
    assert events is not None
    of = {each.name: getattr(events, each.name) for each in fields(Events)}
    return Events(**{**of, "run": np.array([float(numbers[int(i)]) for i in events.run])})
