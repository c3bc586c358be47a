"""Random rigs, laws, starts and effects with well-posed runs, and a run's distance from an ill-posed one."""

from __future__ import annotations

import math
from dataclasses import replace
from itertools import pairwise

import numpy as np
from hypothesis import strategies as st
from scipy.optimize import brentq

from every_effect import usual
from stickslip.declared.effect import CATALOGUE, effect
from stickslip.declared.friction.coulomb import CoulombFriction
from stickslip.declared.friction.hyperbolic import HyperbolicFriction
from stickslip.declared.friction.paper import PaperFriction
from stickslip.declared.model import Model, idle
from stickslip.declared.rig import BlockOnBelt, Rig
from stickslip.simulated.reference import integrate as reference


def numbers(low, high):
    """Floats of a dozen bits: shrinks well, and hits round values that sit on surfaces."""
    return st.integers(0, 4096).map(lambda i: low + (high - low) * i / 4096)


@st.composite
def rigs(draw):
    eta1 = draw(numbers(0.0, 0.3))
    return Rig(
        alpha1=draw(numbers(8, 40)),
        alpha2=draw(numbers(4, 20)),
        beta3=draw(numbers(1.5, 6)),
        eta1=eta1,
        eta12=eta1 + draw(numbers(0.0, 0.3)),
        coupling=draw(st.sampled_from(["reciprocal", "reciprocal", "reciprocal", "as_printed"])),
    )


def blocks():
    return st.builds(BlockOnBelt, mass=numbers(0.5, 2), stiffness=numbers(0.5, 2), damping=numbers(0, 0.3))


@st.composite
def paper_laws(draw):
    return PaperFriction(
        T_s_minus=draw(numbers(5.2, 6.6)),
        A1=draw(numbers(2.8, 3.6)),
        A2=draw(numbers(2.5, 3.1)),
        t1=draw(numbers(0.03, 0.05)),
        t2=draw(numbers(0.2, 0.4)),
        T_min_minus=draw(numbers(1.0, 1.8)),
        T_s_plus=draw(numbers(3.0, 4.2)),
        T_min_plus=draw(numbers(0.5, 1.2)),
    )


@st.composite
def coulomb_laws(draw):
    static, plus = draw(numbers(0.2, 3)), draw(st.none() | numbers(0.2, 3))
    kinetic = static * draw(numbers(0.2, 1))
    # with one kinetic for both ways it must lie below both limits
    if plus is None:
        return CoulombFriction(static=static, kinetic=kinetic)
    return CoulombFriction(
        static=static, kinetic=kinetic, static_plus=plus, kinetic_plus=plus * draw(numbers(0.2, 1))
    )


def hyperbolic_laws():
    other = st.none() | numbers(0.2, 3)
    return st.builds(
        HyperbolicFriction,
        scale=numbers(0.2, 3),
        decay=numbers(0, 5),
        constant=numbers(0, 0.5),
        quadratic=numbers(0, 0.3),
        scale_plus=other,
        constant_plus=st.none() | numbers(0, 0.5),
    )


def belt_speeds():
    return st.just(0.0) | numbers(0.02, 0.4) | numbers(-0.4, -0.02)


# sizes at which an effect shows and a run stays well posed: friction never negative, springs tame
SIZES = {
    "block_viscous_damping": {"c": (0.05, 1)},
    "block_quadratic_damping": {"c": (0.5, 5)},
    "spring_cubic_k1": {"k": (1, 20)},
    "spring_cubic_k2": {"k": (1, 20)},
    "spring_cubic_k3": {"k": (1, 100)},
    "spring_gap_k3": {"k": (0.5, 8), "d": (0.02, 0.15)},
    "constant_load": {"f": (-0.5, 0.5)},
    "harmonic_forcing": {"a": (0.1, 1), "w": (0.3, 3), "phi": (0, 6)},
    "pivot_dry_friction": {"f": (0.01, 0.1)},
    "normal_force_feedback": {"beta2": (-10, 10), "eta2": (-5, 5)},
    "stribeck_peak": {"dT": (0.1, 1), "v_s": (0.02, 0.1)},
    "static_aging": {"dT": (0.1, 1), "tau": (0.5, 5)},
    "friction_memory": {"tau": (0.05, 0.4)},
    "friction_drift": {"r": (-0.01, 0.01)},
    "belt_seam": {"a": (0.05, 0.4), "L": (0.5, 3), "phi": (0, 6)},
    "contact_compliance": {"k": (100, 500), "c": (0.5, 3)},
    "belt_speed_ripple": {"a": (0.05, 0.4), "w": (0.5, 3), "phi": (0, 6)},
    "belt_load_droop": {"k": (0.001, 0.02), "tau": (0.2, 1)},
}
SIZES |= {  # of one that is not here, about what it is tested with elsewhere
    name: {key: (0.5 * size, 1.5 * size) for key, size in usual(name).items()}
    for name, kind in CATALOGUE.items()
    if name not in SIZES and kind.physics == "dynamics"
}


@st.composite
def effects(draw, name):
    return effect(name, **{p: draw(numbers(*span)) for p, span in SIZES[name].items()})


@st.composite
def runs(draw, names=None, most=2):
    """Model, belt speed and start; `names` are the effects to draw from, all that move the rig by default."""
    two = draw(st.sampled_from([True, True, False]))
    rig = draw(rigs() if two else blocks())
    law = draw(st.one_of(paper_laws(), coulomb_laws(), hyperbolic_laws()))
    usable = [n for n in (SIZES if names is None else names) if two or not CATALOGUE[n].two_degree]
    chosen = draw(st.lists(st.sampled_from(usable), max_size=most, unique=True)) if usable else []
    if isinstance(law, HyperbolicFriction) and "friction_memory" in chosen:
        chosen.remove(
            "friction_memory"
        )  # R(|w|) may exceed the static limit: no mode is then possible at v = 0
    if idle(law, chosen):
        chosen = [one for one in chosen if one not in ("friction_memory", "static_aging")]
    v_b = draw(belt_speeds())
    start = [draw(numbers(-0.4, 0.4)), draw(st.just(v_b) | numbers(-0.4, 0.4))]
    if two:
        start += [draw(numbers(-0.1, 0.1)), draw(numbers(-0.1, 0.1))]
    return Model(rig, friction=law, effects=[draw(effects(n)) for n in chosen]), v_b, tuple(start)


def clearance(run: reference.Run) -> float:
    """Distance of a run from the nearest one with another sequence of modes, in switching functions' units.

    The least of: the rate at which a switching function is crossed; the height of its summits between
    crossings, above or below zero; what the other switching functions keep from zero at a switching, and the
    force demanded from the static limits at a return to the belt. Below some 1e-3 two correct programs may
    part (a graze, a tie). Nothing but the reference's own trajectory enters.
    """
    least = math.inf
    for step, after in pairwise(run.steps):
        least = min(least, _summits(run.system, step))
        if after.side != step.side:
            least = min(least, _landing(run.system, step, after))
    return least


def _landing(system, step, after):
    """At the end of a leg: the rate of what is crossed, and what the rest keeps from zero."""
    z = run_end(system, step)
    crossed, least = 0, math.inf
    for guard in system.guards(step.side).values():
        s = abs(float(guard(step.end, z)))
        if s < 1e-9:
            crossed += 1
            least = min(least, float(system.rate(guard, step.end, z, step.side)))
        else:
            least = min(least, s)
    if crossed != 1:
        return 0.0
    if step.side.contact and after.side.since != step.side.since and not system.compliant:  # came to rest
        rest = replace(after.side, contact=0, since=step.end)
        q = float(system.demand(step.end, z, rest))
        limits = (float(system.limit(-1, step.end, z, rest)), -float(system.limit(1, step.end, z, rest)))
        least = min(least, *(abs(q - limit) for limit in limits))
    return least


def run_end(system, step):
    return reference.advance(system, step.side, step.t, step.z, step.end)


def _summits(system, step):
    """How far below zero the switching functions' summits within a step stay."""
    least = math.inf
    times = np.linspace(step.t, step.end, 9)
    states = step.dense(times)
    for guard in system.guards(step.side).values():
        s, rise = guard(times, states), system.rate(guard, times, states, step.side)
        for j in np.flatnonzero((rise[:-1] > 0) & (rise[1:] < 0)):
            if j == 0 and s[0] > -1e-9:
                continue  # it has only just left this surface
            top = brentq(
                lambda t, g=guard: float(system.rate(g, t, step.dense(t), step.side)), *times[j : j + 2]
            )
            least = min(least, abs(float(guard(top, step.dense(top)))))
    return least
