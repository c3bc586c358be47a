"""What is done by `stickslip forecast`: the readings that follow a recording."""

from __future__ import annotations

import warnings
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from stickslip.cli.drive import is_record, read_drive
from stickslip.cli.printed import console, say_lines, say_written
from stickslip.declared.model import Model, load_model, model_file
from stickslip.declared.quantity import sized, with_unit
from stickslip.declared.rig import DrivenSlider, Rig
from stickslip.declared.rigs.general import GeneralRig
from stickslip.declared.scale import read_quantity, scales
from stickslip.declared.units import Channel
from stickslip.errors import InputError, ModelWarning, Place
from stickslip.files import chosen, time_digits, with_figure, write_csv
from stickslip.fitted.forecast import MOST
from stickslip.likelihoods.forecast import forecast as run_forecast
from stickslip.measured.channels import head_of
from stickslip.measured.readers.tables import open_table
from stickslip.measured.recording import Recording, load_recording

if TYPE_CHECKING:
    import pandas as pd


def perform(
    model: Path,
    run: Path,
    moved_by: tuple[str | None, str | None, str | None],
    horizon: str,
    out: Path,
    figure: bool,
    force: bool,
) -> None:
    """Do what `stickslip forecast` is asked for; `moved_by` are the belt's speed, the drive's, and its force."""
    belt_speed, drive_speed, drive = moved_by
    inputs = {"MODEL": model_file(model), "RUN": run}
    if drive is not None and is_record(drive):
        inputs["--drive"] = Path(drive)
    with chosen(with_figure(out, figure), inputs, force=force):
        loaded = load_model(model)
        if loaded.channels is None and isinstance(loaded.rig, Rig) and loaded.rig.scales is not None:
            words = "the rig is in SI and the units of the readings are not given; add [channels]"
            raise InputError(f"{words}, as in rig.toml", place=Place(str(model)))
        if isinstance(loaded.rig, DrivenSlider):
            say_written(_of_slider(loaded, run, moved_by, horizon, out, figure))
            return
        read_drive(drive, loaded)
        of_rig = _of_bodies if isinstance(loaded.rig, GeneralRig) else _of_named_rig
        say_written(of_rig(loaded, run, belt_speed, drive_speed, horizon, out, figure))


def _of_named_rig(
    loaded: Model,
    run: Path,
    belt_speed: str | None,
    drive_speed: str | None,
    horizon: str,
    out: Path,
    figure: bool,
) -> list[Path]:
    """The forecast of a rig of (2.1) or a block on a belt, written; the files."""
    if drive_speed is not None:
        raise InputError("nothing is pulled by a drive in this rig; leave it out", key="--drive-speed")
    if belt_speed is None:
        raise InputError("missing: the belt's speed; give one like '12 mm/s'", key="--belt-speed")
    units = scales(loaded.rig, loaded.channels)
    v_b = read_quantity(belt_speed, "belt", units["belt"], loaded.rig, "--belt-speed")
    ahead = read_quantity(horizon, "t", units["t"], loaded.rig, "--horizon")
    if ahead <= 0:
        raise InputError("must be a finite number above 0", key="--horizon", value=horizon)
    channels, noise = _recorded(loaded, run)
    set_point = f"{v_b * units['belt'].size!r} {units['belt'].unit}"  # a belt left out takes its unit along
    past = load_recording(run, loaded.rig, channels=channels, belt_speed=set_point, noise=noise)
    step = float(np.median(np.diff(past.t)))
    if ahead < step * (1 - 1e-9):
        words = f"shorter than the run's sampling interval {units['t'].of(step)}"
        raise InputError(words, key="--horizon", value=horizon)
    if ahead > MOST * step:
        words = (
            f"{ahead / step:.3g} samples; {MOST} are the most, {units['t'].of(MOST * step, 4)} of this run"
        )
        raise InputError(words, key="--horizon", value=horizon)
    with warnings.catch_warnings(record=True) as doubts:
        warnings.simplefilter("always", ModelWarning)
        frame = run_forecast(loaded, past, belt_speed=v_b, horizon=ahead)
    write_csv(frame, out, 10)
    written = [out]
    if figure:
        from stickslip.shown.plot import curves as plot

        written += plot.save_figure(plot.forecast(past, frame), out.with_suffix(""))
    say_lines(str(doubt.message) for doubt in doubts)
    t, own = units["t"].unit, "" if units["belt"].size == 1 else f" ({v_b:.5g} in the model)"
    digits = time_digits(frame["t"], 6, finer=1.0)
    first, last = (f"{x:.{digits}g}" for x in (frame["t"].iloc[0], frame["t"].iloc[-1]))
    console.print(
        f"belt speed {units['belt'].of(v_b)}{own}; {len(frame)} samples, t = {first} to {last}"
        f"{'' if t == '1' else f' {t}'}; "
        + ", ".join(_column(past, str(name)) for name in frame if name in past.channels and name != "t"),
        markup=False,
        soft_wrap=True,
    )
    return written


def _of_slider(
    model: Model,
    run: Path,
    moved_by: tuple[str | None, str | None, str | None],
    horizon: str,
    out: Path,
    figure: bool,
) -> list[Path]:
    """The forecast of a driven slider, written; the files."""
    if moved_by[2] is None:
        read_drive(None, model)  # says what is missing
    for key, one in zip(("--belt-speed", "--drive-speed"), moved_by, strict=False):
        if one is not None:
            raise InputError("a driven slider has neither belt nor spring; leave it out", key=key)
    channels, noise = _recorded(model, run)
    past = load_recording(run, model.rig, channels=channels, noise=noise)
    ahead = sized(horizon, "s", "--horizon") * (1.0 if with_unit(horizon)[1] else past.factors["t"])
    drive = read_drive(moved_by[2], model, float(past.t[-1]))
    return _told(past, run_forecast(model, past, drive=drive, horizon=ahead), out, figure)


def _of_bodies(
    model: Model,
    run: Path,
    belt_speed: str | None,
    drive_speed: str | None,
    horizon: str,
    out: Path,
    figure: bool,
) -> list[Path]:
    """The forecast of a rig of bodies or matrices, written; the files."""
    channels, noise = _recorded(model, run)
    past = load_recording(
        run, model.rig, channels=channels, belt_speed=belt_speed or 0.0, drive_speed=drive_speed, noise=noise
    )
    per_unit = past.factors["t"]
    ahead = sized(horizon, "s", "--horizon") * (1.0 if with_unit(horizon)[1] else per_unit)
    with warnings.catch_warnings(record=True) as doubts:
        warnings.simplefilter("always", ModelWarning)
        frame = run_forecast(model, past, horizon=ahead)
    say_lines(str(doubt.message) for doubt in doubts)
    return _told(past, frame, out, figure)


def _told(past: Recording, frame: pd.DataFrame, out: Path, figure: bool) -> list[Path]:
    """Write a forecast, and say what is in it."""
    write_csv(frame, out, 10)
    written = [out]
    if figure:
        from stickslip.shown.plot import curves as plot

        written += plot.save_figure(plot.forecast(past, frame), out.with_suffix(""))
    names = [str(name) for name in frame if name in past.channels and name != "t"]
    console.print(f"{len(frame)} samples; " + ", ".join(_column(past, name) for name in names), markup=False)
    return written


def _column(past: Recording, name: str) -> str:
    """A column and its unit; where the column is a multiple of it, what 1 in it is."""
    channel = past.channels[name]
    if channel.scale != 1:
        return f"{name} [{channel.scale:.4g} {channel.unit}]"
    return name if channel.unit == "1" else f"{name} [{channel.unit}]"


def _recorded(model: Model, run: Path) -> tuple[dict[str, Channel] | None, dict[str, float]]:
    """The model's channels and noise, without those of a belt that this run did not record."""
    channels = None if model.channels is None else dict(model.channels)
    noise = dict(model.noise or {})
    column = channels["belt"].column if channels and "belt" in channels else "belt"
    others = [] if channels is None else [one.column for name, one in channels.items() if name != "belt"]
    if head_of(column, open_table(run, others).contents) is None:
        noise.pop("belt", None)
        if channels is not None:
            channels.pop("belt", None)
    return channels, noise
