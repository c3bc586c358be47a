"""The laws of a rig's contacts, by their names."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar, Self

from stickslip.declared.dimensions import Dimension
from stickslip.declared.friction_law import Direction, FrictionLaw, LawBranch
from stickslip.errors import InputError, did_you_mean

_SEVERAL = "a rig of several contacts has a law for each; ask one of them"


@dataclass(frozen=True)
class ContactLaws(FrictionLaw):
    """Several laws by name, of a rig whose contacts name them.

    Parameters
    ----------
    laws
        Pairs of a name and a law.
    """

    kind: ClassVar[str] = "several"
    rank: ClassVar[int] = 1000
    dimensions: ClassVar[Mapping[str, Dimension]] = {}

    laws: tuple[tuple[str, FrictionLaw], ...]

    def __getitem__(self, name: str) -> FrictionLaw:
        """The law of that name."""
        known = dict(self.laws)
        if name not in known:
            raise InputError(f"no law '{name}'; {did_you_mean(name, known)}", key="law")
        return known[name]

    @property
    def numbers(self) -> dict[str, float]:
        """Every law's numbers by "<law>.<number>"."""
        return {f"{name}.{key}": one for name, law in self.laws for key, one in law.numbers.items()}

    def with_numbers(self, values: Mapping[str, float]) -> Self:
        """Return the laws with some numbers changed."""
        by: dict[str, dict[str, float]] = {}
        for name, size in values.items():
            owner, _, key = name.partition(".")
            by.setdefault(owner, {})[key] = size
        return type(self)(tuple((name, law.with_numbers(by.get(name, {}))) for name, law in self.laws))

    @property
    def static_limits(self) -> tuple[float, float]:
        """Refused: there are several."""
        raise InputError(_SEVERAL, key="friction")

    @property
    def kinks(self) -> tuple[float | None, float | None]:
        """Refused: there are several."""
        raise InputError(_SEVERAL, key="friction")

    def branch(self, direction: Direction) -> LawBranch:  # noqa: ARG002  # as every law's
        """Refused: there are several."""
        raise InputError(_SEVERAL, key="friction")
