"""The encoding of a text file: by its byte-order mark, or by what its bytes can be."""

from __future__ import annotations

import codecs
import re
from pathlib import Path

from stickslip.errors import InputError, Place

BLOCK = 1 << 20  # bytes looked at together
_CONTROL = re.compile(rb"[\0-\x08\x0e-\x19\x1b-\x1f]")  # characters that no text holds; 1a ended files of DOS
MARKS = (
    (codecs.BOM_UTF8, "utf-8"),
    (codecs.BOM_UTF32_LE, "utf-32-le"),
    (codecs.BOM_UTF32_BE, "utf-32-be"),
    (codecs.BOM_UTF16_LE, "utf-16-le"),
    (codecs.BOM_UTF16_BE, "utf-16-be"),
)


def encoding_of(file: Path) -> tuple[str, int]:
    """Return the encoding of a text file and the length of its byte-order mark in bytes.

    Text without a mark is UTF-8 if all of it is; UTF-16 if every other byte of its beginning is 0; Latin-1 otherwise,
    as older instruments write it.

    Raises
    ------
    InputError
        The file cannot be read, or is no text in the encoding that it begins in.
    """
    try:
        with file.open("rb") as stream:
            first = stream.read(BLOCK)
    except OSError as error:
        raise InputError(f"cannot be read ({error.strerror})", place=Place(str(file))) from None
    encoding, mark = next(((name, len(mark)) for mark, name in MARKS if first.startswith(mark)), ("", 0))
    encoding = encoding or _unmarked(first)
    if encoding == "utf-8" and _CONTROL.search(first):
        raise InputError("not text, and of no known format; save it as CSV in UTF-8", place=Place(str(file)))
    if _all_of(file, mark, encoding):
        return encoding, mark
    if mark or encoding != "utf-8":
        words = f"not the {encoding[:6].upper().rstrip('-')} text that it begins as; save it as CSV in UTF-8"
        raise InputError(words, place=Place(str(file)))
    return "latin-1", 0


def _unmarked(first: bytes) -> str:
    """UTF-16 shows as zeros in every other byte: those of digits, separators and line ends."""
    pairs = len(first) // 2
    if pairs and first[1 : 2 * pairs : 2].count(0) > 0.9 * pairs and first[0 : 2 * pairs : 2].count(0) == 0:
        return "utf-16-le"
    if pairs and first[0 : 2 * pairs : 2].count(0) > 0.9 * pairs and first[1 : 2 * pairs : 2].count(0) == 0:
        return "utf-16-be"
    return "utf-8"


def _all_of(file: Path, mark: int, encoding: str) -> bool:
    """Say whether the whole file decodes."""
    decoder = codecs.getincrementaldecoder(encoding)()
    with file.open("rb") as stream:
        stream.seek(mark)
        try:
            while block := stream.read(BLOCK):
                if encoding != "utf-8" or not block.isascii() or decoder.getstate()[0]:
                    decoder.decode(block)
            decoder.decode(b"", final=True)
        except UnicodeDecodeError:
            return False
    return True
