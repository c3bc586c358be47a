"""The tables [rig], [friction], [[effect]] and [channels] of TOML files: to what is declared, and back."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import fields
from typing import Any, TypeVar

from stickslip.declared.catalogue import KINDS
from stickslip.declared.effect import AnyEffect, Tabulated, effect, tabulated
from stickslip.declared.friction_law import FrictionLaw
from stickslip.declared.laws import LAWS
from stickslip.declared.rig import LONG, NONDIMENSIONAL, AnyRig, BlockOnBelt, DrivenSlider, Rig, Scales
from stickslip.declared.toml_file import Document, Key, Table
from stickslip.declared.units import Channel
from stickslip.errors import InputError, did_you_mean

T = TypeVar("T")

RIG_KINDS = ("two_degree", "block_on_belt", "driven_slider")
SI = ("m", "J", "r", "k1", "k2", "k3", "c1", "c2", "length")


def read_rig(document: Document, *keys: Key, table: Table) -> AnyRig:
    """Make the rig that `table`, at `keys` of the document, declares; `kind` is "two_degree" if absent."""
    given = dict(table)
    kind = given.pop("kind", "two_degree")
    if kind not in RIG_KINDS:
        raise document.error(did_you_mean(str(kind), RIG_KINDS), *keys, "kind", value=kind)
    if kind == "block_on_belt":
        if given.keys() & LONG.keys():
            return _made(document, keys, _block_on_belt, given)
        return _made(document, keys, BlockOnBelt, given, required=("mass", "stiffness"))
    if kind == "driven_slider":
        bare = given.keys() & {"mass", "damping"}
        return _made(document, keys, DrivenSlider if bare else _driven_slider, given)
    if given.keys() & {"m", "J", "k1", "k2", "length"}:
        mixed = [name for name in NONDIMENSIONAL if name in given]
        if mixed:
            words = f"the rig is declared in SI ({', '.join(SI)}); leave the nondimensional numbers out"
            raise document.error(words, *keys, mixed[0])
        return _made(document, keys, Rig.from_si, given)
    scales = given.get("scales")
    if isinstance(scales, Mapping):
        given["scales"] = _made(document, (*keys, "scales"), Scales, dict(scales))
    return _made(document, keys, Rig, given)


def read_friction(document: Document, *keys: Key, table: Table) -> FrictionLaw:
    """Make the law that `table` declares; `kind` is "paper" if absent, and so is every number left out."""
    given = dict(table)
    kind = given.pop("kind", "paper")
    if kind not in LAWS:
        raise document.error(did_you_mean(str(kind), LAWS), *keys, "kind", value=kind)
    make: Callable[..., FrictionLaw] = LAWS[str(kind)]
    return _made(document, keys, make, given)


def read_effect(document: Document, *keys: Key, table: Table) -> AnyEffect:
    """Make the effect that `table` declares; "tabulated" has where, depends_on, knots, values."""
    given = dict(table)
    name = given.pop("name", None)
    if name == "tabulated":
        return _made(document, keys, tabulated, given)
    if not isinstance(name, str) or name not in KINDS:
        hint = did_you_mean(str(name), [*KINDS, "tabulated"]) if name is not None else "missing"
        raise document.error(hint if name is None else f"unknown effect; {hint}", *keys, "name", value=name)
    for key in given:
        if key not in KINDS[name].parameter_names:
            hint = did_you_mean(key, KINDS[name].parameter_names)
            raise document.error(f"unknown; {hint}", *keys, key)
    with document.at(*keys):
        return effect(name, **given)  # type: ignore[arg-type]  # `effect` checks every number


def read_channel(document: Document, *keys: Key, table: Table) -> Channel:
    """Make the channel that `table` declares: column, unit, scale."""
    given = dict(table)
    for name in ("column", "unit"):
        if not isinstance(given.get(name, ""), str):
            raise document.error('not text; write it in "quotes"', *keys, name, value=given[name])
    return _made(document, keys, Channel, given)


def rig_table(rig: AnyRig) -> dict[str, object]:
    """Return the table that `read_rig` makes `rig` of, to the last bit."""
    kinds = {Rig: "two_degree", BlockOnBelt: "block_on_belt", DrivenSlider: "driven_slider"}
    table: dict[str, object] = {"kind": kinds[type(rig)]}
    table |= {field.name: getattr(rig, field.name) for field in fields(rig)}
    scales = table.pop("scales", None)
    if isinstance(scales, Scales):
        table["scales"] = {field.name: getattr(scales, field.name) for field in fields(scales)}
    return table


def friction_table(law: FrictionLaw) -> dict[str, object]:
    """Return the table that `read_friction` makes `law` of."""
    numbers = {field.name: getattr(law, field.name) for field in fields(law)}
    return {"kind": law.kind} | {name: value for name, value in numbers.items() if value is not None}


def effect_table(one: AnyEffect) -> dict[str, object]:
    """Return the table that `read_effect` makes the effect of."""
    if not isinstance(one, Tabulated):
        return {"name": one.name, **one.parameters}
    table: dict[str, object] = {"name": "tabulated", "where": one.where, "depends_on": one.variable}
    table |= {"knots": list(one.knots), "values": list(one.values)}
    if one.period is not None:
        table["period"] = one.period
    return table if one.phi == 0 else table | {"phi": one.phi}


def _block_on_belt(*, m: float, k: float, c: float = 0.0) -> BlockOnBelt:
    """Make the block m x1'' = -k x1 - c x1' - T, its numbers in SI."""
    with _short():
        return BlockOnBelt(mass=m, stiffness=k, damping=c)


def _driven_slider(*, m: float, c: float = 0.0) -> DrivenSlider:
    """Make the slider m x1'' = drive - c x1' - T, its numbers in SI."""
    with _short():
        return DrivenSlider(mass=m, damping=c)


@contextmanager
def _short() -> Iterator[None]:
    """Say of an error under which short key the number was declared."""
    names = {long: short for short, long in LONG.items()}
    try:
        yield
    except InputError as error:
        raise InputError(error.what, key=names.get(error.key or "", error.key), value=error.value) from None


def _made(
    document: Document,
    keys: tuple[Key, ...],
    make: Callable[..., T],
    given: dict[str, Any],
    *,
    required: Iterable[str] = (),
) -> T:
    """Call `make` with the given keys, which must be its keywords, and place what it complains of."""
    parameters = inspect.signature(make).parameters
    for key in given:
        if key not in parameters:
            raise document.error(f"unknown; {did_you_mean(key, parameters)}", *keys, key)
    needed = {name for name, one in parameters.items() if one.default is one.empty} | set(required)
    for name in parameters:
        if name in needed and name not in given:
            needs = ", ".join(one for one in parameters if one in needed)
            place, _ = document.place(*keys, name)
            raise InputError(f"lacks '{name}'; it needs {needs}", place=place)
    with document.at(*keys):
        return make(**given)
