"""What is done by `stickslip sweep`: a TOML file says what varies, a Zarr store holds the result."""

from __future__ import annotations

import sys
import warnings
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Annotated

import numpy as np
from pydantic import BaseModel, BeforeValidator, ConfigDict, Field, model_validator

from stickslip.cli.printed import console, say_written
from stickslip.declared.declaration import read_effect, read_friction, read_rig
from stickslip.declared.model import Model, load_model
from stickslip.declared.toml_file import Document, read_toml
from stickslip.errors import InputError, ModelWarning, nearest
from stickslip.simulated.sweep.observables import DEFAULT, NOT_COMPUTED
from stickslip.simulated.sweep.sweep import sweep as run_sweep

INTERRUPTED = 130  # what a shell reports of a program that Ctrl-C ended


class SweptAxis(BaseModel):
    """What a name runs through: `values`, or `start`, `stop` and `count` equal steps; `dim` to share a dimension."""

    model_config = ConfigDict(extra="forbid", strict=True)
    values: list[float] | None = None
    start: float | None = None
    stop: float | None = None
    count: Annotated[int, Field(ge=1, le=10**8)] | None = None
    dim: str | None = None

    @model_validator(mode="before")
    @classmethod
    def _briefly(cls, given: object) -> object:
        """Take a list for its values; say what a number alone, and a name among the keys, should be."""
        if isinstance(given, list):
            return {"values": given}
        if not isinstance(given, dict):
            single = isinstance(given, (int, float)) and not isinstance(given, bool)
            what = "a single number" if single else "not numbers"
            raise ValueError(f"{what}; give a list, or start, stop and count")
        ours = given.keys() & cls.model_fields.keys()
        names = [name for name in given if name not in ours and nearest(name, cls.model_fields) is None]
        if ours and names:
            raise ValueError(f"{min(ours)} beside names of states ({', '.join(names)}); leave one out")
        return given


def _axes(given: object) -> object:
    """[over] with an entry for each whole name: one with a dot need not be quoted."""
    if not isinstance(given, dict):
        if isinstance(given, list) and given and all(isinstance(one, dict) for one in given):
            return given  # headed [[over]], which is said of any table
        raise ValueError("must be a table [over] of names and values")
    out: dict[str, object] = {}
    for name, axis in given.items():
        dotted = isinstance(axis, dict) and axis and not axis.keys() & SweptAxis.model_fields.keys()
        for whole, one in ((f"{name}.{rest}", axis[rest]) for rest in axis) if dotted else ((name, axis),):
            if whole in out:
                raise ValueError(f"'{whole}' is given twice; leave one out")
            out[whole] = one
    return out


def _names(given: object) -> object:
    return [given] if isinstance(given, str) else given


class Settings(BaseModel):
    """The table [sweep]: the keywords of `stickslip.sweep`."""

    model_config = ConfigDict(extra="forbid", strict=True)
    t_end: float
    after: float = 0.0
    belt_speed: float | None = None
    drive_speed: float | None = None
    drive: float | str | list[list[float]] | None = None  # the last: [times, forces]
    initial: list[float] | None = None
    rtol: float = 1e-8
    atol: float = 1e-8
    observe: Annotated[list[str], BeforeValidator(_names)] = list(DEFAULT)
    points: int = 32
    lanes: bool = True
    max_transitions: int = 1_000_000
    max_steps: int = 5_000_000


class SweepFile(BaseModel):
    """sweep.toml. The model is a path, or the tables of a model file here."""

    model_config = ConfigDict(extra="forbid", strict=True)
    model: str | None = None
    sweep: Settings
    over: Annotated[dict[str, SweptAxis], BeforeValidator(_axes)]
    rig: dict[str, object] | None = None
    friction: dict[str, object] = {}
    effect: list[dict[str, object]] = []


def perform(file: Path, out: Path, threads: int | None) -> None:
    """Do what `stickslip sweep` is asked for."""
    document = read_toml(file)
    asked = document.validated(SweepFile)
    model = _model(document, asked)
    over = {name: _values(document, name, axis) for name, axis in asked.over.items()}
    if not over:
        words = "empty; give at least one name and its values, like belt_speed = [0.1, 0.2]"
        raise document.error(words, "over")
    with (
        warnings.catch_warnings(record=True) as said,
        _the_option_out(),
        document.at("sweep"),
        _of_over(document, over),
    ):
        warnings.simplefilter("always")
        ds = run_sweep(
            model, over, **asked.sweep.model_dump(), out=out, threads=threads, progress=console.is_terminal
        )
    for one in said:
        if issubclass(one.category, ModelWarning):
            console.print(f"note: {one.message}", markup=False)
    if (ds["status"].values == NOT_COMPUTED).any():
        console.print(f"stopped; the same command goes on with {out}", markup=False)
        sys.exit(INTERRUPTED)
    _say(ds["status"].values, ds["status"].attrs)
    say_written([out])


@contextmanager
def _the_option_out() -> Iterator[None]:
    """Say of a fault of the store that it lies in the command line, where `--out` stands, and not in the file."""
    try:
        yield
    except InputError as error:
        if error.key == "out":
            raise InputError(error.what, key="--out", value=error.value) from None
        raise


@contextmanager
def _of_over(document: Document, over: Mapping[str, object]) -> Iterator[None]:
    """Say of a fault of what varies that it lies in [over]."""
    try:
        yield
    except InputError as error:
        for name in over:
            unknown = error.key is None and f"'{name}'" in error.what
            if unknown or error.key in (name, f"over['{name}']"):
                raise document.error(error.what, "over", name, value=error.value) from None
        if error.key == "over":
            raise document.error(error.what, "over") from None
        if error.key is not None and error.key.startswith("dimension "):
            raise document.error(f"{error.key}: {error.what}", "over") from None
        raise


def _model(document: Document, asked: SweepFile) -> Model:
    if asked.model is not None:
        if asked.rig is not None or asked.friction or asked.effect:
            raise document.error("a file is given, and tables of a model beside it; leave one out", "model")
        if not asked.model:
            raise document.error('is empty; give the path of a model, like "model.toml"', "model")
        return load_model(document.path.parent / asked.model)
    if asked.rig is None:
        raise document.error('lacks its model: give model = "model.toml", or a table [rig]')
    effects = [read_effect(document, "effect", i, table=one) for i, one in enumerate(asked.effect)]
    rig = read_rig(document, "rig", table=asked.rig)
    law = read_friction(document, "friction", table=asked.friction)
    with document.at():
        return Model(rig, friction=law, effects=tuple(effects))


def _values(document: Document, name: str, axis: SweptAxis) -> object:
    given = axis.values is not None, axis.start is not None, axis.stop is not None, axis.count is not None
    if given == (True, False, False, False):
        values: object = axis.values
    elif axis.start is not None and axis.stop is not None and axis.count is not None and not given[0]:
        values = np.linspace(axis.start, axis.stop, axis.count)
    else:
        raise document.error("give values = [...], or start, stop and count", "over", name)
    return values if axis.dim is None else (axis.dim, values)


def _say(status: np.ndarray[tuple[int, ...], np.dtype[np.int8]], attrs: Mapping[str, object]) -> None:
    """Print how many members ended how."""
    flags = np.asarray(attrs["flag_values"]).tolist()
    meanings = dict(zip(flags, str(attrs["flag_meanings"]).split(), strict=True))
    kinds, counts = np.unique(status, return_counts=True)
    told = ", ".join(f"{count} {meanings[int(kind)]}" for kind, count in zip(kinds, counts, strict=True))
    console.print(f"{status.size} members: {told.replace('_', ' ')}")
