"""The bench of a block on a belt: its runs in scaled numbers, cut into windows."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from stickslip.declared.friction.coulomb import CoulombFriction
from stickslip.declared.model import Model
from stickslip.declared.rig import BlockOnBelt
from stickslip.discovery.laboratory.belt_bench import BeltBench
from stickslip.discovery.laboratory.rival_kind import rival
from stickslip.discovery.laboratory.unused import usable
from stickslip.errors import InputError
from stickslip.fitted.data import Data, prepare
from stickslip.likelihoods.block_windows import BlockSensors
from stickslip.likelihoods.declared_numbers import known
from stickslip.likelihoods.policy import POLICY
from stickslip.likelihoods.population import STATIC
from stickslip.likelihoods.scaled import Scaled, scaled, start
from stickslip.likelihoods.shown_levels import shown_levels
from stickslip.likelihoods.stretches import stretches
from stickslip.measured.case import Case
from stickslip.measured.constants import block_constants


def bench_of(case: Case) -> tuple[BeltBench, Scaled, list[Data], dict[str, str]]:
    """
    Return train runs cut into windows, the units, the same runs with those not fitted, and which are left out and why.

    Constants that a run has for itself are its own, and exact.

    Raises
    ------
    InputError
        A constant is in another unit, a belt stands still, or no train run shows a slip.
    """
    rig = case.rig
    assert isinstance(rig, BlockOnBelt)
    block_constants(case)
    units, runs = scaled(rig, case.train), (*case.train, *case.validate)
    rigs = [run.rig for run in runs if isinstance(run.rig, BlockOnBelt)]  # a case has runs of one kind
    data = [
        replace(made, constants=units.constants(own))
        for own, made in zip(rigs, prepare([units.run(one) for one in runs]), strict=True)
    ]
    train, validate = data[: len(case.train)], data[len(case.train) :]
    used, why = usable(case.train, train)
    cut = stretches(used)
    if len(cut) < POLICY.fewest_windows and not any(one.stuck for one in cut):
        reasons = "".join(f"; {name}: {one}" for name, one in why.items())
        swings = f", and {len(cut)} swings of {POLICY.fewest_windows} that would do without" if cut else ""
        raise InputError(f"no slip between two sticks is found in the train runs{swings}{reasons}")
    declared = Model(units.block(), friction=start(case.declared_law, units, case.train))
    channel = case.train[0].channel("x1")
    sensors = BlockSensors(
        (f"gain.{channel}",), declared.parameters["stiffness"] if channel == "spring_force" else None
    )
    rivals = tuple(rival(one, units.scales) for one in case.candidates)
    bench = BeltBench(declared, used, cut, known(case), POLICY, sensors, rivals)
    return as_shown(bench), units, [*used, *validate], why


def as_shown(bench: BeltBench) -> BeltBench:
    """Return the same, a Coulomb law begun at the mean of what its windows show."""
    law, windows = bench.model.friction, bench.windows()
    if (
        not isinstance(law, CoulombFriction)
        or not bench.stretches
        or (own := shown_levels(windows, windows.start)) is None
    ):
        return bench
    u = own[:, windows.begins :]
    kinetic = float(np.mean(u[:, windows.kinetic]))
    numbers = {
        "static": law.static * (1 + kinetic) * (1 + float(np.mean(u[:, STATIC]))),
        "kinetic": law.kinetic * (1 + kinetic),
    }
    return replace(bench, model=bench.model.replace(**numbers)) if min(numbers.values()) > 0 else bench
