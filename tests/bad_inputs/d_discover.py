"""Cases that no verdict is possible on, and forecasts that cannot be made."""

from __future__ import annotations

import re
from pathlib import Path

import found_by_hand
import stickslip as ss
from bad_input import bad_input
from stickslip.cli import discover as cli_discover
from stickslip.cli import forecast as cli_forecast
from stickslip.declared.model import Model
from stickslip.files import folder as report_folder

DISCOVER, FORECAST = "Discovery", "Forecasts"


def spoilt(folder: Path, old: str, new: str) -> list[str]:
    """A sound case with one thing changed; the command's arguments."""
    path = found_by_hand.write_case(folder, si=True)
    text = path.read_text(encoding="utf-8")
    assert old in text
    path.write_text(text.replace(old, new), encoding="utf-8")
    return [str(path), "--out", str(folder / "out")]


def run(folder: Path, arguments: list[str]) -> None:
    try:
        cli_discover.discover.main(arguments, standalone_mode=False)
    finally:
        assert not [p for p in folder.iterdir() if "out" in p.name], "something half-written is left"


@bad_input(DISCOVER, "a misspelt key")
def misspelt(folder: Path) -> None:
    run(folder, spoilt(folder, "length = ", "lenght = "))


@bad_input(DISCOVER, "a misspelt table")
def misspelt_table(folder: Path) -> None:
    run(folder, spoilt(folder, "[channels]", "[chanels]"))


@bad_input(DISCOVER, "a run's file that is missing")
def missing(folder: Path) -> None:
    run(folder, spoilt(folder, '"run_02.csv"', '"run_2.csv"'))


@bad_input(DISCOVER, "no run to validate on")
def nobody_validates(folder: Path) -> None:
    run(folder, spoilt(folder, '"validate"', '"train"'))


@bad_input(DISCOVER, "no run to train on")
def nobody_trains(folder: Path) -> None:
    run(folder, spoilt(folder, '"train"', '"validate"'))


@bad_input(DISCOVER, "a role that is none")
def unknown_role(folder: Path) -> None:
    run(folder, spoilt(folder, 'role = "validate"', 'role = "test"'))


@bad_input(DISCOVER, "one run only")
def one_run(folder: Path) -> None:
    text = found_by_hand.write_case(folder, si=True).read_text(encoding="utf-8")
    second = text[text.index('[[run]]\nfile = "run_02.csv"') : text.index("[channels]")]
    run(folder, spoilt(folder, second, ""))


@bad_input(DISCOVER, "a channel in a wrong unit")
def wrong_unit(folder: Path) -> None:
    run(folder, spoilt(folder, 'x1 = { column = "x1", unit = "mm" }', 'x1 = { column = "x1", unit = "m" }'))


@bad_input(DISCOVER, "a run of another rig")
def another_rig(folder: Path) -> None:
    file = 'file = "run_02.csv"'
    run(folder, spoilt(folder, file, f"{file}\nrig = {{ m = 12.0 }}"))


@bad_input(DISCOVER, "an inertia in kg mm^2")
def inertia_in_another_unit(folder: Path) -> None:
    number = re.search(
        r"^J = (\S+)", found_by_hand.write_case(folder, si=True).read_text(encoding="utf-8"), re.M
    )
    assert number is not None
    run(folder, spoilt(folder, number.group(0), f"J = {1e6 * float(number.group(1))}"))


@bad_input(DISCOVER, "a result folder that is a file")
def out_is_a_file(folder: Path) -> None:
    (folder / "taken").write_text("", encoding="utf-8")
    with report_folder(folder / "taken", ["report.html"]):
        pass


def model_and_run(folder: Path) -> tuple[str, str]:
    """A model file of the case, and one of its runs."""
    case = ss.load_case(found_by_hand.write_case(folder, si=True))
    model: Model = case.model()
    model.save(folder / "model.toml")
    return str(folder / "model.toml"), str(folder / "run_03.csv")


def forecast(
    folder: Path, *, speed: str = "0.01", horizon: str = "1", run: str = "", model: str = ""
) -> None:
    own_model, own_run = model_and_run(folder)
    out = ["--out", str(folder / "next.csv")]
    arguments = [model or own_model, run or own_run, "--belt-speed", speed, "--horizon", horizon, *out]
    try:
        cli_forecast.forecast.main(arguments, standalone_mode=False)
    finally:
        assert not (folder / "next.csv").exists()


for tried, given in (
    ("a horizon of 0", {"horizon": "0"}),
    ("a horizon that is not a number", {"horizon": "nan"}),
    ("a horizon under a sampling interval", {"horizon": "1e-6"}),
    ("a horizon of more than a million samples", {"horizon": "1e9"}),
    ("a belt speed in a unit of length", {"speed": "12 mm"}),
    ("a belt speed that is not a number", {"speed": "fast"}),
    ("a belt speed in mm/s taken for m/s", {"speed": "13.4"}),
    ("a belt speed of 0 where the block rides the belt", {"speed": "0"}),
    ("a model that is missing", {"model": "no_model.toml"}),
    ("a run that is missing", {"run": "no_run.csv"}),
):
    bad_input(FORECAST, tried)(lambda folder, given=given: forecast(folder, **given))


@bad_input(FORECAST, "a case instead of a model")
def case_as_model(folder: Path) -> None:
    forecast(folder, model=str(found_by_hand.write_case(folder)))


@bad_input(FORECAST, "a past too short to tell the state")
def short_past(folder: Path) -> None:
    _, run = model_and_run(folder)
    lines = Path(run).read_text(encoding="utf-8").splitlines()
    (folder / "short.csv").write_text("\n".join(lines[:12]) + "\n", encoding="utf-8")
    forecast(folder, run=str(folder / "short.csv"))
