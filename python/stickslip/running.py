"""The model's side of a comparison: the run it makes from the start, and its forecasts from cycle to cycle.

The whole chain counts: effects keep the run's own time, their phases and hidden states come from its readings, and
what the sensors add is in the readings that are predicted.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, cast

import numpy as np
from numpy.typing import NDArray

from stickslip import segments
from stickslip.effects import Effect
from stickslip.errors import InputError, StickslipError
from stickslip.identify import Measured, columns, natural_period
from stickslip.lowering import HIDDEN
from stickslip.model import Model
from stickslip.records import Recording
from stickslip.rig import Rig
from stickslip.shooting import Array, Simulator, Window, shoot
from stickslip.simulate import Trajectory

if TYPE_CHECKING:
    from stickslip.discovery.slider.predict import Reading

THREADS = 2


@dataclass(frozen=True)
class Runs:
    """Readings (n, c) of the free run, and of the forecasts, NaN where there is none."""

    free: Array
    ahead: Array

    @property
    def forecast(self) -> NDArray[np.bool_]:
        """Where there is a forecast, (n,)."""
        return np.isfinite(self.ahead[:, 0])


def runs_of(run: Measured, model: Model, recording: Recording, simulator: Simulator) -> Runs:
    """Run the model beside a record: freely from its start, and for each window from the readings before it.

    Raises
    ------
    InputError
        If the model cannot be simulated from the estimated start.
    """
    bounds = _windows(run, model)
    if model.effects and isinstance(model.rig, Rig):
        try:
            return _with_effects(run, model, recording, bounds)
        except InputError:  # too short to hold a cycle: states can be told, phases cannot
            pass
    windows = [
        (segments.window(run.track, run.readings, b, run=0, columns=columns(model.rig), past_only=True), b[0])
        for b in bounds
    ]
    force = recording.channel("x1") == "spring_force"
    return Runs(_free_run(run, model, force, simulator), _forecasts(run, model, windows, force, simulator))


def _windows(run: Measured, model: Model) -> list[tuple[int, int]]:
    """Samples of windows of about two cycles for forecasting."""
    length = 1.2 * natural_period(model.rig)
    return [b for b in segments.cut(run.track, length) if b[1] - b[0] > 12]


def _with_effects(run: Measured, model: Model, recording: Recording, bounds: list[tuple[int, int]]) -> Runs:
    """States, hidden states and phases by the window fit of the loop."""
    from stickslip.discovery.data import prepare
    from stickslip.discovery.predict import Forecaster, whole_run
    from stickslip.discovery.readings import curves_of

    data = prepare([replace(recording, belt_speed=run.belt_speed)])[0]
    data = replace(data, readings=data.readings[:, :2], weight=data.weight[:, :2], noise=data.noise[:2])
    forecaster = Forecaster(model, data, THREADS, curves_of(model))
    try:
        free = whole_run(forecaster).readings
    except StickslipError as error:
        raise InputError("the model cannot be simulated over the run from the estimated start") from error
    ahead = np.full_like(run.readings, np.nan)
    forecaster = Forecaster(model, data, THREADS, curves_of(model))
    for start, stop in bounds[1:]:
        try:
            ahead[start:stop] = forecaster.forecast(start, data.t[start:stop]).readings
        except StickslipError:
            continue
    return Runs(free, ahead)


def _free_run(run: Measured, model: Model, force: bool, simulator: Simulator) -> Array:
    """Readings (n, c) of the model running freely from the start, its initial state fitted to the run."""
    cols = list(columns(model.rig))
    whole = segments.window(run.track, run.readings, (0, len(run.t)), run=0, columns=cols)
    first = segments.cut(run.track, 2 * natural_period(model.rig))[0]
    opening = segments.window(run.track, run.readings, first, run=0, columns=cols)
    fitted = opening
    try:
        # a stick says where the block is; slips whose friction scatters would only pull the start astray
        if len(cols) > 1 or "x2" in opening.free:
            short = shoot(model, [opening], (), noise=run.noise, simulator=simulator, iterations=20)
            fitted = short.windows[0]
        if len(cols) > 1:
            whole = replace(whole, initial=fitted.initial)
            longer = shoot(model, [whole], (), noise=run.noise, simulator=simulator, iterations=20)
            fitted = longer.windows[0] if np.isfinite(longer.chi2) else fitted
    except (StickslipError, np.linalg.LinAlgError):
        fitted = opening
    whole = replace(whole, initial=_state(model, fitted.initial, 0.0, force))
    out = _simulated(model, whole, simulator, 0.0, ())
    if out is None:
        raise InputError("the model cannot be simulated over the run from the estimated start")
    return _read(model, out, force, cols)


def _forecasts(
    run: Measured, model: Model, windows: list[tuple[Window, int]], force: bool, simulator: Simulator
) -> Array:
    """Readings forecast cycle by cycle, each from a state estimated from earlier readings only."""
    cols = list(columns(model.rig))
    ahead = np.full_like(run.readings, np.nan)
    hidden: tuple[float, ...] = ()
    for i, (given, start) in enumerate(windows):
        at = float(run.t[start]) if model.effects else 0.0
        window = replace(given, initial=_state(model, given.initial, at, force))
        out = _simulated(model, window, simulator, at, hidden)
        if out is None:
            hidden = ()
            continue
        if model.effects:  # what a hidden state has come to is known from the window before alone
            owned = {n for one in model.effects if isinstance(one, Effect) for n in one.kind.hidden}
            hidden = tuple(float(out.hidden[n][-1]) if n in owned else 0.0 for n in HIDDEN)
        if i > 0:
            ahead[start : start + len(out.state)] = _read(model, out, force, cols)
    return ahead


def _simulated(
    model: Model, window: Window, simulator: Simulator, t_start: float, hidden: tuple[float, ...]
) -> Trajectory | None:
    """The model over a window, from its state and the hidden ones; None where it stops before the end."""
    later = {"t_start": t_start} if t_start else {}
    try:
        out = simulator(
            model,
            belt_speed=window.belt_speed,
            initial=(*window.initial, *hidden),
            t_end=t_start + float(window.t[-1]),
            t_eval=t_start + window.t,
            **later,
        )
    except StickslipError:
        return None
    return (
        cast("Trajectory", out) if len(out.state) == len(window.t) else None
    )  # hidden states: of `simulate` alone


def _chain(model: Model, force: bool) -> Reading:
    from stickslip.discovery.slider.predict import reading_of

    chain = reading_of(model, force)
    lagged = any(one.name == "sensor_lag" for one in model.effects)  # the core lags what the sensor reads
    return replace(chain, curvature=0.0) if lagged else chain


def _state(model: Model, told: Array, t: float, force: bool) -> Array:
    """The state behind what the readings tell of it at t: a block on a belt has one channel, and its chain undone."""
    if not model.effects or isinstance(model.rig, Rig):
        return told
    x = _chain(model, force).undone(told[:1], np.array([t]))
    return np.concatenate([x, told[1:]])


def _read(model: Model, out: Trajectory, force: bool, cols: list[int]) -> Array:
    """Readings (n, c) of a run: its states, with what the sensors add; `force` where the spring's force is recorded."""
    if not model.effects:
        return out.state[:, cols]
    lagged = any(one.name == "sensor_lag" for one in model.effects)
    readings = out.state[:, cols].copy()
    readings[:, 0] = _chain(model, force).of(out.hidden["m"] if lagged else out.state[:, 0], out.t)
    return readings
