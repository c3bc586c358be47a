"""What a numpydoc docstring says, for the pages made from the code."""

from __future__ import annotations

import inspect
import re
from dataclasses import dataclass


@dataclass(frozen=True)
class Told:
    """A docstring in parts: first paragraph, further paragraphs, and parameters as (names, words)."""

    summary: str
    more: tuple[str, ...]
    parameters: tuple[tuple[tuple[str, ...], str], ...]


def told(of: object) -> Told:
    """Return what the docstring of a class or function says."""
    text = inspect.getdoc(of) or ""
    prose, *sections = re.split(r"\n([A-Z][a-z ]+)\n-{3,}\n", text)
    by_name = dict(zip(sections[::2], sections[1::2], strict=True))
    summary, *more = (one.strip() for one in re.split(r"\n\s*\n", prose))
    return Told(summary, tuple(one for one in more if one), tuple(_parameters(by_name.get("Parameters", ""))))


def _parameters(section: str) -> list[tuple[tuple[str, ...], str]]:
    found: list[tuple[tuple[str, ...], list[str]]] = []
    for line in section.splitlines():
        if line and not line.startswith(" "):
            found.append((tuple(one.strip() for one in line.split(":")[0].split(",")), []))
        elif line.strip() and found:
            found[-1][1].append(line.strip())
    return [(names, " ".join(words)) for names, words in found]


def escaped(text: str) -> str:
    """Return prose of a docstring as MyST shows it word for word: names and bars are no markup."""
    kept = re.split(r"(`[^`]*`)", text)
    return "".join(one if one.startswith("`") else re.sub(r"([*_|<>\[\]$^])", r"\\\1", one) for one in kept)
