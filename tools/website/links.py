"""Links of the built site that lead nowhere: Sphinx looks at those that it made itself, and not at all of them."""

from __future__ import annotations

import re
from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote


class _Page(HTMLParser):
    """The anchors of a page, and what it links to."""

    def __init__(self) -> None:
        super().__init__()
        self.anchors: set[str] = set()
        self.links: set[str] = set()

    def handle_starttag(self, _tag: str, attrs: list[tuple[str, str | None]]) -> None:
        """Keep what a tag names and what it links to."""
        for name, value in attrs:
            if value and name == "id":
                self.anchors.add(value)
            elif value and name in ("href", "src"):
                self.links.add(value)


def dead_links(site: Path) -> list[str]:
    """Return "page: link" for every relative link whose file or anchor is not there."""
    pages = {path.resolve(): _Page() for path in sorted(site.rglob("*.html"))}
    for path, page in pages.items():
        page.feed(path.read_text(encoding="utf-8"))
    return [
        f"{path.relative_to(site.resolve())}: {link}"
        for path, page in pages.items()
        for link in sorted(page.links)
        if not re.match(r"[a-z]+:|//", link) and not _leads(link, path, pages)
    ]


def _leads(link: str, path: Path, pages: dict[Path, _Page]) -> bool:
    name, _, anchor = link.partition("#")
    name = unquote(name.partition("?")[0])
    target = (path.parent / name).resolve() if name else path
    if target not in pages or not anchor:
        return target.exists()
    return unquote(anchor) in pages[target].anchors
