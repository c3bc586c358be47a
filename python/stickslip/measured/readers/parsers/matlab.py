"""MATLAB files of version 4 to 7.2: vectors, columns of matrices, fields of structs and cells."""

from __future__ import annotations

from typing import Any

import numpy as np
from scipy.io import loadmat, whosmat
from scipy.io.matlab import MatlabFunction, MatlabOpaque

LOADED = ("struct", "cell", "char")  # classes of variables that hold others, or words
LONGEST = 200  # characters of a word that may be the title of a column
DEEPEST = 16  # structs in structs
WIDEST = 256  # columns of a matrix that are offered each


def answer(file: str, names: list[str]) -> tuple[dict[str, Any], list[np.ndarray]]:
    """Return what the file holds, and the columns asked for where each is there once.

    Parts are called as in MATLAB: `run.t` a field, `run(2).t` one of several structs, `data{1}` a cell, `data(:,1)` a
    column.
    """
    try:
        listed = whosmat(file)
    except NotImplementedError:
        return {"known": [], "fault": "a MATLAB 7.3 file; save it with -v7", "column": None}, []
    inside = {name for name, _, kind in listed if kind in LOADED}  # their parts are known by loading alone
    asked = {*names, *(name.partition("(:,")[0] for name in names)}
    load = inside | {name for name, _, _ in listed if name in asked}
    loaded = loadmat(file, variable_names=sorted(load)) if load else {}
    known: list[str] = []
    held: dict[str, np.ndarray] = {}
    words: dict[str, str] = {}
    for name, shape, kind in listed:
        found = _parts(name, loaded[name]) if name in load else {}
        said = {key: one for key, one in found.items() if one.dtype.kind == "U"}
        words |= {key: one for k, v in said.items() for key, one in _words(k, v).items()}
        found = {
            key: one for key, one in found.items() if key not in said or (kind == "char" and key in names)
        }
        known += found if name in load else _columns(name, shape)
        held |= found
    also = _also(known)
    own = [name if name in known else also.get(name, name) for name in names]
    head = {"known": known, "also": also, "words": words}
    if any(known.count(name) != 1 for name in own):
        return head, []
    for name in own:
        array = held[name]
        if array.dtype.kind not in "iufb" or not array.size or max(array.shape) != array.size:
            fault = f"a {array.dtype.name} array of shape {array.shape}; a channel is a real vector"
            return {**head, "fault": fault, "column": name}, []
    return head, [held[name] for name in own]


def _parts(name: str, value: Any, depth: int = 0) -> dict[str, np.ndarray]:
    """The arrays in a variable, words too, by the names that MATLAB has for them."""
    array = np.asarray(value)
    inner: dict[str, Any] = {}
    if isinstance(value, MatlabOpaque | MatlabFunction) or depth > DEEPEST:
        return {}
    if array.dtype.names is not None:
        for k, one in enumerate(array.ravel(order="F"), 1):
            of = name if array.size == 1 else f"{name}({k})"
            inner |= {f"{of}.{field}": one[field] for field in array.dtype.names}
    elif array.dtype == object and array.ndim:
        inner = {f"{name}{{{k}}}": one for k, one in enumerate(array.ravel(order="F"), 1)}
    elif array.dtype.kind == "U":
        return {name: array}
    elif depth and array.dtype.kind not in "iufbc":
        return {}
    else:
        columns = _columns(name, array.shape)
        return {name: array} if columns == [name] else dict(zip(columns, array.T, strict=True))
    return {key: one for k, v in inner.items() for key, one in _parts(k, v, depth + 1).items()}


def _words(name: str, array: np.ndarray) -> dict[str, str]:
    """A word, or the rows of a char matrix, as a cell of words has them."""
    told = [str(one).strip()[:LONGEST] for one in array.ravel()]
    return {name: told[0]} if len(told) == 1 else {f"{name}{{{k}}}": one for k, one in enumerate(told, 1)}


def _columns(name: str, shape: tuple[int, ...]) -> list[str]:
    """The names of the columns of a matrix; that of a vector is its own."""
    if len(shape) != 2 or min(shape) < 2 or shape[1] > WIDEST:
        return [name]
    return [f"{name}(:,{j})" for j in range(1, shape[1] + 1)]


def _also(known: list[str]) -> dict[str, str]:
    """Fields by their last name where only one has it."""
    bare = [name.rpartition(".")[2] for name in known]
    return {
        last: name for last, name in zip(bare, known, strict=True) if bare.count(last) == 1 and last != name
    }
