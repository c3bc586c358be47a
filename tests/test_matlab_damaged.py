"""A damaged MATLAB file is read or refused in one line; it never gives a traceback and never ends the process."""

import io
import os
import random
import subprocess
import time
from pathlib import Path

import numpy as np
import psutil
import pytest
import scipy.io

import stickslip as ss
from stickslip.measured.readers import process
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


@pytest.fixture
def parser_that(tmp_path, monkeypatch):
    """Let the parser do something else than parse, within 1 s and 200 MB; it gives the file to read."""

    def doing(words):
        program = tmp_path / "parser.py"
        real = process.PROGRAM
        program.write_text(
            f"import sys; sys.path.insert(0, {str(real.parent)!r})\n"
            f"import main\nclass Parser:\n    @staticmethod\n    def answer(file, names):\n        {words}\n"
            "main.parser = lambda name: Parser\nmain.main()\n"
        )
        monkeypatch.setattr(process, "PROGRAM", program)
        monkeypatch.setattr(process, "SECONDS", 1)
        monkeypatch.setattr(process, "MEMORY", 200 << 20)
        process.PROCESS.close()
        file = tmp_path / "a.mat"
        file.write_bytes(written())
        return file

    yield doing
    process.PROCESS.close()


@pytest.mark.parametrize(
    ("does", "said"),
    [
        ("import os; os.kill(os.getpid(), 11)", "a damaged MATLAB file (its parser was ended by signal 11)"),
        ("import time; time.sleep(60)", "not parsed within 1 s"),
        ("while True: pass", "not parsed within 1 s"),
        ("import numpy; numpy.ones(10**9)", "it needs more than 0.195 GiB of memory"),
        ("raise RuntimeError('odd')", "a damaged one (odd)"),
        ("import os; os.write(2, bytes(10**6)); raise RuntimeError('loud')", "a damaged one (loud)"),
        ("import os; os._exit(3)", "the process that parses MATLAB files failed"),
        ("import os; os.write(1, b'{'); os._exit(0)", "the process that parses MATLAB files failed"),
    ],
)
def test_a_parser_that_dies_hangs_or_eats_memory_is_one_line(parser_that, does, said):
    file = parser_that(does)
    for _ in range(2):  # the next one is as fresh
        with pytest.raises(ss.InputError) as caught:
            read_columns(file, ["t"])
        assert said in str(caught.value)
        assert len(str(caught.value).splitlines()) == 1


def test_one_process_parses_all_files_of_all_formats(tmp_path, monkeypatch):
    started = []
    real = subprocess.Popen
    monkeypatch.setattr(subprocess, "Popen", lambda *a, **k: started.append(a) or real(*a, **k))
    process.PROCESS.close()
    for name in "abc":
        (tmp_path / f"{name}.mat").write_bytes(written(**KINDS["5"]))
        column_names(tmp_path / f"{name}.mat")
        read_columns(tmp_path / f"{name}.mat", ["t"])
    scipy.io.wavfile.write(tmp_path / "a.wav", 20, SIGNALS["x1"])
    np.testing.assert_array_equal(
        read_columns(tmp_path / "a.wav", ["channel 1"]).values["channel 1"], SIGNALS["x1"]
    )
    assert len(started) == 1


def test_a_parser_that_ended_between_two_files_is_replaced(tmp_path):
    file = tmp_path / "a.mat"
    file.write_bytes(written())
    read_columns(file, ["t"])
    (child,) = (p for p in psutil.Process().children() if str(process.PROGRAM) in p.cmdline())
    child.kill()
    while child.status() != psutil.STATUS_ZOMBIE:
        time.sleep(0.01)
    np.testing.assert_array_equal(read_columns(file, ["t"]).values["t"], T)


def test_a_forked_copy_and_its_origin_read_side_by_side(tmp_path):
    file = tmp_path / "a.mat"
    file.write_bytes(written())
    read_columns(file, ["t"])
    child = os.fork()
    if child == 0:
        good = all((read_columns(file, ["x1"]).values["x1"] == SIGNALS["x1"]).all() for _ in range(3))
        os._exit(0 if good else 1)
    for _ in range(3):
        np.testing.assert_array_equal(read_columns(file, ["t"]).values["t"], T)
    assert os.waitpid(child, 0)[1] == 0


OUTLINES = {
    "nothing": b"",
    "text": b"t,x1,y1\n" * 100,
    "zeros": bytes(400),
    "a cut": written()[:-5],
    "a long element": written()[:132] + b"\xff\xff\xff\x7f" + written()[136:],
    "a cut of version 4": written(format="4")[:200],
    "version 7.3": b"MATLAB 7.3 MAT-file".ljust(512),
}


@pytest.mark.parametrize("kind", OUTLINES)
def test_what_cannot_be_a_whole_file_starts_no_parser(tmp_path, monkeypatch, kind):
    monkeypatch.setattr(subprocess, "Popen", lambda *_, **__: pytest.fail("a parser was started"))
    process.PROCESS.close()
    file = tmp_path / "a.mat"
    file.write_bytes(OUTLINES[kind])
    with pytest.raises(ss.InputError, match=r"MATLAB|empty"):
        read_columns(file, ["t"])


@pytest.mark.parametrize("name", ["a.mat", "a.csv"])
def test_a_pipe_is_refused_and_not_waited_for(tmp_path, name):
    os.mkfifo(tmp_path / name)
    with pytest.raises(ss.InputError, match="no file on a disk"):
        read_columns(tmp_path / name, ["t"])
