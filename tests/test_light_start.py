"""Importing the package and asking for help load nothing slow; every public name is there when it is used."""

import ast
import subprocess
import sys
from pathlib import Path

import pytest

import stickslip
from stickslip.cli.commands import COMMANDS
from stickslip.declared import declaration
from stickslip.declared.rig_kinds import NAMED, RIG_KINDS

SLOW = (
    "bokeh",
    "jinja2",
    "loky",
    "matplotlib",
    "pandas",
    "pint",
    "psutil",
    "pydantic",
    "rich",
    "scipy",
    "tomlkit",
    "xarray",
    "zarr",
)
ASKED = "from stickslip.cli.commands import main\ntry:\n    main({})\nexcept SystemExit:\n    pass"
STARTS = {"import": "import stickslip", "help": ASKED.format(["--help"])}
STARTS |= {f"{name} --help": ASKED.format([name, "--help"]) for name in COMMANDS}


@pytest.mark.parametrize("code", STARTS.values(), ids=STARTS)
def test_nothing_slow_is_loaded(code: str) -> None:
    asked = f"{code}\nimport sys\nprint(*(name for name in {SLOW} if name in sys.modules), file=sys.stderr)"
    run = subprocess.run([sys.executable, "-c", asked], capture_output=True, text=True, check=True)
    assert run.stderr.split() == []


@pytest.mark.parametrize("start", ["import", "help"])
def test_numpy_is_loaded_when_it_is_used(start: str) -> None:
    """It took four fifths of the time of an import."""
    asked = f"{STARTS[start]}\nimport sys\nprint('numpy' in sys.modules, file=sys.stderr)"
    run = subprocess.run([sys.executable, "-c", asked], capture_output=True, text=True, check=True)
    assert run.stderr.split() == ["False"]


def test_dir_is_the_public_list() -> None:
    assert dir(stickslip) == sorted(stickslip.__all__)
    assert all(getattr(stickslip, name) is not None for name in stickslip.__all__)


def test_the_checker_of_types_sees_what_a_user_gets() -> None:
    tree = ast.parse(Path(stickslip.__file__).read_text(encoding="utf-8"))
    (checked,) = (
        one for one in tree.body if isinstance(one, ast.If) and not isinstance(one.test, ast.UnaryOp)
    )
    seen = {
        name.name: one.module for one in checked.body if isinstance(one, ast.ImportFrom) for name in one.names
    }
    assert seen == stickslip._HOME
    assert {*seen, "__version__"} == set(stickslip.__all__)


def test_a_misspelt_name_is_an_attribute_error() -> None:
    with pytest.raises(AttributeError, match="simulat'"):
        _ = stickslip.simulat  # type: ignore[attr-defined]


def test_help_says_of_a_command_what_the_command_says() -> None:
    import click

    from stickslip.cli.commands import COMMANDS, main

    context = click.Context(main)
    assert main.list_commands(context) == sorted(COMMANDS)
    for name, words in COMMANDS.items():
        command = main.get_command(context, name)
        assert command is not None
        assert command.name == name
        assert command.short_help == words


def test_the_kinds_of_rigs_that_are_shown_are_those_that_are_read() -> None:
    assert (*NAMED, *declaration.GENERAL) == RIG_KINDS
