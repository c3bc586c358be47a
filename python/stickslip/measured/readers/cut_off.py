"""Was a table in text cut off? By its last line, and by a number of samples that its first lines tell of.

A file whose last line has no line end may have lost the end of its last number. It is whole where it is written as all
those above it; it is cut where it has fewer decimals than they have; else nobody can know, and it is said.
"""

from __future__ import annotations

import os
import re
from collections.abc import Sequence

from stickslip.errors import InputError, Place, quoted
from stickslip.measured.readers.dialect import Layout, bare, cells_of, opened, rows_from

TAIL = 1 << 16  # bytes at the end that are looked at
ALIKE = 20  # rows that must be written alike before a last one that is shorter is refused
_END = re.compile(r"\r\n|\r|\n")
_NUMBER = re.compile(r"[+-]?\d*(?:[.,](\d*))?([eE][+-]?\d*)?")
# a name and a whole number
_PAIR = re.compile(r"\W*(.+?)[\s\"':=;,]+(\d+)\W*(?:points|samples)?\W*", re.IGNORECASE)
_MANY, _WHAT = ("number of", "no. of", "no of"), ("samples", "points", "rows", "scans")
COUNTS = {  # the names under which instruments write how many samples there are
    *_WHAT, *(f"{many} {what}" for many in _MANY for what in _WHAT),
    "record length", "recordlength", "sample count", "samplecount", "n_samples",
    "number of values", "number of records",
    "anzahl messwerte", "anzahl der messwerte", "anzahl werte", "messwerte",
}  # fmt: skip


def unended(layout: Layout) -> bool:
    """Say whether the last line of a file has no line end."""
    return _is_unended(_tail(layout))


def last_number(layout: Layout, names: Sequence[str]) -> tuple[str, ...]:
    """Look at the last number of a file, if it is one of the named columns and no line end follows it.

    Returns
    -------
    tuple of str
        What is said where it may be cut short; empty where it is whole.

    Raises
    ------
    InputError
        It is cut short: it has fewer decimals than all above it.
    """
    if not _is_unended(tail := _tail(layout)):
        return ()
    *above, last = _END.split(tail)
    cells = cells_of(text, layout.delimiter) if (text := bare(last, layout.delimiter)) else []
    if not cells or not cells[-1] or last[-1] in '" \t' or len(cells) > len(layout.header):
        return ()  # something that follows the number shows its end
    at, cell = len(cells) - 1, cells[-1]
    if layout.header[at] not in names:
        return ()
    texts = [bare(line, layout.delimiter) for line in above]
    rows = [cells_of(one, layout.delimiter) for one in texts if one]
    others = [row[at] for row in rows if at < len(row) and row[at]]
    forms = {_form(one) for one in others}
    if forms == {_form(cell)}:
        return ()
    if len(others) >= ALIKE and len(forms) == 1 and _is_shorter(cell, others[0]):
        words = f"'{quoted(cell, 30)}' ends the file, with fewer digits than the rows above and no line end: cut off?"
        with opened(layout.path, layout.encoding, layout.mark) as stream:
            line = sum(1 for _ in stream)
        place = Place(str(layout.path), line, column=layout.header[at])
        raise InputError(f"{words} delete the line", place=place)
    return (f"the last line has no line end; its last number, {quoted(cell, 30)}, may be cut short",)


def told_count(layout: Layout, count: int) -> tuple[str, ...]:
    """Say where the lines above the names tell of more samples than there are."""
    with opened(layout.path, layout.encoding, layout.mark) as stream:
        lines = [line for _, line in zip(range(layout.header_line - 1), stream, strict=False)]
    for i, line in enumerate(lines, 1):
        found = _PAIR.fullmatch(line.strip()[:200])
        if found and found[1].lower() in COUNTS and int(found[2]) > count:
            return (f"{count} samples where line {i} tells of {found[2]}; was the file cut off?",)
    return ()


def _is_unended(tail: str) -> bool:
    return bool(tail) and not tail.endswith(("\n", "\r"))


def _tail(layout: Layout) -> str:
    """The last rows of a file, as it is written."""
    width = {"utf-16": 2, "utf-32": 4}.get(layout.encoding[:6], 1)
    first, size = rows_from(layout), os.path.getsize(layout.path)
    begin = max(first, size - TAIL)
    begin += -(begin - layout.mark) % width
    with layout.path.open("rb") as stream:
        stream.seek(begin)
        text = stream.read().decode(layout.encoding, errors="ignore")
    return text if begin <= first else _END.split(text, maxsplit=1)[-1]  # it began somewhere in a line


def _form(cell: str) -> tuple[int, ...] | int:
    """How a number is written: decimals and digits of the exponent; of a whole number, or a time, how long it is."""
    found = _NUMBER.fullmatch(cell)
    if found is None or (found[1] is None and found[2] is None):
        return len(cell.lstrip("+-"))
    return -1 if found[1] is None else len(found[1]), len(found[2] or "")


def _is_shorter(cell: str, other: str) -> bool:
    """Whether a number lacks decimals, or its exponent, that another one has."""
    form, usual = _form(cell), _form(other)
    if isinstance(usual, int):
        return False  # whole numbers have as many digits as they need
    if isinstance(form, int):
        return True
    return form[0] < usual[0] or form[1] < usual[1]
