"""The commands discover and forecast: what they write, print and return."""

from __future__ import annotations

import json
import os
import pickle
import signal
import time
from collections.abc import Callable
from pathlib import Path

import pytest
from click.testing import CliRunner, Result

import found_by_hand
import stickslip as ss
from quick_figures import quickly
from stickslip.cli.commands import main
from stickslip.cli.running.discover import folded
from stickslip.discovery.result import Found
from stickslip.progress import StageStep, stages, trying
from studies import few

LAG = ("sensor_lag",)


def invoke(*arguments: object) -> Result:
    return CliRunner().invoke(main, [str(a) for a in arguments])


@pytest.fixture
def known(monkeypatch: pytest.MonkeyPatch) -> Callable[[str], None]:
    """Let the command return a result put together by hand, of the verdict asked for."""

    def use(verdict: str) -> None:
        def search(
            case: ss.Case, *, progress: Callable[[str], None], seed: int, threads: int | None
        ) -> Found:
            assert (seed, threads) == (3, 2)
            for base, name in (
                ((), "sensor_lag"),
                ((), "belt_seam"),
                (LAG, "belt_seam"),
                (LAG, "sensor_delay"),
            ):
                progress(trying(base, name))
            for variable in ("x1", "x2"):
                progress(StageStep(f"scoring a curve: block against {variable}", "scoring curves"))
            return found_by_hand.found(case, verdict=verdict)

        monkeypatch.setattr(ss, "discover", search)
        quickly(monkeypatch)

    return use


@pytest.mark.parametrize(
    "verdict", few(["no_effect", "effect_found", "unlisted_effect"], ["unlisted_effect"])
)
def test_every_verdict_is_a_success_and_printed(
    tmp_path: Path, known: Callable[[str], None], verdict: str
) -> None:
    known(verdict)
    path = found_by_hand.write_case(tmp_path, si=True)
    result = invoke("discover", path, "--out", tmp_path / "out", "--seed", "3", "--threads", "2")
    assert result.exit_code == 0, result.output
    assert json.loads((tmp_path / "out" / "report.json").read_text(encoding="utf-8"))["verdict"] == verdict
    stages = [line.partition("] ")[2] for line in result.stderr.splitlines()]
    assert [one for one in stages if not one.startswith(("note: ", "still "))] == [
        "trying each effect", "trying sensor_lag + each other effect", "scoring curves", "drawing the report"
    ]  # fmt: skip
    for name in ("report.html", "report.json", "model_before.toml", "model_after.toml"):
        assert str(tmp_path / "out" / name) in result.stdout
        assert (tmp_path / "out" / name).is_file()
    if verdict == "effect_found":  # the tie, the size in SI and the next experiment are printed
        out = " ".join(result.stdout.split())
        assert "NOT settled: these runs cannot tell it from sensor_delay" in out
        assert "0.009603 s" in out
        assert (
            "Next experiment: a common trigger for both sensors, to tell sensor_lag from sensor_delay." in out
        )


@pytest.mark.parametrize(
    "given", [("--threads", "0"), ("--threads", "1.5"), ("--threads", "two"), ("--seed", "-1")]
)
def test_no_threads_and_a_negative_seed_are_refused(tmp_path: Path, given: tuple[str, str]) -> None:
    path = found_by_hand.write_case(tmp_path)
    result = invoke("discover", path, "--out", tmp_path / "out", *given)
    assert result.exit_code == 2
    assert result.stderr.startswith(f"stickslip: invalid value for '{given[0]}': ")
    assert result.stderr.count("\n") == 1
    assert not (tmp_path / "out").exists()


def test_a_log_hears_what_is_tried_while_a_stage_lasts(capsys: pytest.CaptureFixture[str]) -> None:
    """Minutes without a line looked like a search that hangs."""
    with stages("discovering", effects=23, every=0.2) as tell:
        tell("fitting the declared law")
        time.sleep(0.5)  # no word from the search
        for what in ("sensor_lag", "belt_seam", "belt_seam", "cubic_spring"):
            tell(trying((), what))
        time.sleep(0.3)
        tell(trying(LAG, "belt_seam"))
        tell(trying(LAG, "cubic_spring"))
        time.sleep(0.3)
    lines = [line.partition("] ")[2] for line in capsys.readouterr().err.splitlines()]
    assert list(dict.fromkeys(lines)) == [
        "fitting the declared law",
        "still fitting the declared law",
        "trying each effect",
        "trying each effect: 2 of at most 23 done, now trying cubic_spring",
        "trying sensor_lag + each other effect",
        "trying sensor_lag + each other effect: 1 of at most 22 done, now trying sensor_lag + cubic_spring",
    ]


def test_a_stage_is_told_by_its_type_and_not_read_from_the_words(capsys: pytest.CaptureFixture[str]) -> None:
    with stages("discovering", effects=23, every=60.0) as tell:
        tell("trying a rig of another name + what it lacks")
        tell("a note: a curve: of x1")
    lines = [line.partition("] ")[2] for line in capsys.readouterr().err.splitlines()]
    assert lines == ["trying a rig of another name + what it lacks", "a note: a curve: of x1"]
    step = trying(LAG, "belt_seam")
    assert step == "trying sensor_lag + belt_seam"  # a text to whoever prints it
    again = pickle.loads(pickle.dumps(step))
    assert (again, again.stage, again.beside) == (step, step.stage, 1)


@pytest.mark.skipif(not hasattr(signal, "SIGHUP"), reason="no such signal here")
@pytest.mark.parametrize("name", ["SIGTERM", "SIGHUP"])
def test_an_ended_search_leaves_no_hidden_folder(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, name: str
) -> None:
    number = getattr(signal, name)

    def search(*_: object, **__: object) -> None:
        assert any(one.name.startswith(".out.") for one in tmp_path.iterdir())
        os.kill(os.getpid(), number)
        time.sleep(10)

    monkeypatch.setattr(ss, "discover", search)
    before = signal.signal(number, signal.SIG_DFL)
    try:
        result = invoke("discover", found_by_hand.write_case(tmp_path), "--out", tmp_path / "out")
        assert signal.getsignal(number) is signal.SIG_DFL
    finally:
        signal.signal(number, before)
    assert result.exit_code == 128 + number
    assert not any("out" in one.name for one in tmp_path.iterdir())


def test_no_verdict_is_one_line_and_not_zero(tmp_path: Path) -> None:
    path = found_by_hand.write_case(tmp_path)
    path.write_text(path.read_text().replace('"validate"', '"train"'), encoding="utf-8")
    result = invoke("discover", path, "--out", tmp_path / "out")
    assert result.exit_code == 2
    assert (
        result.stderr.replace(f"{tmp_path}/", "")
        == "stickslip: rig.toml: no [[run]] has role = 'validate'; give it to at least one\n"
    )
    assert not (tmp_path / "out").exists()


def test_findings_alike_are_said_once() -> None:
    said = [f"run_{i:02d}: x1: ranges over {i}.5e-3 m; is the unit right?" for i in range(3)]
    other = [f"run_{i:02d}: y1: ranges over {i} m; is the unit right?" for i in range(2)]
    assert folded([*said, *other, "run_01: samples are missing"]) == [
        f"{said[0]} (and alike in 2 other runs)",
        f"{other[0]} (and alike in 1 other run)",
        "run_01: samples are missing",
    ]


@pytest.mark.parametrize("command", ["identify", "compare"])
def test_findings_are_printed(tmp_path: Path, command: str) -> None:
    """Millimetres declared as metres."""
    path = found_by_hand.write_case(tmp_path, si=True)
    case = ss.load_case(path)
    case.model().save(tmp_path / "model.toml")
    for name in ("x1", "y1"):
        text = path.read_text(encoding="utf-8")
        path.write_text(text.replace(f'"{name}", unit = "mm"', f'"{name}", unit = "m"'), encoding="utf-8")
    first = [tmp_path / "model.toml"] if command == "compare" else []
    result = invoke(command, *first, path, "--out", tmp_path / "out")
    findings = ss.load_case(path).findings
    assert any("is the unit right?" in one for one in findings)
    for one in findings:
        assert one in result.stdout or (command == "compare" and not one.startswith("run_03"))


@pytest.mark.study
def test_a_lag_is_found_and_removed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = found_by_hand.write_case(tmp_path, si=True)
    quickly(monkeypatch)
    result = invoke("discover", path, "--out", tmp_path / "out")
    assert result.exit_code == 0, result.output
    report = json.loads((tmp_path / "out" / "report.json").read_text(encoding="utf-8"))
    first = report["effects"][0]
    assert "sensor_lag" in {first["name"], *(a["name"] for a in first["alternatives"] if a["tied"])}
    if first["name"] == "sensor_lag":
        tau = first["parameters"]["tau"]
        deviation = (tau["high"] - tau["low"]) / (2 * 1.96)
        assert abs(tau["value"] - 0.12) < 3.5 * deviation  # one draw: its 95 % interval may miss
        assert deviation < 0.015 * 0.12
    assert report["error"]["after"] < 0.5 * report["error"]["before"]
