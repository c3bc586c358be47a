"""Rebuild the figures of the documents: `python tools/figures.py`, or with names:
story tutorial rigs branch sweep derivatives.

The story is the search of the demonstration's second half and takes a minute or two.
"""

import re
import shlex
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any

from rich.console import Console

import stickslip as ss
from stickslip.cli.rotated_portrait import story as tell
from stickslip.shown.plot import sweep as plot_sweep
from stickslip.shown.plot.branch import plot_branch
from stickslip.shown.plot.curves import save_figure
from website.law_figures import save

ROOT = Path(__file__).parent.parent
FIGURES = ROOT / "docs" / "figures"


def story() -> None:
    """The README's picture: portraits before and after."""
    with tempfile.TemporaryDirectory() as folder:
        tell(Path(folder), Console(stderr=True))
        shutil.copyfile(
            Path(folder) / "rotated_portrait" / "found" / "figures" / "portrait.png", FIGURES / "story.png"
        )


def tutorial() -> None:
    """What the tutorial's commands draw."""
    page = (ROOT / "docs" / "tutorial.md").read_text(encoding="utf-8")
    lines = re.findall(r"^stickslip (?:example|inspect|init|identify|compare) .*$", page, re.MULTILINE)
    drawn = {"columns": "columns", "identified/friction_characteristic": "friction"}
    with tempfile.TemporaryDirectory() as folder:
        for line in lines:
            program = [sys.executable, "-c", "from stickslip.cli.commands import main; main()"]
            subprocess.run([*program, *shlex.split(line)[1:]], cwd=folder, check=True)
        for name, short in (drawn | {"compared/phase_portrait": "portrait"}).items():
            shutil.copyfile(Path(folder) / f"{name}.png", FIGURES / f"tutorial_{short}.png")


def rigs() -> None:
    """The figure that every program of docs/rigs leaves."""
    for page in sorted((ROOT / "docs" / "rigs").glob("[!i]*.md")):
        shown: dict[str, Any] = {}
        for program in re.findall(
            r"^```python\n(.*?)^```$", page.read_text(encoding="utf-8"), re.DOTALL | re.MULTILINE
        ):
            exec(compile(program, page.name, "exec"), shown)
        save(shown["figure"], FIGURES / f"rig_{page.stem}.svg")


def branch() -> None:
    """Leine's damped oscillator over the belt speed."""
    leine = ss.Model(ss.BlockOnBelt(damping=0.1), friction=ss.HyperbolicFriction(scale=1, decay=3))
    found = ss.continuation(leine, 2.0, parameter="belt_speed", span=(0.5, 3.5), guess=(3.0, 0.0))
    save_figure(plot_branch(found), FIGURES / "branch")


def sweep() -> None:
    """The paper's rig over belt speed and alpha1: what docs/sweeps.md shows, from its own first snippet."""
    shown: dict[str, Any] = {}
    page = (ROOT / "docs" / "sweeps.md").read_text(encoding="utf-8")
    exec(re.findall(r"```python\n(.*?)```", page, re.DOTALL)[0], shown)
    save_figure(plot_sweep.parameter_map(shown["ds"], "periodicity"), FIGURES / "sweep_map")


def derivatives() -> None:
    """Velocity and acceleration from noisy readings, by method."""
    program = ROOT / "bench" / "bench_derivatives.py"
    subprocess.run([sys.executable, program, "--figure", FIGURES / "derivatives"], check=True)


KNOWN = {
    "story": story,
    "tutorial": tutorial,
    "rigs": rigs,
    "branch": branch,
    "sweep": sweep,
    "derivatives": derivatives,
}

if __name__ == "__main__":
    for name in sys.argv[1:] or KNOWN:
        if name not in KNOWN:
            sys.exit(f"figures: no figure '{name}'; known are {', '.join(KNOWN)}")
        KNOWN[name]()
