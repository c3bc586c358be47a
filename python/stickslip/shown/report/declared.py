"""`declared` of report.json: constants and gains as the file has them, how well they are known, what the runs say."""

from __future__ import annotations

from collections.abc import Mapping

from stickslip.declared.rig import LONG, AnyRig, Rig
from stickslip.declared.rigs.general import GeneralRig
from stickslip.declared.si import dimension, scales_of
from stickslip.declared.units import Channel
from stickslip.discovery.plain import Json, plain
from stickslip.discovery.result import Found
from stickslip.discovery.rig_numbers import constant
from stickslip.likelihoods.interval import Interval
from stickslip.measured.case import Case
from stickslip.shown.report.places import unit_of


def declared(found: Found, case: Case) -> dict[str, Json]:
    """Every declared constant and gain of a case by its declared name.

    Returns
    -------
    dict
        By name: `value` as declared (1 for a gain), `unit`, `uncertainty`, the standard uncertainty in that unit, and
        `runs`, what the runs say of it with everything else as declared: an interval, or None where it was not asked.
    """
    known, said = case.uncertainty, _said(found, case.rig)
    out: dict[str, Json] = {}
    for name, value in known.values.items():
        row: dict[str, Json] = {"value": value, "unit": _unit(name, case.rig, case.channels)}
        row["uncertainty"] = abs(value) * known.constants[name]
        out[name] = {**row, "runs": plain(said.get(name, said.get(LONG.get(name, name))))}
    for channel, share in known.gains.items():
        gain: dict[str, Json] = {"value": 1.0, "unit": "1", "uncertainty": share}
        out[channel] = {**gain, "runs": plain(said.get(channel))}
    return out


def off(numbers: Mapping[str, Json]) -> dict[str, Json]:
    """
    Return by how much each declared constant and gain is off by what the runs say: shares of the declared one.

    Parameters
    ----------
    numbers : as of `declared`; what the runs do not say is left out
    """
    out: dict[str, Json] = {}
    for name, row in numbers.items():
        assert isinstance(row, dict)
        value, runs = row["value"], row["runs"]
        if isinstance(runs, dict) and isinstance(value, float) and value:
            sides = [None if runs[k] is None else runs[k] / value - 1 for k in ("value", "low", "high")]  # type: ignore[operator]
            out[name] = dict(zip(("value", "low", "high"), sides, strict=True))
    return out


def _unit(name: str, rig: AnyRig, channels: Mapping[str, Channel]) -> str:
    if isinstance(rig, GeneralRig):
        return unit_of(rig, name)
    measures = dimension(name)
    return "1" if measures is None or scales_of(rig, channels) is None else measures.unit


def _said(found: Found, rig: AnyRig) -> dict[str, Interval]:
    """What the runs say of the constants, in the unit of the file, by the rig's own name or the channel."""
    numbers = dict(found.constants)
    for effect in found.effects:
        if effect.of_rig:
            numbers |= effect.parameters
    if isinstance(rig, Rig):
        return _of_two_degree(numbers, rig)
    return numbers


def _of_two_degree(numbers: Mapping[str, Interval], rig: Rig) -> dict[str, Interval]:
    """The numbers of (2.1) and, of a rig in SI, the constants that they stand for."""
    out = dict(numbers)
    for name, one in numbers.items():
        what = constant(rig, name, numbers)
        if what is not None:
            # found together, c2 is a difference of two numbers: its interval is not in theirs
            together = name == "eta12" and "eta1" in numbers
            limits = (None if limit is None or together else what.of(limit) for limit in (one.low, one.high))
            out[what.name] = Interval(what.of(one.value), *limits)
    return out
