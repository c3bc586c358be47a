"""The skeleton of every page: head, contents, body, style and script in one HTML text that loads nothing."""

from __future__ import annotations

import base64
import os
import re
import shlex
from collections.abc import Mapping
from dataclasses import dataclass
from datetime import UTC, datetime
from importlib.resources import files
from pathlib import Path
from typing import Any

from jinja2 import ChoiceLoader, Environment, PackageLoader, StrictUndefined
from markupsafe import Markup
from matplotlib.figure import Figure

from stickslip.declared.rig import AnyRig, BlockOnBelt, DrivenSlider
from stickslip.declared.rigs.general import GeneralRig
from stickslip.measured.case import Case
from stickslip.shown.pages.filters import FILTERS
from stickslip.shown.pages.interactive import Interactive, interactive, script
from stickslip.shown.plot.curves import save_figure


@dataclass(frozen=True)
class Saved:
    """A figure that was drawn: its file as SVG, and the same for a page."""

    svg: Path
    live: Interactive | None


@dataclass(frozen=True)
class PageFigure:
    """A figure in a page: the drawn one, for paper, and the one that zooms."""

    drawn: Markup
    live: Interactive | None


class PageContents:
    """The headings of a page in their order, collected while its body is rendered."""

    def __init__(self) -> None:
        self.lines: list[tuple[str, str]] = []

    def heading(self, name: str, words: str) -> Markup:
        """A heading that the list of contents leads to."""
        self.lines.append((name, words))
        return Markup('<h2 id="{}">{}</h2>').format(name, words)


def saved(figure: Figure, folder: Path, name: str) -> Saved:
    """Save a figure as SVG and PNG and take it over for a page."""
    path = save_figure(figure, folder / name)[0]
    return Saved(path, interactive(figure, name))


def shown(drawings: Mapping[str, Saved]) -> dict[str, PageFigure]:
    """Figures as a page takes them."""
    return {name: PageFigure(inline(one.svg, name), one.live) for name, one in drawings.items()}


def render(package: str, template: str, given: Mapping[str, Any]) -> str:
    """The page as one HTML text: a template of a package gives its head and its body, the rest is the same for all.

    Parameters
    ----------
    package : str
        Where the template is.
    template : str
        Its name; its macro `head_of_page` is the head, all else the body, a heading `contents.heading(name, words)`.
    given : mapping
        What the template uses; `title` names the page, `figures` are those of `shown`.
    """
    environment = Environment(
        loader=ChoiceLoader([PackageLoader("stickslip.shown.pages", ""), PackageLoader(package, "")]),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.filters |= FILTERS
    contents = PageContents()
    module = environment.get_template(template).make_module({**given, "contents": contents})
    live = any(one.live is not None for one in given["figures"].values())
    here = files("stickslip.shown.pages")
    return environment.get_template("page.html.j2").render(
        title=given["title"],
        style=Markup((here / "page.css").read_text(encoding="utf-8")),
        head=module.head_of_page(),  # type: ignore[attr-defined]
        body=Markup(str(module)),
        contents=contents.lines,
        script=Markup(script().replace("</script", "<\\/script")) if live else "",
        behaviour=Markup((here / "page.js").read_text(encoding="utf-8")),
    )


def inline(path: Path, prefix: str) -> Markup:
    """An SVG for a place in a page: its header dropped, its names made its own, scaled to the page's width."""
    text = path.read_text(encoding="utf-8")
    text = text[text.index("<svg") :]
    text = re.sub(r"<metadata>.*?</metadata>", "", text, flags=re.DOTALL)
    text = re.sub(r'\bid="', f'id="{prefix}-', text)
    text = text.replace("url(#", f"url(#{prefix}-").replace('href="#', f'href="#{prefix}-')
    text = re.sub(r'<svg ([^>]*?)\bwidth="([\d.]+)pt"', r'<svg \1style="max-width:\2pt"', text, count=1)
    text = re.sub(r'(<svg [^>]*?)\bheight="[\d.]+pt"', r'\1role="img"', text, count=1)
    return Markup(text)  # drawn by us from numbers; names in it are escaped by matplotlib


def download(text: str, kind: str) -> str:
    """A link that holds a file, so that the page can travel alone."""
    return f"data:{kind};base64,{base64.b64encode(text.encode()).decode()}"


def today() -> str:
    """The day in UTC; that of SOURCE_DATE_EPOCH where it is set, for files that come out the same again."""
    given = os.environ.get("SOURCE_DATE_EPOCH", "")
    now = datetime.fromtimestamp(int(given), UTC) if given.isdigit() else datetime.now(UTC)
    return now.strftime("%-d %B %Y")


def command(case: Case) -> str:
    """The command that makes a report again, where nobody says which it was."""
    return shlex.join(["stickslip", "discover", case.path.name, "--out", "found"])


def rig(one: AnyRig) -> str:
    """The rig in words."""
    if isinstance(one, BlockOnBelt):
        return "a block on a belt, held by a spring"
    if isinstance(one, DrivenSlider):
        return "a slider that is driven along its guide"
    if isinstance(one, GeneralRig):
        names = one.equations.names
        return f"a rig of {len(names)} coordinate{'s' * (len(names) > 1)}: {', '.join(names)}"
    return "a block on a belt, coupled to an angle body: two degrees of freedom"
