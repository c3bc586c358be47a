"""What the documents show works, and what they point at exists."""

import re
import shlex
from pathlib import Path
from typing import Any

import click
import numpy as np
import pytest
from click.testing import CliRunner

import stickslip as ss
from effects_page import PAGE, page
from stickslip.cli.commands import main

ROOT = Path(__file__).parent.parent
PAGES = sorted(
    path
    for place in ("*.md", "bench/**/*.md", "docs/**/*.md", "examples/**/*.md")
    for path in ROOT.glob(place)
)


def snippets(name: str, language: str) -> list[str]:
    page = (ROOT / "docs" / f"{name}.md").read_text(encoding="utf-8")
    return re.findall(rf"```{language}\n(.*?)```", page, re.DOTALL)


README = (ROOT / "README.md").read_text()


def test_the_readme_shows_every_command_with_options_it_has() -> None:
    lines = [shlex.split(one) for one in re.findall(r"\| `stickslip ([^`]*)`", README)]
    context = click.Context(main)
    assert {line[0] for line in lines} == set(main.list_commands(context))
    for name, *words in lines:
        command = main.get_command(context, name)
        assert command is not None
        command.make_context(name, words)  # refuses an option it has not, or one that is missing


@pytest.mark.study
def test_the_page_of_sweeps_runs_from_top_to_bottom(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)  # where its figures go
    shown: dict[str, Any] = {}
    for one in snippets("sweeps", "python"):
        exec(compile(one, "docs/sweeps.md", "exec"), shown)
    ds = shown["ds"]
    assert {1, 2} <= set(np.unique(ds.periodicity).tolist())  # the map is of more than one colour
    assert float((ds.periodicity == 0).mean()) < 0.02  # and settled


def test_the_two_bifurcations_that_the_page_of_sweeps_tells_of() -> None:
    rig = ss.Rig(alpha1=10, alpha2=8, beta3=4, eta1=0.1, eta12=0.2)
    branch = ss.continuation(ss.Model(rig, friction=ss.PaperFriction()), 0.15, span=(0.12, 0.22))
    told = [(one.kind, f"{one.value:.3f}") for one in branch.special]
    assert told == [("crossing", "0.166"), ("neimark_sacker", "0.196")]


@pytest.mark.study
def test_the_branch_of_the_page_is_the_one_it_tells_of(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    shown: dict[str, Any] = {}
    for one in snippets("derivatives", "python"):
        exec(compile(one, "docs/derivatives.md", "exec"), shown)
    assert [f"{one.value:.7f}" for one in shown["branch"].special] == [
        "2.8923458",
        f"{(30**0.5 - 1) / 3:.7f}",
    ]
    assert shown["found"].chaotic
    assert shown["ss"].continuation(shown["leine"], 1.0, span=(0.5, 3.5)).special[0].kind == "loss_of_stick"


def test_the_sweep_of_the_page_is_the_example(tmp_path: Path) -> None:
    pytest.importorskip("zarr")
    example = ROOT / "examples" / "sweep" / "sweep.toml"
    (shown,) = snippets("sweeps", "toml")
    assert shown in example.read_text(encoding="utf-8")
    result = CliRunner().invoke(main, ["sweep", str(example), "--out", str(tmp_path / "result.zarr")])
    assert result.exit_code == 0, result.output
    assert "180 members: 180 finished" in result.output


def anchors(page: str) -> set[str]:
    """The anchors that GitHub and the site give to the headings of a page."""
    heads = re.findall(r"^#+ +(.*)$", re.sub(r"^```.*?^```$", "", page, flags=re.DOTALL | re.MULTILINE), re.M)
    return {re.sub(r"[^\w -]", "", one).strip().lower().replace(" ", "-") for one in heads}


def dead_links(page: Path) -> list[str]:
    """Links of a page that lead to no file of the repository, or to no heading of it."""
    text = re.sub(r"^```.*?^```$", "", page.read_text(encoding="utf-8"), flags=re.DOTALL | re.MULTILINE)
    gone = []
    for link in re.findall(r"\]\(([^)\s]+)\)", text):
        if re.match(r"[a-z]+:", link):
            continue
        name, _, anchor = link.partition("#")
        target = page.parent / name if name else page
        read = target.exists() and anchor and target.suffix == ".md"
        if not target.exists() or (read and anchor not in anchors(target.read_text(encoding="utf-8"))):
            gone.append(link)
    return gone


@pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(ROOT)))
def test_links_inside_the_repository_lead_somewhere(page: Path) -> None:
    assert dead_links(page) == []


def test_a_dead_link_is_seen(tmp_path: Path) -> None:
    (tmp_path / "other.md").write_text("# The `one` heading: long\n\n```sh\n# none\n```\n")
    page = tmp_path / "page.md"
    page.write_text(
        "# Here\n[a](other.md) [b](other.md#the-one-heading-long) [c](gone.md) [d](other.md#none) [e](#here) "
        "[f](#there) [g](https://example.org/x#y)\n```text\n[h](gone.md)\n```\n"
    )
    assert dead_links(page) == ["gone.md", "other.md#none", "#there"]


def test_the_tests_named_by_the_readings_exist() -> None:
    named = set(re.findall(r"`(test_\w+)`", (ROOT / "docs/model.md").read_text()))
    defined = {
        name
        for path in (ROOT / "tests").glob("test_*.py")
        for name in re.findall(r"^def (test_\w+)", path.read_text(), re.MULTILINE)
    }
    assert named >= {"test_the_filter_looks_back"}
    assert named <= defined


def test_the_page_of_effects_is_the_catalogue() -> None:
    assert PAGE.read_text() == page(), "stale: run `python tests/effects_page.py`"


def test_the_page_of_rigs_runs_from_top_to_bottom(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    shown: dict[str, Any] = {}
    for one in snippets("rigs", "python"):
        exec(compile(one, "docs/rigs.md", "exec"), shown)
    told = capsys.readouterr().out
    slip = 2 * (np.pi - np.arctan(0.0016 * 1000**0.5 / 0.01)) / 1000**0.5
    assert f"{2 * 0.0016 / 0.01 + slip:.6f}" in told  # the pulled slider's period, in closed form
    grown = [float(one) for one in re.findall(r"is (\S+) times what it was", told)]
    assert grown[0] < 0.9 < 1.1 < grown[1]
    assert float(re.findall(r"difference (\S+)", told)[0]) < 1e-9  # LuGre built in, and as a formula
    assert re.search(r"by the numbers of effects: -?\d", told)
    drill, matrices, formula, effects = (
        one for one in snippets("rigs", "toml") if re.search(r"^\[+(rig|effect)\]", one, re.M)
    )
    for name, text in (("drill", drill), ("matrices", matrices), ("formula", formula)):
        (tmp_path / f"{name}.toml").write_text(text)
    assert ss.load_model("drill.toml") == shown["model"]
    (tmp_path / "dragged.toml").write_text(drill + effects)
    _, pressed, mud = ss.load_model("dragged.toml").effects
    assert (pressed.where, pressed.by) == ("bit", "table")
    assert mud.formula == shown["mud"].formula
    assert mud.parameters == shown["mud"].parameters
    named = ss.Model(ss.Rig(alpha1=16, alpha2=8, beta3=4, eta1=0.1, eta12=0.2), friction=ss.PaperFriction())
    core = ss.simulate(named, belt_speed=0.1, initial=(0.1, 0.1, 0, 0), t_end=40)
    run = ss.simulate(ss.load_model("matrices.toml"), belt_speed=0.1, initial=(0.1, 0, 0.1, 0), t_end=40)
    np.testing.assert_allclose(run.transitions.t, core.transitions.t, atol=1e-8)
    commands = [line.removeprefix("stickslip ").strip() for line in snippets("rigs", "sh")]
    for command in [*commands, "simulate formula.toml --belt-speed '5 mm/s' --t-end '2 s' --out own.csv"]:
        result = CliRunner().invoke(main, shlex.split(command), catch_exceptions=False)
        assert result.exit_code == 0, result.output
