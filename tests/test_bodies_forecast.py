"""`forecast` and `compare` on rigs of bodies and matrices, against records of a simulator written apart."""

from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from click.testing import CliRunner
from numpy.typing import NDArray

import stickslip as ss
from bodies_cases import CASES, one_block, recorded, recording
from bodies_files import written
from stickslip.cli.commands import main
from stickslip.errors import InputError
from studies import few

Floats = NDArray[np.float64]
PAST, AHEAD = {"pin": 4.0, "drill": 15.0}, {"pin": 0.6, "drill": 3.0}


def cut(name: str, seed: int, scatter: float) -> tuple[ss.Recording, Floats, pd.DataFrame]:
    """A past, the readings that follow it, and the forecast of these."""
    case = CASES[name]()
    t, readings = recorded(case, seed, level=scatter, static=scatter, lasts=PAST[name] + AHEAD[name])
    past = t < PAST[name]
    run = recording(case, t[past], readings[past])
    frame = ss.forecast(case.model, run, horizon=AHEAD[name])
    return run, readings[past.sum() : past.sum() + len(frame)], frame


@pytest.mark.parametrize("name", few(PAST, ["pin"]))
def test_the_band_holds_what_follows(name: str) -> None:
    inside = []
    for seed in (11, 12):
        run, true, frame = cut(name, seed, 0.02)
        assert list(frame)[: 1 + true.shape[1]] == ["t", *run.coordinates]
        assert frame["t"].iloc[0] == pytest.approx(run.t[-1] + np.median(np.diff(run.t)))
        for k, channel in enumerate(run.coordinates):
            low, high = frame[f"{channel}_low"], frame[f"{channel}_high"]
            inside.append(float(np.mean((true[:, k] > low) & (true[:, k] < high))))
    assert np.mean(inside) > 0.85  # four records: the mean of 0.95 scatters by about 0.04


def test_friction_that_repeats_is_foretold_to_the_noise() -> None:
    run, true, frame = cut("pin", 21, 0.0)
    for k, channel in enumerate(run.coordinates):
        off = np.sqrt(np.mean((frame[channel] - true[:, k]) ** 2)) / np.std(true[:, k])
        assert off < 0.1
        width = float((frame[f"{channel}_high"] - frame[f"{channel}_low"]).mean()) / float(np.std(true[:, k]))
        assert width < 0.35  # with 2 % of scatter it is about 0.6


def test_a_right_model_compares_well_and_a_wrong_one_does_not() -> None:
    case = CASES["pin"]()
    run = recording(case, *recorded(case, 7, level=0.02, static=0.02, lasts=3.0))
    right, wrong = (ss.compare(model, run) for model in (case.model, case.model.replace(static=5.0)))
    assert isinstance(right, ss.RigComparison)
    for row in right.rows[:3]:
        assert row.measured is not None
        assert row.simulated == pytest.approx(row.measured, rel=0.1), row.quantity
    between = wrong.row("time between slips of contact_1")
    assert between.difference is not None
    assert between.difference > 0.03  # the spring must be drawn out 1 N further, at 40 N/s
    error, worse = (one.row("forecast error").simulated for one in (right, wrong))
    assert error is not None
    assert worse is not None
    assert error < 0.2 < worse
    assert right.row("noise left").simulated == pytest.approx(1.0, abs=0.2)
    assert "one event ahead the model errs by" in str(right)


def test_the_commands(tmp_path: Path) -> None:
    case = CASES["pin"]()
    folder = tmp_path / "case"
    folder.mkdir()
    written(folder, [("validate", *recorded(case, 8, level=0.02, static=0.02, lasts=2.0))])
    loaded = ss.load_case(folder)
    loaded.model(friction=ss.CoulombFriction(static=4.0, kinetic=2.0)).save(tmp_path / "model.toml")
    said = CliRunner().invoke(
        main, ["compare", str(tmp_path / "model.toml"), str(folder), "--out", str(tmp_path / "compared")]
    )
    assert said.exit_code == 0, said.output
    assert (tmp_path / "compared" / "time_series.png").is_file()
    asked = ["forecast", str(tmp_path / "model.toml"), str(folder / "run_1.csv"), "--belt-speed", "50 mm/s"]
    out = tmp_path / "next.csv"
    said = CliRunner().invoke(main, [*asked, "--horizon", "200", "--out", str(out), "--figure"])
    assert said.exit_code == 0, said.output
    frame = pd.read_csv(out)
    assert list(frame) == ["t", "along", "across", "along_low", "along_high", "across_low", "across_high"]
    assert len(frame) == 100  # 200 ms, the unit of the run's time, at 2 ms
    assert 1.0 < frame["along"].abs().max() < 10.0  # mm


def test_another_rig_and_a_short_past_are_refused() -> None:
    pin, drill = CASES["pin"](), CASES["drill"]()
    t = np.arange(0.0, 1.0, 0.01)
    run = recording(drill, t, np.column_stack([t, t]))
    with pytest.raises(InputError, match="was recorded on another rig"):
        ss.forecast(pin.model, run, horizon=1.0)
    with pytest.raises(InputError, match="was recorded on another rig"):
        ss.compare(pin.model, run)
    with pytest.raises(InputError, match="gives 0 samples"):
        ss.forecast(drill.model, run, horizon=1e-4)


@pytest.mark.parametrize("how", ["static_aging", "formula"])
def test_a_limit_that_grows_in_rest_begins_anew_in_every_stick(how: str) -> None:
    """What is to come is a simulation of the true model, whose sticks each begin at no time at rest."""
    rig = one_block()
    if how == "static_aging":
        law: ss.FrictionLaw = ss.CoulombFriction(static=2.0, kinetic=1.2)
        model = ss.Model(rig, friction=law, effects=[ss.effect("static_aging", where="x", dT=0.4, tau=0.3)])
    else:
        law = ss.FormulaFriction(
            kinetic="Fc", static="Fs*(1 + b*log(1 + dwell/tau))", Fc=1.2, Fs=1.8, b=0.02, tau=0.1
        )
        model = ss.Model(rig, friction=law)
    t = np.arange(1400) * 0.004
    run = ss.simulate(model, belt_speed=0.01, initial=(3e-4, 0.01), t_end=t[-1], t_eval=t)
    x = run.state[:, 0] + np.random.default_rng(0).normal(0, 4e-6, t.size)
    past = 1000
    told = {"t": t[:past], "x": x[:past]}
    recording = ss.load_recording(told, rig, belt_speed=0.01, noise={"x": 4e-6})
    found = ss.forecast(model, recording, belt_speed=0.01, horizon=1.5)
    true = run.state[past : past + len(found), 0]
    assert np.sqrt(np.mean((found["x"] - true) ** 2)) < 0.02 * np.std(
        true
    )  # with rests that add up 0.1 to 0.5


def test_a_law_with_a_state_of_its_own_is_refused_in_a_sentence() -> None:
    case = CASES["pin"]()
    numbers = {"Fc": 2.0, "Fs": 4.0, "h": 0.6, "vs": 0.03, "tau": 0.02}
    states = {"w": {"rate": "(exp(-u/vs) - w)/tau", "start": 0.0}}
    law = ss.FormulaFriction(kinetic="Fc + h*w", static="Fs", states=states, **numbers)
    run = recording(case, *recorded(case, 7, level=0.02, static=0.02, lasts=2.0))
    model = ss.Model(case.model.rig, friction=law)
    with pytest.raises(InputError, match="a law with states of its own can be simulated"):
        ss.forecast(model, run, horizon=0.5)
    with pytest.raises(InputError, match="a law with states of its own can be simulated"):
        ss.compare(model, run)
    with pytest.raises(InputError, match="a law with states of its own can be simulated"):
        ss.identify(run, rig=model.rig, friction=law)
