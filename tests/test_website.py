"""The site: it is made from the code, its pages hang together, and a reader needs no network."""

import re
from pathlib import Path

import numpy as np
import pytest

import stickslip as ss
from browser import chromium
from pages_run import DOCS, Reader, steps
from stickslip.declared.catalogue import KINDS
from stickslip.declared.laws import ALL_LAWS, FORMULA_LAWS, LAWS
from website import api, effect_figures, effects, gallery, laws, sources
from website.docstrings import plain
from website.links import dead_links
from website.mathml import mathml
from website.tex import tex

ROOT = Path(__file__).parent.parent
FUNCTIONS = {"exp": np.exp, "max": np.maximum, "abs": abs}


def test_every_public_name_is_in_the_reference_once() -> None:
    shown = [name for _, names in api.GROUPS.values() for name in names]
    assert sorted([*shown, "__version__"]) == sorted(ss.__all__)


@pytest.mark.parametrize("kind", LAWS)
def test_the_equations_of_a_page_are_those_of_the_law(kind: str) -> None:
    law = LAWS[kind](**laws.EXAMPLES[kind])
    both = law.equations * (2 if len(law.equations) == 1 else 1)
    for sign, (_, kinetic, static), limit in zip((-1, 1), both, law.static_limits, strict=True):
        u = np.linspace(0.01, 1, 50)
        names = {**law.numbers, **FUNCTIONS, "u": u}
        np.testing.assert_allclose(eval(kinetic, names) + 0 * u, law.magnitude(sign * u), rtol=1e-12)
        assert eval(static, names) == limit


@pytest.mark.parametrize("kind", [*FORMULA_LAWS, *LAWS])
def test_every_law_has_its_equations_and_every_number_a_unit(kind: str) -> None:
    page = laws.page(ALL_LAWS[kind])
    if kind not in ("formula", "tabulated"):
        assert len(re.findall(r"^\$\$\n", page, re.MULTILINE)) >= 2
    for one in re.findall(r"\$\$\n(.*?)\n\$\$", page, re.DOTALL):
        assert mathml(one, block=True).startswith("<math")
    for row in re.findall(r"^\| `(\w+)`.*\|$", page, re.MULTILINE):
        assert row in page.split("## Parameters")[1]


def test_a_unit_is_not_broken_over_lines() -> None:
    assert "| N/m, N\N{NO-BREAK SPACE}s/m, N\N{NO-BREAK SPACE}s/m |" in laws.page(ALL_LAWS["lugre"])


def test_a_formula_in_tex() -> None:
    assert tex("F_s*(1 + b*log(1 + dwell/tau))") == (
        r"F_{s}\,\left(1 + b\,\ln\left(1 + \frac{\mathrm{dwell}}{\tau}\right)\right)"
    )
    assert tex("a - (b - c)") == r"a - \left(b - c\right)"
    assert tex("sigma0*z_rate") == r"\sigma_{0}\,\dot{z}"


def test_every_effect_has_a_section_and_numbers_to_be_drawn_with() -> None:
    for kind in KINDS.values():
        assert effects.page_of(kind) in effects.PLACES
        assert ss.effect(kind.name, **kind.drawn).parameters.items() >= kind.drawn.items()


@pytest.mark.parametrize("kind", ["sensor_lag", "sensor_crosstalk", "sensor_drift", "stribeck_peak"])
def test_an_effect_that_is_drawn_changes_what_is_drawn(kind: str) -> None:
    t = np.linspace(0, 20, 401)
    before, after = effect_figures.read(None, t), effect_figures.read(kind, t)
    assert max(np.ptp(a - b) for a, b in zip(before, after, strict=True)) > 0.01


def test_a_late_reading_is_drawn_late() -> None:
    t, late = np.linspace(0, 20, 401), KINDS["sensor_delay"].drawn["delay"]
    rig = ss.Rig(alpha1=16, alpha2=8, beta3=4, eta1=0.1, eta12=0.2)
    times = t[10:] - late
    run = ss.simulate(
        ss.Model(rig, friction=ss.PaperFriction()),
        belt_speed=0.1,
        initial=(0.1, 0.1, 0, 0),
        t_end=20,
        t_eval=times,
    )
    np.testing.assert_allclose(effect_figures.read("sensor_delay", t)[1][10:], run.state[:, 2], atol=1e-3)


def test_formulas_in_docstrings_are_no_markup() -> None:
    assert plain("R(|v|) of T_- and `T_s`; `Link`s") == r"R(\|v\|) of T\_- and `T_s`; `Link`\ s"


def test_every_page_is_reached_from_the_first() -> None:
    seen, ahead = set(), ["index"]
    while ahead:
        page = ahead.pop()
        seen.add(page)
        path = DOCS / f"{page}.md"
        if not path.exists():  # made when the site is built
            continue
        trees = re.findall(r"```\{toctree\}\n(.*?)```", path.read_text(encoding="utf-8"), re.DOTALL)
        entries = [line for tree in trees for line in tree.splitlines() if line and not line.startswith(":")]
        home = Path(page).parent
        ahead += [str(home / one) for one in entries if str(home / one) not in seen]
    written = {str(path.relative_to(DOCS).with_suffix("")) for path in DOCS.rglob("*.md")}
    made = {f"{one}/index" for one in sources.MADE} | {"changelog", "contributing"}
    assert seen == written | made


def test_links_out_of_docs_lead_to_copies_and_pages(tmp_path: Path) -> None:
    page = tmp_path / "rigs" / "one.md"
    text = "[a](../CONTRIBUTING.md#commands) [b](../examples/emps/rig.toml) [c](../tests) [d](model.md) ![e](x.png)"
    made = sources.inside(text, DOCS, tmp_path, page)
    assert made == (
        "[a](../contributing.md#commands) [b](../files/examples/emps/rig.toml) `tests` [d](../model.md) "
        "![e](../x.png)"
    )
    assert (tmp_path / "files/examples/emps/rig.toml").exists()


def test_links_to_what_the_site_makes_a_page_of_lead_to_that_page(tmp_path: Path) -> None:
    text = (
        "[a](effects.md#friction-laws) [b](../python/stickslip/declared/friction/coulomb.py) "
        "[c](../bench/results) [d](effects.md)"
    )
    made = sources.inside(text, DOCS, tmp_path, tmp_path / "one.md")
    assert made == "[a](laws/index.md) [b](laws/coulomb.md) [c](benchmarks/index.md) [d](effects.md)"
    kinds = [law.__module__.rpartition(".")[2] for law in ALL_LAWS.values()]
    assert kinds == list(ALL_LAWS)  # a law's page is named after its file


def test_a_dead_link_of_the_built_site_is_seen(tmp_path: Path) -> None:
    (tmp_path / "b").mkdir()
    (tmp_path / "b/two.html").write_text('<h1 id="here">x</h1><a href="../one.html">x</a><img src="no.png">')
    (tmp_path / "one.html").write_text(
        '<a href="b/two.html#here"></a><a href="b/two.html#gone"></a><a href="#"></a><a href="https://x.org"></a>'
    )
    assert dead_links(tmp_path) == ["b/two.html: no.png", "one.html: b/two.html#gone"]


@pytest.mark.parametrize("path", sorted(gallery.PROGRAMS.glob("*.py")), ids=lambda path: path.stem)
def test_the_gallery_runs(path: Path) -> None:
    shown = gallery.run(path)
    assert shown.title
    assert shown.words
    assert shown.figure.axes


LONG = (  # the studies below
    "stickslip identify",
    "stickslip compare",
    "stickslip discover",
    "stickslip forecast found",
    "import stickslip as ss",
)


@pytest.mark.parametrize("page", ["tutorial"])
def test_a_page_does_what_it_says(page: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    reader = Reader()
    for step in steps(DOCS / f"{page}.md"):
        if not step.text.startswith(LONG):
            reader.follow(step)


@pytest.mark.parametrize("page", sorted(DOCS.glob("rigs/[!i]*.md")), ids=lambda page: page.stem)
def test_the_programs_of_a_rig_print_what_its_page_says(page: Path) -> None:
    reader = Reader()
    for step in steps(page):
        assert step.said != ""
        reader.follow(step)
    assert reader.names["figure"].axes
    assert (DOCS / f"figures/rig_{page.stem}.svg").exists()


@pytest.mark.study
def test_the_fit_and_the_search_of_the_tutorial(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    wanted = ("stickslip example", "stickslip init", *LONG[:-1])
    for step in steps(DOCS / "tutorial.md"):
        if step.text.startswith(wanted):
            Reader().follow(step)


@pytest.mark.study
def test_the_program_of_the_tutorial(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """It identifies what the command identified."""
    monkeypatch.chdir(tmp_path)
    (program,) = (step for step in steps(DOCS / "tutorial.md") if step.language == "python")
    Reader().follow(program)


def test_a_reader_needs_no_network_and_finds_a_word(tmp_path: Path) -> None:
    sphinx = pytest.importorskip("sphinx.cmd.build")
    source, out = tmp_path / "source", tmp_path / "out"
    source.mkdir()
    (source / "_static").mkdir()
    (source / "_static/site.css").write_bytes((DOCS / "_static/site.css").read_bytes())
    (source / "conf.py").write_text(
        (DOCS / "conf.py").read_text().replace("HERE.parent", f"Path({str(ROOT)!r})")
    )
    (source / "index.md").write_text("# First\n\n```{toctree}\nmodel\n```\n")
    (source / "model.md").write_text(
        "# The rig\n\nA block rides a belt.\n\n$$\nT = \\frac{a}{b}\n$$\n\n```python\na = 1\n```\n"
    )
    assert sphinx.build_main(["-q", "-W", str(source), str(out)]) == 0
    with chromium(viewport={"width": 390, "height": 844}) as seen:
        seen.page.goto((out / "model.html").as_uri())
        assert seen.page.locator("math mfrac").count() == 1
        assert seen.sideways() <= 0
        seen.page.goto((out / "search.html").as_uri() + "?q=belt")
        seen.page.wait_for_selector("#search-results a[href^='model.html']")
    assert seen.complaints == []
    assert [one for one in seen.asked if not one.startswith("file:")] == []
