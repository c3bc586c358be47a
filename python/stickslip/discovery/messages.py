"""Sentences a person should read beside the verdict, and the input that no verdict is possible on."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from stickslip.discovery.data import Data
from stickslip.discovery.result import FoundEffect, Residual
from stickslip.discovery.trace import Trial
from stickslip.errors import InputError

ABSURD = 0.5  # of a reading's own spread left over in windows of one cycle: the declared rig is not this one


def absurd(null: Trial, data: Sequence[Data]) -> None:
    """Refuse a case whose declared model explains next to nothing even in windows of one cycle.

    Raises
    ------
    InputError
        With the channel that is worst, and what may be wrong with it.
    """
    for c, channel in enumerate(("x1", "y1")):
        off, spread, count = 0.0, 0.0, 0
        for w, b in zip(null.fit.windows, null.fit.blocks, strict=True):
            run = data[w.run]
            r = b.r.reshape(-1, len(run.channels))[:, c] * run.noise[c]
            x = run.readings[w.start : w.stop, c]
            off += float(r @ r)
            spread += float(np.sum((x - x.mean()) ** 2))
            count += len(r)
        if off > ABSURD**2 * spread and off > 100 * count * data[0].noise[c] ** 2:
            share = (off / spread) ** 0.5
            raise InputError(
                f"the declared model leaves {100 * share:.0f} % of channel {channel} unexplained even over single "
                "cycles, more than any effect does: check the channels' units and columns and the rig's numbers"
            )


def remarks(
    data: Sequence[Data], null: Trial, effects: Sequence[FoundEffect], after: Residual
) -> tuple[str, ...]:
    """What to know about this case's data and verdict."""
    out = []
    speeds = {round(run.belt_speed, 12) for run in data}
    if len(data) == 1:
        out.append("one train run only: rivals that differ in their dependence on speed are not told apart")
    elif len(speeds) == 1:
        out.append("all train runs have one belt speed: ties are wide; add slower, faster and reversed runs")
    elif len({np.sign(s) for s in speeds}) == 1:
        out.append("no train run reverses the belt: what depends on direction is not seen")
    if _one_way(null):
        out.append(
            "every run slips one way only: a constant load on the block is absorbed whole by the friction law "
            "(T_s and T_min of that direction shift by it), so that none is claimed or excluded"
        )
    if any(one.name == "block_viscous_damping" for one in effects):
        out.append(
            "a gain error e of y1 is, by algebra, block damping of c1 e/(1 + e): a damping of that size names no "
            "cause without a calibration of y1"
        )
    for one in effects:
        tied = [a.name for a in one.alternatives if a.tied]
        if tied:
            out.append(f"these runs do not tell {one.name} from {', '.join(tied)}")
    if not after.clean:
        out.append(f"something is left over: {after.sentence}")
    return tuple(out)


def _one_way(null: Trial) -> bool:
    """Does each run slip in one direction only?"""
    seen: dict[int, set[int]] = {}
    for w, b in zip(null.fit.windows, null.fit.blocks, strict=True):
        modes, counts = np.unique(b.mode, return_counts=True)
        seen.setdefault(w.run, set()).update(
            int(m) for m, n in zip(modes, counts, strict=True) if m and n > 3
        )
    return all(len(signs) <= 1 for signs in seen.values())
