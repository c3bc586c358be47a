"""What other systems lack is not needed: forks, alarms, limits of processes, /proc."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
import scipy.io

from stickslip.measured.readers.process import PROGRAM

LACKING = """
import os, signal, sys, psutil  # it is what asks the system, on each in its own way
sys.modules["resource"] = None
for module, names in (
    (os, ("register_at_fork", "sysconf", "sched_getaffinity", "fork", "getpgid", "killpg")),
    (signal, ("SIGALRM", "alarm", "pthread_sigmask")),
):
    for name in names:
        if hasattr(module, name):
            delattr(module, name)
"""
READS = """
import numpy as np, stickslip as ss
from stickslip.measured.readers.tables import read_columns
assert read_columns("run.mat", ["t"]).values["t"].size == 50
model = ss.Model(ss.BlockOnBelt(), friction=ss.CoulombFriction())
assert ss.sweep(model, {"belt_speed": [0.1, 0.2]}, t_end=5.0).sizes["belt_speed"] == 2
"""


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    scipy.io.savemat(tmp_path / "run.mat", {"t": np.arange(50.0)})
    (tmp_path / "sitecustomize.py").write_text(LACKING)  # the parser's process reads it too
    return tmp_path


def run(folder: Path, code: str) -> subprocess.CompletedProcess[str]:
    environment = {**os.environ, "PYTHONPATH": str(folder)}
    command = [sys.executable, "-c", code]
    return subprocess.run(
        command, cwd=folder, env=environment, capture_output=True, text=True, check=False, timeout=120
    )


def test_the_system_lacks_what_it_should(folder: Path) -> None:
    done = run(folder, "import os, signal; print(hasattr(os, 'sysconf'), hasattr(signal, 'SIGALRM'))")
    assert done.stdout.split() == ["False", "False"]


def test_files_are_read_and_sweeps_computed(folder: Path) -> None:
    done = run(folder, READS)
    assert done.returncode == 0, done.stderr


SLOW = """
import sys, time
sys.path.insert(0, PARSERS)
import main
main.answered = lambda *_: time.sleep(60)
main.main()
"""
WAITS = """
import pathlib, stickslip as ss
from stickslip.measured.readers import process
from stickslip.measured.readers.tables import read_columns
process.PROGRAM, process.SECONDS = pathlib.Path("slow.py"), 1
try:
    read_columns("run.mat", ["t"])
except ss.InputError as error:
    print(error)
"""


def test_a_parser_that_takes_too_long_is_ended_without_an_alarm(folder: Path) -> None:
    (folder / "slow.py").write_text(SLOW.replace("PARSERS", repr(str(PROGRAM.parent))))
    done = run(folder, WAITS)
    assert "not parsed within 1 s" in done.stdout, done.stderr
