"""Every block of commands, programs and tables that the documents show is run or read, or says why it is not."""

from __future__ import annotations

import re
import tomllib
from pathlib import Path

import pytest

import page_folder
import stickslip as ss
from pages_run import DOCS, ROOT, Reader, Step, steps
from quick_figures import quickly
from stickslip.declared.laws import ALL_LAWS
from studies import few
from website import laws

PAGES = {str(path.relative_to(ROOT)): path for path in [ROOT / "README.md", *sorted(DOCS.rglob("*.md"))]}
ELSEWHERE = {  # pages that another test follows, which may ask for more than what the page prints
    "docs/sweeps.md": "test_the_page_of_sweeps_runs_from_top_to_bottom",
    "docs/derivatives.md": "test_the_branch_of_the_page_is_the_one_it_tells_of",
    "docs/rigs.md": "test_the_page_of_rigs_runs_from_top_to_bottom",
    "docs/tutorial.md": "test_a_page_does_what_it_says",
    "docs/index.md": "test_the_first_page_begins_as_the_readme_does",
}
ELSEWHERE |= {
    one: "test_the_programs_of_a_rig_print_what_its_page_says" for one in PAGES if "docs/rigs/" in one
}
TABLES = {  # pages whose tables in TOML another test reads
    "docs/case.md": "test_the_cases_of_the_page",
    "docs/emps.md": "test_the_tables_of_emps_are_those_of_the_example",
}
FOLLOWED = {name: steps(page) for name, page in PAGES.items() if name not in ELSEWHERE}
FOLLOWED = {name: found for name, found in FOLLOWED.items() if found}


LONG = (  # pages that search or fit much
    "docs/how-to/forecast.md",
    "docs/how-to/read-a-report.md",
    "docs/how-to/fit-a-law.md",
    "docs/how-to/compare-two-models.md",
    "docs/discovery.md",
)


@pytest.mark.parametrize("page", few(FOLLOWED, [one for one in FOLLOWED if one not in LONG]))
def test_a_page_runs_from_top_to_bottom(page: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    quickly(monkeypatch)  # what is printed is compared, no figure
    if "docs/how-to/" not in page:  # those write what they need
        page_folder.prepare(tmp_path)
    reader = Reader()
    for step in FOLLOWED[page]:
        if step.language == "toml":
            tomllib.loads(step.text)
            assert step.file or page in TABLES, f"nothing reads {step.text}"
        assert step.language != "text" or step.not_run or step.file, f"nothing prints {step.text}"
        reader.follow(step)


def test_pages_that_are_followed_elsewhere_are() -> None:
    tests = "\n".join(path.read_text(encoding="utf-8") for path in Path(__file__).parent.glob("test_*.py"))
    for name in {*ELSEWHERE.values(), *TABLES.values()}:
        assert f"\ndef {name}(" in tests


def test_commands_stand_in_blocks() -> None:
    """Those that are indented only would be overlooked."""
    for name, page in PAGES.items():
        text = re.sub(r"^```.*?^```$", "", page.read_text(encoding="utf-8"), flags=re.DOTALL | re.MULTILINE)
        assert re.findall(r"^    (?:stickslip|python|import) .*$", text, re.MULTILINE) == [], name


def test_the_first_page_begins_as_the_readme_does() -> None:
    first, readme = (
        next(one.text for one in steps(PAGES[name]) if one.language == "sh")
        for name in ("docs/index.md", "README.md")
    )
    lines = [re.sub(r" +#.*", "", line) for line in readme.splitlines()]
    assert first.splitlines()[1:] == lines


def test_the_tables_of_emps_are_those_of_the_example() -> None:
    example = tomllib.loads((ROOT / "examples/emps/rig.toml").read_text(encoding="utf-8"))
    (shown,) = (tomllib.loads(one.text) for one in steps(PAGES["docs/emps.md"]) if one.language == "toml")
    assert {name: example[name] for name in shown} == shown


@pytest.mark.parametrize("kind", laws.EXAMPLES)
def test_the_example_of_a_law_is_one_in_toml_and_in_python(kind: str, tmp_path: Path) -> None:
    page = tmp_path / "law.md"
    page.write_text(laws.page(ALL_LAWS[kind]), encoding="utf-8")
    table, program = steps(page)
    reader = Reader()
    reader.follow(program)
    (tmp_path / "model.toml").write_text('[rig]\nkind = "block_on_belt"\nm = 1.0\nk = 1.0\n\n' + table.text)
    assert ss.load_model(tmp_path / "model.toml").friction == reader.names["law"]


def test_what_a_page_says_wrongly_is_seen(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    page = tmp_path / "page.md"
    page.write_text(
        "<!-- file: a.toml -->\n```toml\na = 1\n```\n\n```python\nprint(1)\n```\n\n```text\n2\n```\n\n"
        "<!-- not run: for ever -->\n\n```sh\nstickslip explore --nowhere\n```\n"
    )
    table, program, served = steps(page)
    Reader().follow(table)
    assert Path("a.toml").read_text() == "a = 1\n"
    with pytest.raises(AssertionError):
        Reader().follow(program)
    assert served.not_run == "for ever"
    with pytest.raises(Exception, match="nowhere"):
        Reader().follow(served)
    with pytest.raises(AssertionError, match="not printed"):
        Reader().follow(Step("sh", "stickslip --version\n", said="version of nothing\n"))
    with pytest.raises(AssertionError, match="a page runs rm"):
        Reader().follow(Step("sh", "rm -r .\n"))
