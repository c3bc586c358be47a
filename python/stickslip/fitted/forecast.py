"""Forecasts of one run: the state from its past by the window fit, then a free run of the model."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from stickslip.arguments import must_be
from stickslip.declared.bodies_model import check_closed_form
from stickslip.declared.model import Model
from stickslip.declared.rig import BlockOnBelt
from stickslip.declared.scale import plainly
from stickslip.errors import InputError, number
from stickslip.fitted.data import CHANNELS, Data, prepare
from stickslip.fitted.plausible import stick_speed
from stickslip.fitted.predict import Forecaster
from stickslip.fitted.readings import curves_of
from stickslip.measured.case import Recording
from stickslip.measured.stick_speed import CLEAR, NEAR, contradicted, wrong_set_point

SLACK = 0.05  # of a sampling interval: a horizon so little short of a sample reaches it; a file's times are rounded
MOST = 1_000_000  # samples of a forecast
LAST = 10  # samples of the past that the start is held against
HARDLY = 1.03  # ratio of the past's speed to the one given that may be why the model misses the last readings
FAR = 5.0  # times the noise
BEYOND = 10.0  # ratio of the past's speed to the one given that only a mistake explains


@dataclass(frozen=True)
class Expected:
    """
    A run of a model that follows a recording, in model units.

    Parameters
    ----------
    t : (n,) times, from the recording's first sample
    readings : (n, c) as the recording's channels have them
    channels : their names
    model : with the phases of this recording
    past : the recording, its belt speed the one asked for
    wrong : what contradicts that speed, None if nothing does
    far : how far from the last readings the run begins, None if it passes through them
    """

    t: NDArray[np.float64]
    readings: NDArray[np.float64]
    channels: tuple[str, ...]
    model: Model
    past: Recording
    wrong: str | None = None
    far: str | None = None


def follow(model: Model, recording: Recording, belt_speed: float, horizon: float) -> Expected:
    """Return what a model without scatter makes of what follows; errors and warnings are those of `forecast`."""
    must_be("model", model, Model, "load_model(file) gives one")
    check_closed_form(model.rig, model.friction)
    must_be("recording", recording, Recording, "load_recording(path, rig) or a case's runs give one")
    if type(recording.rig) is not type(model.rig):
        kinds = [type(one.rig).__name__ for one in (recording, model)]
        raise InputError("{} was recorded on a {}, and the model is of a {}".format(recording.name, *kinds))
    speed, span = number("belt_speed", belt_speed), number("horizon", horizon, above=0)
    past_run = replace(recording, belt_speed=speed)
    dt = _interval(recording.t)
    steps = int(np.floor(span / dt + SLACK))
    if steps < 1:
        raise InputError(f"shorter than one sampling interval ({dt:g})", key="horizon", value=horizon)
    if steps > MOST:
        words = f"{steps:.3g} samples; {MOST} are the most, a horizon of {MOST * dt:.4g}"
        raise InputError(words, key="horizon", value=horizon)
    if isinstance(model.rig, BlockOnBelt):
        return _slider(model, past_run, dt, steps)
    run = prepare([past_run])[0]
    seen, who = _ridden(run)
    _refuse(contradicted(past_run, seen, BEYOND, who))
    future = np.asarray(float(run.t[-1]) + dt * np.arange(1, steps + 1), dtype=np.float64)
    forecaster = Forecaster(model, run, 2, curves_of(model))
    forecaster.settle(len(run.t))
    window = forecaster.state_window(len(run.t))
    past = np.asarray(run.t[window.start : window.stop], dtype=np.float64)
    whole = forecaster.run_on(window, np.concatenate([past, future])).readings
    difference = whole[len(past) - LAST : len(past)] - run.readings[window.stop - LAST : window.stop]
    wrong, far = _doubts(difference, run, past_run, seen, who)
    phases = {one.name: forecaster.engine.parameters(forecaster.vector, 0)[1] for one in forecaster.periodic}
    effects = [
        one.replace(phi=phases[one.name][f"{one.name}.phi"]) if one.name in phases else one
        for one in model.effects
    ]
    names = CHANNELS[: min(whole.shape[1], 2)]
    settled = replace(model, effects=tuple(effects))
    return Expected(future, whole[len(past) :, : len(names)], names, settled, past_run, wrong, far)


def _interval(t: NDArray[np.float64]) -> float:
    """The sampling interval: the mean over all, which the rounding of times hardly touches; a gap counts as the samples
    that it lacks.
    """
    gaps = np.diff(t)
    interval = float(np.median(gaps))
    for _ in range(3):
        interval = float(t[-1] - t[0]) / float(np.maximum(np.round(gaps / interval), 1).sum())
    return interval


def _slider(model: Model, recording: Recording, dt: float, steps: int) -> Expected:
    """A block on a belt: the model in the belt's direction and the run's time, its state from the last stick."""
    from stickslip.fitted.block_events.predict import BlockForecaster as Slider
    from stickslip.fitted.block_events.predict import bare
    from stickslip.fitted.block_events.sensor import reading_of

    seen = bare(recording, reading_of(model, recording.channel("x1") == "spring_force"))
    _refuse(wrong_set_point(seen, clear=BEYOND))
    droops = any(one.name == "belt_load_droop" for one in model.effects)  # so that its sticks ride slower
    wrong = None if droops else wrong_set_point(seen, clear=NEAR)
    if wrong:
        wrong += "; the speed given is taken for that of the past too: the forecast starts from a wrong state"
    slider = Slider.of(model, recording)
    run = slider.measured.run
    future = np.asarray(float(run.t[-1]) + dt * np.arange(1, steps + 1), dtype=np.float64)
    readings = run.sign * slider.forecast(len(run.t), future).reading
    return Expected(future, readings[:, None], (recording.channel("x1"),), slider.model, recording, wrong)


def _ridden(run: Data) -> tuple[float | None, str]:
    """Speed of the past by its sticks, or else by its belt channel, None where neither tells; and what told it."""
    speed = stick_speed(run)
    if speed is None and run.readings.shape[1] == len(CHANNELS):
        reads = float(np.median(run.readings[:, 2]))
        still = run.belt_speed == 0 and abs(reads) < BEYOND * run.noise[2]  # a sensor's zero may be off
        return None if still else reads, "the past's channel belt reads"
    return speed, "the sticks of the past ride at"


def _refuse(wrong: str | None) -> None:
    if wrong:
        raise InputError(wrong)


def _doubts(
    difference: NDArray[np.float64], run: Data, recording: Recording, seen: float | None, who: str
) -> tuple[str | None, str | None]:
    """What to doubt: that the past rode at the speed given, and that the model passes through the last readings."""
    root = np.sqrt(np.mean(difference**2, axis=0))
    off = root / np.asarray(run.noise)
    worst = int(np.argmax(off))
    far = off[worst] > FAR
    wrong = contradicted(recording, seen, HARDLY if far else CLEAR, who)
    if not far:
        return wrong, None
    name = CHANNELS[worst]
    unit = "" if recording.unit(name) == "1" else f" {recording.unit(name)}"
    size = plainly(float(recording.to_readings(name, root[worst])), 3)
    return wrong, (
        f"model and channel {name} differ by {size}{unit} over the last {len(difference)} readings, "
        f"{plainly(off[worst], 3)} times the noise: the forecast starts that far off"
        + ("; is belt_speed right?" if seen is None else "")
    )
