"""The tables [rig], [friction], [[effect]], [[candidate]], [channels] of TOML files: to what is declared, and back."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import fields
from typing import Any, TypeVar

from stickslip.declared.bodies_model import check_names_of_laws
from stickslip.declared.candidate import candidate, distinct, on_rig
from stickslip.declared.catalogue import KINDS
from stickslip.declared.contact_laws import ContactLaws
from stickslip.declared.effect import AnyEffect, FormulaEffect, Tabulated, effect, tabulated
from stickslip.declared.formula_effect import formula_effect
from stickslip.declared.formula_laws.formula import FormulaFriction
from stickslip.declared.friction_law import FrictionLaw
from stickslip.declared.law_numbers import check_size
from stickslip.declared.laws import ALL_LAWS
from stickslip.declared.quantity import quantity
from stickslip.declared.rig import LONG, NONDIMENSIONAL, AnyRig, BlockOnBelt, DrivenSlider, Rig, Scales
from stickslip.declared.rig_kinds import RIG_KINDS
from stickslip.declared.rigs.bodies import BodiesRig
from stickslip.declared.rigs.general import GeneralRig, RigError
from stickslip.declared.rigs.matrices import MatricesRig
from stickslip.declared.scatter import EventScatter
from stickslip.declared.toml_file import Document, Key, Table
from stickslip.declared.units import Channel
from stickslip.errors import InputError, did_you_mean

T = TypeVar("T")

GENERAL: Mapping[str, type[BodiesRig] | type[MatricesRig]] = {"bodies": BodiesRig, "matrices": MatricesRig}
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
    if kind in GENERAL:
        return _general(document, keys, GENERAL[str(kind)], given)
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


def read_friction(document: Document, *keys: Key, table: Table, rotation: bool | None = None) -> FrictionLaw:
    """Make the law that `table` declares; `kind` is "paper" if absent, and so is every number left out.

    `rotation` says of a contact of a general rig whether it turns: numbers may be text with a unit then.
    """
    given = dict(table)
    kind = given.pop("kind", "paper")
    if kind not in ALL_LAWS:
        raise document.error(did_you_mean(str(kind), ALL_LAWS), *keys, "kind", value=kind)
    make = ALL_LAWS[str(kind)]
    if make is FormulaFriction:
        with document.at(*keys):
            return FormulaFriction(**given)  # type: ignore[arg-type]  # it looks at everything
    if rotation is not None:
        for name, one in given.items():
            if isinstance(one, str) and name.removesuffix("_plus") in make.dimensions:
                with document.at(*keys):
                    given[name], unit = quantity(name, one)
                    check_size(name, unit, make.dimensions[name.removesuffix("_plus")], rotation)
    return _made(document, keys, make, given)


def read_laws(document: Document, rig: AnyRig) -> FrictionLaw:
    """Make the law of [friction], or, for a rig of bodies or matrices, those of its tables [law.<name>]."""
    tables = document.tables
    if not isinstance(rig, GeneralRig):
        if "law" in tables:
            raise document.error(
                "is for a rig of bodies or matrices; the law of this rig is [friction]", "law"
            )
        return read_friction(document, "friction", table=_table(tables.get("friction", {})))
    if "law" in tables and "friction" in tables:
        raise document.error("give [friction] for all contacts, or a [law.<name>] each, not both", "friction")
    turns: dict[str, bool] = {one.law: one.rotation for one in rig.equations.contacts}
    if "law" not in tables:
        if "friction" not in tables:
            raise document.error(
                "a model lacks its law: [friction], or a [law.<name>] for each name of a contact"
            )
        rotation = next(iter(turns.values()), False)
        return read_friction(document, "friction", table=_table(tables["friction"]), rotation=rotation)
    with document.at("law"):
        check_names_of_laws(rig.equations.contacts, _table(tables["law"]))
    laws = {
        name: read_friction(document, "law", name, table=_table(table), rotation=turns.get(name, False))
        for name, table in _table(tables["law"]).items()
    }
    return ContactLaws(tuple(laws.items()))


def read_effect(document: Document, *keys: Key, table: Table) -> AnyEffect:
    """Make the effect that `table` declares; "tabulated" has where, depends_on, knots, values."""
    given = dict(table)
    name = given.pop("name", None)
    if name == "tabulated":
        return _made(document, keys, tabulated, given)
    if given.get("kind") == "formula" or name == "formula":
        given.pop("kind", None)
        with document.at(*keys):
            return formula_effect(called=str(name or "formula"), **given)  # type: ignore[arg-type]  # it looks
    if not isinstance(name, str) or name not in KINDS:
        hint = did_you_mean(str(name), [*KINDS, "tabulated"]) if name is not None else "missing"
        raise document.error(hint if name is None else f"unknown effect; {hint}", *keys, "name", value=name)
    for key in given:
        if key not in KINDS[name].parameter_names and key not in ("where", "by"):
            hint = did_you_mean(key, KINDS[name].parameter_names)
            raise document.error(f"unknown; {hint}", *keys, key)
    with document.at(*keys):
        return effect(name, **given)


def read_candidate(document: Document, *keys: Key, table: Table) -> FormulaEffect:
    """Make the rival that `table` declares: name, where, a formula, its numbers and their ranges."""
    given = dict(table)
    if (kind := given.pop("kind", "formula")) != "formula":
        raise document.error("a rival is a formula; leave it out", *keys, "kind", value=kind)
    for needed in ("name", "ranges"):
        if needed not in given:
            place, _ = document.place(*keys, needed)
            words = "name, where, one of force, factor and reading, and ranges"
            raise InputError(f"lacks '{needed}'; it needs {words}", place=place)
    with document.at(*keys):
        return candidate(**given)  # type: ignore[arg-type]  # it looks


def read_candidates(
    document: Document,
    tables: Iterable[Table],
    rig: AnyRig,
    friction: FrictionLaw,
    channels: Mapping[str, Channel],
) -> tuple[FormulaEffect, ...]:
    """Make the rivals of [[candidate]], each at its place and once."""
    found: list[FormulaEffect] = []
    for i, table in enumerate(tables):
        one = read_candidate(document, "candidate", i, table=table)
        with document.at("candidate", i):
            found.append(on_rig(one, rig, friction, channels))
            if one.name in [each.name for each in found[:-1]]:
                raise InputError("is there twice; name one otherwise", key="name", value=one.name)
    return distinct(found)


def read_channel(document: Document, *keys: Key, table: Table) -> Channel:
    """Make the channel that `table` declares: column, unit, scale."""
    given = dict(table)
    for name in ("column", "unit"):
        if not isinstance(given.get(name, ""), str):
            raise document.error('not text; write it in "quotes"', *keys, name, value=given[name])
    return _made(document, keys, Channel, given)


def read_scatter(document: Document, table: Table) -> EventScatter:
    """Make the scatter that [scatter] of a model declares."""
    return _made(document, ("scatter",), EventScatter, dict(table))


def rig_table(rig: AnyRig) -> dict[str, object]:
    """Return the table that `read_rig` makes `rig` of, to the last bit."""
    if isinstance(rig, GeneralRig):
        return rig.table()
    kinds = {Rig: "two_degree", BlockOnBelt: "block_on_belt", DrivenSlider: "driven_slider"}
    table: dict[str, object] = {"kind": kinds[type(rig)]}
    table |= {field.name: getattr(rig, field.name) for field in fields(rig)}
    scales = table.pop("scales", None)
    if isinstance(scales, Scales):
        table["scales"] = {field.name: getattr(scales, field.name) for field in fields(scales)}
    return table


def friction_table(law: FrictionLaw) -> dict[str, object]:
    """Return the table that `read_friction` makes `law` of."""
    if isinstance(law, FormulaFriction):
        return {"kind": law.kind, **law.table()}
    values = {field.name: getattr(law, field.name) for field in fields(law)}
    numbers = {name: list(one) if isinstance(one, tuple) else one for name, one in values.items()}
    return {"kind": law.kind} | {name: value for name, value in numbers.items() if value is not None}


def effect_table(one: AnyEffect) -> dict[str, object]:
    """Return the table that `read_effect` makes the effect of."""
    if isinstance(one, FormulaEffect):
        return one.table()
    if not isinstance(one, Tabulated):
        where = {"where": one.where} if one.placed else {}
        return {"name": one.name, **where, **({"by": one.by} if one.by else {}), **one.parameters}
    table: dict[str, object] = {"name": "tabulated", "where": one.where, "depends_on": one.variable}
    table |= {"knots": list(one.knots), "values": list(one.values)}
    if one.period is not None:
        table["period"] = one.period
    return table if one.phi == 0 else table | {"phi": one.phi}


def _general(
    document: Document,
    keys: tuple[Key, ...],
    make: type[BodiesRig] | type[MatricesRig],
    given: dict[str, Any],
) -> AnyRig:
    """Make a rig of bodies or matrices, and say in which of its tables a fault lies."""
    known = [one.name for one in fields(make)]
    for key in given:
        if key not in known:
            raise document.error(f"unknown; {did_you_mean(key, known)}", *keys, key)
    for name in ("M", "K") if make is MatricesRig else ("body",):
        if name not in given:
            what = "its matrix" if make is MatricesRig else "a body, like [rig.body.block]: it lacks"
            raise document.error(f"lacks {what} '{name}'", *keys)
    try:
        return make(**given)
    except RigError as error:
        raise document.error(error.what, *keys, *error.path, value=error.value) from None
    except InputError as error:
        raise document.error(
            error.what, *keys, *([error.key] if error.key else []), value=error.value
        ) from None


def _table(value: object) -> Table:
    return value if isinstance(value, Mapping) else {}


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
