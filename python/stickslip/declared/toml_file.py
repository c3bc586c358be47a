"""TOML files: read with the line of every key at hand, written whole or not at all."""

from __future__ import annotations

import os
import re
import tomllib
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from types import NoneType
from typing import TypeVar, get_args, get_origin

from pydantic import BaseModel, ValidationError

from stickslip.errors import InputError, Place, did_you_mean
from stickslip.files import whole

Table = Mapping[str, object]
Key = str | int
M = TypeVar("M", bound=BaseModel)

_HEADER = re.compile(r"^\s*(\[\[?)\s*([^\[\]]+?)\s*\]\]?\s*(#.*)?$")
_ASSIGNED = re.compile(r"^\s*([\w.\-\"']+)\s*=")
_INLINE = re.compile(r"([{,])\s*([\w\-\"']+)\s*=")
_QUOTED = re.compile(r'"[^"]*"|\'[^\']*\'')
_LISTED = re.compile(r"(\w+)\[(\d+)\](?:\.(\w+))?")
_AT_LINE = re.compile(r"\s*\(at (?:line (\d+), column \d+|end of document)\)")


@dataclass(frozen=True)
class Document:
    """A TOML file: its tables and where in the text each key stands."""

    path: Path
    text: str
    tables: Table

    def line(self, *keys: Key) -> int | None:
        """Return the line of the key that `keys` lead to, or of the deepest table on the way, or None."""
        best, found, counts, table = 0, None, dict[str, int](), tuple[Key, ...]()
        head, entry, depth = (
            table,
            -1,
            0,
        )  # the key of a list that goes on over lines, its entry, and how deep it is in
        for number, text in enumerate(self.text.splitlines(), start=1):
            bare = _QUOTED.sub("", text).partition("#")[0]
            header = _HEADER.match(text)
            if header and depth and ("," in header[2] or not header[2][0].isalpha()):
                header = None  # a row of a matrix
            assigned = None if depth else _ASSIGNED.match(text)
            paths = list[tuple[Key, ...]]()
            if header:
                table, depth = _parts(header[2]), 0
                if header[1] == "[[":
                    counts[header[2]] = counts.get(header[2], -1) + 1
                    table = (*table, counts[header[2]])
                head, paths = table, [table]
            elif assigned:
                head, entry = (*table, *_parts(assigned[1])), -1
                paths = [head]
            of_list = depth > 0 or bool(assigned and bare.partition("=")[2].lstrip().startswith("["))
            for begin, key in [] if header else _INLINE.findall(text):
                entry += begin == "{"
                own = (*head, entry) if of_list else head
                paths += [own, (*own, *_parts(key))]
            if assigned or depth:
                depth = max(0, depth + bare.count("[") - bare.count("]"))
            for path in paths:
                if len(path) > best and path == keys[: len(path)]:
                    best, found = len(path), number
        return found

    def place(self, *keys: Key) -> tuple[Place, str | None]:
        """Return the place of a key for an error, and the key itself: [table] of all but the last."""
        names = [str(key) if isinstance(key, str) else str(key + 1) for key in keys]
        key = names.pop() if names and isinstance(keys[-1], str) else None
        return Place(str(self.path), self.line(*keys), " ".join(names) or None), key

    def error(self, what: str, *keys: Key, value: object = None) -> InputError:
        """Return the error `what` at a key."""
        place, key = self.place(*keys)
        return InputError(what, key=key, value=value, place=place)

    @contextmanager
    def at(self, *keys: Key) -> Iterator[None]:
        """Say of errors raised within that they lie in the table `keys`, at the key they name."""
        try:
            yield
        except InputError as error:
            if error.place is not None:
                raise
            if error.key is None:
                place, last = self.place(*keys)
                table = " ".join(part for part in (place.table, last) if part)
                raise error.placed(Place(place.file, place.line, table or None)) from None
            # "belt_seam.L" is said by an effect; the file knows it as L. "belt_speed[1].value" is an entry's
            listed = _LISTED.fullmatch(error.key)
            own = (error.key.rsplit(".", 1)[-1],)
            path = (*keys, *((listed[1], int(listed[2]), *filter(None, [listed[3]])) if listed else own))
            raise self.error(error.what, *path, value=error.value) from None

    def validated(self, model: type[M]) -> M:
        """Return the tables as a `model`, or raise its first fault in one line."""
        try:
            return model.model_validate(self.tables)
        except ValidationError as error:
            raise _first_fault(self, model, error) from None


def _parts(dotted: str) -> tuple[str, ...]:
    return tuple(part.strip().strip("\"'") for part in dotted.split("."))


def read_toml(path: str | os.PathLike[str]) -> Document:
    """Read a TOML file.

    Raises
    ------
    InputError
        No such file, not text, or not TOML (with the line).
    """
    file = Path(path)
    if file.suffix.lower() in (".csv", ".mat", ".txt", ".tsv"):
        raise InputError(
            "a recording; give the rig.toml beside it, or the model's .toml", place=Place(str(file))
        )
    try:
        text = file.read_text(encoding="utf-8-sig")
    except FileNotFoundError:
        raise InputError("no such file", place=Place(str(file))) from None
    except IsADirectoryError:
        raise InputError("a folder, not a file; give the .toml file in it", place=Place(str(file))) from None
    except UnicodeDecodeError:
        raise InputError("not UTF-8 text; save it as UTF-8", place=Place(str(file))) from None
    except OSError as error:
        raise InputError(f"cannot be read ({error.strerror})", place=Place(str(file))) from None
    try:
        tables = tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        words = str(error)
        at = _AT_LINE.search(words)
        line = int(at[1]) if at and at[1] else len(text.splitlines())
        what = _AT_LINE.sub("", words)
        raise InputError(f"not TOML: {what[:1].lower()}{what[1:]}", place=Place(str(file), line)) from None
    except RecursionError:
        raise InputError("nested too deeply; no table of ours is", place=Place(str(file))) from None
    except ValueError:  # Python refuses to read integers of thousands of digits
        raise InputError("holds a number of thousands of digits", place=Place(str(file))) from None
    return Document(file, text, tables)


def write_text(path: str | os.PathLike[str], text: str) -> None:
    """Write a file whole: it appears complete under its name, or what was there before stays.

    Raises
    ------
    InputError
        The folder cannot be made or written to.
    """
    with whole(Path(path)) as temporary:
        temporary.write_text(text, encoding="utf-8")


def _first_fault(document: Document, model: type[BaseModel], error: ValidationError) -> InputError:
    """Say the first of pydantic's faults in a sentence; a misspelt key before what it leaves missing."""
    faults = error.errors(include_url=False)
    order = {"extra_forbidden": 0, "missing": 2}
    fault = min(faults, key=lambda one: order.get(one["type"], 1))
    # of a value that may be of several types the last key is the type tried
    tried = ("[key]", "[one]", "[steps]", "float", "str")
    keys = tuple(key for key in fault["loc"] if key not in tried)
    match fault["type"]:
        case "extra_forbidden":
            return document.error(f"unknown; {did_you_mean(str(keys[-1]), _known(model, keys[:-1]))}", *keys)
        case "missing":
            needed = ", ".join(_known(model, keys[:-1], required=True))
            place, key = document.place(*keys)
            return InputError(f"lacks '{key}'; it needs {needed}", place=place)
        case "literal_error":
            words = "must be " + str(fault["ctx"]["expected"])
            return document.error(words, *keys, value=fault["input"])
        case "float_type" | "float_parsing":
            return document.error("not a number; give one like 0.5", *keys, value=fault["input"])
        case "dict_type" | "model_type" if "[steps]" in fault["loc"]:
            words = "no step; one is { from = 2.0, value = 0.1 }"
            return document.error(words, *keys, value=fault["input"])
        case "dict_type" | "model_type":
            return _no_table(document, keys, fault["input"])
        case "list_type" if set(_leaves(_at(model, keys))) <= {float, int, str, NoneType}:
            return document.error("must be a list, in [ ]", *keys, value=fault["input"])
        case "list_type":
            table = " ".join(str(key) for key in keys)
            return document.error(f"must be tables, each headed [[{table}]]", *keys)
        case "string_type":
            return document.error('not text; write it in "quotes"', *keys, value=fault["input"])
        case "int_type":
            return document.error("must be a whole number", *keys, value=fault["input"])
        case "bool_type":
            return document.error("must be true or false", *keys, value=fault["input"])
        case "value_error":
            given = None if isinstance(fault["input"], (dict, list)) else fault["input"]
            return document.error(str(fault["ctx"]["error"]), *keys, value=given)
    words = fault["msg"].replace("Input should", "must")
    return document.error(f"{words[:1].lower()}{words[1:]}", *keys, value=fault["input"])


def _no_table(document: Document, keys: tuple[Key, ...], given: object) -> InputError:
    """Say how the table at `keys` is written, of what stands in its place."""
    names = [key for key in keys if isinstance(key, str)]
    if names[:1] == ["channels"] and len(names) == 2:
        words = f'must be a table: {names[1]} = {{ column = "...", unit = "..." }}'
        return document.error(words, *keys, value=None if isinstance(given, list) else given)
    if isinstance(given, list) and all(isinstance(one, dict) for one in given):
        words = f"is there once, so it is headed [{names[-1]}], not [[{names[-1]}]]"
        return InputError(words, key=names[-1], place=Place(str(document.path), document.line(*names, 0)))
    return document.error(f"must be a table, headed [{names[-1]}]", *keys, value=given)


def _known(model: type[BaseModel], keys: tuple[Key, ...], *, required: bool = False) -> list[str]:
    """Names of the fields (all, or those required) at `keys` below a model, through lists of tables."""
    here = _at(model, keys)
    if isinstance(here, type) and issubclass(here, BaseModel):
        fields = here.model_fields.items()
        return [field.alias or name for name, field in fields if field.is_required() or not required]
    return []


def _at(model: type[BaseModel], keys: tuple[Key, ...]) -> object:
    """What stands at `keys` below a model: a model, through lists of them, or the type of a field."""
    here: object = model
    named_by_user = False  # the key of a dict, which is not a field
    for key in (key for key in keys if isinstance(key, str)):
        if named_by_user:
            named_by_user = False
        elif isinstance(here, type) and issubclass(here, BaseModel):
            by_name = {field.alias or name: field.annotation for name, field in here.model_fields.items()}
            here = by_name.get(key)
            named_by_user = get_origin(here) is dict
            models = [one for one in _leaves(here) if isinstance(one, type) and issubclass(one, BaseModel)]
            here = models[0] if models else here
    return here


def _leaves(annotation: object) -> Iterator[object]:
    inner = get_args(annotation)
    if not inner:
        yield annotation
    for one in inner:
        yield from _leaves(one)
