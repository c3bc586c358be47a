"""The report: its JSON against the schema, its page, its files; on a result put together by hand."""

from __future__ import annotations

import dataclasses
import hashlib
import json
import re
from html.parser import HTMLParser
from pathlib import Path

import jsonschema
import numpy as np
import pytest
from matplotlib.figure import Figure

import found_by_hand
import stickslip as ss
from found_by_hand import SCHEMA, made
from quick_figures import not_saved, quickly
from stickslip.discovery.result import Found
from stickslip.discovery.workers import Workers
from stickslip.files import RECORD, folder
from stickslip.fitted.readings import reading_rate
from stickslip.shown.driven_slider import figures as driven_figures
from stickslip.shown.general_rig import figures as general_figures
from stickslip.shown.report import files, motion, words
from stickslip.shown.report.contents import contents
from stickslip.shown.report.files import NAMES
from stickslip.shown.report.page import FIGURES, draw, page
from stickslip.shown.report.write import fill, write_report

VERDICTS = ("effect_found", "no_effect", "unlisted_effect")


@dataclasses.dataclass(frozen=True)
class Written:
    """A result, its case, and what `write_report` said that it wrote into the folder."""

    found: Found
    case: ss.Case
    out: Path
    said: list[Path]


@pytest.fixture(autouse=True)
def drawn_here(monkeypatch: pytest.MonkeyPatch) -> None:
    """Processes that a search of another test has left would not see what a test here replaces."""
    monkeypatch.setattr(Workers, "at_hand", lambda: Workers(1))


def few_figures(monkeypatch: pytest.MonkeyPatch) -> None:
    """Draw two of the figures alone."""
    few = {name: FIGURES[name] for name in ("errors", "learned_curve")}
    monkeypatch.setattr("stickslip.shown.report.page.FIGURES", few)


@pytest.fixture(scope="module")
def written(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Written]:
    """A report of every verdict, written once, by this process alone; all figures are drawn for one of them."""
    out = {}
    for verdict in VERDICTS:
        place = tmp_path_factory.mktemp(verdict)
        found, case = made(place, verdict=verdict)
        with pytest.MonkeyPatch.context() as patch:
            if verdict != "effect_found":
                few_figures(patch)
            out[verdict] = Written(found, case, place / "out", list(write_report(found, case, place / "out")))
    return out


@pytest.fixture(scope="module")
def reports(written: dict[str, Written]) -> dict[str, tuple[Found, Path]]:
    """The results and the folders."""
    return {verdict: (one.found, one.out) for verdict, one in written.items()}


@pytest.mark.parametrize("verdict", VERDICTS)
@pytest.mark.parametrize("si", [True, False])
def test_json_follows_the_schema(tmp_path: Path, verdict: str, si: bool) -> None:
    found, case = made(tmp_path, si=si, verdict=verdict)
    text = json.dumps(contents(found, case), allow_nan=False)  # raises on NaN and infinity
    report = json.loads(text)
    jsonschema.Draft202012Validator.check_schema(SCHEMA)
    jsonschema.validate(report, SCHEMA)
    assert list(report)[:3] == ["format", "title", "verdict"]
    assert report["format"] == 2  # 1 was that of version 0.1.0, whose bic and error mean something else
    assert report["error"]["runs"][0]["period"]["after"] is None  # it was NaN


@pytest.mark.parametrize(
    ("spoil", "why"),
    [
        (lambda r: r.update(verdict="maybe"), "maybe"),
        (lambda r: r["error"].pop("floor"), "floor"),
        (lambda r: r["effects"][0]["parameters"]["tau"].pop("high"), "high"),
        (lambda r: r.update(effects=[]), "non-empty|too short"),
    ],
)
def test_the_schema_refuses_a_spoilt_report(tmp_path: Path, spoil: object, why: str) -> None:
    report = json.loads(json.dumps(contents(*made(tmp_path))))
    spoil(report)  # type: ignore[operator]
    with pytest.raises(jsonschema.ValidationError, match=why):
        jsonschema.validate(report, SCHEMA)


def test_models_are_complete_and_read_back(reports: dict[str, tuple[Found, Path]]) -> None:
    found, out = reports["effect_found"]
    assert ss.load_model(out / "model_before.toml") == found.before
    assert ss.load_model(out / "model_after.toml") == found.after


class _Page(HTMLParser):
    """Collects what a page loads from elsewhere, its names, and whether its tags close."""

    VOID = frozenset({"meta", "link", "br", "img", "hr"})

    def __init__(self) -> None:
        super().__init__()
        self.open: list[str] = []
        self.ids: list[str] = []
        self.loads: list[str] = []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        given = dict(attrs)
        self.ids += [given["id"]] if given.get("id") else []  # type: ignore[list-item]
        target = given.get("src") or given.get("href") or given.get("xlink:href") or "#"
        if not target.startswith("#") and not target.startswith("data:"):
            self.loads.append(target)
        if tag == "iframe" or (tag == "link" and given.get("rel") != "icon"):
            self.loads.append(tag)
        if tag not in self.VOID:
            self.open.append(tag)

    def handle_startendtag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.handle_starttag(tag, attrs)
        if tag not in self.VOID:
            self.open.pop()

    def handle_endtag(self, tag: str) -> None:
        assert self.open.pop() == tag


@pytest.mark.parametrize("verdict", VERDICTS)
def test_page_stands_alone_and_says_the_verdict(reports: dict[str, tuple[Found, Path]], verdict: str) -> None:
    found, out = reports[verdict]
    text = (out / "report.html").read_text(encoding="utf-8")
    parsed = _Page()
    parsed.feed(text)
    assert parsed.open == []
    assert parsed.loads == []
    assert len(parsed.ids) == len(set(parsed.ids))
    unscripted = re.sub(r"<script.*?</script>", "", text, flags=re.DOTALL)
    for name in re.findall(r"url\(#([^)]+)\)", unscripted):
        assert name in parsed.ids
    assert words.headline(found) in text
    assert "nan" not in re.sub(r"<(svg|script).*?</\1>", "", text, flags=re.DOTALL).lower().split()
    assert text.count('<div class="drawn"><svg') == len(list((out / "figures").glob("*.svg")))
    assert len(list((out / "figures").glob("*.png"))) == len(list((out / "figures").glob("*.svg")))


def test_page_shows_the_tie_the_experiment_and_what_is_not_identified(
    reports: dict[str, tuple[Found, Path]],
) -> None:
    text = (reports["effect_found"][1] / "report.html").read_text(encoding="utf-8")
    assert "these runs cannot tell which" in text
    assert "exact, by algebra" in text
    assert "a common trigger for both sensors" in text
    assert "Not identified by these runs, kept near the declared values: T_min_plus." in text


def test_a_title_cannot_break_the_page(tmp_path: Path) -> None:
    path = found_by_hand.write_case(tmp_path)
    path.write_text(path.read_text().replace("made by hand", "<script>alert(1)</script>"), encoding="utf-8")
    case = ss.load_case(path)
    found = found_by_hand.found(case)
    text = page(found, case, contents(found, case), {})
    assert "<script>alert" not in text
    assert "&lt;script&gt;" in text


def test_nothing_half_written_when_drawing_fails(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    found, case = made(tmp_path)
    monkeypatch.setattr(Figure, "savefig", not_saved)
    before = sorted(tmp_path.iterdir())
    with pytest.raises(RuntimeError, match="no figure today"):
        write_report(found, case, tmp_path / "out")
    assert sorted(tmp_path.iterdir()) == before


def test_other_files_of_the_folder_stay(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    found, case = made(tmp_path)
    out = tmp_path / "out"
    (out / "figures").mkdir(parents=True)
    quickly(monkeypatch)
    few_figures(monkeypatch)
    (out / "mine.txt").write_text("kept", encoding="utf-8")
    (out / "report.json").write_text("mine", encoding="utf-8")
    with pytest.raises(ss.InputError, match=r"holds 'report.json', which no former result put there"):
        write_report(found, case, out)
    assert (out / "report.json").read_text(encoding="utf-8") == "mine"
    write_report(found, case, out, force=True)
    assert (out / "mine.txt").read_text(encoding="utf-8") == "kept"
    assert json.loads((out / "report.json").read_text(encoding="utf-8"))["verdict"] == "effect_found"
    assert not [p for p in tmp_path.iterdir() if p.name.startswith(".")]


def test_figures_of_an_earlier_result_do_not_stay(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    found, case = made(tmp_path)
    figures = tmp_path / "out" / "figures"
    figures.mkdir(parents=True)
    (figures / "sub").mkdir()
    old = ("learned_curve.svg", "learned_curve.png")
    mine = ("mine.png", "learned_curve.pdf", "sub/errors.png")
    for name in (*old, *mine):
        (figures / name).write_text("old", encoding="utf-8")
    record = {f"figures/{name}": hashlib.sha256(b"old").hexdigest() for name in old}
    (tmp_path / "out" / RECORD).write_text(json.dumps(record), encoding="utf-8")
    monkeypatch.setattr(Figure, "savefig", not_saved)
    with pytest.raises(RuntimeError, match="no figure"):
        write_report(found, case, tmp_path / "out")
    assert all((figures / name).exists() for name in (*old, *mine))
    quickly(monkeypatch)
    few_figures(monkeypatch)
    said = write_report(found, case, tmp_path / "out")
    assert not [name for name in old if (figures / name).exists()]
    assert all((figures / name).exists() for name in mine)
    assert figures / "mine.png" not in said


def test_what_is_said_to_be_written_is_all_that_is_written(written: dict[str, Written]) -> None:
    one = written["effect_found"]
    assert one.said[0].name == "report.html"
    assert sorted(one.said) == sorted(p for p in one.out.rglob("*") if p.is_file() and p.name != RECORD)
    assert any(p.suffix == ".png" for p in one.said)


def test_out_that_is_a_file_is_refused_before_any_work(tmp_path: Path) -> None:
    (tmp_path / "out").write_text("", encoding="utf-8")
    with pytest.raises(ss.InputError, match="is a file; give a folder"), folder(tmp_path / "out", NAMES):
        pytest.fail("the work began")


def test_an_interrupt_while_drawing_ends_the_processes_and_leaves_nothing(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    found, case = made(tmp_path)
    stopped = []

    def interrupt(*_: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(Workers, "map", interrupt)
    monkeypatch.setattr(Workers, "stop", lambda self: stopped.append(self))
    before = sorted(tmp_path.iterdir())
    with pytest.raises(KeyboardInterrupt):
        write_report(found, case, tmp_path / "out")
    assert len(stopped) == 1
    assert sorted(tmp_path.iterdir()) == before


@pytest.mark.study
def test_processes_draw_what_one_draws(
    written: dict[str, Written], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    one = written["effect_found"]
    # two figures: a process takes seconds to start, and the others are drawn in the same way
    monkeypatch.setattr("stickslip.shown.report.page.FIGURES", dict.fromkeys(("portrait", "ranking")))
    monkeypatch.setattr(Workers, "at_hand", lambda: Workers(2))
    drawn = draw(one.found, one.case, tmp_path)
    text = (one.out / "report.html").read_text(encoding="utf-8")
    for name, saved in drawn.items():
        assert saved.svg.read_bytes() == (one.out / f"figures/{name}.svg").read_bytes()
        assert saved.live.document in text


@pytest.mark.study
def test_same_result_same_files(
    written: dict[str, Written], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    one = written["no_effect"]
    quickly(monkeypatch)
    for name in ("once", "again"):
        (tmp_path / name).mkdir()
        fill(tmp_path / name, one.found, one.case)
    for name in ("report.html", "report.json", "model_after.toml"):
        assert (tmp_path / "once" / name).read_bytes() == (tmp_path / "again" / name).read_bytes()


@pytest.mark.parametrize(
    "effect",
    [
        ss.effect("sensor_lag", tau=0.12),
        ss.effect("sensor_crosstalk", c=0.2),
        ss.effect("sensor_nonlinearity", q=0.3),
        ss.effect("sensor_drift", r=0.01),
    ],
    ids=lambda e: e.name,
)
def test_velocity_of_a_reading_is_its_derivative(effect: ss.Effect) -> None:
    model = ss.Model(found_by_hand.rig(si=False), friction=ss.PaperFriction(), effects=[effect])
    t = np.linspace(0.0, 8.0, 4001)
    run = ss.simulate(model, belt_speed=0.1, initial=(0.1, 0.1, 0, 0), t_end=8.0, t_eval=t)
    x1, y1, p = run.state[:, 0], run.state[:, 2], effect.parameters
    # the readings by the catalogue's formulas, written out again
    reading = {
        "sensor_lag": run.hidden.get("m", x1),
        "sensor_crosstalk": x1 + p.get("c", 0) * y1,
        "sensor_nonlinearity": x1 + p.get("q", 0) * x1**2,
        "sensor_drift": x1 + p.get("r", 0) * t,
    }[effect.name]
    state = np.zeros((len(t), 9))
    state[:, :4], state[:, 7] = run.state, run.hidden.get("m", 0.0)
    if effect.name != "sensor_lag":  # simulate returns readings for these: undo them
        bare = ss.simulate(
            model.with_effects([]), belt_speed=0.1, initial=(0.1, 0.1, 0, 0), t_end=8.0, t_eval=t
        )
        state[:, :4], x1, y1 = bare.state, bare.state[:, 0], bare.state[:, 2]
        reading = x1 + p.get("c", 0) * y1 + p.get("q", 0) * x1**2 + (p.get("r", 0) * t if "r" in p else 0.0)
    rate = reading_rate(t, state, model.parameters)
    differences = np.gradient(reading, t)
    assert np.median(np.abs(rate - differences)[2:-2]) < 2e-5


def test_force_from_readings_is_the_law(tmp_path: Path) -> None:
    found, _ = made(tmp_path, si=False)
    model = found.before
    t = np.arange(0.0, 60.0, 0.04)
    truth = ss.simulate(model, belt_speed=-0.1, initial=(0.1, 0.1, 0, 0), t_end=60.0, t_eval=t)
    generator = np.random.default_rng(3)
    noisy = truth.state[:, [0, 2]] + 1e-3 * generator.standard_normal((len(t), 2))
    view = dataclasses.replace(
        found.runs[1], t=t, belt_speed=-0.1, measured={"x1": noisy[:, 0], "y1": noisy[:, 1]}
    )
    got = motion.measured(model, view)
    assert got is not None
    slip = got.sure & (np.abs(got.v_w) > 0.05)
    off = np.abs(got.force[slip] - model.friction.force(got.v_w[slip]))
    assert np.median(off) < 0.04 * model.friction.T_s_minus
    assert np.median(np.abs(got.x2 - truth.state[:, 1])) < 0.01


def test_forecasts_are_not_joined_by_lines() -> None:
    t = np.arange(200) * 0.05
    state = np.column_stack([np.sin(t), np.cos(t), 0 * t, 0 * t])
    state[100:, 0] += 0.3
    (x,) = motion.broken(t, state, state[:, 0])
    assert len(x) == 201
    assert np.isnan(x[100])


def test_the_files_of_a_report_are_known_before_anything_draws_them() -> None:
    assert set(files.FIGURES) == set(FIGURES)
    assert set(files.OF_DRIVEN) == set(driven_figures.FIGURES)
    assert set(files.OF_GENERAL) == set(general_figures.FIGURES)
