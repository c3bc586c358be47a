"""Windows of the rig of (2.1) from mid-stick to mid-stick, with numbers of their own."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

import stickslip as ss
from differences import held_against_differences
from stickslip.fitted.data import Data
from stickslip.likelihoods.belt_windows import BeltWindows
from stickslip.likelihoods.declared_numbers import BESIDE
from stickslip.likelihoods.fit_state import begin
from stickslip.likelihoods.rig_windows import RigSensors
from stickslip.likelihoods.shared import Declared, SharedNumber
from stickslip.likelihoods.single_windows import lifted
from stickslip.likelihoods.stretches import stretches

RIG = ss.Rig(alpha1=16, alpha2=8, beta3=4, eta1=0.1, eta12=0.2)
MODEL = ss.Model(RIG, friction=ss.PaperFriction(), effects=())
LAW = ("T_s_minus", "T_min_minus", "alpha1", "eta1")
EFFECTS = {
    "nothing": (),
    "droop": (ss.effect("belt_load_droop", k=0.002, tau=0.7),),
    "lag": (ss.effect("sensor_lag", tau=0.1), ss.effect("sensor_crosstalk", c=0.1)),
    "ripple": (
        ss.effect("belt_speed_ripple", a=0.1, w=2.0, phi=0.4),
        ss.effect("sensor_delay", delay=0.1),
        ss.effect("static_aging", dT=0.4, tau=1.5),
    ),
    "springs": (ss.effect("belt_load_droop", k=0.002, tau=0.7),),
    "memory": (ss.effect("friction_memory", tau=0.05), ss.effect("belt_seam", a=0.1, L=4.0, phi=0.2)),
}
BELT, NOISE = 0.1, 1e-3


@pytest.fixture(scope="module")
def windows() -> BeltWindows:
    """A run that the model made, without noise."""
    return made(recorded(MODEL, BELT), ())


def recorded(model: ss.Model, belt: float) -> list[Data]:
    """One run of a model, without noise."""
    t = np.arange(0.0, 60.0, 0.02)
    run = ss.simulate(model, belt_speed=belt, initial=(0.1, belt, 0, 0), t_end=t[-1], t_eval=t)
    readings = run.state[:, [0, 2]]
    v = run.state[:, 1]
    slips = [a + int(np.argmax(np.abs(v[a:b] - belt))) for a, b in _slipping(run.mode)]
    weight = np.full_like(readings, 1 / NOISE)
    noise, held = np.full(2, NOISE), np.zeros_like(readings, dtype=bool)
    cycle = float(np.median(np.diff(t[slips])))
    return [Data("run", "train", belt, t, readings, weight, noise, v, np.array(slips), cycle, held)]


def made(data: list[Data], effects: tuple[ss.Effect, ...], *, beside: bool = False) -> BeltWindows:
    """Windows of a run under a model with effects, all their numbers shared; springs `beside` alpha1, too."""
    model = ss.Model(RIG, friction=ss.PaperFriction(), effects=effects)
    numbers = [
        SharedNumber(n, float(np.log(model.parameters[n])), float(np.log(model.parameters[n])), 1.0, True)
        for n in LAW
    ]
    numbers += [SharedNumber(n, 0.002, 0.0, 0.01) for n in ("gain.x1", "gain.y1")]
    if beside:
        numbers.append(SharedNumber(BESIDE, 0.1, 0.0, 0.2))
    for one in effects:
        numbers += [
            SharedNumber(f"{one.name}.{k}", v, v, np.inf, run=0 if k == "phi" else None)
            for k, v in one.parameters.items()
        ]
    return BeltWindows(model, data, stretches(data), numbers, Declared(), RigSensors())


def _slipping(mode: NDArray[np.int8]) -> list[tuple[int, int]]:
    edges = np.flatnonzero(np.diff(np.concatenate([[0], (mode != 0).astype(int), [0]])))
    return [(int(a), int(b)) for a, b in zip(edges[::2], edges[1::2], strict=True)]


def start(windows: BeltWindows) -> NDArray[np.float64]:
    """Coordinates of the declared numbers."""
    return np.array([n.start for n in windows.numbers])


def test_the_true_model_leaves_nothing(windows: BeltWindows) -> None:
    assert len(windows.stretches) >= 3
    own, at = windows.first(), start(windows)
    at[len(LAW) :] = 0.0  # no gain
    for row, w in zip(own, windows.stretches, strict=True):
        row[:2] = windows.data[0].readings[w.start]
    for block in windows.blocks(at, own):
        assert block is not None
        assert np.median(np.abs(block[:, :, -1])) < 3.0


def test_a_motion_is_what_the_blocks_are_of(windows: BeltWindows) -> None:
    own, at = windows.first(), start(windows)
    for s, block, motion in zip(
        windows.stretches, windows.blocks(at, own), windows.motions(at, own), strict=True
    ):
        assert block is not None
        assert motion is not None
        left = (windows.data[0].readings[s.start : s.stop] - motion.readings) / NOISE
        assert np.abs(left - block[:, :, -1]).max() < 1e-2


@pytest.mark.parametrize("name", EFFECTS)
def test_derivatives_are_those_of_differences(windows: BeltWindows, name: str) -> None:
    of_effects = made(windows.data, EFFECTS[name], beside=name == "springs")
    held_against_differences(of_effects, start(of_effects), name)


def test_static_friction_is_found_above_the_kinetic_friction_below_which_it_does_not_act() -> None:
    """With v_w > 0 kinetic friction begins at the static limit: below it a window's own limit has no slope."""
    aged = MODEL.with_effects([ss.effect("static_aging", dT=0.3, tau=1e-3)])
    windows = made(recorded(aged, -BELT), ())
    fit = begin(windows)
    fit.at[len(LAW) :] = 0.0  # no gain
    fit.own[:, windows.begins] = -0.01
    fit = replace(fit, blocks=windows.blocks(fit.at, fit.own))
    static = len(windows.numbers) + windows.begins
    for block in fit.blocks:
        assert block is not None
        assert 0.01 * np.linalg.norm(block[:, :, static]) < 0.01
        assert np.mean(block[:, :, -1] ** 2) > 3.0
    found = lifted(fit)
    assert np.all(found.own[:, windows.begins] > 0.02)  # a part of 0.08: the prior gives the slip the rest
    again = replace(found, blocks=windows.blocks(found.at, found.own))
    for block in again.blocks:
        assert block is not None
        assert np.mean(block[:, :, -1] ** 2) < 0.1
    assert lifted(again) is again


def test_springs_beside_alpha1_act_where_a_formula_takes_the_general_core(windows: BeltWindows) -> None:
    """A formula that is a spring, and as much more of a spring without it: the same motion."""
    spring = ss.effect("formula", where="block", force="-c*x1", c=0.05)
    by_formula, alone = (made(windows.data, one, beside=True) for one in ((spring,), ()))
    at, place = start(alone), [n.name for n in alone.numbers].index(BESIDE)
    at[place] += 0.05
    here, there = by_formula.motions(start(by_formula), windows.first()), alone.motions(at, windows.first())
    still = alone.motions(start(alone), windows.first())
    for one, same, other in zip(here, there, still, strict=True):
        assert one is not None
        assert same is not None
        assert other is not None
        np.testing.assert_allclose(one.readings, same.readings, atol=1e-4)
        assert np.abs(one.readings - other.readings).max() > 1e-3
