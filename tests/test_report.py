"""The report: its JSON against the schema, its page, its files; on a result put together by hand."""

from __future__ import annotations

import dataclasses
import io
import json
import re
from concurrent.futures import Future
from html.parser import HTMLParser
from importlib.resources import files
from pathlib import Path
from types import SimpleNamespace

import jsonschema
import numpy as np
import pytest
from rich.console import Console

import found_by_hand
import stickslip as ss
from stickslip.catalogue import CATALOGUE, CONSTANTS, KINDS
from stickslip.cli_discover import effects_table
from stickslip.discovery.readings import reading_velocity
from stickslip.discovery.result import Found
from stickslip.discovery.workers import Workers
from stickslip.report import motion, words
from stickslip.report.contents import contents
from stickslip.report.page import error, page, percent
from stickslip.report.si import EFFECTS, to_si
from stickslip.report.units import axes_of
from stickslip.report.write import fill, folder, write_report

VERDICTS = ("effect_found", "no_effect", "unlisted_effect")
SCHEMA = json.loads((files("stickslip.report") / "report.schema.json").read_text(encoding="utf-8"))

OMEGA = ((6243.0 + 362.1) / 42.3) ** 0.5


def made(tmp_path: Path, *, si: bool = True, verdict: str = "effect_found") -> tuple[Found, ss.Case]:
    case = ss.load_case(found_by_hand.write_case(tmp_path, si=si))
    return found_by_hand.found(case, verdict=verdict), case


@pytest.fixture(scope="module")
def reports(tmp_path_factory: pytest.TempPathFactory) -> dict[str, tuple[Found, Path]]:
    """A report of every verdict, written once: the result and the folder."""
    out = {}
    for verdict in VERDICTS:
        place = tmp_path_factory.mktemp(verdict)
        found, case = made(place, verdict=verdict)
        write_report(found, case, place / "out")
        out[verdict] = (found, place / "out")
    return out


@pytest.mark.parametrize("verdict", VERDICTS)
@pytest.mark.parametrize("si", [True, False])
def test_json_follows_the_schema(tmp_path: Path, verdict: str, si: bool) -> None:
    found, case = made(tmp_path, si=si, verdict=verdict)
    text = json.dumps(contents(found, case), allow_nan=False)  # raises on NaN and infinity
    report = json.loads(text)
    jsonschema.Draft202012Validator.check_schema(SCHEMA)
    jsonschema.validate(report, SCHEMA)
    assert list(report)[:3] == ["format", "title", "verdict"]
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


def test_si_values_are_the_scaled_ones(tmp_path: Path) -> None:
    found, case = made(tmp_path)
    tau = contents(found, case)["effects"][0]["parameters"]["tau"]  # type: ignore[index, call-overload]
    assert tau["unit"] == "s"
    assert tau["value_si"] == pytest.approx(0.12 / OMEGA)
    assert tau["low_si"] == pytest.approx(0.117 / OMEGA)


def test_every_parameter_of_the_catalogue_has_its_dimension() -> None:
    scaled = {**CATALOGUE, **CONSTANTS}  # a driven slider is in the numbers of its readings
    names = {f"{k.name}.{p.name}" for k in scaled.values() for p in k.parameters if p.name != "phi"}
    assert names <= set(EFFECTS)


@pytest.mark.parametrize(
    ("name", "value", "expected", "unit"),
    [
        ("block_viscous_damping.c", 0.5, 0.5 * 362.1 / OMEGA, "N s/m"),
        ("spring_cubic_k1.k", 2.0, 2.0 * 362.1 / 0.0089**2, "N/m^3"),
        ("contact_compliance.k", 400.0, 400.0 * 362.1, "N/m"),
        ("T_s_minus", 5.94, 5.94 * 362.1 * 0.0089, "N"),
        ("belt_speed_ripple.w", 2.0, 2.0 * OMEGA, "rad/s"),
        ("sensor_nonlinearity.q", 0.1, 0.1 / 0.0089, "1/m"),
        ("belt_load_droop.k", 0.002, 0.002 * OMEGA / 362.1, "m/(N s)"),
    ],
)
def test_si_by_the_rigs_own_numbers(name: str, value: float, expected: float, unit: str) -> None:
    got = to_si(name, value, found_by_hand.rig(si=True))
    assert got == (pytest.approx(expected, rel=2e-4), unit)
    assert to_si(name, value, found_by_hand.rig(si=False)) is None


RIG_FOUND = [  # numbers found, and the constants that they make of the declared ones
    ({"alpha2": 0.9}, {"J": 0.9}),
    ({"beta3": 1.1}, {"k3": 362.1 * (1.1 - 1) / 1234.0 + 1.1}),
    ({"eta12": 1.2}, {"c2": (1.2 * (2.48 + 2.94) - 2.48) / 2.94}),
    ({"eta1": 1.3, "eta12": 1.2}, {"c1": 1.3, "c2": (1.2 * (2.48 + 2.94) - 1.3 * 2.48) / 2.94}),
    ({"inertia": 1.05, "stiffness": 1.02}, {"m": 1.05, "k1": (1.02 * (6243.0 + 362.1) - 362.1) / 6243.0}),
    ({"alpha1": 1.1}, {}),  # mass and spring k1 at once
]


@pytest.mark.parametrize(("shares", "expected"), RIG_FOUND, ids=lambda one: "-".join(one) or "none")
def test_a_wrong_number_of_the_rig_has_its_constant_in_si(
    tmp_path: Path, shares: dict[str, float], expected: dict[str, float]
) -> None:
    found, case = made(tmp_path)
    rig, constants = case.rig, case.rig.to_si()
    values = {name: share * getattr(rig, name, rig.alpha1) for name, share in shares.items()}
    found = found_by_hand.with_effect(found, found_by_hand.of_rig(values))
    report = json.loads(json.dumps(contents(found, case)))
    jsonschema.validate(report, SCHEMA)
    given = report["effects"][0]["parameters"].values()
    told = {one["si_name"]: one for one in given if "si_name" in one}
    assert {name: one["value_si"] / constants[name] for name, one in told.items()} == pytest.approx(expected)
    for name, one in told.items():
        if name == "c2" and "eta1" in shares:  # a difference of two
            assert one["low_si"] is None
        else:
            assert one["low_si"] < one["value_si"] < one["high_si"]
    rows = [row for row in report["parameters"] if row["kind"] == "effect"]
    assert [row["name"] for row in rows] == list(shares)
    assert [row["before"]["value"] for row in rows] == [getattr(rig, name, rig.alpha1) for name in shares]
    text = page(found, case, report, {})
    assert all(f"{name} = " in text for name in expected)


def test_the_commands_table_of_a_wrong_number_says_what_it_is(tmp_path: Path) -> None:
    found, case = made(tmp_path)
    console = Console(width=80, record=True, file=io.StringIO())
    wrong = found_by_hand.with_effect(found, found_by_hand.of_rig({"eta1": 0.08, "eta12": 0.2}))
    console.print(effects_table(wrong, case))
    text = console.export_text()
    assert "wrong in the declared rig" in text
    assert "unlisted" not in text
    assert "c1 = 2.318 N s/m" in text
    assert "c2 = 3.477 N s/m" in text
    console.print(effects_table(found, case))
    text = console.export_text()
    assert "what the declared model lacks" in text
    assert "sensor_lag" in text
    assert "│ 0.009603 s │" in text


def test_a_guessed_place_shows_no_evidence(tmp_path: Path) -> None:
    found, case = made(tmp_path)
    found = found_by_hand.with_effect(found, found_by_hand.guessed())
    report = json.loads(json.dumps(contents(found, case)))
    jsonschema.validate(report, SCHEMA)
    proof = report["effects"][0]["evidence"]
    assert [proof[k] for k in ("delta_chi2", "delta_bic", "held_out_ratio", "control")] == [None] * 4
    text = re.sub(r"\s+", " ", page(found, case, report, {}))
    assert "It lowers chi-squared" not in text
    assert "kept out of every fit" not in text
    assert "Where it acts is a guess: on the angle body and depending on y1 is the likeliest." in text
    assert "acts, most likely on the angle body, as a function of y1." in words.headline(found)
    assert words.sureness(found)[-1].startswith("Where it acts and on what is the likeliest guess")
    assert not any("stands" in line for line in words.sureness(found))


def test_what_was_compared_with_nothing_is_not_said_to_stand(tmp_path: Path) -> None:
    found, case = made(tmp_path)
    bare = found_by_hand.with_effect(found, found_by_hand.of_rig({"eta1": 0.08, "eta12": 0.2}))
    said = words.sureness(bare)[-1]
    assert said == (
        "That it is eta1 and eta12 was held against no rival of its kind; of all that was tried sensor_delay comes "
        "nearest, its BIC higher by 3.1."
    )
    close = tuple(dataclasses.replace(one, bic=0.0) for one in bare.ranking)
    assert "NOT settled" in words.sureness(dataclasses.replace(bare, ranking=close))[-1]
    assert words.sureness(dataclasses.replace(bare, ranking=()))[-1].endswith("held against no rival.")
    assert contents(bare, case)["effects"][0]["evidence"]["control"] is None  # type: ignore[index, call-overload]
    held = found_by_hand.with_effect(found, found_by_hand.of_rig({"alpha2": 7.5}, "spring_gap_k3"))
    assert words.sureness(held)[-1] == "That it is alpha2 stands: no rival comes near."


@pytest.mark.parametrize(
    ("value", "digits", "text"),
    [
        (99.7, 2, "100"),
        (100.0, 2, "100"),
        (9999.6, 4, "10\u202f000"),
        (12345.6, 4, "12\u202f350"),
        (0.05, 2, "0.05"),
        (2e7, 3, "2·10⁷"),
        (-99.96, 3, "−100"),
    ],
)
def test_numbers_have_no_exponent_where_a_person_needs_none(value: float, digits: int, text: str) -> None:
    assert words.short(value, digits) == text


def test_shares_and_rounding_residue() -> None:
    assert percent(1.0) == percent(0.997) == "100\u00a0%"
    assert percent(0.028) == "2.8\u00a0%"
    assert percent(float("nan")) == "–"
    assert error(2.21e-16) == "0"
    assert error(2.21e-3) == "0.00221"
    assert error(float("nan")) == "–"


def test_a_residual_that_grows_is_remarked_on(tmp_path: Path) -> None:
    found, _ = made(tmp_path)
    after = dataclasses.replace(found.residual_before, chi2=found.residual_before.chi2 + 8, clean=False)
    grown = dataclasses.replace(found, residual_after=after)
    said = words.clean_sentence(grown)
    assert said.startswith("Reading by reading more is left than before: chi-squared per reading is ")
    assert "not what was fitted" not in said
    block = dataclasses.replace(found.before, rig=ss.BlockOnBelt(), effects=(), channels=None, noise=None)
    assert "not what was fitted" in words.clean_sentence(dataclasses.replace(grown, before=block))


def test_a_single_belt_speed_is_said_once_in_the_readings_unit(tmp_path: Path) -> None:
    found, case = made(tmp_path)
    size = case.rig.scales.velocity * 1e3
    low, high = (words.short(size * one, 3) for one in (0.08, 0.1))
    assert f"Trained at |belt speed| from {low} to {high} mm/s; " in words.caveats(found, axes_of(case))[-1]
    runs = tuple(dataclasses.replace(run, belt_speed=0.08) for run in found.runs)
    one_speed = dataclasses.replace(found, runs=runs)
    assert f"Trained at |belt speed| {low} mm/s only; " in words.caveats(one_speed, axes_of(case))[-1]
    assert "|belt speed| 0.08 (model units) only; " in words.caveats(one_speed)[-1]


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
        if tag in ("script", "link", "iframe"):
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
    for name in re.findall(r"url\(#([^)]+)\)", text):
        assert name in parsed.ids
    assert words.headline(found) in text
    assert "nan" not in re.sub(r"<svg.*?</svg>", "", text, flags=re.DOTALL).lower().split()
    assert text.count("<svg") == len(list((out / "figures").glob("*.svg")))
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
    assert "<script" not in text
    assert "&lt;script&gt;" in text


def test_headlines() -> None:
    assert set(words.PLAIN) == {*KINDS, "unlisted"}


def test_no_effect_is_not_called_complete_where_something_is_left(tmp_path: Path) -> None:
    found, _ = made(tmp_path, verdict="no_effect")
    clean, dirty = (
        dataclasses.replace(
            found, residual_after=dataclasses.replace(found.residual_after, clean=is_clean, chi2=1.3)
        )
        for is_clean in (True, False)
    )
    assert words.headline(clean).startswith("Nothing is missing: ")
    assert words.headline(dirty).startswith("Nothing can be named: a little is left above the noise")
    assert words.clean_sentence(clean).startswith("What is left is noise: chi-squared per reading is 1.3 ± ")
    assert words.clean_sentence(dirty).startswith(
        "Not all is explained: chi-squared per reading is still 1.3 ± "
    )


@pytest.mark.parametrize("verdict", ["effect_found", "unlisted_effect"])
def test_a_candidate_below_the_threshold_is_not_called_sure(tmp_path: Path, verdict: str) -> None:
    found, _ = made(tmp_path, verdict=verdict)
    assert words.sureness(found)[0].startswith("Something is missing, that is sure: ")
    for observed in (0.5 * found.gate.threshold, found.gate.threshold):
        below = dataclasses.replace(found, gate=dataclasses.replace(found.gate, observed=observed))
        assert words.sureness(below)[0] == (
            "Something is missing, though no effect of the list lowers chi-squared by more than noise may."
        )


def test_nothing_half_written_when_drawing_fails(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    found, case = made(tmp_path)

    def fail(*_: object) -> str:
        raise RuntimeError("no page today")

    monkeypatch.setattr("stickslip.report.write.draw", lambda *_: {})
    monkeypatch.setattr("stickslip.report.write.page", fail)
    before = sorted(tmp_path.iterdir())
    with pytest.raises(RuntimeError, match="no page today"):
        write_report(found, case, tmp_path / "out")
    assert sorted(tmp_path.iterdir()) == before


def test_other_files_of_the_folder_stay(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    found, case = made(tmp_path)
    out = tmp_path / "out"
    (out / "figures").mkdir(parents=True)
    (out / "mine.txt").write_text("kept", encoding="utf-8")
    (out / "report.json").write_text("old", encoding="utf-8")
    monkeypatch.setattr("stickslip.report.write.draw", lambda *_: {})
    write_report(found, case, out)
    assert (out / "mine.txt").read_text(encoding="utf-8") == "kept"
    assert json.loads((out / "report.json").read_text(encoding="utf-8"))["verdict"] == "effect_found"
    assert not [p for p in tmp_path.iterdir() if p.name.startswith(".")]


def test_figures_of_an_earlier_result_do_not_stay(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    found, case = made(tmp_path)
    figures = tmp_path / "out" / "figures"
    figures.mkdir(parents=True)
    (figures / "sub").mkdir()
    old = ("learned_curve.svg", "learned_curve.png", "weights.png")
    mine = ("mine.png", "learned_curve.pdf", "sub/errors.png")
    for name in (*old, *mine):
        (figures / name).write_text("old", encoding="utf-8")
    monkeypatch.setattr(
        "stickslip.report.write.page", lambda *_: (_ for _ in ()).throw(RuntimeError("no page"))
    )
    monkeypatch.setattr("stickslip.report.write.draw", lambda *_: {})
    with pytest.raises(RuntimeError, match="no page"):
        write_report(found, case, tmp_path / "out")
    assert all((figures / name).exists() for name in (*old, *mine))
    monkeypatch.setattr("stickslip.report.write.page", lambda *_: "")
    said = write_report(found, case, tmp_path / "out")
    assert not [name for name in old if (figures / name).exists()]
    assert all((figures / name).exists() for name in mine)
    assert figures / "mine.png" not in said


def test_what_is_said_to_be_written_is_all_that_is_written(tmp_path: Path) -> None:
    found, case = made(tmp_path)
    said = write_report(found, case, tmp_path / "out")
    assert said[0].name == "report.html"
    assert sorted(said) == sorted(p for p in (tmp_path / "out").rglob("*") if p.is_file())
    assert any(p.suffix == ".png" for p in said)


def test_out_that_is_a_file_is_refused_before_any_work(tmp_path: Path) -> None:
    (tmp_path / "out").write_text("", encoding="utf-8")
    with pytest.raises(ss.InputError, match="is a file; give a folder"), folder(tmp_path / "out"):
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


def test_an_interrupted_map_cancels_nothing_under_way() -> None:
    """What is cancelled makes the pool's own thread cry out when it is stopped."""

    class Interrupted(Future[int]):
        def result(self, timeout: float | None = None) -> int:
            raise KeyboardInterrupt(timeout)

    handed: list[Future[int]] = [Interrupted(), Future(), Future()]
    todo, workers = iter(handed), Workers(1)
    workers._pool = SimpleNamespace(submit=lambda *_: next(todo), map=None)
    with pytest.raises(KeyboardInterrupt):
        workers.map(abs, [1, 2, 3])
    assert next(todo, None) is None
    assert not any(one.cancelled() for one in handed)


def test_same_result_same_files(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    found, case = made(tmp_path)
    for name, processes in (("a", 2), ("b", 1)):
        monkeypatch.setattr(Workers, "at_hand", lambda: Workers(processes))  # noqa: B023
        (tmp_path / name).mkdir()
        fill(tmp_path / name, found, case)
    for name in ("report.html", "report.json", "figures/portrait.svg"):
        assert (tmp_path / "a" / name).read_bytes() == (tmp_path / "b" / name).read_bytes()


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
    state = run.state.copy()
    if effect.name != "sensor_lag":  # simulate returns readings for these: undo them
        bare = ss.simulate(
            model.with_effects([]), belt_speed=0.1, initial=(0.1, 0.1, 0, 0), t_end=8.0, t_eval=t
        )
        state, x1, y1 = bare.state, bare.state[:, 0], bare.state[:, 2]
        reading = x1 + p.get("c", 0) * y1 + p.get("q", 0) * x1**2 + (p.get("r", 0) * t if "r" in p else 0.0)
    rate = reading_velocity(model, state, reading)
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
