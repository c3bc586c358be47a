"""Events at one instant on rigs of bodies: corners of speeds, kinks of several formulas, contacts that do the same.

Each was a wrong motion, or a run that ended early, on some processors or on all of them; which event comes first was
rounding's choice.
"""

from __future__ import annotations

import numpy as np
import pytest
import scipy

import stickslip as ss
from stickslip.errors import InputError

S = ss.Speed


def rig(
    k: float = 1.0, against: str = "ground", m: float = 1.0, bodies: str = "a", c: float = 0.0
) -> ss.BodiesRig:
    return ss.BodiesRig(
        body={name: ss.Body(mass=m) for name in bodies},
        link=[ss.Link(between=(name, "ground"), stiffness=k, damping=c) for name in bodies] if k else [],
        contact=[ss.Contact(body=name, against=against) for name in bodies],
    )


def coulomb(static: float, kinetic: float) -> ss.CoulombFriction:
    return ss.CoulombFriction(static=static, kinetic=kinetic)


def factor(text: str) -> ss.FormulaEffect:
    return ss.effect("formula", called="factor", where="a", factor=text)


def force(text: str, called: str) -> ss.FormulaEffect:
    return ss.effect("formula", called=called, where="a", force=text)


def end(model: ss.Model, **run: object) -> ss.Trajectory:
    out = ss.simulate(model, **run)
    assert out.t[-1] == run["t_end"], str(out.status)
    return out


@pytest.mark.parametrize("make", [lambda: ss.BlockOnBelt(mass=1, stiffness=1), lambda: rig(against="belt")])
@pytest.mark.parametrize("until", [0.3, 0.7, 1.1])
def test_a_block_stays_where_its_belt_comes_to_rest(make, until: float) -> None:
    """Its speed and the belt's are then both rounding, and do not say that it slips."""
    speed = S.measured([0, until, 3], [0.1, 0, 0])
    run = end(ss.Model(make(), friction=coulomb(1, 0.25)), initial=(0.4, 0.1), belt_speed=speed, t_end=4)
    assert len(run.transitions) == 0
    np.testing.assert_allclose(run.state[-1], [0.4 + 0.05 * until, 0.0], atol=1e-12)


def test_what_rests_stays_at_a_corner_of_a_drive_that_does_not_jump() -> None:
    rests = ss.MatricesRig(
        M=[[3, 1], [1, 2]], K=[[2, -1], [-1, 2]], C=[[0.5, 0], [0, 0.5]], contact=[[1, 0], [0, 1]],
        against="ground", names=["x", "y"], drive_stiffness=[0.1, 0],
    )  # fmt: skip
    drive = S.measured([0, 30, 31], [0, 0, 0.001])
    run = end(ss.Model(rests, friction=coulomb(1, 0.2)), initial=(0.5, -1, 0, 0), drive_speed=drive, t_end=40)
    assert run.transitions.t[-1] < 29
    before = run.transitions.state[-1]
    np.testing.assert_allclose(run.state[-1], before, atol=1e-9)


@pytest.mark.parametrize("growth", [0.0, 0.5])
def test_a_contact_rests_on_through_corners(growth: float) -> None:
    """The dwell goes on, too: static friction of 1 + growth (1 - exp(-dwell)) holds until the spring has it."""
    aging = [ss.effect("static_aging", where="a", dT=growth, tau=1.0)] if growth else []
    times = np.linspace(0, 40, 401)
    speed = S.measured(times, 0.05 + 0.01 * np.sin(times))
    run = end(
        ss.Model(rig(against="belt"), friction=coulomb(1, 0.5), effects=aging),
        initial=(0, speed(0.0)), belt_speed=speed, t_end=40,
    )  # fmt: skip
    first = run.transitions.t[0]
    slopes = sorted(float(speed(first + s * 1e-6) - speed(first)) / (s * 1e-6) for s in (-1, 1))
    limit = 1 + growth * (
        1 - np.exp(-first)
    )  # what is asked of the contact jumps with the belt's acceleration
    low, high = (float(speed.way(first)) + one for one in slopes)
    assert low - 1e-7 <= limit <= high + 1e-7


TABLE = ss.TabulatedFriction(speeds=[0, 0.5, 1], forces=[1, 0.5, 0.75], static=1)
LAWS = {
    "tabulated": (TABLE, TABLE.magnitude),
    "a dip": (
        ss.FormulaFriction(kinetic="0.5 + 0.25*abs(u - 0.5)", static="1"),
        lambda u: 0.5 + 0.25 * abs(u - 0.5),
    ),
    "a ceiling": (ss.FormulaFriction(kinetic="min(1, 0.5 + u)", static="1"), lambda u: min(1, 0.5 + u)),
    "a floor": (ss.FormulaFriction(kinetic="max(0.5, 1 - u)", static="1"), lambda u: max(0.5, 1 - u)),
}


@pytest.mark.parametrize("jump", [(0.4, 1.0), (0.4, 2.0), (1.5, 0.75), (2.0, 0.4)])
@pytest.mark.parametrize("law", LAWS)
def test_a_step_of_the_belt_takes_a_law_over_its_kinks(law: str, jump: tuple[float, float]) -> None:
    made, friction = LAWS[law]
    run = end(
        ss.Model(rig(against="belt"), friction=made), initial=(0, 0), belt_speed=S.steps([0, 0.05], jump),
        t_end=0.3, rtol=1e-11, atol=1e-11,
    )  # fmt: skip
    state = np.zeros(2)
    for (begin, stop), speed in zip(((0, 0.05), (0.05, 0.3)), jump, strict=True):
        state = scipy.integrate.solve_ivp(
            lambda _, y, V=speed: [y[1], -y[0] + float(friction(V - y[1]))], (begin, stop), state,
            rtol=1e-9, atol=1e-11, max_step=5e-3,
        ).y[:, -1]  # fmt: skip
    np.testing.assert_allclose(run.state[-1], state, atol=1e-7)


def test_an_event_at_the_very_time_of_a_corner() -> None:
    """The spring has the static limit where the belt slows down; a free block comes to rest where its belt starts."""
    slower = end(
        ss.Model(rig(against="belt"), friction=coulomb(1, 0.5)), initial=(1 - 0.3 * 0.7, 0.3),
        belt_speed=S.steps([0, 0.7], [0.3, 0.1]), t_end=0.8,
    )  # fmt: skip
    # from rest on the old belt it slips forward on the new one: x'' = -x - 0.5
    t = 0.1
    np.testing.assert_allclose(slower.a[-1], 1.5 * np.cos(t) + 0.3 * np.sin(t) - 0.5, atol=1e-9)
    starts = 0.5 * 0.5 / 0.3
    free = end(
        ss.Model(rig(k=0, against="belt", m=0.5), friction=coulomb(0.6, 0.3)), initial=(0, 0.5),
        belt_speed=S.steps([0, starts], [0, 0.1]), t_end=2,
    )  # fmt: skip
    catches = starts + 0.1 * 0.5 / 0.3
    x = 0.25 * starts + 0.05 * (catches - starts) + 0.1 * (2 - catches)
    np.testing.assert_allclose(free.state[-1], [x, 0.1], atol=1e-9)


def test_one_surface_in_several_formulas_is_passed_in_all() -> None:
    """Forces by abs and by sign of one wave, and static limits of both directions by one, at every zero of the wave."""
    waves = [force("0.5*abs(sin(t))", "p"), force("0.2*sign(sin(t))", "q")]
    held = end(ss.Model(rig(), friction=coulomb(1.2, 0.8), effects=waves), initial=(0.3, 0), t_end=12)
    np.testing.assert_allclose(held.state[-1], [0.3, 0], atol=1e-12)
    free = ss.Model(rig(c=0.1), friction=coulomb(0, 0), effects=waves)
    run = end(free, initial=(0.3, 0), t_end=12, rtol=1e-11, atol=1e-11)
    state = np.array([0.3, 0.0])
    for k in range(4):
        sign = 1 if k % 2 == 0 else -1
        state = scipy.integrate.solve_ivp(
            lambda t, y, s=sign: [y[1], -y[0] - 0.1 * y[1] + s * (0.5 * np.sin(t) + 0.2)],
            (k * np.pi, min((k + 1) * np.pi, 12)), state, rtol=1e-11, atol=1e-12,
        ).y[:, -1]  # fmt: skip
    np.testing.assert_allclose(run.state[-1], state, atol=1e-8)
    stuck = end(
        ss.Model(rig(), friction=coulomb(1, 0.8), effects=[factor("1 + 0.5*abs(sin(t))")]),
        initial=(0.5, 0.5),
        t_end=12,
    )
    assert (stuck.mode[-1] == 0).all()


@pytest.mark.parametrize("speed", ["0.5*t", "t*t"])
@pytest.mark.parametrize("knots", [(0, 0.3, 0.7), (0, 0.5, 1)])
def test_equal_blocks_pass_the_knots_of_their_law_together(speed: str, knots: tuple[float, ...]) -> None:
    law = ss.TabulatedFriction(speeds=knots, forces=[1, 0.5, 0.75], static=1)
    both, one = (
        end(
            ss.Model(rig(against="belt", bodies=bodies, c=0.1), friction=law),
            initial=[0.1] * len(bodies) + [0.0] * len(bodies), belt_speed=speed, t_end=6,
        )
        for bodies in ("ab", "a")
    )  # fmt: skip
    np.testing.assert_allclose(both.a[-1], one.a[-1], atol=1e-8)
    np.testing.assert_allclose(both.b[-1], one.a[-1], atol=1e-8)


@pytest.mark.parametrize("text", ["max(1, 1 - abs(u - 0.5))", "min(1, 1 + abs(u - 1))"])
def test_a_bound_that_only_touches_is_not_passed(text: str) -> None:
    """The law is 1 at every speed."""
    ours, plain = (
        end(ss.Model(rig(), friction=law), initial=(-0.5, -1.5), t_end=4)
        for law in (ss.FormulaFriction(kinetic=text, static="1"), coulomb(1, 1))
    )
    np.testing.assert_allclose(ours.state[-1], plain.state[-1], atol=1e-8)


def test_a_contact_that_lets_go_at_a_kink_is_beyond_it() -> None:
    """Carried over position 0 its friction falls to 1, below the load of 1.5: it falls on with -1, as R is 1 there."""
    load = ss.effect("constant_load", where="a", f=1.5)
    model = ss.Model(
        rig(k=0, against="belt"), friction=coulomb(2, 2), effects=[factor("1 + 0.5*sign(position)"), load]
    )
    run = end(model, initial=(0.5, 0), belt_speed="-t", t_end=4)
    t = 3.0  # from t = 1 with v = -1: v' = 1.5 - 1
    np.testing.assert_allclose(run.state[-1], [-t + 0.25 * t**2, -1 + 0.5 * t], atol=1e-9)


def test_a_force_by_the_size_of_a_speed_begins_on_the_side_that_the_body_goes_to() -> None:
    drag = ss.effect("block_quadratic_damping", where="a", c=0.25)
    for seed in range(12):
        rng = np.random.default_rng(seed)
        start = rng.uniform(1.0, 2.5), 1.0
        end(
            ss.Model(rig(k=2.0, m=2.0), friction=coulomb(1, 1), effects=[force("0.5*sin(t)", "w"), drag]),
            initial=start,
            t_end=15,
        )


def test_a_belt_that_jumps_the_way_a_slip_has_just_begun_moves_no_body() -> None:
    """The spring has the static limit where the belt speeds up: friction is bounded, and no speed jumps."""
    run = end(
        ss.Model(rig(against="belt"), friction=coulomb(1, 0.5)), initial=(1 - 0.3 * 0.7, 0.3),
        belt_speed=S.steps([0, 0.7], [0.3, "0.8 - 5*(t - 0.7)"]), t_end=0.75,
    )  # fmt: skip
    t = 0.05  # it slips back on the faster belt: x'' = 0.5 - x
    np.testing.assert_allclose(run.a[-1], 0.5 + 0.5 * np.cos(t) + 0.3 * np.sin(t), atol=1e-9)
    np.testing.assert_allclose(run.v_a[-1], -0.5 * np.sin(t) + 0.3 * np.cos(t), atol=1e-9)


def test_three_kinks_at_one_place_are_passed() -> None:
    """On some processors two of them were passed to and fro without end, where it slips at 3.92."""
    text = "-0.25*sign(deflection) - abs(deflection) + max(0, -deflection)"
    model = ss.Model(rig(k=2.0, m=3.0, c=0.1), friction=coulomb(1, 0.5), effects=[force(text, "w")])
    ours, near = (end(model, initial=(q, -1.5), t_end=10) for q in (0.3, 0.3 + 1e-9))
    np.testing.assert_allclose(ours.state[-1], near.state[-1], atol=1e-7)


def test_a_release_by_a_jump_does_not_hang_on_the_limit() -> None:
    """A force that jumps takes a stuck block beyond its limit: when is the time of the jump, whatever the spring."""
    jump = force("0.5*sign(1 - t) + 0.5*abs(t - 1)", "w")
    pulled = ss.Model(rig(k=1.0, m=4.0), friction=coulomb(1, 1), effects=[jump])

    def run(k: float, **more: object) -> ss.Trajectory:
        return end(
            pulled.replace({"link_1.stiffness": k}), initial=(1, 0), t_end=2, rtol=1e-12, atol=1e-12, **more
        )

    h = 1e-6
    moved = (run(1 + h).state[-1] - run(1 - h).state[-1]) / (2 * h)
    seeds = run(1.0, sensitivity=["link_1.stiffness"]).sensitivity[-1, :, 0]
    np.testing.assert_allclose(seeds, moved, atol=1e-5)


def test_derivatives_by_a_link_beside_a_contact_that_an_effect_adds() -> None:
    pair = ss.BodiesRig(
        body={"a": ss.Body(mass=1), "b": ss.Body(mass=1)}, link=[ss.Link(between=("a", "b"), stiffness=1)],
        contact=[ss.Contact(body="b")],
    )  # fmt: skip

    def run(k: float, **more: object) -> ss.Trajectory:
        one = ss.effect("pivot_dry_friction", where="a", f=0.1)
        model = ss.Model(pair, friction=coulomb(1, 0.5), effects=[one]).replace({"link_1.stiffness": k})
        return end(model, initial=(0.9, 0, 0, 0), t_end=3, rtol=1e-12, atol=1e-12, **more)

    h = 1e-5
    seeds = run(1.0, sensitivity=["link_1.stiffness"])
    moved = (run(1 + h).state[-1] - run(1 - h).state[-1]) / (2 * h)
    np.testing.assert_allclose(seeds.sensitivity[-1, :, 0], moved, atol=1e-6)


def test_what_is_no_speed_is_refused() -> None:
    with pytest.raises(InputError):
        S.steps([0, 0], [1, 2])
