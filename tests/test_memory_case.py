"""Discovery of what is in memory: a data frame, recordings; and what is said of what cannot be searched."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

import stickslip as ss
from every_object import BLOCK, CHANNELS, COULOMB, block_run, objects
from quick_figures import quickly
from stickslip.measured.memory_case import IN_MEMORY, case_in_memory

RIG = ss.Rig(alpha1=16, alpha2=8, beta3=4, eta1=0.1, eta12=0.2)


def frame() -> pd.DataFrame:
    return block_run().to_dataframe()


def test_a_frame_becomes_a_case_whose_last_third_is_validated() -> None:
    whole = block_run()
    case = case_in_memory(frame(), BLOCK, channels=CHANNELS, belt_speed="5 mm/s", noise={"x1": 1e-3})
    assert [run.role for run in case.runs] == ["train", "validate"]
    np.testing.assert_array_equal(np.concatenate([run.t for run in case.runs]), whole.t)
    np.testing.assert_array_equal(np.concatenate([run.x1 for run in case.runs]), whole.x1)
    assert len(case.train[0]) == pytest.approx(2 / 3 * len(whole), abs=1)
    assert all(run.belt_speed == 0.005 for run in case.runs)
    assert case.noise == pytest.approx({"x1": 1e-3})
    assert case.declared_numbers == {}


def test_recordings_keep_their_roles() -> None:
    train, validate = block_run(), replace(block_run(seed=1), role="validate", name="other")
    case = case_in_memory([train, validate], None, friction=COULOMB)
    assert case.runs == (train, validate)
    assert case.rig == BLOCK
    assert case.declared_law == COULOMB


def test_recordings_of_one_name_are_told_apart() -> None:
    """What was forecast of one was held against the readings of the other."""
    runs = [replace(block_run(seed=k), role=role) for k, role in enumerate(("train", "validate", "validate"))]
    names = [run.name for run in case_in_memory(runs, None).runs]
    assert names == [f"{runs[0].name}_{k}" for k in (1, 2, 3)]


def test_files_of_one_name_are_told_apart_by_their_folders(tmp_path: Path) -> None:
    text = '[rig]\nkind = "block_on_belt"\nm = 0.5\nk = 500\n'
    text += '[channels]\nt = { column = "t", unit = "s" }\nx1 = { column = "x1", unit = "mm" }\n'
    for day, role in (("monday", "train"), ("tuesday", "validate"), ("friday", "validate")):
        (tmp_path / day).mkdir()
        frame().to_csv(tmp_path / day / "run.csv", index=False)
        text += f'[[run]]\nfile = "{day}/run.csv"\nrole = "{role}"\nbelt_speed = "5 mm/s"\n'
    case = tmp_path / "rig.toml"
    case.write_text(text)
    assert [run.name for run in ss.load_case(case).runs] == ["monday/run", "tuesday/run", "friday/run"]
    case.write_text(text.replace('role = "validate"', 'role = "validate"\nname = "late"'))
    with pytest.raises(ss.InputError, match=r"\[\[run\]\] 2 has this name already"):
        ss.load_case(case)


@pytest.mark.parametrize(
    ("given", "named", "words"),
    [
        ({"t": [0.0], "x1": [0.0]}, {}, "columns in memory need their rig"),
        ([], {}, "is empty; give recordings"),
        (block_run(), {"belt_speed": 0.1}, "is for columns in memory"),
        (["a"], {}, "must be a Recording, not str"),
        (5, {}, "must be a Case, not int"),
        ("case", {}, "must be a Case, not str"),
    ],
)
def test_what_is_no_case_is_one_line(given: object, named: dict[str, object], words: str) -> None:
    with pytest.raises(ss.InputError, match=words) as caught:
        ss.discover(given, **named)  # type: ignore[arg-type]
    assert "\n" not in str(caught.value)


def test_recordings_with_other_channels_are_refused() -> None:
    other = replace(block_run(), channels={**CHANNELS, "x1": ss.Channel("x", "mm")})
    with pytest.raises(ss.InputError, match="different channels"):
        ss.discover([block_run(), other])


def test_a_case_has_its_own_rig() -> None:
    case = case_in_memory(block_run(), None)
    with pytest.raises(ss.InputError, match="rig: is for recordings and columns in memory"):
        ss.discover(case, rig=BLOCK)


def test_a_frame_reaches_the_search() -> None:
    found = ss.discover(
        frame(), rig=BLOCK, channels=CHANNELS, belt_speed=0.005, noise={"x1": 1e-3}, friction=COULOMB
    )
    assert found.effects == ()
    assert "every event of a run is like every other" in found.messages[0]


@pytest.mark.study
def test_the_report_of_what_was_in_memory_says_so(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    quickly(monkeypatch)
    found, case = objects()["Found"], objects()["Case"]
    written = replace(found, case=replace(case, path=IN_MEMORY)).write_report(tmp_path / "out")
    assert "in Python, of what was in memory" in written[0].read_text(encoding="utf-8")
