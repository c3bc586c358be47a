"""What MATLAB calls the columns of a matrix and the vectors in a cell: words beside them, since they have no names."""

from __future__ import annotations

import re
from collections import defaultdict
from collections.abc import Mapping, Sequence

PLACE = re.compile(r"(.+?)(\(:,|\[:,|\{)(\d+)[)\]}]")  # a column of a matrix, or a part of a cell


def titles_of(known: Sequence[str], words: Mapping[str, str]) -> dict[str, str]:
    """Return the words that stand for columns, by the column's name.

    A matrix of k columns takes them from the one list of k words beside it, as `importdata` leaves `colheaders`. In
    a cell of words and vectors a word is above its vector, or before it.

    Parameters
    ----------
    known
        Names of the columns, in their order.
    words
        Texts in the file by name, those of a cell as "names{1}".
    """
    parts: dict[str, dict[int, str]] = defaultdict(dict)  # of cells, by place: their names
    matrices: dict[str, list[str]] = defaultdict(list)
    for name in dict.fromkeys((*known, *words)):
        if place := PLACE.fullmatch(name):
            if place[2] == "{":
                parts[place[1]][int(place[3])] = name
            else:
                matrices[place[1]].append(name)
    lists = {}
    found: dict[str, str] = {}
    for cell, places in parts.items():
        names = [places[k] for k in sorted(places)]
        if all(name in words for name in names):
            lists[cell] = [words[name] for name in names]
        elif len(names) == max(places):
            found |= _within(names, words)
    for matrix, names in matrices.items():
        beside = [
            one for cell, one in lists.items() if _holder(cell) == _holder(matrix) and len(one) == len(names)
        ]
        if len(beside) == 1 and _tell_apart(beside[0]):
            found |= dict(zip(names, beside[0], strict=True))
    return found


def unnamed(known: Sequence[str], titles: Mapping[str, str]) -> dict[str, tuple[str, ...]]:
    """Return the columns that have neither name nor title, in their order, by what holds them."""
    found: dict[str, tuple[str, ...]] = {}
    for name in known:
        if (place := PLACE.fullmatch(name)) and name not in titles:
            for of in {place[1], place[1].replace("/", ".")}:  # HDF5 files are asked by dots as well
                found[of] = (*found.get(of, ()), name)
    return found


def _within(names: Sequence[str], words: Mapping[str, str]) -> dict[str, str]:
    """The words of a cell that is half words and half vectors, MATLAB's order being down the columns."""
    half = len(names) // 2
    for titled, columns in ((names[::2], names[1::2]), (names[:half], names[half:])):
        told = [words.get(name, "") for name in titled]
        if len(columns) == len(told) and _tell_apart(told) and not any(name in words for name in columns):
            return dict(zip(columns, told, strict=True))
    return {}


def _tell_apart(told: Sequence[str]) -> bool:
    return all(told) and len(set(told)) == len(told)


def _holder(name: str) -> str:
    """The struct that holds a variable; "" where none does."""
    return name.replace("/", ".").rpartition(".")[0]
