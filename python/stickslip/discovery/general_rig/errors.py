"""The error on runs never fitted, of a rig of bodies or matrices: one window ahead, with friction of the mean event."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from stickslip.declared.model import Model
from stickslip.discovery.carry_over import deciding
from stickslip.discovery.result import ErrorBlock, RunError
from stickslip.errors import InputError
from stickslip.fitted.bodies_data import BodiesData
from stickslip.likelihoods.bodies_ahead import WindowForecasts, one_ahead
from stickslip.likelihoods.bodies_cuts import Cut, cuts
from stickslip.likelihoods.bodies_windows import BodiesWindows
from stickslip.likelihoods.contact_scatter import ContactScatter
from stickslip.likelihoods.fit import null
from stickslip.likelihoods.held_out import Unseen, deviances, falls
from stickslip.likelihoods.own_phases import as_it_ran
from stickslip.likelihoods.policy import POLICY
from stickslip.likelihoods.shared import Declared
from stickslip.measured.recording import Recording

Floats = NDArray[np.float64]
METRIC = (
    "error of the readings one window (a stick and the slips after it) ahead of where the window before ends, with "
    "friction of the mean event, over how far they move in it; mean over validate runs"
)
WHO = ("before", "after", "floor")
NONE = dict.fromkeys(WHO, math.nan)


@dataclass(frozen=True)
class FittedRig:
    """
    What the runs that were fitted tell: a model, and what its sensors make of what they read.

    Parameters
    ----------
    model : of the rig
    sensors : gains less 1 and offsets, as "gain.<channel>" and "offset.<channel>", among other numbers
    scatter, noise : of what differs from event to event, and (channels,) of the readings over what is declared
    """

    model: Model
    sensors: Mapping[str, float]
    scatter: ContactScatter
    noise: Floats

    def of(self, kind: str, run: BodiesData) -> Floats:
        """Return the gains less 1, or the offsets, of a run's channels, (c,)."""
        return np.array([self.sensors.get(f"{kind}.{name}", 0.0) for name in run.channels])


def error_block(
    before: FittedRig,
    after: FittedRig,
    runs: Sequence[BodiesData],
    recordings: Sequence[Recording],
    spare: float | None,
    less: Mapping[str, tuple[FittedRig, float]],
) -> tuple[ErrorBlock, list[tuple[WindowForecasts, WindowForecasts]]]:
    """
    Return `error` of the report, and the forecasts that it rests on.

    The floor is what noise of the readings alone leaves; that friction of the next event is not known comes on top.
    How likely the runs are is told by their events, each with friction of its own.

    Parameters
    ----------
    before, after : what is held against each other
    runs, recordings : never fitted
    spare : by how much what was found passes its gate; None for what has none
    less : what there is without each of several effects, by name, and by how much that one passes its gate
    """
    rows, kept, fell = [], [], list[float]()
    each: dict[str, list[float]] = {name: [] for name in less}
    for run, recording in zip(runs, recordings, strict=True):
        now, deviance = ahead(after, run)
        was = now
        if before is not after:
            was, other = ahead(before, run)
            fell += falls(other, deviance)
        for name, (one, _) in less.items():
            each[name] += falls(ahead(one, run)[1], deviance)
        kept.append((was, now))
        rows.append(_row(run, recording, was, now))
    mean = {who: float(np.nanmean([row.one_cycle[who] for row in rows])) for who in WHO}
    block = ErrorBlock(METRIC, mean["before"], mean["after"], mean["floor"], tuple(rows))
    held = {name: (each[name], beyond) for name, (_, beyond) in less.items()}
    return replace(block, likelihood=deciding(fell, spare, held)), kept


def two_windows(run: BodiesData) -> list[Cut]:
    """
    Return the windows of a run of which one can be forecast.

    Raises
    ------
    InputError
        The run is too short: no window ends where another begins.
    """
    cut = cuts([run])
    if not any(a.stop == b.start for a, b in zip(cut[:-1], cut[1:], strict=True)):
        words = "a window, from stick to stick or a natural period long, is forecast from the one before it"
        raise InputError(f"run '{run.name}' is too short to be forecast; {words}")
    return cut


def ahead(told: FittedRig, run: BodiesData) -> tuple[WindowForecasts, Unseen]:
    """
    Return what is forecast of a run, one window ahead, and how likely each window is, as of `deviances`.

    Its sensors have the gains and offsets found: of an angle that grows a small error of the gain is soon a large one.

    Raises
    ------
    InputError
        The run is too short.
    """
    cut = two_windows(run)
    gain, offset = 1 + told.of("gain", run), told.of("offset", run)
    true = (run.readings - offset) / gain
    run = replace(run, readings=true, weight=run.weight * gain, noise=run.noise / gain)
    own, run = as_it_ran(told.model, run, cut)
    fit = null(BodiesWindows(own, [run], cut, [], Declared()), POLICY)
    made = one_ahead(fit, run)
    made = replace(made, off=made.off * gain, readings=made.readings * gain + offset)
    return made, deviances(fit, told.scatter, told.noise)


def _row(run: BodiesData, recording: Recording, was: WindowForecasts, now: WindowForecasts) -> RunError:
    error = {"before": was.error, "after": now.error, "floor": now.floor}
    rmse, unit = {}, {}
    for c, name in enumerate(run.channels):
        factor = recording.factors.get(name, 1.0)
        sizes = (was.off[c], now.off[c], run.noise[c])
        rmse[name] = {who: float(size / factor) for who, size in zip(WHO, sizes, strict=True)}
        unit[name] = recording.channels[name].unit if name in recording.channels else "1"
    return RunError(run.name, run.belt_speed, error, NONE, NONE, NONE, NONE, NONE, rmse, unit)
