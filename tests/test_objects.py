"""Every object that a public call gives: a line, a table, a portrait, a frame, equality, a pickle."""

from __future__ import annotations

import inspect
import pickle
import re
import subprocess
import sys
from dataclasses import replace
from html.parser import HTMLParser

import numpy as np
import pytest

import stickslip as ss
from browser import chromium, program
from every_object import BLOCK, COULOMB, MODEL, block_run, bodies, objects
from quick_figures import quickly
from stickslip.objects import Drawn, Sampled, same

NO_INSTANCES = {"InputError", "ModelWarning", "NoLimitCycleError", "Status", "StickslipError"}
NAMES = sorted(name for name in dir(ss) if inspect.isclass(getattr(ss, name)) and name not in NO_INSTANCES)
VOID = {"img", "br"}


class Outline(HTMLParser):
    """What an HTML text is made of; an end that closes nothing, or something else, fails."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.open, self.tags, self.attributes, self.words = [], [], [], []
        self.feed(text)
        assert self.open == []

    def handle_starttag(self, tag, attrs):
        self.tags.append(tag)
        self.attributes += attrs
        if tag not in VOID:
            self.open.append(tag)

    def handle_endtag(self, tag):
        assert self.open.pop() == tag

    def handle_data(self, data):
        self.words.append(data)


def example(name: str):
    return objects()[name]


def test_there_is_one_of_every_public_class() -> None:
    assert set(NAMES) == set(objects())


def test_the_catalogue_and_what_has_many_points_are_no_walls_of_numbers() -> None:
    knots = np.linspace(0, 1, 24)
    many = [ss.tabulated("block", "x1", knots, knots), ss.TabulatedFriction(speeds=knots, forces=1 + knots)]
    for one in [*many, ss.CATALOGUE, *ss.CATALOGUE.values()]:
        assert len(repr(one)) < 120
    assert "24 in all" in repr(many[0])


def test_a_law_is_printed_as_the_call_that_makes_it() -> None:
    for law in (
        ss.CoulombFriction(static=0.3, kinetic=0.2),
        ss.StribeckFriction(F_s=8, F_c=5, v_s=0.01, c_plus=2),
    ):
        assert eval(repr(law), vars(ss)) == law


@pytest.mark.parametrize("name", NAMES)
def test_it_is_printed_in_one_line(name: str) -> None:
    said = repr(example(name))
    assert "\n" not in said
    assert len(said) < 120
    assert name in said or said.startswith("<fold at 0.1")
    assert len(said) < 500


@pytest.mark.sampled(8)
@pytest.mark.parametrize("name", NAMES)
def test_a_notebook_shows_a_table(name: str) -> None:
    seen = Outline(example(name)._repr_html_())
    assert {"table", "th", "td"} <= set(seen.tags)
    assert not {"script", "style", "link", "iframe"} & set(seen.tags)
    sources = [value for key, value in seen.attributes if key == "src"]
    assert all(one.startswith("data:image/png;base64,iVBOR") for one in sources)
    assert len(sources) == isinstance(example(name), Drawn)
    assert not re.search(r"\bnan\b|None|object at", " ".join(seen.words))


@pytest.mark.parametrize("name", NAMES)
def test_it_is_equal_to_its_copy_and_to_nothing_else(name: str) -> None:
    one = example(name)
    copy = pickle.loads(pickle.dumps(one))
    assert copy == one
    assert same(copy, one)
    assert one != "something else"
    assert all(one != other for key, other in objects().items() if key != name)


@pytest.mark.parametrize("name", NAMES)
def test_its_frame_has_rows(name: str) -> None:
    frame = example(name).to_dataframe()
    assert len(frame) > 0
    assert len(set(frame.columns)) == frame.shape[1]


@pytest.mark.sampled(8)
@pytest.mark.parametrize("name", [one for one in NAMES if issubclass(getattr(ss, one), Drawn)])
def test_it_draws_itself_in_a_notebook(name: str) -> None:
    figure = example(name).plot()
    assert any(ax.lines or ax.collections for ax in figure.axes)
    assert figure._repr_png_().startswith(b"\x89PNG")


@pytest.mark.parametrize("name", [one for one in NAMES if issubclass(getattr(ss, one), Sampled)])
def test_its_samples_are_a_dataset(name: str) -> None:
    one = example(name)
    dataset = one.to_xarray()
    if name != "Branch":  # that one is over its points: it may turn round
        frame = one.to_dataframe()
        assert list(dataset.sizes) == [frame.columns[0]]
        for column in frame.columns[1:]:
            np.testing.assert_array_equal(dataset[column], frame[column])


def test_another_number_is_another_object() -> None:
    run = ss.simulate(MODEL, belt_speed=0.1, t_end=60.0, sensitivity=["T_s_minus"])
    assert run == example("Trajectory")
    assert hash(run) == hash(example("Trajectory"))
    changed = run.state.copy()
    changed[-1, 0] = np.nextafter(changed[-1, 0], 1)
    assert replace(run, state=changed) != run
    holes = replace(run, state=np.full_like(changed, np.nan))
    assert holes == replace(run, state=np.full_like(changed, np.nan))
    assert ss.simulate(MODEL, belt_speed=0.1, t_end=61.0) != run


def test_states_go_by_their_names() -> None:
    run = example("Trajectory")
    for k, name in enumerate(run.state_names):
        np.testing.assert_array_equal(getattr(run, name), run.state[:, k])
        assert name in dir(run)
    with pytest.raises(AttributeError, match=r"a Trajectory has no 'x3'; its states are x1, x2, y1, y2"):
        _ = run.x3
    assert not hasattr(pickle.loads(pickle.dumps(run)), "__wrapped__")


def test_hidden_states_and_modes_of_contacts_go_by_their_names() -> None:
    memory = ss.effect(
        "friction_memory", **dict.fromkeys(ss.CATALOGUE["friction_memory"].parameter_names, 0.5)
    )
    run = ss.simulate(MODEL.with_effects([memory]), belt_speed=0.1, t_end=20.0)
    (name,) = run.hidden_names
    np.testing.assert_array_equal(getattr(run, name), run.hidden[name])
    model = ss.Model(bodies(), friction=ss.CoulombFriction(static=4.0, kinetic=2.0))
    run = ss.simulate(model, drive_speed=1.0, t_end=5.0)
    np.testing.assert_array_equal(run.mode_bit, run.mode[:, 0])
    np.testing.assert_array_equal(run.v_bit, run.state[:, 2])
    assert run.to_xarray()["bit"].attrs["units"] == "rad"
    assert run.to_xarray()["v_bit"].attrs["units"] == "rad/s"


def test_a_recording_keeps_its_units() -> None:
    recording = block_run()
    frame = recording.to_dataframe()
    np.testing.assert_array_equal(frame["x1"], recording.raw["x1"])
    assert frame.attrs["units"] == {"t": "s", "x1": "mm"}
    assert recording.to_xarray()["x1"].attrs["units"] == "mm"
    html = recording._repr_html_()
    assert "5 mm/s" in html or "0.005 m/s" in html
    assert block_run() == recording
    assert block_run(seed=1) != recording


def test_a_frame_is_read_back_in_its_own_units() -> None:
    recording = block_run()
    metres = {"t": ss.Channel("t", "s"), "x1": ss.Channel("x1", "m")}
    again = ss.load_recording(recording.to_dataframe(), BLOCK, channels=metres, belt_speed=0.005)
    np.testing.assert_allclose(again.x1, recording.x1, rtol=1e-12)
    with pytest.raises(ss.InputError, match="column 'x1': is in 'mm', but its channel is declared in 's'"):
        ss.load_recording(recording.to_dataframe(), BLOCK, channels={**metres, "x1": ss.Channel("x1", "s")})
    bare = example("Trajectory").to_dataframe()
    assert ss.load_recording(bare, MODEL.rig).x1.size == len(bare)


def test_intervals_become_two_columns_in_si() -> None:
    found = example("Found")
    frame = found.to_dataframe().set_index("number")
    one, scales = found.effects[0].parameters["tau"], found.after.rig.scales
    assert frame.loc["sensor_lag.tau", "value"] == pytest.approx(one.value * scales.time)
    assert frame.loc["sensor_lag.tau", "low"] == pytest.approx(one.low * scales.time)
    assert frame.loc["sensor_lag.tau", "high"] == pytest.approx(one.high * scales.time)
    assert frame.loc["sensor_lag.tau", "unit"] == "s"


def test_what_a_file_is_called_is_text_and_no_markup() -> None:
    evil = ss.load_recording(
        {"t": np.arange(10.0), "x1": np.arange(10.0)}, ss.BlockOnBelt(), name="<script>alert(1)</script>"
    )
    assert "script" not in Outline(evil._repr_html_()).tags


def test_a_found_writes_its_report(tmp_path, monkeypatch: pytest.MonkeyPatch) -> None:
    found, case = example("Found"), example("Case")
    with pytest.raises(ss.InputError, match="holds no case"):
        found.write_report(tmp_path / "none")
    quickly(monkeypatch)
    written = replace(found, case=case).write_report(tmp_path / "out")
    assert written[0] == tmp_path / "out" / "report.html"
    assert all(one.stat().st_size > 0 for one in written)
    assert ss.load_model(tmp_path / "out") == found.after


def test_the_table_of_a_law_with_several_contacts_says_so() -> None:
    rig = ss.MatricesRig(M=[[1, 0], [0, 1]], K=[[2, -1], [-1, 2]], contact=[[1, 0], [0, 1]], law=["a", "b"])
    model = ss.Model(rig, friction={"a": COULOMB, "b": ss.CoulombFriction()})
    assert "a.static" in model._repr_html_()
    with pytest.raises(ss.StickslipError, match="nothing can be drawn"):
        model.plot()


def test_a_browser_shows_them_without_complaint(tmp_path) -> None:
    program()
    page = tmp_path / "objects.html"
    parts = "".join(f"<section>{one._repr_html_()}</section>" for one in objects().values())
    page.write_text(f"<!doctype html><meta charset=utf-8><body>{parts}", encoding="utf-8")
    with chromium(viewport={"width": 1000, "height": 800}) as seen:
        seen.page.goto(page.as_uri())
        assert seen.complaints == []
        assert seen.sideways() <= 0
        broken = "[...document.images].filter(one => !one.naturalWidth).length"
        assert seen.page.evaluate(broken) == 0
        assert seen.page.evaluate("document.images.length") == sum(
            isinstance(one, Drawn) for one in objects().values()
        )
        assert [one for one in seen.asked if not one.startswith(("file:", "data:"))] == []


def test_looking_is_what_loads_matplotlib() -> None:
    code = (
        "import sys, stickslip as ss\n"
        "law = ss.CoulombFriction(); repr(law); law == ss.CoulombFriction(static=2)\n"
        "assert 'matplotlib' not in sys.modules and 'stickslip.shown' not in sys.modules\n"
        "law._repr_html_()\n"
        "assert 'matplotlib' in sys.modules and 'matplotlib.pyplot' not in sys.modules"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr


def test_a_block_declared_with_units_has_them_on_the_axes_and_in_frames() -> None:
    law = ss.CoulombFriction(static="2 N", kinetic="1.2 N")
    block = ss.BlockOnBelt(mass="500 g", stiffness="500 N/m")
    run = ss.simulate(ss.Model(block, friction=law), belt_speed="10 mm/s", t_end="1 s")
    over_time, portrait = run.plot().axes
    assert (over_time.get_xlabel(), portrait.get_xlabel()) == ("time $t$ [s]", "$x_1$ [m]")
    assert portrait.get_ylabel() == "$x_2$ [m/s]"
    assert run.to_dataframe().attrs["units"] == {"t": "s", "x1": "m", "x2": "m/s"}
    bare = ss.simulate(ss.Model(ss.BlockOnBelt(), friction=law), belt_speed=0.1, t_end=1)
    assert bare.plot().axes[1].get_xlabel() == "$x_1$"
