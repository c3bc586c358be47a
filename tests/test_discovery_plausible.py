"""Cases whose channels are not what they say: one right line at once, and no alarm where there is nothing wrong."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

import found_by_hand
import stickslip as ss
from discover_cases import FEW, NOISE, make_case
from stickslip.declared.effect import effect
from stickslip.discovery.cleaning import noise_size
from stickslip.discovery.discover import Verdict, discover
from stickslip.errors import InputError
from stickslip.fitted.data import Data, prepare
from stickslip.fitted.plausible import body_ratio, plausible, stick_speed
from stickslip.measured.case import Case

EFFECTS = (
    (),
    (effect("belt_load_droop", k=0.002, tau=0.6),),
    (effect("belt_speed_ripple", a=0.12, w=6.3, phi=0.0),),
    (effect("contact_compliance", k=400.0, c=0.5),),
    (effect("spring_cubic_k3", k=30.0),),
    (effect("spring_gap_k3", k=3.0, d=0.05),),
)


def looked_at(case: Case) -> tuple[list[Data], tuple[str, ...]]:
    return plausible(case, prepare((*case.train, *case.validate)))


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    found_by_hand.write_case(tmp_path, si=True)
    return tmp_path


def declared(folder: Path, channel: str, unit: str) -> Case:
    """The case with a unit in [channels] changed."""
    path = folder / "rig.toml"
    old = path.read_text(encoding="utf-8")
    new = re.sub(rf'({channel} = {{ column = "{channel}", unit = ")[^"]*', rf"\g<1>{unit}", old)
    assert new != old
    path.write_text(new, encoding="utf-8")
    return ss.load_case(path)


def recorded(folder: Path, change: Callable[[pd.DataFrame, int], pd.DataFrame]) -> Case:
    """The case with its runs' columns changed."""
    for i, file in enumerate(sorted(folder.glob("run_*.csv"))):
        change(pd.read_csv(file), i).to_csv(file, index=False)
    return ss.load_case(folder / "rig.toml")


@pytest.mark.parametrize("effects", EFFECTS, ids=lambda one: one[0].name if one else "none")
def test_no_effect_of_the_list_is_taken_for_a_wrong_unit(effects) -> None:
    _, said = looked_at(make_case(effects, length=60.0))
    assert said == ()


@pytest.mark.parametrize("cross", [0.0, 0.25])
def test_the_numbers_of_a_right_case(cross: float) -> None:
    case = make_case(length=60.0, crosstalk=cross)
    data = prepare(case.runs)
    ratio = body_ratio(data, case.rig)
    assert ratio.gain == pytest.approx(1.0, abs=0.02 if cross == 0 else 0.2)
    assert ratio.correlation > (0.999 if cross == 0 else 0.95)
    ridden = [(stick_speed(run), run.belt_speed) for run in data]
    known = [v / v_b for v, v_b in ridden if v is not None]
    assert len(known) >= (5 if cross == 0 else 3)
    assert known == pytest.approx([1.0] * len(known), abs=0.05 + cross)


def test_an_oscillation_without_sticks_has_no_stick_speed() -> None:
    case = make_case(length=60.0)
    t = case.runs[0].t
    x1 = 0.2 * np.sin(0.9 * t) + NOISE * np.random.default_rng(0).standard_normal(len(t))
    (run,) = prepare([replace(case.runs[0], x1=x1)])
    assert stick_speed(run) is None


@pytest.mark.parametrize(
    ("channel", "unit", "words"),
    [
        (
            "x1",
            "m",
            "channel x1 reads (999|1000) times what y1 asks for .*its unit is 'm' .*with 'mm' it would be right",
        ),
        ("x1", "cm", "channel x1 reads (9.99|10) times what y1 .*with 'mm' it would be right"),
        ("y1", "um", "channel y1 reads 0.00(1|100) times what x1 .*with 'mm' it would be right"),
        (
            "y1",
            "deg",
            "channel y1 reads 2.(19|2) times what x1 .*while x1 agrees with belt_speed.*with 'mm' it would",
        ),
        ("t", "ms", "channel t is in 'ms' .*only with times in 's'"),
    ],
)
def test_a_wrong_unit_is_named_with_the_right_one(folder: Path, channel: str, unit: str, words: str) -> None:
    with pytest.raises(InputError, match=words):
        discover(declared(folder, channel, unit))


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (lambda t, _: t.rename(columns={"x1": "y1", "y1": "x1"}), "x1 and y1 .*are their columns swapped"),
        (lambda t, _: t.assign(x1=-t.x1), "channel x1 reads the negative of what y1"),
        (lambda t, _: t.assign(y1=-t.y1), "channel y1 reads the negative of what x1"),
        (
            lambda t, _: t.assign(x1=10 * t.x1, y1=10 * t.y1),
            "(9.9.|10) times what friction allows: check the units of x1",
        ),
        (lambda t, _: t.assign(y1=t.y1 + 3.0), "another zero: x1 reads .* too much, or y1 3 mm"),
        (lambda t, i: t.assign(x1=0.0) if i == 1 else t, "run_02: channel x1 never changes"),
    ],
)
def test_a_wrong_column_is_said(folder: Path, change, words: str) -> None:
    with pytest.raises(InputError, match=words):
        discover(recorded(folder, change))


@pytest.mark.parametrize(
    ("times", "which", "words"),
    [
        (
            1000.0,
            slice(None),
            "a rate of x1 that is 0.00(1|0996) times belt_speed.*'m/s'.*in 'mm/s' it would be right",
        ),
        (-1.0, slice(None), "minus belt_speed: check the sign of belt_speed"),
        (
            -1.0,
            slice(0, 1),
            "run_01: belt_speed is -.* but the block sticks at a rate of x1 of .*unlike in the other",
        ),
        (1.5, slice(2, 3), "run_03: belt_speed is .*unlike in the other runs"),
    ],
)
def test_a_wrong_belt_speed_is_said(folder: Path, times: float, which: slice, words: str) -> None:
    path = folder / "rig.toml"
    text = path.read_text(encoding="utf-8")
    for one in re.findall(r"belt_speed = \S+", text)[which]:
        text = text.replace(one, f"belt_speed = {times * float(one.split(' = ')[1]):.10g}")
    path.write_text(text, encoding="utf-8")
    with pytest.raises(InputError, match=words):
        discover(ss.load_case(path))


def with_belt(case: Case, gain: float) -> Case:
    noise = np.random.default_rng(5).standard_normal
    runs = tuple(
        replace(run, belt=gain * run.belt_speed + 2 * NOISE * noise(len(run.t)), channels={**run.channels})
        for run in case.runs
    )
    return replace(case, runs=runs)


def test_a_belt_channel_that_the_block_contradicts_is_left_out() -> None:
    case = with_belt(make_case(length=60.0), 1.4)
    data, said = looked_at(case)
    assert len(said) == 1
    assert re.match(r"channel belt reads 1\.(39|4|41) times the speed at which the block rides", said[0])
    assert all((run.weight[:, 2] == 0).all() for run in data)
    data, said = looked_at(with_belt(make_case(length=60.0), 1.02))
    assert said == ()
    assert all((run.weight[:, 2] > 0).all() for run in data)


@pytest.mark.study
def test_one_train_run_gives_a_verdict_with_a_remark() -> None:
    case = make_case(length=40.0)
    found = discover(replace(case, runs=(case.runs[0], case.runs[-1])))
    assert found.verdict is Verdict.no_effect
    assert any("one train run only" in one for one in found.messages)
    assert any("no train run slips both ways" in one for one in found.messages)


@pytest.mark.study
def test_all_runs_at_one_speed_give_a_verdict_with_a_remark() -> None:
    found = discover(make_case(length=30.0, speeds=(0.1, 0.1, 0.1)))
    assert found.verdict is Verdict.no_effect
    assert any("all train runs have one belt speed: ties are wide" in one for one in found.messages)


@pytest.mark.study
@pytest.mark.parametrize("times", [0.1, 10.0])
def test_a_noise_declared_wrong_is_said_and_put_right(times: float) -> None:
    case = make_case(length=40.0, speeds=FEW)
    wrong = {"x1": times * NOISE, "y1": times * NOISE}
    runs = tuple(replace(run, noise=wrong) for run in case.runs)
    found = discover(replace(case, runs=runs, noise=wrong))
    assert found.verdict is Verdict.no_effect
    assert abs(found.residual_after.chi2 - 1) < 0.1
    assert sum("[noise] declares" in one for one in found.messages) == 2
    assert found.runs[0].noise["x1"] == pytest.approx(NOISE, rel=0.06)


@pytest.mark.study
def test_clipped_and_coarse_readings_pass_for_no_effect() -> None:
    case = make_case(length=40.0, speeds=FEW)
    runs = []
    for run in case.runs:
        top, step = np.quantile(np.abs(run.x1), 0.85), 0.02 * np.ptp(run.y1)
        runs.append(replace(run, x1=np.clip(run.x1, -top, top), y1=step * np.round(run.y1 / step)))
    found = discover(replace(case, runs=tuple(runs)))
    assert found.verdict is Verdict.no_effect


@pytest.mark.study
def test_a_short_validate_run_is_forecast_all_the_same() -> None:
    case = make_case(length=40.0, speeds=FEW)
    runs = (*case.runs[:-1], case.runs[-1].window(0.0, 6.0))
    found = discover(replace(case, runs=runs))
    assert found.error.after < 3 * found.error.floor
    assert any("cycles only: its second half is forecast from its first" in one for one in found.messages)


def test_the_white_part_of_a_residual_is_told_from_a_misfit() -> None:
    t = np.arange(0, 100, 0.04)
    white = np.random.default_rng(2).standard_normal(len(t))
    size, sure = noise_size([white + 20 * np.sin(2 * t) + 8 * np.abs(np.sin(t))])
    assert sure
    assert size == pytest.approx(1.0, rel=0.06)
    _, sure = noise_size(
        [white[::20] + 20 * np.sin(2 * t[::20])] * 3
    )  # a misfit that the sampling hardly resolves
    assert not sure


def test_no_process_is_started_for_a_case_that_is_refused(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def started(_: int) -> None:
        raise AssertionError("processes were started")

    monkeypatch.setattr("stickslip.discovery.discover.Workers", started)
    with pytest.raises(InputError, match=r"it would be right"):
        discover(declared(folder, "x1", "m"), threads=2)
