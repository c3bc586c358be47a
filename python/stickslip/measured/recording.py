"""A recording: channels in the model's numbers and as they were read, with what is odd about them."""

from __future__ import annotations

import math
import os
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Literal, get_args

import numpy as np
from numpy.typing import ArrayLike, NDArray

from stickslip.arguments import explained, must_be
from stickslip.arguments import path as as_path
from stickslip.declared.friction_law import FrictionLaw
from stickslip.declared.law_dimensions import in_model
from stickslip.declared.prescribed import Given
from stickslip.declared.rig import AnyRig, BlockOnBelt, DrivenSlider, Rig
from stickslip.declared.rigs.general import GeneralRig
from stickslip.declared.scale import scales
from stickslip.declared.speeds import Speed
from stickslip.declared.units import Channel, factor, is_electric
from stickslip.errors import InputError, did_you_mean
from stickslip.measured.channels import (
    bare_channels,
    by_heads,
    by_place,
    channel_factor,
    check_channels,
    noise_in_model,
)
from stickslip.measured.check_recording import check_belt, check_gaps, check_times, cut
from stickslip.measured.findings import (
    Finding,
    FindingKind,
    belt_findings,
    channel_findings,
    drive_findings,
    size_findings,
    time_findings,
)
from stickslip.measured.prescribed import constant, prescribed, set_point_of, taken_from
from stickslip.measured.readers.tables import Held, open_table
from stickslip.measured.stick_speed import wrong_set_point
from stickslip.objects import Sampled, one_line

Floats = NDArray[np.float64]
Role = Literal["train", "validate"]


@dataclass(frozen=True, eq=False, repr=False)
class Recording(Sampled):
    """One recorded run of a rig.

    Arrays are the model's numbers: nondimensional for a `Rig`, SI (m, s) for a `BlockOnBelt` declared in SI.
    A recorded spring force appears as the deflection x1 = force/stiffness. Times are those of the file, which
    need not start at 0.

    Attributes
    ----------
    name
        Name of the run.
    role
        "train" or "validate".
    rig
        The rig it was recorded on, the run's overrides included.
    belt_speed
        Set-point.
    t, x1
        Times, increasing but not always regular, and block displacement (n,).
    y1, belt
        Leg displacement and measured belt speed (n,), None if not recorded.
    raw
        Columns by channel (n,), as in the file.
    channels
        Column, unit and scale by channel.
    factors
        The model's number for 1 in the column, by channel.
    noise
        Standard deviation by channel ("x1", "y1", "belt") in the model's numbers; unknown ones are missing.
    source
        The file.
    findings
        What is odd: gaps, clipping, quantisation, ...
    drive
        Force of the drive on a `DrivenSlider` (n,), held from each sample to the next; None on other rigs.
    averaged
        How many readings each sample is the mean of, at the mean of their times (`stickslip.measured.thinning`).
    coordinates
        Of a rig of bodies or matrices, every reading and prescribed speed recorded (n,), in SI; `x1` is the first of
        them.
    speeds
        Of such a rig, what is prescribed: "belt_speed", "drive_speed". `belt_speed` is NaN where it is no number.
    taken
        Channels that such speeds were taken from ("belt", "drive"); they are no readings beside them.

    Examples
    --------
    >>> import numpy as np
    >>> import stickslip as ss
    >>> t = np.arange(0, 6, 0.002)
    >>> channels = {"t": ss.Channel("t", "s"), "x1": ss.Channel("x1", "mm")}
    >>> rig = ss.BlockOnBelt(mass=0.5, stiffness=500)
    >>> run = ss.load_recording({"t": t, "x1": np.sin(t)}, rig, channels=channels, belt_speed="5 mm/s")
    >>> print(f"{run.x1.max():.4f} m in the model, {run.raw['x1'].max():.1f} mm in the column")
    0.0010 m in the model, 1.0 mm in the column
    """

    name: str
    role: Role
    rig: AnyRig
    belt_speed: float
    t: Floats
    x1: Floats
    y1: Floats | None
    belt: Floats | None
    raw: Mapping[str, Floats] = field(repr=False)
    channels: Mapping[str, Channel] = field(repr=False)
    factors: Mapping[str, float] = field(repr=False)
    noise: Mapping[str, float]
    source: Path
    findings: tuple[Finding, ...] = ()
    drive: Floats | None = None
    averaged: int = 1
    coordinates: Mapping[str, Floats] = field(default_factory=dict, repr=False)
    speeds: Mapping[str, Speed] = field(default_factory=dict, repr=False)
    taken: tuple[str, ...] = ()

    def __len__(self) -> int:
        return self.t.size

    def __repr__(self) -> str:
        if isinstance(self.rig, GeneralRig):
            told = ", ".join(f"{name} {one.text}" for name, one in self.speeds.items())
            read = ", ".join(self.coordinates)
            return (
                f"<Recording '{self.name}' ({self.role}): {read}, {len(self)} samples{told and f'; {told}'}>"
            )
        units = scales(self.rig, self.channels)
        names = ", ".join(
            f"{n} [{c.unit}]" if c.unit != "1" else n for n, c in self.channels.items() if n != "t"
        )
        span = units["t"].of(float(self.t[-1] - self.t[0])) if len(self) else "nothing"
        odd = f"; {len(self.findings)} findings" if self.findings else ""
        return one_line(
            f"<Recording '{self.name}' ({self.role}): {names}, {len(self)} samples over {span}, "
            f"belt speed {units['belt'].of(self.belt_speed)}{odd}>"
        )

    def channel(self, name: str) -> str:
        """Return the channel that records a quantity: "spring_force" may stand for "x1".

        Raises
        ------
        InputError
            It is not recorded.
        """
        if name in self.channels:
            return name
        if name == "x1" and "spring_force" in self.channels:
            return "spring_force"
        raise InputError(f"{self.name} has no channel '{name}'; {did_you_mean(name, self.channels)}")

    def unit(self, name: str) -> str:
        """Return the unit of a channel's column, its scale applied."""
        return self.channels[self.channel(name)].unit

    def factor(self, name: str) -> float:
        """Return the model's number for 1 in the channel's column."""
        return self.factors[self.channel(name)]

    def offset(self, name: str) -> float:
        """Return what a channel's column reads too little, in the model's numbers."""
        one = self.channels[self.channel(name)]
        return one.offset * self.factor(name) / one.scale if one.offset else 0.0

    def to_readings(self, name: str, values: ArrayLike) -> Floats:
        """Turn the model's numbers of a channel into numbers of its column."""
        return (np.asarray(values, dtype=np.float64) - self.offset(name)) / self.factor(name)

    def from_readings(self, name: str, values: ArrayLike) -> Floats:
        """Turn numbers of a channel's column into the model's."""
        return np.asarray(values, dtype=np.float64) * self.factor(name) + self.offset(name)

    def window(self, start: float, end: float) -> Recording:
        """Return the samples with start <= t < end (the model's time); findings are those of the whole.

        Raises
        ------
        InputError
            No sample lies there.
        """
        kept = (self.t >= start) & (self.t < end)
        if not kept.any():
            words = f"holds no samples; the run lasts from {self.t[0]:g} to {self.t[-1]:g}"
            raise InputError(f"{self.name}: the window {start:g} to {end:g} {words}")
        return replace(
            self,
            t=self.t[kept],
            x1=self.x1[kept],
            y1=None if self.y1 is None else self.y1[kept],
            belt=None if self.belt is None else self.belt[kept],
            drive=None if self.drive is None else self.drive[kept],
            raw={name: column[kept] for name, column in self.raw.items()},
            coordinates={name: column[kept] for name, column in self.coordinates.items()},
            speeds=self.since(float(self.t[kept][0])),
        )

    def since(self, start: float) -> dict[str, Speed]:
        """Return what is prescribed by the clock of a run whose first sample is at the time `start`."""
        return {key: one.since(start - float(self.t[0])) for key, one in self.speeds.items()}


@explained
def load_recording(
    source: str | os.PathLike[str] | Mapping[str, ArrayLike],
    rig: AnyRig,
    *,
    channels: Mapping[str, Channel] | None = None,
    belt_speed: Given | None = None,
    drive_speed: Given | None = None,
    role: Role = "train",
    noise: Mapping[str, float] | None = None,
    window: tuple[float | None, float | None] = (None, None),
    name: str | None = None,
    friction: FrictionLaw | None = None,
) -> Recording:
    """Read one run from a file, or take it from columns in memory.

    Parameters
    ----------
    source
        The file; or the columns (n,) by name, as a dict of arrays or a data frame has them.
    rig
        On which it was recorded.
    channels
        Column, unit and scale for t, x1, y1 and, if recorded, belt; a `BlockOnBelt` has t and x1 or
        spring_force; a rig of bodies or matrices coordinates by their names, velocities `v_NAME`, accelerations
        `a_NAME`, forces in links `F_link_1` and friction at contacts `T_NAME`. None: columns of these names,
        nondimensional.
    belt_speed
        Set-point in the unit of the belt channel; without one, m/s for an SI rig and nondimensional
        otherwise. Text may carry a unit ("1100 um/s"). For a rig of bodies or matrices also a formula of t in SI, t
        from the first sample; a `Speed`; steps, a dict of `from` and `value` each; or "measured": what the belt channel
        reads, smoothed. None: 0, where no belt is recorded.
    drive_speed
        The same of the drive of such a rig.
    role
        "train" or "validate".
    noise
        Standard deviation by channel, in the unit of its column.
    window
        First and last time to keep, start <= t < end, in the unit of t; None: open.
    name
        Name of the run; None: that of the file, or "recording".
    friction
        Declared law; readings of a size it cannot explain are then found.

    Returns
    -------
    Recording
        In the model's numbers, with what is odd about it in `findings`.

    Raises
    ------
    InputError
        The file, a column or a cell is wrong (with line and column); a unit is not one of its channel; times
        do not increase; fewer than 8 samples; a recorded belt that never moves though its set-point is not 0.

    Examples
    --------
    >>> import numpy as np
    >>> import stickslip as ss
    >>> t = np.arange(0, 6, 0.002)
    >>> x = np.abs((10 * t) % 1 - 0.5)  # mm
    >>> rig = ss.BlockOnBelt(mass=0.5, stiffness=500)
    >>> channels = {"t": ss.Channel("time", "s"), "x1": ss.Channel("deflection", "mm")}
    >>> run = ss.load_recording({"time": t, "deflection": x}, rig, channels=channels, belt_speed="5 mm/s")
    >>> print(f"{len(run)} samples, x1 up to {run.x1.max():.4f} m")
    3000 samples, x1 up to 0.0005 m
    """
    must_be("rig", rig, (Rig, BlockOnBelt, DrivenSlider, GeneralRig))
    if role not in get_args(Role):
        raise InputError("must be 'train' or 'validate'", key="role", value=role)
    table: Held | Path
    if hasattr(source, "keys"):
        held = dict(source)  # type: ignore[arg-type]  # a data frame is no Mapping
        for strange in (one for one in held if not isinstance(one, str)):
            words = "columns are asked for by text; rename them, like frame.rename(columns=str)"
            raise InputError(f"a column is named {strange!r}; {words}", key="source")
        table = Held(name or "recording", held)
    else:
        table = as_path("source", source)
    declared = _channels(channels) if channels is not None else bare_channels(table, rig)
    check_channels(declared, rig)
    opened = open_table(table, [channel.column for channel in declared.values()])
    declared, taken = by_place(opened.contents, declared, os.fspath(table))
    declared, doubts = by_heads(opened, declared, os.fspath(table))
    units = {channel.column: channel.unit for channel in declared.values()}
    columns = opened.read(list(units), units)
    factors = {one: channel_factor(one, channel, rig) for one, channel in declared.items()}
    raw = {one: columns.values[channel.column] for one, channel in declared.items()}
    check_times(columns, declared, raw)
    raw = cut(columns, declared, raw, window)
    check_gaps(columns, declared, raw)
    position = _position(rig, declared)
    model = {one: _in_model(column, declared[one], factors[one]) for one, column in raw.items()}
    sizes = noise_in_model(noise or {}, declared, rig)
    sizes = {one: size / math.sqrt(columns.averaged) for one, size in sizes.items()}
    given = 0.0 if belt_speed is None and "belt" not in declared else belt_speed
    speeds = prescribed(rig, declared, given, drive_speed, model, sizes)
    general = isinstance(rig, GeneralRig)
    belt = constant(speeds) if general else set_point_of(rig, declared, 0.0 if given is None else given)
    check_belt(columns, declared, raw, belt)
    recording = Recording(
        name=name or columns.path.stem,
        role=role,
        rig=rig,
        belt_speed=belt,
        t=model["t"],
        x1=model[position],
        y1=model.get("y1"),
        belt=model.get("belt"),
        drive=model.get("drive") if isinstance(rig, DrivenSlider) else None,
        raw=raw,
        channels=declared,
        factors=factors,
        noise=sizes,
        source=columns.path,
        averaged=columns.averaged,
        coordinates={k: x for k, x in model.items() if k != "t"} if isinstance(rig, GeneralRig) else {},
        speeds=speeds,
        taken=taken_from(rig, given, drive_speed),
    )
    said = [*opened.contents.doubts, *columns.doubts, *taken, *doubts]
    guessed = [Finding(FindingKind.GUESSED, "t", f"file: {words}") for words in said]
    law = None if friction is None else in_model(friction, rig)
    return replace(recording, findings=(*guessed, *_findings(recording, law)))


def _in_model(column: Floats, channel: Channel, per_unit: float) -> Floats:
    """A column in the model's numbers; not copied where it has them."""
    out = column if per_unit == 1 else column * per_unit
    return out + channel.offset * per_unit / channel.scale if channel.offset else out


def _channels(given: object) -> dict[str, Channel]:
    """The channels, each a `Channel`."""
    channels = must_be("channels", given, Mapping, "give a Channel by name")
    for name, one in channels.items():
        like = f"like Channel({str(one)!r}, 'mm')" if isinstance(one, str) else ""
        must_be(f"channels.{name}", one, Channel, like)
    return dict(channels)


def _position(rig: AnyRig, channels: Mapping[str, Channel]) -> str:
    """The channel that is x1."""
    if isinstance(rig, GeneralRig):
        order = [*rig.state_names, *channels]
        return next(name for name in order if name in channels and name != "t")
    return "spring_force" if "spring_force" in channels else "x1"


def _findings(recording: Recording, friction: FrictionLaw | None) -> list[Finding]:
    found = time_findings(_scaled(recording.raw["t"], recording.channels["t"]), recording.unit("t"))
    jumps = np.array([i for finding in found for i in finding.samples], dtype=np.intp)
    for name, channel in recording.channels.items():
        if name == "t":
            continue
        noise = recording.noise.get("x1" if name == "spring_force" else name)
        per_unit = factor(channel.reads or name, channel.unit, recording.rig)
        own = None if noise is None else noise / per_unit
        readings = _scaled(recording.raw[name], channel)
        unit = "N" if name == "drive" and is_electric(channel.unit) else _word(channel.unit)
        found += channel_findings(name, readings, unit, own, jumps)
        if name == "drive" and isinstance(recording.rig, DrivenSlider):
            found += drive_findings(recording.t, recording.x1, readings * per_unit, recording.rig.mass)
        elif name == "belt" and math.isfinite(recording.belt_speed):
            found += belt_findings(readings, recording.belt_speed / per_unit, _word(channel.unit))
        elif friction is not None and name != "y1" and isinstance(recording.rig, Rig | BlockOnBelt):
            rig = recording.rig
            stiffness = rig.stiffness if isinstance(rig, BlockOnBelt) else rig.alpha1
            reach = max(friction.static_limits) / stiffness
            found += size_findings(name, recording.x1, reach, _word(channel.unit), per_unit)
    wrong = None if isinstance(recording.rig, GeneralRig) else wrong_set_point(recording)
    if wrong and not any(one.kind is FindingKind.BELT for one in found):
        found.append(Finding(FindingKind.BELT, "belt", f"belt: {wrong}"))
    return found


def _scaled(column: Floats, channel: Channel) -> Floats:
    """A column in its channel's unit; not copied where it is."""
    return column if channel.scale == 1 else column * channel.scale


def _word(unit: str) -> str:
    return "" if unit == "1" else unit
