"""The command line as a person meets it."""

import json

import numpy as np
import pandas as pd
import pytest
from click.testing import CliRunner

import stickslip as ss
from stickslip.cli import main
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
    return at


@pytest.mark.parametrize(
    "command", ["simulate", "identify", "compare", "discover", "forecast", "sweep", "demo"]
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
    assert sorted(p.name for p in tmp_path.iterdir()) == ["run.csv", "run.png", "run.svg"]


def test_identify_then_compare(folder, tmp_path):
    result = stickslip("identify", folder / "rig.toml", "--out", tmp_path / "found")
    assert result.exit_code == 0, result.output
    assert "T_s_minus" in result.output
    saved = json.loads((tmp_path / "found" / "identified.json").read_text())
    assert saved["estimates"]["T_s_minus"]["value"] == pytest.approx(TRUE.T_s_minus, abs=0.05)
    model = ss.load_model(tmp_path / "found" / "model.toml")
    assert model.friction.T_s_minus == saved["estimates"]["T_s_minus"]["value"]
    assert model.channels == ss.load_case(folder).channels
    result = stickslip(
        "compare", tmp_path / "found" / "model.toml", folder, "--run", "b", "--out", tmp_path / "compared"
    )
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
        (["simulate", "{model}", "--belt-speed", "nan", "--t-end", 1, "--out", "{out}"], "belt_speed"),
        (["simulate", "{model}", "--belt-speed", 0.1, "--t-end", 1, "--dt", 2, "--out", "{out}"], "--dt"),
        (
            ["simulate", "{model}", "--belt-speed", 0.1, "--t-end", 1, "--initial", "a,b", "--out", "{out}"],
            "--initial",
        ),
        (["identify", "{model}", "--out", "{out}"], "model.toml"),
        (["compare", "{model}", "{case}", "--run", "c", "--out", "{out}"], "unknown run 'c'"),
    ],
)
def test_bad_input_is_one_line_exit_2_and_nothing_written(folder, tmp_path, arguments, said):
    names = {"model": folder / "model.toml", "case": folder / "rig.toml", "out": tmp_path / "out"}
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


def test_demo_ends_with_the_law_the_comparison_and_the_paths(tmp_path):
    result = stickslip("demo", "--first-half", "--out", tmp_path)
    assert result.exit_code == 0, result.output
    saved = json.loads((tmp_path / "identified.json").read_text())
    weight = 30.7e-3 * 9.81
    # paper on paper: the spring force was 0.25 to 0.42 of the weight at breakaway
    assert 0.33 < saved["diagnostics"]["static_mean"] / weight < 0.40
    assert saved["diagnostics"]["kinetic_mean"] < saved["diagnostics"]["static_mean"]
    assert saved["diagnostics"]["events"] > 40
    rows = {r["quantity"]: r for r in json.loads((tmp_path / "compare.json").read_text())["rows"]}
    for name in ("slip amplitude", "largest slip speed", "period"):
        assert abs(rows[name]["difference"]) < 1.5 * rows[name]["scatter"]
    for name in ("friction_characteristic", "phase_portrait", "time_series"):
        assert (tmp_path / f"{name}.svg").stat().st_size > 5000
        assert f"{name}.png" in result.output
