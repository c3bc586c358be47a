"""What the loop returns for a rig of bodies or matrices: as for any rig, and the readings to draw."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, fields

import numpy as np
from numpy.typing import NDArray

from stickslip.discovery.plain import Json, plain
from stickslip.discovery.result import Found

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class RigView:
    """One run as read and as the two models have it, SI; (n,) arrays by channel, NaN where a model says nothing.

    Of a run that was fitted `before` and `after` are the fits, of one that was not what each model forecasts one
    window ahead.
    """

    name: str
    role: str
    t: Floats
    measured: Mapping[str, Floats]
    noise: Mapping[str, float]
    before: Mapping[str, Floats]
    after: Mapping[str, Floats]


@dataclass(frozen=True, eq=False, repr=False)
class GeneralFound(Found):
    """What `stickslip.discover` returns for a rig of bodies or matrices: `views` are the runs to draw."""

    views: tuple[RigView, ...]

    @property
    def report(self) -> dict[str, Json]:
        """report.json as plain Python."""
        skipped = {"before", "after", "runs", "spectrum", "constants", "views", "unclaimed", "case"}
        return {f.name: plain(getattr(self, f.name)) for f in fields(self) if f.name not in skipped}
