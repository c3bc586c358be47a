"""Pages of docs/ as a reader would follow them: their commands and programs are run, what they print is compared.

A block ```text after a block ```sh or ```python is what it prints. Of a program all of it; of commands each line,
wherever it stands in the output, since a page may leave lines out. White space is not compared.
"""

from __future__ import annotations

import contextlib
import io
import re
import shlex
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from click.testing import CliRunner

from stickslip.cli.commands import main

DOCS = Path(__file__).parent.parent / "docs"
BLOCK = re.compile(r"^```(sh|python|text)\n(.*?)^```$", re.DOTALL | re.MULTILINE)


@dataclass
class Step:
    """A block of commands or of a program, and what the page says that it prints."""

    language: str
    text: str
    said: str | None = None


@dataclass
class Reader:
    """Runs steps one after the other; programs share their names."""

    names: dict[str, Any] = field(default_factory=dict)

    def follow(self, step: Step) -> None:
        if step.language == "sh":
            printed = squeezed("\n".join(command(line) for line in commands(step.text)))
            gone = [line for line in (step.said or "").splitlines() if squeezed(line) not in printed]
            assert gone == [], f"not printed: {gone}; printed: {printed}"
            return
        with contextlib.redirect_stdout(io.StringIO()) as out:
            exec(compile(step.text, "a page", "exec"), self.names)
        if step.said is not None:
            assert out.getvalue() == step.said


def steps(page: Path) -> list[Step]:
    found: list[Step] = []
    for language, text in BLOCK.findall(page.read_text(encoding="utf-8")):
        if language == "text":
            found[-1].said = text
        else:
            found.append(Step(language, text))
    return found


def commands(text: str) -> list[str]:
    joined = text.replace("\\\n", " ")
    return [line.removeprefix("stickslip ") for line in joined.splitlines() if line.startswith("stickslip ")]


def command(line: str) -> str:
    """What a command prints, and the text files that it writes in this folder."""
    before = {path: path.stat().st_mtime_ns for path in Path().glob("*.toml")}
    result = CliRunner().invoke(main, shlex.split(line), catch_exceptions=False)
    assert result.exit_code == 0, result.output
    new = [path for path in Path().glob("*.toml") if path.stat().st_mtime_ns != before.get(path)]
    return "\n".join([result.output, *(path.read_text(encoding="utf-8") for path in new)])


def squeezed(text: str) -> str:
    return " ".join(text.split())
