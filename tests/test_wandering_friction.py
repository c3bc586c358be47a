"""Discovery where friction wanders along the belt by more than it falls in a slip, as paper's does."""

import json
from dataclasses import replace
from importlib.resources import as_file, files
from pathlib import Path

import numpy as np
import pytest

import stickslip as ss
from quick_figures import quickly
from stickslip.discovery.laboratory.block_bench import bench_of
from stickslip.discovery.result import Found, Verdict
from stickslip.likelihoods.fit import null
from stickslip.likelihoods.shown_levels import shown_levels
from stickslip.measured.case import Case
from wandering import FALL, RIG, SPEED, WANDER, case_of, recording


def found_in(case: Case) -> Found:
    return ss.discover(case, threads=1)


@pytest.mark.slow
def test_friction_that_wanders_is_given_no_name() -> None:
    found = found_in(case_of(recording(1), recording(2)))
    assert found.verdict is Verdict.no_effect
    assert found.residual_after.clean
    assert not any("in sticks" in one for one in found.messages)
    assert found.error.after == pytest.approx(found.error.floor, rel=0.1)
    # single events know nothing of how far friction wanders in the whole record
    assert 0.4 * WANDER < found.scatter["kinetic"].value < 1.6 * WANDER


def test_windows_show_the_friction_that_they_are_simulated_with() -> None:
    """Static friction is beside a level that it has, too; a breakaway on the move is read a little high."""
    bench, _, _, _ = bench_of(case_of(recording(1), recording(2)))
    windows = bench.windows()
    own = shown_levels(windows, windows.start)
    assert own is not None
    level, static = -0.4, 0.3
    q = windows.begins
    own[:, :q] *= (1 + level) * (1 + static)  # the spring pulls as much less where a window begins
    own[:, q:][:, windows.kinetic] = level
    own[:, q] = static
    for s, motion in zip(windows.stretches, windows.motions(windows.start, own), strict=True):
        assert motion is not None
        windows.data[s.run].readings[s.start : s.stop, 0] = motion.readings[:, 0]
    slips = [np.any(one.mode != 0) for one in windows.motions(windows.start, own) if one is not None]
    again = shown_levels(windows, windows.start)
    assert again is not None
    assert sum(slips) > 5
    np.testing.assert_allclose(again[slips, q], static, atol=0.04)


@pytest.mark.slow
@pytest.mark.sampled(2)
@pytest.mark.parametrize(
    ("name", "gain", "mass", "by"),
    [("sensor_gain", 1.1, 1.0, WANDER), ("rig_mass", 1.0, 0.6, WANDER), ("sensor_gain", 1.1, 1.0, 0.2)],
    ids=["gain", "mass", "wild"],
)
def test_a_wrong_constant_is_found_beside_it(name: str, gain: float, mass: float, by: float) -> None:
    """However much friction differs: the events show that by themselves."""
    true = replace(RIG, mass=mass * RIG.mass)
    found = found_in(case_of(*(recording(seed, gain=gain, true=true, by=by) for seed in (1, 2))))
    assert [one.name for one in found.effects] == [name]
    e = found.effects[0].parameters["e"]
    assert e.low is not None
    assert e.high is not None
    assert e.low < gain * mass - 1 < e.high
    assert e.high - e.low < 0.1
    assert found.error.after < 1.2 * found.error.floor < 0.6 * found.error.before


def test_levels_are_found_where_no_run_has_the_mean_ones() -> None:
    case = case_of(recording(1), recording(2))
    bench, units, _, _ = bench_of(case)
    fit = null(bench.windows(), bench.policy)
    fall = (fit.values()["static"] - fit.values()["kinetic"]) * units.scales.k2 * units.scales.length
    assert fall == pytest.approx(FALL, rel=0.15)
    assert fit.values()["mass"] == pytest.approx(16.0, rel=0.02)


@pytest.mark.slow
@pytest.mark.parametrize("part", ["validate", "train"])
def test_a_run_with_a_spring_of_its_own(part: str) -> None:
    """Every constant that a run declares for itself is its own, in fits, errors and forecasts."""
    stiffer = ss.BlockOnBelt(mass=RIG.mass, stiffness=3 * RIG.stiffness)
    other = recording(2, true=stiffer, declared=stiffer)
    runs = [recording(1), other] if part == "validate" else [recording(1), other, recording(3)]
    case = case_of(*[replace(one, rig=RIG) for one in runs])
    case = replace(
        case,
        runs=tuple(
            replace(one, rig=stiffer) if one.name.startswith(other.name) else one for one in case.runs
        ),
    )
    found = found_in(case)
    assert found.verdict is Verdict.no_effect
    assert found.residual_after.chi2 == pytest.approx(1.0, abs=0.1)
    assert found.error.after == pytest.approx(found.error.floor, rel=0.15)


def test_a_stick_beyond_the_force_of_its_own_breakaway_belongs_to_the_next() -> None:
    """A window that held it slipped again where the record sticks, and the belt's speed had to take it."""
    bench, *_ = bench_of(case_of(recording(1), recording(2)))
    for one in bench.stretches:
        run = bench.data[one.run]
        rise = np.sign(run.belt_speed) * run.readings[one.start : one.stop, 0]
        slip = int(np.argmax(np.maximum.accumulate(rise) - rise))
        assert rise[-1] < rise[:slip].max() + 10 * run.noise[0]
    assert len(bench.stretches) > 15


def test_few_stretches_are_said_and_nothing_is_tried() -> None:
    found = found_in(case_of(*(recording(seed, 10, gain=1.1) for seed in (1, 2))))
    assert found.verdict is Verdict.no_effect
    assert any("12 are needed to see how friction scatters" in one for one in found.messages)
    assert found.ranking[0].names == ()
    # sticks show that something is off, whatever friction does
    (said,) = [one for one in found.messages if one.startswith("in sticks x1 rises 1.1 +- ")]
    assert "the gain of x1 or the speed of the pull is off" in said
    assert found.error.after == found.error.before


def test_no_slip_at_all_is_refused() -> None:
    t = np.arange(0, 20, 0.01)
    x = 1e-3 * np.sin(0.3 * t)
    columns = {"t": t, "x1": x + 1e-6 * np.random.default_rng(0).standard_normal(t.size)}
    with pytest.raises(ss.InputError, match="no slip between two sticks is found in the train runs"):
        ss.discover(columns, rig=RIG, belt_speed=SPEED)


@pytest.mark.study
def test_the_shipped_recording(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Slips of paper change within themselves in a way that no windows follow yet: nothing is claimed of them."""
    with as_file(files("stickslip") / "data" / "paper_slider") as folder:
        case = ss.load_case(folder / "rig.toml")
    found = found_in(case)
    assert found.verdict is Verdict.no_effect
    assert found.messages[0].startswith("nothing is named: no effect, curve or scatter makes every stretch")
    assert 0.05 < found.scatter["kinetic"].value < 0.3
    assert found.error.after < 2.5 * found.error.floor
    quickly(monkeypatch)
    found.write_report(tmp_path / "out")
    report = json.loads((tmp_path / "out" / "report.json").read_text(encoding="utf-8"))
    assert report["verdict"] == "no_effect"
    model = ss.load_model(tmp_path / "out" / "model_after.toml")
    assert model == found.model
    run = case.validate[0]
    past = run.window(float(run.t[0]), float(run.t[0]) + 3.0)
    ahead = ss.forecast(model, past, belt_speed=run.belt_speed, horizon=0.1)
    assert list(ahead.columns) == ["t", "spring_force", "spring_force_low", "spring_force_high"]
    assert np.all(np.abs(ahead["spring_force"] - np.nanmean(past.to_readings("x1", past.x1))) < 0.2)
    stiffer = model.replace(stiffness=1002.0)
    other = replace(past, rig=replace(past.rig, stiffness=1002.0), x1=past.x1 * 168.0 / 1002.0)
    # the same force on a stiffer spring would be the record of a slower belt
    with pytest.warns(ss.errors.ModelWarning, match="but the sticks ride at"):
        assert len(ss.forecast(stiffer, other, belt_speed=run.belt_speed, horizon=0.1)) == len(ahead)
