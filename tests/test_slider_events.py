"""Events of a block on a belt: the closed form against the core, and the fit of events one by one."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from slider import coulomb_record
from stickslip.declared.friction.coulomb import CoulombFriction
from stickslip.declared.friction.hyperbolic import HyperbolicFriction
from stickslip.declared.model import Model
from stickslip.declared.rig import BlockOnBelt
from stickslip.fitted.block_events.cycle import (
    LOG_W2,
    RELEASE,
    ZETA,
    K,
    S,
    arrest,
    duration,
    lost,
    positions,
    slopes,
)
from stickslip.fitted.block_events.predict import BlockForecaster, scaled
from stickslip.fitted.block_events.table import measure, prepare
from stickslip.measured.case import Recording, load_recording
from stickslip.simulated.simulate import simulate

NOISE = 2e-4


@pytest.mark.parametrize("damping", [0.0, 0.1, 0.2])
def test_the_closed_form_is_what_the_core_simulates(damping: float) -> None:
    rig = BlockOnBelt(mass=2.0, stiffness=3.0, damping=damping)
    law = CoulombFriction(static=1.5, kinetic=0.9)
    v, w = 0.2, np.sqrt(1.5)
    t = np.linspace(0, 12, 400)
    run = simulate(Model(rig, friction=law), belt_speed=v, initial=(0.3, v), t_end=12.0, t_eval=t)
    # viscous damping also holds against the carried block: it lowers the level of breakaway and of sliding
    top, level = (1.5 - damping * v) / 3, 0.9 / 3
    zeta = damping / (2 * np.sqrt(6.0))
    p = np.array([[top, level, (top - 0.3) / v, v, 2 * np.log(w), zeta]])
    end = float(p[0, RELEASE] + duration(p)[0])
    inside = t < end + 0.1
    np.testing.assert_allclose(positions(p, t[None, inside])[0], run.state[inside, 0], atol=2e-8)
    assert run.transitions.t[1] == pytest.approx(end, abs=1e-7)
    assert top + v * duration(p)[0] - lost(p)[0] == pytest.approx(arrest(p)[0])


def test_slopes_agree_with_differences() -> None:
    rng = np.random.default_rng(3)
    p = np.array([0.9, 0.3, 2.0, 0.2, 0.4, 0.0]) + rng.uniform(-0.1, 0.1, (20, 6))
    p[:, ZETA] += rng.uniform(-0.3, 0.15, 20)
    t = np.linspace(0, 12, 500) * np.ones((20, 1))
    found = slopes(p, t)
    for j in range(6):
        up, down = p.copy(), p.copy()
        up[:, j] += 1e-5
        down[:, j] -= 1e-5
        expected = (positions(up, t) - positions(down, t)) / 2e-5
        # at the breakaway and the capture themselves x is bent
        bent = (np.abs(t - p[:, RELEASE, None]) < 0.03) | (
            np.abs(t - (p[:, RELEASE] + duration(p))[:, None]) < 0.03
        )
        np.testing.assert_allclose(found[:, j][~bent], expected[~bent], atol=2e-8)


def recording(tmp_path: Path, seed: int, slips: int = 30) -> tuple[Recording, np.ndarray, np.ndarray]:
    rng = np.random.default_rng(seed)
    static = 1 + 0.05 * rng.standard_normal(slips)
    kinetic = static - 0.25 - 0.03 * rng.standard_normal(slips)
    t, x, _, _ = coulomb_record(static, kinetic, 0.1, 0.02)
    x = x + NOISE * rng.standard_normal(len(t))
    x[::97] += 30 * NOISE  # glitches of a single sample
    path = tmp_path / f"run_{seed}.csv"
    np.savetxt(path, np.column_stack([t, x]), delimiter=",", header="t,x1", comments="", fmt="%.9f")
    return load_recording(path, BlockOnBelt(), belt_speed=0.1, name=f"run_{seed}"), static, kinetic


def test_events_are_fitted_within_their_intervals(tmp_path: Path) -> None:
    run, static, kinetic = recording(tmp_path, 1)
    e = measure(prepare(run)).events
    assert len(e) >= 26
    order = np.array([int(np.argmin(np.abs(static - top))) for top in e.p[:, S]])
    for column, truth in ((S, static[order]), (K, kinetic[order]), (LOG_W2, 0.0), (ZETA, 0.0)):
        z = (e.p[:, column] - truth) / e.std[:, column]
        assert np.sqrt(np.mean(z**2)) < 1.6
        assert abs(np.mean(z)) < 4 / np.sqrt(len(z))
    assert np.median(e.rms) == pytest.approx(1.0, abs=0.15)


def test_sticks_rise_with_the_belt_and_glitches_do_not_count(tmp_path: Path) -> None:
    run, _, _ = recording(tmp_path, 2)
    one = measure(prepare(run))
    z = (one.sticks.rate - 1) / one.sticks.std
    assert np.sqrt(np.mean(z**2)) < 1.6
    assert one.run.glitches > 0.008


def test_a_reversed_record_gives_the_same_events(tmp_path: Path) -> None:
    run, _, _ = recording(tmp_path, 3)
    ahead = measure(prepare(run)).events
    back = measure(prepare(replace(run, x1=-run.x1, belt_speed=-run.belt_speed))).events
    np.testing.assert_allclose(back.p, ahead.p)


def test_forecasts_start_at_the_level_of_the_last_events(tmp_path: Path) -> None:
    run, _, _ = recording(tmp_path, 6)
    one = measure(prepare(run))
    law = CoulombFriction(static=2.0, kinetic=1.5)  # twice too large: the level is taken from the past
    stop = next(s for s in one.run.track.sticks if s.start > 3000)
    at = (stop.start + stop.stop) // 2
    future = one.run.t[at : at + 60]
    out = BlockForecaster(Model(BlockOnBelt(), friction=law), one).forecast(at, future)
    truth = np.nan_to_num(one.run.x[at : at + 60], nan=np.inf)
    early = slice(0, min(stop.stop - at, 60) - 5)
    good = np.isfinite(truth[early])
    np.testing.assert_allclose(out.reading[early][good], truth[early][good], atol=8 * NOISE)


def test_a_law_is_sized() -> None:
    curved = Model(BlockOnBelt(), friction=HyperbolicFriction(scale=2.0, decay=5.0, constant=1.0))
    assert scaled(curved, 3.0).friction == HyperbolicFriction(scale=6.0, decay=5.0, constant=3.0)
