"""An effect of one's own, written as a formula."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass, field
from typing import Any, Literal, Self

import numpy as np

from stickslip.arguments import must_be
from stickslip.declared.acts import Acts
from stickslip.declared.formula.parse import CONSTANTS, FUNCTIONS, parse
from stickslip.declared.formula.range import check_range
from stickslip.declared.formula.tree import Tree, names
from stickslip.declared.formula_laws.formula import LawState
from stickslip.declared.quantity import quantity
from stickslip.errors import InputError, did_you_mean, number

Kind = Literal["force", "factor", "reading"]
KINDS: tuple[Kind, ...] = ("force", "factor", "reading")
LOCAL = ("t", "u", "v", "deflection", "deflection_rate", "position", "travel", "reading")
LOOKS = 401  # numbers of a range that a formula is looked at


@dataclass(frozen=True)
class FormulaEffect:
    """An effect of one's own: a force, a factor or a reading as a formula; made by `effect("formula", ...)`.

    Attributes
    ----------
    name, where
        What it is called, and the place of the rig that it acts on.
    acts
        Which of "force", "factor", "reading" its formula is.
    formula
        As it was written.
    states
        Its own states by name.
    given
        Its numbers: name, size in SI, unit or None.
    ranges
        Lower and upper bound by name, of numbers that have them.
    """

    name: str
    where: str
    acts: Kind
    formula: str
    given: tuple[tuple[str, float, str | None], ...] = ()
    states: tuple[tuple[str, LawState], ...] = ()
    ranges: Mapping[str, tuple[float, float]] = field(default_factory=dict, hash=False)

    def __post_init__(self) -> None:
        if not self.name.replace("-", "_").isidentifier():
            raise InputError("is no name; letters, digits and _ make one", key="name", value=self.name)
        self._check_names()
        trees = self.trees()
        used = set().union(*(names(one) for one in trees.values()))
        for name, size, _ in self.given:
            if name not in used:
                raise InputError("no formula of the effect reads it; leave it out", key=name)
            low, high = self.ranges.get(name, (size, size))
            if not low <= size <= high:
                raise InputError(f"is outside its range from {low:g} to {high:g}", key=name, value=size)
        self._check_ranges(trees)

    @property
    def parameters(self) -> Mapping[str, float]:
        """Its numbers by name, in SI."""
        return {name: size for name, size, _ in self.given}

    @property
    def units(self) -> Mapping[str, str]:
        """SI units of the numbers that were given with one."""
        return {name: unit for name, _, unit in self.given if unit is not None}

    @property
    def depends_on(self) -> tuple[str, ...]:
        """Variables the formula reads, and "memory" where it has states."""
        own = {*self.parameters, *dict(self.states)}
        read = sorted(set().union(*(names(one) for one in self.trees().values())) - own)
        return (*read, *(("memory",) if self.states else ()))

    @property
    def label(self) -> str:
        """The name that its numbers go by."""
        return self.name

    @property
    def as_acts(self) -> Acts:
        """How it acts on a rig of any kind."""
        states = {name: (one.rate, one.start) for name, one in self.states}
        return Acts(**{self.acts: self.formula}, states=states)  # type: ignore[arg-type]  # one of the three

    def trees(self) -> dict[str, Tree]:
        """Every formula by its key."""
        out: dict[str, Tree] = {self.acts: _read(self.acts, self.formula)}
        for name, one in self.states:
            out[f"states.{name}.rate"] = _read(f"states.{name}.rate", one.rate)
            out[f"states.{name}.start"] = _read(f"states.{name}.start", one.start)
        return out

    def replace(self, **parameters: float) -> Self:
        """Return the effect with some of its numbers changed, in SI."""
        known = self.parameters
        for name in parameters:
            if name not in known:
                raise InputError(
                    f"effect '{self.name}' has no parameter '{name}'; {did_you_mean(name, known)}"
                )
        own = [
            (name, number(f"{self.name}.{name}", parameters.get(name, size)), unit)
            for name, size, unit in self.given
        ]
        return type(self)(
            self.name, self.where, self.acts, self.formula, tuple(own), self.states, self.ranges
        )

    def table(self) -> dict[str, object]:
        """Return a file's table [[effect]]."""
        out: dict[str, object] = (
            {"name": "formula"} if self.name == "formula" else {"name": self.name, "kind": "formula"}
        )
        out |= {"where": self.where, self.acts: self.formula}
        if self.states:
            out["states"] = {
                name: {"rate": one.rate, "start": one.start, "unit": one.unit} for name, one in self.states
            }
        out |= {name: size if unit is None else f"{size!r} {unit}" for name, size, unit in self.given}
        return out | (
            {"ranges": {name: list(one) for name, one in self.ranges.items()}} if self.ranges else {}
        )

    def _check_names(self) -> None:
        taken = {
            *LOCAL,
            *FUNCTIONS,
            *CONSTANTS,
            *KINDS,
            "name",
            "kind",
            "called",
            "where",
            "states",
            "ranges",
            "dwell",
        }
        for name in [one for one, _, _ in self.given] + [one for one, _ in self.states]:
            if not name.isidentifier():
                raise InputError("is no name; letters, digits and _ make one", key=str(name))
            if name in taken:
                raise InputError("is taken; name it otherwise", key=name)
            taken.add(name)
        for name in self.ranges:
            if name not in self.parameters:
                raise InputError(
                    f"the effect has no number '{name}'; {did_you_mean(name, self.parameters)}", key="ranges"
                )

    def _check_ranges(self, trees: Mapping[str, Tree]) -> None:
        """Refuse what divides by zero at rest, at some time or speed, or at some number of a range."""
        for key, tree in trees.items():
            of = (
                dict.fromkeys(names(tree), 0.0)
                | {name: 1.0 for name, _ in self.states}
                | dict(self.parameters)
            )
            for over in ("t", "u"):
                if over in names(tree):
                    check_range(key, tree, over, of)
            check_range(key, tree, "t", of)
            for name, (low, high) in self.ranges.items():
                if name in names(tree):
                    check_range(key, tree, name, of, np.linspace(low, high, LOOKS))


def formula_effect(
    *,
    where: str = "",
    called: str = "formula",
    states: Mapping[str, object] | None = None,
    ranges: Mapping[str, object] | None = None,
    **given: object,
) -> FormulaEffect:
    """Make an effect of one's own of the keywords of `effect("formula", ...)`.

    Raises
    ------
    InputError
        No formula or several, one that cannot be read, a number that no formula reads, a division by zero.
    """
    acts = [one for one in KINDS if one in given]
    if len(acts) != 1:
        raise InputError(
            "give one of 'force', 'factor' and 'reading', a formula", key=acts[1] if acts else "force"
        )
    formula = must_be(acts[0], given.pop(acts[0]), str, "a formula is text like '-c*deflection_rate'")
    must_be("where", where, str)
    kept = {key: state_of(key, one) for key, one in must_be("states", states or {}, Mapping).items()}
    own = tuple((key, *quantity(key, one)) for key, one in given.items())
    bounds = {key: range_of(key, one) for key, one in must_be("ranges", ranges or {}, Mapping).items()}
    return FormulaEffect(called, where, acts[0], formula, own, tuple(kept.items()), bounds)


def range_of(name: str, given: object) -> tuple[float, float]:
    """Return a lower and an upper bound of two numbers, with units or bare, in SI.

    Raises
    ------
    InputError
        Not two numbers, the lower one first.
    """
    if isinstance(given, (str, bytes)) or not isinstance(given, Collection) or len(given) != 2:
        raise InputError('must be a lower and an upper bound, like ["0 N", "5 N"]', key=name, value=given)
    (low, one), (high, other) = (quantity(name, each) for each in given)
    if one != other:
        raise InputError("both bounds need a unit of the same kind", key=name)
    if not low < high:
        raise InputError(f"its lower bound {low:g} is not below the upper one {high:g}", key=name)
    return low, high


def state_of(name: str, given: object) -> LawState:
    """Return a state of an effect: a `LawState`, or the table of one."""
    if isinstance(given, LawState):
        return given
    table: Any = must_be(f"states.{name}", given, Mapping, 'like {rate = "deflection - z", unit = "m s"}')
    known = ("rate", "start", "unit")
    for key in table:
        if key not in known:
            raise InputError(f"unknown; {did_you_mean(str(key), known)}", key=f"states.{name}.{key}")
    if "rate" not in table:
        raise InputError("lacks its rate", key=f"states.{name}")
    return LawState(**{key: str(one) for key, one in table.items()})


def _read(key: str, text: str) -> Tree:
    try:
        return parse(text)
    except InputError as error:
        raise InputError(error.what, key=key, value=error.value) from None
