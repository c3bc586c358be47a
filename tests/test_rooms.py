"""The rooms of the package: their arrows go one way, and no two files import each other in a circle."""

import importlib.util
import subprocess
import sys
from pathlib import Path

import grimp
import pytest

ROOT = Path(__file__).parent.parent


@pytest.fixture(scope="module")
def census() -> object:
    spec = importlib.util.spec_from_file_location("census", ROOT / "tools" / "census.py")
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_a_room_uses_only_the_rooms_before_it() -> None:
    code = "from importlinter.cli import lint_imports; raise SystemExit(lint_imports(no_cache=True))"
    told = subprocess.run([sys.executable, "-c", code], cwd=ROOT, capture_output=True, text=True, check=False)
    assert told.returncode == 0, told.stdout + told.stderr


def test_no_files_import_each_other_in_a_circle(census: object) -> None:
    graph = grimp.build_graph("stickslip", cache_dir=None)
    modules = sorted(graph.modules)
    arrows = [(a, b) for a in modules for b in graph.find_modules_directly_imported_by(a) if b != "stickslip"]
    assert census.circles(modules, arrows) == []  # type: ignore[attr-defined]


def test_a_circle_is_seen(census: object) -> None:
    names = ["a", "b", "c", "d"]
    assert census.circles(names, [("a", "b"), ("b", "c"), ("c", "a"), ("c", "d")]) == [["a", "b", "c"]]  # type: ignore[attr-defined]
