"""A run that is cut, and goes on from where it was cut, is the run: on every rig, with all that is hidden in it."""

from dataclasses import dataclass, field
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import stickslip as ss
from stickslip.errors import InputError

DWELLS = ss.FormulaFriction(kinetic="0.6", static="0.6 + 0.4*(1 - exp(-dwell))")
LAW = ss.CoulombFriction(static=1.0, kinetic=0.5)
SLIDER = ss.BodiesRig(
    body={"block": ss.Body(mass=1.0)},
    link=[ss.Link(between=("block", "ground"), stiffness=1.0, damping=0.05)],
    contact=[ss.Contact(body="block", against="belt")],
)
PULLED = ss.BodiesRig(
    body={"block": ss.Body(mass=1.0), "second": ss.Body(mass=0.5)},
    link=[
        ss.Link(between=("block", "drive"), stiffness=1.0, damping=0.05),
        ss.Link(between=("second", "block"), stiffness=2.0, damping=0.05),
    ],
    contact=[ss.Contact(body="block"), ss.Contact(body="second")],
)
PAPER = ss.Rig(alpha1=16, alpha2=8, beta3=4, eta1=0.1, eta12=0.2)
SEAM, AGING = ss.effect("belt_seam", a=0.3, L=1.3, phi=0.4), ss.effect("static_aging", dT=0.4, tau=2.0)
SWINGS = "0.1 + 0.05*sin(0.3*t)"


@dataclass
class One:
    """A model and what moves it."""

    model: ss.Model
    speeds: dict[str, Any]
    end: float = 60.0
    initial: tuple[float, ...] | None = None
    how: dict[str, float] = field(default_factory=lambda: {"rtol": 1e-12, "atol": 1e-12})


CASES = {
    "block, limit that grows": One(
        ss.Model(ss.BlockOnBelt(damping=0.05), friction=DWELLS), {"belt_speed": 0.1}
    ),
    "bodies, limit that grows": One(ss.Model(SLIDER, friction=DWELLS), {"belt_speed": 0.1}),
    "bodies, seam": One(ss.Model(SLIDER, friction=LAW, effects=[SEAM]), {"belt_speed": 0.1}),
    "bodies, seam of a belt that swings": One(
        ss.Model(SLIDER, friction=LAW, effects=[SEAM]), {"belt_speed": SWINGS}
    ),
    "bodies, aging": One(ss.Model(SLIDER, friction=LAW, effects=[AGING]), {"belt_speed": 0.1}),
    "bodies, aging on a belt that swings": One(
        ss.Model(SLIDER, friction=LAW, effects=[AGING]), {"belt_speed": SWINGS}
    ),
    "pulled, two contacts": One(ss.Model(PULLED, friction=DWELLS), {"drive_speed": 0.1}),
    "paper, seam of a belt that swings": One(
        ss.Model(PAPER, friction=ss.PaperFriction(), effects=[SEAM]), {"belt_speed": SWINGS}, 40.0
    ),
    "paper, aging on a belt that swings": One(
        ss.Model(PAPER, friction=ss.PaperFriction(), effects=[AGING]), {"belt_speed": SWINGS}, 40.0
    ),
    "paper, aging": One(
        ss.Model(PAPER, friction=ss.PaperFriction(), effects=[AGING]), {"belt_speed": 0.1}, 40.0
    ),
}


@pytest.mark.parametrize("name", CASES)
@settings(max_examples=8, deadline=None)
@given(share=st.floats(0.05, 0.9), again=st.floats(0.1, 0.9))
def test_what_goes_on_is_the_run(name: str, share: float, again: float) -> None:
    """Cut twice: what a cut keeps of an earlier one counts too."""
    one = CASES[name]
    first = share * one.end
    second = first + again * (one.end - first)
    whole = ss.simulate(
        one.model, **one.speeds, initial=one.initial, t_end=one.end, t_eval=[one.end], **one.how
    )
    part = ss.simulate(one.model, **one.speeds, initial=one.initial, t_end=first, t_eval=[first], **one.how)
    for end in (second, one.end):
        part = ss.simulate(one.model, **one.speeds, initial=part, t_end=end, t_eval=[end], **one.how)
    assert part.state[-1] == pytest.approx(whole.state[-1], abs=1e-6)
    assert (part.mode[-1] == whole.mode[-1]).all()
    assert part.rested == pytest.approx(whole.rested, abs=1e-6)
    for key, way in whole.travelled.items():
        assert part.travelled[key][-1] == pytest.approx(way[-1], abs=1e-9)


def test_what_cannot_go_on_is_refused() -> None:
    model = ss.Model(SLIDER, friction=LAW)
    run = ss.simulate(model, belt_speed=0.1, t_end=5.0)
    with pytest.raises(InputError, match="is a run of another rig than the model's"):
        ss.simulate(ss.Model(PAPER, friction=ss.PaperFriction()), belt_speed=0.1, initial=run, t_end=9.0)
    with pytest.raises(InputError, match="the run to go on from ends at 5; leave it out"):
        ss.simulate(model, belt_speed=0.1, initial=run, t_start=3.0, t_end=9.0)
    with pytest.raises(InputError, match="the run to go on from has its own; leave it out"):
        ss.simulate(model, belt_speed=0.1, initial=run, contact="stick", t_end=9.0)
    aged, swings = CASES["paper, aging"], CASES["paper, aging on a belt that swings"]
    for before, after in ((aged, swings), (swings, aged)):
        part = ss.simulate(before.model, **before.speeds, t_end=9.0)
        with pytest.raises(InputError, match="goes on as it began"):
            ss.simulate(after.model, **after.speeds, initial=part, t_end=19.0)
    on = ss.simulate(model, belt_speed=0.1, initial=run, t_end=9.0)
    assert on.t[0] == run.t[-1]
    assert np.array_equal(on.state[0], run.state[-1])
