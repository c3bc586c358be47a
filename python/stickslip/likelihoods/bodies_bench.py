"""What stays the same over all hypotheses of a case of a rig of bodies or matrices, and the numbers of each."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from stickslip.declared.model import Model
from stickslip.declared.rigs.general import GeneralRig
from stickslip.declared.uncertainty import Uncertainty
from stickslip.errors import InputError
from stickslip.fitted.bodies_data import BodiesData, prepare_bodies
from stickslip.likelihoods.bodies_cuts import Cut, cuts
from stickslip.likelihoods.bodies_windows import BELT_OFF, BodiesWindows
from stickslip.likelihoods.declared_numbers import FAR, FAR_GAIN, STRIDE_CONSTANT, held_loosely
from stickslip.likelihoods.policy import POLICY, Policy
from stickslip.likelihoods.shared import Declared, SharedNumber
from stickslip.measured.recording import Recording

WIDE = 2.3  # width of the prior of a number of a law that is identified, in the logarithm: a factor of ten


@dataclass(frozen=True)
class BodiesBench:
    """
    A case.

    Parameters
    ----------
    model : the declared model
    data : the runs
    stretches : their windows
    declared : how well the rig's numbers and the gains are known; what is exact is not among them
    policy : what steers
    law_spread : width of the prior of a law's numbers about the declared ones, in the logarithm
    """

    model: Model
    data: Sequence[BodiesData]
    stretches: Sequence[Cut]
    declared: Declared
    policy: Policy = POLICY
    law_spread: float = WIDE

    def windows(self, model: Model | None = None, more: Sequence[SharedNumber] = ()) -> BodiesWindows:
        """Return the windows of a hypothesis: the declared model, or another with further numbers."""
        own = model or self.model
        of_runs = (n for r, run in enumerate(self.data) for n in of_run(own, run, r, self.policy))
        numbers = [*self.of_law(), *self.of_rig(), *self.of_sensors(), *of_runs, *more]
        return BodiesWindows(own, self.data, self.stretches, numbers, self.declared, self.policy)

    def of_law(self) -> list[SharedNumber]:
        """Return the numbers of the laws, held loosely about what is declared."""
        return held_loosely(self.model.friction.numbers, self.law_spread)

    def of_rig(self) -> list[SharedNumber]:
        """Return the constants, over what is declared of them, and the gains that are not exact."""
        out = []
        for name in self.declared.names:
            if name in self.declared.gains:
                out.append(SharedNumber(name, 0.0, 0.0, math.inf, low=-FAR_GAIN, high=FAR_GAIN))
            else:
                out.append(
                    SharedNumber(name, 0.0, 0.0, math.inf, True, low=-FAR, high=FAR, stride=STRIDE_CONSTANT)
                )
        return out

    def of_sensors(self) -> list[SharedNumber]:
        """Return the offsets of sensors that are not exact, as well known as declared."""
        given = self.data[0].offsets
        return [SharedNumber(f"offset.{name}", 0.0, 0.0, size) for name, (_, size) in given.items()]


def of_run(model: Model, run: BodiesData, number: int, policy: Policy) -> list[SharedNumber]:
    """
    Return the speeds of a run's belt and drive, nearly as set or measured; none of a drive whose speed is a formula.

    The belt's is the share by which it is faster than set, for all of the run's windows: without it the gain of a
    sensor, which reads that speed in every stick, would be known as well as it is read.
    """
    assert isinstance(model.rig, GeneralRig)
    own, out, sd = model.rig.equations, list[SharedNumber](), policy.belt_sd
    if own.on_belt and run.belt.constant != 0:
        out.append(SharedNumber(BELT_OFF, 0.0, 0.0, sd, run=number, stride=sd))
    if own.driven and (speed := run.drive.constant):
        off = sd * abs(speed)
        out.append(SharedNumber("drive_speed", run.followed * speed, speed, off, run=number, stride=off))
    return out


def bench_of(
    model: Model, runs: Sequence[Recording], known: Uncertainty, policy: Policy = POLICY
) -> BodiesBench:
    """
    Return runs cut into windows.

    Parameters
    ----------
    model : the declared one
    runs : recorded on its rig
    known : how well its constants and gains are known

    Raises
    ------
    InputError
        A run is too short, or none can be cut into windows.
    """
    assert isinstance(model.rig, GeneralRig)
    data = prepare_bodies(model.rig, runs, model.friction)
    stretches = cuts(data, policy)
    if not stretches:
        raise InputError("the runs are shorter than a natural period; nothing can be fitted to them")
    return BodiesBench(model, data, stretches, declared_of(model.rig, known, data[0].channels), policy)


def declared_of(rig: GeneralRig, known: Uncertainty, channels: Sequence[str]) -> Declared:
    """Return what is known of the constants and the gains of what is read, less what is exact."""
    gains = {f"gain.{name}": name for name in channels if name in known.gains}
    every = {name: name for name in rig.uncertain} | gains
    covariance = known.covariance(list(every.values()))
    kept = [i for i in range(len(every)) if covariance[i, i] > 0]
    names = list(every)
    return Declared(tuple(names[i] for i in kept), covariance[np.ix_(kept, kept)], gains)
