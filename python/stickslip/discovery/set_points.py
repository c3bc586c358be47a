"""Belt speeds that the sticks of single runs contradict, unlike in the other runs: a set-point mistyped or swapped."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from stickslip.declared.units import default_speed_unit, factor
from stickslip.discovery.result import ErrorBlock, FoundEffect, Residual
from stickslip.fitted.data import Data
from stickslip.fitted.plausible import period_of
from stickslip.measured.case import Case
from stickslip.measured.stick_speed import ridden_speed

OFF = 0.04  # in the logarithm, from the other runs: the sticks of a run whose belt runs as said are within a hundredth
AGREE = 0.02  # how near most runs must lie to each other, for one to be odd
FEWEST = 4  # runs whose sticks tell their speed
FAR = 1.5  # error of a run's forecast over its floor, from which its set-point is looked at


def doubtful_set_points(
    case: Case,
    data: Sequence[Data],
    effects: Sequence[FoundEffect],
    after: Residual,
    error: ErrorBlock,
    wild: bool = False,
) -> tuple[str, ...]:
    """What to say of runs whose block rides at another speed than belt_speed, unlike the others'.

    Only where something is unexplained: a yielding contact and a drooping belt change these speeds as well.

    Parameters
    ----------
    data : all runs.
    wild : whether what is left is small only as scatter takes it.
    """
    unnamed = any(one.name == "unlisted" and one.where in ("belt", "contact") for one in effects)
    missed = [run.run for run in error.runs if run.one_cycle["after"] > FAR * run.one_cycle["floor"]]
    trained = wild or not after.clean or unnamed
    if not (trained or missed):
        return ()
    ridden = [ridden_speed(run.t, run.readings[:, 0], period_of(run.t, run.readings[:, 0])) for run in data]
    shares = {
        run.name: v / run.belt_speed
        for run, v in zip(data, ridden, strict=True)
        if v is not None and v * run.belt_speed > 0
    }
    if len(shares) < FEWEST:
        return ()
    usual = float(np.median(list(shares.values())))
    if np.mean([abs(np.log(one / usual)) < AGREE for one in shares.values()]) < 0.5:
        return ()
    unit = case.channels["belt"].unit if "belt" in case.channels else default_speed_unit(case.rig)
    one = factor("belt", unit, case.rig)
    word = "" if unit == "1" else f" {unit}"
    out = []
    for run in data:
        share, v_b = shares.get(run.name, usual), run.belt_speed
        if abs(np.log(share / usual)) > OFF and (run.name in missed or (trained and run.role == "train")):
            out.append(
                f"{run.name}: the block sticks at {share * v_b / one:.4g}{word}, {share:.3g} times belt_speed, unlike "
                f"in the other runs: check its belt_speed ({v_b / one:.4g}{word}) and its file first"
            )
    return tuple(out)
