"""Cases and recordings with something wrong."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
from scipy.io import savemat

from bad_input import bad_input
from stickslip.declared.friction.paper import PaperFriction
from stickslip.declared.model import Model
from stickslip.declared.rig import BlockOnBelt, Rig
from stickslip.declared.units import Channel
from stickslip.measured.case import load_case
from stickslip.measured.readers.tables import read_columns
from stickslip.measured.recording import load_recording

CASE = "Cases: rig.toml"
RUN = "Runs: files"
TIME = "Runs: times and windows"

TOML = """\
title = "a rig"
[rig]
m = 40.0
J = 0.3
r = 0.1
k1 = 6000.0
k2 = 400.0
k3 = 1200.0
c1 = 2.0
c2 = 3.0
length = 0.01
[noise]
x1 = 0.01
[[run]]
file = "run_1.csv"
role = "train"
belt_speed = 0.1
[[run]]
file = "run_2.csv"
role = "validate"
belt_speed = 0.05
[channels]
t = { column = "t", unit = "s" }
x1 = { column = "x1", unit = "mm" }
y1 = { column = "y1", unit = "mm" }
belt = { column = "belt", unit = "m/s" }
"""
ND = Rig(alpha1=16, alpha2=8, beta3=4, eta1=0.1, eta12=0.2)


def rows(n: int = 40) -> list[str]:
    """A run of n samples: t,x1,y1,belt."""
    t = 0.01 * np.arange(n)
    x1 = np.sin(3 * t)
    y1 = -0.5 * np.cos(2 * t)
    return ["t,x1,y1,belt", *(f"{a:.4g},{b:.7g},{c:.7g},0.1" for a, b, c in zip(t, x1, y1, strict=True))]


def case(folder: Path, text: str) -> None:
    for name in ("run_1.csv", "run_2.csv"):
        if not (folder / name).exists():
            (folder / name).write_text("\n".join(rows()) + "\n")
    (folder / "rig.toml").write_text(text)
    load_case(folder)


def run(folder: Path, change: Callable[[list[str]], list[str]], n: int = 40) -> None:
    (folder / "run_1.csv").write_text("\n".join(change(rows(n))) + "\n")
    case(folder, TOML)


def cell(line: int, column: int, text: str) -> Callable[[list[str]], list[str]]:
    """Put `text` into a cell; line from 1."""

    def change(lines: list[str]) -> list[str]:
        cells = lines[line - 1].split(",")
        cells[column] = text
        return [*lines[: line - 1], ",".join(cells), *lines[line:]]

    return change


for tried, before, after in (
    ("misspelt key", "belt_speed = 0.05", "beltspeed = 0.05"),
    ("misspelt table", "[channels]", "[chanels]"),
    ("misspelt SI constant", "length = 0.01", "lenght = 0.01"),
    ("missing SI constant", "k3 = 1200.0\n", ""),
    ("zero mass", "m = 40.0", "m = 0.0"),
    ("negative damping", "c2 = 3.0", "c2 = -3.0"),
    ("a role that is none", '"validate"', '"validation"'),
    ("no belt speed", "belt_speed = 0.05\n", ""),
    ("a belt speed that is text", "belt_speed = 0.05", 'belt_speed = "fast"'),
    ("a belt speed that is a length", "belt_speed = 0.05", 'belt_speed = "50 mm"'),
    ("a belt speed that is NaN", "belt_speed = 0.05", "belt_speed = nan"),
    ("a run file that is missing", "run_2.csv", "run_3.csv"),
    ("a run given twice", "run_2.csv", "run_1.csv"),
    ("a run given twice as train", 'run_2.csv"\nrole = "validate"', 'run_1.csv"\nrole = "train"'),
    ("a unit of something else", '"mm" }\ny1', '"ms" }\ny1'),
    ("a unit nobody knows", '"mm" }\ny1', '"mmm" }\ny1'),
    ("a missing channel", 'y1 = { column = "y1", unit = "mm" }\n', ""),
    ("a channel that is none", "belt =", "bellt ="),
    ("a misspelt key of a channel", "y1 = { column", "y1 = { colum"),
    ("noise of a channel that is none", "[noise]\nx1", "[noise]\nx2"),
    ("noise of 0", "x1 = 0.01", "x1 = 0.0"),
    ("an uncertainty of what is not declared", "[noise]", "[uncertainty]\nalpha1 = 0.01\n[noise]"),
    ("an uncertainty that has a unit", "[noise]", '[uncertainty]\nm = "0.2 kg"\n[noise]'),
    ("an uncertainty in per cent without its sign", "[noise]", "[uncertainty]\nm = 1.5\n[noise]"),
    ("a column that is missing", 'column = "x1"', 'column = "X_1"'),
    ("a window that is empty", 'role = "train"', 'role = "train"\nfrom = 0.2\nto = 0.1'),
    ("a window beyond the run", 'role = "train"', 'role = "train"\nfrom = 7.0'),
    ("an override that is no number of the rig", 'role = "train"', 'role = "train"\nrig = { k4 = 3.0 }'),
    ("one column for two channels", 'column = "y1"', 'column = "x1"'),
    ("channels as an array of tables", "[channels]", "[[channels]]"),
    ("a rig as an array of tables", "[rig]", "[[rig]]"),
    (
        "a run as a single table",
        TOML[TOML.index("[[run]]") : TOML.index("[channels]")],
        '[run]\nfile = "run_1.csv"\n',
    ),
    ("a channel that is no table", '{ column = "y1", unit = "mm" }', '"y1"'),
    ("a folder for a run's file", "run_2.csv", "."),
    ("no runs", TOML[TOML.index("[[run]]") : TOML.index("[channels]")], ""),
    ("not TOML", "[noise]", "[noise"),
):
    assert before in TOML, tried
    changed = TOML.replace(before, after, 1)
    bad_input(CASE, tried)(lambda folder, text=changed: case(folder, text))


@bad_input(CASE, "units for a nondimensional rig")
def nondimensional_with_units(folder: Path) -> None:
    numbers = "alpha1 = 16.0\nalpha2 = 8.0\nbeta3 = 4.0\neta1 = 0.1\neta12 = 0.2\n"
    case(folder, TOML[: TOML.index("m = 40")] + numbers + TOML[TOML.index("[noise]") :])


@bad_input(CASE, "a role nobody has")
def nobody_validates(folder: Path) -> None:
    case(folder, TOML.replace('"validate"', '"train"'))
    _ = load_case(folder).validate


@bad_input(CASE, "both x1 and spring_force")
def force_and_deflection(folder: Path) -> None:
    (folder / "run.csv").write_text("\n".join(rows()))
    force = {"t": Channel("t", "s"), "x1": Channel("x1", "mm"), "spring_force": Channel("y1", "N")}
    load_recording(folder / "run.csv", BlockOnBelt(), channels=force)


@bad_input(CASE, "a model for a case")
def model_for_a_case(folder: Path) -> None:
    Model(ND, friction=PaperFriction()).save(folder / "model.toml")
    load_case(folder / "model.toml")


@bad_input(CASE, "a folder of results for a case")
def results_for_a_case(folder: Path) -> None:
    (folder / "found").mkdir()
    Model(ND, friction=PaperFriction()).save(folder / "found" / "model_after.toml")
    load_case(folder / "found")


@bad_input(CASE, "no such folder")
def no_such_case(folder: Path) -> None:
    load_case(folder / "case_7" / "rig.toml")


for tried, change in (
    ("an empty cell", cell(8, 1, "")),
    ("NaN", cell(9, 2, "nan")),
    ("infinity", cell(9, 2, "inf")),
    ("text in numbers", cell(5, 1, "overload")),
    ("a line of other units below the names", lambda lines: [lines[0], "s,m,mm,m/s", *lines[1:]]),
    ("a line of text below the names", lambda lines: [lines[0], "time,block,leg,belt", *lines[1:]]),
    ("a row that is cut short", lambda lines: [*lines[:-1], lines[-1].split(",")[0]]),
    ("a row that is too long", lambda lines: [*lines[:4], lines[4] + ",7", *lines[5:]]),
    ("decimal commas between commas", lambda lines: [lines[0], *(x.replace(".", ",") for x in lines[2:])]),
    ("no line of names", lambda lines: lines[1:]),
    ("a name that is there twice", lambda lines: ["t,x1,x1,belt", *lines[1:]]),
    ("no rows", lambda lines: lines[:1]),
    ("an empty file", lambda _lines: []),
    ("one sample", lambda lines: lines[:2]),
    ("a belt that never moves", lambda lines: [lines[0], *(x[: x.rindex(",")] + ",0" for x in lines[1:])]),
):
    bad_input(RUN, tried)(lambda folder, change=change: run(folder, change))


@bad_input(RUN, "a file that was cut off within its last number")
def cut_in_a_number(folder: Path) -> None:
    (folder / "run_1.csv").write_text("\n".join(rows())[:-1])
    case(folder, TOML)


@bad_input(CASE, "a number for a path")
def number_for_a_path(_folder: Path) -> None:
    load_case(3)  # type: ignore[arg-type]


@bad_input(RUN, "a rig that is None")
def no_rig(folder: Path) -> None:
    load_recording(folder / "run_1.csv", None)  # type: ignore[arg-type]


@bad_input(RUN, "not text")
def not_text(folder: Path) -> None:
    (folder / "run_1.csv").write_bytes(bytes(range(256)))
    case(folder, TOML)


@bad_input(RUN, "a .mat file without the variable")
def mat_without(folder: Path) -> None:
    savemat(folder / "run.mat", {"t": np.arange(9.0), "Fnorm": np.arange(9.0)})
    read_columns(folder / "run.mat", ["t", "F_norm"])


@bad_input(RUN, "a .mat file that is none")
def mat_is_text(folder: Path) -> None:
    (folder / "run.mat").write_text("t,x1\n0,1\n")
    read_columns(folder / "run.mat", ["t"])


@bad_input(RUN, "a .mat variable that is a matrix")
def mat_matrix(folder: Path) -> None:
    savemat(folder / "run.mat", {"t": np.ones((3, 4))})
    read_columns(folder / "run.mat", ["t"])


@bad_input(RUN, ".mat variables of different lengths")
def mat_lengths(folder: Path) -> None:
    savemat(folder / "run.mat", {"t": np.arange(9.0), "x1": np.arange(8.0)})
    read_columns(folder / "run.mat", ["t", "x1"])


for tried, change in (
    ("a time that is there twice", cell(6, 0, "0.03")),
    ("time that goes back", cell(6, 0, "0.005")),
    ("columns that are swapped", lambda lines: ["x1,t,y1,belt", *lines[1:]]),
):
    bad_input(TIME, tried)(lambda folder, change=change: run(folder, change, 100))
