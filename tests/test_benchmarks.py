"""What benchmarks print is stored as it is, and the site's page has nothing else."""

from __future__ import annotations

import importlib.util
import json
import re
from pathlib import Path
from types import ModuleType

import pytest

from website import benchmarks

ROOT = Path(__file__).parent.parent


@pytest.fixture(scope="module")
def bench() -> ModuleType:
    spec = importlib.util.spec_from_file_location("bench_run", ROOT / "bench" / "run.py")
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_what_a_benchmark_prints_is_stored(bench: ModuleType, tmp_path: Path) -> None:
    program = tmp_path / "bench_filter.py"
    program.write_text('"""What it is.\n\nMore."""\nprint("rate  2.5")\nprint("  error 1e-9")\n')
    assert bench.run(program, tmp_path / "results" / "filter.json")
    kept = json.loads((tmp_path / "results" / "filter.json").read_text())
    assert kept["what"] == "What it is."
    assert kept["command"] == "python bench/bench_filter.py"
    assert kept["printed"] == ["rate  2.5", "  error 1e-9"]
    page = benchmarks.page(tmp_path / "results")
    assert "```text\nrate  2.5\n  error 1e-9\n```" in page
    assert kept["build"]["isa"] in page
    assert "python bench/bench_filter.py\n" in page
    assert "- `python bench/bench_sweep.py`" in page
    assert "- `python bench/bench_filter.py`" not in page


def test_a_benchmark_that_fails_is_not_stored(bench: ModuleType, tmp_path: Path) -> None:
    program = tmp_path / "bench_wrong.py"
    program.write_text('"""Wrong."""\nprint("1")\nraise SystemExit("the answers differ")\n')
    assert not bench.run(program, tmp_path / "wrong.json")
    assert not (tmp_path / "wrong.json").exists()


def test_a_result_of_a_benchmark_that_is_gone_is_seen(tmp_path: Path) -> None:
    (tmp_path / "gone.json").write_text("{}")
    with pytest.raises(ValueError, match="of no benchmark"):
        benchmarks.page(tmp_path)


def test_a_name_that_is_none_is_one_line(bench: ModuleType, capsys: pytest.CaptureFixture[str]) -> None:
    assert bench.main(["--store", "filtre"]) == 2
    assert "no benchmark 'filtre'" in capsys.readouterr().err


def test_the_table_of_signals_is_what_is_stored() -> None:
    stored = benchmarks.stored(benchmarks.RESULTS)["derivatives"]["printed"]
    kept = [tuple(re.split(r"\s{2,}", line.strip())) for line in stored[1:] if line]
    text = (ROOT / "docs" / "signals.md").read_text(encoding="utf-8")
    shown = re.findall(r"^\| (0\.\d+) \| (.*?) \| (\S+) \| (\S+) \|$", text, re.MULTILINE)
    assert len(shown) == 18
    assert shown == kept
