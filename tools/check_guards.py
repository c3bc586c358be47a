"""Plant a fault for each guard in a copy of the sources and see that the guard names it.

A guard that nobody has seen fail may be switched off without anyone noticing. Each fault here is one
that its guard must find, in a copy with the project's own settings; the guard must fail and its output
must contain the fault's name, so that failing for another reason does not count.
"""

import os
import re
import shutil
import subprocess
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path

PATH = f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"
ROOT = Path(__file__).parent.parent
FACE = "python/stickslip/planted.py"
CORE = "cpp/src/planted.cpp"
TEST = "cpp/tests/test_planted.cpp"
DOCTEST = '#include <doctest/doctest.h>\n#include <climits>\n#include <vector>\nTEST_CASE("planted") {\n'
HEAP = "std::vector<int> v(4); volatile int i = 4; CHECK(v.data()[i] != 12345); }\n"
OVERFLOW = "volatile int i = INT_MAX; i = i + 1; CHECK(i < 0); }\n"
LEAK = """#include "stickslip/isa.hpp"
namespace stickslip {
[[gnu::noinline]] inline double shared(double x) { return x * x; }
namespace STICKSLIP_ISA { double kernel(double x); double kernel(double x) { return shared(x); } }
}
"""


@dataclass(frozen=True)
class Fault:
    """One planted fault: where it goes, which command must fail, and by what name."""

    guard: str
    path: str
    text: str
    command: str
    says: str


FAULTS = (
    Fault("ruff check", FACE, "import os\n", f"ruff check {FACE}", "F401"),
    Fault("ruff format", FACE, "x = {  1:2 }\n", f"ruff format --check {FACE}", "would be reformatted"),
    Fault("mypy", FACE, "def f(x: int) -> str:\n    return x\n", f"mypy {FACE}", "return-value"),
    Fault(
        "arrows between the rooms",
        "python/stickslip/declared/planted.py",
        "from stickslip.fitted import shooting\n\nshooting.shoot\n",
        "PYTHONPATH=python lint-imports --no-cache",
        "stickslip.declared.planted -> stickslip.fitted.shooting",
    ),
    Fault("mypy strict", FACE, "def f(x):\n    return x\n", f"mypy {FACE}", "no-untyped-def"),
    Fault(
        "pytest warnings are errors",
        "tests/test_planted.py",
        "import warnings\n\n\ndef test_planted():\n    warnings.warn('planted')\n",
        "python -m pytest -q -p no:cacheprovider tests/test_planted.py",
        "UserWarning: planted",
    ),
    Fault(
        "clang-format",
        CORE,
        "int  f( );\n",
        f"clang-format --dry-run -Werror {CORE}",
        "clang-format-violations",
    ),
    Fault(
        "clang-tidy",
        CORE,
        "#include <string>\n#include <utility>\nstd::size_t f(std::string s);\n"
        "std::size_t f(std::string s) { std::string t = std::move(s); return t.size() + s.size(); }\n",
        f"clang-tidy --quiet {CORE} -- -std=c++20",
        "bugprone-use-after-move",
    ),
    Fault(
        "-Wconversion -Werror",
        CORE,
        "int f(double x);\nint f(double x) { return x; }\n",
        "cmake --preset dev && cmake --build build/dev --target core",
        "-Werror=float-conversion",
    ),
    Fault(
        "-Wall -Werror",
        CORE,
        "int f();\nint f() { int unused = 0; return 1; }\n",
        "cmake --preset dev && cmake --build build/dev --target core",
        "-Werror=unused-variable",
    ),
    Fault(
        "address sanitizer",
        TEST,
        DOCTEST + HEAP,
        "cmake --preset asan && cmake --build --preset asan && build/asan/core_tests",
        "heap-buffer-overflow",
    ),
    Fault(
        "undefined-behaviour sanitizer",
        TEST,
        DOCTEST + OVERFLOW,
        "cmake --preset asan && cmake --build --preset asan && build/asan/core_tests",
        "signed integer overflow",
    ),
    Fault(
        "weak symbols of AVX objects",
        "cpp/src/planted_kernel.cpp",
        LEAK,
        "cmake --preset dev && cmake --build build/dev --target kernel_avx2 && python tools/check_symbols.py",
        "stickslip::shared(double)",
    ),
    Fault(
        "stub",
        "python/stickslip/_core.pyi",
        "def removed_long_ago() -> int: ...\n",
        "python tools/stubs.py --check",
        "_core.pyi is stale",
    ),
)


def copy_sources(to: Path) -> None:
    """Copy what the guards read; the core is reduced to one small source, its settings stay."""
    for name in ("pyproject.toml", "CMakeLists.txt", "CMakePresets.json", ".clang-format", ".clang-tidy"):
        shutil.copy(ROOT / name, to)
    for name in ("cmake", "cpp", "python", "tools"):
        shutil.copytree(ROOT / name, to / name, ignore=shutil.ignore_patterns("__pycache__", "*.so"))
    (to / "tests").mkdir()
    (to / CORE).write_text("")
    (to / TEST).write_text("")
    (to / "cpp/src/planted_kernel.cpp").write_text("")
    lists = to / "CMakeLists.txt"
    text = lists.read_text()
    for start, sources in (
        ("add_library(core STATIC", f"cpp/src/isa.cpp {CORE}"),
        ("set(kernel_sources", "cpp/src/planted_kernel.cpp"),
        ("add_executable(core_tests", f"cpp/tests/main.cpp {TEST}"),
    ):
        text, count = re.subn(rf"{re.escape(start)}[^)]*\)", f"{start} {sources})", text)
        if count != 1:
            raise SystemExit(f"check_guards: CMakeLists.txt has {count} times {start!r}, expected once")
    lists.write_text(text)


def finds(fault: Fault, root: Path) -> bool:
    """Plant the fault, run its guard, undo the planting."""
    place = root / fault.path
    before = place.read_text() if place.exists() else None
    place.write_text(fault.text)
    try:
        result = subprocess.run(
            fault.command,
            shell=True,
            cwd=root,
            env=os.environ | {"PATH": PATH},
            capture_output=True,
            text=True,
            timeout=300,
            check=False,
        )
    finally:
        place.unlink() if before is None else place.write_text(before)
    output = result.stdout + result.stderr
    seen = result.returncode != 0 and fault.says in output
    print(f"{'found   ' if seen else 'MISSED  '} {fault.guard}: {fault.says}")
    if not seen:
        print(f"  exit {result.returncode} of: {fault.command}\n  " + "\n  ".join(output.splitlines()[-20:]))
    return seen


def main() -> int:
    """Plant them all, or those whose guard's name contains the argument."""
    with tempfile.TemporaryDirectory() as folder:
        root = Path(folder)
        copy_sources(root)
        results = [
            finds(fault, root) for fault in FAULTS if all(word in fault.guard for word in sys.argv[1:])
        ]
    print(f"{sum(results)} of {len(results)} planted faults found")
    return int(not results or not all(results))


if __name__ == "__main__":
    sys.exit(main())
