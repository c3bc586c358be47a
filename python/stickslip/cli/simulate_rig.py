"""`stickslip simulate` of a rig of bodies or matrices; and a prescribed speed as the command takes it, of any rig."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from stickslip.cli.printed import console, say_written
from stickslip.declared.model import Model
from stickslip.declared.prescribed import formula_of_time
from stickslip.declared.quantity import sized
from stickslip.declared.rig import AnyRig
from stickslip.declared.rigs.general import GeneralRig
from stickslip.declared.scale import Scale, read_quantity
from stickslip.declared.speeds import Speed
from stickslip.declared.toml_file import read_toml
from stickslip.errors import InputError, Place, did_you_mean
from stickslip.files import write_csv
from stickslip.simulated.simulate import simulate
from stickslip.simulated.trajectory import Trajectory

Floats = NDArray[np.float64]
ROWS = 2001  # of the CSV where no step is given
MOST = 50_000_000  # samples


def read_speed(text: str, time: Scale, speed: Scale, rig: AnyRig, key: str = "--belt-speed") -> float | Speed:
    """Return a speed in the model's numbers, of "14 mm/s", of a formula of t, or of a file.

    Parameters
    ----------
    text
        As given. A formula and a file are in the units of `time` and `speed`.
    time, speed
        How the rig's times and the belt's speed are read.
    rig, key
        The rig, and the name of the option.

    Raises
    ------
    InputError
        None of these.
    """
    given = prescribed(text, key)
    if given is None:
        return read_quantity(text, "belt", speed, rig, key)
    return given.scaled(time.size, 1 / speed.size)


def is_file(text: str) -> bool:
    """Say whether a speed is given by a file."""
    return Path(text).suffix.lower() in (".toml", ".csv")


def prescribed(text: str, key: str) -> Speed | None:
    """Return the speed that a formula of t or a file tells of; None for what should be a number with a unit."""
    if is_file(text):
        return _steps(text) if Path(text).suffix.lower() == ".toml" else _measured(text, key)
    return formula_of_time(text, key)


def _steps(text: str) -> Speed:
    document = read_toml(text)
    tables = document.tables.get("speed")
    if not isinstance(tables, list) or not tables or set(document.tables) != {"speed"}:
        raise InputError("must be tables [[speed]] with from and value", place=Place(text))
    for i, one in enumerate(tables):
        for name in ("from", "value"):
            if name not in one:
                raise document.error(f"lacks '{name}'; a step is from = 2.0, value = 0.1", "speed", i)
        for name in one:
            if name not in ("from", "value"):
                raise document.error(f"unknown; {did_you_mean(name, ('from', 'value'))}", "speed", i, name)
    with document.at("speed"):
        return Speed.steps([one["from"] for one in tables], [one["value"] for one in tables], "value")


def _measured(text: str, key: str) -> Speed:
    from stickslip.measured.readers.tables import read_columns

    name = "drive" if key == "--drive-speed" else "belt"
    values = read_columns(text, ("t", name)).values
    return Speed.measured(values["t"], values[name], key)


@dataclass(frozen=True)
class Asked:
    """What the command is asked for, as it was typed."""

    belt_speed: str | None
    drive_speed: str | None
    drive: str | None
    t_end: str
    dt: str | None
    initial: str | None
    out: Path
    sensors: bool
    figure: bool

    def times(self, read: Callable[[str, str], float]) -> Floats:
        """Times to sample at, from 0 to the end, which is there even off the step.

        Parameters
        ----------
        read
            A time in the model's number, of its text and the option's name.
        """
        end = read(self.t_end, "--t-end")
        if end <= 0:
            raise InputError("must be above 0", key="--t-end", value=self.t_end)
        if self.dt is None:
            return np.linspace(0.0, end, ROWS)
        step = read(self.dt, "--dt")
        if not 0 < step <= end:
            raise InputError(f"must be above 0 and at most --t-end = {self.t_end}", key="--dt", value=self.dt)
        count = int(end / step * (1 + 1e-12)) + 1
        if count > MOST:
            raise InputError(f"gives {count} samples; 50 million is the most", key="--dt", value=self.dt)
        times: Floats = np.asarray(np.arange(count) * step, dtype=np.float64)
        return np.append(times, end) if end - times[-1] > 1e-9 * step else times


def simulate_rig(model: Model, asked: Asked) -> int:
    """Simulate and write, as the command does; return its exit status."""
    rig = model.rig
    assert isinstance(rig, GeneralRig)
    own = rig.equations
    times = asked.times(lambda text, key: sized(text, "s", key))
    speeds = {
        "belt_speed": _speed(asked.belt_speed, own.belt_unit, "--belt-speed"),
        "drive_speed": _speed(asked.drive_speed, own.drive_unit, "--drive-speed"),
    }
    start = None if asked.initial is None else _start(rig, asked.initial)
    run = simulate(model, **speeds, initial=start, t_end=float(times[-1]), t_eval=times)  # type: ignore[arg-type]
    _write(rig, run, asked.out, asked.sensors)
    written = [asked.out]
    if asked.figure:
        from stickslip.shown.plot import bodies
        from stickslip.shown.plot.curves import save_figure

        written += save_figure(bodies.coordinates(run, rig), asked.out.with_suffix(""))
    sticks = ", ".join(
        f"{name} {np.mean(mode == 0):.4g}" for name, mode in zip(run.contact_names, run.mode.T, strict=True)
    )
    console.print(
        f"{run.status}: {len(run.transitions)} transitions, stick fraction: {sticks}", soft_wrap=True
    )
    say_written(written)
    return 0 if run.status.ok else 1


def _speed(text: str | None, unit: str, key: str) -> float | Speed | None:
    if text is None:
        return None
    given = prescribed(text, key)
    return sized(text, unit, key) if given is None else given


def _start(rig: GeneralRig, text: str) -> list[float]:
    own, parts = rig.equations, text.split(",")
    units = [*own.units, *("1" if one == "1" else f"{one}/s" for one in own.units)]
    every = [
        *rig.state_names,
        *(f"state {i + 1} of the laws" for i in range(len(parts) - len(rig.state_names))),
    ]
    units += ["1"] * (len(every) - len(units))
    if len(parts) < len(rig.state_names):
        words = f"has {len(parts)} numbers; give {len(rig.state_names)}: {','.join(rig.state_names)}"
        raise InputError(words, key="--initial", value=text)
    return [
        sized(part.strip(), unit, f"--initial, {name}")
        for part, name, unit in zip(parts, every, units, strict=True)
    ]


def _write(rig: GeneralRig, run: Trajectory, out: Path, sensors: bool) -> None:
    import pandas as pd  # slow to import

    own = rig.equations
    units = [*own.units, *("1" if one == "1" else f"{one}/s" for one in own.units)]
    heads = [Scale(1.0, unit).head(name) for name, unit in zip(rig.state_names, units, strict=True)]
    time = "t" if set(own.units) == {"1"} else "t [s]"
    known = {**dict(zip(rig.state_names, units, strict=True)), **own.sensed}
    read = {
        Scale(1.0, known.get(name, "1")).head(f"{name}_read"): one for name, one in run.read_otherwise.items()
    }
    columns = {time: run.t, **dict(zip(heads, run.state.T, strict=True)), **run.hidden, **read, **run.modes}
    if sensors:
        columns |= {Scale(1.0, unit).head(name): run.sensed[name] for name, unit in own.sensed.items()}
    write_csv(pd.DataFrame(columns), out, 12)
