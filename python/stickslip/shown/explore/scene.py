"""What is drawn of a model at one belt speed, and what was measured to lay beneath it; in the readings' units."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from stickslip.declared.contact_laws import ContactLaws
from stickslip.declared.friction_law import FrictionLaw
from stickslip.declared.model import Model
from stickslip.declared.rig import DrivenSlider
from stickslip.declared.rigs.general import GeneralRig
from stickslip.declared.scale import Quantity, Scale, scales
from stickslip.errors import InputError, StickslipError
from stickslip.fitted.bodies_data import natural_periods
from stickslip.fitted.identify_windows import natural_period
from stickslip.measured import signals
from stickslip.measured.recording import Recording
from stickslip.simulated.simulate import simulate

Floats = NDArray[np.float64]
PERIODS = 20  # natural ones that are simulated: a cycle settles within a few of them
SAMPLES = 1000
TOLERANCE = 1e-7  # far below a pixel
LAW = 200  # points of the friction law on either side


@dataclass(frozen=True)
class ScenePlace:
    """Where a model is looked at: a coordinate and its velocity among the states, and the contact that rubs there.

    `direction` turns velocities of the coordinates into that of the contact; `drift` says whether a drive carries the
    coordinate away, which is then drawn against the drive.
    """

    name: str
    x: int
    v: int
    contact: int = 0
    direction: Floats | None = None
    moved_by: Literal["belt", "drive"] = "belt"
    slides: bool = True  # v_w is less by the belt's speed
    drift: bool = False


def place(model: Model) -> ScenePlace:
    """The block, or the first coordinate that a contact of a rig of bodies or matrices rubs on.

    Raises
    ------
    InputError
        Of a rig that neither a belt nor a drive moves.
    """
    if not isinstance(model.rig, GeneralRig):
        return ScenePlace("x1", 0, 1)
    own = model.rig.equations
    n = len(own.names)
    if not own.contacts or not (own.on_belt or own.driven):
        words = "nothing moves it: a contact on the belt or a link to the drive is needed"
        raise InputError(words, key="MODEL")
    j = next((j for j, one in enumerate(own.contacts) if one.against == "belt"), 0)
    direction = own.contacts[j].direction
    at = int(np.argmax(np.abs(direction)))
    moved_by: Literal["belt", "drive"] = "belt" if own.on_belt else "drive"
    on_belt = own.contacts[j].against == "belt"
    return ScenePlace(own.names[at], at, at + n, j, direction, moved_by, on_belt, own.driven)


@dataclass(frozen=True)
class Curves:
    """t, x1 (n,), the second half's portrait x, v (m,), and the law: v_w, T (k,) with NaN at v_w = 0."""

    t: Floats
    x1: Floats
    x: Floats
    v: Floats
    v_w: Floats
    force: Floats
    sticks: bool  # whether the block sticks in the second half


def units(model: Model) -> dict[Quantity, Scale]:
    """Sizes and units of what is drawn."""
    if not isinstance(model.rig, GeneralRig):
        return scales(model.rig, model.channels)
    own, seen = model.rig.equations, place(model)
    unit = own.units[seen.x]
    if unit == "1":
        return dict.fromkeys(("t", "x1", "x2", "belt", "force"), Scale())
    turns = own.contacts[seen.contact].rotation
    speed, force = ("rad/s", "N m") if turns else ("m/s", "N")
    sizes: dict[Quantity, Scale] = {
        "t": Scale(1.0, "s"),
        "x1": Scale(1.0, unit),
        "x2": Scale(1.0, f"{unit}/s"),
    }
    return sizes | {"belt": Scale(1.0, speed), "force": Scale(1.0, force)}


def law_of(model: Model) -> FrictionLaw:
    """The law of the contact that is drawn."""
    if isinstance(model.friction, ContactLaws) and isinstance(model.rig, GeneralRig):
        return model.friction[model.rig.equations.contacts[place(model).contact].law]
    return model.friction


def refuse(model: Model) -> None:
    """Refuse a rig that nothing moves by a speed.

    Raises
    ------
    InputError
        Of a driven slider, or a rig of bodies or matrices without belt and drive.
    """
    if isinstance(model.rig, DrivenSlider):
        known = "the rig of (2.1), a block on a belt and rigs of bodies or matrices can be explored"
        raise InputError(f"a {type(model.rig).__name__} has no belt to set; {known}", key="MODEL")
    place(model)


def _span(model: Model) -> float:
    """How long is simulated."""
    rig = model.rig
    return PERIODS * (
        natural_periods(rig.equations)[0] if isinstance(rig, GeneralRig) else natural_period(rig)
    )


def _moved(model: Model, speed: float) -> dict[str, Any]:
    """The speeds that a run is given: that of the belt and that of the drive, where there are both, are the same."""
    if not isinstance(model.rig, GeneralRig):
        return {"belt_speed": speed}
    own = model.rig.equations
    asked = {"belt_speed": own.on_belt, "drive_speed": own.driven}
    return {name: speed for name, there in asked.items() if there}


def curves(model: Model, belt_speed: float) -> Curves:
    """Simulate from rest and return what is drawn.

    Parameters
    ----------
    model : Model
    belt_speed : float
        v_b in the model's unit.

    Raises
    ------
    StickslipError
        The run stops before its end.
    """
    size, seen, law = units(model), place(model), law_of(model)
    t = np.linspace(0.0, _span(model), SAMPLES)
    speeds = _moved(model, belt_speed)
    run = simulate(model, **speeds, t_end=float(t[-1]), t_eval=t, rtol=TOLERANCE, atol=TOLERANCE)
    if len(run.t) < len(t):
        raise StickslipError(f"the run stops at t = {size['t'].of(float(run.t[-1]))}: {run.status.value}")
    late = slice(len(t) // 2, None)
    x1, x2 = run.state[:, seen.x], run.state[:, seen.v]
    v_c = x2 if seen.direction is None else run.state[:, len(seen.direction) :] @ seen.direction
    v_c = v_c - belt_speed if seen.slides else v_c
    if seen.drift:
        x1 = x1 - belt_speed * run.t
    reach = max(float(np.abs(v_c).max()), abs(belt_speed) if seen.slides else 0.0) or 1.0
    side = np.linspace(0.0, reach, LAW + 1)[1:]
    v_w = np.concatenate([-side[::-1], [np.nan], side])
    force = np.concatenate([law.force(-side[::-1]), [np.nan], law.force(side)])
    mode = run.mode if run.mode.ndim == 1 else run.mode[:, seen.contact]
    return Curves(
        size["t"].size * run.t,
        size["x1"].size * x1,
        size["x1"].size * x1[late],
        size["x2"].size * x2[late],
        size["belt"].size * v_w,
        size["force"].size * np.asarray(force, dtype=np.float64),
        bool(np.any(mode[late] == 0)),
    )


def measured(model: Model, run: Recording) -> dict[str, Floats]:
    """A run's readings as drawn: t from 0, x1, and the velocity of x1 by a smoothing spline."""
    size = units(model)
    good = np.isfinite(run.x1)
    t, x1 = run.t[good] - run.t[0], run.x1[good]
    try:
        smooth = signals.smooth(t, x1)
        x, v = smooth.x, smooth.v
    except StickslipError:  # too rough for a spline
        x, v = x1, np.gradient(x1, t)
    return {
        "t": size["t"].size * t,
        "x1": size["x1"].size * x1,
        "x": size["x1"].size * x,
        "v": size["x2"].size * v,
    }
