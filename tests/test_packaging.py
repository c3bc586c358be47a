"""Files that repeat what pyproject.toml says agree with it."""

from __future__ import annotations

import re
import tomllib
from pathlib import Path

import pytest

ROOT = Path(__file__).parent.parent
SETTINGS = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
PROJECT = SETTINGS["project"]


def section(text: str, name: str) -> list[str]:
    """Items of a list in the recipe."""
    found = re.search(rf"^    {name}:|^  {name}:", text, re.MULTILINE)
    assert found, name
    lines = text[found.end() :].strip("\n").splitlines()
    items = []
    for line in lines:
        if not line.strip().startswith("- "):
            break
        items.append(line.strip()[2:])
    return items


def test_the_conda_recipe_asks_for_what_the_package_does() -> None:
    text = (ROOT / "packaging" / "conda" / "recipe.yaml").read_text(encoding="utf-8")
    asked = {one.replace("matplotlib-base", "matplotlib").replace(" ", "") for one in section(text, "run")}
    assert asked - {"python"} == set(PROJECT["dependencies"])
    assert f'version: "{PROJECT["version"]}"' in text


def test_the_citation_is_of_this_version() -> None:
    text = (ROOT / "CITATION.cff").read_text(encoding="utf-8")
    assert re.search(r"^version: (\S+)$", text, re.MULTILINE)[1] == PROJECT["version"]


def test_cmake_has_the_version_too() -> None:
    text = (ROOT / "CMakeLists.txt").read_text(encoding="utf-8")
    assert f"project(stickslip VERSION {PROJECT['version']} " in text


@pytest.mark.parametrize("file", ["noxfile.py", ".pre-commit-config.yaml"])
@pytest.mark.parametrize("tool", ["ruff", "clang-format"])
def test_hooks_have_the_versions_of_the_environment(file: str, tool: str) -> None:
    pinned = next(
        one.partition("==")[2]
        for one in PROJECT["optional-dependencies"]["test"]
        if one.startswith(f"{tool}==")
    )
    text = (ROOT / file).read_text(encoding="utf-8")
    for version in re.findall(rf"{tool}(?:==|-pre-commit\s+rev: v|\s+rev: v)([\d.]+)", text):
        assert version == pinned
    if file.startswith(".pre"):
        assert f"v{pinned}" in text


def test_every_python_with_a_classifier_gets_a_wheel() -> None:
    built = SETTINGS["tool"]["cibuildwheel"]["build"].split()
    said = [one.rpartition(" ")[2] for one in PROJECT["classifiers"] if re.search(r":: 3\.\d+$", one)]
    assert {f"cp{one.replace('.', '')}-*" for one in said} == {one for one in built if "t-" not in one}


def test_every_entry_of_a_paper_is_cited_and_every_citation_is_there() -> None:
    text = (ROOT / "paper" / "paper.md").read_text(encoding="utf-8")
    entries = re.findall(r"^@\w+\{(\w+),", (ROOT / "paper" / "paper.bib").read_text(encoding="utf-8"), re.M)
    assert set(re.findall(r"@(\w+\d{4})", text)) == set(entries)
