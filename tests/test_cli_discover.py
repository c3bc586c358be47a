"""The commands discover and forecast: what they write, print and return."""

from __future__ import annotations

import json
import os
import re
import signal
import time
from collections.abc import Callable
from dataclasses import replace
from importlib import import_module
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from click.testing import CliRunner, Result

import found_by_hand
import stickslip as ss
from stickslip import plot
from stickslip.cli import main
from stickslip.cli_discover import folded
from stickslip.discovery.result import Found
from stickslip.files import time_digits
from stickslip.telling import telling


def invoke(*arguments: object) -> Result:
    return CliRunner().invoke(main, [str(a) for a in arguments])


@pytest.fixture
def known(monkeypatch: pytest.MonkeyPatch) -> Callable[[str], None]:
    """Let the command return a result put together by hand, of the verdict asked for."""

    def use(verdict: str) -> None:
        def search(
            case: ss.Case, *, progress: Callable[[str], None], seed: int, threads: int | None
        ) -> Found:
            assert (seed, threads) in ((3, None), (3, 2))
            for what in ("sensor_lag", "belt_seam", "sensor_lag + belt_seam", "sensor_lag + sensor_delay"):
                progress(f"trying {what}")
            progress("scoring a curve: block against x1")
            progress("scoring a curve: block against x2")
            return found_by_hand.found(case, verdict=verdict)

        module = import_module("stickslip.discover")  # the package has a function of that name
        monkeypatch.setattr(module, "discover", search)
        monkeypatch.setattr("stickslip.report.write.draw", lambda *_: {})

    return use


@pytest.mark.parametrize("verdict", ["no_effect", "effect_found", "unlisted_effect"])
def test_every_verdict_is_a_success(tmp_path: Path, known: Callable[[str], None], verdict: str) -> None:
    known(verdict)
    path = found_by_hand.write_case(tmp_path, si=True)
    result = invoke("discover", path, "--out", tmp_path / "out", "--seed", "3", "--threads", "2")
    assert result.exit_code == 0, result.output
    assert json.loads((tmp_path / "out" / "report.json").read_text(encoding="utf-8"))["verdict"] == verdict
    stages = [line.partition("] ")[2] for line in result.stderr.splitlines()]
    assert [one for one in stages if not one.startswith("note: ")] == [
        "trying each effect", "trying sensor_lag + each other effect", "scoring curves", "drawing the report"
    ]  # fmt: skip
    for name in ("report.html", "report.json", "model_before.toml", "model_after.toml"):
        assert str(tmp_path / "out" / name) in result.stdout
        assert (tmp_path / "out" / name).is_file()


@pytest.mark.parametrize(
    "given", [("--threads", "0"), ("--threads", "1.5"), ("--threads", "two"), ("--seed", "-1")]
)
def test_no_threads_and_a_negative_seed_are_refused(tmp_path: Path, given: tuple[str, str]) -> None:
    path = found_by_hand.write_case(tmp_path)
    result = invoke("discover", path, "--out", tmp_path / "out", *given)
    assert result.exit_code == 2
    assert result.stderr.startswith(f"stickslip: invalid value for '{given[0]}': ")
    assert result.stderr.count("\n") == 1
    assert not (tmp_path / "out").exists()


def test_a_log_hears_what_is_tried_while_a_stage_lasts(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """Minutes without a line looked like a search that hangs."""
    monkeypatch.setattr("stickslip.telling.EVERY", 0.2)
    with telling("discovering", effects=23) as tell:
        tell("fitting the declared law")
        time.sleep(0.5)  # no word from the search
        for what in ("sensor_lag", "belt_seam", "belt_seam", "cubic_spring"):
            tell(f"trying {what}")
        time.sleep(0.3)
        tell("trying sensor_lag + belt_seam")
        tell("trying sensor_lag + cubic_spring")
        time.sleep(0.3)
    lines = [line.partition("] ")[2] for line in capsys.readouterr().err.splitlines()]
    assert list(dict.fromkeys(lines)) == [
        "fitting the declared law",
        "still fitting the declared law",
        "trying each effect",
        "trying each effect: 2 of at most 23 done, now trying cubic_spring",
        "trying sensor_lag + each other effect",
        "trying sensor_lag + each other effect: 1 of at most 22 done, now trying sensor_lag + cubic_spring",
    ]


def test_what_is_printed_has_the_tie_the_si_value_and_the_next_experiment(
    tmp_path: Path, known: Callable[[str], None]
) -> None:
    known("effect_found")
    path = found_by_hand.write_case(tmp_path, si=True)
    out = " ".join(invoke("discover", path, "--out", tmp_path / "out", "--seed", 3).stdout.split())
    assert "NOT settled: these runs cannot tell it from sensor_delay" in out
    assert "0.009603 s" in out
    assert "Next experiment: a common trigger for both sensors, to tell sensor_lag from sensor_delay." in out


@pytest.mark.skipif(not hasattr(signal, "SIGHUP"), reason="no such signal here")
@pytest.mark.parametrize("name", ["SIGTERM", "SIGHUP"])
def test_an_ended_search_leaves_no_hidden_folder(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, name: str
) -> None:
    number = getattr(signal, name)

    def search(*_: object, **__: object) -> None:
        assert any(one.name.startswith(".out.") for one in tmp_path.iterdir())
        os.kill(os.getpid(), number)
        time.sleep(10)

    monkeypatch.setattr(import_module("stickslip.discover"), "discover", search)
    before = signal.signal(number, signal.SIG_DFL)
    try:
        result = invoke("discover", found_by_hand.write_case(tmp_path), "--out", tmp_path / "out")
        assert signal.getsignal(number) is signal.SIG_DFL
    finally:
        signal.signal(number, before)
    assert result.exit_code == 128 + number
    assert not any("out" in one.name for one in tmp_path.iterdir())


def test_no_verdict_is_one_line_and_not_zero(tmp_path: Path) -> None:
    path = found_by_hand.write_case(tmp_path)
    path.write_text(path.read_text().replace('"validate"', '"train"'), encoding="utf-8")
    result = invoke("discover", path, "--out", tmp_path / "out")
    assert result.exit_code == 2
    assert (
        result.stderr.replace(f"{tmp_path}/", "")
        == "stickslip: rig.toml: no [[run]] has role = 'validate'; give it to at least one\n"
    )
    assert not (tmp_path / "out").exists()


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
    assert list(ahead.columns) == ["t", "x1", "y1"]
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


def test_findings_alike_are_said_once() -> None:
    said = [f"run_{i:02d}: x1: ranges over {i}.5e-3 m; is the unit right?" for i in range(3)]
    other = [f"run_{i:02d}: y1: ranges over {i} m; is the unit right?" for i in range(2)]
    assert folded([*said, *other, "run_01: samples are missing"]) == [
        f"{said[0]} (and alike in 2 other runs)",
        f"{other[0]} (and alike in 1 other run)",
        "run_01: samples are missing",
    ]


@pytest.mark.parametrize("command", ["identify", "compare"])
def test_findings_are_printed(tmp_path: Path, command: str) -> None:
    """Millimetres declared as metres."""
    path = found_by_hand.write_case(tmp_path, si=True)
    case = ss.load_case(path)
    case.model().save(tmp_path / "model.toml")
    for name in ("x1", "y1"):
        text = path.read_text(encoding="utf-8")
        path.write_text(text.replace(f'"{name}", unit = "mm"', f'"{name}", unit = "m"'), encoding="utf-8")
    first = [tmp_path / "model.toml"] if command == "compare" else []
    result = invoke(command, *first, path, "--out", tmp_path / "out")
    findings = ss.load_case(path).findings
    assert any("is the unit right?" in one for one in findings)
    for one in findings:
        assert one in result.stdout or (command == "compare" and not one.startswith("run_03"))


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


@pytest.mark.slow
def test_a_lag_is_found_and_removed(tmp_path: Path) -> None:
    path = found_by_hand.write_case(tmp_path, si=True)
    result = invoke("discover", path, "--out", tmp_path / "out")
    assert result.exit_code == 0, result.output
    report = json.loads((tmp_path / "out" / "report.json").read_text(encoding="utf-8"))
    first = report["effects"][0]
    assert "sensor_lag" in {first["name"], *(a["name"] for a in first["alternatives"] if a["tied"])}
    if first["name"] == "sensor_lag":
        tau = first["parameters"]["tau"]
        deviation = (tau["high"] - tau["low"]) / (2 * 1.96)
        assert abs(tau["value"] - 0.12) < 3.5 * deviation  # one draw: its 95 % interval may miss
        assert deviation < 0.01 * 0.12
    assert report["error"]["after"] < 0.5 * report["error"]["before"]
