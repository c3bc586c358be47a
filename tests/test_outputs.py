"""Nothing is written over: inputs, a user's files, devices, pipes and what links lead to."""

from __future__ import annotations

import errno
import json
import os
import stat
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

import stickslip as ss
from stickslip.errors import QUOTED, InputError, Place, quoted
from stickslip.files import RECORD, chosen, folder, whole

NAMES = ("model.toml", "figures/*.svg")


def write(out: Path, text: str, *, force: bool = False, inputs: tuple[Path, ...] = ()) -> None:
    with folder(out, NAMES, force=force, inputs=inputs) as into:
        (into / "model.toml").write_text(text)
        (into / "figures").mkdir()
        (into / "figures" / f"{text}.svg").write_text(text)


def test_a_result_replaces_a_former_one_whole(tmp_path: Path) -> None:
    write(tmp_path / "out", "a")
    (tmp_path / "out" / "notes.txt").write_text("mine")
    write(tmp_path / "out", "b")
    assert (tmp_path / "out" / "model.toml").read_text() == "b"
    assert [one.name for one in (tmp_path / "out" / "figures").iterdir()] == ["b.svg"]
    assert (tmp_path / "out" / "notes.txt").read_text() == "mine"
    assert sorted(json.loads((tmp_path / "out" / RECORD).read_text())) == ["figures/b.svg", "model.toml"]


@pytest.mark.parametrize("name", ["model.toml", "figures/mine.svg"])
def test_a_file_of_the_users_stays(tmp_path: Path, name: str) -> None:
    mine = tmp_path / "out" / name
    mine.parent.mkdir(parents=True)
    mine.write_text("mine")
    with pytest.raises(ss.InputError, match="no former result put there"):
        write(tmp_path / "out", "a")
    assert mine.read_text() == "mine"
    write(tmp_path / "out", "a", force=True)
    assert (tmp_path / "out" / "model.toml").read_text() == "a"


def test_a_result_that_was_changed_since_is_the_users(tmp_path: Path) -> None:
    write(tmp_path / "out", "a")
    (tmp_path / "out" / "model.toml").write_text("mended by hand")
    with pytest.raises(ss.InputError, match="was changed since it was written"):
        write(tmp_path / "out", "b")
    assert (tmp_path / "out" / "model.toml").read_text() == "mended by hand"


def test_an_input_is_not_replaced_by_force_either(tmp_path: Path) -> None:
    case = tmp_path / "model.toml"
    case.write_text("case")
    with pytest.raises(ss.InputError, match="which is read here"):
        write(tmp_path, "a", force=True, inputs=(case,))
    assert case.read_text() == "case"


def test_a_link_in_a_folder_is_not_replaced(tmp_path: Path) -> None:
    (tmp_path / "kept.toml").write_text("kept")
    (tmp_path / "out").mkdir()
    (tmp_path / "out" / "model.toml").symlink_to(tmp_path / "kept.toml")
    with pytest.raises(ss.InputError, match="a link"):
        write(tmp_path / "out", "a", force=True)
    assert (tmp_path / "kept.toml").read_text() == "kept"


def test_a_folder_on_another_disk_is_written_to_though_a_link_leads_there(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    disk, here = tmp_path / "disk", tmp_path / "here"
    disk.mkdir(), here.mkdir()
    (here / "out").symlink_to(disk)
    usual = Path.replace

    def on_one_disk(self: Path, to: Path) -> Path:
        if self.resolve().is_relative_to(disk) != to.resolve().is_relative_to(disk):
            raise OSError(errno.EXDEV, os.strerror(errno.EXDEV))
        return usual(self, to)

    monkeypatch.setattr(Path, "replace", on_one_disk)
    write(here / "out", "a")
    assert (disk / "model.toml").read_text() == "a"
    assert sorted(os.listdir(disk)) == sorted([RECORD, "figures", "model.toml"])
    assert os.listdir(here) == ["out"]


def test_a_link_to_a_folder_that_is_not_there_is_followed(tmp_path: Path) -> None:
    (tmp_path / "out").symlink_to("to")
    write(tmp_path / "out", "a")
    assert (tmp_path / "to" / "model.toml").read_text() == "a"
    assert (tmp_path / "out").is_symlink()


@pytest.mark.parametrize("way", ["circle", "inner file", "inner link"])
def test_a_folder_that_cannot_be_filled_is_refused_before_any_work(tmp_path: Path, way: str) -> None:
    out = tmp_path / "out"
    if way == "circle":
        out.symlink_to("out")
    else:
        out.mkdir()
        (tmp_path / "mine").mkdir()
        inner = out / "figures"
        inner.write_text("mine") if way == "inner file" else inner.symlink_to("../mine")
    with pytest.raises(ss.InputError), folder(out, NAMES):
        pytest.fail("work was done")


@pytest.mark.parametrize("way", ["circle", "record", "closed"])
def test_a_file_that_cannot_be_written_is_refused_before_any_work(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, way: str
) -> None:
    out = tmp_path / ("new/" + RECORD if way == "record" else "out")
    if way == "circle":
        out.symlink_to("out")
    if way == "closed":  # the superuser may write anywhere
        monkeypatch.setattr(os, "access", lambda *_: False)
    with pytest.raises(ss.InputError, match=r"cannot be written|record of results"), chosen([out], {}):
        pytest.fail("work was done")


def test_a_pipe_stays_a_pipe(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe")
    with pytest.raises(ss.InputError, match="a device or a pipe"), whole(tmp_path / "pipe"):
        pytest.fail("the work began")
    assert stat.S_ISFIFO((tmp_path / "pipe").stat().st_mode)


def test_a_link_is_followed(tmp_path: Path) -> None:
    (tmp_path / "deep").mkdir()
    (tmp_path / "run.csv").symlink_to(tmp_path / "deep" / "run.csv")
    with whole(tmp_path / "run.csv") as temporary:
        temporary.write_text("t")
    assert (tmp_path / "run.csv").is_symlink()
    assert (tmp_path / "deep" / "run.csv").read_text() == "t"


@pytest.mark.parametrize("name", ["a" * 300, "there/is/a/file/below"])
def test_a_place_that_cannot_be_is_said_in_a_line(tmp_path: Path, name: str) -> None:
    (tmp_path / "there").write_text("")
    with pytest.raises(ss.InputError, match="cannot be written"), whole(tmp_path / name):
        pytest.fail("the work began")
    with pytest.raises(ss.InputError, match="cannot be written"), folder(tmp_path / name, NAMES):
        pytest.fail("the work began")


@given(st.text(max_size=3000), st.integers(3, 300))
def test_what_is_quoted_fits_a_line(text: str, most: int) -> None:
    told = quoted(text, most)
    assert len(told) <= most
    assert told.isprintable()
    if text.isprintable() and len(text) <= most:
        assert told == text


@given(st.text(min_size=1, max_size=3000))
def test_a_message_is_one_line_of_bounded_length(text: str) -> None:
    place = Place(file=text, table=text, column=text)
    said = str(InputError(f"'{text}' is none", key=text, value=text, place=place))
    assert said.isprintable()
    assert len(said) < 10 * QUOTED


def test_numbers_of_hundreds_of_digits_are_said_to_be_infinite() -> None:
    with pytest.raises(ss.InputError, match="infinite"):
        ss.Rig(alpha1=10**400, alpha2=8, beta3=4, eta1=0.1, eta12=0.2)


CASE = """[rig]
kind = "block_on_belt"
mass = 1.0
stiffness = 1.0
[[run]]
file = "{file}"
role = "train"
belt_speed = 0.1
[channels]
t = {{ column = "t", unit = "1" }}
x1 = {{ column = "x1", unit = "1" }}
"""


@pytest.mark.parametrize("way", ["up", "absolute", "link"])
def test_a_case_reads_nothing_outside_its_folder(tmp_path: Path, way: str) -> None:
    (tmp_path / "case").mkdir()
    secret = tmp_path / "secret.csv"
    secret.write_text("t,x1,password\n" + "".join(f"{i},{i % 3},hunter2\n" for i in range(20)))
    (tmp_path / "case" / "link.csv").symlink_to(secret)
    file = {"up": "../secret.csv", "absolute": str(secret), "link": "link.csv"}[way]
    (tmp_path / "case" / "rig.toml").write_text(CASE.format(file=file))
    with pytest.raises(ss.InputError, match="lies outside the case's folder") as refused:
        ss.load_case(tmp_path / "case")
    assert "password" not in str(refused.value)
    case = ss.load_case(tmp_path / "case", files_from=tmp_path)
    assert len(case.runs[0]) == 20
    assert case.files[1].samefile(secret)
