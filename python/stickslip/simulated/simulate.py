"""One trajectory of a model: `simulate`."""

from __future__ import annotations

import math
import warnings
from collections.abc import Callable, Sequence
from functools import partial
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from stickslip import _core
from stickslip.arguments import explained, must_be, texts, vector, whole_number
from stickslip.declared.drive import Drive, pull_or_force
from stickslip.declared.effect import Effect
from stickslip.declared.friction_sign import driving_friction
from stickslip.declared.model import Model
from stickslip.declared.rig import DrivenSlider
from stickslip.declared.scale import written_speed, written_time
from stickslip.declared.speeds import Speed
from stickslip.errors import InputError, ModelWarning, number
from stickslip.simulated.goes_on import where_it_ends
from stickslip.simulated.lowering import Lowered, lower
from stickslip.simulated.named_readings import named_readings
from stickslip.simulated.simulate_bodies import constant_speed, lacks_belt_speed, needs_bodies, simulate_any
from stickslip.simulated.states import HIDDEN, VISIBLE, Y1
from stickslip.simulated.trajectory import CONTACTS, Status, Trajectory, Transitions

Floats = NDArray[np.float64]
MOST_TRANSITIONS, MOST_STEPS = 1_000_000, 5_000_000  # of a run, if not said otherwise
Mode = Literal["auto", "stick", "slip-", "slip+"]


@explained
def simulate(
    model: Model,
    *,
    belt_speed: float | str | Speed | None = None,
    drive_speed: float | str | Speed | None = None,
    drive: Drive | None = None,
    initial: ArrayLike | Trajectory | None = None,
    t_end: float | str,
    t_start: float | str = 0.0,
    t_eval: ArrayLike | None = None,
    rtol: float = 1e-10,
    atol: float = 1e-10,
    sensitivity: Sequence[str] = (),
    contact: Mode | Sequence[Mode] = "auto",
    locator: Literal["henon", "bracket"] = "henon",
    max_transitions: int = MOST_TRANSITIONS,
    max_steps: int = MOST_STEPS,
    order: int | None = None,
    step: float | None = None,
) -> Trajectory:
    """Simulate the model, locating every transition.

    The motion is a sequence of pieces (stick, slip either way, saturated branches), each expanded in its
    Taylor series; linear pieces to machine precision, curved ones to the tolerance. Transitions are roots of
    the switching polynomials, landed on by Hénon's method.

    Parameters
    ----------
    model
        What to simulate.
    belt_speed
        v_b, the set-point of the belt, of either sign or zero, in the rig's units or with its own ("12 mm/s"); or a
        formula of t ("0.5*sin(1.7*t)"), or a `Speed`.
        Left out where no contact rubs on a belt.
    drive_speed
        Likewise of the drive that pulls at links of a rig of bodies; it is at 0 at `t_start`, or where a run left it.
    drive
        Force on a `DrivenSlider`: a number [N] or one with a unit, a formula of t, or (times, forces), each held until
        the next.
    initial
        State at `t_start` in the order of `rig.state_names`, optionally followed by the hidden states w, z,
        b, m, dwell, or by those of the laws. At rest at the origin if absent; a law's state as its law starts it. Or a
        run that goes on: from its last sample, in its modes, with all that is hidden in it; derivatives begin anew.
    t_end, t_start
        Time span, in the rig's unit of time or with a unit ("60 s").
    t_eval
        Increasing times at which to return the state, within the span; the integrator's steps if absent.
    rtol, atol
        Error allowed to each step, relative and absolute; not both zero. `atol` is in the rig's own units: for a
        block in SI units that moves by micrometres choose it far below that.
    sensitivity
        Names of parameters (as in `model.parameters`, "belt_speed", "initial.x1", ...) to differentiate by.
    contact
        Mode to start in; found from the state by "auto". "stick" sets the block on the belt (x2 becomes the belt's
        speed); a slip whose sign v_w contradicts is refused. Of several contacts, one for all or a list.
    locator
        "henon", or "bracket" for plain bisection on the same series.
    max_transitions
        Transitions and kinks after which the run is ended.
    max_steps
        Steps after which the run is ended: it is very long, or stiff by an effect's time constant far below the
        motion's.
    order, step
        Fixed order and step of the series of curved pieces, of a named rig; chosen from the tolerance if absent.

    Returns
    -------
    Trajectory

    Raises
    ------
    InputError
        A number is out of its bounds or not finite, `t_eval` not increasing or outside the span, a name
        unknown.

    Warns
    -----
    ModelWarning
        An effect turns the sign of friction within the run (a `friction_drift` that goes on too long, a curve below
        -1 at the contact): it is simulated as declared, with friction that drives.

    Examples
    --------
    >>> import stickslip as ss
    >>> rig = ss.Rig(alpha1=16, alpha2=8, beta3=4, eta1=0.1, eta12=0.2)
    >>> model = ss.Model(rig, friction=ss.PaperFriction())
    >>> run = ss.simulate(
    ...     model, belt_speed=0.1, initial=(0.1, 0.1, 0, 0), t_end=20, sensitivity=("T_s_minus",)
    ... )
    >>> print(run.transitions)
        2.754597  stick  -> slip -
        7.219832  slip - -> stick
       12.857874  stick  -> slip -
       17.396113  slip - -> stick
    >>> print(f"d x1(20) / d T_s_minus = {run.sensitivity[-1, 0, 0]:.4f}")
    d x1(20) / d T_s_minus = -0.2903
    """
    must_be("model", model, Model, "Model(rig, friction=law) or load_model(file) give one")
    belt_speed = written_speed(belt_speed, model.rig, "belt_speed")
    drive_speed = written_speed(drive_speed, model.rig, "drive_speed")
    drive_speed = pull_or_force(model.rig, drive_speed, drive)
    first = written_time(t_start, model.rig, "t_start")
    before, begun = (initial, None) if isinstance(initial, Trajectory) else (None, initial)
    if before is not None:
        kind = needs_bodies(model, belt_speed, drive_speed)
        first, begun, contact = where_it_ends(before, model, first, contact, of_bodies=kind)
    start, end = _span(first, written_time(t_end, model.rig, "t_end"))
    tolerances = checked_tolerances(rtol, atol)
    times = None if t_eval is None else _sample_times(t_eval, start, end)
    names = texts("sensitivity", sensitivity, "parameter names")
    asked: object = locator  # whatever was given: an array has no truth value
    if not isinstance(asked, str) or locator not in ("henon", "bracket"):
        raise InputError("must be 'henon' or 'bracket'", key="locator", value=locator)
    shared: dict[str, Any] = {
        "t_start": start,
        "t_end": end,
        "rtol": tolerances[0],
        "atol": tolerances[1],
        "locator": _core.Locator[locator],
        "max_transitions": whole_number("max_transitions", max_transitions),
        "max_steps": whole_number("max_steps", max_steps),
    }
    if needs_bodies(model, belt_speed, drive_speed):
        if order is not None or step is not None:
            key = "step" if order is None else "order"
            raise InputError("is for a named rig under its own laws; leave it out", key=key)
        if isinstance(model.rig, DrivenSlider):
            _warn_of_driving(model, start, end)
        return simulate_any(
            model, belt_speed, drive_speed, begun, contact, names, times, before=before, **shared
        )
    if belt_speed is None:
        raise lacks_belt_speed()
    speed = constant_speed(belt_speed)
    if model.effects:
        _warn_of_driving(model, start, end)
    lowered = lower(model, speed)
    if not isinstance(contact, str) or contact not in CONTACTS:
        raise InputError(f"must be one of {', '.join(CONTACTS)}", key="contact", value=contact)
    start_state = _started(model, lowered, begun, contact, speed)
    run: Callable[..., dict[str, Any]] = partial(
        _core.simulate,
        structure=lowered.structure,
        parameters=lowered.parameters,
        initial=start_state,
        contact=CONTACTS[contact],
        order=0 if order is None else whole_number("order", order, least=2, most=30),
        fixed_step=0.0 if step is None else number("step", step, above=0),
    )
    raw = run(t_eval=times, seeds=lowered.seeds(map(model.full_name, names)), **shared)

    def earlier(at: Floats) -> Floats:
        """Y1 at increasing times; before the start what it is there."""
        out, within = np.full(at.shape, float(start_state[Y1])), at > start
        if within.any():
            asked = {**shared, "t_end": max(end, float(at[-1]))}
            found = run(t_eval=at[within], seeds=lowered.seeds(()), **asked)["state"][:, Y1]
            out[within] = np.append(found, np.full(int(within.sum()) - len(found), np.nan))
        return out

    return _trajectory(raw, model, names, speed, earlier)


def _warn_of_driving(model: Model, start: float, end: float) -> None:
    for said in driving_friction(model, start, end):
        warnings.warn(said, ModelWarning, stacklevel=4)


def _span(t_start: float, t_end: float) -> tuple[float, float]:
    start = number("t_start", t_start)
    return start, number("t_end", t_end, above=start, why="the end must come after the start")


def checked_tolerances(rtol: float, atol: float) -> tuple[float, float]:
    """Return the tolerances, or raise `InputError` for ones that cannot be kept."""
    relative, absolute = number("rtol", rtol, least=0, below=1), number("atol", atol, least=0)
    if relative == 0 and absolute == 0:
        raise InputError("both are zero; give one like 1e-10", key="rtol, atol")
    if 0 < relative < 1e-15:
        raise InputError("below the resolution of float64; the least is 1e-15", key="rtol", value=rtol)
    return relative, absolute


def checked_initial(model: Model, lowered: Lowered, initial: ArrayLike | None) -> Floats:
    """Return the core's initial state, or raise `InputError` for one of the wrong length or not finite."""
    names = model.rig.state_names
    if initial is None:
        return lowered.initial([0.0] * len(names))
    given = vector("initial", initial, f"one start ({', '.join(names)})")
    most = len(names) + len(HIDDEN)
    owned = _owned(model)
    if not len(names) <= given.size <= most:
        words = f"has {given.size} number{'s' * (given.size != 1)}; give {len(names)} ({', '.join(names)})"
        if owned:
            hidden = HIDDEN[: HIDDEN.index(owned[-1]) + 1]
            states = f"hidden state{'s' * (len(hidden) > 1)} {', '.join(hidden)}"
            words += f", or up to {len(names) + len(hidden)} with the {states}"
        raise InputError(words, key="initial")
    values: list[float] = given.tolist()  # so few that numpy's loops cost more
    if not all(map(math.isfinite, values)):
        bad = next(name for name, x in zip((*names, *HIDDEN), values, strict=False) if not math.isfinite(x))
        raise InputError(f"{bad} is not finite", key="initial", value=values)
    for name, value in zip(HIDDEN, values[len(names) :], strict=False):
        if value and name not in owned:
            raise InputError(f"{name} = {value:g}, but no effect of the model has that state", key="initial")
    return lowered.initial(values)


def _started(model: Model, lowered: Lowered, initial: ArrayLike | None, contact: str, speed: float) -> Floats:
    """Return the full initial state, refusing a slip that goes the other way than `contact` says."""
    state = checked_initial(model, lowered, initial)
    if contact not in ("slip-", "slip+"):
        return state
    v = state[1] - speed
    moving = any(term.where == "belt" for term in model.effects)
    if not moving and v * CONTACTS[contact] < -1e-12 * abs(speed):
        raise InputError(
            f"x2 = {state[1]:g} on a belt of {speed:g} slips the other way", key="contact", value=contact
        )
    return state


def _sample_times(t_eval: ArrayLike, start: float, end: float) -> Floats:
    times = vector("t_eval", t_eval, "a list of times")
    # nearly every call; NaN compares false, and what increases between finite ends is finite
    within = times.size > 0 and start <= times.item(0) and times.item(-1) <= end
    if within and (times.size == 1 or (times[1:] > times[:-1]).all()):
        return times
    if times.size == 0:
        raise InputError(
            "empty; give at least one time, or leave it out for the integrator's steps", key="t_eval"
        )
    if not np.isfinite(times).all():
        raise InputError(f"entry {int(np.flatnonzero(~np.isfinite(times))[0])} is not finite", key="t_eval")
    falls = np.flatnonzero(np.diff(times) <= 0)
    if falls.size:
        i = int(falls[0]) + 1
        raise InputError(f"must increase; entry {i} is {times[i]:g} after {times[i - 1]:g}", key="t_eval")
    slack = 4 * math.ulp(max(abs(start), abs(end)))
    if times[0] < start - slack or times[-1] > end + slack:
        raise InputError(
            f"runs from {times[0]:g} to {times[-1]:g}, outside the span {start:g} to {end:g}", key="t_eval"
        )
    clipped = np.clip(times, start, end)
    if (clipped[1:] <= clipped[:-1]).any():
        raise InputError("has several entries within rounding of an end of the span; give one", key="t_eval")
    return clipped


def _trajectory(
    raw: dict[str, Any],
    model: Model,
    names: tuple[str, ...],
    speed: float,
    earlier: Callable[[Floats], Floats],
) -> Trajectory:
    d = len(model.rig.state_names)
    state: Floats = raw["state"]
    sensitivity: Floats = raw["sensitivity"]  # (n, states, p)
    events: Floats = raw["transition_sensitivity"]  # (k, 1 + states, p)
    hidden = slice(len(VISIBLE), None)
    transitions = Transitions(
        t=raw["transition_t"],
        state=raw["transition_state"][:, :d].copy(),
        before=raw["transition_before"],
        after=raw["transition_after"],
        sensitivity=events[:, 0],
        state_sensitivity=events[:, 1 : 1 + d],
    )
    return Trajectory(
        t=raw["t"],
        state=state[:, :d].copy(),
        mode=raw["mode"],
        hidden=dict(zip(HIDDEN, state.T[hidden], strict=True)),
        transitions=transitions,
        kinks=raw["kink_t"],
        sensitivity=sensitivity[:, :d],
        hidden_sensitivity=(
            dict(zip(HIDDEN, sensitivity.transpose(1, 0, 2)[hidden], strict=True))
            if names
            else dict.fromkeys(HIDDEN, sensitivity[:, 0])
        ),
        status=Status[raw["outcome"].name],
        steps=int(raw["steps"]),
        sensitivity_names=names,
        state_names=model.rig.state_names,
        hidden_names=_owned(model),
        readings=named_readings(model, raw["t"], state, earlier),
        model=model,
        belt_speed=speed,
    )


def _owned(model: Model) -> tuple[str, ...]:
    """Hidden states that an effect of the model has."""
    if not model.effects:
        return ()
    names = {name for term in model.effects if isinstance(term, Effect) for name in term.kind.hidden}
    return tuple(name for name in HIDDEN if name in names)
