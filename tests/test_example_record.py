"""The record in closed form that examples take: it is what the core makes of its rig."""

from __future__ import annotations

import doctest

import numpy as np

import stickslip as ss
from stickslip import data


def test_the_closed_form_is_the_motion_that_the_core_simulates() -> None:
    t, x = data.stick_slip(noise=0.0)
    rig = ss.BlockOnBelt(mass=0.5, stiffness=500.0)
    model = ss.Model(rig, friction=ss.CoulombFriction(static=2.0, kinetic=1.2))
    run = ss.simulate(model, belt_speed=0.01, initial=(0.0, 0.01), t_end=6.0, t_eval=t)
    np.testing.assert_allclose(run.x1, x, atol=1e-11)
    noisy = data.stick_slip()[1]
    assert 0.9e-6 < np.std(noisy - x) < 1.1e-6
    assert np.array_equal(noisy, data.stick_slip()[1])


def test_its_example_runs() -> None:
    assert doctest.testmod(data).failed == 0
