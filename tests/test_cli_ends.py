"""Where the command line ends: closed outputs, full disks."""

from __future__ import annotations

import errno
import sys

import click
import pytest

from stickslip.cli.commands import main


def test_the_program_works_where_the_caller_closed_its_outputs(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys, "stdout", None)
    monkeypatch.setattr(sys, "stderr", None)
    with pytest.raises(SystemExit) as ended:
        main(["--version"])
    assert ended.value.code == 0
    for stream in (sys.stdout, sys.stderr):  # what libraries flush
        stream.flush()
    with pytest.raises(SystemExit) as ended:
        main(["discover", "nowhere"])
    assert ended.value.code == 2
    for stream in (sys.stdout, sys.stderr):
        stream.close()


def test_a_full_disk_is_said_in_one_line(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def full(*_: object, **__: object) -> None:
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr(click.Group, "invoke", full)
    with pytest.raises(SystemExit) as ended:
        main(["discover", "nowhere"])
    assert ended.value.code == 1
    assert capsys.readouterr().err == "stickslip: no space left on device\n"
