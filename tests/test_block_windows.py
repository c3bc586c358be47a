"""Windows of a block on a belt from mid-stick to mid-stick, with numbers of their own."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

import stickslip as ss
from differences import held_against_differences
from stickslip.declared.rig import Scales
from stickslip.fitted.block_events.sensor import reading_of
from stickslip.fitted.data import Data
from stickslip.likelihoods.belt_windows import BeltWindows
from stickslip.likelihoods.block_windows import BlockSensors, drowned
from stickslip.likelihoods.scaled import Scaled
from stickslip.likelihoods.shared import Declared, SharedNumber
from stickslip.likelihoods.shown_levels import shown_levels
from stickslip.likelihoods.stretches import stretches
from stickslip.measured.sticks import rides

Floats = NDArray[np.float64]
BLOCK = ss.BlockOnBelt(mass=16.0, stiffness=16.0, damping=0.3)
LAW = ss.CoulombFriction(static=5.0, kinetic=3.0)
CONSTANTS = ("static", "kinetic", "mass", "stiffness", "damping")
EFFECTS = {
    "nothing": (),
    "cubic": (ss.effect("spring_cubic_k1", k=6.0), ss.effect("block_quadratic_damping", c=1.0)),
    "droop": (ss.effect("belt_load_droop", k=0.002, tau=0.7),),
    "lag": (ss.effect("sensor_lag", tau=0.1), ss.effect("sensor_nonlinearity", q=0.1)),
    "ripple": (ss.effect("belt_speed_ripple", a=0.1, w=2.0, phi=0.4), ss.effect("sensor_drift", r=1e-3)),
    "aging": (ss.effect("static_aging", dT=0.4, tau=1.5), ss.effect("belt_seam", a=0.1, L=4.0, phi=0.2)),
}
BELT, NOISE, GAIN = 0.1, 1e-3, 0.002


@pytest.fixture(scope="module")
def run() -> Data:
    """A run that the model made, without noise."""
    t = np.arange(0.0, 60.0, 0.02)
    made = ss.simulate(
        ss.Model(BLOCK, friction=LAW), belt_speed=BELT, initial=(0.1, 0.1), t_end=t[-1], t_eval=t
    )
    v, slips = made.state[:, 1], []
    edges = np.flatnonzero(np.diff(np.concatenate([[0], (made.mode != 0).astype(int), [0]])))
    for a, b in zip(edges[::2], edges[1::2], strict=True):
        slips.append(a + int(np.argmax(np.abs(v[a:b] - BELT))))
    readings = made.state[:, :1]
    weight, held = np.full_like(readings, 1 / NOISE), np.zeros_like(readings, dtype=bool)
    cycle = float(np.median(np.diff(t[slips])))
    return Data("run", "train", BELT, t, readings, weight, np.full(1, NOISE), v, np.array(slips), cycle, held)


def made(run: Data, effects: tuple[ss.Effect, ...], *, force: bool = True) -> BeltWindows:
    """Windows of a run under a model with effects, all their numbers shared."""
    model = ss.Model(BLOCK, friction=LAW, effects=effects)
    numbers = []
    for name in CONSTANTS:
        at = float(np.log(model.parameters[name]))
        numbers.append(SharedNumber(name, at, at, 1.0, True))
    channel = "gain.spring_force" if force else "gain.x1"
    numbers.append(SharedNumber(channel, GAIN, 0.0, 0.01))
    for one in effects:
        numbers += [
            SharedNumber(f"{one.name}.{k}", v, v, np.inf, run=0 if k == "phi" else None)
            for k, v in one.parameters.items()
        ]
    sensors = BlockSensors((channel,), BLOCK.stiffness if force else None)
    return BeltWindows(model, [run], stretches([run]), numbers, Declared(), sensors)


def start(windows: BeltWindows) -> Floats:
    """Coordinates of the declared numbers."""
    return np.array([n.start for n in windows.numbers])


def test_a_stretch_runs_from_stick_to_stick_over_one_slip(run: Data) -> None:
    found = stretches([run])
    assert found
    for one in found:
        rode = rides(run.v[one.start : one.stop + 1], run.belt_speed)
        assert rode[0]
        assert rode[-1]
        assert np.count_nonzero(np.diff(rode.astype(int)) == -1) == 1


def test_the_true_model_leaves_nothing(run: Data) -> None:
    windows = made(run, ())
    assert len(windows.stretches) >= 3
    own, at = windows.first(), start(windows)
    at[len(CONSTANTS)] = 0.0  # no gain
    own[:, 0] = [run.readings[w.start, 0] for w in windows.stretches]
    for block in windows.blocks(at, own):
        assert block is not None
        assert block.shape[1:] == (1, len(CONSTANTS) + 1 + windows.own + 1)
        assert np.median(np.abs(block[:, :, -1])) < 3.0


@pytest.mark.parametrize("name", EFFECTS)
def test_derivatives_are_those_of_differences(run: Data, name: str) -> None:
    windows = made(run, EFFECTS[name])
    held_against_differences(windows, start(windows), name)


def test_a_force_is_that_of_the_true_spring(run: Data) -> None:
    """A stiffer spring shows in its force, and not in a displacement, while the block sticks."""
    for force, rise in ((True, 1.1), (False, 1.0)):
        windows = made(run, (), force=force)
        at = start(windows)
        at[len(CONSTANTS)] = 0.0
        at[CONSTANTS.index("stiffness")] += np.log(1.1)
        motion = windows.motions(at, windows.first())[0]
        assert motion is not None
        stuck = motion.readings[:5, 0]
        assert np.diff(stuck) / np.diff(motion.t[:5]) == pytest.approx(rise * BELT, rel=1e-6)


def test_an_event_shows_its_levels(run: Data) -> None:
    """A slip without damping swings by root (A^2 + v^2) about the kinetic level, A from there to the static one."""
    static, kinetic = LAW.static / 16.0, LAW.kinetic / 16.0
    swing = np.hypot(static - kinetic, BELT)
    t = run.t
    readings = (kinetic + swing * np.cos(t))[:, None]  # omega is 1
    shown = BlockSensors(("gain.x1",), None).levels(readings, True, 16.0)
    assert shown == pytest.approx((16.0 * (kinetic + swing), LAW.kinetic), rel=1e-3)
    assert BlockSensors(("gain.x1",), None).levels(-readings, False, 16.0) == pytest.approx(shown)
    own = shown_levels(made(run, ()), start(made(run, ())))
    assert own is not None
    windows = made(run, ())
    level = own[:, windows.begins :][:, windows.kinetic]
    assert np.ptp(level, axis=1).max() == 0.0
    # the damper takes a little of the fall
    assert np.abs(level).max() < 0.08


def test_a_run_that_slides_for_long_is_no_noise(run: Data) -> None:
    """A block that swings past the belt's speed for half a run sticks seldom; peaks of noise are no such slips."""
    assert not drowned(run)
    n, noise = len(run.t), float(run.noise[0])
    often = np.arange(10, n - 10, 20)
    swings = 40 * noise * np.sin(2 * np.pi * np.arange(n) / 20)[:, None]
    slow = noise * np.random.default_rng(1).standard_normal((n, 1)) + run.t[:, None] * noise
    assert not drowned(replace(run, readings=swings, slips=often))
    assert drowned(replace(run, readings=slow, slips=often))
    assert not drowned(replace(run, readings=slow, slips=often[:1]))


def test_the_scale_of_forces_is_told_by_no_position(run: Data) -> None:
    """Friction of a window's own is relative to the law as it is: mass, springs and friction twice as large move alike.

    Relative to the declared law it was not, and all forces were lowered to half of what they are.
    """
    windows = made(run, (), force=False)
    own = windows.first()
    own[:, windows.begins :] = 0.02 * np.random.default_rng(1).normal(size=own[:, windows.begins :].shape)
    here = start(windows)
    twice = here + np.log(2.0) * np.isin([one.name for one in windows.numbers], CONSTANTS)
    for a, b in zip(windows.blocks(here, own), windows.blocks(twice, own), strict=True):
        assert a is not None
        assert b is not None
        assert np.abs(a[:, :, -1] - b[:, :, -1]).max() < 1e-3  # of the noise


def test_a_curve_of_the_reading_is_the_model_s_whatever_the_gain_is_found_to_be() -> None:
    """Windows scale with the gain what is added to a reading; a model adds it to what is scaled."""
    rig, x = ss.BlockOnBelt(mass=0.9, stiffness=460.0), np.linspace(-0.3, 0.3, 13)
    units = Scaled(rig, Scales(length=0.01, omega=float(np.sqrt(460.0 / 0.9)), k2=460.0 / 16, r=0.01))
    curve = ss.tabulated("x1 channel", "x1", [-0.3, 0.0, 0.3], [0.02, 0.0, 0.03])
    values = {"mass": 16.0, "stiffness": 16.0 * 1.03, "damping": 0.0, "gain.spring_force": 0.04}
    made = units.model(ss.Model(BLOCK, friction=LAW, effects=[curve]), values, "gain.spring_force")
    read = reading_of(made, force_channel=True).read(0.01 * x, None, 0.0 * x)
    np.testing.assert_allclose(read / 0.01, (1.03 * x + curve.curve(x)) * 1.04, rtol=1e-12)


def test_of_a_slow_belt_the_time_of_a_slip_says_where_the_block_broke_away() -> None:
    """The largest of many readings lies three standard deviations of their noise beyond it."""
    belt, noise = 0.002, 0.004
    t = np.arange(0.0, 700.0, 0.05)
    made_of = ss.Model(ss.BlockOnBelt(mass=16.0, stiffness=16.0), friction=LAW)
    motion = ss.simulate(made_of, belt_speed=belt, initial=(0.1, belt), t_end=t[-1], t_eval=t)
    clean = motion.state[:, :1]
    readings = clean + noise * np.random.default_rng(3).standard_normal(clean.shape)
    edges = np.flatnonzero(np.diff(np.concatenate([[0], (motion.mode != 0).astype(int), [0]])))
    slips = np.array([(a + b) // 2 for a, b in zip(edges[::2], edges[1::2], strict=True)])
    weight, held = np.full_like(readings, 1 / noise), np.zeros_like(readings, dtype=bool)
    cycle, scatter = float(np.median(np.diff(t[slips]))), np.full(1, noise)
    v = motion.state[:, 1]
    slow = Data("run", "train", belt, t, readings, weight, scatter, v, slips, cycle, held)
    windows = made(slow, (), force=False)
    own = shown_levels(windows, start(windows))
    assert own is not None
    assert len(own) > 2
    static = 1 + own[:, windows.begins]
    level = own[:, windows.begins + 1]
    shown = LAW.static * static * (1 + level)
    assert np.abs(shown / LAW.static - 1).max() < 0.01
    largest = [float(readings[w.start : w.stop].max()) * 16.0 for w in windows.stretches]
    assert np.min(largest) > 1.02 * LAW.static
