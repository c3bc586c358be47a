"""report.json: what was found, with SI values beside the model's numbers, and where it came from."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from importlib.metadata import version
from pathlib import Path

from stickslip._core import build_config
from stickslip.declared.catalogue import KINDS
from stickslip.declared.rig import DrivenSlider, Rig
from stickslip.declared.rigs.general import GeneralRig
from stickslip.declared.si import OF_VARIABLES, curve_dimension, dimension, scales_of, si_of
from stickslip.declared.uncertainty import GAINS
from stickslip.discovery.plain import Json, plain
from stickslip.discovery.result import Curve, Found, FoundEffect
from stickslip.discovery.rig_numbers import constant, declared
from stickslip.likelihoods.interval import Interval
from stickslip.measured.case import Case
from stickslip.shown.report import words
from stickslip.shown.report.declared import declared as declared_numbers
from stickslip.shown.report.declared import off
from stickslip.shown.report.places import unit_at
from stickslip.shown.report.scatter import scatter
from stickslip.shown.report.units import axes_of

FORMAT = 2  # raised when a key of report.json changes its meaning


def contents(found: Found, case: Case) -> dict[str, Json]:
    """report.json as plain Python; numbers that are not finite are None.

    Parameters
    ----------
    found : Found
    case : Case
        What it was found in: gives the SI scales, units and files.

    Returns
    -------
    dict
        `Found.plain` with, for a case in SI, `value_si`, `low_si`, `high_si` and `unit` beside each
        parameter that has a dimension (`si_name` too where it is a number of the rig), and with `summary`, `caveats`,
        `parameters` and `provenance`.
    """
    out = dict(found.plain)
    out["format"] = FORMAT
    out["summary"] = [words.headline(found), *words.sureness(found), words.clean_sentence(found)]
    axes = None if isinstance(case.rig, DrivenSlider | GeneralRig) else axes_of(case)
    out["caveats"] = list(words.caveats(found, axes))
    out["effects"] = [_effect(one, case) for one in found.effects]
    for which, law in (("law", found.law), ("law_before", found.law_before)):
        out[which] = {name: {**_table(plain(one)), **_si(name, one, case)} for name, one in law.items()}
    out["parameters"] = [*parameter_table(found, case)]
    out["declared"] = numbers = declared_numbers(found, case)
    out["scatter"] = {**scatter(found), "constants": off(numbers)}
    out["provenance"] = provenance(case, found.seconds)
    first = ("format", "title", "verdict", "summary", "effects", "error")
    return {key: out[key] for key in (*first, *(key for key in out if key not in first))}


def _effect(one: FoundEffect, case: Case) -> dict[str, Json]:
    out = plain(one)
    assert isinstance(out, dict)
    out["parameters"] = {
        name: {**_table(plain(number)), **in_si(one, name, case)} for name, number in one.parameters.items()
    }
    out["alternatives"] = [
        {**_table(plain(a)), "parameters": _parameters(a.name, a.parameters, case)} for a in one.alternatives
    ]
    out["words"] = words.kind(one)
    if one.curve is not None:
        out["curve"] = {**_table(out["curve"]), **_curve(one.curve, case)}
    return out


def _curve(curve: Curve, case: Case) -> dict[str, Json]:
    """A learned curve in SI: its variable and its values, where they have a unit."""
    out: dict[str, Json] = {}
    if isinstance(case.rig, GeneralRig):  # it is in SI
        return out
    x = si_of(OF_VARIABLES[curve.variable], case.rig, case.channels)
    value = si_of(curve_dimension(curve.where), case.rig, case.channels)
    if x is not None:
        out |= {"x_si": plain(curve.x * x.size), "x_unit": x.unit}
    if value is not None:
        sides = {"value": curve.value, "low": curve.low, "high": curve.high}
        out |= {f"{side}_si": plain(g * value.size) for side, g in sides.items()} | {"unit": value.unit}
    return out


def in_si(effect: FoundEffect, name: str, case: Case) -> dict[str, Json]:
    """A parameter's value, limits and unit in SI; `si_name` says which constant a wrong number of the rig stands for.

    Empty where there is no one number in SI.
    """
    one, rig = effect.parameters[name], case.rig
    own = next((each for each in case.candidates if each.name == effect.name), None)
    if own is not None:  # its numbers are those of the case
        limits = {"value_si": one.value, "low_si": one.low, "high_si": one.high}
        return {**limits, "unit": own.units[name]} if name in own.units else {}
    if isinstance(rig, GeneralRig):
        return _of_general(effect, name, rig)
    corrects = KINDS[effect.name].corrects if effect.name in KINDS else None
    if corrects is not None and hasattr(rig, corrects):
        return _corrected(corrects, one, case)
    if not effect.of_rig:
        return _si(f"{effect.name}.{name}", one, case)
    if isinstance(rig, Rig) and rig.scales is not None and name in rig.to_si():
        return {"si_name": name, "value_si": one.value, "unit": Rig.dimensions[name].unit,
                "low_si": one.low, "high_si": one.high}  # fmt: skip
    what = constant(rig, name, effect.parameters)
    if what is None:
        return {}
    # found together, c2 is a difference of two numbers: its interval is not in theirs
    low, high = (None, None) if name == "eta12" and "eta1" in effect.parameters else (one.low, one.high)
    return {
        "si_name": what.name,
        "value_si": what.of(one.value),
        "unit": what.unit,
        "low_si": None if low is None else what.of(low),
        "high_si": None if high is None else what.of(high),
    }


def _of_general(effect: FoundEffect, name: str, rig: GeneralRig) -> dict[str, Json]:
    """A parameter of an effect at a place: its numbers are in SI already, of the unit that the place has."""
    one, unit = effect.parameters[name], unit_at(rig, effect.name, effect.where, name)
    if unit is None:
        return {}
    return {"value_si": one.value, "low_si": one.low, "high_si": one.high, "unit": unit}


def _corrected(number: str, error: Interval, case: Case) -> dict[str, Json]:
    """A declared number of a block on a belt, or of a driven slider, with the relative error that was found."""
    measures = dimension(number)
    if measures is None or scales_of(case.rig, case.channels) is None:
        return {}
    declared = float(getattr(case.rig, number))
    limits = (("value_si", error.value), ("low_si", error.low), ("high_si", error.high))
    sizes: dict[str, Json] = {key: None if e is None else declared * (1 + e) for key, e in limits}
    return {"si_name": number, **sizes, "unit": measures.unit}


def si_text(effect: FoundEffect, name: str, case: Case) -> str:
    """A parameter in SI for a table: "0.22 N", or "J = 0.22 kg m^2" where it stands for a constant of the rig."""
    one = in_si(effect, name, case)
    size = one.get("value_si")
    if not isinstance(size, float):
        return "-"
    constant = f"{one['si_name']} = " if "si_name" in one else ""
    return f"{constant}{words.short(size)} {one['unit']}"


def _table(value: Json) -> dict[str, Json]:
    assert isinstance(value, dict)
    return value


def _parameters(effect: str, values: Mapping[str, Interval], case: Case) -> dict[str, Json]:
    return {
        name: {**_table(plain(one)), **_si(f"{effect}.{name}", one, case)} for name, one in values.items()
    }


def _si(name: str, one: Interval, case: Case) -> dict[str, Json]:
    known = si_of(name, case.rig, case.channels)
    if known is None:
        return {}
    limits = (("low_si", one.low), ("high_si", one.high))
    sizes: dict[str, Json] = {key: None if limit is None else known.of(limit) for key, limit in limits}
    return {"value_si": known.of(one.value), "unit": known.unit, **sizes}


def parameter_table(found: Found, case: Case) -> list[dict[str, Json]]:
    """Every estimated number: name, what the file declares (None: nothing), before, after with its interval, SI beside,
    and whether it is identified.
    """
    rows: list[dict[str, Json]] = []
    law = case.declared_numbers if case.friction.kind == found.after.friction.kind else {}
    for name, one in found.law.items():
        own: dict[str, Json] = {"name": name, "kind": "law", "declared": law.get(name)}
        own["before"] = plain(found.law_before.get(name))
        rows.append({**own, **_status(one), **_si(name, one, case)})
    for effect in found.effects:
        for name, one in effect.parameters.items():
            own = {"name": name if effect.of_rig else f"{effect.name}.{name}", "kind": "effect"}
            given = _given(effect, name, case)
            before = None if given is None else plain(Interval(given, None, None))
            rows.append(
                {**own, "declared": given, "before": before, **_status(one), **in_si(effect, name, case)}
            )
    return rows


def _given(effect: FoundEffect, name: str, case: Case) -> float | None:
    """A wrong number of (2.1) as it is declared, 1 for a gain; None for what only an effect has."""
    if effect.of_rig and isinstance(case.rig, GeneralRig):
        return case.rig.numbers[name]
    if not effect.of_rig or not isinstance(case.rig, Rig):
        return None
    return 1.0 if name in GAINS else declared(case.rig, name)


def _status(one: Interval) -> dict[str, Json]:
    status = "identified" if one.low is not None and one.high is not None else "not identified"
    return {**_table(plain(one)), "status": status}


def provenance(case: Case, seconds: float) -> dict[str, Json]:
    """What made the report, and of what: version, build, and the SHA-256 of every file read."""
    files = [case.path, *dict.fromkeys(run.source for run in case.runs)]
    return {
        "program": "stickslip",
        "version": version("stickslip"),
        "build": plain(build_config()),
        "case": case.title,
        "files": [{"file": one.name, "sha256": sha256(one)} for one in files],
        "findings": list(case.findings),
        "seconds": round(seconds, 3),
    }


def sha256(path: Path) -> str | None:
    """The file's SHA-256; None if it has gone since."""
    try:
        with path.open("rb") as file:
            return hashlib.file_digest(file, "sha256").hexdigest()
    except OSError:
        return None
