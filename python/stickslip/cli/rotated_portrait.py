"""The paper's own story: a measured portrait that is rotated, with an irregular stick phase, and what causes it.

"The experimental trajectory shown in Fig. 4 is rather rotated and has an irregular sticking phase" (section 5). The
readings here are simulated, with a cause that the search is not told and noise from a fixed seed; no reading of the
paper's rig is published.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from rich.console import Console
from rich.table import Table

import stickslip
from stickslip.cli.printed import say_table
from stickslip.cli.running.discover import say
from stickslip.declared.catalogue import CATALOGUE
from stickslip.declared.effect import Effect, effect
from stickslip.declared.friction.paper import PaperFriction
from stickslip.declared.model import Model
from stickslip.declared.rig import Rig
from stickslip.declared.toml_file import write_text
from stickslip.discovery.result import Found
from stickslip.files import folder
from stickslip.measured.case import load_case
from stickslip.measured.fit_window import Array
from stickslip.progress import stages
from stickslip.shown.report.files import NAMES, written
from stickslip.shown.report.write import fill
from stickslip.simulated.simulate import simulate

RIG = {
    "m": 2.6, "J": 0.0174, "r": 0.08, "k1": 690.0, "k2": 45.0, "k3": 140.0, "c1": 0.28, "c2": 0.3, "length": 0.012
}  # fmt: skip
LAW = PaperFriction(
    T_s_minus=6.2, A1=3.4, A2=2.75, T_min_minus=1.5, T_s_plus=3.8, T_min_plus=0.9
)  # near Table 1
CAUSE = (effect("sensor_lag", tau=0.16), effect("belt_speed_ripple", a=0.12, w=6.3))
NOISE = 1e-3  # of `length`
SAMPLES, STEP = 1500, 0.06  # model time
SEED = 4


@dataclass(frozen=True)
class Story:
    """What the story ends with: the result, the causes it was made with, and the files written."""

    found: Found
    cause: tuple[Effect, ...]
    paths: list[Path]


@dataclass(frozen=True)
class _StoryRun:
    speed: float
    role: str
    phase: float


RUNS = (
    _StoryRun(0.06, "train", 0.4),
    _StoryRun(0.1, "train", 1.9),
    _StoryRun(0.16, "train", 5.1),
    _StoryRun(-0.07, "train", 1.3),
    _StoryRun(-0.13, "train", 3.6),
    _StoryRun(0.09, "validate", 0.9),
    _StoryRun(-0.1, "validate", 4.4),
)


def story(out: Path, console: Console, *, force: bool = False) -> Story:
    """Make the case, search for the cause, write its report, and tell it.

    Parameters
    ----------
    out : Path
        Folder; the case goes to out/rotated_portrait, its report to out/rotated_portrait/found.
    console : rich.console.Console
        Where it is told.
    force : bool
        Replace files that no former result put there, too.

    Returns
    -------
    Story
    """
    place = out / "rotated_portrait"
    path = write_case(place, force=force)
    console.print(
        "Second half: the paper's own story. Its measured portrait (Fig. 4) is rotated against the simulated one and "
        "its stick phase is irregular. Here is a simulated rig with just that trouble; the search is given the "
        "declared model, Table 1 as a start, and the readings.\n"
    )
    case = load_case(path)
    with (
        folder(place / "found", NAMES, force=force) as temporary,
        stages("discovering", len(CATALOGUE)) as tell,
    ):
        found = stickslip.discover(case, progress=tell)
        tell("drawing the report")
        fill(temporary, found, case)
    say(found, case, console)
    say_table(truth_table(found), console)
    paths = [path, *written(place / "found")]
    console.print(
        f"See {paths[1]}: the phase trajectory before and after, over the measurement.\n", soft_wrap=True
    )
    return Story(found, CAUSE, paths)


def write_case(place: Path, *, force: bool = False) -> Path:
    """Simulate the rig with its cause and write the readings as a case; the same files every time.

    Returns
    -------
    Path
        rig.toml.
    """
    rig = Rig.from_si(**RIG)  # type: ignore[arg-type]  # numbers by name
    model = Model(rig, friction=LAW, effects=CAUSE)
    generator = np.random.default_rng(SEED)
    assert rig.scales is not None
    scales = rig.scales
    columns = np.array([scales.time, 1e3 * scales.length, 1e3 * scales.length])
    names = [f"run_{number:02d}.csv" for number in range(1, len(RUNS) + 1)]
    with folder(place, (*names, "rig.toml"), force=force) as temporary:
        for name, run in zip(names, RUNS, strict=True):
            readings = _readings(model, run)
            readings[:, 1:] += NOISE * generator.standard_normal((SAMPLES, 2))
            np.savetxt(temporary / name, readings * columns, "%.7g", ",", header="t,x1,y1", comments="")
        write_text(temporary / "rig.toml", _toml(1e3 * scales.velocity, 1e3 * scales.length))
    return place / "rig.toml"


def _readings(model: Model, run: _StoryRun) -> Array:
    """t, x1 and y1 as the sensors read them, noise-free; (n, 3) in model units."""
    t, start = STEP * np.arange(SAMPLES), (0.1, 0.1, 0.0, 0.0)
    own = model.replace({f"{e.name}.phi": run.phase for e in model.effects if "phi" in e.parameters})
    motion = simulate(own, belt_speed=run.speed, initial=start, t_end=float(t[-1]), t_eval=t)
    return np.column_stack([t, motion.hidden.get("m", motion.state[:, 0]), motion.state[:, 2]])


def _toml(speed: float, length: float) -> str:
    lines = ['title = "a rotated portrait with an irregular stick phase"', "", "[rig]"]
    lines += [f"{name} = {value}" for name, value in RIG.items()]
    lines += ["", "[noise]", f"x1 = {NOISE * length:.6g}", f"y1 = {NOISE * length:.6g}"]
    for number, run in enumerate(RUNS, 1):
        lines += ["", "[[run]]", f'file = "run_{number:02d}.csv"', f'role = "{run.role}"']
        lines.append(f'belt_speed = "{run.speed * speed:.10g} mm/s"')
    lines += ["", "[channels]"]
    lines += [
        f'{c} = {{ column = "{c}", unit = "{u}" }}' for c, u in (("t", "s"), ("x1", "mm"), ("y1", "mm"))
    ]
    return "\n".join(lines) + "\n"


def truth_table(found: Found) -> Table:
    """The causes that the readings were made with, beside what was found."""
    table = Table(title="made with, and found")
    table.add_column("parameter")
    for name in ("made with", "found", "95 % interval"):
        table.add_column(name, justify="right")
    named = {one.name: one for one in found.effects}
    for cause in CAUSE:
        for parameter, value in cause.parameters.items():
            if parameter == "phi":  # each run has its own
                continue
            one = named[cause.name].parameters.get(parameter) if cause.name in named else None
            got = "not found" if one is None else f"{one.value:.5g}"
            span = (
                "-"
                if one is None or one.low is None or one.high is None
                else f"{one.low:.5g} .. {one.high:.5g}"
            )
            table.add_row(f"{cause.name}.{parameter}", f"{value:.5g}", got, span)
    return table
