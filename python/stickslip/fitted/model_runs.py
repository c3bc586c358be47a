"""The model's side of a comparison: the run it makes from the start, and its forecasts from cycle to cycle.

The whole chain counts: effects keep the run's own time, their phases and hidden states come from its readings, and
what the sensors add is in the readings that are predicted.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, cast

import numpy as np
from numpy.typing import NDArray

from stickslip.declared.model import Model
from stickslip.declared.rig import Rig
from stickslip.errors import InputError, StickslipError
from stickslip.fitted.identify import columns, natural_period
from stickslip.fitted.shooting import Simulator, shoot
from stickslip.measured import cutting
from stickslip.measured.case import Recording
from stickslip.measured.fit_window import Array, Window
from stickslip.measured.prepared import Measured
from stickslip.simulated.lowering import HIDDEN, hidden_states
from stickslip.simulated.simulate import Trajectory

if TYPE_CHECKING:
    from stickslip.fitted.block_events.sensor import Reading
    from stickslip.fitted.data import Data

THREADS = 2
PHASES = 24  # of a turn, tried for an unknown phase


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
        prepared = _prepared(run, recording)
        if prepared is not None:
            return _with_effects(run, model, prepared, bounds)
    chain = _Chain(model, recording.channel("x1") == "spring_force")
    told = replace(run, readings=chain.undone(run))
    windows = [
        (
            cutting.window(told.track, told.readings, b, run=0, columns=columns(model.rig), past_only=True),
            b[0],
        )
        for b in bounds
    ]
    chain = replace(chain, model=_turned(told, model, windows, simulator))
    return Runs(_free_run(told, chain, simulator), _forecasts(told, chain, windows, simulator))


def _windows(run: Measured, model: Model) -> list[tuple[int, int]]:
    """Samples of windows of about two cycles for forecasting."""
    length = 1.2 * natural_period(model.rig)
    return [b for b in cutting.cut(run.track, length) if b[1] - b[0] > 12]


def _prepared(run: Measured, recording: Recording) -> Data | None:
    """The run as the loop takes it; None where it is too short to hold a cycle, so that phases cannot be told."""
    from stickslip.fitted.data import prepare

    seen = np.isfinite(run.readings)  # glitches are out
    x1, y1 = (np.interp(run.t, run.t[ok], r[ok]) for r, ok in zip(run.readings.T, seen.T, strict=True))
    try:
        noise = dict(zip(("x1", "y1"), run.noise.tolist(), strict=True))
        told = replace(recording, belt_speed=run.belt_speed, x1=x1, y1=y1, noise={**recording.noise, **noise})
        data = prepare([told])[0]
    except InputError:
        return None
    weight = np.where(seen, data.weight[:, :2], 0.0)
    return replace(data, readings=data.readings[:, :2], weight=weight, noise=data.noise[:2])


def _with_effects(run: Measured, model: Model, data: Data, bounds: list[tuple[int, int]]) -> Runs:
    """States, hidden states and phases by the window fit of the loop."""
    from stickslip.fitted.predict import Forecaster, whole_run
    from stickslip.fitted.readings import curves_of

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


def _free_run(run: Measured, chain: _Chain, simulator: Simulator) -> Array:
    """Readings (n, c) of the model running freely from the start, its initial state fitted to the run."""
    model = chain.model
    cols = list(columns(model.rig))
    whole = cutting.window(run.track, run.readings, (0, len(run.t)), run=0, columns=cols)
    first = cutting.cut(run.track, 2 * natural_period(model.rig))[0]
    opening = cutting.window(run.track, run.readings, first, run=0, columns=cols)
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
    whole = replace(whole, initial=fitted.initial)
    began = float(run.t[0]) if model.effects else 0.0
    out = _simulated(model, whole, simulator, began, chain.settled(whole))
    if out is None:
        raise InputError("the model cannot be simulated over the run from the estimated start")
    return chain.read(out)


def _forecasts(
    run: Measured, chain: _Chain, windows: list[tuple[Window, int]], simulator: Simulator
) -> Array:
    """Readings forecast cycle by cycle, each from a state estimated from earlier readings only."""
    model = chain.model
    ahead = np.full_like(run.readings, np.nan)
    hidden: tuple[float, ...] = ()
    for i, (given, start) in enumerate(windows):
        at = float(run.t[start]) if model.effects else 0.0
        n = len(given.t)
        follows = model.effects and i + 1 < len(windows) and windows[i + 1][1] == start + n
        to = np.append(given.t, run.t[start + n] - run.t[start]) if follows else given.t
        out = _simulated(model, replace(given, t=to), simulator, at, hidden or chain.settled(given))
        hidden = ()
        if out is None:
            continue
        if follows:  # what a hidden state has come to is known from the window before alone
            owned = hidden_states(model)
            hidden = tuple(float(out.hidden[name][-1]) if name in owned else 0.0 for name in HIDDEN)
        if i > 0:
            ahead[start : start + n] = chain.read(out)[:n]
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


@dataclass(frozen=True)
class _Chain:
    """From states to readings, as the model's sensors have it; and back, for the one channel of a block on a belt."""

    model: Model
    force: bool  # the spring's force is recorded

    @property
    def _sensor(self) -> Reading:
        from stickslip.fitted.block_events.sensor import reading_of

        return reading_of(self.model, self.force)

    def undone(self, run: Measured) -> Array:
        """Displacements (n, 1) behind the readings; the rig of two degrees has its own way."""
        if not self.model.effects or isinstance(self.model.rig, Rig):
            return run.readings
        m, moves = self._sensor.behind(run.readings[:, 0], run.track.v, run.t)
        return (m + self._sensor.lag * moves)[:, None]

    def settled(self, window: Window) -> tuple[float, ...]:
        """Hidden states that a window starts from where nothing else is known: a lag that has settled."""
        if isinstance(self.model.rig, Rig) or not self._sensor.lag:
            return ()
        x, v = window.initial[:2]
        return tuple(self._sensor.settled(x, v) if name == "m" else 0.0 for name in HIDDEN)

    def read(self, out: Trajectory) -> Array:
        """Readings (n, c) of a run: its states, with what the sensors add."""
        readings = out.state[:, list(columns(self.model.rig))].copy()
        if not self.model.effects:
            return readings
        readings[:, 0] = self._sensor.read(out.state[:, 0], out.hidden.get("m"), out.t)
        return readings


def _turned(run: Measured, model: Model, windows: list[tuple[Window, int]], simulator: Simulator) -> Model:
    """The model with the phases of this run, which no other run tells: those under which its first half is met best."""
    early = [one for one in windows[1:] if run.t[one[1]] < 0.5 * run.t[-1]] or windows[:2]

    def misfit(trial: Model) -> float:
        total = 0.0
        for window, start in early:
            out = _simulated(trial, window, simulator, float(run.t[start]), ())
            if out is None:
                return np.inf
            total += float(np.nansum((out.state[:, 0] - window.readings[:, 0]) ** 2))
        return total

    for one in [e for e in model.effects if "phi" in e.parameters]:
        centre, width = one.parameters["phi"], 2 * np.pi
        for tried in (PHASES, 5, 5, 5):
            angles = centre + width * (np.arange(tried) - tried // 2) / tried
            trials = [model.replace(**{f"{one.name}.phi": float(a)}) for a in angles]
            best = int(np.argmin([misfit(trial) for trial in trials]))
            model, centre, width = trials[best], float(angles[best]), 2 * width / tried
    return model
