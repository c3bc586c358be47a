"""The page of benchmarks, from what `python bench/run.py --store` kept: nothing on it is typed."""

from __future__ import annotations

import json
import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any

BENCH = Path(__file__).parent.parent.parent / "bench"
RESULTS = BENCH / "results"


def write(folder: Path, results: Path = RESULTS) -> list[str]:
    """Write the page into the folder; return its name."""
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "index.md").write_text(page(results), encoding="utf-8")
    return ["index"]


def stored(results: Path) -> dict[str, Mapping[str, Any]]:
    """Return the results in a folder by the name of their benchmark.

    Raises
    ------
    ValueError
        There is no such benchmark: the result is of another version.
    """
    found = {}
    for path in sorted(results.glob("*.json")):
        if not (BENCH / f"bench_{path.stem}.py").exists():
            raise ValueError(f"{path} is of no benchmark that there is")
        found[path.stem] = json.loads(path.read_text(encoding="utf-8"))
    return found


def page(results: Path) -> str:
    """Return the page of the results in a folder."""
    found = stored(results)
    parts = [
        "# Benchmarks",
        "Every number below was printed by the command above it and kept by `python bench/run.py --store`. This page "
        "is made of what was kept. A benchmark that finds a wrong answer fails, and is not kept. Times are of one "
        "machine, as busy as it says; errors and counts are not.",
    ]
    parts += [section(name, one) for name, one in found.items()]
    rest = [
        path.stem
        for path in sorted(BENCH.glob("bench_*.py"))
        if path.stem.removeprefix("bench_") not in found
    ]
    if rest:
        parts += ["## Not stored", "These take long, or need data or rivals that are installed apart:"]
        parts.append("\n".join(f"- `python bench/{one}.py`" for one in rest))
    return "\n\n".join(parts) + "\n"


def section(name: str, result: Mapping[str, Any]) -> str:
    """Return the section of one benchmark."""
    machine, build = result["machine"], result["build"]
    how = "" if result["installed"] else ", from the source tree"
    told = (
        f"*{result['date']}, version {build['version']}{how}; {machine['processor']}, {machine['cores']} cores, "
        f"load {machine['load']} before it began; {build['compiler']}, instruction set {build['isa']}. "
        f"It took {result['seconds']:.0f} s.*"
    )
    if machine["load"] > machine["cores"]:
        told += "\n\n*Other programs ran at the same time: every time is longer than on a quiet machine.*"
    lines = [line for line in result["printed"] if not re.match(r'^\{"build"', line)]
    printed = "\n".join(lines).strip("\n")
    what = re.sub(r"([*_<>|])", r"\\\1", str(result["what"]))
    return f"## {name}\n\n{what}\n\n```sh\n{result['command']}\n```\n\n```text\n{printed}\n```\n\n{told}"
