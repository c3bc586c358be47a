"""`stickslip forecast`: what it writes, what it doubts, what it refuses."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from click.testing import CliRunner, Result

import found_by_hand
import stickslip as ss
from stickslip.cli.commands import main
from stickslip.files import time_digits
from stickslip.shown.plot import curves as plot


def invoke(*arguments: object) -> Result:
    return CliRunner().invoke(main, [str(a) for a in arguments])


@pytest.mark.parametrize("si", [True, False])
def test_forecast_meets_what_happened(tmp_path: Path, si: bool) -> None:
    case = ss.load_case(found_by_hand.write_case(tmp_path, si=si))
    model = found_by_hand.true_model(case)
    model.save(tmp_path / "model.toml")
    whole = pd.read_csv(tmp_path / "run_03.csv")
    now, later = 1000, 1300
    whole[:now].to_csv(tmp_path / "past.csv", index=False)
    horizon = float(whole["t"][later - 1] - whole["t"][now - 1]) * 1.0001
    recording = case.run("run_03")
    speed = recording.belt_speed * (case.rig.scales.velocity if si else 1.0)
    result = invoke(
        "forecast", tmp_path / "model.toml", tmp_path / "past.csv", "--belt-speed", speed, "--horizon", horizon,
        "--out", tmp_path / "next.csv",
    )  # fmt: skip
    assert result.exit_code == 0, result.output
    ahead = pd.read_csv(tmp_path / "next.csv")
    assert list(ahead.columns) == ["t", "x1", "y1", "x1_low", "x1_high", "y1_low", "y1_high"]
    assert len(ahead) == later - now
    np.testing.assert_allclose(ahead["t"], whole["t"][now:later], rtol=1e-5)
    noise = recording.noise["x1"] * found_by_hand.per_reading(case)
    truth = found_by_hand.readings(model, recording.belt_speed)[now:later, 1:] * found_by_hand.per_reading(
        case
    )
    off = np.sqrt(np.mean((ahead[["x1", "y1"]].to_numpy() - truth) ** 2))
    assert off < 2 * noise  # two cycles ahead, of readings that spread by several hundred times the noise
    assert np.std(truth) > 100 * noise


@pytest.fixture
def past(tmp_path: Path) -> tuple[Path, Path, float]:
    """The true model, the first 1000 samples of a run, its belt speed in m/s."""
    case = ss.load_case(found_by_hand.write_case(tmp_path, si=True))
    found_by_hand.true_model(case).save(tmp_path / "model.toml")
    pd.read_csv(tmp_path / "run_03.csv")[:1000].to_csv(tmp_path / "past.csv", index=False)
    return (
        tmp_path / "model.toml",
        tmp_path / "past.csv",
        case.run("run_03").belt_speed * case.rig.scales.velocity,
    )


def test_a_forecast_from_unix_time_stamps_can_be_read_again(
    tmp_path: Path, past: tuple[Path, Path, float]
) -> None:
    """Ten digits of 1.7e9 s tell nothing below a second: times came twice, and the file was refused."""
    model, run, speed = past
    table = pd.read_csv(run)
    step = float(table["t"].diff().median())
    table["t"] += 1.7e9
    table.to_csv(run, index=False, float_format="%.17g")
    asked = ("--belt-speed", speed, "--horizon", 1.0, "--out", tmp_path / "next.csv")
    result = invoke("forecast", model, run, *asked)
    assert result.exit_code == 0, result.output
    ahead = pd.read_csv(tmp_path / "next.csv")
    assert ahead["t"].iloc[0] - table["t"].iloc[-1] == pytest.approx(step, rel=1e-3)
    np.testing.assert_allclose(np.diff(ahead["t"]), step, rtol=1e-3)
    again = invoke("forecast", model, tmp_path / "next.csv", *asked[:-1], tmp_path / "then.csv")
    assert again.exit_code == 0, again.output


def test_a_run_without_the_model_s_belt_channel_is_forecast(
    tmp_path: Path, past: tuple[Path, Path, float]
) -> None:
    """The channel was left out, its noise was not: "belt: no such channel"."""
    model, run, speed = past
    text = model.read_text(encoding="utf-8").replace("\n[noise]\n", "\n[noise]\nbelt = 0.1\n")
    model.write_text(text + '\n[channels.belt]\ncolumn = "belt"\nunit = "mm/s"\n', encoding="utf-8")
    out = tmp_path / "next.csv"
    result = invoke("forecast", model, run, "--belt-speed", 1e3 * speed, "--horizon", 1.0, "--out", out)
    assert result.exit_code == 0, result.output
    assert "ride at" not in result.output


def test_horizon_and_belt_speed_have_units_of_their_own_beside_a_bare_displacement(
    tmp_path: Path, past: tuple[Path, Path, float]
) -> None:
    """One channel in "1" made the command read seconds and m/s as the model's own numbers."""
    model, run, speed = past
    loaded = ss.load_model(model)
    per = 1e-3 / loaded.rig.scales.length
    bare = {name: replace(loaded.channels[name], unit="1", scale=per) for name in ("x1", "y1")}
    replace(loaded, channels={**loaded.channels, **bare}, noise=None).save(tmp_path / "bare.toml")
    out, ahead = tmp_path / "next.csv", []
    for one in (model, tmp_path / "bare.toml"):
        result = invoke("forecast", one, run, "--belt-speed", speed, "--horizon", 1.0, "--out", out)
        assert result.exit_code == 0, result.output
        assert f"belt speed {speed:.5g} m/s" in result.output
        assert re.search(r"t = [\d.]+ to [\d.]+ s; ", result.output)
        ahead.append(pd.read_csv(out)["t"])
    np.testing.assert_array_equal(*ahead)


def test_a_forecast_is_drawn_behind_the_record(tmp_path: Path, past: tuple[Path, Path, float]) -> None:
    model, run, speed = past
    out = tmp_path / "next.csv"
    asked = ("--belt-speed", speed, "--horizon", 1.0, "--out", out, "--figure")
    result = invoke("forecast", model, run, *asked)
    assert result.exit_code == 0, result.output
    assert result.output.split()[-3:] == [str(out.with_suffix(kind)) for kind in (".csv", ".svg", ".png")]
    loaded, ahead = ss.load_model(model), pd.read_csv(out)
    record = ss.load_recording(run, loaded.rig, channels=loaded.channels, belt_speed=f"{speed} m/s")
    figure = plot.forecast(record, ahead)
    assert [ax.get_ylabel() for ax in figure.axes] == [f"${c}_1$ [mm]" for c in "xy"]
    assert figure.axes[-1].get_xlabel() == "time $t$ [s]"
    for ax, name in zip(figure.axes, ("x1", "y1"), strict=True):
        (t, seen), (later, forecast), (now, _) = (np.asarray(one.get_data()) for one in ax.lines)
        assert set(now) == {t[-1]} == {later[0]} == {record.raw["t"][-1]}
        np.testing.assert_array_equal(seen, record.raw[name][-len(seen) :])
        assert later[-1] - now[0] == pytest.approx(
            now[0] - t[0], rel=0.01
        )  # as much of the past as of the future
        np.testing.assert_array_equal(forecast[1:], ahead[name])


@pytest.mark.parametrize(
    ("named", "words"),
    [
        ("model.toml", "it would overwrite MODEL"),
        ("past.csv", "it would overwrite RUN"),
        ("link.csv", "it would overwrite RUN"),
        ("drawn.png", "its figure would overwrite it"),
    ],
)
def test_a_forecast_does_not_overwrite_what_it_is_made_from(
    tmp_path: Path, past: tuple[Path, Path, float], named: str, words: str
) -> None:
    model, run, speed = past
    (tmp_path / "link.csv").symlink_to(run)
    before = model.read_bytes(), run.read_bytes()
    out = tmp_path / named
    result = invoke(
        "forecast", tmp_path if named == "model.toml" else model, run, "--belt-speed", speed, "--horizon", 1.0,
        "--out", out, "--figure",
    )  # fmt: skip
    assert result.exit_code == 2
    assert result.stderr.startswith("stickslip: --out = ")
    assert words in result.stderr
    assert result.stderr.count("\n") == 1
    assert (model.read_bytes(), run.read_bytes()) == before


def test_times_are_written_as_finely_as_they_lie() -> None:
    assert time_digits([0.0, 0.5, 1.0], 10) == 10
    assert time_digits(1.7e9 + 0.02 * np.arange(5), 10) == 16
    assert time_digits([0.0, 1.0, 1.0 + 1e-9], 12) == 14  # an end that lies off the step
    assert time_digits([1.7e9], 10) == 17


@pytest.mark.parametrize(
    ("times", "words"),
    [
        (
            1000.0,
            r"but the sticks of the past ride at .* m/s, 0\.001 times that: .*; in 'mm/s' it would be right",
        ),
        (-1.0, "check the sign of belt_speed"),
    ],
)
def test_a_belt_speed_far_from_that_of_the_past_is_refused(
    tmp_path: Path, past: tuple[Path, Path, float], times: float, words: str
) -> None:
    """mm/s taken for m/s gave a forecast, and a warning of 1.26e+05 times the noise."""
    model, run, speed = past
    out = tmp_path / "next.csv"
    result = invoke("forecast", model, run, "--belt-speed", times * speed, "--horizon", 1.0, "--out", out)
    assert result.exit_code == 2
    assert re.search(words, result.stderr)
    assert result.stderr.count("\n") == 1
    assert not out.exists()


@pytest.mark.parametrize("times", [0.9, 1.1])
def test_a_belt_speed_hardly_off_is_doubted_where_the_model_misses(
    tmp_path: Path, past: tuple[Path, Path, float], times: float
) -> None:
    model, run, speed = past
    out = tmp_path / "next.csv"
    result = invoke("forecast", model, run, "--belt-speed", times * speed, "--horizon", 1.0, "--out", out)
    assert result.exit_code == 0, result.output
    assert f"but the sticks of the past ride at {speed:.3g}"[:-1] in result.output
    right = invoke("forecast", model, run, "--belt-speed", speed, "--horizon", 1.0, "--out", out)
    assert "sticks of the past" not in right.output


def test_a_belt_speed_somewhat_off_is_doubted_in_units(
    tmp_path: Path, past: tuple[Path, Path, float]
) -> None:
    model, run, speed = past
    result = invoke(
        "forecast", model, run, "--belt-speed", 2 * speed, "--horizon", 1.0, "--out", tmp_path / "next.csv"
    )
    assert result.exit_code == 0, result.output
    assert f"but the sticks of the past ride at {speed:.3g}"[:-1] in result.output
    assert "0.5 times that" in result.output
    assert re.search(
        r"model and channel \w+ differ by [\d.]+ mm over the last 10 readings, [\d.]+ times", result.output
    )
    assert "e+" not in result.output


def test_forecast_by_the_model_that_identify_wrote(tmp_path: Path) -> None:
    """Readings in mm and s: the forecast goes on where the run stops."""
    path = found_by_hand.write_case(tmp_path, si=True)
    case = ss.load_case(path)
    result = invoke("identify", path, "--out", tmp_path / "found")
    assert result.exit_code == 0, result.output
    model = ss.load_model(tmp_path / "found" / "model.toml")
    assert model.channels == case.channels
    assert model.noise == case.noise
    whole = pd.read_csv(tmp_path / "run_03.csv")
    whole[:1000].to_csv(tmp_path / "past.csv", index=False)
    speed = case.run("run_03").belt_speed * case.rig.scales.velocity
    result = invoke(
        "forecast", tmp_path / "found" / "model.toml", tmp_path / "past.csv", "--belt-speed", speed,
        "--horizon", 1.0, "--out", tmp_path / "next.csv",
    )  # fmt: skip
    assert result.exit_code == 0, result.output
    ahead = pd.read_csv(tmp_path / "next.csv")
    assert ahead["t"][0] == pytest.approx(whole["t"][1000], rel=1e-5)
    step = 5 * whole[["x1", "y1"]].diff().abs().max()
    assert (abs(ahead[["x1", "y1"]].iloc[0] - whole[["x1", "y1"]].iloc[1000]) < step).all()


def test_forecast_refuses_an_si_rig_whose_readings_have_no_units(tmp_path: Path) -> None:
    case = ss.load_case(found_by_hand.write_case(tmp_path, si=True))
    ss.Model(case.rig, friction=case.friction).save(tmp_path / "model.toml")
    out = tmp_path / "next.csv"
    result = invoke(
        "forecast", tmp_path / "model.toml", tmp_path / "run_03.csv", "--belt-speed", 0.01, "--horizon", 1,
        "--out", out,
    )  # fmt: skip
    assert result.exit_code == 2
    assert result.stderr.replace(f"{tmp_path}/", "") == (
        "stickslip: model.toml: the rig is in SI and the units of the readings are not given; "
        "add [channels], as in rig.toml\n"
    )
    assert not out.exists()


def test_forecast_writes_nothing_on_bad_input(tmp_path: Path) -> None:
    case = ss.load_case(found_by_hand.write_case(tmp_path))
    case.model().save(tmp_path / "model.toml")
    run = tmp_path / "run_03.csv"
    out = tmp_path / "next.csv"
    result = invoke(
        "forecast", tmp_path / "model.toml", run, "--belt-speed", 0.1, "--horizon", "-1", "--out", out
    )
    assert result.exit_code == 2
    assert result.stderr == "stickslip: --horizon = '-1': must be a finite number above 0\n"
    assert not out.exists()


@pytest.mark.parametrize(
    ("command", "said"),
    [
        (("forecast", "model.toml", "past.csv", "--horizon", "0.1"), "--drive: missing: the force on the slider"),
        (("simulate", "model.toml", "--t-end", "1"), "--drive: missing: the force on the slider"),
    ],
    ids=["forecast", "simulate"],
)  # fmt: skip
def test_of_a_driven_slider_no_belt_speed_is_asked(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, command: tuple[str, ...], said: str
) -> None:
    """The speed of its belt was asked for, which it has not, and with one it was refused."""
    monkeypatch.chdir(tmp_path)
    ss.Model(ss.DrivenSlider(mass=1.0), friction=ss.CoulombFriction(static=2, kinetic=1)).save("model.toml")
    pd.DataFrame({"t": [0.0, 0.1], "x1": [0.0, 0.1]}).to_csv("past.csv", index=False)
    for speed in ((), ("--belt-speed", "0.1")):
        result = invoke(*command, *speed, "--out", "out.csv")
        assert result.exit_code == 2
        assert said in result.output
    assert not Path("out.csv").exists()
