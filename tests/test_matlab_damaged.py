"""A damaged MATLAB file is read or refused in one line; it never gives a traceback and never ends the process."""

import io
import random
import signal
import subprocess
from pathlib import Path

import numpy as np
import pytest
import scipy.io

import stickslip as ss
from stickslip.measured.readers.tables import column_names, read_columns

T = np.arange(300) * 0.05
SIGNALS = {"t": T, "x1": np.sin(T), "y1": np.cos(T)}


def written(**how) -> bytes:
    stream = io.BytesIO()
    scipy.io.savemat(stream, SIGNALS, **how)
    return stream.getvalue()


KINDS = {"5": {}, "compressed": {"do_compression": True}, "4": {"format": "4"}}


def outcome(file: Path) -> str:
    try:
        read_columns(file, ["t", "x1", "y1"])
    except ss.InputError as error:
        return "one line" if len(str(error).splitlines()) == 1 else "lines"
    return "read"


@pytest.mark.parametrize("kind", KINDS)
def test_good_files_give_their_numbers(tmp_path, kind):
    file = tmp_path / "a.mat"
    file.write_bytes(written(**KINDS[kind]))
    assert set(column_names(file)) == set(SIGNALS)
    found = read_columns(file, ["x1", "t"])
    for name in ("x1", "t"):
        np.testing.assert_array_equal(found.values[name], SIGNALS[name])


@pytest.mark.parametrize("kind", KINDS)
def test_one_flipped_bit_or_a_cut_is_read_or_refused(tmp_path, kind):
    rng, good, seen = random.Random(kind), written(**KINDS[kind]), set()
    for i in range(8):
        data = bytearray(good)
        data[rng.randrange(400 if i % 2 else len(data))] ^= 1 << rng.randrange(8)
        file = tmp_path / "a.mat"
        file.write_bytes(data if i % 4 else data[: rng.randrange(len(data))])
        seen.add(outcome(file))
    assert "one line" in seen
    assert seen <= {"read", "one line"}


def test_a_parser_that_is_ended_by_a_signal_is_one_line(tmp_path, monkeypatch):
    file = tmp_path / "a.mat"
    file.write_bytes(written())
    fallen = subprocess.CompletedProcess([], -signal.SIGSEGV, b"", b"")
    monkeypatch.setattr(subprocess, "run", lambda *_, **__: fallen)
    with pytest.raises(ss.InputError, match="damaged MATLAB file"):
        read_columns(file, ["t"])
