"""What a sweep varies: names, values, dimensions, and the members they make; all checked before any work."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from stickslip.arguments import must_be
from stickslip.declared.effect import CATALOGUE, CONSTANTS
from stickslip.declared.model import Model
from stickslip.errors import InputError, number
from stickslip.simulated.lowering import READ_ALONE

Floats = NDArray[np.float64]
MOST = 10**18  # members
CHECKED = 2000  # members of which a model is made to see that it is allowed


class Slots(Protocol):
    """What is asked of a lowered model: where each name goes, and what it is multiplied by there."""

    @property
    def slots(self) -> Mapping[str, tuple[int, ...]]:
        """Places of a name."""

    def seeds(self, names: Iterable[str]) -> Floats:
        """Return a row of weights a name."""


@dataclass(frozen=True)
class GridColumn:
    """One varied name: its values along its dimension, the slots of the core they go to, and by what they are
    multiplied there. `name` is as it was given, `full_name` what it stands for.
    """

    name: str
    full_name: str
    dim: str
    values: Floats
    slots: tuple[int, ...]
    factors: tuple[float, ...]


@dataclass(frozen=True)
class Grid:
    """The members of a sweep, numbered in C order over the dimensions; never held all at once."""

    columns: tuple[GridColumn, ...]

    @cached_property
    def sizes(self) -> dict[str, int]:
        """Dimension -> length, in the order given."""
        return {column.dim: len(column.values) for column in self.columns}

    @property
    def shape(self) -> tuple[int, ...]:
        """Lengths of the dimensions."""
        return tuple(self.sizes.values())

    @property
    def members(self) -> int:
        """Number of trajectories."""
        return math.prod(self.shape)

    @property
    def slots(self) -> NDArray[np.int32]:
        """(k,) slots, as `values` has its columns."""
        return np.array([slot for column in self.columns for slot in column.slots], dtype=np.int32)

    def values(self, start: int, stop: int) -> Floats:
        """Return (stop - start, k) values of the members from `start` on."""
        index = dict(zip(self.sizes, np.unravel_index(np.arange(start, stop), self.shape), strict=True))
        chosen = [
            column.values[index[column.dim]] * factor for column in self.columns for factor in column.factors
        ]
        return np.ascontiguousarray(np.stack(chosen, axis=1))

    def named(self, place: Mapping[str, int]) -> dict[str, float]:
        """Return the varied numbers at an index of each dimension."""
        return {column.name: float(column.values[place[column.dim]]) for column in self.columns}


def make_grid(over: object, model: Model, lowered: Slots, taken: frozenset[str]) -> Grid:
    """Check `over` and turn it into a grid.

    Parameters
    ----------
    over
        Name -> array, or (dimension, array).
    taken
        Names that a dimension cannot have, being those of results.

    Raises
    ------
    InputError
        Nothing to vary; a name that is unknown (with the nearest known one) or given twice; an array that is
        empty, not one-dimensional or not finite; lengths of a shared dimension that differ; a value that the
        model does not allow.
    """
    must_be("over", over, Mapping, "give names and their values, like {'belt_speed': array}")
    if not isinstance(over, Mapping) or not over:
        raise InputError(
            "empty; give at least one name and its values, like {'belt_speed': array}", key="over"
        )
    columns = [_varied(name, given, over, model, lowered, taken) for name, given in over.items()]
    _consistent(columns)
    grid = Grid(tuple(columns))
    if math.prod(grid.sizes.values()) > MOST:
        raise InputError(
            f"has {math.prod(grid.sizes.values()):.3g} members, more than can be counted", key="over"
        )
    _allowed(grid, model)
    return grid


def _varied(
    name: str,
    given: object,
    over: Mapping[str, object],
    model: Model,
    lowered: Slots,
    taken: frozenset[str],
) -> GridColumn:
    must_be("over", name, str, "the names of what varies are strings")
    if name == "initial":
        first = model.rig.state_names[0]
        raise InputError(
            f"'initial' is not one number; vary its states: 'initial.{first}', ...; whole starts on a shared "
            f"dimension: {{'initial.{first}': ('start', {first}), ...}}",
            key="over",
        )
    dim, values = _column(name, given)
    if dim != name and dim in over:
        raise InputError(f"is varied too; give the dimension of '{name}' another name", key=dim)
    if not dim:
        raise InputError("its dimension's name is empty", key=f"over['{name}']")
    if dim in taken:
        raise InputError(f"cannot be a dimension's name, a result has it; it varies {name}", key=dim)
    full = model.full_name(name)
    slots = _slots(name, full, model, lowered)
    return GridColumn(name, full, dim, values, slots, tuple(lowered.seeds([full])[0, list(slots)].tolist()))


def _column(name: str, given: object) -> tuple[str, Floats]:
    key, dim = f"over['{name}']", name
    if isinstance(given, tuple) and len(given) == 2 and isinstance(given[0], str):
        dim, given = given
    if np.ma.is_masked(given):
        raise InputError("has masked entries, which are missing; fill them in or leave them out", key=key)
    try:
        raw = np.asarray(given)
        if raw.dtype.kind not in "iufO":
            raise TypeError
        if raw.dtype.kind == "O" or isinstance(given, (list, tuple)):
            _all_numbers(key, given if isinstance(given, (list, tuple)) else raw)
        values = np.array(given, dtype=np.float64)
    except (TypeError, ValueError, OverflowError) as error:
        if isinstance(error, InputError):
            raise
        raise InputError("not numbers; give an array, or a pair (dimension, array)", key=key) from None
    if values.ndim != 1:
        words = "a single number; set it in the model, or give an array" if values.ndim == 0 else ""
        raise InputError(words or f"must have one dimension, has shape {values.shape}", key=key)
    if values.size == 0:
        raise InputError("empty; the grid has no members", key=key)
    bad = np.flatnonzero(~np.isfinite(values))
    if bad.size:
        raise InputError(f"entry {bad[0]} is {values[bad[0]]}; every value must be finite", key=key)
    return dim, values


def _all_numbers(key: str, given: Iterable[object]) -> None:
    """Refuse what numpy would make a number of: a truth value among numbers, a text, None."""
    for i, one in enumerate(given):
        if isinstance(one, (bool, np.bool_, str, bytes)) or one is None:
            raise InputError(f"entry {i} is {one!r}, not a number", key=key)


def _slots(given: str, name: str, model: Model, lowered: Slots) -> tuple[int, ...]:
    """Slots of a full name; what is wrong is said of the name as given."""
    known, owner = model.parameters, name.partition(".")[0]
    if name == "initial.m" or (name in known and (name not in lowered.slots or owner in READ_ALONE)):
        raise InputError("acts on the reading, not on the motion; a sweep observes the motion", key=given)
    if owner in CONSTANTS:
        raise InputError("corrects a number of the rig; vary that number itself", key=given)
    if owner in CATALOGUE and name not in known:
        if all(one.name != owner for one in model.effects):
            raise InputError(f"the model has no effect '{owner}'; add it to its effects first", key=given)
        CATALOGUE[owner].parameter(name.partition(".")[2])
    if "." not in name and name not in known and name not in lowered.slots:
        model.parameter_name(name)  # says what is wrong, and the nearest name
    return tuple(int(slot) for slot in np.flatnonzero(lowered.seeds([name])[0]))


def _consistent(columns: list[GridColumn]) -> None:
    first: dict[str, GridColumn] = {}
    owner: dict[int, str] = {}
    for column in columns:
        other = first.setdefault(column.dim, column)
        if len(column.values) != len(other.values):
            raise InputError(
                f"'{column.name}' has {len(column.values)} values, '{other.name}' {len(other.values)}; on a "
                "shared dimension they must be as many",
                key=f"dimension '{column.dim}'",
            )
        for slot in column.slots:
            if owner.setdefault(slot, column.name) != column.name:
                raise InputError(f"is the same number as '{owner[slot]}'; give it once", key=column.name)


def _allowed(grid: Grid, model: Model) -> None:
    """Make the model at the members where a bound would be broken first.

    Bounds are intervals and orders of two numbers (eta12 >= eta1), so it is enough to look at the extremes of each
    number and of each difference of two along each dimension, in all their combinations.
    """
    ours = [column for column in grid.columns if column.full_name in model.parameters]
    sizes = {column.dim: len(column.values) for column in ours}
    places = {dim: _extremes([column.values for column in ours if column.dim == dim]) for dim in sizes}
    for place in _combinations(places):
        values = {column.full_name: float(column.values[place[column.dim]]) for column in ours}
        try:
            model.replace(values)
        except InputError as error:
            culprit = _culprit(ours, error.key or "")
            if culprit is None:
                raise
            index = place[culprit.dim]
            number(culprit.name, culprit.values[index])
            raise InputError(
                f"entry {index} is {culprit.values[index]:g}: {error.what}", key=f"over['{culprit.name}']"
            ) from None


def _culprit(ours: list[GridColumn], key: str) -> GridColumn | None:
    """The number that an error names: by its full name, or by its own where the error knows no owner."""
    by_name = [one for one in ours if one.full_name == key]
    short = [one for one in ours if one.full_name.rpartition(".")[2] == key]
    return next(iter([*by_name, *short]), None)


def _extremes(along: list[Floats]) -> list[int]:
    if len(along[0]) <= 8:
        return list(range(len(along[0])))
    looked_at = [*along, *(a - b for a, b in itertools.combinations(along, 2))]
    return sorted({int(f(x)) for x in looked_at for f in (np.argmin, np.argmax)})


def _combinations(places: Mapping[str, list[int]]) -> Iterator[dict[str, int]]:
    """All combinations where they are few, else those of any two dimensions beside the firsts of the others."""
    if not places:
        return
    if math.prod(len(one) for one in places.values()) <= CHECKED:
        for chosen in itertools.product(*places.values()):
            yield dict(zip(places, chosen, strict=True))
        return
    firsts = {dim: some[0] for dim, some in places.items()}
    for one, other in itertools.combinations(places, 2):
        for pair in itertools.product(places[one], places[other]):
            yield firsts | dict(zip((one, other), pair, strict=True))
