"""The law of a driven slider: records moved in closed form or by SciPy, whose truth is known; the search's own fit."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
import scipy
from click.testing import CliRunner

import driven_truth as truth
import stickslip as ss
from stickslip.cli.commands import main
from stickslip.errors import InputError
from stickslip.fitted.identified import Identified

TRUE = {
    "mass": truth.MASS,
    "damping": truth.DAMPING,
    "kinetic": truth.MINUS,
    "kinetic_plus": truth.PLUS,
}
RATE = 250.0
SI = {"t": ss.Channel("t", "s"), "x1": ss.Channel("x", "m"), "drive": ss.Channel("F", "N")}
SHORT = {"seconds": 9.0, "train": 6.0}


def recorded(
    t: np.ndarray, x: np.ndarray, force: np.ndarray, mass: float = truth.MASS, channels=SI
) -> ss.Recording:
    names = {name: one.column for name, one in channels.items()}
    columns = {names["t"]: t, names["x1"]: x, names["drive"]: force}
    return ss.load_recording(columns, ss.DrivenSlider(mass=mass), channels=channels)


def open_loop(seed: int, seconds: float = 5.0, noise: float = 0.2, reading: float = 2e-6) -> tuple:
    """Times, positions and drive (n,) of a slider that three sines push; the force noise is white."""
    generator = np.random.default_rng(seed)
    t = np.arange(round(seconds * RATE)) / RATE
    drive = 15 * np.sin(2.2 * t) + 8 * np.sin(8 * t + 1) + 5 * np.sin(31 * t + 2)
    x = v = 0.0
    out = np.empty(len(t))
    for k, force in enumerate(drive):
        out[k] = x
        x, v = truth.moved(x, v, force + noise * generator.standard_normal(), 1 / RATE)
    return t, out + reading * generator.standard_normal(len(t)), drive


def by_scipy(t: np.ndarray, drive: np.ndarray) -> np.ndarray:
    """Positions (n,) under a drive that is held, by an adaptive integrator that stops where the slider does."""

    def slides(way: float, force: float):
        level = truth.PLUS if way > 0 else truth.MINUS
        return lambda _, s: [s[1], (force - truth.DAMPING * s[1] - way * level) / truth.MASS]

    def stops(_, s):
        return s[1]

    stops.terminal = True
    out, state = np.empty(len(t)), np.zeros(2)
    for k, force in enumerate(drive):
        out[k] = state[0]
        now, end = 0.0, t[1] - t[0]
        while now < end:
            way = np.sign(state[1])
            if way == 0:
                if -truth.MINUS <= force <= truth.PLUS:
                    break
                way = np.sign(force)
                state = np.array([state[0], way * 1e-14])
            stops.direction = -way
            run = scipy.integrate.solve_ivp(
                slides(way, force), (now, end), state, events=stops, rtol=1e-9, atol=1e-13
            )
            now, state = run.t[-1], run.y[:, -1]
            if run.status == 1:
                state[1] = 0.0
    return out


@pytest.fixture(scope="module")
def case(tmp_path_factory: pytest.TempPathFactory) -> ss.Case:
    return ss.load_case(truth.write_case(tmp_path_factory.mktemp("slider"), **SHORT))


@pytest.fixture(scope="module")
def found(case: ss.Case) -> Identified:
    return ss.identify(case)


def test_the_law_the_mass_and_their_intervals_are_those_of_the_truth(found: Identified) -> None:
    for name, true in TRUE.items():
        one = found.estimates[name]
        assert one.status == "identified"
        assert one.value == pytest.approx(true, rel=0.03), name
        assert one.low < one.value < one.high
        assert abs(one.value - true) < 3.5 * one.std, name
        assert (one.high - one.low) / 3.92 == pytest.approx(one.std, rel=0.15)
    assert found.estimates["kinetic"].declared == 6.0
    assert found.constants["mass"].declared == truth.MASS
    assert found.reduced_chi2 == pytest.approx(1, abs=0.1)
    assert found.noise["drive"] == pytest.approx(0.25, rel=0.15)
    units = {row["parameter"]: row["unit"] for row in found.table()}
    assert units == {
        **dict.fromkeys(("static", "kinetic", "static_plus", "kinetic_plus"), "N"),
        "mass": "kg",
        "damping": "N s/m",
    }


@pytest.mark.slow
def test_what_it_says_is_the_fit_of_the_declared_law_that_a_search_begins_with(
    case: ss.Case, found: Identified
) -> None:
    searched = ss.discover(case)
    for name, one in searched.law_before.items():
        own = found.estimates[name]
        assert (own.value, own.low, own.high) == (one.value, one.low, one.high)
    assert found.model == searched.before
    assert found.diagnostics["held_out_force"] == searched.error.before
    (run,) = searched.error.runs
    assert found.diagnostics["held_out_position"] == pytest.approx(1e-3 * run.rmse["x1"]["before"])


def test_a_record_by_an_adaptive_integrator_gives_its_numbers_back() -> None:
    t = np.arange(1200) / RATE
    drive = 16 * np.sin(2.2 * t) + 8 * np.sin(8 * t + 1) + 5 * np.sin(31 * t + 2)
    x = by_scipy(t, drive) + 1e-7 * np.random.default_rng(0).standard_normal(len(t))
    found = ss.identify(recorded(t, x, drive))
    for name, true in TRUE.items():
        assert found.estimates[name].value == pytest.approx(true, rel=2e-3), name
        assert abs(found.estimates[name].value - true) < 3.5 * found.estimates[name].std


def test_intervals_hold_the_truth_as_often_as_they_say() -> None:
    off = []
    for seed in range(8):
        estimates = ss.identify(recorded(*open_loop(seed))).estimates
        off.append([(estimates[n].value - true) / estimates[n].std for n, true in TRUE.items()])
    z = np.array(off)
    assert 0.5 < np.mean(z**2) < 1.7
    assert np.mean(np.abs(z) < 1.96) > 0.85


@pytest.mark.parametrize(
    ("units", "sizes"),
    [(("s", "mm", "N"), (1.0, 1e3, 1.0)), (("ms", "um", "mN"), (1e3, 1e6, 1e3))],
)
def test_units_of_the_columns_do_not_matter(units, sizes) -> None:
    t, x, force = open_loop(3)
    plain = ss.identify(recorded(t, x, force))
    channels = {
        name: ss.Channel(one.column, unit) for (name, one), unit in zip(SI.items(), units, strict=True)
    }
    columns = [one * size for one, size in zip((t, x, force), sizes, strict=True)]
    other = ss.identify(recorded(*columns, channels=channels))
    for name in TRUE:
        for side in ("value", "low", "high"):
            assert getattr(other.estimates[name], side) == pytest.approx(
                getattr(plain.estimates[name], side), rel=1e-4
            )


def test_without_units_the_numbers_are_bare() -> None:
    bare = {name: ss.Channel(one.column, "1") for name, one in SI.items()}
    t, x, force = open_loop(3)
    found = ss.identify(recorded(t, x, force, channels=bare))
    assert found.estimates["mass"].value == pytest.approx(truth.MASS, rel=0.02)
    assert all("unit" not in row for row in found.table())
    (noise,) = [one for one in found.messages if one.startswith("Noise")]
    assert noise.endswith(" of the readings.")
    assert " N " not in noise


def test_the_model_goes_through_its_file_and_is_compared_and_forecast(
    case: ss.Case, found: Identified, tmp_path: Path
) -> None:
    found.save(tmp_path / "out")
    model = ss.load_model(tmp_path / "out" / "model.toml")
    assert model == found.model
    run = ss.simulate(model, drive="20*sin(6*t)", t_end=1.0)
    assert run.x1.max() > 0
    compared = ss.compare(model, case.validate[0])
    assert compared.rows[-1].simulated < 0.05
    ahead = ss.forecast(model, case.validate[0], drive=5.0, horizon=0.1)
    assert (ahead["x1_low"] < ahead["x1"]).all()


def test_the_band_is_as_wide_as_the_interval_of_friction(found: Identified) -> None:
    u = np.linspace(0, 0.1, 5)
    for branch, name in (("minus", "kinetic"), ("plus", "kinetic_plus")):
        low, value, high = found.band(branch, u, simultaneous=False)
        np.testing.assert_allclose(value, found.estimates[name].value)
        np.testing.assert_allclose((high - low) / 3.92, found.estimates[name].std, rtol=0.1)


def test_a_law_that_explains_and_one_that_does_not(found: Identified, tmp_path: Path) -> None:
    assert not any("does not explain" in one for one in found.messages)
    assert any("explains more of what the law leaves than noise does" in one for one in found.messages)
    ripple = {"force": lambda x, _: 0.8 * np.sin(2 * np.pi * x / 0.004 + 1)}
    rippled = ss.identify(ss.load_case(truth.write_case(tmp_path, **SHORT, **ripple)))
    (said,) = [one for one in rippled.messages if "does not explain" in one]
    assert "position_ripple" in said
    assert "`stickslip discover`" in said


def test_runs_that_were_not_fitted_are_said_beside_what_noise_leaves(found: Identified) -> None:
    (said,) = [one for one in found.messages if one.startswith("validate runs")]
    assert "of the drive's force is unexplained" in said
    assert "250 ms ahead" in said or "0.25 s ahead" in said
    numbers = found.diagnostics
    assert numbers["held_out_force"] < 1.5 * numbers["held_out_force_of_noise"]
    assert numbers["held_out_position"] < 2 * numbers["held_out_position_of_noise"]


def test_a_loop_is_said_to_be_one_and_an_open_drive_is_not(found: Identified) -> None:
    assert any("The drive answers to noise of the readings" in one for one in found.messages)
    alone = ss.identify(recorded(*open_loop(0)))
    assert not any("answers to noise" in one for one in alone.messages)


def test_a_mass_that_is_far_from_the_declared_one_is_said() -> None:
    found = ss.identify(recorded(*open_loop(1), mass=1.25 * truth.MASS))
    assert found.estimates["mass"].value == pytest.approx(truth.MASS, rel=0.02)
    assert found.constants["mass"].beyond
    assert any(one.startswith("mass ") and "is not 15 as declared" in one for one in found.messages)


def test_a_mass_that_is_exact_is_not_fitted(tmp_path: Path) -> None:
    path = truth.write_case(tmp_path, **SHORT)
    exact = "\n[uncertainty]\nm = 0\nx1 = 0\ndrive = 0\n\n[[run]]"
    path.write_text(path.read_text().replace("\n[[run]]", exact, 1))
    found = ss.identify(ss.load_case(path))
    assert "mass" not in found.estimates
    assert found.model.rig.mass == truth.MASS
    assert not any("gains of drive" in one for one in found.messages)


def test_a_direction_never_taken_keeps_what_is_declared_or_is_as_the_other() -> None:
    t = np.arange(1500) / RATE
    drive = 40 + 5 * np.sin(3 * t) + 4 * np.sin(40 * t)
    x = by_scipy(t, drive) + 1e-6 * np.random.default_rng(0).standard_normal(len(t))
    run = recorded(t, x, drive)
    silent = ss.identify(run)
    assert silent.estimates["kinetic"].status == "unidentified"
    assert silent.covered["minus"] is None
    assert silent.law.kinetic == silent.law.kinetic_plus
    told = ss.identify(run, friction=ss.CoulombFriction(static=7.0, kinetic=6.5))
    assert (told.law.static, told.law.kinetic) == (7.0, 6.5)
    assert told.estimates["kinetic"].low is None
    assert any("never moves with x2 < 0: the declared friction is kept" in one for one in told.messages)


def test_the_command_writes_what_it_writes_for_other_rigs(case: ss.Case, tmp_path: Path) -> None:
    out = tmp_path / "out"
    result = CliRunner().invoke(main, ["identify", str(case.path), "--out", str(out)])
    assert result.exit_code == 0, result.output
    assert sorted(one.name for one in out.iterdir() if not one.name.startswith(".")) == [
        "friction_characteristic.png",
        "friction_characteristic.svg",
        "identified.json",
        "model.toml",
    ]
    written = json.loads((out / "identified.json").read_text())
    assert written["estimates"]["kinetic"]["value"] == pytest.approx(truth.MINUS, rel=0.03)
    assert written["diagnostics"]["held_out_force"] > 0
    assert written["declared"].keys() == {"mass"}
    assert "damping" in result.output


def test_what_a_notebook_shows(found: Identified) -> None:
    page = found._repr_html_()
    assert "Identified coulomb law" in page
    assert "kinetic_plus" in page
    assert "N s/m" in page


REFUSED = {
    "another law": ({}, {"friction": ss.PaperFriction()}, "the law of a driven slider is coulomb"),
    "a table of laws": (
        {},
        {"friction": {"x": ss.CoulombFriction()}},
        "the law of a driven slider is coulomb",
    ),
    "another rig": ({}, {"rig": ss.BlockOnBelt(mass=1.0, stiffness=1.0)}, "declared with its recordings"),
    "another mass": ({}, {"rig": ss.DrivenSlider(mass=1.0)}, "declared with its recordings"),
    "noise": ({}, {"noise": {"x1": 1e-6}}, "leave it out for a driven slider"),
    "scatter": ({}, {"scatter": True}, "leave it out for a driven slider"),
    "a drive that never changes": ({"force": 5.0}, {}, "the drive never changes"),
    "a slider that never moves": ({"x": 0.0}, {}, "tell of a mass of 0 where 12 is declared"),
    "too few samples": ({"n": 60}, {}, "samples are too few"),
}


@pytest.mark.parametrize("name", REFUSED)
def test_what_cannot_be_identified_is_refused_in_a_line(name: str) -> None:
    spoilt, given, words = REFUSED[name]
    t, x, force = (one[: spoilt.get("n")] for one in open_loop(0))
    run = recorded(t, np.full_like(x, spoilt.get("x", 0)) if "x" in spoilt else x, force)
    if "force" in spoilt:
        run = recorded(t, x, np.full_like(x, spoilt["force"]))
    with pytest.raises(InputError, match=words) as caught:
        ss.identify(run, **given)
    assert "\n" not in str(caught.value)
    assert "verdict" not in str(caught.value)


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ('unit = "mm"', 'unit = "m"', "where 12 is declared"),
        ("scale = 4.0", "scale = -4.0", "where 12 is declared"),
        ('drive = { column = "u", unit = "V", scale = 4.0 }', "", "no channel drive"),
        ("m = 12.0", "", "'m'|mass"),
        ('role = "train"', 'role = "validate"', "role = 'train'|role 'train'"),
    ],
)
def test_a_case_that_contradicts_itself_is_refused(tmp_path: Path, old: str, new: str, words: str) -> None:
    path = truth.write_case(tmp_path, **SHORT)
    assert old in path.read_text()
    path.write_text(path.read_text().replace(old, new))
    with pytest.raises(InputError, match=words) as caught:
        ss.identify(ss.load_case(path))
    assert "\n" not in str(caught.value)


def test_a_gap_is_refused() -> None:
    t, x, force = open_loop(0)
    kept = np.r_[0:500, 700 : len(t)]
    with pytest.raises(InputError, match=r"200 sample\(s\) missing"):
        ss.identify(recorded(t[kept], x[kept], force[kept]))


def test_validate_runs_that_cannot_be_forecast_do_not_stop_it(tmp_path: Path) -> None:
    path = truth.write_case(tmp_path, **SHORT)
    text = path.read_text().replace("from = 6.0", "from = 6.0\nto = 6.05")
    path.write_text(text)
    found = ss.identify(ss.load_case(path))
    (said,) = [one for one in found.messages if one.startswith("validate runs")]
    assert found.estimates["kinetic"].value == pytest.approx(truth.MINUS, rel=0.03)
    assert "unexplained" not in said
