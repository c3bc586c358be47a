"""The tree of a formula: numbers, names and operations on them."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Literal

Operation = Literal[
    "add", "subtract", "multiply", "divide", "power", "negate", "abs", "min", "max", "sign",
    "exp", "log", "sqrt", "sin", "cos", "tan", "tanh", "asinh",
]  # fmt: skip
PIECEWISE = frozenset({"abs", "sign", "min", "max"})  # smooth on either side of a switching surface


@dataclass(frozen=True)
class Number:
    """A number written in the formula."""

    value: float


@dataclass(frozen=True)
class Name:
    """A variable, a parameter or a state."""

    name: str


@dataclass(frozen=True)
class Apply:
    """An operation on one or two trees."""

    operation: Operation
    operands: tuple[Tree, ...]

    def __hash__(self) -> int:
        known: int | None = self.__dict__.get("_hash")
        if known is None:  # kept: of a tree of n nodes it would take n steps each time
            known = hash((self.operation, self.operands))
            self.__dict__["_hash"] = known
        return known

    def __getstate__(self) -> dict[str, object]:
        # another process hashes text otherwise
        return {name: one for name, one in self.__dict__.items() if name != "_hash"}


Tree = Number | Name | Apply


def nodes(tree: Tree) -> Iterator[Tree]:
    """Every node, operands before what is made of them; one that occurs twice comes twice."""
    if isinstance(tree, Apply):
        for one in tree.operands:
            yield from nodes(one)
    yield tree


def names(tree: Tree) -> set[str]:
    """Names that a tree reads."""
    return {one.name for one in nodes(tree) if isinstance(one, Name)}


def substituted(tree: Tree, by: Mapping[str, Tree]) -> Tree:
    """Put trees in the place of names."""
    if isinstance(tree, Name):
        return by.get(tree.name, tree)
    if isinstance(tree, Number):
        return tree
    return Apply(tree.operation, tuple(substituted(one, by) for one in tree.operands))


def switches(tree: Tree) -> list[Apply]:
    """Return the operations that are smooth in pieces only, each once, inner ones first."""
    found = [one for one in nodes(tree) if isinstance(one, Apply) and one.operation in PIECEWISE]
    return list(dict.fromkeys(found))


def written(tree: Tree) -> str:
    """Write a tree as a formula again."""
    if isinstance(tree, Number):
        return repr(tree.value)
    if isinstance(tree, Name):
        return tree.name
    parts = [written(one) for one in tree.operands]
    signs = {"add": "+", "subtract": "-", "multiply": "*", "divide": "/", "power": "**"}
    if tree.operation in signs:
        return f"({parts[0]} {signs[tree.operation]} {parts[1]})"
    if tree.operation == "negate":
        return f"(-{parts[0]})"
    return f"{tree.operation}({', '.join(parts)})"
