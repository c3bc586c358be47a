"""A driven slider in motion, against closed forms and an adaptive integrator."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
import pytest
import scipy

import driven_truth as truth
import stickslip as ss
from every_effect import usual
from stickslip.declared.effect import DRIVEN
from stickslip.declared.effect_terms import At
from stickslip.declared.rig import DrivenSlider
from stickslip.errors import InputError
from stickslip.simulated.driven_slider import Loop, Slider, closed_loop, forecast

LAW = ss.CoulombFriction(
    static=truth.MINUS, kinetic=truth.MINUS, static_plus=truth.PLUS, kinetic_plus=truth.PLUS
)


def model(*effects: ss.Effect) -> ss.Model:
    return ss.Model(DrivenSlider(mass=truth.MASS, damping=truth.DAMPING), friction=LAW, effects=effects)


def exact(forces: np.ndarray, x: float, v: float, h: float) -> np.ndarray:
    out = [x]
    for force in forces:
        x, v = truth.moved(x, v, float(force), h)
        out.append(x)
    return np.array(out)


@pytest.mark.parametrize("seed", range(4))
def test_turns_and_rests_follow_the_closed_form(seed: int) -> None:
    generator = np.random.default_rng(seed)
    forces = np.repeat(generator.uniform(-15, 15, 40), 25)
    t = np.arange(len(forces) + 1) / truth.RATE
    command = np.append(forces, 0.0)
    ours = forecast(model(), t, command, np.array([0]), np.array([0.0]), np.array([0.02]), len(forces))[:, 0]
    theirs = exact(forces, 0.0, 0.02, 1 / truth.RATE)
    assert np.max(np.abs(ours - theirs)) < 2e-3 * np.ptp(theirs)


def test_the_error_shrinks_with_the_substep() -> None:
    forces = 20 * np.sin(np.arange(300) / 40)
    theirs = exact(forces, 0.0, 0.1, 1 / truth.RATE)[-1]
    errors = []
    for substeps in (4, 32):
        slider = Slider(model(), 1 / truth.RATE, substeps=substeps)
        s = slider.start(np.zeros(1), np.array([0.1]), np.zeros(1))
        for force in forces:
            slider.step(s, 0.0, lambda _, force=force: np.array([force]))
        errors.append(abs(float(s.x[0]) - theirs))
    assert errors[1] < 0.3 * errors[0]


def test_it_rests_while_the_drive_is_below_friction() -> None:
    t = np.arange(200) / truth.RATE
    command = np.where(t < 0.2, 4.9, 5.5)
    path = forecast(model(), t, command, np.array([0]), np.zeros(1), np.zeros(1), 150)[:, 0]
    assert np.ptp(path[:100]) == 0
    assert path[-1] > 0


# force on the slider from position x, velocity v > 0, time t and drive f, beside damping and plain friction
# ruff: noqa: ARG005
SMOOTH = {
    "viscous_asymmetry": ({"c": 8.0}, lambda x, v, t, f: f - 8 * abs(v)),
    "block_quadratic_damping": ({"c": 90.0}, lambda x, v, t, f: f - 90 * v * abs(v)),
    "position_load": ({"k": 40.0}, lambda x, v, t, f: f - 40 * x),
    "load_drift": ({"r": 3.0}, lambda x, v, t, f: f + 3 * t),
    "position_ripple": (
        {"a": 3.0, "L": 0.03, "phi": 1.0},
        lambda x, v, t, f: f + 3 * np.sin(2 * np.pi * x / 0.03 + 1),
    ),
    "drive_ripple": (
        {"a": 0.2, "L": 0.03, "phi": 1.0},
        lambda x, v, t, f: f * (1 + 0.2 * np.sin(2 * np.pi * x / 0.03 + 1)),
    ),
    "friction_ripple": (
        {"a": 0.3, "L": 0.05, "phi": 0.0},
        lambda x, v, t, f: f - truth.PLUS * 0.3 * np.sin(2 * np.pi * x / 0.05),
    ),
    "position_friction": ({"r": 2.0}, lambda x, v, t, f: f - truth.PLUS * 2 * x),
    "friction_drift": ({"r": 0.4}, lambda x, v, t, f: f - truth.PLUS * 0.4 * t),
    "drive_gain_drift": ({"r": 0.1}, lambda x, v, t, f: f * (1 + 0.1 * t)),
    "drive_nonlinearity": ({"q": 0.01}, lambda x, v, t, f: f * (1 + 0.01 * abs(f))),
    "harmonic_forcing": ({"a": 3.0, "w": 20.0, "phi": 0.4}, lambda x, v, t, f: f + 3 * np.sin(20 * t + 0.4)),
    "stribeck_peak": ({"dT": 2.0, "v_s": 0.2}, lambda x, v, t, f: f - 2 * np.exp(-((v / 0.2) ** 2))),
    "viscous_saturation": ({"dT": 2.0, "v_s": 0.2}, lambda x, v, t, f: f - 2 * (1 - np.exp(-v / 0.2))),
}


def stated(name: str, numbers: Mapping[str, float]) -> Callable[..., Any]:
    """The force on the slider by what an effect states for rigs of any kind.

    A change of the drive is stated nowhere else: there the effect's own formula says whether the slider uses it.
    """
    kind = DRIVEN[name]
    functions = {"sin": np.sin, "exp": np.exp, "sqrt": np.sqrt, "abs": np.abs, "pi": np.pi}
    functions |= {"min": np.minimum, "max": np.maximum}

    def force(x: Any, v: Any, t: Any, f: Any) -> Any:
        own = {**functions, **numbers, "t": t, "v": v, "u": abs(v), "position": x}
        own |= {"deflection": x, "deflection_rate": v}
        if kind.anywhere.force is not None:
            return f + eval(kind.anywhere.force, own)
        if kind.anywhere.factor is not None:
            return f - truth.PLUS * (eval(kind.anywhere.factor, own) - 1)
        if kind.anywhere.peak is not None:
            return f - eval(kind.anywhere.peak, own)
        assert kind.adds.drive is not None, f"say above what {name} does to a driven slider"
        return f * (1 + kind.adds.drive(numbers, At(x1=x, x2=v, t=t, drive=f)))

    return force


def of_some_newtons(name: str) -> dict[str, float]:
    """The usual numbers of an effect, the first that acts linearly such that the slider feels 3 N."""
    numbers = dict(usual(name))
    felt = abs(stated(name, numbers)(0.02, 0.2, 1.7, 25.0) - 25.0)
    linear = [one.name for one in DRIVEN[name].parameters if one.spread is not None]
    return numbers | {one: numbers[one] * 3.0 / felt for one in linear[:1] if felt}


# a screw's second and third wave are forces as the first
SMOOTH |= dict.fromkeys(("position_ripple_2", "position_ripple_3"), SMOOTH["position_ripple"])
ELSEWHERE = {"drive_lag", "drive_delay", "contact_compliance", "rig_mass"}  # with tests of their own
BY_HAND = tuple(SMOOTH)
for _name in DRIVEN:
    if _name not in {*SMOOTH, *ELSEWHERE}:
        SMOOTH[_name] = (own := of_some_newtons(_name)), stated(_name, own)


@pytest.mark.parametrize("name", [name for name in SMOOTH if DRIVEN[name].adds.block])
def test_a_force_on_the_slider_is_its_formula_whichever_way_it_moves(name: str) -> None:
    """An asymmetry of the damping that read v for |v| passed: all formulas were tried at v > 0."""
    numbers, formula = SMOOTH[name]
    x, v, t = (one.ravel() for one in np.meshgrid([-0.02, 0.013], [-0.3, -0.01, 0.0, 0.2], [0.0, 1.7]))
    ours = Slider(model(ss.effect(name, **numbers)), 1 / truth.RATE).block(x, v, t)
    np.testing.assert_allclose(ours, formula(x, v, t, 0.0), rtol=1e-13, atol=1e-15)


@pytest.mark.parametrize(
    "name", [name for name in SMOOTH if DRIVEN[name].adds.friction or DRIVEN[name].adds.peak]
)
def test_a_change_of_friction_is_its_formula_against_either_way(name: str) -> None:
    numbers, formula = SMOOTH[name]
    x, v, t = (one.ravel() for one in np.meshgrid([-0.02, 0.013], [0.01, 0.2], [0.0, 1.7]))
    more = -formula(x, v, t, 0.0)  # of friction at v > 0
    share = bool(DRIVEN[name].adds.friction)
    for way in (1, -1):
        low, high = Slider(model(ss.effect(name, **numbers)), 1 / truth.RATE).limits(x, way * v, t)
        np.testing.assert_allclose(high, truth.PLUS + more, rtol=1e-13)
        scaled = more * truth.MINUS / truth.PLUS if share else more
        np.testing.assert_allclose(low, truth.MINUS + scaled, rtol=1e-13)


def numbers_of(name: str) -> dict[str, float]:
    """Numbers of an effect, of a size that shows."""
    own = {
        "drive_lag": {"tau": 0.02},
        "drive_delay": {"delay": 0.01},
        "contact_compliance": {"k": 2000.0, "c": 4.0},
        "rig_mass": {"e": 0.2},
    }
    return own[name] if name in own else SMOOTH[name][0]


LOOP = Loop(truth.GAIN, truth.KP, truth.KV, limit=1e9)


def in_the_loop(*effects: ss.Effect) -> np.ndarray:
    t = np.arange(250) / truth.RATE
    return closed_loop(model(*effects), LOOP, t, truth.reference(t)).command


def ahead(*effects: ss.Effect) -> np.ndarray:
    t = np.arange(301) / truth.RATE
    return forecast(model(*effects), t, 25 * np.sin(8 * t), np.array([0]), np.zeros(1), np.array([0.05]), 300)


@pytest.mark.sampled(8)
@pytest.mark.parametrize("moved", [in_the_loop, ahead])
@pytest.mark.parametrize("name", DRIVEN)
def test_every_number_of_every_effect_acts(name: str, moved: Callable[..., np.ndarray]) -> None:
    numbers = numbers_of(name)
    plain, whole = moved(), moved(ss.effect(name, **numbers))
    least = 1e-5 * np.ptp(plain)
    assert np.max(np.abs(whole - plain)) > least
    for key, value in numbers.items():
        other = moved(ss.effect(name, **{**numbers, key: 1.3 * value + 0.1 * (value == 0)}))
        assert np.max(np.abs(other - whole)) > least, key


def test_a_bristle_s_damping_brakes_as_its_formula_says() -> None:
    """T = k z + c v: c was read and did nothing."""
    k, c, drive = 2000.0, 20.0, 25.0
    mean = 0.5 * (truth.MINUS + truth.PLUS)
    t = np.arange(301) / truth.RATE

    def rate(_: float, state: np.ndarray) -> list[float]:
        _, v, z = state  # z relative to its end, T at large deflection
        friction = truth.PLUS * z + c * v
        return [v, (drive - truth.DAMPING * v - friction) / truth.MASS, k / mean * (v - abs(v) * z)]

    theirs = scipy.integrate.solve_ivp(rate, (0, t[-1]), [0, 0.05, 1], rtol=1e-10, atol=1e-12).y[0, -1]
    soft = model(ss.effect("contact_compliance", k=k, c=c))
    command, start = np.full(len(t), drive), np.array([0])
    ours = forecast(soft, t, command, start, np.zeros(1), np.array([0.05]), 300)[-1, 0]
    assert ours == pytest.approx(theirs, rel=2e-3)


def test_a_loop_whose_drive_acts_before_its_command_is_refused() -> None:
    with pytest.raises(InputError, match=r"drive_delay.delay = -0.01: a loop cannot act before"):
        in_the_loop(ss.effect("drive_delay", delay=-0.01))


@pytest.mark.parametrize("name", [name for name in BY_HAND if not DRIVEN[name].anywhere.refused])
def test_what_an_effect_states_for_any_rig_is_its_formula_here(name: str) -> None:
    numbers, ours = SMOOTH[name]
    x, v, t, f = np.meshgrid([-0.02, 0.013], [0.01, 0.2], [0.3, 1.7], [-20.0, 25.0])
    np.testing.assert_allclose(stated(name, numbers)(x, v, t, f), ours(x, v, t, f), rtol=1e-12)


def test_a_wrong_mass_is_another_mass() -> None:
    t = np.arange(301) / truth.RATE
    command, start = 25 * np.sin(8 * t), np.array([0])
    heavy = ss.Model(DrivenSlider(mass=1.2 * truth.MASS, damping=truth.DAMPING), friction=LAW)
    ours, theirs = (
        forecast(one, t, command, start, np.zeros(1), np.array([0.05]), 300)
        for one in (model(ss.effect("rig_mass", e=0.2)), heavy)
    )
    np.testing.assert_allclose(ours, theirs, rtol=1e-12)


@pytest.mark.sampled(3)
@pytest.mark.parametrize("where", ["block", "contact", "angle_body", "x1 channel", "y1 channel"])
@pytest.mark.parametrize("variable", ["x1", "x2", "v_w", "t", "y1", "y2"])
def test_a_curve_acts_or_is_refused(where: str, variable: str) -> None:
    if where.endswith("channel") and variable == "v_w":
        return  # no curve of a reading at all
    curve = ss.tabulated(where, variable, [-0.5, 0, 0.5], [-0.2, 0.1, 0.3])
    if where not in ("block", "contact") or variable.startswith("y"):
        with pytest.raises(InputError, match=r"angle body|is read as it is"):
            model(curve)
        return
    t = np.arange(301) / truth.RATE
    command, start = 25 * np.sin(8 * t), np.array([0])
    ours, plain = (
        forecast(one, t, command, start, np.zeros(1), np.array([0.05]), 300)
        for one in (model(curve), model())
    )
    assert np.max(np.abs(ours - plain)) > 1e-4 * np.ptp(plain)


@pytest.mark.sampled(5)
@pytest.mark.parametrize("name", SMOOTH)
def test_each_effect_moves_it_as_its_formula_says(name: str) -> None:
    numbers, force = SMOOTH[name]
    t = np.arange(301) / truth.RATE
    drive = 25.0

    def rate(now: float, state: np.ndarray) -> list[float]:
        x, v = state
        return [v, (force(x, v, now, drive) - truth.DAMPING * v - truth.PLUS) / truth.MASS]

    theirs = scipy.integrate.solve_ivp(rate, (0, t[-1]), [0.0, 0.05], rtol=1e-10, atol=1e-12).y[0, -1]
    start = np.array([0])
    command = np.full(len(t), drive)
    ours = forecast(model(ss.effect(name, **numbers)), t, command, start, np.zeros(1), np.array([0.05]), 300)[
        -1, 0
    ]
    plain = forecast(model(), t, command, start, np.zeros(1), np.array([0.05]), 300)[-1, 0]
    assert abs(ours - theirs) < 2e-3 * abs(theirs)
    assert abs(ours - theirs) < 0.1 * abs(plain - theirs)


def test_a_lag_and_a_delay_put_off_a_step_of_the_drive() -> None:
    t = np.arange(401) / truth.RATE
    command = np.where(np.arange(401) < 100, 12.0, 30.0)
    start, x, v = np.array([0]), np.zeros(1), np.array([0.05])
    plain, lagged, late = (
        forecast(one, t, command, start, x, v, 400)[:, 0]
        for one in (
            model(),
            model(ss.effect("drive_lag", tau=0.01)),
            model(ss.effect("drive_delay", delay=0.01)),
        )
    )
    # both act like the same force 10 ms later: the impulse lacking is 18 N * 10 ms
    lost = 18.0 * 0.01 / truth.MASS * truth.MASS / truth.DAMPING
    for path in (lagged, late):
        share = 1 - np.exp(-truth.DAMPING / truth.MASS * (t[-1] - t[100]))
        assert plain[-1] - path[-1] == pytest.approx(lost * share, rel=0.06)


def test_a_bristle_turns_the_jump_of_friction_into_a_slope() -> None:
    t = np.arange(101) / truth.RATE
    soft = model(ss.effect("contact_compliance", k=2000.0, c=0.0))
    path = forecast(soft, t, np.full(101, 3.0), np.array([0]), np.zeros(1), np.zeros(1), 100)[:, 0]
    hard = forecast(model(), t, np.full(101, 3.0), np.array([0]), np.zeros(1), np.zeros(1), 100)[:, 0]
    assert np.ptp(hard) == 0
    assert 0 < path[-1] < 0.05


def test_the_loop_is_the_published_controller() -> None:
    t = np.arange(800) / truth.RATE
    goal = truth.reference(t)
    loop = Loop(truth.GAIN, truth.KP, truth.KV, limit=1e9)
    run = closed_loop(model(), loop, t, goal, substeps=32)
    _, x, command = truth.record(800 / truth.RATE, noise=0.0)
    assert np.max(np.abs(run.x - x)) < 2e-5
    assert np.max(np.abs(run.command - command)) < 0.02 * np.ptp(command)


def test_other_rigs_and_laws_are_refused() -> None:
    with pytest.raises(InputError, match="only a driven slider"):
        Slider(ss.Model(ss.BlockOnBelt(), friction=LAW), 1e-3)
    for law in (ss.PaperFriction(), ss.HyperbolicFriction()):
        with pytest.raises(InputError, match="is coulomb"):
            ss.Model(DrivenSlider(mass=1.0), friction=law)
