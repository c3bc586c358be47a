"""A lag of the y1 reading: no listed effect, but one that a delay of it stands in for."""

from __future__ import annotations

import math
from dataclasses import replace

from stickslip.discovery.intervals import intervals
from stickslip.discovery.result import Interval
from stickslip.discovery.rivals import LOGARITHMIC, hypothesis
from stickslip.discovery.search import Search, Trial
from stickslip.discovery.trace import MARGIN, starts_of
from stickslip.fitted.readings import Y1_LAG
from stickslip.fitted.unknowns import Hypothesis, Unknown

DELAY = "sensor_delay"
BOUNDS = (4e-3, 3.0)


def lag_of(search: Search, chosen: Trial) -> tuple[Trial, Trial] | None:
    """The delay that stands in for a lag of the y1 reading, and the lag fitted; None where the delay is one.

    The lag is fitted alone from where the delay has the law and the windows, and must explain more than what was
    `chosen`, a delay with or without a partner.
    """
    delay = search.tried.get((DELAY,))
    if delay is None or DELAY not in chosen.names:
        return None
    late = delay.model.parameters[f"{DELAY}.delay"]
    if late <= BOUNDS[0]:
        return None
    search.progress("letting the y1 reading lag")
    h = _hypothesis(search, delay, late)
    found = search.run(h, windows_of=delay, tolerance=2e-5, anyway=True)
    return None if found is None or found.bic > chosen.bic - MARGIN else (delay, found)


def time_constant(lag: Trial) -> Interval:
    """Of a fitted lag, with its 95 % interval."""
    return intervals(lag.fit)[Y1_LAG]


def _hypothesis(search: Search, delay: Trial, late: float) -> Hypothesis:
    others = [one for one in starts_of(delay) if one.term.name != DELAY]
    h = hypothesis(delay.hypothesis.model, others, search.model)
    tau = Unknown(Y1_LAG, late, True, math.log(late), LOGARITHMIC, bounds=BOUNDS)
    return replace(h, unknowns=(*h.unknowns, tau))


def told(tau: Interval, after: Trial) -> tuple[str, str]:
    """Why it is a lag, and its formula."""
    words = (
        "a first-order lag of the y1 reading explains more than its delay does; the delay stands in for it in the "
        f"model, and leaves {after.chi2:.3g}"
    )
    return words, f"y1 reads m, tau m' = y1 - m with tau = {tau.value:.4g}"
