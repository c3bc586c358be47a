"""Sphinx reads docstrings as they are meant: bars, stars and underscores of formulas are no markup.

Examples are left as they are: a program is a program.
"""

from __future__ import annotations

import re
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from sphinx.application import Sphinx

BEFORE_NAPOLEON, AFTER_NAPOLEON = 400, 600
EXAMPLE = re.compile(r"(^[ ]*>>>.*?(?:\n[ ]*\n|\Z))", re.DOTALL | re.MULTILINE)  # up to an empty line


def plain(text: str) -> str:
    """Return a docstring whose only markup is what stands between backticks, examples apart."""
    return "".join(one if one.lstrip().startswith(">>>") else _prose(one) for one in EXAMPLE.split(text))


def _prose(text: str) -> str:
    kept = re.split(r"(`[^`]+`)", re.sub(r"(`[^`\n]+`)(?=s\b)", r"\1\\ ", text))  # several of a `Link`
    return "".join(one if one.startswith("`") else _escaped(one) for one in kept)


def _escaped(prose: str) -> str:
    prose = re.sub(r"(?<!^)(?<!\n)([|*])", r"\\\1", prose)
    return re.sub(r"(\w)_(?=\W|$)", r"\1\\_", prose)


def _process(_: Sphinx, __: str, ___: str, ____: object, _____: object, lines: list[str]) -> None:
    lines[:] = plain("\n".join(lines)).split("\n")


def singly(lines: list[str]) -> list[str]:
    """Return fields of attributes that share their words, `:ivar a, b: words`, as one field each."""
    out: list[str] = []
    fields: list[tuple[str, list[str], list[str]]] = []  # kind, names, lines

    def done() -> None:
        for kind, names, words in fields:
            for name in names:
                out.extend([f":{kind} {name}:{words[0]}", *words[1:]])
        fields.clear()

    for line in lines:
        found = re.match(r"^:(ivar|vartype) (\S+(?:, \S+)*):(.*)$", line)
        if found:
            done()
            fields.append((found[1], found[2].split(", "), [found[3]]))
        elif fields and line.startswith(" "):
            fields[0][2].append(line)
        else:
            done()
            out.append(line)
    done()
    return out


def _split(_: Sphinx, __: str, ___: str, ____: object, _____: object, lines: list[str]) -> None:
    lines[:] = singly(lines)


def setup(app: Sphinx) -> dict[str, Any]:
    """Connect before numpydoc sections are read, and after."""
    app.connect("autodoc-process-docstring", _process, priority=BEFORE_NAPOLEON)
    app.connect("autodoc-process-docstring", _split, priority=AFTER_NAPOLEON)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
