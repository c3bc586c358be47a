"""Sentences a person should read beside the verdict, and the input that no verdict is possible on."""

from __future__ import annotations

from collections.abc import Collection, Sequence

import numpy as np

from stickslip.declared.rig import AnyRig, Rig
from stickslip.discovery.laboratory.belt_bench import BeltBench
from stickslip.discovery.laboratory.left import Left
from stickslip.discovery.residual import describe
from stickslip.discovery.result import ErrorBlock, Found, FoundEffect
from stickslip.errors import InputError
from stickslip.fitted.data import Data
from stickslip.fitted.plausible import body_ratio

LARGEST_GAIN = 0.2  # error of a sensor's gain that a laboratory might not notice
UNSURE = 5.0  # sampling errors below 1 of a chi-squared that says an estimated noise was too large
LOOSE = 0.93  # and the chi-squared below which it is said
FAR = 2.0  # error after over its floor, the same
FEW = 3  # samples of a slip that noise makes
ABSURD = 0.5  # of a reading's own spread left over in windows of one cycle: the declared rig is not this one


def absurd(fit: Left, rig: AnyRig) -> None:
    """
    Refuse a case of which a model explains next to nothing even in windows of one cycle.

    A strong effect defeats the declared law alone in this way, so that it is asked of the best that was found.

    Raises
    ------
    InputError
        With what may be wrong with it.
    """
    data = fit.engine.data
    off, spread, noise = np.zeros(2), np.zeros(2), np.zeros(2)
    for w, b in zip(fit.windows, fit.blocks, strict=True):
        run = data[w.run]
        r = b.r.reshape(-1, len(run.channels))[:, :2] * run.noise[:2]
        x = run.readings[w.start : w.stop, :2]
        off += np.sum(r**2, axis=0)
        spread += np.sum((x - x.mean(axis=0)) ** 2, axis=0)
        noise += len(r) * run.noise[:2] ** 2
    if not np.any((off > ABSURD**2 * spread) & (off > 100 * noise)):
        return
    assert isinstance(rig, Rig)
    share = 100 * float(np.max(np.sqrt(off / spread)))
    raise InputError(
        f"the declared model leaves {share:.0f} % of the readings unexplained even over single cycles, more than any "
        f"effect does; {_where(data, rig)}"
    )


def _where(data: Sequence[Data], rig: Rig) -> str:
    """Which part of a declared rig to doubt."""
    if body_ratio(data, rig).right:
        return (
            "x1, y1 and t agree with each other by the angle body's equation in (2.1): check alpha1 (m, k1, k2), the "
            "coupling, [friction] and belt_speed"
        )
    return (
        "x1 and y1 do not meet the angle body's equation in (2.1), which friction does not enter: check their columns "
        "and units, that of t, and alpha2, beta3, eta12 (J, r, k2, k3, c1, c2)"
    )


def remarks(
    bench: BeltBench,
    effects: Sequence[FoundEffect],
    left: Left,
    error: ErrorBlock,
    validate: Sequence[Data],
    declared: Collection[str],
) -> tuple[str, ...]:
    """
    Return what to know about a case's data and verdict.

    Parameters
    ----------
    bench, validate : the train runs and the others
    effects, left, error : what was found, what it leaves, and what it is worth on runs never fitted
    declared : the channels whose noise the case gives
    """
    out, data, rig, after = list[str](), bench.data, bench.model.rig, describe(left)
    speeds = {round(run.belt_speed, 12) for run in data}
    if len(data) == 1:
        out.append("one train run only: rivals that differ in their dependence on speed are not told apart")
    elif len(speeds) == 1:
        out.append("all train runs have one belt speed: ties are wide; add slower, faster and reversed runs")
    elif bench.one_way:
        out.append("no train run reverses the belt: what depends on direction is not seen")
    if _one_way(left):
        out.append(
            "no train run slips both ways: a constant load on the block is absorbed whole by the friction law (the "
            "levels of each direction that was seen shift by it), so that none is claimed or excluded"
        )
    elif not any(one.name == "constant_load" for one in effects):
        out.append(
            "a constant load on the block is absorbed whole by the friction law (its levels shift by it, up in one "
            "direction and down in the other), so that none is claimed or excluded"
        )
    out += [_gain(rig, one) for one in effects if abs(_gain_like(rig, one)) < LARGEST_GAIN]
    for one in effects:
        tied = [a.name for a in one.alternatives if a.tied]
        if tied:
            out.append(f"these runs do not tell {one.name} from {', '.join(tied)}")
    if after.chi2 < min(1 - UNSURE * after.error, LOOSE) and not {"x1", "y1"} <= set(declared):
        out.append(
            f"the noise was estimated from the readings, and too large: chi-squared per reading is {after.chi2:.3g} "
            "where noise alone leaves 1; what is as small does not show: declare [noise] if it is known"
        )
    if not after.clean:
        out.append(f"something is left over: {after.sentence}")
    out += [
        f"{run.name} lasts {run.t[-1] / run.cycle:.2g} cycles only: its second half is forecast from its first"
        for run in validate
        if run.t[-1] < 2 * run.cycle
    ]
    if after.clean and error.after > FAR * error.floor:
        out.append(
            f"nothing is left over on the train runs, yet the runs never fitted are forecast with an error of "
            f"{error.after:.3g} where noise and scatter leave {error.floor:.3g}: the train runs do not tell all "
            "that these need (another speed or direction?), or these show something new; train on runs like them too"
        )
    return tuple(out)


def unseen(found: Found) -> tuple[str, ...]:
    """What to know of a law where the block never slips, or never sticks."""
    loose = sum(one.low is None or one.high is None for one in found.law.values())
    if not found.never or not loose:
        return ()
    runs = (
        "longer or faster runs, until it slips" if found.never == "slips" else "slower runs, until it sticks"
    )
    return (
        f"the block never {found.never} in these runs: {loose} of {len(found.law)} numbers of the friction law are not "
        f"identified; add {runs}",
    )


def _gain_like(rig: AnyRig, one: FoundEffect) -> float:
    """The gain error e of y1 that block damping c = eta1 e/(1 + e) is like; infinite of anything else."""
    c = one.parameters["c"].value if one.name == "block_viscous_damping" else None
    if c is None or not isinstance(rig, Rig) or c == rig.eta1:
        return np.inf
    return float(c / (rig.eta1 - c))


def _gain(rig: AnyRig, one: FoundEffect) -> str:
    """The tie in words: with y scaled, all of (2.1) but c1 x1' is met by other J, k2, k3, c1 and c2."""
    percent = 100 * _gain_like(rig, one)
    return (
        f"if J, k2, k3, c1 and c2 were measured with this y1 sensor, a gain error of {percent:.2g} % in it is, by "
        "algebra, this very damping of the block: only a calibration of y1 tells them apart"
    )


def _one_way(left: Left) -> bool:
    """Does each run slip in one direction only?"""
    seen: dict[int, set[int]] = {}
    for w, b in zip(left.windows, left.blocks, strict=True):
        modes, counts = np.unique(b.mode, return_counts=True)
        signs = {int(m) for m, n in zip(modes, counts, strict=True) if m and n > FEW}
        seen.setdefault(w.run, set()).update(signs)
    return all(len(signs) <= 1 for signs in seen.values())
