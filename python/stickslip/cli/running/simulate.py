"""What is done by `stickslip simulate`: one run of a model, in the units of its readings."""

from __future__ import annotations

import sys
import warnings
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from rich.console import Console

from stickslip.cli.drive import is_record, read_drive
from stickslip.cli.printed import console, say_lines, say_written
from stickslip.cli.simulate_rig import Asked, is_file, read_speed, simulate_rig
from stickslip.declared.model import Model, load_model, model_file
from stickslip.declared.rig import DrivenSlider
from stickslip.declared.rigs.general import GeneralRig
from stickslip.declared.scale import Quantity, Scale, read_quantity, scales
from stickslip.declared.speeds import Speed
from stickslip.errors import InputError, ModelWarning
from stickslip.files import chosen, with_figure, write_csv
from stickslip.fitted.identify_windows import natural_period
from stickslip.measured.fit_window import Array
from stickslip.simulated.simulate import simulate as run_model
from stickslip.simulated.trajectory import Trajectory

FEW = 5  # rows a transition, below which the CSV does not show the motion
DRAWN = 120  # points a natural period in the figure: what is drawn must be a curve, whatever the CSV's step
MANY = 4001  # points in the figure of what has no period
LONGEST = 1000  # natural periods in the figure


def perform(model: Path, force: bool, **given: Any) -> None:
    """Do what `stickslip simulate` is asked for."""
    asked = Asked(**given)
    speeds = {"--belt-speed": asked.belt_speed, "--drive-speed": asked.drive_speed}
    files = {key: Path(text) for key, text in speeds.items() if text is not None and is_file(text)}
    if asked.drive is not None and is_record(asked.drive):
        files["--drive"] = Path(asked.drive)
    inputs = {"MODEL": model_file(model), **files}
    with chosen(with_figure(asked.out, asked.figure), inputs, force=force):
        loaded = load_model(model)
        of_bodies = isinstance(loaded.rig, GeneralRig)
        status = simulate_rig(loaded, asked) if of_bodies else _of_named_rig(loaded, asked)
    if status:
        sys.exit(status)


def _of_named_rig(loaded: Model, asked: Asked) -> int:
    """Simulate and write, as the command does; return its exit status."""
    if asked.sensors:
        raise InputError("is for rigs of bodies or matrices; leave it out", key="--sensors")
    units = scales(loaded.rig, loaded.channels)
    if asked.drive_speed is not None:
        raise InputError("nothing is pulled by a drive in this rig; leave it out", key="--drive-speed")
    drive = read_drive(asked.drive, loaded)
    if drive is None:
        v_b: float | Speed | None = (own := _belt(asked, units, loaded))
        how = f"belt speed {_told(units, own)}"
    else:
        if asked.belt_speed is not None:
            raise InputError("a driven slider has no belt; leave it out", key="--belt-speed")
        v_b, how = None, f"drive {drive.text} (N)"
    times = asked.times(lambda text, key: read_quantity(text, "t", units["t"], loaded.rig, key))
    start = None if asked.initial is None else _start(loaded, units, asked.initial)
    _say_understood(loaded, units, how, times, start)
    drawn = _drawn(loaded, times) if asked.figure else times[:0]
    with warnings.catch_warnings(record=True) as doubts:
        warnings.simplefilter("always", ModelWarning)
        with Console(stderr=True).status("simulating"):  # on a terminal alone
            run = run_model(
                loaded,
                belt_speed=v_b,
                drive=drive,
                initial=start,
                t_end=float(times[-1]),
                t_eval=np.union1d(times, drawn),
            )
    said = [str(doubt.message) for doubt in doubts]
    say_lines([*said, *_sparse(run, times, units["t"])])
    written = [asked.out]
    kept = _at(run, times)
    _write(loaded, units, kept, asked.out)
    if asked.figure:
        from stickslip.shown.plot import curves as plot

        seen = _at(run, drawn)
        seen = seen if len(seen.t) else kept  # it ended before the stretch to be drawn
        speed = float(v_b(0.0)) if isinstance(v_b, Speed) else v_b
        shown = plot.trajectory(seen, loaded.rig.state_names, belt_speed=speed, units=units)
        written += plot.save_figure(shown, asked.out.with_suffix(""))
    console.print(
        f"{run.status}: {len(run.transitions)} transitions, stick fraction {np.mean(kept.mode == 0):.4g}"
    )
    say_written(written)
    return 0 if run.status.ok else 1


def _belt(asked: Asked, units: dict[Quantity, Scale], model: Model) -> float | Speed:
    if asked.belt_speed is None:
        raise InputError("missing: the rig has a belt; give its speed, like '14 mm/s'", key="--belt-speed")
    return read_speed(asked.belt_speed, units["t"], units["belt"], model.rig)


def _told(units: dict[Quantity, Scale], v_b: float | Speed) -> str:
    """What was understood of the belt's speed."""
    if isinstance(v_b, Speed):
        return v_b.text
    own = "" if units["belt"].size == 1 else f" ({v_b:.5g} in the model)"
    return f"{units['belt'].of(v_b)}{own}"


def _sparse(run: Trajectory, times: Array, unit: Scale) -> list[str]:
    """What to say where the rows are too far apart to show the motion."""
    changes = run.transitions.t
    if len(changes) < 3 or len(times) > FEW * len(changes):
        return []
    apart = float(changes[-1] - changes[0]) / (len(changes) - 1)
    return [
        f"the rows are {unit.of(times[1] - times[0])} apart and the contact changes every {unit.of(apart)} on average: "
        f"the CSV does not show the motion; --dt '{unit.of(apart / 20, 2)}' would"
    ]


def _drawn(model: Model, times: Array) -> Array:
    """Times to draw at: those of the CSV if they are dense enough, or as many as a curve needs."""
    if isinstance(model.rig, DrivenSlider):  # it has no period of its own
        return np.union1d(times, np.linspace(0.0, float(times[-1]), MANY))
    period, end = natural_period(model.rig), float(times[-1])
    begin = max(0.0, end - LONGEST * period)
    if np.diff(times).max() <= period / DRAWN:
        return np.asarray(times[times >= begin])
    return np.linspace(begin, end, 2 + int((end - begin) / period * DRAWN))


def _at(run: Trajectory, times: Array) -> Trajectory:
    """Return the run at those of its samples that are at `times`."""
    here = np.isin(run.t, times)
    read = {name: one[here] for name, one in run.readings.items()}
    return replace(run, t=run.t[here], state=run.state[here], mode=run.mode[here], readings=read)


def _start(model: Model, units: dict[Quantity, Scale], text: str) -> list[float]:
    names: tuple[Quantity, ...] = model.rig.state_names  # type: ignore[assignment]  # they are quantities
    parts = text.split(",")
    if len(parts) != len(names):
        words = f"has {len(parts)} numbers; give {len(names)}: {','.join(names)}, like {','.join('0' for _ in names)}"
        raise InputError(words, key="--initial", value=text)
    return [
        read_quantity(part, name, units[name], model.rig, f"--initial, {name}")
        for part, name in zip(parts, names, strict=True)
    ]


def _say_understood(
    model: Model, units: dict[Quantity, Scale], how: str, times: Array, start: list[float] | None
) -> None:
    """Print what was understood of the numbers, in their units."""
    at = "rest at the origin"
    if start is not None:
        names: tuple[Quantity, ...] = model.rig.state_names  # type: ignore[assignment]
        at = ", ".join(f"{name} = {units[name].of(x)}" for name, x in zip(names, start, strict=True))
    console.print(
        f"{how}; from {at}; to t = {units['t'].of(times[-1])} in steps of "
        f"{units['t'].of(times[1] - times[0])}",
        soft_wrap=True,
    )


def _write(model: Model, units: dict[Quantity, Scale], run: Trajectory, out: Path) -> None:
    import pandas as pd  # slow to import

    names: tuple[Quantity, ...] = model.rig.state_names  # type: ignore[assignment]
    columns = {units["t"].head("t"): run.t * units["t"].size}
    columns |= {units[n].head(n): run.state[:, i] * units[n].size for i, n in enumerate(names)}
    read: dict[Quantity, Array] = run.read_otherwise  # type: ignore[assignment]  # channels are quantities
    columns |= {units[n].head(f"{n}_read"): one * units[n].size for n, one in read.items()}
    write_csv(pd.DataFrame({**columns, "mode": run.mode}), out, 12)
