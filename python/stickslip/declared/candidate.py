"""Rivals of a user's own: effects by a formula whose numbers have ranges, for `discover` to hold against its catalogue.

A candidate is a `FormulaEffect`. Its numbers with a range are fitted within it, the others stay as they are given.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import replace
from itertools import combinations
from typing import Any

import numpy as np

from stickslip.arguments import explained, listed, must_be
from stickslip.declared.bodies_model import law_of
from stickslip.declared.catalogue import KINDS
from stickslip.declared.contact_laws import ContactLaws
from stickslip.declared.effect import FormulaEffect
from stickslip.declared.formula.tree import names
from stickslip.declared.formula.value import value
from stickslip.declared.formula_effect import formula_effect, range_of
from stickslip.declared.friction_law import FrictionLaw
from stickslip.declared.number_names import check_effect_name
from stickslip.declared.placed import Placed, placed
from stickslip.declared.places import NAMED_PLACES, SPEEDS, Places
from stickslip.declared.quantity import quantity
from stickslip.declared.rig import AnyRig, DrivenSlider
from stickslip.declared.rigs.general import GeneralRig
from stickslip.declared.rigs.named import equations_of
from stickslip.declared.rigs.parts import RESERVED_OWNERS
from stickslip.declared.si import scales_of
from stickslip.declared.units import Channel
from stickslip.errors import InputError, did_you_mean

RESERVED = ("formula", "tabulated", "unlisted", "candidate")
PREFIXES = ("rig_", "learned_", "tabulated_", "gain")  # of what reports call by themselves
LOOKS = 64  # points at which a formula is asked whether it does anything


@explained
def candidate(
    name: str,
    *,
    where: str = "",
    ranges: Mapping[str, object],
    **given: object,
) -> FormulaEffect:
    """Declare a rival for `discover`: an effect by a formula, of which some numbers are sought.

    Parameters
    ----------
    name
        What a report calls it; no name of the catalogue.
    where
        Place of the rig: a body or link (`force`), a contact, a number of its law, `belt` or `drive` (`factor`), a
        channel (`reading`).
    ranges
        Lower and upper bound of every number that is sought, bare in the case's units or with a unit:
        ``{"c": ["0 N s/m", "5 N s/m"]}``.
    **given
        One of `force`, `factor`, `reading`; its other numbers, which stay as they are, and where those that are sought
        start: in the middle of their range if not given (of one above 0, the geometric middle).

    Returns
    -------
    FormulaEffect

    Raises
    ------
    InputError
        A name of the catalogue, no range at all, or what `effect("formula", ...)` refuses.

    Examples
    --------
    >>> import stickslip as ss
    >>> drag = ss.candidate("drag", where="block", force="-c*deflection_rate**3", ranges={"c": [0, 5]})
    >>> drag.parameters
    {'c': 2.5}
    """
    must_be("name", name, str)
    if name in KINDS:
        raise InputError(
            "is an effect of the catalogue, which is sought anyway; name it otherwise", key="name", value=name
        )
    if name in RESERVED or name in RESERVED_OWNERS or name.startswith(PREFIXES):
        raise InputError("is what reports call something else; name it otherwise", key="name", value=name)
    bounds = must_be("ranges", ranges, Mapping, 'like {"c": ["0 N s/m", "5 N s/m"]}')
    if not bounds:
        raise InputError("none is given, so there is nothing to find; give one like c = [0, 5]", key="ranges")
    if given.get("states"):
        raise InputError("no reading shows them where a window begins; a rival has none", key="states")
    starts = {key: _start(key, one, given.get(key)) for key, one in bounds.items()}
    return formula_effect(called=name, where=where, ranges=bounds, **{**given, **starts})  # type: ignore[arg-type]


def _start(name: str, bounds: object, given: object) -> object:
    """Where a number starts: as given, or the middle of its range, in the unit of that."""
    low, high = range_of(name, bounds)
    unit = quantity(name, next(iter(bounds)))[1]  # type: ignore[call-overload]  # two numbers, as looked at above
    if given is not None:
        own = quantity(name, given)[1]
        if unit is not None and own != unit:
            raise InputError(
                f"its range is in {unit}; give it in the same kind of unit", key=name, value=given
            )
        return given
    middle = math.sqrt(low * high) if low > 0 else 0.5 * (low + high)
    return middle if unit is None else f"{middle!r} {unit}"


def on_rig(
    one: FormulaEffect, rig: AnyRig, friction: FrictionLaw, channels: Mapping[str, Channel] | None = None
) -> FormulaEffect:
    """Return a candidate that acts on a rig; of a named rig its place by the name that reports have for it.

    Parameters
    ----------
    one
        From `candidate`.
    rig, friction, channels
        As declared. Where the readings have units, or the rig was declared in SI, numbers and formulas are in SI.

    Raises
    ------
    InputError
        The rig has no such place, a formula reads what is not there or measures something else, a number has a unit
        though the rig has none, the channel is not recorded.
    """
    if isinstance(rig, DrivenSlider):
        words = "is for rigs on a belt and rigs of bodies or matrices; a driven slider has its own list alone"
        raise InputError(words, key="candidate", value=one.name)
    check_effect_name(one, rig, dict(friction.laws) if isinstance(friction, ContactLaws) else ())
    own, order = equations_of(rig)
    places = Places(rig, own, order)
    if not isinstance(rig, GeneralRig):
        places.bare = scales_of(rig, channels) is None
    try:
        found = placed(one, places)
        if found.number is not None and found.contact is not None:
            known = law_of(friction, own.contacts[found.contact]).numbers
            if found.number not in known:
                words = f"the law has no number '{found.number}'; {did_you_mean(found.number, known)}"
                raise InputError(words, key="where", value=one.where)
        return one if isinstance(rig, GeneralRig) else replace(one, where=_named(found, channels))
    except InputError as error:
        key = (error.key or "").removeprefix(f"{one.name}.").removeprefix(one.name)
        raise InputError(error.what, key=key or None, value=error.value) from None


def _named(found: Placed, channels: Mapping[str, Channel] | None) -> str:
    """What reports call a place of a named rig."""
    if found.direction is not None:
        return [*NAMED_PLACES][int(np.flatnonzero(found.direction)[0])]
    if found.contact is not None:
        return "contact" if found.number is None else f"contact.{found.number}"
    if found.speed is not None:
        return next(place for place, key in SPEEDS.items() if key == found.speed)
    if channels is not None and found.channel not in channels:
        words = f"'{found.channel}' is not recorded; a rival reads one of {', '.join(k for k in channels if k != 't')}"
        raise InputError(words, key="where")
    return f"{found.channel} channel"


def distinct(candidates: Iterable[FormulaEffect]) -> tuple[FormulaEffect, ...]:
    """Return candidates, each name once.

    Raises
    ------
    InputError
        Something is no candidate, or a name is there twice.
    """
    out: dict[str, FormulaEffect] = {}
    for one in listed("candidates", candidates, "candidates"):
        must_be("candidates", one, FormulaEffect, "stickslip.candidate(name, ...) makes one")
        if not one.ranges:
            words = f"'{one.name}' has no ranges, so there is nothing to find; give them"
            raise InputError(words, key="candidates")
        if one.name in KINDS:
            raise InputError(
                f"'{one.name}' is an effect of the catalogue; name it otherwise", key="candidates"
            )
        if one.name in out:
            raise InputError(f"'{one.name}' is there twice; give it once", key="candidates")
        out[one.name] = one
    return tuple(out.values())


def sizes(one: FormulaEffect) -> tuple[str, ...]:
    """Return the fewest of its sought numbers that an effect is proportional to together; () where there are none.

    Of "-c*v - k*v**3" they are c and k, of "1 + a*sin(w*t)" it is a; "1/(1 - a)" and "exp(-t/tau)" have none.
    """
    tree = one.trees()[one.acts]
    rng = np.random.default_rng(0)
    of: dict[str, Any] = {
        name: rng.choice([-1.0, 1.0], LOOKS) * 10 ** rng.uniform(-6, 6, LOOKS) for name in names(tree)
    }
    of |= {name: np.abs(x) for name, x in of.items() if name in ("u", "t", "dwell")}
    of |= one.parameters
    of |= {name: rng.uniform(low, high, LOOKS) for name, (low, high) in one.ranges.items()}
    nothing: Any = {"force": 0.0, "factor": 1.0}.get(one.acts, of.get("reading", 0.0))

    def added(scale: float, chosen: tuple[str, ...]) -> np.ndarray:
        moved = {name: scale * np.asarray(of[name]) for name in chosen}
        with np.errstate(all="ignore"):
            return np.asarray(np.broadcast_to(value(tree, {**of, **moved}) - nothing, LOOKS))

    for count in range(1, len(one.ranges) + 1):
        for chosen in combinations(one.ranges, count):
            whole = added(1.0, chosen)
            rounding = 1e-9 * float(np.max(np.abs(nothing)))  # of 1 + a
            good = np.isfinite(whole)
            twice = np.allclose(added(2.0, chosen)[good], 2 * whole[good], rtol=1e-9, atol=rounding)
            if twice and not added(0.0, chosen)[good].any():
                return chosen
    return ()
