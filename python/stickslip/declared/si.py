"""SI values of the model's numbers: of every law, effect, curve and rig, by one table of dimensions."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from stickslip.declared.catalogue import KINDS
from stickslip.declared.dimensions import (
    ANGULAR_FREQUENCY,
    FORCE,
    LENGTH,
    NUMBER,
    SPEED,
    TIME,
    Dimension,
)
from stickslip.declared.friction_law import FrictionLaw
from stickslip.declared.laws import LAWS
from stickslip.declared.rig import AnyRig, BlockOnBelt, DrivenSlider, Rig, Scales
from stickslip.declared.units import Channel

OF_LAWS: Mapping[str, Dimension] = {
    f"{name}{twin}": dimension
    for law in LAWS.values()
    for name, dimension in law.dimensions.items()
    for twin in (("", "_plus") if name in law.each_way else ("",))
}
OF_RIGS: Mapping[str, Dimension] = {**Rig.dimensions, **BlockOnBelt.dimensions, **DrivenSlider.dimensions}
OF_EFFECTS: Mapping[str, Dimension] = {
    **{f"{kind.name}.{info.name}": info.dimension for kind in KINDS.values() for info in kind.parameters},
    "unlisted.w": ANGULAR_FREQUENCY,  # of a learned curve that repeats
}
OF_VARIABLES: Mapping[str, Dimension] = {
    **dict.fromkeys(("x1", "y1"), LENGTH),
    **dict.fromkeys(("x2", "y2", "v_w"), SPEED),
    "t": TIME,
}
_ALL = {**OF_LAWS, **OF_RIGS, **OF_EFFECTS}
_ITSELF = Scales(length=1.0, omega=1.0, k2=1.0, r=1.0)  # of a rig whose numbers are in SI


@dataclass(frozen=True)
class SI:
    """A number in SI: the model's times `size`, in `unit`."""

    size: float
    unit: str

    def of(self, value: float) -> float:
        """Value in SI of one of the model's numbers."""
        return value * self.size


def scales_of(rig: AnyRig, channels: Mapping[str, Channel] | None = None) -> Scales | None:
    """Return what is 1 in the model, in SI; None where the model has no units.

    A rig of (2.1) has the scales it is declared with. Other rigs have none of their own: with readings in units their
    numbers are SI already, with readings in "1" or without channels they are bare.
    """
    if isinstance(rig, Rig):
        return rig.scales
    units = {one.unit for one in (channels or {}).values()}
    return _ITSELF if units and "1" not in units else None


def dimension(name: str) -> Dimension | None:
    """Return what a number measures, named as `Model.parameters` names it; None for a name nothing has."""
    return _ALL.get(name)


def dimension_in(friction: FrictionLaw, name: str) -> Dimension | None:
    """Return what a number of a model measures; a number of its law by that law, whatever others call so."""
    if name in friction.numbers:
        return friction.dimensions.get(name, friction.dimensions.get(name.removesuffix("_plus")))
    return dimension(name)


def curve_dimension(where: str) -> Dimension:
    """Return what the values of a learned or tabulated curve measure, by the place where it acts."""
    if where in ("contact", "belt"):  # a share of friction, or of the belt's speed
        return NUMBER
    return LENGTH if where.endswith(" channel") else FORCE


def si_of(what: str | Dimension, rig: AnyRig, channels: Mapping[str, Channel] | None = None) -> SI | None:
    """Return how a number is read in SI.

    Parameters
    ----------
    what
        A number's name as `Model.parameters` has it, or its dimension.
    rig, channels
        As for `scales_of`.

    Returns
    -------
    SI or None
        None for a model without units, a pure number, a phase, and a name nothing has.
    """
    measured = dimension(what) if isinstance(what, str) else what
    scales = scales_of(rig, channels)
    if measured is None or measured == NUMBER or scales is None:
        return None
    return SI(measured.size(scales), measured.unit)
