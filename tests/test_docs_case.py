"""The rig.toml files that docs/case.md shows are read as it says."""

import re
from pathlib import Path

import numpy as np
import pytest

from stickslip.declared.rig import BlockOnBelt, DrivenSlider, Rig
from stickslip.measured.case import Case, load_case

PAGE = Path(__file__).resolve().parent.parent / "docs" / "case.md"


@pytest.fixture
def cases(tmp_path: Path) -> list[Case]:
    t = 0.5 * np.arange(50)
    rows = [f"{1000 * a},{np.sin(a)},{np.cos(a)},{6.3},{a}" for a in t]
    found = []
    for i, text in enumerate(re.findall(r"```toml\n(.*?)```", PAGE.read_text(encoding="utf-8"), re.DOTALL)):
        folder = tmp_path / str(i)
        folder.mkdir()
        (folder / "rig.toml").write_text(text)
        header = "time,block,angle,belt,s" if "block_on_belt" not in text else "ms,force,angle,belt,time"
        if "driven_slider" in text:
            header = "ms,position,command,belt,time"
        if "bodies" in text:
            header = (
                "ms,angle,speed,top,time"
                if 'drive_speed = "12 rpm"' in text
                else "acc,laser,laser 2,cell,time"
            )
        for name in ("run_01.csv", "run_02.csv"):
            (folder / name).write_text("\n".join([header, *rows]))
        found.append(load_case(folder))
    return found


def test_the_cases_of_the_page(cases: list[Case]) -> None:
    two, one, driven, drill, slider = cases
    assert isinstance(two.rig, Rig)
    assert two.rig.scales is not None
    assert two.friction.static_limits == (6.2, 3.63)
    speed = two.rig.scales.velocity
    assert [run.belt_speed * speed for run in two.runs] == pytest.approx([6.3e-3, -11e-3])
    run = two.train[0]
    np.testing.assert_allclose(run.t * two.rig.scales.time, 0.5 * np.arange(50), atol=1e-12)
    assert run.y1 is not None
    np.testing.assert_allclose(run.y1 * 0.0089 / 0.1256, np.deg2rad(np.cos(0.5 * np.arange(50))), atol=1e-12)

    assert one.rig == BlockOnBelt(mass=0.0307, stiffness=168)
    assert [len(run) for run in one.runs] == [24, 26, 50]
    assert [(own.name, own.where, own.ranges) for own in one.candidates] == [
        ("stiffening", "block", {"k2": (0.0, 1e5)})
    ]
    assert one.runs[2].rig == BlockOnBelt(mass=0.0307, stiffness=1002)
    np.testing.assert_allclose(one.runs[2].x1 * 1002, 0.301 * np.sin(0.5 * np.arange(50)), atol=1e-12)

    assert driven.rig == DrivenSlider(mass=95.1)
    drive = driven.runs[0].drive
    assert drive is not None
    np.testing.assert_allclose(drive, 35.15 * np.cos(0.5 * np.arange(50)), atol=1e-12)

    assert drill.rig.state_names == ("table", "bit", "v_table", "v_bit")
    assert drill.uncertainty.relative("table.inertia") == 0.01
    (run,) = drill.runs
    np.testing.assert_allclose(run.coordinates["bit"], np.deg2rad(np.sin(0.5 * np.arange(50))), atol=1e-12)
    assert run.speeds["drive_speed"].constant == pytest.approx(12 * 2 * np.pi / 60)

    (run,) = slider.runs
    np.testing.assert_allclose(run.coordinates["a_slider"], 9.80665 * 1000 * 0.5 * np.arange(50), atol=1e-9)
    assert run.channels["laser_2"].reads == "slider"
    assert slider.uncertainty.gains == {
        "slider": 0.005,
        "a_slider": 0.005,
        "T_slider": 0.005,
        "laser_2": 0.01,
    }


def test_columns_in_memory_as_on_the_page(capsys: pytest.CaptureFixture[str]) -> None:
    every = re.findall(r"```python\n(.*?)```", PAGE.read_text(encoding="utf-8"), re.DOTALL)
    (program,) = (one for one in every if "load_recording" in one)
    exec(program, {})
    said = capsys.readouterr().out
    value = re.search(r"static +([\d.]+)", said)
    assert value is not None
    assert float(value[1]) == pytest.approx(0.4, abs=1e-4)
