"""No command takes the place of a user's file: asked of every command that the command line has."""

from __future__ import annotations

import os
import re
import shlex
from pathlib import Path

import click
import pytest
from click.testing import CliRunner, Result

import page_folder
from quick_figures import quickly
from stickslip.cli.commands import COMMANDS, main
from stickslip.cli.options import Output
from stickslip.cli.running import compare, identify
from stickslip.files import RECORD

SIMULATE = "MODEL.toml --belt-speed 0.012 --t-end 1 --figure --out run.csv"
LINES = {  # a command that writes: its line, and the files that it would write
    "compare": ("MODEL.toml CASE/rig.toml --out out", [f"out/{one}" for one in compare.WRITTEN]),
    "demo": ("--out out", [f"out/{one}" for one in identify.WRITTEN]),
    "discover": ("CASE/rig.toml --out out", ["out/report.json", "out/model_after.toml", "out/report.html"]),
    "example": ("bodies --out out", ["out/rig.toml", "out/run_01.csv", "out/run_02.csv"]),
    "explore": ("MODEL.toml --belt-speed 0.012 --screenshot page.png", ["page.png"]),
    "forecast": (
        "CASEMODEL.toml RUN.csv --belt-speed '12 mm/s' --horizon '0.1 s' --figure --out next.csv",
        ["next.csv", "next.svg", "next.png"],
    ),
    "identify": ("CASE/rig.toml --out out", [f"out/{one}" for one in identify.WRITTEN]),
    "init": ("CASE/run_01.csv --constant m=0.0307 --constant k=168 --out CASE", ["CASE/rig.toml"]),
    "inspect": ("RUN.csv --figure seen", ["seen.svg", "seen.png"]),
    "simulate": (SIMULATE, ["run.csv", "run.svg", "run.png"]),
    "sweep": ("SWEEP.toml --out store", ["store"]),  # it never replaces anything: there is no --force
}
QUICK = ("example", "forecast", "init", "inspect", "simulate")
MODEL = '[rig]\nkind = "block_on_belt"\nm = 0.0307\nk = 168\n'
MODEL += '[friction]\nkind = "coulomb"\nstatic = 0.11\nkinetic = 0.07\n'
CHANNELS = '[channels]\nt = { column = "t", unit = "s" }\nx1 = { column = "x1", unit = "mm" }\n'


def command(name: str) -> click.Command:
    found = main.get_command(click.Context(main), name)
    assert found is not None
    return found


def outputs(name: str) -> list[click.Parameter]:
    return [one for one in command(name).params if isinstance(one.type, Output)]


INPUTS = ("files_from",)  # options that name what is read
WRITERS = [name for name in COMMANDS if outputs(name)]
FILES = [(name, file) for name in WRITERS for file in LINES[name][1]]


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    page_folder.prepare(tmp_path)
    (tmp_path / "MODEL.toml").write_text(MODEL)
    (tmp_path / "CASEMODEL.toml").write_text(MODEL + CHANNELS)
    (tmp_path / "SWEEP.toml").write_text(MODEL + "[sweep]\nt_end = 1.0\n[over]\nbelt_speed = [0.01, 0.012]\n")
    monkeypatch.chdir(tmp_path)
    return tmp_path


def run(name: str, *more: str) -> Result:
    line, _ = LINES[name]
    return CliRunner().invoke(main, [name, *shlex.split(line), *more])


def test_every_option_that_takes_a_path_is_an_input_or_an_output():
    for name in COMMANDS:
        for one in command(name).params:
            if isinstance(one, click.Option) and isinstance(one.type, click.Path):
                assert isinstance(one.type, Output) or one.name in INPUTS, f"{name}: {one.name}"


@pytest.mark.parametrize("name", WRITERS)
def test_every_command_that_writes_can_be_forced(name: str) -> None:
    given = [one.name for one in command(name).params]
    assert ("force" in given) == (name != "sweep")


@pytest.mark.parametrize(("name", "file"), FILES, ids=[f"{name} {file}" for name, file in FILES])
def test_a_file_that_is_there_stays(folder: Path, name: str, file: str) -> None:
    mine = folder / file
    mine.parent.mkdir(exist_ok=True)
    mine.write_text("mine")
    before = {one: one.read_bytes() for one in folder.rglob("*") if one.is_file()}
    refused = run(name)
    assert refused.exit_code == 2, refused.output
    assert len(refused.stderr.splitlines()) == 1
    assert name == "sweep" or re.search("no former result put (it )?there", refused.stderr)
    assert {one: one.read_bytes() for one in folder.rglob("*") if one.is_file()} == before


@pytest.mark.parametrize("name", QUICK)
def test_a_former_result_is_replaced_one_that_was_changed_by_force(
    folder: Path, monkeypatch: pytest.MonkeyPatch, name: str
) -> None:
    quickly(monkeypatch)
    files = [folder / one for one in LINES[name][1]]
    for one in files:
        one.unlink(missing_ok=True)
    assert run(name).exit_code == 0
    for file in files:
        assert run(name).exit_code == 0
        made = file.read_bytes()
        file.write_text("mended by hand")
        refused = run(name)
        assert refused.exit_code == 2
        assert "changed since it was written" in refused.stderr
        assert file.read_text() == "mended by hand"
        assert run(name, "--force").exit_code == 0
        assert len(file.read_bytes()) == pytest.approx(len(made), rel=0.01)
    assert RECORD in os.listdir(files[0].parent)


def test_a_copy_of_a_result_under_another_name_is_the_users(folder: Path) -> None:
    assert run("simulate").exit_code == 0
    (folder / "run.csv").rename(folder / "kept.csv")
    (folder / "run.csv").symlink_to("RUN.csv")
    refused = run("simulate")
    assert refused.exit_code == 2
    assert (folder / "RUN.csv").read_text().startswith("t [s],x1")
