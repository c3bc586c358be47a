"""The plain simulator of general rigs, against the named rigs' core, closed forms, SciPy's solvers and symmetry."""

from itertools import pairwise

import numpy as np
import pytest
import scipy
from scipy.integrate import solve_ivp

import stickslip as ss
from pivot import both_ways
from stickslip.simulated.general import general
from stickslip.simulated.reference.bodies import Bodies, BodiesRun, Modes
from stickslip.simulated.reference.bodies import simulate as plain

RIG = ss.Rig(alpha1=16, alpha2=8, beta3=4, eta1=0.1, eta12=0.2)
LAWS = [
    ss.CoulombFriction(static=2, kinetic=1.2, static_plus=1.5),
    ss.PaperFriction(),
    ss.HyperbolicFriction(scale=3, decay=2, quadratic=0.1),
]
OWN = {  # the built-in laws once more, as a person would write them
    "coulomb": ss.FormulaFriction(kinetic="k", static="s", static_plus="sp", k=1.2, s=2, sp=1.5),
    "hyperbolic": ss.FormulaFriction(kinetic="a/(1 + d*u) + q*u**2", a=3, d=2, q=0.1),
    "paper": ss.FormulaFriction(
        kinetic="max(1.42, S - 3.2345*exp((min(u, 0.5) - 0.28)/0.0342) - 2.8736*exp((min(u, 0.5) - 0.28)/0.3053))",
        static="S",
        kinetic_plus="max(0.86, P - u*(P - 0.86)/0.27)",
        static_plus="P",
        S=5.94,
        P=3.63,
    ),
}


def matrices(
    law: ss.CoulombFriction | ss.PaperFriction | ss.HyperbolicFriction | ss.FormulaFriction,
) -> ss.Model:
    rig = ss.MatricesRig(
        M=[[16, 0], [0, 8]],
        C=[[0.1, 0.1], [0.1, 0.2]],
        K=[[16, 1], [1, 4]],
        contact=[1, 0],
        names=["x1", "y1"],
        unit="1",
    )
    return ss.Model(rig, friction=law)


def bodies(law: ss.FormulaFriction) -> ss.Model:
    rig = ss.BodiesRig(
        body={"x1": ss.Body(mass=16), "y1": ss.Body(mass=8)},
        link=[
            ss.Link(between=("x1", "ground"), stiffness=15),
            ss.Link(between=("x1", "y1"), stiffness=1, damping=0.1, gear=-1),
            ss.Link(between=("y1", "ground"), stiffness=3, damping=0.1),
        ],
        contact=[ss.Contact(body="x1", against="belt")],
    )
    return ss.Model(rig, friction=law)


def in_order(run: BodiesRun) -> np.ndarray:
    return run.state[:, [0, 2, 1, 3]] if run.state.shape[1] == 4 else run.state


@pytest.mark.parametrize("law", LAWS, ids=lambda law: law.kind)
@pytest.mark.parametrize("how", ["named", "matrices", "bodies of formulas"])
def test_the_named_rig_rebuilt_moves_as_the_named_one(law: ss.PaperFriction, how: str) -> None:
    t = np.linspace(0, 6, 7)
    named = ss.Model(RIG, friction=law)
    core = ss.simulate(
        named, belt_speed=0.1, initial=(0.1, 0.1, 0, 0), t_end=6, t_eval=t, rtol=1e-13, atol=1e-13
    )
    model = {"named": named, "matrices": matrices(law), "bodies of formulas": bodies(OWN[law.kind])}[how]
    start = (0.1, 0.1, 0, 0) if how == "named" else (0.1, 0, 0.1, 0)
    run = plain(model, belt_speed=0.1, initial=start, t_end=6, t_eval=t)
    np.testing.assert_allclose(run.state if how == "named" else in_order(run), core.state, atol=3e-12)
    assert [one.after for one in run.changes] == core.transitions.after.tolist()
    np.testing.assert_allclose([one.t for one in run.changes], core.transitions.t, atol=1e-11)
    assert (run.mode[:, 0] == core.mode).all()


def test_pivot_friction_is_a_second_contact() -> None:
    t = np.linspace(0, 12, 13)
    named, model = both_ways()
    core = ss.simulate(
        named, belt_speed=0.1, initial=(0.1, 0.1, 0, 0), t_end=12, t_eval=t, rtol=1e-13, atol=1e-13
    )
    run = plain(model, belt_speed=0.1, initial=(0.1, 0, 0.1, 0), t_end=12, t_eval=t)
    assert {one.contact for one in run.changes} == {0, 1}
    assert 0 in run.mode[:, 1]  # the pivot sticks, too
    np.testing.assert_allclose(in_order(run), core.state, atol=1e-11)


def test_a_belt_that_goes_to_and_fro() -> None:
    """The belt's acceleration counts in stick; the other program lands by SciPy's events."""
    m, k, limit, kinetic, size, w, end = 1.0, 1.0, 0.6, 0.3, 0.5, 1.7, 12.0
    law = ss.CoulombFriction(static=limit, kinetic=kinetic)
    model = ss.Model(ss.BlockOnBelt(mass=m, stiffness=k), friction=law)
    run = plain(model, belt_speed=f"{size}*sin({w}*t)", initial=(0.05, 0.2), t_end=end, t_eval=[end])

    def belt(t: float) -> float:
        return float(size * np.sin(w * t))

    def load(t: float, y: np.ndarray) -> float:
        return float(k * y[0] + m * size * w * np.cos(w * t))

    t, y, mode, changes = 0.0, np.array([0.05, 0.2]), 1, 0
    while t < end:
        if mode:
            ends = [lambda t, y, s=mode: s * (y[1] - belt(t))]
        else:
            ends = [lambda t, y: limit - load(t, y), lambda t, y: limit + load(t, y)]
        for one in ends:
            one.terminal, one.direction = True, -1

        def rate(t: float, y: np.ndarray, s: int = mode) -> list[float]:
            return [y[1], (-k * y[0] - s * kinetic) / m] if s else [belt(t), size * w * np.cos(w * t)]

        more = {"rtol": 1e-12, "atol": 1e-13, "max_step": 0.01, "first_step": 1e-6}
        found = solve_ivp(rate, (t, end), y, method="DOP853", events=ends, **more)
        t, y = found.t[-1], found.y[:, -1].copy()
        if found.status == 0:
            break
        changes += 1
        y[1] = belt(t)
        if mode == 0:
            mode = -1 if len(found.t_events[0]) else 1
        else:
            mode = 0 if abs(load(t, y)) <= limit else (-1 if load(t, y) > 0 else 1)
        y[1] += mode * 1e-12
    assert changes > 8
    assert len(run.changes) == changes
    np.testing.assert_allclose(run.state[0], y, atol=1e-9)


def test_steps_of_the_belt_tear_the_block_off() -> None:
    """A belt that jumps leaves the block behind; between jumps a block in stick moves with it."""
    model = ss.Model(ss.BlockOnBelt(mass=2, stiffness=1e-9), friction=ss.CoulombFriction(static=2, kinetic=1))
    run = plain(
        model,
        belt_speed=ss.Speed.steps([0, 3], [0.1, 0.6]),
        initial=(0, 0.1),
        t_end=6,
        t_eval=[3.0, 3.5, 6.0],
    )
    assert [(one.t, one.before, one.after) for one in run.changes] == [
        (3.0, 0, -1),
        (pytest.approx(4.0), -1, 0),
    ]
    np.testing.assert_allclose(run.state[:, 1], [0.1, 0.1 + 0.5 * 0.5, 0.6], atol=1e-8)


@pytest.mark.study
def test_lugre_against_a_stiff_solver() -> None:
    s0, s1, s2, Fc, Fs, vs = 1e3, 30.0, 0.4, 1.0, 1.5, 0.01

    def rate(t: float, y: np.ndarray) -> list[float]:
        x, w, z = y
        v = w - 0.3 * np.cos(2 * t)
        dz = v - s0 * abs(v) / (Fc + (Fs - Fc) * np.exp(-((v / vs) ** 2))) * z
        return [w, -2 * x - s0 * z - s1 * dz - s2 * v, dz]

    t = np.linspace(0, 2, 9)
    true = solve_ivp(rate, (0, 2), [0, 0, 0], method="Radau", rtol=1e-12, atol=1e-14, max_step=0.02, t_eval=t)
    law = ss.LuGreFriction(sigma0=s0, sigma1=s1, sigma2=s2, F_c=Fc, F_s=Fs, v_s=vs)
    model = ss.Model(ss.BlockOnBelt(mass=1, stiffness=2), friction=law)
    run = plain(model, belt_speed="0.3*cos(2*t)", initial=(0, 0), t_end=2, t_eval=t, tol=1e-11, max_step=0.05)
    np.testing.assert_allclose(np.column_stack([run.state, run.hidden]), true.y.T, atol=1e-8)
    assert set(run.mode.ravel().tolist()) == {-1, 1}


def jacobian(model: ss.Model, state: list[float], belt_speed: float) -> np.ndarray:
    own = general(model, belt_speed)
    system = Bodies(own)
    z = own.start(np.asarray(state, float), {}, 0.0)
    z, side = system.start(0.0, z)
    rows = []
    for k in range(len(z)):
        step = z.astype(complex)
        step[k] += 1e-30j
        rows.append(np.imag(system.field(0.0, step, side)) / 1e-30)
    return np.array(rows).T


@pytest.mark.parametrize("state_law", ["aging", "slip"])
def test_rate_and_state_loses_stability_at_the_stiffness_of_ruina(state_law: str) -> None:
    """Steady sliding of a spring slider is neutral at k_c = (b - a) N/D_c (1 + m v^2/(a N D_c)), Routh and Hurwitz."""
    m, N, a, b, D_c, v = 1.0, 100.0, 0.008, 0.012, 0.01, 0.013
    law = ss.RateAndStateFriction(mu0=0.6, a=a, b=b, D_c=D_c, V_0=0.01, normal=N, state_law=state_law)  # type: ignore[arg-type]
    steady = float(law.magnitude(-v))

    def growth(k: float) -> float:
        model = ss.Model(ss.BlockOnBelt(mass=m, stiffness=k), friction=law)
        return float(np.max(np.linalg.eigvals(jacobian(model, [steady / k, 0.0], v)).real))

    found = scipy.optimize.brentq(
        growth, 0.1 * (b - a) * N / D_c, 10 * (b - a) * N / D_c, xtol=1e-13, rtol=1e-14
    )
    assert found == pytest.approx((b - a) * N / D_c * (1 + m * v**2 / (a * N * D_c)), rel=1e-10)


def drill(law: ss.CoulombFriction) -> ss.Model:
    rig = ss.BodiesRig(
        body={"table": ss.Body(inertia=0.35), "bit": ss.Body(inertia=0.04)},
        link=[
            ss.Link(between=("table", "bit"), stiffness=12),
            ss.Link(between=("table", "drive"), stiffness=80),
        ],
        contact=[ss.Contact(body="bit")],
    )
    return ss.Model(rig, friction=law)


def test_a_drill_string_in_stick_is_an_oscillator_of_one_degree() -> None:
    """The bit rests: 0.35 a'' + 92 a = 80 W t. It lets go where the shaft's torque reaches the limit."""
    W, w = 0.5, np.sqrt(92 / 0.35)
    model = drill(ss.CoulombFriction(static=2, kinetic=1.2))
    run = plain(model, drive_speed=W, initial=(0, 0, 0, 0), t_end=0.3, t_eval=np.linspace(0, 0.3, 7))

    def table(t: np.ndarray | float) -> np.ndarray:
        return 80 * W / 92 * (t - np.sin(w * t) / w)

    np.testing.assert_allclose(run.state[:, 0], table(run.t), atol=1e-12)
    assert (run.mode == 0).all()
    release = scipy.optimize.brentq(lambda t: 12 * table(t) - 2, 0.3, 0.5)
    whole = plain(model, drive_speed=W, initial=(0, 0, 0, 0), t_end=2)
    assert whole.changes[0].t == pytest.approx(release, abs=1e-11)
    assert whole.changes[0].after == 1
    stop = whole.changes[1]
    assert (stop.after, abs(stop.z[3]) < 1e-12) == (0, True)

    def slip(t: float, y: np.ndarray) -> list[float]:
        return [
            y[2],
            y[3],
            (80 * (W * t - y[0]) - 12 * (y[0] - y[1])) / 0.35,
            (12 * (y[0] - y[1]) - 1.2) / 0.04,
        ]

    at = whole.changes[0]
    found = solve_ivp(slip, (at.t, stop.t), at.z[:4], method="DOP853", rtol=1e-12, atol=1e-13)
    np.testing.assert_allclose(stop.z[:4], found.y[:, -1], atol=1e-10)


def chain(law: ss.CoulombFriction, count: int = 3) -> ss.Model:
    """Burridge and Knopoff (1967): blocks on a belt, each on a leaf spring, with springs between neighbours."""
    names = [f"b{i}" for i in range(count)]
    links = [ss.Link(between=(one, "ground"), stiffness=1) for one in names]
    links += [ss.Link(between=pair, stiffness=1.5) for pair in pairwise(names)]
    rig = ss.BodiesRig(
        body={one: ss.Body(mass=1) for one in names},
        link=links,
        contact=[ss.Contact(body=one, against="belt") for one in names],
    )
    return ss.Model(rig, friction=law)


@pytest.mark.study
def test_a_chain_of_blocks_keeps_its_symmetry_and_simultaneous_releases() -> None:
    law = ss.HyperbolicFriction(scale=1, decay=3)
    v = 0.2
    t = np.linspace(0, 17.5, 36)
    run = plain(chain(law), belt_speed=v, initial=[0.1, 0.4, 0.1, v, v, v], t_end=17.5, t_eval=t, tol=1e-10)
    np.testing.assert_allclose(run.state[:, 0], run.state[:, 2], atol=1e-9)
    pairs = [sorted(one.t for one in run.changes if one.contact == j) for j in (0, 2)]
    np.testing.assert_allclose(pairs[0], pairs[1], atol=1e-9)
    assert len(pairs[0]) > 2
    # identical blocks that start alike release together and stay alike: a single block
    same = plain(chain(law), belt_speed=v, initial=[0.3] * 3 + [v] * 3, t_end=9, t_eval=t[:19])
    one = plain(
        ss.Model(ss.BlockOnBelt(), friction=law), belt_speed=v, initial=[0.3, v], t_end=9, t_eval=t[:19]
    )
    for k in range(3):
        np.testing.assert_allclose(same.state[:, k], one.state[:, 0], atol=1e-8)


def test_what_sticks_can_be_held_and_what_slips_goes_its_way() -> None:
    """M couples the contacts: a release changes what the others carry at once, and may tear them off."""
    rig = ss.MatricesRig(
        M=[[1.08, -0.36, -0.17], [-0.36, 2.76, 1.01], [-0.17, 1.01, 2.51]],
        C=0.05 * np.eye(3),  # type: ignore[arg-type]
        K=[[3, -1, 0], [-1, 3, -1], [0, -1, 2]],
        contact=np.eye(3),  # type: ignore[arg-type]
    )
    law = ss.CoulombFriction(static=1, kinetic=0.2)
    model = ss.Model(rig, friction=law)
    run = plain(model, belt_speed=0.1, initial=[0.1, 0.2, 0, 0.1, 0.1, 0.1], t_end=25, tol=1e-9, max_step=0.5)
    assert run.status.ok
    at_once = [sum(abs(one.t - other.t) < 1e-9 for other in run.changes) for one in run.changes]
    assert max(at_once) > 1
    system = Bodies(general(model, 0.1))
    for step in run.steps:
        side: Modes = step.side
        T = np.array(system.friction(step.t, step.z, side), float)
        push = system.field(step.t, step.z, side)[3:6]
        v = step.z[3:6] - 0.1
        stuck = np.array(side.modes) == 0
        assert (np.abs(T[stuck]) <= 1 + 1e-9).all()
        np.testing.assert_allclose(v[stuck], 0, atol=1e-9)
        s = np.array(side.modes)[~stuck]
        begins = np.abs(v[~stuck]) < 1e-10
        assert (s[~begins] * v[~stuck][~begins] > 0).all()
        assert (s[begins] * push[~stuck][begins] > -1e-9).all()


def test_a_law_may_depend_on_the_time_at_rest_and_have_a_state() -> None:
    """Static friction that grows with the rest, as the effect `static_aging` and as a formula."""
    t = np.linspace(0, 10, 11)
    block = ss.BlockOnBelt(mass=1, stiffness=1)
    aging = ss.effect("static_aging", dT=0.5, tau=3.0)
    named = ss.Model(block, friction=ss.CoulombFriction(static=1, kinetic=0.5), effects=[aging])
    core = ss.simulate(named, belt_speed=0.1, initial=(0.9, 0.1), t_end=10, t_eval=t, rtol=1e-13, atol=1e-13)
    own = ss.FormulaFriction(kinetic="k", static="s + dT*(1 - exp(-dwell/tau))", k=0.5, s=1, dT=0.5, tau=3)
    run = plain(ss.Model(block, friction=own), belt_speed=0.1, initial=(0.9, 0.1), t_end=10, t_eval=t)
    assert len(run.changes) == len(core.transitions) > 1
    np.testing.assert_allclose(run.state, core.state, atol=1e-10)
    # the same with a state that relaxes at rest and is wiped out in slip
    lazy = ss.FormulaFriction(
        kinetic="k",
        static="s + g",
        states={"g": {"rate": "(dT - g)/tau - 1e4*u*g"}},
        k=0.5,
        s=1,
        dT=0.5,
        tau=3,
    )
    with_state = plain(
        ss.Model(block, friction=lazy),
        belt_speed=0.1,
        initial=(0.9, 0.1),
        t_end=5.2,  # just after the release: in slip this law is stiff
        t_eval=[5.2],
        max_step=0.02,
    )
    assert with_state.changes[0].t == pytest.approx(run.changes[0].t, abs=1e-9)


@pytest.mark.study
def test_tables_and_formulas_with_many_kinks_land_on_each() -> None:
    """A tabulated law is integrated as the smooth program that knows its cubics would."""
    law = ss.TabulatedFriction(speeds=[0, 0.05, 0.1, 0.2, 0.4], forces=[1, 0.7, 0.6, 0.65, 0.8], static=1.2)
    model = ss.Model(ss.BlockOnBelt(mass=1, stiffness=1), friction=law)
    run = plain(model, belt_speed=0.15, initial=(1.1, 0.15), t_end=6)
    curve = scipy.interpolate.PchipInterpolator([0, 0.05, 0.1, 0.2, 0.4], [1, 0.7, 0.6, 0.65, 0.8])
    release, stop = run.changes[0], run.changes[1]
    assert release.z[0] == pytest.approx(1.2, abs=1e-12)

    def slip(_: float, y: np.ndarray) -> list[float]:
        return [y[1], -y[0] + float(curve(min(max(0.15 - y[1], 0.0), 0.4)))]

    found = solve_ivp(
        slip, (release.t, stop.t), release.z, method="DOP853", rtol=1e-11, atol=1e-12, max_step=5e-3
    )
    np.testing.assert_allclose(stop.z, found.y[:, -1], atol=1e-7)
    assert stop.z[1] == pytest.approx(0.15, abs=1e-12)
