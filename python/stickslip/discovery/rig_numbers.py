"""Numbers of the declared rig: where each acts, the SI constant behind it, and how a curve shows that one is wrong."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from stickslip.declared.rig import AnyRig, Rig
from stickslip.declared.uncertainty import numbers as every_number
from stickslip.discovery.result import Curve
from stickslip.likelihoods.interval import Interval

BEYOND = 3.0  # standard uncertainties within which a constant is as declared (the format of a case says so)
NEARLY_TWICE = 0.1  # how near 2 a slope must be to be the coupling's
STRAIGHT = (
    0.9  # share of a learned curve's variance in a straight line, which a wrong number of the rig leaves
)


PLACES: Mapping[str, tuple[str, tuple[str, ...]]] = {
    **dict.fromkeys(("alpha1", "m", "k1"), ("block", ("x1",))),
    **dict.fromkeys(("alpha2", "J", "r", "beta3", "k3"), ("angle_body", ("y1",))),
    **dict.fromkeys(("eta12", "c2"), ("angle_body", ("y2",))),
    **dict.fromkeys(("eta1", "c1"), ("both", ("x2", "y2"))),
    "k2": ("both", ("x1", "y1")),
    "x1": ("x1 channel", ("x1",)),
    "y1": ("y1 channel", ("y1",)),
}
"""Where a declared constant, or the gain of a channel, acts, and on what."""


def declared(rig: AnyRig, name: str) -> float:
    """Return a number or a constant as declared; `inertia` and `stiffness` are alpha1."""
    return every_number(rig)["alpha1" if name in ("inertia", "stiffness") else name]


@dataclass(frozen=True)
class SIConstant:
    """The SI constant behind a number of the rig, everything else as declared: (number - least) size."""

    name: str
    size: float
    least: float = 0.0

    @property
    def unit(self) -> str:
        """Its unit."""
        return Rig.dimensions[self.name].unit

    def of(self, value: float) -> float:
        """Its value for one of the number."""
        return (value - self.least) * self.size


def constant(rig: AnyRig, name: str, found: Mapping[str, Interval]) -> SIConstant | None:
    """What a wrong number says of the SI constants by (2.1), with r, k2 and the units as declared.

    c2 is in eta12 - eta1, with the eta1 `found` if it was. alpha1 in both places is none: a mass and a spring k1 that
    are both wrong.
    """
    if not isinstance(rig, Rig) or rig.scales is None:
        return None
    omega, k2, r = rig.scales.omega, rig.scales.k2, rig.scales.r
    eta1 = found["eta1"].value if "eta1" in found else rig.eta1
    known = {
        "alpha2": SIConstant("J", r * r * k2 / omega**2),
        "beta3": SIConstant("k3", k2, 1.0),
        "eta1": SIConstant("c1", k2 / omega),
        "eta12": SIConstant("c2", k2 / omega, eta1),
        "eta2": SIConstant("c2", k2 / omega),
        "inertia": SIConstant("m", k2 / omega**2),
        "stiffness": SIConstant("k1", k2, 1.0),
    }
    return known.get(name)


def remark(rig: AnyRig, curve: Curve) -> str | None:
    """Return what to know of a learned curve that a wrong number of the rig leaves."""
    looks = _LOOKS.get((curve.where, curve.variable))
    if looks is None or not np.corrcoef(curve.x, curve.value)[0, 1] ** 2 > STRAIGHT:
        return None
    if looks == COUPLING:
        return _turned(rig, curve)
    return (
        f"the learned curve is nearly straight, as a wrong {looks} of the declared rig leaves it: check these"
    )


def _turned(rig: AnyRig, curve: Curve) -> str | None:
    """The coupling of the other sign, where the curve is what that adds to the block: twice the force of y1."""
    if not isinstance(rig, Rig):
        return None
    sign, other = (1.0, "as_printed") if rig.coupling == "reciprocal" else (-1.0, "reciprocal")
    slope = float(np.polyfit(curve.x, curve.value, 1)[0])
    if abs(slope - 2 * sign) > NEARLY_TWICE:
        return None
    return (
        f"the learned curve is {slope:+.3g} y1, what the coupling of the other sign adds: write coupling = '{other}' "
        f"in [rig] instead of '{rig.coupling}', and search again"
    )


COUPLING = "coupling"
_LOOKS = {
    ("block", "y1"): COUPLING,
    ("block", "x1"): "m, k1 or k2",
    ("angle_body", "y1"): "J, k2 or k3",
    ("angle_body", "y2"): "J, c1 or c2",
}
