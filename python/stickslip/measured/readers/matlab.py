"""The outline of MATLAB files (version 4 to 7.2): what is no such file, or is cut, starts no parser."""

from __future__ import annotations

import struct
from pathlib import Path

_HEADER = 128  # bytes of words and a version, before the variables of version 5 and later
_ELEMENTS = (14, 15)  # a variable, plain or compressed
_NUMBERS = (8, 4, 4, 2, 2, 1)  # bytes of a number of version 4, by the type of its header


def fault(file: Path) -> str | None:
    """What is wrong with a file as far as its headers and lengths show; None if it may be sound."""
    try:
        with file.open("rb") as stream:
            head, size = stream.read(_HEADER), file.stat().st_size
            if head.startswith(b"\x89HDF") or head[:19] == b"MATLAB 7.3 MAT-file":
                return "a MATLAB 7.3 file; save it with -v7"
            if size < 20:
                return f"not a MATLAB file: it has {size} bytes"
            if 0 in head[:4]:  # words begin later versions
                return _first_of_version_4(head, size)
            if size < _HEADER or head[126:128] not in (b"IM", b"MI"):
                return "not a MATLAB file, or a damaged one: no mark of its byte order"
            order = "<" if head[126:128] == b"IM" else ">"
            at = _HEADER
            while at < size:
                stream.seek(at)
                tag = stream.read(8)
                kind, length = struct.unpack(f"{order}II", tag) if len(tag) == 8 else (0, 0)
                if kind not in _ELEMENTS or at + 8 + length > size:
                    return f"a damaged MATLAB file: no whole variable begins at byte {at}; save it again"
                at += 8 + length
    except OSError as error:
        return f"cannot be read ({error.strerror})"
    return None


def _first_of_version_4(head: bytes, size: int) -> str | None:
    """What is wrong with the first variable of a version 4 file, by its header."""
    for order in "<>":
        kind, rows, columns, imaginary, name = struct.unpack(f"{order}5i", head[:20])
        number = kind // 10 % 10
        if not (0 <= kind < 5000 and number < len(_NUMBERS) and rows >= 0 and columns >= 0 and name > 0):
            continue
        data = rows * columns * _NUMBERS[number] * (2 if imaginary else 1)
        if imaginary in (0, 1) and (kind % 10 == 2 or 20 + name + data <= size):  # a sparse one is shorter
            return None
    return "not a MATLAB file, or a damaged one: its first variable does not fit into it"
