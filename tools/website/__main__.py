"""Build the site: `python tools/website [FOLDER]`, build/site if it is left out. Warnings are errors."""

from __future__ import annotations

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent.parent))

from website.links import dead_links
from website.sources import ROOT, prepare


def build(out: Path) -> int:
    """Write the sources and let Sphinx make pages of them; return Sphinx's exit code, or 1 for dead links."""
    from sphinx.cmd.build import build_main

    work = out.with_name(f".{out.name}")
    prepare(work / "source")
    code = int(
        build_main(["-q", "-W", "--keep-going", "-d", str(work / "cache"), str(work / "source"), str(out)])
    )
    gone = dead_links(out)
    for one in gone:
        print(f"a link that leads nowhere: {one}", file=sys.stderr)
    return code or int(bool(gone))


if __name__ == "__main__":
    folder = Path(sys.argv[1]) if len(sys.argv) > 1 else ROOT / "build" / "site"
    code = build(folder)
    if code == 0:
        print(folder / "index.html")
    sys.exit(code)
