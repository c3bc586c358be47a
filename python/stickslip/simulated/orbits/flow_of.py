"""The flow that goes with a model."""

from __future__ import annotations

from stickslip.arguments import must_be
from stickslip.declared.bodies_model import check_closed_form
from stickslip.declared.model import Model
from stickslip.declared.rig import DrivenSlider, on_belt
from stickslip.declared.scale import written_speed
from stickslip.declared.speeds import Speed
from stickslip.errors import InputError, number
from stickslip.simulated.orbits.flow import BeltSpeed, Flow
from stickslip.simulated.orbits.general_flow import GeneralFlow
from stickslip.simulated.orbits.named_flow import NamedFlow
from stickslip.simulated.simulate_bodies import constant_speed, needs_bodies


def flow_of(
    model: Model,
    belt_speed: float | str | Speed | None,
    drive_speed: float | str | Speed | None = None,
    tolerance: float = 1e-13,
) -> Flow:
    """Return the flow of a model: of a named rig, or of one of any kind.

    Raises
    ------
    InputError
        A speed is missing, or given where nothing moves at it; no motion of the model repeats.
    """
    must_be("model", model, Model, "Model(rig, friction=law) or load_model(file) give one")
    if isinstance(model.rig, DrivenSlider):
        on_belt(model.rig)
    belt_speed = written_speed(belt_speed, model.rig, "belt_speed")
    drive_speed = written_speed(drive_speed, model.rig, "drive_speed")
    if needs_bodies(model, belt_speed, drive_speed):
        return GeneralFlow(
            model, _plain(belt_speed, "belt_speed"), _plain(drive_speed, "drive_speed"), tolerance
        )
    check_closed_form(model.rig, model.friction, model.effects)
    on_belt(model.rig)
    if belt_speed is None:
        raise InputError("missing; give the speed of the belt", key="belt_speed")
    return NamedFlow(model, constant_speed(belt_speed), None, tolerance)


def _plain(given: float | str | Speed | None, key: str) -> BeltSpeed:
    """Return a number where the speed is one."""
    if given is None:
        return None
    if not isinstance(given, (str, Speed)):
        return number(key, given)
    speed = Speed.of(given, key)
    return speed if speed.constant is None else speed.constant
