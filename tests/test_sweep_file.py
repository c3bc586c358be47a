"""sweep.toml: what is given is taken as it stands or refused, with the line and what would be right."""

from __future__ import annotations

from pathlib import Path

import pytest
from click.testing import CliRunner

from stickslip.cli.commands import main

pytest.importorskip("zarr")

RIG = "[rig]\nalpha1 = 16\nalpha2 = 8\nbeta3 = 4\neta1 = 0.1\neta12 = 0.2\n"
HEAD = f"{RIG}[sweep]\nt_end = 2\nbelt_speed = 0.1\n"
ONE = "[over]\nalpha1 = [8]\n"


def said(tmp_path: Path, text: str) -> str:
    """What the command answers to a file of this text; nothing is written."""
    (tmp_path / "sweep.toml").write_text(text, encoding="utf-8")
    result = CliRunner().invoke(
        main, ["sweep", str(tmp_path / "sweep.toml"), "--out", str(tmp_path / "a.zarr")]
    )
    assert result.exit_code != 0
    assert not (tmp_path / "a.zarr").exists()
    return result.output.replace("\n", " ").strip()


@pytest.mark.parametrize(
    ("text", "line"),
    [
        (
            HEAD + '[over]\n"initial.x1" = [0, 1]\ninitial.x1 = [2, 3]',
            "'initial.x1' is given twice; leave one out",
        ),
        (HEAD + "[over]\nalpha1 = [true]", "[over alpha1 values 1]: not a number; give one like 0.5"),
        (
            HEAD + "[over]\nalpha1 = { start = 1, stop = 2, count = true }",
            "[over alpha1] key 'count' = True: must be a whole number",
        ),
        (HEAD.replace("= 2", '= "2"') + ONE, "[sweep] key 't_end' = '2': not a number; give one like 0.5"),
        (HEAD + 'lanes = "no"\n' + ONE, "[sweep] key 'lanes' = 'no': must be true or false"),
        (HEAD + "initial = [true, 0, 0, 0]\n" + ONE, "[sweep initial 1]: not a number"),
    ],
)
def test_what_is_given_is_not_made_into_something_else(tmp_path: Path, text: str, line: str) -> None:
    assert line in said(tmp_path, text)


@pytest.mark.parametrize(
    ("text", "line"),
    [
        (
            HEAD + "[over]\nalpha1 = 8",
            "key 'alpha1' = 8: a single number; give a list, or start, stop and count",
        ),
        (
            HEAD + '[over]\nalpha1 = "8"',
            "key 'alpha1' = '8': not numbers; give a list, or start, stop and count",
        ),
        ("over = [1, 2]\n" + HEAD, "key 'over': must be a table [over] of names and values"),
        (HEAD + "[[over]]\nalpha1 = [8]", "key 'over': is there once, so it is headed [over], not [[over]]"),
        (
            HEAD + "[over]",
            "key 'over': empty; give at least one name and its values, like belt_speed = [0.1, 0.2]",
        ),
        (
            HEAD + "[over]\ninitial = { x1 = [0, 1], values = [1] }",
            "[over] key 'initial': values beside names of states (x1); leave one out",
        ),
        (
            HEAD + "[over]\nalpha1 = { strt = 1, stop = 2, count = 2 }",
            "key 'strt': unknown; did you mean 'start'?",
        ),
        (HEAD + "[over]\ninitial = [0, 1]", "'initial' is not one number; vary its states: 'initial.x1'"),
        (HEAD + "initial = 0.1\n" + ONE, "[sweep] key 'initial' = 0.1: must be a list, in [ ]"),
        ('model = ""\n[sweep]\nt_end = 2\n' + ONE, "line 1, key 'model': is empty"),
    ],
)
def test_what_is_written_wrong_is_told_what_would_be_right(tmp_path: Path, text: str, line: str) -> None:
    assert line in said(tmp_path, text)
