"""Every public name has a numpydoc docstring, of what it takes and gives, with an example that runs."""

from __future__ import annotations

import dataclasses
import doctest
import inspect
import re
from enum import Enum
from itertools import pairwise
from pathlib import Path
from types import ModuleType

import pytest

import stickslip as ss
from website.api import CONSTANTS
from website.docstrings import plain, singly

SPOKEN = {f"stickslip.{name}": getattr(ss, name) for name in dir(ss) if name != "__version__"}
SPOKEN |= {f"stickslip.signals.{name}": getattr(ss.signals, name) for name in ss.signals.__all__}
FUNCTIONS = [name for name, one in SPOKEN.items() if inspect.isroutine(one)]
CLASSES = [name for name, one in SPOKEN.items() if dataclasses.is_dataclass(one)]


def said_of(name: str) -> str:
    """The docstring of a public name; of a constant, which can have none, what its page says."""
    short = name.removeprefix("stickslip.")
    return CONSTANTS[short] if short in CONSTANTS else inspect.getdoc(SPOKEN[name]) or ""


def section(text: str, title: str) -> str:
    """What stands below a title, up to the next."""
    found = re.search(
        rf"^{title}\n-{{3,}}\n(.*?)(?=^[A-Z][a-z ]+\n-{{3,}}\n|\Z)", text, re.MULTILINE | re.DOTALL
    )
    return found[1] if found else ""


def entries(text: str, *titles: str) -> list[str]:
    """The names of what a section lists."""
    lines = [line for title in titles for line in section(text, title).splitlines()]
    heads = [line.split(" :")[0] for line in lines if line and not line.startswith(" ")]
    return [name.strip().lstrip("*") for head in heads for name in head.split(",")]


def failures(name: str, text: str) -> tuple[int, str]:
    """How many statements of a docstring's example show something, and what went otherwise than it says."""
    example = doctest.DocTestParser().get_doctest(text, {}, name, None, 0)
    told: list[str] = []
    doctest.DocTestRunner(verbose=False).run(example, out=told.append)
    return sum(bool(one.want) for one in example.examples), "".join(told)


@pytest.mark.parametrize("name", SPOKEN)
def test_the_example_of_a_public_name_runs(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    text = said_of(name)
    assert "\nExamples\n--------\n" in text or name.removeprefix("stickslip.") in CONSTANTS
    shows, told = failures(name, text)
    assert told == ""
    assert shows >= 1


@pytest.mark.parametrize("name", FUNCTIONS)
def test_a_function_says_what_it_takes_and_gives(name: str) -> None:
    text = said_of(name)
    try:
        taken = [*inspect.signature(SPOKEN[name]).parameters]
    except ValueError:  # of the compiled core
        taken = []
    assert entries(text, "Parameters") == taken
    assert section(text, "Returns").strip()


@pytest.mark.parametrize("name", CLASSES)
def test_a_class_says_what_its_numbers_are(name: str) -> None:
    numbers = [one for one in inspect.signature(SPOKEN[name]).parameters if not one.startswith("_")]
    told = entries(said_of(name), "Parameters", "Attributes")
    assert [one for one in numbers if one not in told] == []


@pytest.mark.parametrize("name", [*FUNCTIONS, *CLASSES])
def test_every_number_has_words(name: str) -> None:
    """A shape or a type alone says not what it is; words in the place of the type are set as a type."""
    lines = [
        line for title in ("Parameters", "Attributes") for line in section(said_of(name), title).splitlines()
    ]
    lines = [*filter(None, lines), ""]
    silent = [a for a, b in pairwise(lines) if not a.startswith(" ") and not b.startswith(" ")]
    assert silent == []


def test_what_is_neither_a_function_nor_a_record_is_known() -> None:
    others = [one for name, one in SPOKEN.items() if name not in FUNCTIONS and name not in CLASSES]
    kinds = [one for one in others if not isinstance(one, ModuleType) and one is not ss.CATALOGUE]
    assert all(isinstance(one, type) and issubclass(one, Exception | Enum) for one in kinds)


def test_an_example_that_lies_is_seen() -> None:
    assert failures("right", ">>> 1 + 1\n2\n") == (1, "")
    assert "Expected:\n    3" in failures("wrong", ">>> 1 + 1\n3\n")[1]
    assert "ZeroDivisionError" in failures("broken", ">>> 1 / 0\n")[1]


def test_an_example_is_shown_as_it_is_run() -> None:
    text = "R(|v|), x_1\n\n>>> a_ = [*map(abs, (1,))]  # |v|\n>>> a_ | b_\n{1|2}\n\nand R(|v|)"
    shown = plain(text)
    assert ">>> a_ = [*map(abs, (1,))]  # |v|\n>>> a_ | b_\n{1|2}\n" in shown
    assert shown.endswith("and R(\\|v\\|)")


def test_attributes_that_share_their_words_are_shown_singly() -> None:
    lines = [
        ":ivar a, b: What they",
        "           are.",
        ":vartype a, b: float",
        ":ivar c: Other.",
        "",
        "End, of it.",
    ]
    assert singly(lines) == [
        ":ivar a: What they", "           are.", ":ivar b: What they", "           are.",
        ":vartype a: float", ":vartype b: float", ":ivar c: Other.", "", "End, of it.",
    ]  # fmt: skip
