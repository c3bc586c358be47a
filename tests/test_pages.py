"""The report's page in a browser: three widths, dark, on paper, without scripts; its figures against the results."""

from __future__ import annotations

import base64
import dataclasses
import gzip
import json
from pathlib import Path

import numpy as np
import pytest
from matplotlib.figure import Figure

from browser import WIDTHS, chromium, program
from found_by_hand import made
from stickslip.discovery.result import Found
from stickslip.likelihoods.interval import Interval
from stickslip.shown.pages.filters import agreement
from stickslip.shown.pages.interactive import interactive, plain
from stickslip.shown.report.write import write_report

MOST = 3_500_000  # bytes of a page
CANVASES = """() => {
  let found = 0;
  const look = (root) => { for (const one of root.querySelectorAll('*')) {
    if (one.tagName === 'CANVAS') found += 1;
    if (one.shadowRoot) look(one.shadowRoot); } };
  look(document);
  return found;
}"""


@pytest.fixture(scope="module")
def report(tmp_path_factory: pytest.TempPathFactory) -> tuple[Found, Path]:
    program()
    folder = tmp_path_factory.mktemp("page")
    found, case = made(folder)
    scatter = {"static": Interval(0.031, 0.022, 0.041), "belt": Interval(0.01, None, None)}
    found = dataclasses.replace(found, scatter=scatter)
    write_report(found, case, folder / "out", command="stickslip discover 'my rig' --out found")
    return found, folder / "out" / "report.html"


@pytest.mark.parametrize("width", WIDTHS)
def test_the_page_fits_complains_of_nothing_and_asks_for_nothing(
    report: tuple[Found, Path], width: str
) -> None:
    _, path = report
    wide, high = WIDTHS[width]
    with chromium(viewport={"width": wide, "height": high}) as seen:
        seen.page.goto(path.as_uri())
        seen.scroll()
        assert seen.complaints == []
        assert [one for one in seen.asked if not one.startswith("data:")] == [path.as_uri()]
        assert seen.sideways() <= 0
        panels = seen.page.locator(".panel").count()
        assert panels > 10
        assert seen.page.evaluate(CANVASES) >= panels
        assert not seen.page.locator(".drawn").first.is_visible()


def test_a_figure_zooms_and_shows_values(report: tuple[Found, Path]) -> None:
    _, path = report
    with chromium(viewport={"width": 1000, "height": 900}) as seen:
        page = seen.page
        page.goto(path.as_uri())
        seen.scroll()
        page.locator("#friction-panel-0").scroll_into_view_if_needed()
        page.wait_for_timeout(500)
        plot = "Bokeh.documents.flatMap((d) => d.roots()).find((r) => r.id.startsWith('friction-'))"
        before = page.evaluate(f"{plot}.x_range.end - {plot}.x_range.start")
        box = page.locator("#friction-panel-0").bounding_box()
        x, y = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
        page.mouse.move(x, y)
        page.mouse.down()
        page.mouse.move(x + 120, y + 80, steps=5)
        page.mouse.up()
        page.wait_for_timeout(300)
        after = page.evaluate(f"{plot}.x_range.end - {plot}.x_range.start")
        assert 0 < after < 0.5 * before
        assert seen.complaints == []


def test_dark_is_dark_and_paper_has_the_drawn_figures(report: tuple[Found, Path], tmp_path: Path) -> None:
    _, path = report
    lightness = "getComputedStyle(document.querySelector('main')).backgroundColor.match(/\\d+/g).map(Number)"
    with chromium(viewport={"width": 900, "height": 900}, color_scheme="dark") as seen:
        page = seen.page
        page.goto(path.as_uri())
        assert max(page.evaluate(lightness)) < 60
        page.emulate_media(media="print", color_scheme="dark")
        assert min(page.evaluate(lightness)) == 255
        assert page.locator(".drawn").first.is_visible()
        assert not page.locator(".live").first.is_visible()
        page.pdf(path=str(tmp_path / "paper.pdf"), format="A4")
        assert (tmp_path / "paper.pdf").stat().st_size > 50_000


def test_without_scripts_the_drawn_figures_are_shown(report: tuple[Found, Path]) -> None:
    _, path = report
    with chromium(java_script_enabled=False) as seen:
        seen.page.goto(path.as_uri())
        assert seen.page.locator(".drawn svg").first.is_visible()
        assert not seen.page.locator(".live").first.is_visible()


def test_contents_downloads_command_and_plain_words(report: tuple[Found, Path]) -> None:
    found, path = report
    assert path.stat().st_size < MOST
    with chromium() as seen:
        page = seen.page
        page.goto(path.as_uri())
        links = page.eval_on_selector_all("nav a", "all => all.map((a) => a.getAttribute('href'))")
        assert links == page.eval_on_selector_all("h2", "all => all.map((h) => '#' + h.id)")
        assert "stickslip discover 'my rig' --out found" in page.inner_text(".facts")
        files = page.eval_on_selector_all("a[download]", "all => all.map((a) => [a.download, a.href])")
        held = {name: base64.b64decode(link.partition(",")[2]).decode() for name, link in files}
        assert json.loads(held["report.json"]) == json.loads((path.parent / "report.json").read_text())
        assert held["model_after.toml"] == found.after.toml()
        words = page.inner_text("main")
        assert "static friction, at the end of a stick" in words
        assert "3.1\u00a0%" in words
        assert "m: mass of the block" in words


@pytest.mark.parametrize(
    ("low", "high", "words"),
    [(0.98, 1.01, "agrees"), (1.1, 1.2, "differs by 15\u00a0%"), (None, 1.0, "the runs do not tell")],
)
def test_agreement_of_a_declared_number(low: float | None, high: float | None, words: str) -> None:
    row = {"value": 1.0, "uncertainty": 0.015, "runs": {"value": 1.15, "low": low, "high": high}}
    assert agreement(row) == words
    assert agreement({**row, "runs": None}) == "not asked of the runs"


def _arrays(text: str) -> list[np.ndarray]:
    """Every array of Bokeh's JSON."""
    found: list[np.ndarray] = []

    def look(value: object) -> None:
        if isinstance(value, dict):
            if value.get("type") == "ndarray":
                raw = gzip.decompress(base64.b64decode(value["array"]["data"]))
                found.append(np.frombuffer(raw, dtype=value["dtype"]))
            for one in value.values():
                look(one)
        elif isinstance(value, list):
            for one in value:
                look(one)

    look(json.loads(text))
    return found


def test_a_figure_keeps_its_numbers_ranges_and_rows() -> None:
    figure = Figure()
    left, right = figure.subplots(1, 2, sharey=True)
    x = np.linspace(0.0, 3.0, 7)
    left.plot(x, x**2, "--", color="#ff0000", label="a law $v_w$")
    left.axhline(1.0)
    left.axhspan(-2, 2, color="#00ff00")
    left.set_xlim(0.5, 2.5)
    left.set_xlabel("reading of $x_1$ [mm]")
    left.legend()
    right.plot([1, 2], [0, 1], "o")
    right.set_yticks([0, 1], ["first", "second"])
    figure.draw_without_rendering()
    made = interactive(figure, "small")
    again = interactive(figure, "small")
    assert made == again
    assert made.columns == 2
    assert made.below[0] == "reading of x1 [mm]"
    assert [(key.words, key.colour, key.dash) for key in made.legend] == [("a law v_w", "#ff0000", "dashed")]
    assert any(np.allclose(one, x**2) for one in _arrays(made.document) if one.dtype == np.float32)
    parts = json.loads(made.document)
    kinds = made.document
    assert kinds.count('"name":"Range1d"') + kinds.count('"name": "Range1d"') == 3  # y is shared
    assert "Span" in kinds
    assert "BoxAnnotation" in kinds
    assert "second" in kinds
    assert len(parts["item"]["roots"]) == 2


def test_words_of_axes_are_plain() -> None:
    assert plain("friction force $T$ [N]") == "friction force T [N]"
    assert plain("rate of the reading, $\\dot x_1$ [mm/s]") == "rate of the x1 reading [mm/s]"
