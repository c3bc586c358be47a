"""What was found of a block on a belt in scaled numbers, said in the declared ones."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

from stickslip.discovery.result import Curve, FoundEffect
from stickslip.likelihoods.interval import Interval
from stickslip.likelihoods.scaled import Scaled


def in_units(units: Scaled, name: str, one: Interval) -> Interval:
    """Return a number of a model with its limits in the declared units."""
    size = units.size(name)
    return Interval(*(None if x is None else x * size for x in (one.value, one.low, one.high)))  # type: ignore[arg-type]


def found(units: Scaled, one: FoundEffect) -> FoundEffect:
    """Return what was found in the declared units."""

    def turned(name: str, numbers: Mapping[str, Interval]) -> dict[str, Interval]:
        return {k: in_units(units, f"{name}.{k}", v) for k, v in numbers.items()}

    rivals = tuple(replace(a, parameters=turned(a.name, a.parameters)) for a in one.alternatives)
    curve = None if one.curve is None else _curve(units, one.curve)
    return replace(one, parameters=turned(one.name, one.parameters), alternatives=rivals, curve=curve)


def _curve(units: Scaled, one: Curve) -> Curve:
    along, size = units.of_curve(one.where, one.variable)
    return replace(
        one,
        x=one.x * along,
        knots=one.knots * along,
        period=None if one.period is None else one.period * along,
        value=one.value * size,
        low=one.low * size,
        high=one.high * size,
    )
