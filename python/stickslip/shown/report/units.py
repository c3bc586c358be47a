"""From the model's numbers to the readings' units, for axes and tables."""

from __future__ import annotations

from dataclasses import dataclass

from stickslip.declared.dimensions import FORCE, SPEED, UNITS
from stickslip.declared.scale import scales as read_in
from stickslip.fitted.compare import per_model, speed_unit
from stickslip.measured.case import Case
from stickslip.shown.report.si import VARIABLES, factor, scales_of


@dataclass(frozen=True)
class Axis:
    """How a quantity is drawn: number in `unit` = model's number * `size`."""

    size: float
    unit: str


@dataclass(frozen=True)
class Axes:
    """The axes of a case: time, displacements and velocities in the readings' units, forces and v_w in SI or bare."""

    t: Axis
    x1: Axis
    y1: Axis
    x2: Axis
    force: Axis
    rate: Axis
    si: bool

    def variable(self, name: str) -> Axis:
        """Axis of a variable that a curve may depend on."""
        known = {"t": self.t, "x1": self.x1, "y1": self.y1, "x2": self.x2, "v_w": self.x2, "y2": self.x2}
        return known.get(name, Axis(1.0, "1"))


def axes_of(case: Case) -> Axes:
    """The axes of a case, from its channels and its rig."""
    run = case.runs[0]
    t, x1 = per_model(run, "t"), per_model(run, "x1")
    y1 = per_model(run, "y1") if run.y1 is not None else 1.0
    y1_unit = run.unit("y1") if run.y1 is not None else "1"
    speed, per = speed_unit(run)
    scales = scales_of(case.rig)
    own = read_in(case.rig, run.channels)[
        "force"
    ]  # a block on a belt has no scales, but may be declared in SI
    force = Axis(factor(FORCE, scales), UNITS[FORCE]) if scales else Axis(own.size, own.unit)
    rate = Axis(1.0 / t, f"rad/{run.unit('t')}") if run.unit("t") != "1" else Axis(1.0, "1")
    return Axes(
        Axis(t, run.unit("t")),
        Axis(x1, run.unit("x1")),
        Axis(y1, y1_unit),
        Axis(per, speed),
        force,
        rate,
        scales is not None,
    )


__all__ = ["SPEED", "VARIABLES", "Axes", "Axis", "axes_of"]
