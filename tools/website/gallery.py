"""The gallery: every program of examples/gallery is run; its page shows it, what it prints and what it draws.

A program begins with a docstring, a title and what there is to see, and leaves a matplotlib figure named `figure`.
"""

from __future__ import annotations

import ast
import contextlib
import io
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from website.law_figures import save

if TYPE_CHECKING:
    from matplotlib.figure import Figure

PROGRAMS = Path(__file__).parent.parent.parent / "examples" / "gallery"


@dataclass(frozen=True)
class Shown:
    """A program, its title and words, what it printed, and its figure."""

    program: str
    title: str
    words: str
    printed: str
    figure: Figure


def run(path: Path) -> Shown:
    """Run a program of the gallery."""
    text = path.read_text(encoding="utf-8")
    title, _, words = (ast.get_docstring(ast.parse(text)) or "").partition("\n")
    names: dict[str, object] = {"__name__": path.stem}
    with contextlib.redirect_stdout(io.StringIO()) as printed:
        exec(compile(text, str(path), "exec"), names)
    program = text.split('"""', 2)[2].strip()
    return Shown(program, title.rstrip("."), words.strip(), printed.getvalue(), names["figure"])  # type: ignore[arg-type]


def write(folder: Path) -> list[str]:
    """Write a page for every program into the folder, and the list of them; return their names, the list first."""
    folder.mkdir(parents=True, exist_ok=True)
    names, cards = [], []
    for path in sorted(PROGRAMS.glob("*.py")):
        shown = run(path)
        save(shown.figure, folder / f"{path.stem}.svg")
        output = f"\n```text\n{shown.printed}```\n" if shown.printed else ""
        page = (
            f"# {shown.title}\n\n{shown.words}\n\n![{shown.title}]({path.stem}.svg)\n{output}\n"
            f"```python\n{shown.program}\n```\n\nThe program is `examples/gallery/{path.name}`.\n"
        )
        (folder / f"{path.stem}.md").write_text(page, encoding="utf-8")
        cards.append(
            f"## [{shown.title}]({path.stem}.md)\n\n![{shown.title}]({path.stem}.svg)\n\n{shown.words}"
        )
        names.append(path.stem)
    toc = "\n".join(names)
    body = "\n\n".join(cards)
    text = (
        "# Gallery\n\nEvery program is run when this site is built. Each is short; copy it and change it."
        f"\n\n{body}\n\n```{{toctree}}\n:hidden:\n\n{toc}\n```\n"
    )
    (folder / "index.md").write_text(text, encoding="utf-8")
    return ["index", *names]
