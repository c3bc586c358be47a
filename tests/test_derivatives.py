"""Derivatives through sticks, releases, crossings and kinks, against arithmetic that shares no code with the core."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.linalg import expm

import extended
import stickslip as ss

TRANSITIONS = 20
MEMBERS = 25  # of a seed, as bench/bench_exact.py draws them
FEW = 6


def draw(rng):
    """A random rig, law, belt speed and start."""
    u = rng.uniform
    if rng.random() < 0.65:
        eta1 = u(0, 0.3)
        rig = ss.Rig(
            alpha1=u(8, 40), alpha2=u(4, 20), beta3=u(1.5, 6), eta1=eta1, eta12=eta1 + u(0, 0.3),
            coupling="as_printed" if rng.random() < 0.15 else "reciprocal",
        )  # fmt: skip
    else:
        rig = ss.BlockOnBelt(mass=u(0.5, 2), stiffness=u(0.5, 2), damping=u(0, 0.1))
    kind, both = rng.integers(3), rng.random() < 0.5
    static = u(0.5, 3)
    if kind == 0 and isinstance(rig, ss.Rig):
        law = ss.PaperFriction(
            T_s_minus=u(5.2, 6.6), T_s_plus=u(3, 4.2), T_min_minus=u(1, 1.8), t2=u(0.25, 0.4)
        )
    elif kind == 1:
        plus = None if both else u(0.5, 3)
        law = ss.CoulombFriction(
            static=static, kinetic=static * u(0.3, 0.9) if plus is None else min(static, plus) * u(0.3, 0.9),
            static_plus=plus, kinetic_plus=None if plus is None else plus * u(0.3, 0.9),
        )  # fmt: skip
    else:
        law = ss.HyperbolicFriction(
            scale=static, decay=u(1, 5), constant=u(0, 0.5), quadratic=u(0, 0.2),
            scale_plus=None if both else u(0.5, 3),
        )  # fmt: skip
    v_b = u(0.05, 0.4) * (1 if rng.random() < 0.7 else -1)
    start = [u(-0.4, 0.4), u(-0.4, 0.4)] + ([u(-0.1, 0.1), u(-0.1, 0.1)] if isinstance(rig, ss.Rig) else [])
    return ss.Model(rig, friction=law), v_b, start


def pieces_of(run, model, v_b, start):
    """The sequence of pieces that a run in double precision went through."""
    changes = [(t, int(after)) for t, after in zip(run.transitions.t, run.transitions.after, strict=True)]
    changes += [(t, "kink") for t in run.kinks]
    changes.sort(key=lambda change: change[0])
    mode = int(np.sign(start[1] - v_b))
    kink = model.friction.kinks[0 if mode < 0 else 1]
    saturated = kink is not None and abs(start[1] - v_b) >= kink
    pieces = []
    for t, event in changes:
        pieces.append((mode, saturated, event, t))
        mode, saturated = extended.after(pieces[-1])
    return pieces


def relative(ours, theirs):
    """Greatest error beside the greatest derivative of its kind."""
    return float(np.abs(ours - theirs).max() / max(np.abs(theirs).max(), 1e-3))


def member(rng):
    """Errors of derivatives of one random rig: of transition times, states at them, state at a fixed time."""
    model, v_b, start = draw(rng)
    run = ss.simulate(
        model, belt_speed=v_b, initial=start, t_end=400, rtol=1e-13, atol=1e-13, max_transitions=80
    )
    if len(run.transitions) < TRANSITIONS + 2:
        return None
    ends = run.transitions.t
    t_end = 0.5 * (ends[TRANSITIONS] + ends[TRANSITIONS + 1])
    visible = model.rig.state_names
    names = (*model.parameters, "belt_speed", *(f"initial.{s}" for s in visible))
    run = ss.simulate(
        model,
        belt_speed=v_b,
        initial=start,
        t_end=t_end,
        t_eval=[t_end],
        rtol=1e-14,
        atol=1e-14,
        sensitivity=names,
    )
    values = {**model.parameters, "belt_speed": v_b}
    steps = [5e-6 * max(abs(values.get(name, 0.3)), 0.1) for name in names]
    lanes = extended.lanes_of(model, v_b, names, steps)
    z = extended.starts_of(start, visible, names, steps)
    t, states, last, least = extended.follow(lanes, z, pieces_of(run, model, v_b, start), t_end)
    if least < 1e-3:  # close to a graze, where the derivative does not exist
        return None
    contact = np.isin(np.sort(np.concatenate([run.transitions.t, run.kinks])), run.transitions.t)
    times, at, final = (extended.differences(a, steps) for a in (t[contact], states[contact], last))
    tr = run.transitions
    return max(
        max(relative(tr.sensitivity[:, k], times[:, k]) for k in range(len(names))),
        max(relative(tr.state_sensitivity[..., k], at[..., k]) for k in range(len(names))),
        max(relative(run.sensitivity[0, :, k], final[:, k]) for k in range(len(names))),
    )


def members(seed, count=MEMBERS):
    """Errors of random rigs, those where no derivative exists passed over."""
    rng = np.random.default_rng([20260101, seed])
    errors, drawn = [], 0
    while len(errors) < count:
        drawn += 1
        assert drawn < 12 * count
        error = member(rng)
        if error is not None:
            errors.append(error)
    return errors


@pytest.mark.skipif(not extended.ENOUGH, reason="long double has no more than double's precision here")
def test_derivatives_agree_with_differences_in_extended_precision():
    errors = members(0, FEW)
    assert len(errors) == FEW
    assert max(errors) < 1e-7
    assert np.median(errors) < 1e-9


# -- the textbook saltation matrix ----------------------------------------------------------------------------


class Linear:
    """(2.1) where friction is linear in v_w: z' = A z + b in every mode, so that the flow is an exponential."""

    def __init__(self, model, v_b):
        self.r, self.law, self.v_b = model.rig, model.friction, v_b

    def matrix(self, mode, saturated):
        r, s = self.r, 1.0 if self.r.coupling == "reciprocal" else -1.0
        a = np.zeros((5, 5))  # (x1, x2, y1, y2, 1)
        a[0, 1] = a[2, 3] = 1
        a[3, :4] = np.array([-1, -r.eta1, -r.beta3, -r.eta12]) / r.alpha2
        if mode:
            a[1, :4] = np.array([-r.alpha1, -r.eta1, -s, -r.eta1]) / r.alpha1
            magnitude, slope = self.magnitude(mode, saturated)
            a[1, 1] -= slope / r.alpha1
            a[1, 4] = (slope * self.v_b - mode * magnitude) / r.alpha1
        return a

    def magnitude(self, mode, saturated):
        """R = magnitude + slope u."""
        law = self.law
        if isinstance(law, ss.CoulombFriction):
            kinetic = law.kinetic if mode < 0 or law.kinetic_plus is None else law.kinetic_plus
            return kinetic, 0.0
        assert mode > 0  # the straight branch of (4.2)
        if saturated:
            return law.T_min_plus, 0.0
        return law.T_s_plus, -(law.T_s_plus - law.T_min_plus) / law.v_w_max

    def normal(self, mode):
        """Gradient of what vanishes at the end of a piece: v_w in slip, the demand q in stick."""
        s = 1.0 if self.r.coupling == "reciprocal" else -1.0
        return np.array([self.r.alpha1, 0, s, self.r.eta1]) if mode == 0 else np.array([0.0, 1, 0, 0])

    def saltation(self, z, before, after):
        """S = 1 + (f+ - f-) n / (n . f-), and n . f- which must not vanish."""
        z = np.append(z, 1.0)
        f_before, f_after = (self.matrix(*side) @ z for side in (before, after))
        n = self.normal(before[0])
        return np.eye(4) + np.outer((f_after - f_before)[:4], n) / (n @ f_before[:4])


RIG = ss.Rig(alpha1=16, alpha2=8, beta3=4, eta1=0.1, eta12=0.2)
COULOMB = ss.Model(
    RIG, friction=ss.CoulombFriction(static=2.2, kinetic=1.3, static_plus=1.5, kinetic_plus=1.1)
)
# belt running backwards, slips ahead of it only: the straight branch of Table 1, with its kink
PAPER = ss.Model(RIG, friction=ss.PaperFriction())
CASES = {
    "stick to slip, slip to stick": (COULOMB, 0.1, (0.05, 0.1, 0.0, 0.02), 25.0, {(0, -1), (-1, 0)}),
    "crossing": (COULOMB, 0.02, (-1.2, 0.5, 0.1, 0.0), 8.0, {(1, -1), (-1, 1)}),
    "kink": (PAPER, -0.25, (-0.2, -0.25, 0.0, 0.02), 16.0, {(0, 1), (1, 0), "kink"}),
}


@pytest.mark.parametrize("name", CASES)
def test_derivatives_are_those_of_the_textbook_saltation_matrix(name):
    model, v_b, start, t_end, expected = CASES[name]
    names = tuple(f"initial.{s}" for s in model.rig.state_names)
    run = ss.simulate(
        model,
        belt_speed=v_b,
        initial=start,
        t_end=t_end,
        t_eval=[0.0, t_end],
        rtol=1e-14,
        atol=1e-14,
        sensitivity=names,
    )
    linear, seen = Linear(model, v_b), set()
    mode, saturated, now = int(run.mode[0]), False, 0.0
    z, product = np.array([*start, 1.0]), np.diag([1.0, float(mode != 0), 1, 1])
    pieces = [(t, int(a)) for t, a in zip(run.transitions.t, run.transitions.after, strict=True)]
    pieces = sorted([*pieces, *((t, None) for t in run.kinks)])
    for t, after in pieces:
        flow = expm(linear.matrix(mode, saturated) * (t - now))
        z, product, now = flow @ z, flow[:4, :4] @ product, t
        into = (mode, not saturated) if after is None else (after, False)
        seen.add("kink" if after is None else (mode, after))
        product = linear.saltation(z[:4], (mode, saturated), into) @ product
        mode, saturated = into
    flow = expm(linear.matrix(mode, saturated) * (t_end - now))
    assert seen >= expected
    assert (flow @ z)[:4] == pytest.approx(run.state[-1], abs=1e-11)
    assert flow[:4, :4] @ product == pytest.approx(run.sensitivity[-1], abs=1e-10)


# -- observables ----------------------------------------------------------------------------------------------


def test_derivative_of_the_period_in_closed_form():
    # Coulomb on a belt: period 2 (pi - atan(A/v)) + 2 A/v, A = static - kinetic
    static, kinetic, v = 1.0, 0.4, 0.25
    model = ss.Model(ss.BlockOnBelt(), friction=ss.CoulombFriction(static=static, kinetic=kinetic))
    names = ("belt_speed", "static", "kinetic", "initial.x1")
    run = ss.simulate(model, belt_speed=v, initial=(0.2, 0.1), t_end=60, sensitivity=names)
    releases = run.transitions.before == 0
    a = static - kinetic
    period = 2 * (np.pi - np.arctan(a / v)) + 2 * a / v
    by_a = -2 * v / (v**2 + a**2) + 2 / v
    by_v = 2 * a / (v**2 + a**2) - 2 * a / v**2
    assert np.diff(run.transitions.t[releases])[1:] == pytest.approx(period, rel=1e-12)
    slopes = np.diff(run.transitions.sensitivity[releases], axis=0)[1:]
    assert slopes == pytest.approx(np.tile([by_v, by_a, -by_a, 0.0], (len(slopes), 1)), rel=1e-10, abs=1e-10)


def test_a_block_stuck_forgets_its_velocity():
    names = ("initial.x1", "initial.x2")
    model = ss.Model(ss.BlockOnBelt(), friction=ss.CoulombFriction())
    run = ss.simulate(
        model, belt_speed=0.2, initial=(0.9, 0.0), t_end=20, t_eval=[20.0], sensitivity=names, contact="slip-"
    )
    assert np.linalg.svd(run.sensitivity[0], compute_uv=False)[-1] < 1e-12
