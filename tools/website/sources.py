"""The pages as Sphinx reads them: those of docs/, with links that lead somewhere, and those made from the code."""

from __future__ import annotations

import re
import shutil
from pathlib import Path

from website import api, benchmarks, effects, gallery, laws

ROOT = Path(__file__).parent.parent.parent
DOCS = ROOT / "docs"
PAGES = {
    "CHANGELOG.md": "changelog.md",
    "CONTRIBUTING.md": "contributing.md",
}  # of the repository, as pages of the site
MADE = ("api", "laws", "effects_of", "gallery", "benchmarks")  # folders of pages that are made from the code
LAWS = re.compile(r"python/stickslip/declared/(?:friction|formula_laws)/(\w+)\.py")
BETTER = {  # what a page of the repository links to, and the page of the site that says more
    "docs/effects.md#friction-laws": "laws/index.md",
    "bench/results": "benchmarks/index.md",
    "examples/gallery": "gallery/index.md",
}
LINK = re.compile(r"(?P<before>!?\[(?P<words>[^\]]*)\])\((?P<to>[^)#\s]+)(?P<anchor>#[^)]*)?\)")


def prepare(folder: Path) -> None:
    """Write all sources of the site into a folder, which is emptied first."""
    shutil.rmtree(folder, ignore_errors=True)
    shutil.copytree(DOCS, folder, ignore=shutil.ignore_patterns("__pycache__"))
    for name, page in PAGES.items():
        shutil.copyfile(ROOT / name, folder / page)
    for path in sorted(folder.rglob("*.md")):
        home = ROOT if path.name in PAGES.values() else DOCS / path.relative_to(folder).parent
        path.write_text(inside(path.read_text(encoding="utf-8"), home, folder, path), encoding="utf-8")
    api.write(folder / "api")
    laws.write(folder / "laws")
    effects.write(folder / "effects_of")
    gallery.write(folder / "gallery")
    benchmarks.write(folder / "benchmarks")


def better_page(name: str) -> str | None:
    """Return the page of the site that is made of what a link to the repository leads to, if there is one."""
    law = LAWS.fullmatch(name)
    return f"laws/{law[1]}.md" if law else BETTER.get(name)


def inside(text: str, home: Path, folder: Path, path: Path) -> str:
    """Return a page whose links to files of the repository lead to pages of the site, or to copies of the files."""
    depth = len(path.relative_to(folder).parts) - 1
    up = "../" * depth

    def led(match: re.Match[str]) -> str:
        to, anchor = match["to"], match["anchor"] or ""
        if "://" in to or to.startswith("mailto:"):
            return match[0]
        target = (home / to).resolve()
        if not target.is_relative_to(ROOT):
            return match[0]
        if better := better_page(f"{target.relative_to(ROOT)}{anchor}"):
            return f"{match['before']}({up}{better})"
        if target.is_relative_to(DOCS):
            return f"{match['before']}({up}{target.relative_to(DOCS)}{anchor})"
        name = str(target.relative_to(ROOT))
        if name in PAGES:
            return f"{match['before']}({up}{PAGES[name]}{anchor})"
        if name == "README.md":
            return f"{match['before']}({up}index.md)"
        if not target.is_file():
            return f"`{name}`"
        name += ".txt" if name.endswith(".md") else ""  # or it would be a page
        copy = folder / "files" / name
        copy.parent.mkdir(parents=True, exist_ok=True)
        shutil.copyfile(target, copy)
        return f"{match['before']}({up}files/{name})"

    fences = re.split(r"(^```.*?^```$)", text, flags=re.DOTALL | re.MULTILINE)
    return "".join(one if one.startswith("```") else LINK.sub(led, one) for one in fences)
