"""The bench of a block on a belt: its runs in scaled numbers, cut into windows."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from stickslip.declared.friction.coulomb import CoulombFriction
from stickslip.declared.model import Model
from stickslip.declared.rig import BlockOnBelt
from stickslip.discovery.laboratory.belt_bench import BeltBench
from stickslip.discovery.laboratory.block_words import idle
from stickslip.discovery.laboratory.rival_kind import rival
from stickslip.errors import InputError
from stickslip.fitted.block_events.table import measure
from stickslip.fitted.block_events.table import prepare as prepare_events
from stickslip.fitted.data import Data, prepare
from stickslip.likelihoods.block_windows import BlockSensors, drowned
from stickslip.likelihoods.declared_numbers import known
from stickslip.likelihoods.policy import POLICY
from stickslip.likelihoods.population import STATIC
from stickslip.likelihoods.scaled import Scaled, scaled, start
from stickslip.likelihoods.shown_levels import shown_levels
from stickslip.likelihoods.stretches import cut, stretches
from stickslip.measured.case import Case
from stickslip.measured.constants import block_constants

DROWNED = "left out: what passes for slips in it are peaks of noise"


def bench_of(case: Case) -> tuple[BeltBench, Scaled, list[Data], dict[str, str]]:
    """
    Return train runs cut into windows, the units, the same runs with those not fitted, and which are left out and why.

    Constants that a run has for itself are its own, and exact.

    Raises
    ------
    InputError
        A constant is in another unit, a belt stands still, or no train run shows a slip between sticks.
    """
    rig = case.rig
    assert isinstance(rig, BlockOnBelt)
    block_constants(case)
    measured = [measure(prepare_events(run)) for run in case.train]
    if not any(len(one.events) for one in measured):
        why = "".join(f"; {one}" for one in idle(case.train, measured))
        raise InputError(f"no slip between two sticks is found in the train runs{why}")
    units, runs = scaled(rig, case.train), (*case.train, *case.validate)
    rigs = [run.rig for run in runs if isinstance(run.rig, BlockOnBelt)]  # a case has runs of one kind
    data = [
        replace(made, constants=units.constants(own))
        for own, made in zip(rigs, prepare([units.run(one) for one in runs]), strict=True)
    ]
    train, validate = data[: len(case.train)], data[len(case.train) :]
    left_out = {run.name: DROWNED for run in train if drowned(run)}
    if len(left_out) == len(train):
        raise InputError("; ".join(f"{name}: {why}" for name, why in left_out.items()))
    declared = Model(units.block(), friction=start(case.declared_law, units, case.train))
    channel = case.train[0].channel("x1")
    sensors = BlockSensors(
        (f"gain.{channel}",), declared.parameters["stiffness"] if channel == "spring_force" else None
    )
    rivals = tuple(rival(one, units.scales) for one in case.candidates)
    used = cut([run for run in train if run.name not in left_out])
    bench = BeltBench(declared, used, stretches(used), known(case), POLICY, sensors, rivals)
    return as_shown(bench), units, [*used, *validate], left_out


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
