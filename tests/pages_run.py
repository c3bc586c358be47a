"""Pages of docs/ as a reader would follow them: their commands and programs are run, what they print is compared.

A block ```text after a block ```sh or ```python is what it prints. Of a program all of it; of commands each line,
wherever it stands in the output, since a page may leave lines out. White space is not compared. A line of HTML above
a block says what else becomes of it: `<!-- file: rig.toml -->` writes it into the reader's folder, and
`<!-- not run: why -->` leaves it out, but for the options of its commands.
"""

from __future__ import annotations

import contextlib
import io
import re
import shlex
import subprocess
import sys
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import click
from click.testing import CliRunner

from stickslip.cli.commands import main

ROOT = Path(__file__).parent.parent
DOCS = ROOT / "docs"
BLOCK = re.compile(r"(?:^<!-- (file|not run): (.*?) -->\n+)?^```(.*?)\n(.*?)^```$", re.DOTALL | re.MULTILINE)
RUN = ("sh", "python")
READ = ("text", "toml")


@dataclass
class Step:
    """A block of a page: commands, a program, or a table; what the page says that it prints; what becomes of it."""

    language: str
    text: str
    said: str | None = None
    file: str | None = None
    not_run: str | None = None


@dataclass
class Reader:
    """Follows steps one after the other; programs share their names."""

    names: dict[str, Any] = field(default_factory=dict)

    def follow(self, step: Step) -> None:
        if step.file is not None:
            Path(step.file).write_text(step.text, encoding="utf-8")
        elif step.language == "sh":
            lines = commands(step.text)
            if step.not_run is not None:
                for line in lines:
                    accepted(line)
                return
            printed = squeezed("\n".join(command(line) for line in lines))
            gone = [line for line in (step.said or "").splitlines() if squeezed(line) not in printed]
            assert gone == [], f"not printed: {gone}; printed: {printed}"
        elif step.language == "python":
            program = compile(step.text, "a page", "exec")
            if step.not_run is None:
                with contextlib.redirect_stdout(io.StringIO()) as out:
                    exec(program, self.names)
                assert step.said is None or out.getvalue() == step.said


def steps(page: Path) -> list[Step]:
    """The blocks of a page in order; directives of the site are none."""
    found: list[Step] = []
    for mark, words, language, text in BLOCK.findall(page.read_text(encoding="utf-8")):
        if language.startswith("{"):
            continue
        assert language in (*RUN, *READ), f"{page.name}: a block of {language!r}"
        if language == "text" and found and found[-1].said is None and found[-1].language in RUN and not mark:
            found[-1].said = text
        else:
            file, not_run = (words if mark == kind else None for kind in ("file", "not run"))
            found.append(Step(language, text, file=file, not_run=not_run))
    return found


def commands(text: str) -> list[str]:
    """The lines of a block of commands, each whole."""
    return [line for line in text.replace("\\\n", " ").splitlines() if line and not line.startswith("#")]


def command(line: str) -> str:
    """What a command prints, and the text files that it writes in this folder."""
    program, *words = shlex.split(line, comments=True)
    if program == "python":
        told = subprocess.run(
            [sys.executable, ROOT / words[0], *words[1:]], check=True, capture_output=True, text=True
        )
        return told.stdout
    if program == "pip":  # what is tested is installed
        return ""
    assert program == "stickslip", f"a page runs {program}"
    before = {path: path.stat().st_mtime_ns for path in Path().glob("*.toml")}
    result = CliRunner().invoke(main, words, catch_exceptions=False)
    assert result.exit_code == 0, result.output
    new = [path for path in Path().glob("*.toml") if path.stat().st_mtime_ns != before.get(path)]
    return "\n".join([result.output, *(path.read_text(encoding="utf-8") for path in new)])


def accepted(line: str) -> None:
    """A command that is not run has at least options that there are."""
    program, *words = shlex.split(line, comments=True)
    if program != "stickslip":
        assert program != "python" or (ROOT / words[0]).exists()
        return
    name, *words = words
    found = main.get_command(click.Context(main), name)
    assert found is not None, name
    found.make_context(name, words)


def squeezed(text: str) -> str:
    return " ".join(text.split())
