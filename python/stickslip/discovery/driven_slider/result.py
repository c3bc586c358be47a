"""What the loop returns for a driven slider: as for any rig, and the force balance to draw."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, fields

import numpy as np
from numpy.typing import NDArray

from stickslip.discovery.plain import Json, plain
from stickslip.discovery.result import Found

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class ForceView:
    """The force balance of one run within the band, SI; (n,) arrays.

    `force` is the drive; `friction` what it leaves beside the inertia, drive - mass x2'; `before` and `after` the
    residuals of the two models.
    """

    name: str
    role: str
    t: Floats
    x: Floats
    v: Floats
    force: Floats
    friction: Floats
    before: Floats
    after: Floats


@dataclass(frozen=True, eq=False, repr=False)
class DrivenFound(Found):
    """What `stickslip.discover` returns for a driven slider.

    `waves` is what a force periodic in position would explain: "wavelength" [m], "before", "after" (k,), chi-squared.
    `views` are the balances to draw, `noise` the standard deviation of the process noise [N] within the band up to
    `cutoff` [Hz]. The runs of other rigs are not there.
    """

    views: tuple[ForceView, ...]
    waves: Mapping[str, Floats]
    noise: float
    cutoff: float

    @property
    def report(self) -> dict[str, Json]:
        """report.json as plain Python."""
        skipped = {"before", "after", "runs", "spectrum", "constants", "views", "waves", "case"}
        return {f.name: plain(getattr(self, f.name)) for f in fields(self) if f.name not in skipped}
