"""Identification, comparison and forecasts of what is no case, no recording or no model; and commands given them."""

from __future__ import annotations

import re
from pathlib import Path

from click.testing import CliRunner

import found_by_hand
import stickslip as ss
from bad_input import bad_input
from stickslip.cli.commands import main

MEETING = "Identification and comparison"
MODEL = ss.Model(ss.Rig(alpha1=16, alpha2=8, beta3=4, eta1=0.1, eta12=0.2), friction=ss.PaperFriction())


@bad_input(MEETING, "identify None")
def identify_none(_folder: Path) -> None:
    ss.identify(None)  # type: ignore[arg-type]


@bad_input(MEETING, "identify a path")
def identify_path(_folder: Path) -> None:
    ss.identify("CASE/rig.toml")  # type: ignore[arg-type]


@bad_input(MEETING, "identify, a misspelt argument")
def identify_misspelt(_folder: Path) -> None:
    ss.identify(None, frction=ss.PaperFriction())  # type: ignore[call-arg]


@bad_input(MEETING, "identify, a channel in a wrong unit")
def identify_wrong_unit(folder: Path) -> None:
    path = found_by_hand.write_case(folder, si=True)
    text = path.read_text(encoding="utf-8")
    path.write_text(text.replace('"y1", unit = "mm"', '"y1", unit = "um"'), encoding="utf-8")
    ss.identify(ss.load_case(path))


@bad_input(MEETING, "identify, a leg of the angle body in mm")
def identify_leg_in_mm(folder: Path) -> None:
    path = found_by_hand.write_case(folder, si=True)
    text = path.read_text(encoding="utf-8")
    number = re.search(r"^r = (\S+)", text, re.M)
    assert number is not None
    path.write_text(text.replace(number.group(0), f"r = {1e3 * float(number.group(1))}"), encoding="utf-8")
    ss.identify(ss.load_case(path))


@bad_input(MEETING, "identify, a mass in grams")
def identify_grams(folder: Path) -> None:
    path = found_by_hand.write_case(folder, si=True)
    text = path.read_text(encoding="utf-8")
    path.write_text(re.sub(r"(?m)^m = (.*)", lambda m: f"m = {1e3 * float(m[1])}", text), encoding="utf-8")
    ss.identify(ss.load_case(path))


@bad_input(MEETING, "identify, a run of another rig")
def identify_another_rig(folder: Path) -> None:
    path = found_by_hand.write_case(folder, si=True)
    text, file = path.read_text(encoding="utf-8"), 'file = "run_02.csv"'
    path.write_text(text.replace(file, f"{file}\nrig = {{ m = 12.0 }}"), encoding="utf-8")
    ss.identify(ss.load_case(path))


@bad_input(MEETING, "compare with a path")
def compare_path(_folder: Path) -> None:
    ss.compare(MODEL, "CASE/run_01.csv")  # type: ignore[arg-type]


@bad_input(MEETING, "compare None")
def compare_none(_folder: Path) -> None:
    ss.compare(None, None)  # type: ignore[arg-type]


@bad_input(MEETING, "forecast from a path")
def forecast_path(_folder: Path) -> None:
    ss.forecast(MODEL, "CASE/run_01.csv", belt_speed=0.1, horizon=10)  # type: ignore[arg-type]


COMMANDS = "Commands"
RUN = ("--belt-speed", "14 mm/s", "--t-end", "60 s")
for tried, arguments in (
    ("identify, a recording instead of the case", ("identify", "{folder}/run_01.csv")),
    ("identify, a model instead of the case", ("identify", "{folder}/model.toml")),
    ("compare, the case first", ("compare", "{folder}/rig.toml", "{folder}/model.toml")),
    ("compare, a folder without a model", ("compare", "{folder}/empty", "{folder}/rig.toml")),
    ("compare, a run that is none", ("compare", "{folder}/model.toml", "{folder}", "--run", "run_9")),
    ("simulate, a case instead of a model", ("simulate", "{folder}/rig.toml", *RUN)),
    (
        "simulate, a speed in a unit of length",
        ("simulate", "{folder}/model.toml", "--belt-speed", "14 mm", *RUN[2:]),
    ),
    (
        "simulate, a speed of another kind",
        ("simulate", "{folder}/model.toml", "--belt-speed", "14 kg", *RUN[2:]),
    ),
    ("simulate, an end before the start", ("simulate", "{folder}/model.toml", *RUN[:2], "--t-end", "-1 s")),
    ("simulate, a step beyond the end", ("simulate", "{folder}/model.toml", *RUN, "--dt", "90 s")),
    ("simulate, a start too short", ("simulate", "{folder}/model.toml", *RUN, "--initial", "1 mm, 0")),
    (
        "simulate, the model's file to write",
        ("simulate", "{folder}/model.toml", *RUN, "--out", "{folder}/model.toml"),
    ),
    (
        "simulate, a displacement in seconds",
        ("simulate", "{folder}/model.toml", *RUN, "--initial", "1 s, 0, 0, 0"),
    ),
):

    @bad_input(COMMANDS, tried)
    def command(folder: Path, arguments: tuple[str, ...] = arguments) -> None:
        case = ss.load_case(found_by_hand.write_case(folder, si=True))
        case.model().save(folder / "model.toml")
        (folder / "empty").mkdir()
        given = [one.format(folder=folder) for one in arguments]
        result = CliRunner().invoke(main, [*given[:1], "--out", str(folder / "out"), *given[1:]])
        assert not (folder / "out").exists()
        assert result.exit_code == 2
        raise ss.InputError(result.stderr.removeprefix("stickslip: ").strip())
