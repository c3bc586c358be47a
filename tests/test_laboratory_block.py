"""Discovery on a block on a belt whose friction differs from event to event, its constants nearly right."""

import json
import math
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import stickslip as ss
from quick_figures import quickly
from scattering import MASS, STIFFNESS, block_case
from short_search import naming
from stickslip.discovery.laboratory import block, verdicts
from stickslip.discovery.laboratory.learned import ScoredCurve
from stickslip.discovery.laboratory.proven import proven
from stickslip.discovery.laboratory.search import Searched
from stickslip.discovery.laboratory.trials import Trial
from stickslip.shown.report.write import write_report

SCATTER = 0.02
NEARLY = {"mass": 0.008, "stiffness": -0.006, "gain": 0.003}


def test_nothing_is_named_where_only_friction_scatters(tmp_path: Path) -> None:
    found = ss.discover(ss.load_case(block_case(tmp_path, few=True, seed=1, scatter=SCATTER, off=NEARLY)))
    assert found.verdict is ss.discovery.result.Verdict.no_effect
    assert found.scatter["kinetic"].value == pytest.approx(SCATTER, rel=0.35)
    assert found.after.scatter.level == pytest.approx(SCATTER, rel=0.5)
    for name, true in (("mass", MASS), ("stiffness", STIFFNESS), ("spring_force", 1.003)):
        one = found.constants[name]
        assert one.low is not None
        assert one.high is not None
        assert one.low < true < one.high
    assert found.error.after == found.error.before
    assert found.error.after < 1.3 * found.error.floor


def test_what_acts_in_the_train_runs_alone_is_not_claimed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The damper was off when the run that nothing is fitted to was recorded."""
    damped, plain = (tmp_path / "damped", tmp_path / "plain")
    for folder, effects in ((damped, (ss.effect("block_viscous_damping", c=3.0),)), (plain, ())):
        folder.mkdir()
        block_case(folder, effects, few=True, seed=2, scatter=0.01)
    (plain / "run_3.csv").rename(damped / "run_3.csv")
    naming(monkeypatch, 1)
    found = ss.discover(ss.load_case(damped / "rig.toml"))
    assert found.verdict is ss.discovery.result.Verdict.no_effect
    assert found.effects == ()
    assert "block_viscous_damping" not in {one.name for one in found.after.effects}
    assert found.error.after == found.error.before
    assert [one.name for one in found.unclaimed] == ["block_viscous_damping"]
    said = r"but runs never used are less likely with it, by [0-9.]+ in -2 log likelihood"
    by_ranks = r"over [0-9]+ events \(p = [0-9.]+\): nothing is claimed$"
    assert re.match(
        f"block_viscous_damping would be named by the train runs, {said} {by_ranks}", found.messages[0]
    )


def test_windows_that_nothing_explains_are_a_verdict(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Where windows are of no model nothing is named; what was read is not lost."""
    monkeypatch.setattr(block, "is_a_model", lambda _: False)
    naming(monkeypatch, 1)
    path = block_case(tmp_path, few=True, seed=2, scatter=0.01)
    found = ss.discover(ss.load_case(path))
    assert found.verdict is ss.discovery.result.Verdict.no_effect
    assert found.effects == ()
    assert found.error.after == found.error.before
    assert found.messages[0].startswith("nothing is named: no effect, curve or scatter makes every stretch")
    assert found.messages[0].endswith("which is more than scatter")


@pytest.mark.slow
def test_a_damping_is_named_and_the_error_falls_to_the_noise(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    c = 2.0
    case = ss.load_case(
        block_case(
            tmp_path,
            (ss.effect("block_viscous_damping", c=c),),
            few=True,
            seed=2,
            scatter=SCATTER,
            length=0.008,
            off=NEARLY,
        )
    )
    found = ss.discover(case)
    assert [one.name for one in found.effects] == ["block_viscous_damping"]
    number = found.effects[0].parameters["c"]
    assert number.low is not None
    assert number.high is not None
    assert number.low < c < number.high
    assert found.error.after < 1.3 * found.error.floor
    quickly(monkeypatch)
    write_report(found, case, tmp_path / "out")
    report = json.loads((tmp_path / "out" / "report.json").read_text(encoding="utf-8"))
    assert report["effects"][0]["name"] == "block_viscous_damping"
    assert set(report["scatter"]) == {"static", "kinetic", "belt", "constants"}
    assert set(report["declared"]) == {"m", "k", "c", "spring_force"}
    model = ss.load_model(tmp_path / "out" / "model_after.toml")
    assert model == found.model
    run = case.validate[0]
    past = run.window(float(run.t[0]), float(run.t[0]) + 1.5)
    ahead = ss.forecast(model, past, belt_speed=run.belt_speed, horizon=0.2)
    assert "spring_force" in ahead
    assert float(ahead["spring_force"].abs().max()) < 12.0


@pytest.mark.study
def test_a_wrong_mass_is_named_and_nothing_beside_it(tmp_path: Path) -> None:
    found = ss.discover(
        ss.load_case(block_case(tmp_path, few=True, seed=3, scatter=SCATTER, off={"mass": 0.12}))
    )
    assert [one.name for one in found.effects] == ["rig_mass"]
    e = found.effects[0].parameters["e"]
    assert e.low is not None
    assert e.high is not None
    assert e.low < 1 / 1.12 - 1 < e.high
    assert found.error.after < found.error.before


@pytest.mark.study
def test_a_hum_of_its_sensor_is_told_with_its_period(tmp_path: Path) -> None:
    w, size = 314.0, 3 * 0.008
    path = block_case(
        tmp_path,
        few=True,
        seed=6,
        scatter=SCATTER,
        off=NEARLY,
        read=lambda t, x: x + size / STIFFNESS * np.sin(w * t),
    )
    (one,) = ss.discover(ss.load_case(path)).effects
    assert (one.name, one.depends_on) == ("unlisted", ("t",))
    assert one.curve is not None
    assert one.curve.period == pytest.approx(2 * math.pi / w, rel=2e-3)


@pytest.mark.study
def test_a_curve_of_the_reading_in_the_speed_is_told_and_forecasts_do_without(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """It cannot be undone where x1 alone is recorded: with it in the model after no run could be forecast."""

    def best(bench: block.BeltBench, found: Searched, *_: object) -> tuple[ScoredCurve, Trial]:
        every = bench.curves(found.null.fit)
        (curve,) = [one for one in every if (one.where, one.variable) == ("x1 channel", "x2")]
        return proven(bench, found.null, replace(curve, threshold=0.0))

    monkeypatch.setattr(verdicts, "curve_alone", best)
    found = ss.discover(ss.load_case(block_case(tmp_path, few=True, seed=6, scatter=0.01)))
    (one,) = found.effects
    assert (one.name, one.where, one.depends_on) == ("unlisted", "x1 channel", ("x2",))
    assert not any(isinstance(each, ss.Tabulated) for each in found.model.effects)
    assert block.NOT_AFTER in found.messages
    assert found.error.after == pytest.approx(found.error.before)


@pytest.mark.study
def test_a_wave_of_the_belt_comes_with_its_length(tmp_path: Path) -> None:
    seam = ss.effect("belt_seam", a=0.08, L=0.05, phi=0.0)
    found = ss.discover(
        ss.load_case(block_case(tmp_path, (seam,), few=True, seed=4, scatter=0.01, off=NEARLY))
    )
    assert [one.name for one in found.effects] == ["belt_seam"]
    numbers = found.effects[0].parameters
    assert numbers["a"].value == pytest.approx(0.08, rel=0.1)
    assert numbers["L"].value == pytest.approx(0.05, rel=0.02)
    assert found.effects[0].phases.keys() == {"run_1", "run_2"}
    assert found.error.after < found.error.before
    assert all(math.isfinite(one) for one in (found.error.before, found.error.after, found.error.floor))


@pytest.mark.study
def test_a_curved_sensor_is_named(tmp_path: Path) -> None:
    q = -8.5
    path = block_case(tmp_path, few=True, seed=0, scatter=0.025, off=NEARLY, read=lambda _, x: x + q * x**2)
    found = ss.discover(ss.load_case(path))
    assert [one.name for one in found.effects] == ["sensor_nonlinearity"]
    assert found.effects[0].parameters["q"].value == pytest.approx(q, rel=0.1)
    # a belt of an event's own takes a part of the curvature, before and after
    assert found.error.after < 1.1 * found.error.floor < found.error.before
    assert found.error.after < 0.9 * found.error.before


@pytest.mark.study
def test_belts_that_are_all_slower_than_declared_are_what_a_gain_is(tmp_path: Path) -> None:
    """All belts 6 % slower: a gain was named, as if nothing else could be. No reading tells them apart."""
    path = block_case(tmp_path, few=True, seed=3, scatter=SCATTER)
    text = path.read_text()
    for line in set(re.findall(r"belt_speed = .*", text)):
        text = text.replace(line, f"belt_speed = {1.06 * float(line.split('=')[1])}")
    path.write_text(text)
    found = ss.discover(ss.load_case(path))
    assert [one.name for one in found.effects] == ["sensor_gain"]
    own = found.effects[0].parameters["e"]
    assert own.low is not None
    assert own.high is not None
    assert own.low < 1 / 1.06 - 1 < own.high
    assert [one.name for one in found.effects[0].alternatives if one.exact] == ["belt speed"]
    assert any(one.between == ("sensor_gain", "belt speed") for one in found.experiments)
