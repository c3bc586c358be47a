"""The script that a shell needs, and what it completes."""

import os
import subprocess
import sys

import pytest
from click.testing import CliRunner

from stickslip.cli.commands import COMMANDS, main

CODE = (
    "from stickslip.cli.commands import main; main(prog_name='stickslip', complete_var='_STICKSLIP_COMPLETE')"
)


def asked(words: str, count: int) -> dict[str, str]:
    """What bash tells of the word at `count`."""
    return {"_STICKSLIP_COMPLETE": "bash_complete", "COMP_WORDS": words, "COMP_CWORD": str(count)}


def completed(words: str, count: int) -> list[str]:
    """What bash would offer for it."""
    return CliRunner().invoke(main, prog_name="stickslip", env=asked(words, count)).stdout.split()


def test_the_program_completes() -> None:
    done = subprocess.run(
        [sys.executable, "-c", CODE],
        env={**os.environ, **asked("stickslip dis", 1)},
        capture_output=True,
        text=True,
        check=True,
    )
    assert done.stdout.split() == ["plain,discover"]


def test_commands_are_completed() -> None:
    assert completed("stickslip dis", 1) == ["plain,discover"]
    assert {one.removeprefix("plain,") for one in completed("stickslip ", 1)} == set(COMMANDS)


def test_options_of_a_command_are_completed() -> None:
    assert completed("stickslip discover --se", 2) == ["plain,--seed"]


def test_a_path_is_left_to_the_shell() -> None:
    assert completed("stickslip discover run", 2) == ["file,run"]


@pytest.mark.parametrize("shell", ["bash", "zsh", "fish"])
def test_the_script_names_the_program(shell: str) -> None:
    result = CliRunner().invoke(main, ["completion", shell])
    assert result.exit_code == 0, result.output
    assert f"_STICKSLIP_COMPLETE={shell}_complete" in result.output
    if shell == "bash":
        checked = subprocess.run(["bash", "-n"], input=result.output, text=True, check=False)
        assert checked.returncode == 0


def test_another_shell_is_refused() -> None:
    result = CliRunner().invoke(main, ["completion", "tcsh"])
    assert result.exit_code == 2
    assert len(result.output.strip().splitlines()) == 1
