"""A first rig.toml for recorded files: what they say, what they only hint at, and what must be asked."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from stickslip.declared.quantity import with_unit
from stickslip.declared.rig import LONG, NONDIMENSIONAL, AnyRig, BlockOnBelt, DrivenSlider, Rig
from stickslip.declared.units import default_speed_unit, in_si, speed
from stickslip.errors import InputError, Place, did_you_mean, number
from stickslip.measured.channels import check_channels
from stickslip.measured.column_roles import Roles, roles_of
from stickslip.measured.inspection import Inspection, inspect
from stickslip.measured.lacking import LackingError
from stickslip.measured.recording import Recording, load_recording
from stickslip.measured.stick_speed import ridden_speed

UNITS = {name: what.unit for name, what in {**BlockOnBelt.dimensions, **Rig.dimensions}.items()}  # in SI
CONSTANTS = {
    "two_degree": ("m", "J", "r", "k1", "k2", "k3", "c1", "c2", "length"),
    "block_on_belt": ("m", "k"),
    "driven_slider": ("m",),
}
TRAINED = 2 / 3  # of a single run, the rest of which validates
SLIPPED = 0.99  # of the readings of a spring force lie below where its slips begin


@dataclass(frozen=True)
class Given:
    """What is known besides the files: as the options of the command say it."""

    kind: str | None = None
    constants: Mapping[str, str] = field(default_factory=dict)
    channels: Sequence[str] = ()
    belt_speeds: Mapping[str, str] = field(default_factory=dict)  # by file; "" for all others
    validate: Sequence[str] = ()
    title: str = ""


@dataclass(frozen=True)
class NewRun:
    """A [[run]] to write."""

    file: str
    role: str
    belt_speed: str | float | None
    doubt: str = ""
    start: float | None = None
    end: float | None = None


def new_case(files: Sequence[Path], folder: Path, given: Given) -> str:
    """Return the text of a rig.toml in `folder` for recordings that lie there.

    Raises
    ------
    LackingError
        Something that neither the files nor `given` say; it names what to give.
    InputError
        A file cannot be read, or lies elsewhere; what is given is wrong.
    """
    names = [_inside(file, folder) for file in files]
    found = [inspect(file) for file in files]
    kind, table = _rig_table(given, found[0])
    rig = _rig(kind, table)
    bare = isinstance(rig, Rig) and rig.scales is None
    roles = roles_of(found[0], kind, given.channels, bare=bare)
    check_channels(roles.channels, rig)
    recordings = [load_recording(file, rig, channels=roles.channels) for file in files]
    runs = _runs(names, recordings, given)
    return _text(given.title or folder.resolve().name, kind, table, roles, runs, recordings[0], found)


def _inside(file: Path, folder: Path) -> str:
    """The path of a file relative to the case's folder."""
    if not file.resolve().is_relative_to(folder.resolve()):
        words = f"lies outside '{folder}', the case's folder; copy it there, or give another --out"
        raise InputError(words, place=Place(str(file)))
    return file.resolve().relative_to(folder.resolve()).as_posix()


def _rig_table(given: Given, first: Inspection) -> tuple[str, dict[str, float]]:
    """The kind of the rig and its constants, in SI or nondimensional."""
    kind = given.kind or _kind_of(given, first)
    if kind not in CONSTANTS:
        words = (
            "has parts that no record shows; write its rig.toml by hand, "
            "and begin with that of 'stickslip example bodies'"
        )
        raise InputError(words, key=f"a rig of {kind}")
    bare = kind == "two_degree" and (
        any(name in NONDIMENSIONAL for name in given.constants)
        or not (given.constants or any(one.unit for one in first.columns))
    )
    needed = NONDIMENSIONAL if bare else CONSTANTS[kind]
    known = (*needed, *({"c"} if kind != "two_degree" else {"coupling"}))
    table: dict[str, float] = {}
    for name, text in given.constants.items():
        if name not in known:
            raise InputError(f"unknown constant of this rig; {did_you_mean(name, known)}", key=name)
        table[name] = _constant(name, text, bare=bare)
    for name in needed:
        if name not in table:
            unit = "" if bare else f", in {UNITS[name]}"
            words = f"the constant {name} of the rig ({kind}{unit})"
            raise LackingError(words, option="--constant", begins=f"{name}=")
    return kind, {name: table[name] for name in known if name in table}


def _kind_of(given: Given, first: Inspection) -> str:
    """The kind of rig, by the constants given, or by the channels recorded."""
    if given.constants.keys() & {"k"}:
        return "block_on_belt"
    if given.constants.keys() & {"J", "r", "k1", "k2", "k3", "length", *NONDIMENSIONAL}:
        return "two_degree"
    named = {one.partition("=")[0] for one in given.channels}
    heads = {one.head.lower() for one in first.columns} | named
    if {"drive"} & heads:
        return "driven_slider"
    return "two_degree" if "y1" in heads else "block_on_belt"


def _constant(name: str, text: str, *, bare: bool) -> float:
    try:
        size, unit = with_unit(text)
    except ValueError:
        raise InputError("not a number with a unit", key=name, value=text) from None
    if unit and bare:
        raise InputError("nondimensional numbers have no unit", key=name, value=text)
    return number(name, size) * (in_si(unit, UNITS[name], what=f"the constant {name}") if unit else 1.0)


def _rig(kind: str, table: Mapping[str, Any]) -> AnyRig:
    if kind == "two_degree":
        return Rig(**table) if "alpha1" in table else Rig.from_si(**table)
    long = {LONG[name]: value for name, value in table.items()}
    return DrivenSlider(**long) if kind == "driven_slider" else BlockOnBelt(**long)


def _runs(names: Sequence[str], recordings: Sequence[Recording], given: Given) -> list[NewRun]:
    """The runs: the last one validates if nothing else is said, and the end of a single one."""
    validated = [_one_of(name, names, "--validate") for name in given.validate]
    speeds = {(one and _one_of(one, names, "--belt-speed")): text for one, text in given.belt_speeds.items()}
    runs = []
    for name, recording in zip(names, recordings, strict=True):
        role = "validate" if name in (validated or names[1:][-1:]) else "train"
        speed_, doubt = _belt_speed(name, recording, speeds)
        runs.append(NewRun(name, role, speed_, doubt))
    if len(runs) == 1 and not validated:
        t = recordings[0].raw["t"] * recordings[0].channels["t"].scale
        at = float(f"{t[0] + TRAINED * (t[-1] - t[0]):.3g}")
        one = runs[0]
        return [
            NewRun(one.file, "train", one.belt_speed, one.doubt, end=at),
            NewRun(one.file, "validate", one.belt_speed, one.doubt, start=at),
        ]
    return runs


def _one_of(file: str, names: Sequence[str], option: str) -> str:
    """The run that an option names, by its path or by its last part."""
    alike = [one for one in names if one == file or Path(one).name == Path(file).name]
    if len(alike) != 1:
        raise InputError(f"no such file here; {did_you_mean(file, names)}", key=option, value=file)
    return alike[0]


def _belt_speed(name: str, recording: Recording, speeds: Mapping[str, str]) -> tuple[str | float | None, str]:
    """The set-point of a run: as given, as its belt was measured, or as the block rides it."""
    rig = recording.rig
    if not isinstance(rig, (Rig, BlockOnBelt)):
        return None, ""
    unit = recording.channels["belt"].unit if "belt" in recording.channels else default_speed_unit(rig)
    if text := speeds.get(name, speeds.get("", "")):
        speed(text, unit, rig)  # refused here, where the option is known
        size, own = with_unit(text)
        return (text if own else size), ""
    if "belt" in recording.raw:
        mean = float(np.mean(recording.raw["belt"])) * recording.channels["belt"].scale
        return float(f"{mean:.4g}"), "the mean of the belt's channel; give the set-point if it is known"
    ridden = ridden_speed(recording.t, recording.x1, _period(rig))
    if ridden is None:
        raise LackingError(
            f"the belt speed of {name}, like '12 mm/s'", option="--belt-speed", begins=f"{name}="
        )
    doubt = "read from the sticks of the record; give the set-point if it is known"
    if isinstance(rig, Rig):
        if rig.scales is None:
            return float(f"{ridden:.4g}"), doubt
        ridden *= rig.scales.velocity
    return f"{1e3 * ridden:.4g} mm/s", doubt


def _period(rig: Rig | BlockOnBelt) -> float:
    """Natural period of the block, in the model's time."""
    return float(2 * np.pi * (np.sqrt(rig.mass / rig.stiffness) if isinstance(rig, BlockOnBelt) else 1))


def _text(
    title: str,
    kind: str,
    table: Mapping[str, float],
    roles: Roles,
    runs: Sequence[NewRun],
    first: Recording,
    found: Sequence[Inspection],
) -> str:
    """The file, what is doubtful in its comments."""
    lines = [f"title = {quoted_toml(title)}", "", "[rig]", f"kind = {quoted_toml(kind)}"]
    bare = "alpha1" in table
    lines += [f"{name} = {value!r}" + ("" if bare else f"  # {UNITS[name]}") for name, value in table.items()]
    lines += _friction(first, runs[0])
    for run in runs:
        lines += ["", "[[run]]", f"file = {quoted_toml(run.file)}", f"role = {quoted_toml(run.role)}"]
        if run.belt_speed is not None:
            value = quoted_toml(run.belt_speed) if isinstance(run.belt_speed, str) else repr(run.belt_speed)
            lines.append(f"belt_speed = {value}" + (f"  # doubtful: {run.doubt}" if run.doubt else ""))
        lines += [f"from = {run.start!r}"] * (run.start is not None) + [f"to = {run.end!r}"] * (
            run.end is not None
        )
    lines += ["", "[channels]"]
    for name, one in roles.channels.items():
        scale = "" if one.scale == 1 else f", scale = {one.scale!r}"
        doubt = f"  # doubtful: {roles.doubts[name]}" if name in roles.doubts else ""
        lines.append(
            f"{name} = {{ column = {quoted_toml(one.column)}, unit = {quoted_toml(one.unit)}{scale} }}{doubt}"
        )
    used = {one.column for one in roles.channels.values()} | {"t"}
    odd = [
        f"# {one.path.name}: {d}"
        for one in found
        for d in one.doubts
        if any(d.startswith(f"{name}: ") for name in used)
    ]
    if odd:
        lines += ["", "# what is odd about the readings:", *odd]
    return "\n".join(lines) + "\n"


def _friction(first: Recording, run: NewRun) -> list[str]:
    """A law to start from. Of a block on a belt in N: where its slips begin, and the middle of its swing."""
    if isinstance(first.rig, DrivenSlider):
        return ["", "[friction]", 'kind = "coulomb"']
    if not isinstance(first.rig, BlockOnBelt):
        return ["", "# [friction] is left out: a fit begins at Table 1 of the paper"]
    sign = -1.0 if str(run.belt_speed).lstrip().startswith("-") else 1.0
    force = sign * first.rig.stiffness * first.x1
    low, high = np.quantile(force, [1 - SLIPPED, SLIPPED])
    kinetic = 0.5 * (low + high)
    if not 0 < kinetic < high:
        words = (
            "its readings do not tell of a force that the belt drags with; is the sign of a channel wrong?"
        )
        raise InputError(words, place=Place(str(first.source)))
    words = "# where a fit begins: where the slips begin, and the middle of the swing"
    return [
        "",
        f"[friction]  {words}",
        'kind = "coulomb"',
        f"static = {high:.3g}",
        f"kinetic = {kinetic:.3g}",
    ]


def quoted_toml(text: str) -> str:
    """Return a text as a string of TOML; what JSON escapes, TOML does too."""
    return json.dumps(text, ensure_ascii=False).replace("\x7f", "\\u007F")
