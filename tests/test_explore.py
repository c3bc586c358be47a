"""`stickslip explore`: what it draws, what it refuses, its guard, and the page in a browser."""

from __future__ import annotations

import shutil
import subprocess
import sys
import urllib.error
import urllib.request
from collections.abc import Iterator
from pathlib import Path
from urllib.parse import urlsplit

import numpy as np
import pytest
from click.testing import CliRunner

import stickslip as ss
from browser import chromium
from found_by_hand import write_case
from stickslip.cli.commands import main
from stickslip.shown.explore.page import Page
from stickslip.shown.explore.scene import PERIODS, curves, measured
from stickslip.shown.explore.screenshot import PROGRAMS

SPEED = 0.1
FIND = "Bokeh.documents[0].get_model_by_name"


def model() -> ss.Model:
    rig = ss.Rig(alpha1=16, alpha2=8, beta3=4, eta1=0.1, eta12=0.2)
    return ss.Model(rig, friction=ss.PaperFriction(), effects=(ss.effect("static_aging", dT=0.7, tau=2.2),))


def test_curves_are_those_of_a_tighter_simulation() -> None:
    one = model()
    ours = curves(one, SPEED)
    t_end = PERIODS * 2 * np.pi
    run = ss.simulate(one, belt_speed=SPEED, t_end=t_end, t_eval=ours.t, rtol=1e-12, atol=1e-12)
    np.testing.assert_allclose(ours.x1, run.state[:, 0], atol=1e-4 * np.ptp(run.state[:, 0]))
    assert ours.sticks
    v = ours.v_w[np.isfinite(ours.v_w)]
    np.testing.assert_array_equal(ours.force[np.isfinite(ours.v_w)], one.friction.force(v))


def test_a_measured_run_has_its_units(tmp_path: Path) -> None:
    case = ss.load_case(write_case(tmp_path, si=True))
    run = case.runs[0]
    known = measured(ss.Model(case.rig, friction=case.friction, channels=case.channels), run)
    np.testing.assert_allclose(known["x1"], run.to_readings("x1", run.x1))
    moved = np.trapezoid(known["v"], known["t"])
    assert moved == pytest.approx(known["x"][-1] - known["x"][0], abs=0.05)


def test_sliders_switches_and_saving(tmp_path: Path) -> None:
    page = Page(model(), SPEED, None, tmp_path)
    before = np.array(page.sources["signal"].data["y"])
    page.sliders["alpha1"].value = 20.0
    assert page.model() == model().replace(alpha1=20.0)
    assert not np.allclose(before, page.sources["signal"].data["y"])
    page.effects.active = []
    assert page.model().effects == ()
    page.sliders["alpha1"].value = 0.5  # below its bound
    assert "alpha1" in page.said.text
    page.sliders["alpha1"].value = 18.0
    page.name.value = "mine.toml"
    page.save()
    assert ss.load_model(tmp_path / "mine.toml") == page.model()
    page.sliders["alpha1"].value = 17.0
    page.save()
    assert "press once more" in page.said.text
    assert ss.load_model(tmp_path / "mine.toml").parameters["alpha1"] == 18.0
    page.save()
    assert ss.load_model(tmp_path / "mine.toml").parameters["alpha1"] == 17.0
    for bad in ("../mine.toml", "mine.txt", ".toml", ""):
        page.name.value = bad
        page.save()
        assert "plain file name" in page.said.text
    assert [one.name for one in tmp_path.iterdir()] == ["mine.toml"]


@pytest.mark.parametrize(
    ("words", "said"),
    [
        ([], "--belt-speed: missing"),
        (["--belt-speed", "fast"], "--belt-speed"),
        (["--belt-speed", "0.1", "--run", "a"], "a model has no runs"),
    ],
)
def test_bad_input_is_one_line(tmp_path: Path, words: list[str], said: str) -> None:
    model().save(tmp_path / "model.toml")
    result = CliRunner().invoke(main, ["explore", str(tmp_path / "model.toml"), *words])
    assert result.exit_code == 2
    assert said in result.stderr
    assert result.stderr.count("\n") == 1


@pytest.fixture(scope="module")
def address(tmp_path_factory: pytest.TempPathFactory) -> Iterator[str]:
    folder = tmp_path_factory.mktemp("explore")
    model().save(folder / "model.toml")
    command = [
        sys.executable,
        "-c",
        "from stickslip.cli.commands import main; main()",
        "explore",
        "model.toml",
    ]
    with subprocess.Popen(
        [*command, "--belt-speed", str(SPEED)], cwd=folder, stdout=subprocess.PIPE, text=True
    ) as process:
        assert process.stdout is not None
        try:
            yield process.stdout.readline().split()[1]
        finally:
            process.terminate()
            try:
                process.wait(timeout=10)
            except subprocess.TimeoutExpired:  # its cause is not known
                process.kill()


def status(url: str, **headers: str) -> int:
    try:
        with urllib.request.urlopen(urllib.request.Request(url, headers=headers), timeout=20) as answer:
            return int(answer.status)
    except urllib.error.HTTPError as error:
        with error:
            return error.code


def test_the_guard(address: str) -> None:
    parts = urlsplit(address)
    root = f"{parts.scheme}://{parts.netloc}"
    assert parts.hostname == "127.0.0.1"
    assert len(parts.path) > 30
    assert status(address) == 200
    assert status(address, Origin=root) == 200
    assert status(address, Host="elsewhere.example") == 403
    assert status(address, Origin="http://elsewhere.example") == 403
    assert status(address, Origin="null") == 403
    assert status(f"{root}/") == 404
    assert status(f"{root}/static/js/bokeh.min.js") == 404
    assert status(f"{root}/{'a' * 32}/") == 404


@pytest.mark.parametrize("width", [390, 820, 1440])
def test_the_page_in_a_browser(address: str, width: int) -> None:
    with chromium(viewport={"width": width, "height": 900}) as seen:
        page = seen.page
        page.goto(address)
        page.wait_for_function("window.Bokeh && Bokeh.documents.length && Bokeh.documents[0].is_idle")
        data = f"Array.from({FIND}('signal').renderers[0].data_source.data.y)"
        before = page.evaluate(data)
        slider = "Bokeh.documents[0].all_models"
        page.evaluate(f"[...{slider}].find((one) => one.title === 'alpha1').value = 20")
        page.wait_for_timeout(800)
        after = page.evaluate(data)
        expected = curves(model().replace(alpha1=20.0), SPEED)
        np.testing.assert_allclose(after, expected.x1, atol=1e-9)
        assert not np.allclose(before, after)
        assert seen.sideways() <= 0
        assert seen.complaints == []
        host = urlsplit(address).netloc
        assert all(urlsplit(one).netloc in (host, "") for one in seen.asked)
        page.evaluate(f"[...{slider}].find((one) => one.title === 'alpha1').value = 16")
        page.wait_for_timeout(800)


def drillstring() -> ss.Model:
    """A bit on the rock, on a shaft that a drive turns."""
    rig = ss.BodiesRig(
        body={"bit": ss.Body(inertia="0.5 kg m^2")},
        link=[ss.Link(between=("bit", "drive"), stiffness="12 N m/rad", damping="0.1 N m s/rad")],
        contact=[ss.Contact(body="bit")],
    )
    return ss.Model(rig, friction=ss.StribeckFriction(F_s="8 N m", F_c="5 N m", v_s="0.5 rad/s"))


def two_blocks() -> ss.Model:
    rig = ss.MatricesRig(
        M=[[1, 0], [0, 2]], K=[[2, -1], [-1, 2]], contact=[[0, 1], [1, 0]], law=["soft", "hard"],
        against=["belt", "ground"], names=["a", "b"],
    )  # fmt: skip
    laws = {
        "soft": ss.CoulombFriction(static=1.0, kinetic=0.5),
        "hard": ss.CoulombFriction(static=0.2, kinetic=0.1),
    }
    return ss.Model(rig, friction=laws)


def test_a_rig_that_a_drive_turns_is_drawn_against_the_drive() -> None:
    one, speed = drillstring(), 1.5
    ours = curves(one, speed)
    assert ours.t[-1] == pytest.approx(PERIODS * 2 * np.pi * np.sqrt(0.5 / 12))
    run = ss.simulate(one, drive_speed=speed, t_end=ours.t[-1], t_eval=ours.t, rtol=1e-12, atol=1e-12)
    np.testing.assert_allclose(ours.x1, run.bit - speed * ours.t, atol=1e-4)
    late = len(ours.t) // 2
    np.testing.assert_allclose(ours.v, run.v_bit[late:], atol=1e-3)
    assert ours.sticks == bool((run.mode_bit[late:] == 0).any())
    assert np.nanmax(ours.v_w) == pytest.approx(np.abs(run.v_bit).max(), abs=1e-3)  # the rock stands


def test_of_several_contacts_the_one_on_the_belt_is_drawn_with_its_law() -> None:
    one, speed = two_blocks(), 0.3
    ours = curves(one, speed)
    run = ss.simulate(one, belt_speed=speed, t_end=ours.t[-1], t_eval=ours.t, rtol=1e-12, atol=1e-12)
    np.testing.assert_allclose(ours.x1, run.b, atol=1e-4)
    assert np.nanmax(ours.force) == 0.5
    assert np.nanmax(ours.v_w) == pytest.approx(np.abs(run.v_b - speed).max(), abs=1e-3)


def test_sliders_of_a_general_rig_are_its_numbers(tmp_path: Path) -> None:
    page = Page(drillstring(), 1.5, None, tmp_path)
    assert page.speed.title == "drive speed [rad/s]"
    assert set(page.sliders) == set(drillstring().parameters)
    before = np.array(page.sources["signal"].data["y"])
    page.sliders["link_1.stiffness"].value = 20.0
    assert page.model().parameters["link_1.stiffness"] == 20.0
    assert not np.allclose(before, page.sources["signal"].data["y"])


def test_a_rig_that_nothing_moves_is_refused(tmp_path: Path) -> None:
    rig = ss.BodiesRig(
        body={"bit": ss.Body(mass=1.0)},
        link=[ss.Link(between=("bit", "ground"), stiffness=1.0)],
        contact=[ss.Contact(body="bit")],
    )
    ss.Model(rig, friction=ss.CoulombFriction()).save(tmp_path / "m.toml")
    result = CliRunner().invoke(main, ["explore", str(tmp_path / "m.toml"), "--belt-speed", "1"])
    assert result.exit_code == 2
    assert "nothing moves it" in result.output


@pytest.mark.parametrize(
    ("speed", "words"), [("1 mm/s", "must be in a unit like rad/s"), ("quick", "not a number with a unit")]
)
def test_a_speed_of_something_else_is_refused(tmp_path: Path, speed: str, words: str) -> None:
    drillstring().save(tmp_path / "m.toml")
    result = CliRunner().invoke(main, ["explore", str(tmp_path / "m.toml"), "--belt-speed", speed])
    assert result.exit_code == 2
    assert words in result.output


def test_a_screenshot_shows_the_curves(tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    if not any(map(shutil.which, PROGRAMS)):
        pytest.skip("no Chromium is installed")
    drillstring().save(tmp_path / "m.toml")
    asked = [
        "explore",
        tmp_path / "m.toml",
        "--belt-speed",
        "1.5 rad/s",
        "--screenshot",
        tmp_path / "page.png",
    ]
    result = CliRunner().invoke(main, [str(one) for one in asked])
    assert result.exit_code == 0, result.output
    assert caplog.records == []
    from matplotlib.image import imread

    picture = imread(tmp_path / "page.png")
    assert picture.shape[1] == 1440
    vermilion = np.all(np.abs(picture[..., :3] * 255 - [0xD5, 0x5E, 0x00]) < 40, axis=-1)
    assert vermilion.sum() > 500  # the curves, not a blank page


@pytest.mark.parametrize(
    ("path", "hidden", "words"),
    [("page.jpg", False, "must be the name of a PNG"), ("page.png", True, "needs a browser")],
)
def test_a_screenshot_that_cannot_be_is_one_line(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, path: str, hidden: bool, words: str
) -> None:
    if hidden:
        monkeypatch.setenv("PATH", str(tmp_path))
    drillstring().save(tmp_path / "m.toml")
    asked = ["explore", tmp_path / "m.toml", "--belt-speed", "1.5", "--screenshot", tmp_path / path]
    result = CliRunner().invoke(main, [str(one) for one in asked])
    assert result.exit_code == 2
    assert words in result.output
    assert not (tmp_path / path).exists()
