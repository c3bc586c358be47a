"""A number with its interval, open or not."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Interval:
    """A number with its 95 % interval; a limit is None where the readings set none."""

    value: float
    low: float | None
    high: float | None
