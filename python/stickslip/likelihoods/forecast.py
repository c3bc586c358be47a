"""Forecasts as distributions: the expected readings that follow a recording, and the band that holds them."""

from __future__ import annotations

import warnings
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from stickslip.arguments import explained, must_be
from stickslip.declared.drive import Drive
from stickslip.declared.effect import Effect, FormulaEffect
from stickslip.declared.model import Model
from stickslip.declared.rig import BlockOnBelt, DrivenSlider
from stickslip.declared.rigs.general import GeneralRig
from stickslip.declared.scale import written_speed, written_time
from stickslip.declared.speeds import Speed
from stickslip.declared.uncertainty import SIGMAS_95
from stickslip.errors import CallError, InputError, ModelWarning
from stickslip.fitted.data import prepare
from stickslip.fitted.driven import DrivenForecast, forecast_driven
from stickslip.fitted.forecast import Expected, follow
from stickslip.likelihoods.block_windows import BlockSensors
from stickslip.likelihoods.bodies_forecast import forecast_bodies
from stickslip.likelihoods.ensemble import Distribution, distribution
from stickslip.likelihoods.one_thread import one_thread
from stickslip.likelihoods.rig_windows import RigSensors
from stickslip.likelihoods.scaled import scaled
from stickslip.measured.case import Recording

if TYPE_CHECKING:
    import pandas as pd

Floats = NDArray[np.float64]
NOISE_ALONE = (
    "the windows of the past do not tell how friction of the events to come differs: the band is noise alone"
)


@one_thread
@explained
def forecast(
    model: Model,
    recording: Recording,
    *,
    horizon: float | str,
    belt_speed: float | str | Speed | None = None,
    drive_speed: float | str | Speed | None = None,
    drive: Drive | None = None,
) -> pd.DataFrame:
    """Predict the readings that follow a recording.

    The state at its last sample, hidden states of effects and phases included, comes from its own readings by
    output error over windows; from there the model runs freely. What all events of the past have in common beside the
    model is expected of those to come, too. Friction of these differs as it did in the past, or, where that has fewer
    than twelve windows, as `model.scatter` says. For a block on a belt, phases are the model's unless others foretell
    the past clearly better. The belt speed is that of the past and of the future: a change of speed is not modelled.
    Drifts count t from the recording's first row: give the past from where the run began.

    Parameters
    ----------
    model
        Complete model, as `discover` or `identify` give it.
    recording
        The past, at least one cycle of it.
    horizon
        How far to predict, in the model's unit of time, or with a unit: "0.5 s".
    belt_speed
        v_b in model units, or with a unit ("12 mm/s"): that of the recording and of what follows it. For a rig of
        bodies or matrices it may be left out, as the recording has it, and may be a formula of t or a `Speed`. Where
        the recording's was measured it is needed, and is that of what follows alone, by the recording's clock.
    drive_speed
        The same of the drive of such a rig.
    drive
        Force on a driven slider after the record, as `simulate` takes it, by the record's clock but in the model's unit
        of time. The band is as wide as such forecasts erred within the record.

    Returns
    -------
    DataFrame
        Columns t, x1, y1, then x1_low, x1_high, y1_low, y1_high, in the recording's own units, at its sampling rate,
        from the next sample on; for a block on a belt t, the channel recorded (x1 or spring_force), and its low and
        high; for a rig of bodies or matrices t and the coordinates and velocities recorded, with theirs. The band holds
        95 % of the readings to come, noise included.

    Raises
    ------
    InputError
        A model of another kind of rig than the recording's, a horizon that is not positive or longer than a million
        samples, a past too short or without y1, a belt speed
        of the wrong sign, ten times off the one that the past rides at or 0 where it rides, or, for a block on a belt,
        a curve of the reading in x2.
    StickslipError
        The model's run stops before the horizon.

    Warns
    -----
    ModelWarning
        The model does not pass through the last readings: the forecast starts somewhere else. Or, for a block on a
        belt, the sticks of the past ride at another speed than `belt_speed`. Or nothing tells how friction of events to
        come differs: the band is that of the noise alone.

    Examples
    --------
    >>> import numpy as np
    >>> import stickslip as ss
    >>> rig = ss.BlockOnBelt(mass=0.5, stiffness=500)  # kg, N/m
    >>> law = ss.CoulombFriction(static=2.0, kinetic=1.2)  # N
    >>> t = np.arange(0, 6, 0.002)
    >>> run = ss.simulate(ss.Model(rig, friction=law), belt_speed=0.01, t_end=6, t_eval=t)
    >>> x = 1e3 * run.x1 + 1e-3 * np.random.default_rng(0).standard_normal(t.size)  # mm
    >>> channels = {"t": ss.Channel("t", "s"), "x1": ss.Channel("x1", "mm")}
    >>> recording = ss.load_recording({"t": t, "x1": x}, rig, channels=channels, belt_speed=0.01)
    >>> ahead = ss.forecast(ss.Model(rig, friction=law), recording, belt_speed=0.01, horizon=0.5)  # m/s, s
    >>> [*ahead.columns]
    ['t', 'x1', 'x1_low', 'x1_high']
    """
    import pandas as pd  # slow to import

    if isinstance(model, Model):  # `follow` refuses what is none
        belt_speed = written_speed(belt_speed, model.rig, "belt_speed")
        drive_speed = written_speed(drive_speed, model.rig, "drive_speed")
        horizon = written_time(horizon, model.rig, "horizon")
    if isinstance(getattr(model, "rig", None), DrivenSlider):
        must_be("recording", recording, Recording, "load_recording(path, rig) or a case's runs give one")
        for key, one in (("belt_speed", belt_speed), ("drive_speed", drive_speed)):
            if one is not None:
                raise InputError("a driven slider has neither belt nor spring; `drive` moves it", key=key)
        return _of_slider(recording, forecast_driven(model, recording, drive, horizon))
    if drive is not None:
        raise InputError("no force moves this rig; leave it out", key="drive")
    if isinstance(getattr(model, "rig", None), GeneralRig):
        must_be("recording", recording, Recording, "load_recording(path, rig) or a case's runs give one")
        given = {"belt_speed": belt_speed, "drive_speed": drive_speed}
        speeds = {key: Speed.of(one, key) for key, one in given.items() if one is not None}
        return forecast_bodies(model, recording, speeds, horizon)
    if drive_speed is not None:
        raise InputError("nothing is pulled by a drive in this rig; leave it out", key="drive_speed")
    if belt_speed is None:
        raise CallError("lacks belt_speed; it needs model, recording, belt_speed, horizon", key="forecast")
    expected = follow(model, recording, belt_speed, horizon)  # type: ignore[arg-type]  # it looks
    found = _of_block(expected) if isinstance(model.rig, BlockOnBelt) else _of_rig(expected)
    # what windows tell begins where the last one ends
    doubts = (expected.wrong,) if found is not None else (expected.wrong, expected.far, NOISE_ALONE)
    if said := [one for one in doubts if one]:
        warnings.warn("; ".join(said), ModelWarning, stacklevel=3)
    mean, low, high = _band(expected, found)
    columns = dict(zip(expected.channels, mean.T, strict=True))
    channel_of = {f"{name}{side}": name for name in expected.channels for side in ("", "_low", "_high")}
    for i, name in enumerate(expected.channels):
        columns |= {f"{name}_low": low[:, i], f"{name}_high": high[:, i]}
    t = expected.t + float(recording.t[0])
    return pd.DataFrame(
        {"t": t / recording.factor("t")}
        | {n: _in_units(recording, channel_of[n], v) for n, v in columns.items()}
    )


def _of_slider(recording: Recording, found: DrivenForecast) -> pd.DataFrame:
    """A forecast of a driven slider in the recording's own units."""
    import pandas as pd  # slow to import

    columns = {"x1": found.mean, "x1_low": found.low, "x1_high": found.high}
    per = recording.factor("x1")
    return pd.DataFrame(
        {"t": found.t / recording.factor("t")} | {name: one / per for name, one in columns.items()}
    )


def _in_units(recording: Recording, channel: str, values: Floats) -> Floats:
    """Readings of a channel, or a limit of them, in the recording's own units."""
    if isinstance(recording.rig, BlockOnBelt):
        return np.asarray(values / recording.factor("x1"))
    return np.asarray(recording.to_readings(channel, values))


def _band(expected: Expected, found: Distribution | None) -> tuple[Floats, Floats, Floats]:
    """Expected readings and the 95 % band, (n, c) each, in model units; around the model's own run it is the noise."""
    count = expected.readings.shape[1]
    if found is not None:
        return found.mean[:, :count], found.low[:, :count], found.high[:, :count]
    half = SIGMAS_95 * prepare([expected.past])[0].noise[:count]
    return expected.readings, expected.readings - half, expected.readings + half


def _of_rig(expected: Expected) -> Distribution | None:
    """The distribution on the rig of (2.1)."""
    return distribution(expected.model, prepare([expected.past])[0], RigSensors(), expected.t)


def _of_block(expected: Expected) -> Distribution | None:
    """The distribution of a block on a belt, simulated in scaled numbers."""
    past, model = expected.past, expected.model
    if not isinstance(model.rig, BlockOnBelt) or past.belt_speed == 0:
        return None
    if not all(isinstance(one, (Effect, FormulaEffect)) for one in model.effects):
        return None
    units = scaled(model.rig, [past])
    own = Model(
        units.block(),
        friction=units.law(model.friction),
        effects=tuple(
            units.effect(one, back=False) for one in model.effects if isinstance(one, (Effect, FormulaEffect))
        ),
        scatter=model.scatter,
    )
    force = past.channel("x1") == "spring_force"
    sensors = BlockSensors((f"gain.{past.channel('x1')}",), own.parameters["stiffness"] if force else None)
    run = prepare([units.run(past)])[0]
    found = distribution(own, run, sensors, expected.t * units.scales.omega)
    if found is None:
        return None
    length = units.scales.length
    return replace(found, mean=found.mean * length, low=found.low * length, high=found.high * length)
