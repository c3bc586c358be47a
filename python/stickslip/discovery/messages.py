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
        With the channel whose size is least like such a rig's, and what may be wrong with it.
    """
    off, spread, noise = np.zeros(2), np.zeros(2), np.zeros(2)
    for w, b in zip(null.fit.windows, null.fit.blocks, strict=True):
        run = data[w.run]
        r = b.r.reshape(-1, len(run.channels))[:, :2] * run.noise[:2]
        x = run.readings[w.start : w.stop, :2]
        off += np.sum(r**2, axis=0)
        spread += np.sum((x - x.mean(axis=0)) ** 2, axis=0)
        noise += len(r) * run.noise[:2] ** 2
    if not np.any((off > ABSURD**2 * spread) & (off > 100 * noise)):
        return
    model = null.hypothesis.model
    typical = model.friction.static_limits[0] / model.parameters["alpha1"]
    size = np.array([np.std(np.concatenate([run.readings[:, c] for run in data])) for c in range(2)])
    suspect = int(np.argmax(np.abs(np.log(np.maximum(size, 1e-300) / typical))))
    share = 100 * float(np.max(np.sqrt(off / spread)))
    raise InputError(
        f"the declared model leaves {share:.0f} % of the readings unexplained even over single cycles, more than any "
        f"effect does; channel {('x1', 'y1')[suspect]} spreads by {size[suspect]:.3g} in model units where such a rig "
        f"moves by about {typical:.2g}: check its unit and column, and the rig's numbers"
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
