"""Forecasts and comparisons of a driven slider, on records of a program of its own (`driven_truth`)."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from click.testing import CliRunner, Result

import driven_truth as truth
import stickslip as ss
from stickslip.cli.commands import main
from stickslip.errors import InputError
from test_driven_simulate import LAW, model

CHANNELS = {
    "t": ss.Channel("t", "s"),
    "x1": ss.Channel("x", "mm"),
    "drive": ss.Channel("u", "V", scale=truth.GAIN),
}


def invoke(*arguments: object) -> Result:
    return CliRunner().invoke(main, [str(a) for a in arguments])


def recorded(seconds: float, seed: int = 0) -> ss.Recording:
    """A closed loop with force noise."""
    t, x, u = truth.record(seconds, seed=seed)
    rig = ss.DrivenSlider(mass=truth.MASS, damping=truth.DAMPING)
    return ss.load_recording({"t": t, "x": 1e3 * x, "u": u}, rig, channels=CHANNELS)


def cut(run: ss.Recording, count: int) -> ss.Recording:
    assert run.drive is not None
    return replace(run, t=run.t[:count], x1=run.x1[:count], drive=run.drive[:count])


def test_the_band_holds_the_readings_to_come_as_often_as_it_says() -> None:
    held, off, still = [], [], []
    for seed in range(3):
        run = recorded(6.0, seed)
        for count in range(900, 2800, 300):
            past, ahead = cut(run, count), 100
            frame = ss.forecast(model(), past, drive=(run.t, run.drive), horizon="0.2 s")
            assert [*frame.columns] == ["t", "x1", "x1_low", "x1_high"]
            np.testing.assert_allclose(frame["t"], run.t[count : count + ahead], atol=1e-9)
            x = 1e3 * run.x1[count : count + ahead]
            held.append(((x >= frame["x1_low"]) & (x <= frame["x1_high"])).mean())
            off.append(abs(frame["x1"].iloc[-1] - x[-1]))
            still.append(abs(x[-1] - x[0]))
    assert 0.85 < np.mean(held) <= 1.0, held
    assert np.mean(off) < 0.25 * np.mean(still)


def test_without_noise_it_is_what_the_slider_does() -> None:
    t, x, u = truth.record(3.0, noise=0.0, step=1e-12)
    rig = ss.DrivenSlider(mass=truth.MASS, damping=truth.DAMPING)
    run = ss.load_recording({"t": t, "x": 1e3 * x, "u": u}, rig, channels=CHANNELS)
    frame = ss.forecast(model(), cut(run, 900), drive=(run.t, run.drive), horizon=0.6)
    np.testing.assert_allclose(frame["x1"], 1e3 * x[900:1200], atol=1e-4)


def test_a_lagging_drive_goes_on_lagging() -> None:
    """Hidden states are taken from the past."""
    lagged = model(ss.effect("drive_lag", tau=0.05))
    t = np.arange(1200) / truth.RATE
    force = 25 * np.sign(np.sin(7 * t))
    run = ss.simulate(lagged, drive=(t, force), t_end=t[-1], t_eval=t)
    source = {"t": t, "x": 1e3 * run.x1, "u": force / truth.GAIN}
    whole = ss.load_recording(source, lagged.rig, channels=CHANNELS)
    frame = ss.forecast(
        lagged, cut(whole, 905), drive=(t, force), horizon=0.4
    )  # just after a jump of the drive
    np.testing.assert_allclose(frame["x1"], 1e3 * run.x1[905 : 905 + len(frame)], atol=1e-6)


def test_compare_tells_a_good_model_from_a_bad_one() -> None:
    run = recorded(6.0)
    good = ss.compare(model(), run)
    bad = ss.compare(replace(model(), friction=ss.CoulombFriction(static=2.0, kinetic=2.0)), run)
    errors = [one.row("forecast error").simulated for one in (good, bad)]
    assert errors[0] is not None
    assert errors[1] is not None
    assert errors[0] < 0.2
    assert errors[1] > 2 * errors[0]
    assert "ahead the model errs by" in good.verdict()[0]
    row = good.row("largest speed")
    fastest = np.quantile(np.abs(np.gradient(run.x1, 1 / truth.RATE)), 0.999)
    assert row.measured == pytest.approx(fastest, rel=0.05)
    assert row.simulated == pytest.approx(fastest, rel=0.1)
    assert len(good.t) == len(good.readings) == len(good.simulated)
    assert good.to_dict()


def test_the_largest_speed_is_that_of_an_uneven_record_too() -> None:
    """It was taken to be sampled as its first two samples are."""
    generator = np.random.default_rng(3)
    t = np.sort(generator.uniform(0, 8, 3000))
    run = ss.simulate(model(), drive="25*sin(3*t)", t_end=8.0, t_eval=t)
    source = {"t": t, "x": 1e3 * run.x1, "u": 25 * np.sin(3 * t) / truth.GAIN}
    compared = ss.compare(model(), ss.load_recording(source, model().rig, channels=CHANNELS))
    assert compared.row("largest speed").measured == pytest.approx(np.abs(run.x2).max(), rel=0.03)


def test_a_record_at_rest_cannot_be_compared() -> None:
    t = np.arange(600) / truth.RATE
    source = {"t": t, "x": np.zeros(600), "u": np.full(600, 0.1)}
    with pytest.raises(InputError, match="at the same place at the end of every piece"):
        ss.compare(model(), ss.load_recording(source, model().rig, channels=CHANNELS))


def test_the_commands_take_what_discover_writes(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    t, x, u = truth.record(4.0)
    pd.DataFrame({"t": t, "x": 1e3 * x, "u": u}).to_csv("run.csv", index=False)
    Path("rig.toml").write_text(truth.RIG.replace("17.4", "2.4"))
    whole = model(
        ss.tabulated("contact", "x1", [0.0, 0.1, 0.2], [0.0, 0.2, 0.1]), ss.effect("drive_lag", tau=0.01)
    )
    replace(whole, channels=CHANNELS).save("model.toml")
    for given in (
        ("simulate", "model.toml", "--drive", "run.csv", "--t-end", "3 s", "--out", "again.csv", "--figure"),
        ("simulate", "model.toml", "--drive", "25*sin(7*t)", "--t-end", "3 s", "--out", "sine.csv"),
        ("forecast", "model.toml", "run.csv", "--drive", "5 N", "--horizon", "0.1", "--out", "next.csv"),
        ("compare", "model.toml", "rig.toml", "--out", "compared"),
    ):
        result = invoke(*given)
        assert result.exit_code == 0, result.output
    again = pd.read_csv("again.csv")
    run = ss.simulate(whole, drive=(t, truth.GAIN * u), t_end=3.0, t_eval=np.linspace(0, 3, 2001))
    np.testing.assert_allclose(again["x1 [mm]"], 1e3 * run.x1, atol=1e-6)
    following = pd.read_csv("next.csv")
    assert len(following) == 50
    assert (following["x1_low"] < following["x1_high"]).all()
    assert Path("compared/phase_portrait.png").exists()
    Path("sweep.toml").write_text(
        "model = 'model.toml'\n[sweep]\nt_end = 2.0\ndrive = '25*sin(7*t)'\n[over]\nmass = [10.0, 12.0]\n"
    )
    # a run that begins at 100 s acts from the start; a force to come needs no position
    pd.DataFrame({"t": t + 100, "u": u}).to_csv("later.csv", index=False)
    assert (
        invoke(
            "simulate", "model.toml", "--drive", "later.csv", "--t-end", "3 s", "--out", "later_x.csv"
        ).exit_code
        == 0
    )
    pd.testing.assert_frame_equal(pd.read_csv("later_x.csv"), again)
    asked = ("forecast", "model.toml", "run.csv", "--horizon", "0.1", "--out", "n.csv", "--drive")
    result = invoke(*asked, "later.csv")
    assert result.exit_code == 0, result.output
    result = invoke(*asked, "run.csv")
    assert result.exit_code == 2
    assert "and what is forecast begins after" in result.stderr
    pytest.importorskip("zarr")
    result = invoke("sweep", "sweep.toml", "--out", "result.zarr")
    assert result.exit_code == 0, result.output


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ({"horizon": 0.1}, "drive: missing"),
        ({"horizon": -1.0, "drive": 1.0}, "horizon"),
        ({"horizon": 0.1, "drive": 1.0, "belt_speed": 0.1}, "neither belt nor spring"),
        ({"horizon": 1e7, "drive": 1.0}, "can be forecast"),
    ],
)
def test_what_cannot_be_forecast_is_said_in_a_line(given: dict[str, float], words: str) -> None:
    with pytest.raises(InputError, match=words):
        ss.forecast(model(), cut(recorded(1.0), 400), **given)
    with pytest.raises(InputError, match="samples; 36 are needed"):
        ss.forecast(model(), cut(recorded(1.0), 20), drive=1.0, horizon=0.1)
    other = ss.Model(ss.BlockOnBelt(), friction=LAW)
    with pytest.raises(InputError, match="no force moves this rig"):
        ss.forecast(other, cut(recorded(1.0), 400), drive=1.0, horizon=0.1)
