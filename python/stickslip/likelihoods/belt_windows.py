"""Windows of a rig on a belt linearised, each with friction and a belt speed of its own.

They are what `stickslip.likelihoods.belt_layout` lays out; at one point `stickslip.likelihoods.belt_point` has them.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from stickslip.likelihoods.belt_layout import BeltLayout
from stickslip.likelihoods.belt_point import BeltPoint
from stickslip.likelihoods.motion import WindowMotion

Floats = NDArray[np.float64]


class BeltWindows(BeltLayout):
    """See `BeltLayout`."""

    def blocks(
        self,
        at: Floats,
        own: Floats,
        select: NDArray[np.bool_] | None = None,
        shared: Sequence[int] | None = None,
        local: bool = True,
    ) -> list[Floats | None]:
        """See `EventWindows.blocks`."""
        return self._blocks(at, own, select, range(len(self.numbers)) if shared is None else shared, local)

    def columns(self, at: Floats, own: Floats, shared: Sequence[int]) -> list[Floats | None]:
        """See `EventWindows.columns`."""
        # a gain scales what its sensor reads, the window's own belt with it
        whole = any(self.numbers[j].name in self.sensors.gains for j in shared)
        made = self._blocks(at, own, None, shared, local=False, whole=whole)
        return [None if one is None else one[:, :, :-1] for one in made]

    def _blocks(
        self,
        at: Floats,
        own: Floats,
        select: NDArray[np.bool_] | None,
        shared: Sequence[int],
        local: bool,
        whole: bool = True,
    ) -> list[Floats | None]:
        out: list[Floats | None] = [None] * len(self.stretches)
        for members in self.batches:
            chosen = members if select is None else members[select[members]]
            if len(chosen):
                with np.errstate(over="ignore", invalid="ignore"):  # such a window has failed
                    made = BeltPoint(self, chosen, at, own[chosen], tuple(shared), local, whole).blocks()
                for i, block in zip(chosen, made, strict=True):
                    out[i] = block
        return out

    def motions(self, at: Floats, own: Floats) -> list[WindowMotion | None]:
        """See `EventWindows.motions`."""
        out: list[WindowMotion | None] = [None] * len(self.stretches)
        for members in self.batches:
            with np.errstate(over="ignore", invalid="ignore"):
                made = BeltPoint(self, members, at, own[members], (), False).motions()
            for i, one in zip(members, made, strict=True):
                out[i] = one
        return out
