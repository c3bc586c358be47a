"""Rigs of any kind through the core: against the named rigs, the plain simulator, SciPy, closed forms, differences."""

from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import stickslip as ss
from pivot import both_ways
from stickslip.errors import InputError
from stickslip.simulated.reference.bodies import simulate as plain
from test_bodies_reference import LAWS, OWN, RIG, bodies, chain, drill, matrices

TIGHT = {"rtol": 1e-12, "atol": 1e-13}


@pytest.mark.parametrize("law", LAWS, ids=lambda law: law.kind)
@pytest.mark.parametrize("how", ["matrices", "bodies of formulas", "named, a formula of t"])
def test_the_named_rig_rebuilt_moves_as_the_named_one(law: ss.PaperFriction, how: str) -> None:
    t = np.linspace(0, 100, 101)
    core = ss.simulate(
        ss.Model(RIG, friction=law), belt_speed=0.1, initial=(0.1, 0.1, 0, 0), t_end=100, t_eval=t, **TIGHT
    )
    if how.startswith("named"):
        model, start, speed = ss.Model(RIG, friction=law), (0.1, 0.1, 0.0, 0.0), "0.1 + 0*t"
    else:
        model = matrices(law) if how == "matrices" else bodies(OWN[law.kind])
        start, speed = (0.1, 0.0, 0.1, 0.0), 0.1  # type: ignore[assignment]
    run = ss.simulate(model, belt_speed=speed, initial=start, t_end=100, t_eval=t, **TIGHT)
    states = run.state if how.startswith("named") else run.state[:, [0, 2, 1, 3]]
    np.testing.assert_allclose(states, core.state, atol=1e-10)
    np.testing.assert_allclose(run.transitions.t, core.transitions.t, atol=1e-10)
    assert run.transitions.after.ravel().tolist() == core.transitions.after.tolist()
    assert run.mode.ravel().tolist() == core.mode.tolist()


def test_pivot_friction_is_a_second_contact() -> None:
    t = np.linspace(0, 60, 61)
    named, model = both_ways()
    core = ss.simulate(named, belt_speed=0.1, initial=(0.1, 0.1, 0, 0), t_end=60, t_eval=t, **TIGHT)
    run = ss.simulate(model, belt_speed=0.1, initial=(0.1, 0, 0.1, 0), t_end=60, t_eval=t, **TIGHT)
    np.testing.assert_allclose(run.state[:, [0, 2, 1, 3]], core.state, atol=1e-10)
    assert run.mode.shape == (61, 2)
    assert run.contact_names == ("contact_1", "contact_2")
    assert {"mode_contact_1", "mode_contact_2"} < set(run.to_dataframe().columns)


def held_against_plain(
    model: ss.Model, start: list[float], t_end: float, tolerance: float = 1e-9, **speeds: object
) -> ss.Trajectory:
    t = np.linspace(0, t_end, 41)
    run = ss.simulate(model, initial=start, t_end=t_end, t_eval=t, **TIGHT, **speeds)  # type: ignore[arg-type]
    other = plain(model, initial=start, t_end=t_end, t_eval=t, **speeds)  # type: ignore[arg-type]
    assert run.status.ok
    np.testing.assert_allclose(run.state, other.state, atol=tolerance)
    for name, column in zip(run.hidden_names, other.hidden.T, strict=True):
        np.testing.assert_allclose(run.hidden[name], column, atol=tolerance)
    moves = zip(run.transitions.t, run.transitions.before, run.transitions.after, strict=True)
    ours = [(float(t), int(j), int(b[j])) for t, a, b in moves for j in np.flatnonzero(a != b)]
    theirs = [(one.t, one.contact, one.after) for one in other.changes]
    ours, theirs = (sorted(those, key=lambda one: (round(one[0], 6), one[1])) for those in (ours, theirs))
    assert [one[1:] for one in ours] == [one[1:] for one in theirs]
    np.testing.assert_allclose([one[0] for one in ours], [one[0] for one in theirs], atol=tolerance)
    return run


def test_a_drill_string_turns_as_in_the_plain_simulator_and_the_closed_form() -> None:
    W, w = 0.5, np.sqrt(92 / 0.35)
    model = drill(ss.CoulombFriction(static=2, kinetic=1.2))
    run = held_against_plain(model, [0, 0, 0, 0], 3, drive_speed=W)
    assert len(run.transitions) > 3
    stuck = run.t < run.transitions.t[0]
    expected = 80 * W / 92 * (run.t[stuck] - np.sin(w * run.t[stuck]) / w)
    np.testing.assert_allclose(run.state[stuck, 0], expected, atol=1e-12)
    held_against_plain(model, [0, 0, 0, 0], 2.5, drive_speed="0.5 + 0.3*sin(2*t)")


@pytest.mark.study
def test_a_chain_of_blocks_releases_alike_on_both_sides() -> None:
    law = ss.HyperbolicFriction(scale=1, decay=3)
    run = held_against_plain(chain(law), [0.1, 0.4, 0.1, 0.2, 0.2, 0.2], 9, 1e-8, belt_speed=0.2)
    np.testing.assert_allclose(run.state[:, 0], run.state[:, 2], atol=1e-10)
    one = ss.Model(ss.BlockOnBelt(), friction=law)
    t = np.linspace(0, 30, 31)
    alone = ss.simulate(one, belt_speed=0.2, initial=[0.3, 0.2], t_end=30, t_eval=t, **TIGHT)
    same = ss.simulate(chain(law), belt_speed=0.2, initial=[0.3] * 3 + [0.2] * 3, t_end=30, t_eval=t, **TIGHT)
    for k in range(3):
        np.testing.assert_allclose(same.state[:, k], alone.state[:, 0], atol=1e-9)


@pytest.mark.study
def test_releases_that_tear_others_off_are_those_of_the_plain_simulator() -> None:
    rig = ss.MatricesRig(
        M=[[1.08, -0.36, -0.17], [-0.36, 2.76, 1.01], [-0.17, 1.01, 2.51]],
        C=0.05 * np.eye(3),  # type: ignore[arg-type]
        K=[[3, -1, 0], [-1, 3, -1], [0, -1, 2]],
        contact=np.eye(3),  # type: ignore[arg-type]
    )
    model = ss.Model(rig, friction=ss.CoulombFriction(static=1, kinetic=0.2))
    run = held_against_plain(model, [0.1, 0.2, 0, 0.1, 0.1, 0.1], 14, 1e-8, belt_speed=0.1)
    assert (np.abs(run.transitions.after - run.transitions.before) > 0).sum(axis=1).max() > 1


@pytest.mark.parametrize(
    "speed",
    [
        "0.5*sin(1.7*t)",
        ss.Speed.steps([0, 3, 6], [0.1, "0.3 - 0.02*t", -0.2]),
        ss.Speed.measured([0, 2, 3, 7, 9], [0.1, 0.3, 0.3, -0.2, 0.1]),
    ],
    ids=["formula", "steps", "measured"],
)
def test_prescribed_speeds(speed: object) -> None:
    model = ss.Model(
        ss.BlockOnBelt(mass=1, stiffness=1), friction=ss.CoulombFriction(static=0.6, kinetic=0.3)
    )
    t = np.linspace(0, 10, 41)
    run = ss.simulate(model, belt_speed=speed, initial=(0.05, 0.2), t_end=10, t_eval=t, **TIGHT)  # type: ignore[arg-type]
    other = plain(model, belt_speed=speed, initial=(0.05, 0.2), t_end=10, t_eval=t)
    np.testing.assert_allclose(run.state, other.state, atol=1e-9)
    assert run.transitions.after.tolist() == [one.after for one in other.changes]
    assert run.mode.shape == (41,)  # of a named rig, the one contact


def test_a_speed_that_is_a_number_at_every_time_is_that_number() -> None:
    model = ss.Model(RIG, friction=LAWS[1])
    one, other = (ss.simulate(model, belt_speed=speed, t_end=20) for speed in (0.1, ss.Speed.of(0.1)))
    np.testing.assert_array_equal(one.state, other.state)
    sweeps = [
        ss.sweep(model, {"alpha1": [16.0]}, belt_speed=speed, t_end=5) for speed in (0.1, ss.Speed.of(0.1))
    ]
    np.testing.assert_array_equal(sweeps[0].final_state, sweeps[1].final_state)


STIFF = {"sigma0": 1e5, "sigma1": 316.227766, "sigma2": 0.4, "F_c": 1.0, "F_s": 1.5, "v_s": 1e-3}


def test_lugre_on_a_belt_against_a_stiff_solver() -> None:
    m, k, v_b = 1.0, 2.0, 0.1

    def rate(_: float, y: np.ndarray) -> list[float]:
        x, w, z = y
        v = w - v_b
        g = STIFF["F_c"] + (STIFF["F_s"] - STIFF["F_c"]) * np.exp(-((v / STIFF["v_s"]) ** 2))
        dz = v - STIFF["sigma0"] * abs(v) / g * z
        force = STIFF["sigma0"] * z + STIFF["sigma1"] * dz + STIFF["sigma2"] * v
        return [w, (-k * x - force) / m, dz]

    true = solve_ivp(
        rate, (0, 1), [0, 0, 0], method="Radau", rtol=1e-12, atol=[1e-14, 1e-14, 1e-18], max_step=2e-3
    )
    model = ss.Model(ss.BlockOnBelt(mass=m, stiffness=k), friction=ss.LuGreFriction(**STIFF))
    run = ss.simulate(model, belt_speed=v_b, initial=(0, 0), t_end=1, t_eval=[1.0])
    assert run.status.ok
    np.testing.assert_allclose(run.state[0], true.y[:2, -1], atol=1e-8)
    assert run.hidden["z"][0] == pytest.approx(true.y[2, -1], abs=1e-11)


@pytest.mark.parametrize("state_law", ["aging", "slip"])
def test_rate_and_state_grows_below_the_critical_stiffness_and_decays_above(state_law: str) -> None:
    m, N, a, b, D_c, v = 1.0, 100.0, 0.008, 0.012, 0.01, 0.01
    law = ss.RateAndStateFriction(mu0=0.6, a=a, b=b, D_c=D_c, V_0=v, normal=N, state_law=state_law)  # type: ignore[arg-type]
    critical = (b - a) * N / D_c * (1 + m * v**2 / (a * N * D_c))
    growth = []
    for k in (1.05 * critical, 0.95 * critical):
        steady = 0.6 * N / k
        model = ss.Model(ss.BlockOnBelt(mass=m, stiffness=k), friction=law)
        run = ss.simulate(
            model, belt_speed=v, initial=(steady * 1.0005, 0), t_end=60, t_eval=np.linspace(0, 60, 1201)
        )
        assert run.status.ok
        x = run.state[:, 0] - steady
        growth.append(np.ptp(x[1000:]) / np.ptp(x[200:400]))
    assert growth[0] < 0.9
    assert growth[1] > 1.1


def test_a_state_may_be_given_and_else_starts_as_its_law_says() -> None:
    law = ss.RateAndStateFriction(mu0=0.6, a=0.008, b=0.012, D_c=0.01, V_0=0.01, normal=100)
    model = ss.Model(ss.BlockOnBelt(mass=1, stiffness=50), friction=law)
    t = [0.0, 0.5]
    run = ss.simulate(model, belt_speed=0.02, initial=(1.2, 0), t_end=0.5, t_eval=t)
    assert run.hidden["theta"][0] == pytest.approx(0.5)
    other = ss.simulate(model, belt_speed=0.02, initial=(1.2, 0, 0.5), t_end=0.5, t_eval=t)
    np.testing.assert_array_equal(run.state, other.state)
    with pytest.raises(InputError, match=r"theta is not finite in steady motion .* give its start"):
        ss.simulate(model, belt_speed=0.02, initial=(1.2, 0.02), t_end=0.5)
    with pytest.raises(InputError, match="or 3 with the laws' states theta"):
        ss.simulate(model, belt_speed=0.02, initial=(1.2,), t_end=0.5)


CASES = {
    "drill": (
        drill(ss.CoulombFriction(static=2, kinetic=1.2)),
        (0.0, 0.0, 0.0, 0.0),
        {"drive_speed": 0.5},
        [
            "drive_speed",
            "bit.inertia",
            "link_1.stiffness",
            "link_2.stiffness",
            "kinetic",
            "initial.bit",
        ],
        1.4,
    ),
    "matrices": (
        matrices(LAWS[2]),
        (0.1, 0.0, 0.1, 0.0),
        {"belt_speed": 0.1},
        ["belt_speed", "K_12", "C_11", "contact_11", "scale", "decay", "initial.v_y1"],
        12.0,
    ),
    "rate and state": (
        ss.Model(
            ss.BlockOnBelt(mass=1, stiffness=50),
            friction=ss.RateAndStateFriction(mu0=0.6, a=0.008, b=0.012, D_c=0.01, V_0=0.01, normal=100),
        ),
        (1.2, 0.0),
        {"belt_speed": 0.02},
        ["belt_speed", "mass", "stiffness", "mu0", "a", "b", "D_c", "initial.x1", "initial.x2"],
        0.7,
    ),
}


@pytest.mark.parametrize("case", CASES)
def test_sensitivities_are_those_of_central_differences(case: str) -> None:
    model, start, speeds, names, end = CASES[case]
    run = ss.simulate(model, **speeds, initial=start, t_end=end, t_eval=[end], sensitivity=names, **TIGHT)  # type: ignore[arg-type]
    assert run.status.ok
    for i, name in enumerate(names):
        ends = []
        for sign in (-1, 1):
            moved, begin, speed = model, list(start), dict(speeds)
            state = name.removeprefix("initial.")
            size = speeds.get(name, model.parameters.get(name, 0.0))
            h = 2e-6 * (abs(float(size)) or 1.0)
            if state != name:
                begin[model.rig.state_names.index(state)] += sign * h
            elif name in speeds:
                speed[name] = float(size) + sign * h
            else:
                moved = model.replace({name: float(size) + sign * h})
            ends.append(ss.simulate(moved, **speed, initial=begin, t_end=end, t_eval=[end], **TIGHT).state[0])  # type: ignore[arg-type]
        found = (ends[1] - ends[0]) / (2 * h)
        np.testing.assert_allclose(
            run.sensitivity[0, :, i], found, rtol=5e-6, atol=5e-6 * max(1.0, float(np.abs(found).max()))
        )


def test_calls_that_cannot_be_meant_are_refused_in_a_line() -> None:
    model = drill(ss.CoulombFriction(static=2, kinetic=1.2))
    belt = ss.Model(ss.BlockOnBelt(), friction=ss.CoulombFriction())
    for call, words in [
        (lambda: ss.simulate(model, t_end=1), "drive_speed: missing: a link is pulled by the drive"),
        (lambda: ss.simulate(model, drive_speed=1, belt_speed=1, t_end=1), "no contact rubs on a belt"),
        (lambda: ss.simulate(belt, t_end=1), "lacks belt_speed"),
        (lambda: ss.simulate(belt, belt_speed=1, drive_speed=1, t_end=1), "nothing is pulled by a drive"),
        (lambda: ss.simulate(belt, belt_speed="sin(x)", t_end=1), "unknown name 'x'"),
        (lambda: ss.simulate(belt, belt_speed="abs(sin(t))", t_end=1), "has a kink in time"),
        (lambda: ss.simulate(model, drive_speed=1, initial=(0, 0), t_end=1), "has 2 numbers; give 4"),
        (
            lambda: ss.simulate(model, drive_speed=1, sensitivity=["bit.mass"], t_end=1),
            "unknown parameter 'bit.mass'",
        ),
        (
            lambda: ss.simulate(model, drive_speed=1, contact=["stick", "stick"], t_end=1),
            "2 modes for 1 contacts",
        ),
        (lambda: ss.simulate(model, drive_speed=1, order=5, t_end=1), "is for a named rig"),
    ]:
        with pytest.raises(InputError, match=words):
            call()


def test_a_load_acts_where_the_belt_has_a_formula_too() -> None:
    """A constant force moves where the spring rests: the same motion elsewhere."""
    law, load = ss.CoulombFriction(), 0.3
    rig = ss.BlockOnBelt(mass=1.0, stiffness=2.0)
    t = np.linspace(0.1, 12.0, 60)
    settings = {"belt_speed": "0.4*sin(0.7*t)", "t_end": 12.0, "t_eval": t, "rtol": 1e-11, "atol": 1e-12}
    loaded = ss.Model(rig, friction=law, effects=[ss.effect("constant_load", f=load)])
    moved = ss.simulate(loaded, initial=(0.5 + load / 2.0, 0.0), **settings)
    plain = ss.simulate(ss.Model(rig, friction=law), initial=(0.5, 0.0), **settings)
    assert len(plain.transitions) > 1
    np.testing.assert_allclose(moved.state[:, 0] - load / 2.0, plain.state[:, 0], atol=1e-9)


def test_a_chain_grows_without_new_names(tmp_path: Path) -> None:
    """Eight blocks: names, file and motion."""
    model = chain(ss.CoulombFriction(static=1, kinetic=0.6), 8)
    model.save(tmp_path / "chain.toml")
    assert ss.load_model(tmp_path / "chain.toml") == model
    run = ss.simulate(model, belt_speed=0.2, initial=[*np.linspace(-0.2, 0.3, 8), *[0.2] * 8], t_end=20)
    assert run.status.ok
    assert run.mode.shape[1] == 8
    assert all(a <= b for a, b in pairwise(run.transitions.t))


@pytest.mark.parametrize("delta", [0.7, 1.0, 1.5, 2.0, 3.0])
def test_the_derivative_by_an_exponent_is_that_of_differences(delta: float) -> None:
    """By one that makes the force a polynomial too: steps were as long as that allows, across the zero of log u."""
    rig = ss.BodiesRig(
        body={"a": ss.Body(mass=1.0)},
        link=[ss.Link(between=("a", "ground"), stiffness=1.0, damping=0.02)],
        contact=[ss.Contact(body="a", against="belt", law="law")],
    )
    t = np.linspace(0.5, 16.0, 32)

    def run(at: float, sensitivity: tuple[str, ...] = ()) -> ss.Trajectory:
        law = ss.StribeckFriction(F_c=1.0, F_s=1.5, v_s=0.3, delta=at)
        model = ss.Model(rig, friction={"law": law})
        return ss.simulate(
            model, belt_speed=0.2, t_end=t[-1], t_eval=t, sensitivity=sensitivity, rtol=1e-11, atol=1e-12
        )

    step = 1e-5
    found = run(delta, ("law.delta",))
    want = (run(delta + step).state - run(delta - step).state) / (2 * step)
    assert len(found.transitions) > 2
    assert np.abs(found.sensitivity[:, :, 0] - want).max() < 1e-4 * np.abs(want).max()


def test_the_derivative_by_a_bristle_in_steady_sliding_dies_out_as_in_closed_form() -> None:
    """The bristle is constant, so its own series says nothing of how fast a disturbance goes: it grew to 1e43."""
    k, sigma0, F_c, v = 2.0, 1e3, 1.0, 0.1
    model = ss.Model(ss.BlockOnBelt(stiffness=k), friction=ss.DahlFriction(sigma0=sigma0, F_c=F_c))
    t, rate, w = np.array([0.01, 0.05, 0.5, 4.0]), sigma0 * v / F_c, np.sqrt(k)
    run = ss.simulate(
        model,
        belt_speed=v,
        initial=(F_c / k, 0, -F_c / sigma0),
        t_end=4,
        t_eval=t,
        sensitivity=["initial.z"],
        **TIGHT,
    )
    np.testing.assert_allclose(run.hidden_sensitivity["z"][:, 0], np.exp(-rate * t), rtol=1e-9, atol=1e-12)
    forced = -sigma0 / (rate**2 + k)  # x'' + k x = -sigma0 exp(-rate t)
    want = forced * (np.exp(-rate * t) - np.cos(w * t) + rate / w * np.sin(w * t))
    np.testing.assert_allclose(run.sensitivity[:, 0, 0], want, rtol=1e-9, atol=1e-12)
