"""From the model's numbers to the readings' units, for axes and tables."""

from __future__ import annotations

from dataclasses import dataclass

from stickslip.declared.scale import scales
from stickslip.declared.si import scales_of
from stickslip.fitted.compare import per_model, speed_unit
from stickslip.measured.case import Case


@dataclass(frozen=True)
class Axis:
    """How a quantity is drawn: number in `unit` = model's number * `size`."""

    size: float
    unit: str


@dataclass(frozen=True)
class Axes:
    """
    The axes of a case: time, displacements and velocities in the readings' units, forces and v_w in SI or bare.

    `sensed` is what the sensor of x1 is of: the displacement, or the force of its spring.
    """

    t: Axis
    x1: Axis
    y1: Axis
    x2: Axis
    force: Axis
    rate: Axis
    si: bool
    sensed: str = "x1"

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
    force = scales(case.rig, run.channels)["force"]
    rate = Axis(1.0 / t, f"rad/{run.unit('t')}") if run.unit("t") != "1" else Axis(1.0, "1")
    return Axes(
        Axis(t, run.unit("t")),
        Axis(x1, run.unit("x1")),
        Axis(y1, y1_unit),
        Axis(per, speed),
        Axis(force.size, force.unit),
        rate,
        scales_of(case.rig, run.channels) is not None,
        "spring force" if run.channel("x1").startswith("spring_force") else "x1",
    )
