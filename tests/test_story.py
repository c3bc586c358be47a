"""The demonstration's second half: the case is made the same way every time, and its cause is found."""

from __future__ import annotations

from collections.abc import Callable
from io import StringIO
from pathlib import Path

import numpy as np
import pytest
from rich.console import Console

import found_by_hand
import stickslip as ss
from quick_figures import quickly
from stickslip.cli import rotated_portrait as story
from stickslip.discovery.result import Found
from stickslip.files import RECORD


def test_the_case_is_the_same_every_time(tmp_path: Path) -> None:
    a, b = story.write_case(tmp_path / "a"), story.write_case(tmp_path / "b")
    names = sorted(p.name for p in a.parent.iterdir() if p.name != RECORD)
    assert names == ["rig.toml", *(f"run_{i:02d}.csv" for i in range(1, len(story.RUNS) + 1))]
    for name in names:
        assert (a.parent / name).read_bytes() == (b.parent / name).read_bytes()


def test_the_case_is_a_sound_one_and_does_not_tell_the_cause(tmp_path: Path) -> None:
    path = story.write_case(tmp_path)
    case = ss.load_case(path)
    assert len(case.train) == sum(run.role == "train" for run in story.RUNS)
    assert len(case.validate) == sum(run.role == "validate" for run in story.RUNS)
    assert case.findings == ()
    assert case.friction == ss.PaperFriction()  # Table 1, not the law the readings were made with
    text = path.read_text(encoding="utf-8")
    for cause in story.CAUSE:
        assert cause.name not in text


def test_the_readings_are_rotated_against_the_motion(tmp_path: Path) -> None:
    """A lag tau turns the portrait of a motion by about tau: v is read as v - tau a, x as x - tau v."""
    case = ss.load_case(story.write_case(tmp_path))
    run = case.run("run_01")
    tau = story.CAUSE[0].parameters["tau"]
    own = story.RUNS[0]
    model = ss.Model(case.rig, friction=story.LAW, effects=story.CAUSE).replace(
        {"belt_speed_ripple.phi": own.phase}
    )
    truth = ss.simulate(
        model, belt_speed=own.speed, initial=(0.1, 0.1, 0, 0), t_end=float(run.t[-1]), t_eval=run.t
    )
    late = run.x1 - truth.state[:, 0]
    slope = np.polyfit(truth.state[:, 1], late, 1)[0]
    assert slope == pytest.approx(-tau, rel=0.1)


def test_told_with_its_files(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def search(_case: ss.Case, *, progress: Callable[[str], None]) -> Found:
        progress("trying")
        hand = ss.load_case(found_by_hand.write_case(tmp_path, si=True))
        return found_by_hand.found(hand)

    monkeypatch.setattr(ss, "discover", search)
    quickly(monkeypatch)
    out = StringIO()
    told = story.story(tmp_path / "demo", Console(file=out, width=100))
    assert all(path.is_file() for path in told.paths)
    text = out.getvalue()
    assert "belt_speed_ripple.a" in text
    assert "not found" in text  # by the hand-made result, which has the lag alone
    assert "sensor_lag.tau" in text


@pytest.mark.study
def test_the_cause_is_found(tmp_path: Path) -> None:
    told = story.story(tmp_path, Console(file=StringIO(), width=100))
    named = {one.name: one for one in told.found.effects}
    ripple = next(cause for cause in story.CAUSE if cause.name == "belt_speed_ripple")
    for name in ("a", "w"):
        assert named["belt_speed_ripple"].parameters[name].value == pytest.approx(
            ripple.parameters[name], rel=0.05
        )
    lag = next(cause for cause in story.CAUSE if cause.name == "sensor_lag").parameters["tau"]
    assert set(named) == {"belt_speed_ripple", "sensor_lag"}
    assert named["sensor_lag"].parameters["tau"].value == pytest.approx(lag, rel=0.03)
    assert told.found.residual_after.chi2 < 1.05
    assert told.found.error.after < 0.35 * told.found.error.before
