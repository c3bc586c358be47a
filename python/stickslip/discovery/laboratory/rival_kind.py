"""A user's own effect as one of the catalogue's kinds: what a search asks of an effect, answered by a formula.

Sizes are the numbers that it is proportional to; they are scored at next to nothing. Where there are none the whole
effect is scored, times a strength. Its other sought numbers, which no score reaches, are tried over their ranges.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import numpy as np
import scipy
from numpy.typing import NDArray

from stickslip.declared.candidate import sizes
from stickslip.declared.effect import FormulaEffect
from stickslip.declared.effect_kind import EffectKind, ParameterInfo
from stickslip.declared.rig import Scales
from stickslip.declared.scaled_formula import in_scales
from stickslip.likelihoods.interval import Interval

Floats = NDArray[np.float64]
STRENGTH = "strength"  # of the whole effect, where it is proportional to none of its numbers
NOTHING = 1e-6  # of a size's range: where its columns are taken
WHOLE = {
    "force": "{strength}*({formula})",
    "factor": "1 + {strength}*(({formula}) - 1)",
    "reading": "reading + {strength}*(({formula}) - reading)",
}


@dataclass(frozen=True)
class RivalKind(EffectKind):
    """
    Facts of a user's own effect.

    Parameters
    ----------
    declared : the effect in the numbers of the search, without ranges
    scored_whole : whether this is the effect times a strength
    """

    declared: FormulaEffect = field(kw_only=True)
    scored_whole: bool = False

    @cached_property
    def sizes(self) -> tuple[str, ...]:
        """Names of the numbers that it is proportional to; the strength where there are none."""
        found = tuple(one.name for one in self.parameters if one.spread is not None)
        return found or (STRENGTH,)

    @cached_property
    def times_strength(self) -> RivalKind:
        """The same effect times a strength."""
        name = STRENGTH
        while name in self.declared.parameters:
            name += "_"
        one = self.declared
        text = WHOLE[one.acts].format(strength=name, formula=one.formula)
        more = replace(one, formula=text, given=(*one.given, (name, 0.0, None)))
        info = ParameterInfo(name, "share of the effect", (0.0, math.inf), spread=math.inf)
        return replace(self, parameters=(*self.parameters, info), declared=more, scored_whole=True)

    def made(self, numbers: Mapping[str, float]) -> FormulaEffect:
        """Return the effect with some of its numbers."""
        return self.declared.replace(**{k: v for k, v in numbers.items() if k in self.declared.parameters})

    def tries(self, grid: int) -> Iterator[tuple[RivalKind, dict[str, float], tuple[str, ...]]]:
        """Yield where columns are taken: the effect, its numbers, and the names of those that they are of."""
        kind = self if self.sizes != (STRENGTH,) else self.times_strength
        names = self.sizes if kind is self else (kind.parameters[-1].name,)
        none = (
            {n: NOTHING * max(map(abs, kind.parameter(n).bounds)) for n in names}
            if kind is self
            else {names[0]: 0.0}
        )
        for shapes in self._shapes(grid):
            yield kind, {**self.declared.parameters, **shapes, **none}, names

    def _shapes(self, grid: int) -> Iterator[dict[str, float]]:
        """Where they start, then places over the ranges of the numbers that no score reaches."""
        shapes = [one for one in self.parameters if one.name not in self.sizes]
        yield {one.name: self.declared.parameters[one.name] for one in shapes}
        if not shapes:
            return
        count = grid * len(shapes)
        places = (np.arange(count)[:, None] + 0.5) / count
        if len(shapes) > 1:
            places = scipy.stats.qmc.Halton(len(shapes), scramble=False).random(count + 1)[1:]
        for place in places:
            yield {
                one.name: _within(one.bounds, float(share)) for one, share in zip(shapes, place, strict=True)
            }


def within(kind: EffectKind, name: str, one: Interval) -> Interval:
    """Return a number of an effect; of a user's own one within the range that the user gave."""
    if not isinstance(kind, RivalKind):
        return one
    low, high = kind.parameter(name).bounds
    value, *ends = (None if x is None else min(max(x, low), high) for x in (one.value, one.low, one.high))
    assert value is not None
    return Interval(value, *ends)


def _within(bounds: tuple[float, float], share: float) -> float:
    """A number some way through a range; by its logarithm, of a range above 0."""
    low, high = bounds
    return low * (high / low) ** share if low > 0 else low + share * (high - low)


SEEN: Mapping[
    str, Mapping[str, tuple[str, ...]]
] = {  # what formulas call the variables of a report, by place
    "angle_body": {"deflection": ("y1",), "deflection_rate": ("y2",)},
    "y1 channel": {"reading": ("y1",)},
}
USUAL: Mapping[str, tuple[str, ...]] = {
    "deflection": ("x1",),
    "deflection_rate": ("x2",),
    "position": ("x1",),
    "travel": ("t", "x1"),
    "reading": ("x1",),
    "u": ("v_w",),
    "v": ("v_w",),
    "dwell": ("memory",),
}


def depends_on(one: FormulaEffect) -> tuple[str, ...]:
    """Return what an effect depends on, in the words of a report."""
    by = {**USUAL, **SEEN.get(one.where, {})}
    return tuple(dict.fromkeys(name for read in one.depends_on for name in by.get(read, (read,))))


def rival(one: FormulaEffect, scales: Scales | None) -> RivalKind:
    """
    Return the facts of a case's candidate.

    Parameters
    ----------
    one : at its place, as declared
    scales : of the search's numbers, where they are not the declared ones
    """
    linear = sizes(one)
    infos = tuple(_info(name, bounds, linear) for name, bounds in one.ranges.items())
    facts: dict[str, Any] = {"parameters": infos, "depends_on": depends_on(one), "anywhere": one.as_acts}
    return RivalKind(
        one.name,
        one.where,  # type: ignore[arg-type]  # "contact.static" is a place, too
        one.formula,
        words="declared by the user",
        declared=in_scales(one, scales),
        drawn=one.parameters,
        **facts,
    )


def _info(name: str, bounds: tuple[float, float], linear: tuple[str, ...]) -> ParameterInfo:
    if name in linear:
        return ParameterInfo(name, "size", bounds, spread=math.inf)
    return ParameterInfo(name, "sought within its range", bounds, sought=bounds if bounds[0] > 0 else None)
