"""The main job on a real recording: a paper slider on paper, pulled by a spring at 1.1 mm/s."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from importlib.resources import as_file, files

from stickslip.fitted.compare import Comparison, compare
from stickslip.fitted.identified import Identified
from stickslip.likelihoods.identify import identify
from stickslip.measured.case import Case, load_case

GRAVITY = 9.81
SOURCE = "J. Colas et al., Phys. Rev. E (2019); data: N. Pustelnik and V. Vidal, CeCILL-B"


@dataclass(frozen=True)
class Demo:
    """What the demonstration found, and what there is to say before and after its tables."""

    case: Case
    found: Identified
    comparison: Comparison
    before: tuple[str, ...]
    after: tuple[str, ...]


def run(progress: Callable[[str, float], None]) -> Demo:
    """Load, check, identify, simulate and compare the recording that comes with the package.

    Parameters
    ----------
    progress : callable
        Told what is being done and the share done.

    Returns
    -------
    Demo
    """
    progress("loading", 0.0)
    with as_file(files("stickslip") / "data" / "paper_slider") as folder:
        case = load_case(folder / "rig.toml")
    found = identify(
        case, belt_speed="plateau", progress=lambda what, share: progress(what, 0.05 + 0.75 * share)
    )
    assert isinstance(found, Identified)  # of a block on a belt
    comparison = compare(
        found.model,
        case.validate[0],
        belt_speed="plateau",
        progress=lambda what, share: progress(what, 0.8 + 0.2 * share),
    )
    return Demo(case, found, comparison, _before(case), _after(case, found, comparison))


def _before(case: Case) -> tuple[str, ...]:
    recording = case.runs[0]
    rate = 1.0 / float(recording.t[1] - recording.t[0])
    heard = "\n".join(f"- {f}" for f in case.findings) or "- nothing odd"
    return (
        f"{case.title} ({SOURCE}). Spring force at {rate:.0f} Hz; the first part identifies, the rest validates.",
        f"What the check of the recording says:\n{heard}",
    )


def _after(case: Case, found: Identified, c: Comparison) -> tuple[str, ...]:
    d = found.diagnostics
    weight = float(case.rig.mass) * GRAVITY if hasattr(case.rig, "mass") else 1.0
    static, kinetic = d["static_mean"] / weight, d["kinetic_mean"] / weight
    spread = d["static_std_between_events"] / d["drop_mean"]
    nrmse = c.row("forecast NRMSE").simulated
    period = c.row("period")
    messages = "\n".join(f"- {m}" for m in found.messages)
    regular = (
        f"Found: the slider sticks and slips, {d['events']:.0f} slips in the first part; friction coefficient "
        f"{static:.3f} at breakaway, {kinetic:.3f} in sliding.\n{messages}"
    )
    left = (
        "Left over by a textbook law: the breakaway level wanders from slip to slip with the patch of paper the "
        f"slider is on ({spread:.1f} times the mean drop, correlated over about "
        f"{2 * d['level_correlation_events']:.0f} slips). The simulation therefore gives the typical cycle (its "
        f"period is {_share(period.simulated, period.measured)} of the measured mean), one closed orbit in the midst "
        f"of the measured ones, and cannot say when the next slip comes: its forecast is off by {nrmse or 0:.2g} "
        "standard deviations of the signal. Creep before the slips is not in the law at all."
    )
    return regular, left


def _share(a: float | None, b: float | None) -> str:
    return "unknown share" if not a or not b else f"{100 * a / b:.0f} %"
