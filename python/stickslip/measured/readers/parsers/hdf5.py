"""HDF5 files, those of MATLAB 7.3 among them: vectors, columns of matrices, fields of tables.

A dataset is called by its path ("run/F", or "run.F" as MATLAB has it). Columns of a matrix are "data[:,0]", those of
MATLAB "data(:,1)". Packed numbers are unpacked by `scale_factor` and `add_offset`, as the CF conventions say.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any

import h5py
import numpy as np

WIDEST = 256  # columns of a matrix that are offered each
Read = Callable[[], np.ndarray]


def answer(file: str, names: list[str]) -> tuple[dict[str, Any], list[np.ndarray]]:
    """Return what the file holds, and the columns asked for."""
    with h5py.File(file, "r") as opened:
        found: dict[str, Read] = {}
        units: dict[str, str] = {}
        odd: dict[str, str] = {}
        for path, data in _datasets(opened):
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
    """All datasets by path, those that MATLAB hides left out."""
    found: list[tuple[str, Any]] = []

    def look(path: str, one: Any) -> None:
        if isinstance(one, h5py.Dataset) and not path.startswith("#"):
            found.append((path, one))

    opened.visititems(look)
    return found


def _columns(path: str, data: Any) -> dict[str, Read]:
    """The columns of a dataset, each with what reads it."""
    matlab = data.attrs.get("MATLAB_class", b"")
    matlab = matlab.decode() if isinstance(matlab, bytes) else str(matlab)
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
