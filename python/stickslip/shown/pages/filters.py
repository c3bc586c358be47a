"""How a page writes numbers, units and names."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from markupsafe import Markup

from stickslip.discovery.result import Rival
from stickslip.likelihoods.interval import Interval
from stickslip.shown.pages.interactive import Key
from stickslip.shown.report import words

ROUNDING = 1e-12  # of a cycle, of a signal: no error is so small
NEAR = 2.0  # standard uncertainties within which a declared number agrees with the runs
SWATCH = {
    "circle": '<circle cx="13" cy="6" r="4"/>',
    "square": '<rect x="9" y="2" width="8" height="8"/>',
    "diamond": '<path d="M13 1l5 5-5 5-5-5z"/>',
    "triangle": '<path d="M13 1l5 9h-10z"/>',
    "x": '<path d="M9 2l8 8m0-8l-8 8" stroke-width="2"/>',
}
DASH = {"solid": "", "dashed": "6 3", "dotted": "2 2", "dashdot": "6 2 2 2"}
CONSTANTS: Mapping[str, str] = {
    "m": "mass of the block",
    "mass": "mass of the block",
    "J": "moment of inertia of the angle body",
    "r": "leg of the angle body",
    "k": "stiffness of the spring",
    "stiffness": "stiffness of the spring",
    "k1": "stiffness of the block's spring",
    "k2": "stiffness of the coupling spring",
    "k3": "stiffness of the angle body's spring",
    "c": "damping",
    "damping": "damping",
    "c1": "damping of the coupling",
    "c2": "damping of the angle body",
    "alpha1": "stiffness of the block",
    "alpha2": "inertia of the angle body",
    "beta3": "stiffness of the angle body",
    "eta1": "damping of the coupling",
    "eta12": "damping of coupling and angle body",
    "x1": "gain of the x1 sensor",
    "y1": "gain of the y1 sensor",
    "spring_force": "gain of the force sensor",
    "drive": "gain of the drive's channel",
}
SCATTERING: Mapping[str, str] = {
    "static": "static friction, at the end of a stick",
    "kinetic": "kinetic friction, in a slip",
    "belt": "speed of the belt",
}
POWERS = {"^2": "²", "^3": "³", "um": "µm"}


def swatch(key: Key) -> Markup:
    """What stands before a line of a legend."""
    line = (
        f'<path d="M1 6h24" fill="none" stroke-width="2.5" stroke-dasharray="{DASH[key.dash]}"/>'
        if key.dash
        else ""
    )
    colours = f'fill="{key.colour}" stroke="{key.colour}"'
    return Markup(
        f'<svg aria-hidden="true" {colours}>{line}{SWATCH.get(key.marker, "")}</svg>'
    )  # colours and shapes are ours


def number(value: float | None, digits: int = 4) -> str:
    """A number for a table, with a power of ten where it is far from 1; a dash where there is none."""
    return words.short(value, digits)


def error(value: float) -> str:
    """An error for a table; what is only rounding is 0."""
    return number(0.0 if abs(value) < ROUNDING else value, 3)


def span(one: Interval | None) -> str:
    """A 95 % interval for a table."""
    if one is None or (one.low is None and one.high is None):
        return "–"
    return words.spanned(one)[1]


def valued(one: Interval) -> str:
    """A value with the digits that its interval leaves it."""
    return words.spanned(one)[0]


def interval(row: Mapping[str, float | None]) -> Interval:
    """The interval of a row of the table of all numbers."""
    return Interval(float(row["value"] or 0.0), row.get("low"), row.get("high"))


def si(row: Mapping[str, Any]) -> Interval:
    """The interval of a row in SI, its smaller limit first."""
    low, high = row.get("low_si"), row.get("high_si")
    if low is not None and high is not None and low > high:
        low, high = high, low
    return Interval(float(row["value_si"]), low, high)


def unit(name: str) -> str:
    """A unit as a person writes it; "none" where there is none."""
    for mark, sign in POWERS.items():
        name = name.replace(mark, sign)
    return "none" if name in ("1", "") else name.replace(" ", "\u00a0")


def beneath(one: Mapping[str, float]) -> bool:
    """Is the difference of before and after below the floor?"""
    return abs(one["before"] - one["after"]) < one["floor"]


def numbers(rival: Rival) -> str:
    """A rival's numbers: by their own names where it is one effect; phases, which differ by run, are left out."""
    single = len(rival.names) == 1
    return ", ".join(
        f"{name.rpartition('.')[2] if single else name} = {number(value, 3)}"
        for name, value in rival.parameters.items()
        if not name.endswith(".phi")
    )


def percent(value: float | None) -> str:
    """A share as percent, two digits."""
    return "–" if value is None or value != value else f"{number(100 * value, 2)}\u00a0%"  # NaN


def constant(name: str) -> str:
    """A declared number with what it is."""
    what = CONSTANTS.get(name)
    return f"{name}: {what}" if what else name


def scattering(name: str) -> str:
    """What differs from event to event."""
    return SCATTERING.get(name, name)


def agreement(row: Mapping[str, Any]) -> str:
    """Whether the runs agree with what is declared: in words."""
    runs = row["runs"]
    if not runs:
        return "not asked of the runs"
    if runs["low"] is None or runs["high"] is None:
        return "the runs do not tell"
    reach = NEAR * float(row["uncertainty"])
    value = float(row["value"])
    low, high = sorted((runs["low"], runs["high"]))
    if low - reach <= value <= high + reach:
        return "agrees"
    return f"differs by {percent(runs['value'] / value - 1)}" if value else "differs"


FILTERS: Mapping[str, Callable[..., Any]] = {
    "swatch": swatch,
    "num": number,
    "error": error,
    "span": span,
    "valued": valued,
    "interval": interval,
    "si": si,
    "unit": unit,
    "beneath": beneath,
    "numbers": numbers,
    "percent": percent,
    "constant": constant,
    "scattering": scattering,
    "agreement": agreement,
    "tied": words.ties,
    "guessed": words.guessed,
    "sentence": words.sentence,
}
