"""Effects by a formula, and those of the catalogue, on rigs of bodies and matrices."""

from __future__ import annotations

import math
import re
from pathlib import Path

import numpy as np
import pytest
import scipy

import stickslip as ss
from every_effect import made
from stickslip.declared.effect import KINDS
from stickslip.errors import InputError
from studies import few

TIGHT = {"rtol": 1e-12, "atol": 1e-12}
TIMES = np.linspace(0.0, 12.0, 121)
SOON = TIMES[:21]  # the plain simulator takes seconds for each second of a motion


def string(*effects: object, law: ss.FormulaFriction | None = None) -> ss.Model:
    """A drill string whose bit rubs on the ground."""
    rig = ss.BodiesRig(
        body={"table": ss.Body(inertia="0.35 kg m^2"), "bit": ss.Body(inertia="0.04 kg m^2")},
        link=[
            ss.Link(between=("table", "bit"), stiffness="12 N m/rad", damping="0.01 N m s/rad"),
            ss.Link(between=("table", "drive"), stiffness="80 N m/rad"),
        ],
        contact=[ss.Contact(body="bit", against="ground")],
    )
    usual = ss.StribeckFriction(F_c="1.2 N m", F_s="2 N m", v_s="10 rpm")
    return ss.Model(rig, friction=law or usual, effects=effects)


def block(*effects: object, friction: ss.FrictionLaw | None = None) -> ss.Model:
    """A block on a belt, by its bodies."""
    rig = ss.BodiesRig(
        body={"block": ss.Body(mass=1)},
        link=[ss.Link(between=("block", "ground"), stiffness=1, damping=0.02)],
        contact=[ss.Contact(body="block", against="belt")],
    )
    return ss.Model(rig, friction=friction or ss.CoulombFriction(static=1.0, kinetic=0.5), effects=effects)


def moved(model: ss.Model, **options: object) -> ss.Trajectory:
    given = (
        {"belt_speed": 0.2, "initial": (0.1, 0.1)}
        if "block" in model.rig.state_names
        else {"drive_speed": 1.26}
    )
    run = ss.simulate(model, **{**given, "t_end": TIMES[-1], "t_eval": TIMES, **TIGHT, **options})
    assert run.status.ok
    return run


STOP = "-k*max(0, abs(deflection) - d)*sign(deflection)"
FORMULAS = {
    "a force on a body": {"where": "bit", "force": "-c*v_bit*abs(v_bit)", "c": "0.02 N m s^2/rad^2"},
    "a force on a link": {"where": "link_1", "force": STOP, "k": 30.0, "d": 0.1},
    "with a state": {
        "where": "table", "force": "-k*z", "k": 3.0, "tau": 0.4,
        "states": {"z": {"rate": "(table - z)/tau", "start": "table"}},
    },
    "a factor on friction": {"where": "bit", "factor": "1 + a*sin(3*position)*u/(u + w)", "a": 0.2, "w": 1.0},
    "a factor on a number": {"where": "bit.F_s", "factor": "1 + a*sin(w*t)", "a": 0.2, "w": 0.7},
    "a factor on a speed": {"where": "drive", "factor": "1 + a*sin(w*t)", "a": 0.3, "w": 1.7},
    "a factor with a state": {
        "where": "bit", "factor": "1 + a*theta", "a": -0.3, "tau": 2.0,
        "states": {"theta": {"rate": "(u/(u + 1) - theta)/tau"}},
    },
}  # fmt: skip


@pytest.mark.sampled(1)
@pytest.mark.parametrize("name", few(FORMULAS, ["with a state", "a factor on friction"]))
def test_a_formula_acts_as_the_plain_simulator_says(name: str) -> None:
    model = string(ss.effect("formula", **FORMULAS[name]))
    soon = {"t_end": SOON[-1], "t_eval": SOON}
    ours = moved(model, **soon)
    theirs = ss.reference.simulate_bodies(model, drive_speed=1.26, initial=[0.0] * 4, **soon, tol=1e-11)
    np.testing.assert_allclose(ours.state, theirs.state, atol=2e-7)
    assert np.max(np.abs(ours.state - moved(string(), **soon).state)) > 1e-3


@pytest.mark.parametrize("name", FORMULAS)
def test_derivatives_by_the_numbers_of_a_formula(name: str) -> None:
    model = string(ss.effect("formula", **FORMULAS[name]))
    asked = [one for one in model.parameters if one.startswith("formula.")]
    run = moved(model, t_end=6.0, t_eval=[6.0], sensitivity=asked)
    for i, one in enumerate(asked):
        h = 1e-6 * abs(model.parameters[one])
        ends = [
            moved(model.replace({one: model.parameters[one] + s * h}), t_end=6.0, t_eval=[6.0]).state[0]
            for s in (-1, 1)
        ]
        np.testing.assert_allclose(
            run.sensitivity[0, :, i], (ends[1] - ends[0]) / (2 * h), rtol=2e-5, atol=1e-6
        )


def test_a_force_and_a_state_against_scipy() -> None:
    """Written out by hand, while the bit slips one way."""
    effects = [
        ss.effect("formula", where="bit", force="-c*v_bit*abs(v_bit)", c=0.05),
        ss.effect("formula", called="lagged", where="table", force="-k*z", k=3.0,
                  states={"z": {"rate": "(table - z)/0.4"}}),
    ]  # fmt: skip
    start = [0.2, 0.1, 6.0, 6.0]
    run = ss.simulate(
        string(*effects, law=ss.CoulombFriction(static=0.2, kinetic=0.1)),
        drive_speed=5.0, initial=start, t_end=2.0, t_eval=[2.0], **TIGHT,
    )  # fmt: skip

    def field(t: float, y: np.ndarray) -> list[float]:
        a, b, va, vb, z = y
        shaft = 12 * (a - b) + 0.01 * (va - vb)
        return [va, vb, (-shaft - 80 * (a - 5 * t) - 3 * z) / 0.35, (shaft - 0.1 - 0.05 * vb * abs(vb)) / 0.04,
                (a - z) / 0.4]  # fmt: skip

    theirs = scipy.integrate.solve_ivp(field, (0, 2), [*start, 0.0], method="DOP853", rtol=1e-13, atol=1e-13)
    assert len(run.transitions) == 0
    np.testing.assert_allclose(run.state[-1], theirs.y[:4, -1], atol=1e-9)
    assert run.hidden["lagged.z"][-1] == pytest.approx(theirs.y[4, -1], abs=1e-10)


def test_kinks_of_a_formula_are_located() -> None:
    rig = ss.BodiesRig(
        body={"m": ss.Body(mass=1)},
        link=[ss.Link(between=("m", "ground"), stiffness=1)],
        contact=[ss.Contact(body="m")],
    )
    stop = ss.effect("formula", where="m", force="-k*max(0, m - d)", k=8.0, d=0.5)
    model = ss.Model(rig, friction=ss.CoulombFriction(static=0, kinetic=0), effects=[stop])
    run = ss.simulate(model, initial=(0.0, 1.0), t_end=3.0, **TIGHT)
    first = math.asin(0.5)
    # (9 m - 4)'' = -9 (9 m - 4): from m = 0.5 with its speed to m = 0.5 again
    half = 2 * math.atan2(math.cos(first) / 3, 0.5 - 4 / 9)
    np.testing.assert_allclose(run.kinks[:1], [first], atol=1e-12)
    back = run.kinks[-1]
    w = 3.0
    x = 4 / 9 + (0.5 - 4 / 9) * np.cos(w * (back - first)) + math.cos(first) / w * np.sin(w * (back - first))
    assert x == pytest.approx(0.5, abs=1e-12)
    assert back - first == pytest.approx(half / w, abs=1e-11)


@pytest.mark.parametrize(
    "law", [ss.CoulombFriction(static=1.0, kinetic=0.5), ss.HyperbolicFriction(scale=1, decay=3)]
)
def test_formulas_on_named_rigs_are_the_effects_of_the_catalogue(law: ss.FrictionLaw) -> None:
    own = {
        "block_quadratic_damping": ({"c": 0.3}, {"where": "block", "force": "-c*x2*abs(x2)"}),
        "spring_cubic_k1": ({"k": 2.0}, {"where": "block", "force": "-k*x1**3"}),
        "friction_drift": ({"r": 0.01}, {"where": "contact", "factor": "1 + r*t"}),
        "belt_seam": ({"a": 0.1, "L": 2.0}, {"where": "contact", "factor": "1 + a*sin(2*pi*(0.2*t - x1)/L)"}),
        "belt_speed_ripple": ({"a": 0.1, "w": 1.3}, {"where": "belt", "factor": "1 + a*sin(w*t)"}),
    }
    for rig, start in (
        (ss.BlockOnBelt(mass=1, stiffness=1), (0.1, 0.1)),
        (ss.Rig(alpha1=16, alpha2=8, beta3=4, eta1=0.1, eta12=0.2), (0.1, 0.1, 0, 0)),
    ):
        for name, (numbers, formula) in own.items():
            runs = [
                ss.simulate(
                    ss.Model(rig, friction=law, effects=[one]),
                    belt_speed=0.2,
                    initial=start,
                    t_end=30,
                    t_eval=[10, 20, 30],
                    **TIGHT,
                )
                for one in (ss.effect(name, **numbers), ss.effect("formula", **formula, **numbers))
            ]
            np.testing.assert_allclose(runs[0].state, runs[1].state, atol=1e-9, err_msg=name)


COORDINATE = {"block": "x1", "angle_body": "y1", "contact": "contact", "belt": "belt"}


@pytest.mark.parametrize("name", [name for name in KINDS if name in ss.CATALOGUE])
def test_every_effect_of_the_catalogue_acts_on_any_rig_as_on_the_named_one_or_is_refused(name: str) -> None:
    """The rig of (2.1) by its matrices, effects put to their places, and the named rig with its own code of each."""
    kind = KINDS[name]
    named = ss.Rig(alpha1=16, alpha2=8, beta3=4, eta1=0.1, eta12=0.2)
    s = 1.0 if named.coupling == "reciprocal" else -1.0
    rig = ss.MatricesRig(
        M=[[16, 0], [0, 8]],
        C=[[0.1, 0.1], [0.1, 0.2]],
        K=[[16, s], [1, 4]],
        contact=[1, 0],
        names=["x1", "y1"],
        unit="1",
    )
    law = ss.HyperbolicFriction(scale=0.7, decay=3.0, constant=0.3)
    where = COORDINATE.get(kind.where, kind.where)
    if kind.anywhere.refused:
        with pytest.raises(InputError, match=re.escape(kind.anywhere.refused)):
            ss.Model(rig, friction=law, effects=[made(name, where=where)])
        return
    put = {"where": where, **({"by": "y1"} if kind.anywhere.couples else {})}
    if kind.where == "both":
        return  # on a link; see below
    options = {"belt_speed": 0.1, "t_end": TIMES[-1], "t_eval": TIMES, **TIGHT}
    theirs = ss.simulate(
        ss.Model(named, friction=law, effects=[made(name)]), initial=(0.1, 0.1, 0.02, 0.0), **options
    )
    start = (0.1, 0.02, 0.1, 0.0)
    ours = ss.simulate(ss.Model(rig, friction=law, effects=[made(name, **put)]), initial=start, **options)
    np.testing.assert_allclose(ours.state[:, [0, 2, 1, 3]], theirs.state, atol=1e-8)
    plain = ss.simulate(ss.Model(rig, friction=law), initial=start, **options)
    change = np.max(np.abs(ours.state - plain.state))
    assert change < 1e-9 if kind.physics == "reading" else change > 1e-7


@pytest.mark.sampled(3)
@pytest.mark.parametrize(
    "name", [name for name, kind in KINDS.items() if name not in ss.CATALOGUE and not kind.anywhere.refused]
)
def test_every_effect_of_a_driven_slider_acts_on_any_rig_where_it_can(name: str) -> None:
    model = block(made(name))
    soon = {"t_end": SOON[-1], "t_eval": SOON}
    theirs = ss.reference.simulate_bodies(model, belt_speed=0.2, initial=[0.1, 0.1], **soon, tol=1e-11)
    ours = moved(model, **soon)
    np.testing.assert_allclose(ours.state, theirs.state, atol=1e-6)
    if KINDS[name].physics == "dynamics":
        assert np.max(np.abs(ours.state - moved(block(), **soon).state)) > 1e-7


def test_a_cubic_spring_on_a_link_pulls_at_both_ends() -> None:
    links = [ss.Link(between=(name, "ground"), stiffness=1) for name in ("a", "b")]
    rig = ss.BodiesRig(
        body={"a": ss.Body(mass=1), "b": ss.Body(mass=2)},
        link=[*links, ss.Link(between=("a", "b"), stiffness=0.5, rest=0.1)],
        contact=[ss.Contact(body="a")],
    )
    free = ss.CoulombFriction(static=0, kinetic=0)
    model = ss.Model(rig, friction=free, effects=[ss.effect("spring_cubic_k2", where="link_3", k=2.0)])
    run = ss.simulate(model, initial=(0.4, -0.3, 0, 0.1), t_end=8, t_eval=TIMES[:80], **TIGHT)
    a, b, va, vb = run.state.T
    e = a - b - 0.1
    energy = va**2 / 2 + vb**2 + (a**2 + b**2) / 2 + e**2 / 4 + e**4 / 2
    np.testing.assert_allclose(energy, energy[0], atol=1e-10)


def test_two_of_a_kind_at_two_places() -> None:
    both = [
        ss.effect("block_viscous_damping", where=name, c=c) for name, c in (("table", 0.1), ("bit", 0.02))
    ]
    model = string(*both)
    assert {"block_viscous_damping@table.c", "block_viscous_damping@bit.c"} <= model.parameters.keys()
    rig = string().rig
    damped = ss.BodiesRig(
        body=rig.body, contact=rig.contact,
        link=[
            *rig.link,
            ss.Link(between=("table", "ground"), damping=0.1),
            ss.Link(between=("bit", "ground"), damping=0.02),
        ],
    )  # fmt: skip
    np.testing.assert_allclose(
        moved(model).state, moved(ss.Model(damped, friction=model.friction)).state, atol=1e-8
    )
    with pytest.raises(InputError, match="block_viscous_damping@table' is there twice"):
        string(both[0], both[0])


def test_a_model_with_effects_is_the_file_again(tmp_path: Path) -> None:
    model = string(
        *(ss.effect("formula", called=f"own_{i}", **one) for i, one in enumerate(FORMULAS.values())),
        ss.effect("harmonic_forcing", where="table", a=0.2, w=1.3),
    )
    model.save(tmp_path / "model.toml")
    assert ss.load_model(tmp_path / "model.toml") == model


BAD = {
    "unknown name": ({"where": "bit", "force": "-c*v_bit*w", "c": 1.0}, "column 10: unknown name 'w'"),
    "unknown place": ({"where": "bits", "force": "-c*v_bit", "c": 1.0}, "no body or link 'bits'; did you mean 'bit'"),
    "no place": ({"force": "-c*v_bit", "c": 1.0}, "lacks its place, a body or link: one of table, bit, link_1, link_2"),
    "wrong dimension": ({"where": "bit", "force": "-c*v_bit", "c": "1 N s/m"}, "force = .*: is .* it must be a torque"),
    "no pure number": ({"where": "bit", "factor": "r*t", "r": "1 rad"}, "it must be a pure number"),
    "two formulas": ({"where": "bit", "factor": "1", "force": "1"}, "give one of 'force', 'factor' and 'reading'"),
    "no formula": ({"where": "bit", "c": 1.0}, "give one of 'force', 'factor' and 'reading'"),
    "a number unread": ({"where": "bit", "force": "-c*v_bit", "c": 1.0, "d": 1.0}, "no formula of the effect reads it"),
    "zero at rest": ({"where": "bit", "force": "c/v_bit", "c": 1.0}, "divides by 'v_bit', which is 0"),
    "zero in a range": (
        {"where": "bit", "force": "-bit/(c - 1)", "c": 0.5, "ranges": {"c": [0.0, 2.0]}},
        "divides by .*, which is 0 at c = 1",
    ),
    "outside its range": ({"where": "bit", "force": "-c*bit", "c": 5.0, "ranges": {"c": [0, 2]}}, "outside its range"),
    "a range turned": ({"where": "bit", "force": "-c*bit", "c": 1.0, "ranges": {"c": [2, 0]}}, "not below the upper"),
    "unknown range": ({"where": "bit", "force": "-c*bit", "c": 1.0, "ranges": {"d": [0, 2]}}, "has no number 'd'"),
    "no such contact": ({"where": "table", "factor": "2"}, "no contact 'table'; .*bit"),
    "no such number": ({"where": "bit.normal", "factor": "2"}, "no number 'normal'"),
    "no belt": ({"where": "belt", "factor": "2"}, "no prescribed speed 'belt'; .*drive"),
    "a speed with a kink": ({"where": "drive", "factor": "max(1, t)"}, "has a kink in time"),
    "a speed of the state": ({"where": "drive", "factor": "1 + bit"}, "unknown name 'bit'"),
    "rate at a drive": ({"where": "link_2", "force": "-deflection_rate"}, "has no deflection_rate"),
    "no such channel": ({"where": "bot", "reading": "2*reading"}, "no channel 'bot'; did you mean 'bit'"),
    "a name that is taken": ({"where": "bit", "force": "-t*bit", "t": 1.0}, "is taken"),
    "a name of the rig": ({"where": "bit", "force": "-table*bit", "table": 1.0}, "names a state of the rig"),
}  # fmt: skip


@pytest.mark.parametrize("name", BAD)
def test_bad_input_gets_a_line(name: str) -> None:
    given, words = BAD[name]
    with pytest.raises(InputError, match=words) as caught:
        moved(string(ss.effect("formula", **given)))
    assert "\n" not in str(caught.value)


def test_what_cannot_act_elsewhere_is_refused() -> None:
    formula = ss.effect("formula", where="block", force="-c*x2", c=0.1)
    rig, law = ss.BlockOnBelt(mass=1, stiffness=1), ss.CoulombFriction(static=1, kinetic=0.5)
    with pytest.raises(InputError, match="leave it out"):
        ss.Model(rig, friction=law, effects=[ss.effect("constant_load", where="x1", f=0.1)])
    with pytest.raises(InputError, match="a curve acts"):
        block(ss.tabulated("block", "x1", [0, 1], [0, 1]))
    with pytest.raises(InputError, match="is a formula, for rigs on a belt"):
        ss.Model(ss.DrivenSlider(mass=1), friction=law, effects=[formula])


def test_readings_are_what_their_effects_make_of_them_one_after_the_other() -> None:
    effects = [
        ss.effect("sensor_lag", where="x_block", tau=0.3),
        ss.effect("sensor_gain", where="x_block", e=0.1),
        ss.effect("formula", called="squint", where="v_x_block", reading="reading + c*x_block", c=2.0),
    ]
    rig = ss.BodiesRig(
        body={"x_block": ss.Body(mass=1)},
        link=[ss.Link(between=("x_block", "ground"), stiffness=1, damping=0.02)],
        contact=[ss.Contact(body="x_block", against="belt")],
    )
    plain = ss.Model(rig, friction=ss.CoulombFriction(static=1.0, kinetic=0.5))
    options = {"belt_speed": 0.2, "initial": (0.1, 0.1), "t_end": TIMES[-1], "t_eval": TIMES, **TIGHT}
    run = ss.simulate(plain.with_effects(effects), **options)
    still = ss.simulate(plain, **options)
    np.testing.assert_allclose(run.state, still.state, atol=1e-9)
    x, v = run.state.T
    np.testing.assert_allclose(run.readings["v_x_block"], v + 2 * x, atol=1e-14)
    lagged = scipy.integrate.solve_ivp(
        lambda t, m: (ss_at(plain, t) - m) / 0.3,
        (0, 2.0),
        [0.1],
        t_eval=[1.0, 2.0],
        rtol=1e-9,
        atol=1e-9,
        max_step=0.1,
    )
    np.testing.assert_allclose(run.readings["x_block"][[10, 20]], 1.1 * lagged.y[0], atol=1e-7)


def ss_at(model: ss.Model, t: float) -> float:
    """Where the block is at t."""
    if t == 0:
        return 0.1
    run = ss.simulate(model, belt_speed=0.2, initial=(0.1, 0.1), t_end=t, t_eval=[t], **TIGHT)
    return float(run.state[0, 0])


def test_a_constant_load_over_a_long_time_is_a_spring_that_is_slack_elsewhere() -> None:
    """Linear modes are crossed in long stretches; a load must be in them."""
    rig = block().rig
    slack = ss.BodiesRig(
        body=rig.body,
        contact=rig.contact,
        link=[ss.Link(between=("block", "ground"), stiffness=1, damping=0.02, rest=0.3)],
    )
    law = ss.CoulombFriction(static=0.02, kinetic=0.02)
    options = {
        "belt_speed": 5.0,
        "initial": (0.1, 0.1),
        "t_end": 2000.0,
        "t_eval": [20.0, 500.0, 2000.0],
        **TIGHT,
    }
    loaded = ss.simulate(ss.Model(rig, friction=law, effects=[ss.effect("constant_load", f=0.3)]), **options)
    np.testing.assert_allclose(
        loaded.state, ss.simulate(ss.Model(slack, friction=law), **options).state, atol=1e-10
    )
