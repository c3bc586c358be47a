"""Of a block that no longer sticks nothing is forecast: its friction is known from event to event."""

from pathlib import Path

import numpy as np
import pytest

import stickslip as ss
from recorded import recording
from stickslip.fitted.data import prepare
from stickslip.likelihoods.ahead import _slips_on, ahead
from stickslip.likelihoods.belt_windows import BeltWindows
from stickslip.likelihoods.block_windows import BlockSensors
from stickslip.likelihoods.fit import null
from stickslip.likelihoods.members import Flown
from stickslip.likelihoods.policy import POLICY
from stickslip.likelihoods.shared import Declared
from stickslip.likelihoods.stretches import stretches
from stickslip.simulated.states import X2

SPEED, STEP, NOISE = 0.2, 0.02, 1e-3


def test_no_forecast_begins_in_a_slip_that_goes_on(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    law, t = ss.CoulombFriction(static=1, kinetic=0.5), np.arange(0, 80, STEP)
    free = ss.Model(ss.BlockOnBelt(), friction=law)
    sticks = ss.simulate(free, belt_speed=SPEED, initial=(0, SPEED), t_end=80, t_eval=t)
    slips = int(np.argmin(sticks.state[3000:, 1])) + 3000  # from there on a damper keeps it from sticking
    damped = ss.Model(ss.BlockOnBelt(damping=0.8), friction=law)
    on = ss.simulate(damped, belt_speed=SPEED, initial=sticks.state[slips], t_end=80, t_eval=t)
    assert (on.mode[1:] != 0).all()
    x1 = np.concatenate([sticks.state[:slips, 0], on.state[:, 0]])
    x1 += NOISE * np.random.default_rng(3).standard_normal(len(x1))
    time = STEP * np.arange(len(x1))
    run = prepare([recording(tmp_path, ss.BlockOnBelt(), time, x1, None, SPEED, "run", NOISE)])[0]
    windows = BeltWindows(free, [run], stretches([run]), [], Declared(), BlockSensors(("gain.x1",), None))
    fit = null(windows, POLICY)
    every = [one.start for one in ahead(fit, run, 1.0)]
    longest = max(one.stop - one.start for one in windows.stretches)
    assert len(every) > 3
    assert max(every) < slips + 2 * longest < len(x1) - 2 * run.cycle / STEP
    monkeypatch.setattr("stickslip.likelihoods.ahead._slips_on", lambda *_: True)
    assert ahead(fit, run, 1.0) == []


def test_no_forecast_is_through_a_slip_that_passes_a_place_again() -> None:
    """A damper kept a block from sticking, whose friction differed from swing to swing: a right name was taken back."""
    t = np.linspace(0, 4 * np.pi, 400)
    swing = np.cos(t)  # forth, back, forth, back, forth
    once, twice = (swing, t < 2 * np.pi), (swing, t < 4 * np.pi)  # while it slips
    stuck_between = (swing, np.abs(t - 2 * np.pi) > 0.5)
    for way in (1.0, -1.0):
        for members, told in (
            ([once] * 4, False),
            ([twice] * 4, True),
            ([stuck_between] * 4, False),
            ([twice, once, once, once], False),
            ([twice, twice, once, once], True),
        ):
            state = np.zeros((4, len(t), 9))
            state[:, :, X2] = way * np.array([v for v, _ in members])
            mode = np.array([-way * slips for _, slips in members]).astype(np.int8)
            assert _slips_on(Flown(np.zeros((4, len(t), 1)), state, mode), way * 0.2) == told
