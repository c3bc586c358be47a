"""Hidden states are states: a run goes on from where it was cut, and a state without influence is none."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import stickslip as ss
from every_effect import EFFECTS
from stickslip.declared.catalogue import KINDS
from stickslip.errors import InputError
from stickslip.simulated.orbits.steady_sliding import NoLimitCycleError
from stickslip.simulated.states import HIDDEN

RIG = ss.Rig(alpha1=16, alpha2=8, beta3=4, eta1=0.1, eta12=0.2)
LAW = ss.HyperbolicFriction(scale=1, decay=3)
AGING = ss.effect("static_aging", dT=0.3, tau=1.0)
MODES = {-1: "slip-", 0: "stick", 1: "slip+"}


@pytest.mark.parametrize("name", EFFECTS)
@settings(max_examples=12, deadline=None)
@given(cut=st.floats(0.5, 39.5))
def test_a_run_cut_in_two_is_the_run(name, cut):
    """A stick that had lasted was judged as one that had just begun: the second half slipped at once."""
    model = ss.Model(RIG, friction=ss.PaperFriction(), effects=EFFECTS[name])
    how = {"belt_speed": 0.1, "t_end": 40.0, "rtol": 1e-12, "atol": 1e-12}
    whole = ss.simulate(model, initial=(0.1, 0.1, 0, 0), t_eval=[cut, 40.0], **how)
    state = (*whole.state[0], *(whole.hidden[one][0] * (one in whole.hidden_names) for one in HIDDEN))
    half = ss.simulate(
        model, initial=state, t_start=cut, t_eval=[40.0], contact=MODES[int(whole.mode[0])], **how
    )
    assert half.state[-1] == pytest.approx(whole.state[-1], abs=1e-6)
    for one in whole.hidden_names:
        assert half.hidden[one][-1] == pytest.approx(whole.hidden[one][-1], abs=1e-6)


def motions(effects):
    """A forced cycle, steady sliding and exponents, where nothing sticks."""
    force = ss.effect("harmonic_forcing", a=0.3, w=1.3, phi=0.0)
    forced = ss.Model(ss.BlockOnBelt(damping=0.1), friction=LAW, effects=[force, *effects])
    cycle = ss.limit_cycle(forced, 4.0)
    sliding = ss.steady_sliding(ss.Model(ss.BlockOnBelt(damping=0.3), friction=LAW, effects=effects), 4.0)
    exponents = ss.lyapunov(forced, belt_speed=4.0, t_end=500, transient=100).exponents
    return cycle, sliding, exponents


def test_the_time_at_rest_counts_for_nothing_where_nothing_rests():
    """A multiplier 1, an eigenvalue 0 and an exponent 0 more; stable motions called unstable."""
    bare, aged = motions([]), motions([AGING])
    assert aged[0].multipliers == pytest.approx(bare[0].multipliers, abs=1e-9)
    assert aged[1].eigenvalues == pytest.approx(bare[1].eigenvalues, abs=1e-9)
    assert aged[2] == pytest.approx(bare[2], abs=1e-6)
    assert aged[0].stable
    assert aged[1].stable


def test_a_branch_goes_on_where_sticks_with_aging_end():
    """It turned back at the loss of stick, and its Hopf point was never found."""
    model = ss.Model(ss.BlockOnBelt(damping=0.1), friction=LAW, effects=[AGING])
    branch = ss.continuation(model, 2.0, parameter="belt_speed", span=(0.5, 3.5), guess=(3.0, 0.0))
    hopf = [one.value for one in branch.special if one.kind == "hopf"]
    assert hopf == pytest.approx([(np.sqrt(30) - 1) / 3], abs=1e-6)


def test_a_cycle_that_keeps_what_it_is_given_is_neutral():
    """Every amplitude is a cycle of a block without damping under a constant friction: none of them is unstable."""
    model = ss.Model(ss.BlockOnBelt(), friction=ss.CoulombFriction(static=1, kinetic=1))
    cycle = ss.limit_cycle(model, 1.0, guess=(1.5, 0.0), period=2 * np.pi)
    assert cycle.neutral
    assert "neutral" in repr(cycle)


def repeats(name: str) -> bool:
    """Whether a motion under it may come back to itself."""
    for one in EFFECTS[name]:
        period = KINDS[one.name].behaves.period if isinstance(one, ss.Effect) else None
        try:
            period and period(one.parameters, 0.1)
        except InputError:
            return False
    return True


@pytest.mark.parametrize("name", [*filter(repeats, EFFECTS)])
def test_a_cycle_goes_back_into_simulate(name):
    """Its hidden states were taken for others: `simulate` wants all of them, in the order of the core."""
    model = ss.Model(RIG, friction=ss.PaperFriction(), effects=EFFECTS[name])
    try:
        cycle = ss.limit_cycle(model, 0.1)
    except NoLimitCycleError as no_cycle:
        pytest.skip(str(no_cycle))
    run = ss.simulate(
        model,
        belt_speed=0.1,
        initial=cycle.initial,
        contact=cycle.contact,
        t_end=cycle.period,
        t_eval=[cycle.period],
        rtol=1e-12,
        atol=1e-12,
    )
    hidden = [run.hidden[one][-1] for one in cycle.states[4:]]
    assert [*run.state[-1], *hidden] == pytest.approx(cycle.state, abs=1e-8)


@pytest.mark.parametrize("contact", ["auto", "stick"])
def test_a_rest_that_has_lasted_holds_as_long_as_its_age_says(contact):
    """It slipped at once: the start was judged as if it had just come to rest. Closed form: until x1 = 2, t = 8."""
    law, aging = ss.CoulombFriction(static=1, kinetic=0.5), ss.effect("static_aging", dT=1.0, tau=2.0)
    model = ss.Model(ss.BlockOnBelt(mass=1, stiffness=1), friction=law, effects=[aging])
    run = ss.simulate(model, belt_speed=0.1, initial=(1.2, 0.1, 0, 0, 0, 0, 50.0), contact=contact, t_end=20)
    assert run.transitions.t[0] == pytest.approx(8.0, abs=1e-8)


@pytest.mark.parametrize("stiffness", [1e3, 1e5])
def test_a_bristle_contact_may_start_riding_the_belt(stiffness):
    """With its spring relaxed it stopped at t = 0: "transitions accumulate"."""
    law = ss.CoulombFriction(static=1.2, kinetic=1.2)
    bristles = ss.effect("contact_compliance", k=stiffness, c=1.0)
    model = ss.Model(ss.BlockOnBelt(mass=0.5, stiffness=500.0), friction=law, effects=[bristles])
    runs = [ss.simulate(model, belt_speed=0.02, initial=(0.0, x2), t_end=1.0) for x2 in (0.02, 0.02 - 1e-12)]
    assert all(run.status.ok for run in runs)
    assert runs[0].state[-1] == pytest.approx(runs[1].state[-1], abs=1e-9)
