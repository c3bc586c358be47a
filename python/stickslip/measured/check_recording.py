"""What the columns of a run must be: times that increase, samples enough, a belt that moves."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from stickslip.declared.units import Channel
from stickslip.errors import InputError, Place, number
from stickslip.measured.readers.tables import Columns

Floats = NDArray[np.float64]

LONGEST = 1e8  # usual steps that a gap may last: fits take a number for each of them
FEWEST = 8  # samples below which no derivative, let alone a law, can be had


def check_times(columns: Columns, channels: Mapping[str, Channel], raw: Mapping[str, Floats]) -> None:
    """Refuse a run of too few samples, or whose times do not increase."""
    t, name = raw["t"], channels["t"].column
    if t.size < FEWEST:
        count = "1 sample" if t.size == 1 else f"{t.size} samples"
        raise InputError(f"{count}; a run needs at least {FEWEST}", place=Place(str(columns.path)))
    turn = columns.turns.get(name, (-1, -1))[0 if channels["t"].scale > 0 else 1]
    if columns.averaged > 1 and turn >= 0:
        place = columns.place(name, turn)
        raise InputError("not after the time before it; times must increase", place=place)
    later, sooner = (t[1:], t[:-1]) if channels["t"].scale > 0 else (t[:-1], t[1:])
    wrong = np.flatnonzero(later <= sooner)
    if not wrong.size:
        return
    at = int(wrong[0]) + 1
    place = columns.place(name, at)
    for other, column in raw.items():
        if wrong.size > 0.05 * t.size and other != "t" and (np.diff(column) > 0).all():
            swapped = channels[other].column
            words = f"does not increase, but column '{swapped}' does; are the two swapped?"
            raise InputError(words, place=place)
    what = f"{t[at]:g} twice in a row" if t[at] == t[at - 1] else f"{t[at]:g} after {t[at - 1]:g}"
    more = "" if wrong.size == 1 else f" ({wrong.size} such places)"
    raise InputError(f"{what}{more}; times must increase", place=place)


def check_gaps(columns: Columns, channels: Mapping[str, Channel], raw: Mapping[str, Floats]) -> None:
    """Refuse a gap so long that a time must be damaged, or the run two: in what the window left of it."""
    t, name = raw["t"], channels["t"].column
    with np.errstate(over="ignore"):
        steps = np.abs(np.diff(t))
    at = int(np.argmax(steps))
    if steps[at] > LONGEST * np.median(steps[:: max(1, steps.size // 100_000)]):
        words = f"{t[at + 1]:g} after {t[at]:g}: a gap of {LONGEST:.0e} steps or more"
        row = int(np.flatnonzero(columns.values[name] == t[at + 1])[0])
        raise InputError(f"{words}; is the time damaged? cut the run there", place=columns.place(name, row))


def cut(
    columns: Columns,
    channels: Mapping[str, Channel],
    raw: Mapping[str, Floats],
    window: tuple[float | None, float | None],
) -> dict[str, Floats]:
    """Keep the samples within the window, in the unit of t."""
    given: object = window
    if not isinstance(given, Sequence | np.ndarray) or len(given) != 2:
        raise InputError("must be two times, (start, end), None for an open one", key="window", value=window)
    start, end = (None if one is None else number("window", one) for one in window)
    if start is None and end is None:
        return dict(raw)
    t = raw["t"] * channels["t"].scale
    kept = (t >= (-np.inf if start is None else start)) & (t < (np.inf if end is None else end))
    if np.count_nonzero(kept) < FEWEST:
        said = f"{'its start' if start is None else start} to {'its end' if end is None else end}"
        words = f"{np.count_nonzero(kept)} samples from {said}; the run lasts from {t[0]:g} to {t[-1]:g}"
        raise InputError(words, place=Place(str(columns.path), column=channels["t"].column))
    return {name: column[kept] for name, column in raw.items()}


def check_belt(
    columns: Columns, channels: Mapping[str, Channel], raw: Mapping[str, Floats], set_point: float
) -> None:
    """Refuse a recorded belt that never moves though its set-point is not 0."""
    if "belt" not in raw or set_point == 0 or np.any(raw["belt"] != 0):
        return
    words = (
        "the belt never moves (0 throughout) but its set-point is not 0; leave the channel out if it is dead"
    )
    raise InputError(words, place=Place(str(columns.path), column=channels["belt"].column))
