"""The model's side of a comparison: the run it makes from the start, and its forecasts from cycle to cycle.

Both are those of `forecast`: effects keep the run's own time, their phases and hidden states come from its readings,
and what the sensors add is in the readings that are predicted.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from stickslip.declared.model import Model
from stickslip.declared.rig import Rig
from stickslip.errors import InputError, StickslipError
from stickslip.fitted.data import CHANNELS, prepare
from stickslip.fitted.predict import Forecaster, whole_run
from stickslip.fitted.readings import curves_of
from stickslip.measured.case import Recording
from stickslip.measured.fit_window import Array
from stickslip.measured.prepared import Measured

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


def runs_of(run: Measured, model: Model, recording: Recording, bounds: list[tuple[int, int]]) -> Runs:
    """Run the model beside a record: freely from its start, and for each window from the readings before it.

    Parameters
    ----------
    run : the record, or its end
    recording : where it is from
    bounds : samples of `run` that the windows begin and end before

    Raises
    ------
    InputError
        If the model cannot be simulated from the estimated start.
    """
    told = _as_measured(run, recording)
    free, ahead = (_rig if isinstance(model.rig, Rig) else _block)(run, model, told)
    try:
        whole = free()
    except StickslipError as error:
        raise InputError("the model cannot be simulated over the run from the estimated start") from error
    forecasts = np.full_like(run.readings, np.nan)
    for start, stop in bounds[1:]:
        try:
            forecasts[start:stop] = ahead(start, stop)
        except StickslipError:
            continue
    return Runs(whole, forecasts)


Both = tuple[Callable[[], Array], Callable[[int, int], Array]]


def _as_measured(run: Measured, recording: Recording) -> Recording:
    """The recording at the belt speed and with the noise that its comparison uses."""
    noise = dict(zip(CHANNELS, run.noise.tolist(), strict=False))
    return replace(recording, belt_speed=run.belt_speed, noise={**recording.noise, **noise})


def _rig(run: Measured, model: Model, recording: Recording) -> Both:
    """States, hidden states and phases by the window fit of the loop."""
    seen = np.isfinite(run.readings)  # glitches are out
    x1, y1 = (np.interp(run.t, run.t[ok], r[ok]) for r, ok in zip(run.readings.T, seen.T, strict=True))
    data = prepare([replace(recording, x1=x1, y1=y1, belt=None)])[0]
    data = replace(data, weight=np.where(seen, data.weight, 0.0))
    # what is fitted to the whole run must not be known to its forecasts
    one, other = (Forecaster(model, data, THREADS, curves_of(model)) for _ in range(2))
    return (
        lambda: whole_run(one).readings,
        lambda start, stop: other.forecast(start, data.t[start:stop]).readings,
    )


def _block(run: Measured, model: Model, recording: Recording) -> Both:
    """States from the sticks before, friction at the level of the last events where that foretells better."""
    from stickslip.fitted.block_events.predict import BlockForecaster as Slider

    one = Slider.of(model, recording, at_rest=True)
    one.settle(len(one.measured.run.t))  # phases are the run's own: the forecasts begin with them
    other = Slider(one.model, one.measured, one.chain, one.sensor)
    sign, t, first = one.measured.run.sign, one.measured.run.t, len(recording.t) - len(run.t)
    return (
        lambda: sign * one.free(first).reading[:, None],
        lambda start, stop: (
            sign * other.forecast(first + start, t[first + start : first + stop]).reading[:, None]
        ),
    )
