"""The census of the package: what its rooms hold, and whether the arrows between them keep their way.

    python tools/census.py [FOLDER]     FOLDER holds the package `stickslip`; python/ of this checkout if not given

Prints, for every room: files, lines, constants (numbers with a name at the top of a module), class names that another
file uses too, and arrows that run back up; then those class names, and the circles of files that import each other.
"""

from __future__ import annotations

import ast
import sys
from collections import Counter, defaultdict
from pathlib import Path

import grimp
import numpy as np
import scipy.sparse
from rich.console import Console
from rich.table import Table

# in the order in which data goes through them; a room uses only those before it
ROOMS = ["declared", "measured", "simulated", "fitted", "likelihoods", "discovery", "shown", "cli"]
GROUND = "(ground)"  # errors, arguments, files: what every room stands on


def room_of(module: str) -> str:
    """The room of a module by its dotted name."""
    parts = module.split(".")
    return parts[1] if len(parts) > 1 and parts[1] in ROOMS else GROUND


def constants(tree: ast.Module) -> int:
    """How many numbers have a name at the top of a module."""
    found = 0
    for node in tree.body:
        if isinstance(node, ast.Assign | ast.AnnAssign) and node.value is not None:
            targets = node.targets if isinstance(node, ast.Assign) else [node.target]
            named = any(isinstance(t, ast.Name | ast.Tuple) and ast.unparse(t).isupper() for t in targets)
            numbers = any(
                isinstance(n, ast.Constant) and type(n.value) in (int, float) for n in ast.walk(node.value)
            )
            found += named and numbers
    return found


def circles(names: list[str], arrows: list[tuple[str, str]]) -> list[list[str]]:
    """The sets of files that reach each other by their imports."""
    at = {name: i for i, name in enumerate(names)}
    rows, columns = [at[a] for a, _ in arrows], [at[b] for _, b in arrows]
    graph = scipy.sparse.coo_array((np.ones(len(rows)), (rows, columns)), shape=(len(names), len(names)))
    _, label = scipy.sparse.csgraph.connected_components(graph, connection="strong")
    groups = defaultdict(list)
    for name, one in zip(names, label, strict=True):
        groups[one].append(name)
    return [sorted(group) for group in groups.values() if len(group) > 1]


def main(folder: Path) -> None:
    """Count, and print."""
    sys.path.insert(0, str(folder))
    graph = grimp.build_graph("stickslip", cache_dir=None)
    root = folder / "stickslip"
    sources = {
        "stickslip" + "".join(f".{p}" for p in file.relative_to(root).with_suffix("").parts): file
        for file in sorted(root.rglob("*.py"))
    }
    trees = {name: ast.parse(file.read_text(encoding="utf-8")) for name, file in sources.items()}
    classes = Counter(n.name for t in trees.values() for n in t.body if isinstance(n, ast.ClassDef))
    modules = sorted(graph.modules)
    arrows = [
        (a, b) for a in modules for b in graph.find_modules_directly_imported_by(a) if b != "stickslip" != a
    ]
    back = [
        (a, b)
        for a, b in arrows
        if GROUND not in (room_of(a), room_of(b)) and ROOMS.index(room_of(b)) > ROOMS.index(room_of(a))
    ]
    table = Table("room", "files", "lines", "constants", "class names used twice", "arrows back up")
    total = [0] * 5
    for room in [GROUND, *ROOMS]:
        inside = [name for name in sources if room_of(name.removesuffix(".__init__")) == room]
        row = [
            len(inside),
            sum(len(sources[n].read_text(encoding="utf-8").splitlines()) for n in inside),
            sum(constants(trees[n]) for n in inside),
            sum(classes[c.name] > 1 for n in inside for c in trees[n].body if isinstance(c, ast.ClassDef)),
            sum(room_of(a) == room for a, _ in back),
        ]
        total = [a + b for a, b in zip(total, row, strict=True)]
        if inside:
            table.add_row(room, *map(str, row))
    table.add_row("all", *map(str, total))
    console = Console()
    console.print(table)
    for a, b in back:
        console.print(f"back up: {a} -> {b}")
    twice = sorted(name for name, times in classes.items() if times > 1)
    console.print(f"{len(twice)} class names used twice: {', '.join(twice)}")
    found = circles(modules, arrows)
    console.print(f"{len(found)} circles of files that import each other")
    for group in found:
        console.print(f"  {len(group)}: {', '.join(group)}")


if __name__ == "__main__":
    main(Path(sys.argv[1]).resolve() if len(sys.argv) > 1 else Path(__file__).parents[1] / "python")
