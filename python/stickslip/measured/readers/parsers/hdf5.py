"""HDF5 files, those of MATLAB 7.3 among them: vectors, columns of matrices, fields of tables.

A dataset is called by its path ("run/F", or "run.F" as MATLAB has it). Columns of a matrix are "data[:,0]", those of
MATLAB "data(:,1)", its cells "data{1}" and its many structs "run(2).F". Packed
numbers are unpacked by `scale_factor` and `add_offset`, as the CF conventions say.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any

import h5py
import numpy as np

WIDEST = 256  # columns of a matrix that are offered each
DEEPEST = 16  # references of references
LONGEST = 10_000  # characters of words that may be the titles of columns
Read = Callable[[], np.ndarray]


def answer(file: str, names: list[str]) -> tuple[dict[str, Any], list[np.ndarray]]:
    """Return what the file holds, and the columns asked for."""
    with h5py.File(file, "r") as opened:
        found: dict[str, Read] = {}
        units: dict[str, str] = {}
        odd: dict[str, str] = {}
        words: dict[str, str] = {}
        for path, data in _datasets(opened):
            if _matlab_class(data) == "char" and data.size <= LONGEST:
                words |= _words(path, data)
            try:
                parts = _columns(path, data)
            except _OddError as error:
                odd[path] = str(error)
                continue
            found |= parts
            units |= dict.fromkeys(parts, _unit(data))
        known = [*found, *odd]
        also = _also(known)
        head: dict[str, Any] = {
            "known": known,
            "units": units,
            "also": also,
            "words": words,
            "facts": [f"{len(known)} columns"],
            "paths": True,
        }
        if any(known.count(name) != 1 for name in names):
            return head, []
        for name in names:
            if name in odd:
                return {**head, "fault": odd[name], "column": name}, []
        return head, [np.asarray(found[name](), dtype=np.float64) for name in names]


class _OddError(Exception):
    """A dataset that is no vector of real numbers."""


def _datasets(opened: Any) -> list[tuple[str, Any]]:
    """All datasets by path, those that MATLAB hides left out; cells and structs of MATLAB by what they refer to."""
    found: list[tuple[str, Any]] = []

    def look(into: Any, of: str, depth: int) -> None:
        def one(path: str, what: Any) -> None:
            if isinstance(what, h5py.Dataset) and not (not of and path.startswith("#")):
                add(of + path, what, depth)

        into.visititems(one)

    def add(path: str, data: Any, depth: int) -> None:
        if h5py.check_ref_dtype(data.dtype) is None or depth > DEEPEST:
            found.append((path, data))
            return
        cell = _matlab_class(data) == "cell"
        parent, _, field = path.rpartition("/")
        for k, reference in enumerate(np.ravel(data[...]), 1):  # h5py sees MATLAB's order of columns as rows
            if not reference:
                continue
            to = opened[reference]
            name = f"{path}{{{k}}}" if cell else f"{parent}({k})/{field}"
            if isinstance(to, h5py.Dataset):
                add(name, to, depth + 1)
            else:
                look(to, f"{name}/", depth + 1)

    look(opened, "", 0)
    return found


def _matlab_class(data: Any) -> str:
    said = data.attrs.get("MATLAB_class", b"")
    return said.decode() if isinstance(said, bytes) else str(said)


def _words(path: str, data: Any) -> dict[str, str]:
    """A word of MATLAB, or the rows of a char matrix, as a cell of words has them; h5py sees them transposed."""
    codes = np.atleast_2d(data[...])
    if codes.dtype.kind != "u" or codes.ndim > 2:
        return {}
    told = ["".join(map(chr, one)).strip() for one in codes.T]
    return {path: told[0]} if len(told) == 1 else {f"{path}{{{k}}}": one for k, one in enumerate(told, 1)}


def _columns(path: str, data: Any) -> dict[str, Read]:
    """The columns of a dataset, each with what reads it."""
    matlab = _matlab_class(data)
    if matlab and data.attrs.get("MATLAB_empty", 0):  # the dataset then holds the shape
        raise _OddError(f"an empty {matlab} array; a channel is a real vector")
    kind, shape = data.dtype, data.shape
    if kind.names is not None and len(shape) == 1:
        fields = [one for one in kind.names if kind[one].kind in "iufb" and not kind[one].shape]
        return {f"{path}/{one}": partial(_part, data, one) for one in fields}
    what = matlab or kind.name
    if kind.kind not in "iufb" or matlab in ("char", "cell") or not shape or len(shape) > 2:
        raise _OddError(f"a {what} array of shape {shape}; a channel is a real vector")
    if max(shape) == data.size:
        return {path: partial(_part, data, ...)}
    count = shape[0] if matlab else shape[1]
    if count > WIDEST:
        raise _OddError(f"a matrix of shape {shape}; a channel is a real vector")
    if matlab:  # h5py sees a matrix of MATLAB transposed
        return {f"{path}(:,{j + 1})": partial(_part, data, (j, slice(None))) for j in range(count)}
    return {f"{path}[:,{j}]": partial(_part, data, (slice(None), j)) for j in range(count)}


def _part(data: Any, which: Any) -> np.ndarray:
    """Part of a dataset as a vector, numbers unpacked as the CF conventions pack them; what is missing becomes NaN."""
    values: np.ndarray = np.ravel(data[which])
    said = {key: data.attrs.get(key) for key in ("scale_factor", "add_offset", "_FillValue")}
    said = {
        key: float(np.ravel(value)[0])
        for key, value in said.items()
        if np.size(value) == 1 and value is not None
    }
    if not said:
        return values
    out: np.ndarray = np.array(values, dtype=np.float64)
    missing = out == said.get("_FillValue", np.nan)
    out = out * said.get("scale_factor", 1.0) + said.get("add_offset", 0.0)
    out[missing] = np.nan
    return out


def _unit(data: Any) -> str:
    """The unit in a dataset's attributes."""
    said = next((data.attrs[key] for key in ("units", "unit", "Units", "Unit") if key in data.attrs), "")
    if isinstance(said, np.ndarray):
        said = said.ravel()[0] if said.size == 1 else ""
    return said.decode(errors="replace") if isinstance(said, bytes) else str(said)


def _also(known: list[str]) -> dict[str, str]:
    """Columns by their last name where only one has it, and by dots in place of slashes."""
    bare = [name.rpartition("/")[2] for name in known]
    last = {short: name for short, name in zip(bare, known, strict=True) if bare.count(short) == 1}
    return last | {name.replace("/", "."): name for name in known}
