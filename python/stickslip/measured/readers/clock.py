"""Times as instruments print them: clock times and ISO dates, turned into seconds since the first."""

from __future__ import annotations

import re
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

CLOCK = re.compile(r"(\d{1,3}):(\d\d):(\d\d(?:[.,]\d*)?)$")
DATE = re.compile(r"(\d{4})[-/](\d\d?)[-/](\d\d?)$")
ZONE = re.compile(r"(?:Z|[+-]\d\d:?\d\d)$")


def is_time(cell: str) -> bool:
    """Say whether a cell is a clock time, or an ISO date with or without one."""
    return _split(cell) is not None


def seconds(cells: Sequence[str]) -> tuple[Floats | None, int]:
    """Return the times (n,) in seconds since the first; or None, and the first cell that is no such time.

    A clock without a date that passes midnight is not mended: its times do not increase, and are refused as such.
    """
    out = np.empty(len(cells))
    first: tuple[np.datetime64, float] | None = None
    for i, cell in enumerate(cells):
        if (found := _split(cell)) is None:
            return None, i
        day, since = found
        if first is None:
            first = found
        out[i] = (day - first[0]).astype("timedelta64[s]").astype(float) + (since - first[1])
    return out, -1


def _split(cell: str) -> tuple[np.datetime64, float] | None:
    """The day and the seconds since its beginning, in universal time where the cell says its zone."""
    date, joint, clock = cell.strip().replace("T", " ").partition(" ")
    if not joint and DATE.match(date) is None:
        date, clock = "", date
    day = _day(date) if date else np.datetime64("1970-01-01")
    if day is None or not (date or clock):
        return None
    zone = ZONE.search(clock) if date else None
    offset = 0.0
    if zone is not None:
        clock = clock[: zone.start()].rstrip()
        offset = _offset(zone[0])
    if not clock:
        return (day, 0.0) if zone is None else None
    found = CLOCK.match(clock)
    if found is None or int(found[2]) > 59 or float(found[3].replace(",", ".")) >= 61:
        return None
    return day, 3600.0 * int(found[1]) + 60.0 * int(found[2]) + float(found[3].replace(",", ".")) - offset


def _day(date: str) -> np.datetime64 | None:
    found = DATE.match(date)
    if found is None:
        return None
    try:
        return np.datetime64(f"{found[1]}-{int(found[2]):02}-{int(found[3]):02}")
    except ValueError:
        return None


def _offset(zone: str) -> float:
    if zone == "Z":
        return 0.0
    digits = zone[1:].replace(":", "")
    return (-1 if zone[0] == "-" else 1) * (3600.0 * int(digits[:2]) + 60.0 * int(digits[2:]))
