"""Every row of a table in text has a cell for each name: counted block by block, line by line where that says little.

A block of plain rows, all with as many separators, is counted by array operations. One with a quotation mark, a
comment, a blank line or rows of several lengths is looked at line by line.
"""

from __future__ import annotations

import codecs
from collections.abc import Iterator, Sequence
from itertools import islice

import numpy as np
from numpy.typing import NDArray

from stickslip.measured.readers.dialect import Layout, bare, cells_of, rows_from

BLOCK = 1 << 22  # bytes that are counted together: their arrays take ten times as much
_NEWLINE = 10
# what may be in a bare cell; a blank, a comment mark or a quotation mark may not, nor what is no ASCII
_OF_NUMBERS = bytes(set(range(0x80)) - set(b'\r\n "#%/'))
_SPACES = b" \t\x0b\x0c\x1c\x1d\x1e\x1f"  # what separates words in ASCII, the ends of lines left out


def count_rows(layout: Layout) -> tuple[int, int, bool]:
    """Return the number of rows, the first that has not a cell for each name, and whether all are of bare cells.

    -1 where all rows have their cells. Bare cells have neither comments beside them nor blanks around them.
    """
    rows, plain = 0, layout.delimiter != " " and not layout.last
    left = layout.last - layout.first + 1 if layout.last else None
    for block in _blocks(layout):
        if left is None and (count := _bare(block, layout)):
            rows += count
            continue
        text = block.replace(b"\r\n", b"\n").replace(b"\r", b"\n")
        if left is None and (count := _alike(text, layout)):
            rows, plain = rows + count, plain and b" " not in text
            continue
        plain = False
        lines = text.decode("utf-8").split("\n")[:-1]
        if left is not None:
            lines = list(islice(lines, left))
            left -= len(lines)
        got, wrong = _line_by_line(lines, layout)
        if wrong:
            return rows + got, rows + got, False
        rows += got
        if left == 0:
            break
    return rows, -1, plain


def fits(cells: Sequence[str], least: int, most: int) -> bool:
    """Whether a row has a cell for each name; a separator may end it."""
    return least <= len(cells) <= most or (len(cells) == most + 1 and not cells[-1])


def _blocks(layout: Layout) -> Iterator[bytes]:
    """The rows in UTF-8, in blocks of whole lines."""
    decoder = None if layout.encoding == "utf-8" else codecs.getincrementaldecoder(layout.encoding)()
    with layout.path.open("rb") as stream:
        stream.seek(rows_from(layout))
        rest = b""
        while read := stream.read(BLOCK):
            text = read if decoder is None else decoder.decode(read).encode()
            cut = text.rfind(b"\n") + 1 or text.rfind(b"\r", 0, -1) + 1  # a newline may follow the last \r
            if cut:
                yield b"".join((rest, memoryview(text)[:cut]))
                rest = b""
            rest += text[cut:]
        if rest.rstrip(b"\r"):
            yield rest.rstrip(b"\r") + b"\n"


def _bare(block: bytes, layout: Layout) -> int:
    """The number of rows of a block of bare cells, all of one width; 0 where there is anything else."""
    separator = layout.delimiter.encode()
    if separator == b" ":  # several are one
        return 0
    left = block.translate(None, _OF_NUMBERS.replace(separator, b""))
    first = left[: left.find(b"\n") + 1]
    width = len(first.rstrip(b"\r\n")) + 1
    if first not in (separator * (width - 1) + end for end in (b"\n", b"\r\n")):
        return 0
    most, least = len(layout.header), max(len(layout.header) - layout.spare, 2)
    rows = len(left) // len(first)
    return rows if least <= width <= most and left == first * rows else 0


def _alike(block: bytes, layout: Layout) -> int:
    """The number of rows of a block that plainly has all its cells; 0 where that is not plain."""
    most, least = len(layout.header), max(len(layout.header) - layout.spare, 2)
    if not block.isascii() or block[:1] in (b"%", b"/") or b'"' in block or b"#" in block:
        return 0
    if any(one in block and b"\n" + one in block for one in (b"%", b"/")):
        return 0
    if layout.delimiter == " ":
        cells = _words(np.frombuffer(block, dtype=np.uint8))
        return cells.size if cells.size and cells.min() >= least and cells.max() <= most else 0
    separator = layout.delimiter.encode()
    left = block.translate(None, bytes(set(range(256)) - {_NEWLINE, separator[0]}))
    width = left.index(b"\n") + 1  # cells of the first row
    rows = len(left) // width
    if left != (separator * (width - 1) + b"\n") * rows:
        return 0
    closed = width == most + 1 and block.count(separator + b"\n") == rows  # a separator ends each
    return rows if least <= width <= most or closed else 0


def _words(data: NDArray[np.uint8]) -> NDArray[np.intp]:
    """Words of each line, (n,)."""
    blank = np.zeros(256, dtype=bool)
    blank[list(_SPACES + b"\n")] = True
    apart = blank[data]
    begins = ~apart
    begins[1:] &= apart[:-1]
    return np.diff(np.searchsorted(np.flatnonzero(begins), np.flatnonzero(data == _NEWLINE)), prepend=0)


def _line_by_line(lines: Sequence[str], layout: Layout) -> tuple[int, bool]:
    """The number of rows, up to the first that has not its cells; and whether there is one."""
    most, delimiter = len(layout.header), layout.delimiter
    least, rows = most - layout.spare, 0
    for line in lines:
        if not line:
            continue
        count = len(line.split()) if delimiter == " " else line.count(delimiter) + 1
        if count == most and count > 1 and '"' not in line and "#" not in line and line[0] not in "%/":
            rows += 1
            continue
        if not (text := bare(line, delimiter)):
            continue
        if not fits(cells_of(text, delimiter), least, most):
            return rows, True
        rows += 1
    return rows, False
