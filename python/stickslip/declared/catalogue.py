"""The catalogue of effects that the declared model lacks: every file of `effects/`, by the ranks that they give."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from importlib import import_module
from pkgutil import iter_modules

from stickslip.declared import effects
from stickslip.declared.effect_kind import EffectKind
from stickslip.declared.effects.position_ripple import NAMES as POSITION_RIPPLES
from stickslip.objects import one_line

__all__ = ["CATALOGUE", "CONSTANTS", "DRIVEN", "KINDS", "POSITION_RIPPLES"]


class Catalogue(dict[str, EffectKind]):
    """Effects by name, printed in one line."""

    def __repr__(self) -> str:
        return one_line(f"<{len(self)} effects: {', '.join(self)}>")


def _found() -> list[EffectKind]:
    names = [one.name for one in iter_modules(effects.__path__)]
    return [import_module(f"{effects.__name__}.{name}").EFFECT for name in names]


def _ranked(kinds: list[EffectKind], rank: Callable[[EffectKind], int | None]) -> dict[str, EffectKind]:
    placed = [(place, kind) for kind in kinds if (place := rank(kind)) is not None]
    return {kind.name: kind for _, kind in sorted(placed, key=lambda one: one[0])}


_KINDS = _found()
_ON_BELT = _ranked(_KINDS, lambda kind: kind.on_belt)

CATALOGUE: Mapping[str, EffectKind] = Catalogue(
    {name: kind for name, kind in _ON_BELT.items() if kind.corrects is None}
)
# a block on a belt may have been declared with a wrong number; a spring's force read off its deflection tells of both
CONSTANTS: Mapping[str, EffectKind] = {
    name: kind for name, kind in _ON_BELT.items() if kind.corrects is not None
}
# a driven slider has no belt and no spring; what acts on it, SI throughout: T is its friction, F its drive
DRIVEN: Mapping[str, EffectKind] = _ranked(_KINDS, lambda kind: kind.on_slider)
KINDS: Mapping[str, EffectKind] = {**CATALOGUE, **CONSTANTS, **DRIVEN}
