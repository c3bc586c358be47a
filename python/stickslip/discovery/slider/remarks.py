"""Sentences a person should read beside the verdict on a block on a belt."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np

from stickslip.declared.scale import Scale, percent, plainly, scales
from stickslip.discovery.result import FoundEffect
from stickslip.discovery.slider.choose import Choice
from stickslip.discovery.slider.model import block_of
from stickslip.fitted.block_events.cycle import S
from stickslip.fitted.block_events.table import Measured
from stickslip.measured.case import Case

GRADUAL = 3.0  # standard errors


def remarks(
    case: Case, choice: Choice, train: Sequence[Measured], effects: Sequence[FoundEffect]
) -> tuple[str, ...]:
    """What to know about this case's data and verdict."""
    length = scales(case.rig, case.channels)["x1"]
    return (
        _noise(train, length),
        of_process(choice, train, length),
        *_gradual(choice),
        *of_waves(choice, effects),
        *_speeds(train),
        absorbed(one.run.sign for one in train),
        *_ties(effects),
    )


def absorbed(signs: Iterable[float]) -> str:
    """Say what becomes of a constant load, by the directions of the runs."""
    if len(set(signs)) == 1:
        return (
            "a constant load on the block is absorbed whole by the friction law: every run slips one way only"
        )
    return "a constant load on the block is not sought: it shifts friction's levels, up one way and down the other"


def _noise(train: Sequence[Measured], scale: Scale) -> str:
    one = train[0].run
    unit = f"; readings come in steps of {one.step / one.noise:.2g} of it" if one.step else ""
    share = float(np.mean([m.run.glitches for m in train]))
    return (
        f"noise of the deflection estimated as {scale.of(one.noise, 3)}{unit}; {percent(share)} of the readings are "
        "glitches of a single sample, left out"
    )


def of_process(choice: Choice, train: Sequence[Measured], scale: Scale) -> str:
    """Say by how much friction and what else is read of the events differs from event to event."""
    level = block_of(choice, "level")
    drop = np.concatenate([0.5 * (m.events.p[:, S] - m.events.arrest) for m in train])
    off = np.concatenate([m.events.p[:, S] - m.events.p[:, S].mean() for m in train if len(m.events)])
    (sigma, length, tau), scatter = level.wander, plainly(float(np.std(off) / np.mean(drop)))
    rate, frequency = _spread(choice, "rate"), 0.5 * _spread(choice, "frequency")
    told = [
        f"{who} scatter by {percent(size)}"
        for who, size in (("stick rates", rate), ("slip frequencies", frequency))
        if np.isfinite(size)  # no stick, or no slip, may be long enough to have one
    ]
    words = (
        f"{len(level)} events; breakaway scatters by {scatter} times the mean drop: it wanders by "
        f"{percent(sigma)} over {scale.of(length, 3)} of belt travel, {percent(tau)} from event to event"
    )
    return f"{words}; {', '.join(told)}" if told else words


def _spread(choice: Choice, name: str) -> float:
    block = block_of(choice, name)
    return float(np.median(block.spread)) if len(block) else float("nan")


def _gradual(choice: Choice) -> tuple[str, ...]:
    """A slip that starts slowly has a negative damping: said, never named."""
    block = block_of(choice, "damping")
    if not len(block):
        return ()
    w = 1 / (block.noise + block.spread**2)
    mean = float(w @ block.y / w.sum())
    groups = np.unique(block.group)
    std = float(np.sqrt(1 / w.sum() + block.shared**2 / len(groups)))
    if mean > -GRADUAL * std:
        return ()
    return (
        f"slips start slower and end faster than under constant sliding friction (damping {mean:.2f} +- {std:.2f}): "
        "friction falls over a distance or with speed after breakaway, or the surface is uneven at that scale; these "
        "runs do not tell which, so that none is named",
    )


def of_waves(choice: Choice, effects: Sequence[FoundEffect]) -> tuple[str, ...]:
    """Friction along the belt, or a reading that follows the drive? The latter would also bend the sticks."""
    found = next((one for one in effects if one.name == "belt_seam"), None)
    if found is None:
        return ()
    rate, level = block_of(choice, "rate"), block_of(choice, "level")
    if not len(rate):  # no stick is long enough to have one
        return ()
    length, a = found.parameters["L"].value, found.parameters["a"].value
    angle = 2 * np.pi * rate.travel / length
    columns = [np.where(rate.run == r, f(angle), 0.0) for r in np.unique(rate.run) for f in (np.sin, np.cos)]
    means = [np.where(rate.run == r, 1.0, 0.0) for r in np.unique(rate.run)]
    root = 1 / np.sqrt(rate.noise + rate.spread**2)
    X = np.column_stack([*columns, *means]) * root[:, None]
    theta = np.linalg.lstsq(X, rate.y * root, rcond=None)[0][: len(columns)]
    seen = float(np.sqrt(np.mean(np.sum(theta.reshape(-1, 2) ** 2, axis=1))))
    implied = 2 * np.pi * a * float(np.mean(level.load)) / length
    if seen >= 0.5 * implied:
        return ()
    return (
        f"a reading that followed the drive with this wavelength would make sticks rise {percent(implied)} faster "
        f"and slower in turn; they vary by {percent(seen)}: it is the friction that varies",
    )


def _speeds(train: Sequence[Measured]) -> tuple[str, ...]:
    speeds = {round(m.run.belt_speed, 12) for m in train}
    if len(speeds) > 1:
        return ()
    return ("all train runs have one belt speed: a gain, a drift and a wrong set-point look alike",)


def _ties(effects: Sequence[FoundEffect]) -> list[str]:
    out = []
    for one in effects:
        exact = [a.name for a in one.alternatives if a.exact]
        near = [a.name for a in one.alternatives if a.tied and not a.exact]
        if exact:
            out.append(f"{one.name} and {', '.join(exact)} give the same readings by algebra: {_why(one)}")
        if near:
            out.append(f"these runs do not tell {one.name} from {', '.join(near)}")
    return out


def _why(one: FoundEffect) -> str:
    return next(a.reason for a in one.alternatives if a.exact)
