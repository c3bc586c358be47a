"""Accelerations, forces in links and friction at contacts that `simulate` gives, against simulators written apart."""

import numpy as np
import pytest
from numpy.typing import NDArray

import stickslip as ss
from bodies_cases import CASES
from stickslip.errors import InputError
from stickslip.simulated.general import general
from stickslip.simulated.reference.bodies import Bodies
from stickslip.simulated.reference.bodies import simulate as plain
from stickslip.simulated.reference.integrate import advance
from studies import few

Floats = NDArray[np.float64]
LASTS = 1.2
TIMES = np.linspace(0.0, LASTS, 49)

WAVY = ss.BodiesRig(
    body={"block": ss.Body(mass=1.0), "arm": ss.Body(inertia=0.02)},
    link=[
        ss.Link(between=("block", "ground"), stiffness=30.0, damping=0.3, rest=0.01),
        ss.Link(between=("block", "arm"), stiffness=20.0, damping=0.1, gear=0.1),
        ss.Link(between=("drive", "arm"), stiffness=2.0, damping=0.2),
    ],
    contact=[ss.Contact(body="block", against="belt", law="own"), ss.Contact(body="arm", law="pivot")],
)
OWN = ss.FormulaFriction(kinetic="c + (s - c)*exp(-u/vs) + d*u", static="s", c=1.0, s=1.6, vs=0.05, d=0.2)
WAVES = ss.Model(WAVY, friction={"own": OWN, "pivot": ss.CoulombFriction(static=0.05, kinetic=0.04)})
MOVED = {"belt_speed": "0.1 + 0.03*sin(2*t)", "drive_speed": "0.4*cos(3*t)"}
START = (0.02, 0.0, 0.1, 0.2)
HARD = ss.effect("formula", called="hard", where="link_2", force="-h*deflection**3", h=4e3)
DRAG = ss.effect("formula", called="drag", where="block", force="-b*v_block*abs(v_block)", b=0.5)
PUSHED = ss.Model(WAVY, friction=WAVES.friction, effects=[HARD, DRAG])


def by_reference(
    model: ss.Model, speeds: dict[str, object], start: object, t: Floats
) -> tuple[Floats, Floats]:
    """Accelerations and friction by the plain simulator, its modes at every time."""
    system = Bodies(general(model, speeds.get("belt_speed"), speeds.get("drive_speed")))
    run = plain(model, initial=start, t_end=t[-1], t_eval=t, tol=1e-13, **speeds)  # type: ignore[arg-type]
    begins, a, T = np.array([one.t for one in run.steps]), [], []
    for time in t.tolist():
        step = run.steps[max(0, int(np.searchsorted(begins, time, side="right")) - 1)]
        z = advance(system, step.side, step.t, step.z, time)
        a.append(system.field(time, z, step.side)[system.n : 2 * system.n])
        T.append(system.friction(time, z, step.side))
    return np.array(a, float), np.array(T, float)


@pytest.mark.parametrize("name", few([*CASES, "waves", "pushed"], CASES))
def test_accelerations_and_friction_are_those_of_the_plain_simulator(name: str) -> None:
    if name in CASES:
        case = CASES[name]()
        model, speeds, start = case.model, dict(case.speeds), case.initial
    else:
        model, speeds, start = {"waves": WAVES, "pushed": PUSHED}[name], MOVED, START
    run = ss.simulate(model, initial=start, t_end=LASTS, t_eval=TIMES, **speeds)  # type: ignore[arg-type]
    a, T = by_reference(model, speeds, start, TIMES)
    assert len(run.transitions) > 1
    assert (run.mode == 0).any()
    assert (run.mode != 0).any()
    assert run.acceleration == pytest.approx(a, abs=1e-8 * np.abs(a).max())
    for j, contact in enumerate(run.contact_names):
        assert run.contact_force(contact) == pytest.approx(T[:, j], abs=1e-8 * np.abs(T).max())
    own = ss.simulate(model, initial=start, t_end=LASTS, **speeds)  # type: ignore[arg-type]  # at the integrator's own steps
    same = ss.simulate(model, initial=start, t_end=LASTS, t_eval=own.t, **speeds)  # type: ignore[arg-type]
    assert own.acceleration == pytest.approx(same.acceleration, abs=1e-7 * np.abs(a).max())


@pytest.mark.parametrize("model", [WAVES, PUSHED], ids=["plain", "with effects"])
def test_forces_in_links_are_springs_dampers_and_effects(model: ss.Model) -> None:
    """By hand; and with friction at the contacts they are all that moves the bodies."""
    run = ss.simulate(model, initial=START, t_end=LASTS, t_eval=TIMES, **MOVED)  # type: ignore[arg-type]
    way, rate = 0.4 * np.sin(3 * TIMES) / 3, 0.4 * np.cos(3 * TIMES)
    held = 30.0 * (run.block - 0.01) + 0.3 * run.v_block
    lever = 20.0 * (run.block - 0.1 * run.arm) + 0.1 * (run.v_block - 0.1 * run.v_arm)
    pulled = 2.0 * (way - run.arm) + 0.2 * (rate - run.v_arm)
    drag = 0.0
    if model.effects:
        lever = lever + 4e3 * (run.block - 0.1 * run.arm) ** 3
        drag = 0.5 * run.v_block * np.abs(run.v_block)
        assert np.ptp(4e3 * (run.block - 0.1 * run.arm) ** 3) > 0.05 * np.ptp(lever)
    for i, force in enumerate((held, lever, pulled)):
        assert run.link_force(f"link_{i + 1}") == pytest.approx(force, abs=1e-9)
    on_block = -held - lever - drag - run.contact_force("block")
    assert run.a_block * 1.0 == pytest.approx(on_block, abs=1e-9)
    assert run.a_arm * 0.02 == pytest.approx(0.1 * lever + pulled - run.contact_force("arm"), abs=1e-9)


def test_at_a_jump_the_value_after_it_is_read() -> None:
    case = CASES["pin"]()
    first = ss.simulate(case.model, belt_speed=0.05, initial=case.initial, t_end=1.0)
    at = first.transitions.t[2:6]
    assert len(at) == 4
    run = ss.simulate(case.model, belt_speed=0.05, initial=case.initial, t_end=1.0, t_eval=at)
    for mode, force, a, along, across, v in zip(
        run.mode[:, 0], run.T_contact_1, run.a_along, run.along, run.across, run.v_along, strict=True
    ):
        if mode:
            assert force == pytest.approx(2.0 * mode, abs=1e-9)  # kinetic, no longer the limit of 4
        else:
            held = -(800.0 * along + 90.0 * across + 0.4 * v)
            assert (force, a) == pytest.approx((held, 0.0), abs=1e-7)
    assert set(run.mode[:, 0]) == {-1, 0}


@pytest.mark.parametrize("model", [WAVES, PUSHED], ids=["plain", "with effects"])
def test_derivatives_are_those_of_central_differences(model: ss.Model) -> None:
    """Of sixth order; where a transition passes a time of the record within the step, there is none."""
    names = ["block.mass", "arm.inertia", "link_1.stiffness", "link_1.damping", "link_1.rest", "link_3.stiffness",
             "link_3.damping", "own.c", "own.vs", "pivot.kinetic", "initial.block", "initial.v_arm"]  # fmt: skip
    names += ["hard.h", "drag.b"] if model.effects else ["link_2.stiffness", "link_2.gear"]
    tight = {"t_end": LASTS, "t_eval": TIMES, "rtol": 1e-13, "atol": 1e-14, **MOVED}
    run = ss.simulate(model, initial=START, sensitivity=names, **tight)  # type: ignore[arg-type]

    def moved(name: str, by: float) -> ss.Trajectory:
        start, other = np.array(START), model
        if name.startswith("initial."):
            start[run.state_names.index(name.removeprefix("initial."))] += by
        else:
            other = model.replace({name: model.parameters[name] + by})
        return ss.simulate(other, initial=start, **tight)  # type: ignore[arg-type]

    for k, name in enumerate(names):
        size = 0.02 if name.startswith("initial.") else model.parameters[name]
        step = 2e-5 * size
        sides = {i: moved(name, i * step) for i in (-3, -2, -1, 1, 2, 3)}
        still = np.all([(one.mode == run.mode).all(axis=1) for one in sides.values()], axis=0)
        assert still.mean() > 0.95
        for channel, slopes in run.sensed_sensitivity.items():
            f = {i: one.sensed[channel] for i, one in sides.items()}
            found = (45 * (f[1] - f[-1]) - 9 * (f[2] - f[-2]) + (f[3] - f[-3])) / (60 * step)
            scale = np.abs(slopes[:, k]).max() + 1e-6 * np.abs(run.sensed[channel]).max() / size
            assert slopes[still, k] == pytest.approx(found[still], abs=2e-7 * scale), (name, channel)


def test_what_is_not_there_is_said() -> None:
    case = CASES["pin"]()
    run = ss.simulate(case.model, belt_speed=0.05, initial=case.initial, t_end=0.1)
    assert run.contact_force() is run.contact_force("contact_1")
    with pytest.raises(InputError, match="a rig by its matrices has no links"):
        run.link_force("link_1")
    with pytest.raises(
        InputError, match=r"contact_force = 'contact_2': no such place; did you mean 'contact_1'\?"
    ):
        run.contact_force("contact_2")
    wavy = ss.simulate(WAVES, initial=START, t_end=0.1, **MOVED)  # type: ignore[arg-type]
    with pytest.raises(InputError, match="link_force = 'link_4': no such place"):
        wavy.link_force("link_4")
    named = ss.simulate(
        ss.Model(ss.BlockOnBelt(mass=1, stiffness=1), friction=ss.CoulombFriction(static=2, kinetic=1)),
        belt_speed=0.1,
        t_end=1.0,
    )
    with pytest.raises(InputError, match="is kept of a rig of bodies or matrices"):
        _ = named.acceleration


def test_names_that_a_sensor_has_are_taken() -> None:
    with pytest.raises(InputError, match="'a_x' names a coordinate and what a sensor reads of another"):
        ss.BodiesRig(body={"x": ss.Body(mass=1), "a_x": ss.Body(mass=1)}, contact=[ss.Contact(body="x")])
    with pytest.raises(InputError, match="'T_x' names a coordinate and what a sensor reads of another"):
        ss.BodiesRig(body={"x": ss.Body(mass=1), "T_x": ss.Body(mass=1)}, contact=[ss.Contact(body="x")])
