"""Figures that matplotlib takes seconds to write, written at once: for tests of the files, not of what is drawn."""

import io
from pathlib import Path

import pytest
from matplotlib.figure import Figure

SVG = '<svg xmlns="http://www.w3.org/2000/svg" width="10pt" height="10pt"></svg>'


def saved_empty(_: Figure, to: Path | io.IOBase, **__: object) -> None:
    """In the place of `Figure.savefig`: an empty figure."""
    if isinstance(to, io.IOBase):
        to.write(SVG.encode())
    else:
        Path(to).write_text(SVG, encoding="utf-8")


def not_saved(*_: object, **__: object) -> None:
    """In the place of `Figure.savefig`: an error."""
    raise RuntimeError("no figure today")


def quickly(monkeypatch: pytest.MonkeyPatch) -> None:
    """Let figures be neither laid out nor drawn, only saved empty."""
    monkeypatch.setattr(Figure, "draw_without_rendering", lambda _: None)
    monkeypatch.setattr(Figure, "savefig", saved_empty)
