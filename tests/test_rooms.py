"""The rooms of the package: their arrows go one way, and no two files import each other in a circle."""

import ast
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


def from_the_face(text: str) -> set[str]:
    """What a module imports of the package itself, which takes its names from every room."""
    found = set()
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, ast.ImportFrom) and node.module == "stickslip":
            found |= {one.name for one in node.names}
        elif isinstance(node, ast.Import):
            found |= {"everything" for one in node.names if one.name == "stickslip"}
    return found


def test_no_room_but_the_last_takes_a_name_from_the_face() -> None:
    """The compiled core and the modules that every room stands on alone; import-linter sees no name of the face."""
    package = ROOT / "python" / "stickslip"
    for file in package.rglob("*.py"):
        if package / "cli" not in file.parents:
            taken = from_the_face(file.read_text()) - {"_core", "arguments", "errors", "files", "progress"}
            assert not taken, file


def test_a_name_of_the_face_is_seen() -> None:
    text = "import stickslip\ndef f():\n    from stickslip import Model, _core\n"
    assert from_the_face(text) == {"everything", "Model", "_core"}


def test_a_circle_is_seen(census: object) -> None:
    names = ["a", "b", "c", "d"]
    assert census.circles(names, [("a", "b"), ("b", "c"), ("c", "a"), ("c", "d")]) == [["a", "b", "c"]]  # type: ignore[attr-defined]
