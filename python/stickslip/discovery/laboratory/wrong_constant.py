"""What is said for and against a declared constant that is wrong: its evidence, and other constants that would do."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping

from stickslip.discovery.laboratory.constants import Freed
from stickslip.discovery.laboratory.search import Searched
from stickslip.discovery.result import TIED, Alternative, Evidence
from stickslip.likelihoods.interval import Interval

NEAR = 3 * TIED  # difference in -2 log evidence below which a rival is worth a line


def evidence_of(found: Searched, wrong: Freed) -> Evidence:
    """Return what speaks for a wrong constant, and the best effect that was tried in its place."""
    step = found.steps[-1]
    names = [one for one in step.trials if one.names[-1] not in found.chosen.names]
    control = min(names, key=lambda one: one.deviance, default=None)
    fall = None if control is None else max(step.base.deviance - control.deviance, 0.0)
    said = f"{wrong.far:.1f} standard uncertainties from what is declared"
    label = "" if control is None else control.names[-1]
    return Evidence(wrong.gain, wrong.gain, None, fall, label, step.gate.threshold, said)


def rivals_of(
    wrong: Freed, named: Callable[[Freed], tuple[str, Mapping[str, Interval]] | None]
) -> tuple[Alternative, ...]:
    """Return the constants that explain nearly as much; `named` gives the name and numbers of one, None without."""
    out = []
    for one in wrong.rivals:
        what, delta = named(one), wrong.gain - one.gain
        if what is None or delta >= NEAR:
            continue
        name, numbers = what
        reason = "another constant of the rig explains it as well"
        odds = math.exp(-0.5 * max(delta, 0.0))
        out.append(Alternative(name, odds, delta, delta < TIED, False, reason, numbers))
    return tuple(out)
