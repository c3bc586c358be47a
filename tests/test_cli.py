"""The command line as a person meets it."""

import dataclasses
import json
import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from click.testing import CliRunner

import found_by_hand
import stickslip as ss
from stickslip.cli.commands import main
from stickslip.declared.units import Channel
from stickslip.files import RECORD
from test_identify import RIG, TRUE, truth

CASE = """
title = "made for a test"
[rig]
alpha1 = 16.0
alpha2 = 8.0
beta3 = 4.0
eta1 = 0.1
eta12 = 0.2
[[run]]
file = "a.csv"
role = "train"
belt_speed = 0.1
[[run]]
file = "b.csv"
role = "validate"
belt_speed = 0.1
[channels]
t = { column = "t", unit = "1" }
x1 = { column = "x1", unit = "1" }
y1 = { column = "y1", unit = "1" }
"""

SI = {
    "m": 2.6, "J": 0.0174, "r": 0.08, "k1": 690.0, "k2": 45.0, "k3": 140.0, "c1": 0.28, "c2": 0.3, "length": 0.012
}  # fmt: skip
MODEL_SI = ss.Model(ss.Rig.from_si(**SI), friction=TRUE)


def stickslip(*arguments):
    return CliRunner().invoke(main, [str(a) for a in arguments])


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    at = tmp_path_factory.mktemp("case")
    (at / "rig.toml").write_text(CASE)
    rng = np.random.default_rng(0)
    t, state = truth(0.1, 60.0)
    for name in ("a", "b"):
        x, y = (state[:, i] + 8e-4 * rng.standard_normal(len(t)) for i in (0, 2))
        pd.DataFrame({"t": t, "x1": x, "y1": y}).to_csv(at / f"{name}.csv", index=False)
    ss.Model(RIG, friction=TRUE).save(at / "model.toml")
    MODEL_SI.save(at / "si.toml")
    return at


@pytest.mark.parametrize(
    "command", ["simulate", "identify", "compare", "discover", "explore", "forecast", "sweep", "demo"]
)
def test_every_help_shows_an_example(command):
    result = stickslip(command, "--help")
    assert result.exit_code == 0
    assert r"\b" not in result.output
    assert f"Example:\n    stickslip {command}" in result.output


def test_version():
    assert ss.__version__ in stickslip("--version").output


def test_simulate_writes_what_simulate_returns(folder, tmp_path):
    out = tmp_path / "run.csv"
    result = stickslip(
        "simulate", folder / "model.toml", "--belt-speed", 0.1, "--t-end", 20, "--dt", 0.5,
        "--initial", "0.1,0.1,0,0", "--out", out, "--figure",
    )  # fmt: skip
    assert result.exit_code == 0, result.output
    frame = pd.read_csv(out)
    assert list(frame.columns) == ["t", "x1", "x2", "y1", "y2", "mode"]
    run = ss.simulate(
        ss.load_model(folder / "model.toml"),
        belt_speed=0.1,
        initial=(0.1, 0.1, 0, 0),
        t_end=20,
        t_eval=np.arange(41) * 0.5,
    )
    np.testing.assert_allclose(frame[["x1", "x2", "y1", "y2"]], run.state, atol=1e-11)
    assert sorted(p.name for p in tmp_path.iterdir() if p.name != RECORD) == ["run.csv", "run.png", "run.svg"]


def test_a_long_run_is_drawn_as_a_curve_and_written_as_asked(tmp_path, monkeypatch):
    from matplotlib.figure import Figure

    from stickslip.shown.plot import curves as plot

    drawn = []
    own = Figure.savefig
    monkeypatch.setattr(Figure, "savefig", lambda self, *a, **k: drawn.append(self) or own(self, *a, **k))
    _, frame = simulated(
        tmp_path, ss.Model(RIG, friction=TRUE), "--belt-speed", 0.1, "--t-end", 1000, "--figure"
    )
    assert len(frame) == 2001
    np.testing.assert_allclose(np.diff(frame["t"]), 0.5)
    over_time, portrait = (axes.lines[0] for axes in drawn[0].axes)
    assert np.diff(over_time.get_xdata()).max() <= 2 * np.pi / 60
    run = ss.simulate(ss.Model(RIG, friction=TRUE), belt_speed=0.1, t_end=1000)
    corners = run.transitions.t[run.transitions.t >= over_time.get_xdata()[0] - 1e-6]
    assert len(corners) == plot.MOST_DRAWN
    gap = np.abs(corners[:, None] - over_time.get_xdata()).min(axis=1)
    assert gap.max() < 1e-6  # corners are where they are
    # no corner of a polygon: from one point to the next the portrait goes a small part of its extent
    path = np.column_stack([portrait.get_xdata(), portrait.get_ydata()])
    assert (np.abs(np.diff(path, axis=0)).max(axis=0) < 0.08 * np.ptp(path, axis=0)).all()


def simulated(tmp_path, model, *arguments):
    model.save(tmp_path / "model.toml")
    result = stickslip("simulate", tmp_path / "model.toml", *arguments, "--out", tmp_path / "run.csv")
    assert result.exit_code == 0, result.output
    return result.output, pd.read_csv(tmp_path / "run.csv")


@pytest.mark.parametrize(
    "units",
    [("14 mm/s", "9 s", "0.01 s"), ("14mm/s", "9000ms", "1e-2s"), ("0.014", "9", "0.01"), (None, None, None)],
)
def test_simulate_of_an_si_rig_takes_and_writes_units(tmp_path, units):
    scales = MODEL_SI.rig.scales
    v, end, step = 0.014 / scales.velocity, 9 / scales.time, 0.01 / scales.time
    if units[0] is None:  # the model's own numbers
        units = (f"{v!r} 1", f"{end!r} 1", f"{step!r} 1")
    said, frame = simulated(
        tmp_path, MODEL_SI, "--belt-speed", units[0], "--t-end", units[1], "--dt", units[2]
    )
    assert "belt speed 0.014 m/s" in said
    assert "to t = 9 s in steps of 0.01 s" in said
    assert list(frame.columns) == ["t [s]", "x1 [m]", "x2 [m/s]", "y1 [m]", "y2 [m/s]", "mode"]
    run = ss.simulate(MODEL_SI, belt_speed=v, t_end=end * 1.001, t_eval=frame["t [s]"] / scales.time)
    np.testing.assert_allclose(frame["x1 [m]"], run.state[:, 0] * scales.length, atol=1e-9)
    np.testing.assert_allclose(frame["y2 [m/s]"], run.state[:, 3] * scales.velocity, atol=1e-8)


def test_simulate_ends_at_its_end_even_off_the_step(tmp_path):
    _, frame = simulated(tmp_path, MODEL_SI, "--belt-speed", "14 mm/s", "--t-end", "1 s", "--dt", "0.4 s")
    np.testing.assert_allclose(frame["t [s]"], [0.0, 0.4, 0.8, 1.0], atol=1e-9)


def test_simulate_reads_and_writes_in_the_units_of_the_readings(tmp_path):
    channels = {
        "t": Channel("time", "ms"), "x1": Channel("x", "um"),
        "y1": Channel("angle", "deg"), "belt": Channel("belt", "mm/min"),
    }  # fmt: skip
    model = dataclasses.replace(MODEL_SI, channels=channels)
    said, frame = simulated(
        tmp_path, model, "--belt-speed", "840", "--t-end", "900", "--initial", "100, 14 mm/s, 2, 0 deg/s"
    )
    assert "belt speed 840 mm/min" in said
    assert "x1 = 100 um, x2 = 14 um/ms, y1 = 2 deg, y2 = 0 deg/ms" in said
    assert list(frame.columns) == ["t [ms]", "x1 [um]", "x2 [um/ms]", "y1 [deg]", "y2 [deg/ms]", "mode"]
    scales = MODEL_SI.rig.scales
    start = (1e-4 / scales.length, 0.014 / scales.velocity, np.radians(2) * scales.r / scales.length, 0.0)
    run = ss.simulate(
        MODEL_SI,
        belt_speed=0.014 / scales.velocity,
        initial=start,
        t_end=0.9 / scales.time,
        t_eval=[0.9 / scales.time],
    )
    assert frame["x1 [um]"].iloc[-1] == pytest.approx(run.state[-1, 0] * scales.length * 1e6, abs=1e-5)
    turned = np.degrees(run.state[-1, 2] * scales.length / scales.r)
    assert frame["y1 [deg]"].iloc[-1] == pytest.approx(turned, abs=1e-7)


def test_what_simulate_wrote_can_be_read_as_a_recording(tmp_path):
    channels = {name: Channel(name, unit) for name, unit in (("t", "s"), ("x1", "mm"), ("y1", "mm"))}
    model = dataclasses.replace(MODEL_SI, channels=channels)
    _, frame = simulated(tmp_path, model, "--belt-speed", "14 mm/s", "--t-end", "9")
    read = ss.load_recording(tmp_path / "run.csv", model.rig, channels=channels, belt_speed="14 mm/s")
    np.testing.assert_allclose(read.x1 * model.rig.scales.length * 1e3, frame["x1 [mm]"], rtol=1e-12)
    wrong = {**channels, "y1": Channel("y1", "um")}
    with pytest.raises(ss.InputError, match=r"the file has 'y1 \[mm\]', but its channel is declared in 'um'"):
        ss.load_recording(tmp_path / "run.csv", model.rig, channels=wrong, belt_speed="14 mm/s")


def test_simulate_says_that_friction_drives(tmp_path):
    model = MODEL_SI.with_effects([ss.effect("friction_drift", r=-0.05)])
    said, _ = simulated(tmp_path, model, "--belt-speed", 0.014, "--t-end", "40 1")
    assert "friction_drift.r = -0.05: 1 + r t is below 0 from t = 20" in said


def test_identify_then_compare(folder, tmp_path):
    result = stickslip("identify", folder / "rig.toml", "--out", tmp_path / "found")
    assert result.exit_code == 0, result.output
    assert "T_s_minus" in result.output
    saved = json.loads((tmp_path / "found" / "identified.json").read_text())
    assert saved["estimates"]["T_s_minus"]["value"] == pytest.approx(TRUE.T_s_minus, abs=0.05)
    model = ss.load_model(tmp_path / "found" / "model.toml")
    assert model.friction.T_s_minus == saved["estimates"]["T_s_minus"]["value"]
    assert model.channels == ss.load_case(folder).channels
    result = stickslip("compare", tmp_path / "found", folder, "--run", "b", "--out", tmp_path / "compared")
    assert result.exit_code == 0, result.output
    rows = json.loads((tmp_path / "compared" / "compare.json").read_text())["rows"]
    period = next(r for r in rows if r["quantity"] == "period")
    assert period["simulated"] == pytest.approx(period["measured"], rel=0.02)
    assert (tmp_path / "compared" / "phase_portrait.svg").exists()


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["simulate", "nowhere.toml", "--belt-speed", 0.1, "--t-end", 1, "--out", "{out}"], "no such file"),
        (["simulate", "{model}", "--belt-speed", 0.1, "--t-end", -1, "--out", "{out}"], "--t-end"),
        (["simulate", "{model}", "--belt-speed", "nan", "--t-end", 1, "--out", "{out}"], "--belt-speed"),
        (["simulate", "{model}", "--belt-speed", 0.1, "--t-end", 1, "--dt", 2, "--out", "{out}"], "--dt"),
        (
            ["simulate", "{model}", "--belt-speed", 0.1, "--t-end", 1, "--initial", "a,b", "--out", "{out}"],
            "--initial",
        ),
        (["identify", "{model}", "--out", "{out}"], "model.toml"),
        (["identify", "{run}", "--out", "{out}"], "give the rig.toml beside it"),
        (["compare", "{case}", "{model}", "--out", "{out}"], "the model comes first"),
        (["compare", "{folder}", "{case}", "--out", "{out}"], "a folder without model_after.toml"),
        (["simulate", "{case}", "--belt-speed", 0.1, "--t-end", 1, "--out", "{out}"], "identify or discover"),
        (
            ["simulate", "{si}", "--belt-speed", "14 mm", "--t-end", 1, "--out", "{out}"],
            "measures length, but this is a velocity",
        ),
        (["simulate", "{si}", "--belt-speed", 0.01, "--t-end", "9 m", "--out", "{out}"], "this is a time"),
        (
            [
                "simulate",
                "{si}",
                "--belt-speed",
                0.01,
                "--t-end",
                1,
                "--initial",
                "1 s,0,0,0",
                "--out",
                "{out}",
            ],
            "this is a displacement",
        ),
        (["simulate", "{model}", "--belt-speed", 0.1, "--t-end", 1], "missing option '--out'"),
        (["identfy", "{case}", "--out", "{out}"], "no such command 'identfy'"),
        (["compare", "{model}", "{case}", "--run", "c", "--out", "{out}"], "unknown run 'c'"),
        (["identify", "{case}", "--out", ""], "invalid value for '--out': is empty"),
        (["discover", " ", "--out", "{out}"], "invalid value for 'CASE': is empty"),
        (["sweep", "{case}", "--out", ""], "invalid value for '--out': is empty"),
        (["forecast", "", "{run}", "--belt-speed", 1, "--horizon", 1, "--out", "{out}"], "'MODEL': is empty"),
    ],
)
def test_bad_input_is_one_line_exit_2_and_nothing_written(folder, tmp_path, arguments, said):
    names = {
        "model": folder / "model.toml",
        "case": folder / "rig.toml",
        "run": folder / "a.csv",
        "folder": tmp_path,
        "si": folder / "si.toml",
        "out": tmp_path / "out",
    }
    result = stickslip(*(str(a).format(**names) for a in arguments))
    assert result.exit_code == 2
    assert said in result.stderr
    assert result.stderr.count("\n") == 1
    assert not (tmp_path / "out").exists()


def test_a_failed_write_leaves_what_was_there(folder, tmp_path, monkeypatch):
    out = tmp_path / "run.csv"
    out.write_text("old")

    def broken(*_args, **_keywords):
        raise ss.InputError("disk full")

    monkeypatch.setattr(pd.DataFrame, "to_csv", broken)
    result = stickslip("simulate", folder / "model.toml", "--belt-speed", 0.1, "--t-end", 1, "--out", out)
    assert result.exit_code == 2
    assert out.read_text() == "old"
    assert [p.name for p in tmp_path.iterdir()] == ["run.csv"]


@pytest.mark.study
def test_demo_ends_with_the_law_the_comparison_and_the_paths(tmp_path):
    result = stickslip("demo", "--first-half", "--out", tmp_path)
    assert result.exit_code == 0, result.output
    saved = json.loads((tmp_path / "identified.json").read_text())
    readme = (Path(__file__).parent.parent / "README.md").read_text().replace("\n", " ")
    told = re.search(
        r"coefficient of ([\d.]+) at breakaway and ([\d.]+) in sliding, from (\d+) slips", readme
    )
    said = " ".join(result.output.split())
    assert f"coefficient {told[1]} at breakaway, {told[2]} in sliding" in said
    assert f"{told[3]} slips in the first part" in said
    weight = 30.7e-3 * 9.81
    # paper on paper: the spring force was 0.25 to 0.42 of the weight at breakaway
    assert 0.33 < saved["diagnostics"]["static_mean"] / weight < 0.40
    assert saved["diagnostics"]["kinetic_mean"] < saved["diagnostics"]["static_mean"]
    assert saved["diagnostics"]["events"] > 40
    rows = {r["quantity"]: r for r in json.loads((tmp_path / "compare.json").read_text())["rows"]}
    assert rows["period"]["measured"] == pytest.approx(0.147, abs=0.01)  # as the eye counts in the figure
    assert rows["small slips left out"]["measured"] > 5
    verdict = next(line for line in result.output.splitlines() if line.startswith("- forecast"))
    assert "useless" in verdict
    for name in ("slip amplitude", "largest slip speed", "period"):
        assert abs(rows[name]["difference"]) < 1.5 * rows[name]["scatter"]
    for name in ("friction_characteristic", "phase_portrait", "time_series"):
        assert (tmp_path / f"{name}.svg").stat().st_size > 5000
        assert f"{name}.png" in result.output


def test_identify_refuses_what_discover_refuses_and_writes_nothing(tmp_path):
    """Millimetres declared as metres ended in a word about T_min_plus, which nobody had typed."""
    path = found_by_hand.write_case(tmp_path, si=True)
    text = path.read_text(encoding="utf-8")
    path.write_text(text.replace('"x1", unit = "mm"', '"x1", unit = "m"'), encoding="utf-8")
    result = stickslip("identify", path, "--out", tmp_path / "out")
    assert result.exit_code == 2
    assert re.match(r"stickslip: channel x1 reads \d+ times what y1 asks for .* with 'mm' it", result.stderr)
    assert result.stderr.count("\n") == 1
    assert not (tmp_path / "out").exists()
    with pytest.raises(ss.InputError, match="channel x1 reads"):
        ss.identify(ss.load_case(path))


def test_names_in_brackets_are_printed_in_the_messages_of_identify(tmp_path):
    """The terminal took [friction] for a colour, and left it out."""
    path = found_by_hand.write_case(tmp_path, si=True, extra='[friction]\nkind = "paper"\nA1 = 0.05\n')
    out = stickslip("identify", path, "--out", tmp_path / "out").stdout
    assert "A1 stopped at ten times the declared value" in " ".join(out.split())
    assert "nearer to it in [friction]" in " ".join(out.split())


def test_identify_of_an_si_case_prints_newtons(tmp_path):
    model = MODEL_SI.replace(T_s_minus=6.1)
    scales, channels = (
        model.rig.scales,
        {n: Channel(n, u) for n, u in (("t", "s"), ("x1", "mm"), ("y1", "mm"))},
    )
    rng, t = np.random.default_rng(1), np.arange(3000) * 0.02
    for name, speed in (("a", 0.1), ("b", -0.09)):
        run = ss.simulate(model, belt_speed=speed, initial=(0.1, 0.1, 0, 0), t_end=t[-1], t_eval=t)
        x = 1e3 * scales.length * (run.state[:, ::2] + 8e-4 * rng.standard_normal((len(t), 2)))
        frame = pd.DataFrame({"t": t * scales.time, "x1": x[:, 0], "y1": x[:, 1]})
        frame.to_csv(tmp_path / f"{name}.csv", index=False)
    runs = [
        ss.load_recording(
            tmp_path / f"{name}.csv", model.rig, channels=channels, belt_speed=speed * scales.velocity
        )
        for name, speed in (("a", 0.1), ("b", -0.09))
    ]
    found = ss.identify(runs, rig=model.rig)
    rows = {row["parameter"]: row for row in found.table()}
    assert rows["T_s_minus"]["unit"] == "N"
    assert float(rows["T_s_minus"]["value"]) == pytest.approx(6.1 * scales.force, rel=0.01)
    assert float(rows["T_s_minus"]["model"]) == pytest.approx(6.1, rel=0.01)
    assert rows["t2"]["unit"] == "m/s"
    low, _, high = rows["t2"]["95 % interval"].partition(" .. ")
    assert float(low) < found.law.t2 * scales.velocity < float(high)
    assert "N" in found.summary()
    assert found.model.channels == channels


def test_the_package_runs_as_the_command() -> None:
    asked = [sys.executable, "-m", "stickslip", "--version"]
    done = subprocess.run(asked, capture_output=True, text=True, check=True)
    assert done.stdout == f"stickslip, version {ss.__version__}\n"
