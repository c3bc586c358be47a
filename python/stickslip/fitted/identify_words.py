"""What an identification says in sentences beside its table."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from stickslip.declared.scale import percent, plainly
from stickslip.fitted.identified import BRANCHES, Branch, Estimate, Events, Identified, stopped
from stickslip.fitted.shooting import Shot

POOR = 0.15  # of a slip's amplitude, or of the readings' spread: misfit that a friction law does not leave
MANY = 9.0  # the same of a misfit of three times the noise
EXPLAINED = 1.2  # chi-squared per degree of freedom up to which a law without scatter explains the readings
HUNDRED = 1e4  # chi2 per degree of freedom of a misfit of a hundred times the noise


def fit_messages(
    estimates: Mapping[str, Estimate],
    covered: Mapping[Branch, tuple[float, float] | None],
    best: Shot,
    where: str,
    starts: Mapping[str, float],
    undeclared: Sequence[str] = (),
) -> tuple[str, ...]:
    """Say how well the law fits, and which of its numbers and branches the runs do not tell.

    `starts` holds where the search began; `undeclared` names the numbers whose start nobody declared.
    """
    return *explained_messages(where, best.reduced), *number_messages(estimates, covered, starts, undeclared)


def explained_messages(where: str, reduced: float, *, widened: bool = True) -> list[str]:
    """Say how well a law explains what it was fitted on, whether intervals know, and who looks for what is missing."""
    out = [
        f"fitted on {where}: simulation and readings differ by {plainly(np.sqrt(reduced), 3)} times the noise "
        f"(chi-squared {plainly(reduced, 3)} per degree of freedom)"
    ]
    if reduced > EXPLAINED:
        left = "are widened by what it leaves" if widened else "know nothing of what it leaves"
        out.append(
            f"the declared law does not explain the readings; the intervals {left}, and `stickslip discover` looks for "
            "what is missing"
        )
    return out


def number_messages(
    estimates: Mapping[str, Estimate],
    covered: Mapping[Branch, tuple[float, float] | None],
    starts: Mapping[str, float],
    undeclared: Sequence[str] = (),
) -> tuple[str, ...]:
    """Say which of the law's numbers and branches the runs do not tell; the rest is as in `fit_messages`."""
    out = []
    absent = [n for n, e in estimates.items() if e.status == "unidentified"]
    for names, whose in (
        ([n for n in absent if n not in undeclared], "declared start"),
        ([n for n in absent if n in undeclared], "the start of the law's defaults, as none is declared,"),
    ):
        if names:
            out.append(f"unidentified, {whose} kept: {', '.join(names)}")
    at_limit = {n: stopped(e.value, starts[n]) for n, e in estimates.items()}
    weak = [n for n, e in estimates.items() if e.status == "weak" and not at_limit[n]]
    if weak:
        out.append(f"only weakly determined at the speeds visited: {', '.join(weak)}")
    out += _limit_messages(at_limit, undeclared)
    for branch in BRANCHES:
        if covered[branch] is None:
            out.append(f"branch T_{branch} was never visited")
    return tuple(out)


def _limit_messages(at_limit: Mapping[str, int], undeclared: Sequence[str]) -> list[str]:
    """Say which numbers stopped at the limit of the search, and at which."""
    out = []
    for side, where, more in ((1, "ten times", "more"), (-1, "a tenth of", "less")):
        for start in ("the declared value", "the law's default (none is declared)"):
            default = start != "the declared value"
            names = [n for n, at in at_limit.items() if at == side and (n in undeclared) == default]
            if names:
                out.append(
                    f"{' and '.join(names)} stopped at {where} {start}, the limit of the search: the readings ask for "
                    f"{more}, or the law is not theirs; declare a start nearer to it in [friction] if {more} is meant"
                )
    return out


def spread_share(share: float) -> str:
    """Write a misfit as a share of the readings' spread."""
    return f"{plainly(share)} times their spread" if share > 1 else f"{percent(share)} of their spread"


def misfit_messages(found: Identified) -> list[str]:
    """Say, last of all, where a law fits so badly that its numbers mean little, and what to look at."""
    share, off = found.diagnostics.get("misfit", 0.0), plainly(np.sqrt(found.reduced_chi2), 3)
    if share > POOR:
        return [
            f"the law does NOT reproduce the readings (off by {off} times the noise, {spread_share(share)}): "
            "do not trust its numbers or their intervals; are the rig's numbers, the units and the belt speeds right? "
            "if they are, discover looks for what the model lacks"
        ]
    if share and found.reduced_chi2 > HUNDRED:
        return [
            f"simulation and readings differ by {spread_share(share)} only, yet by {off} times the noise: "
            "is [noise] right?"
        ]
    if share and found.reduced_chi2 > MANY:
        return [
            f"simulation and readings differ by {off} times the noise: more than this law explains, and more than the "
            "intervals know of; a number of the rig is off or an effect is missing, and discover looks for which"
        ]
    return []


def plateau_messages(runs: Sequence[tuple[float, float, float]], belt: str) -> list[str]:
    """Say so where a block rides in its sticks at a speed off the set-point; runs: (plateau, its std, set-point)."""
    off = [
        plateau / set_point
        for plateau, std, set_point in runs
        if np.isfinite(plateau) and abs(plateau - set_point) > max(5 * std, 0.03 * abs(set_point))
    ]
    if not off:
        return []
    ratio = float(np.mean(off))
    used = (
        "the plateau speed is used"
        if belt == "plateau"
        else "the set-point is used; belt_speed='plateau' (--belt-speed-from plateau) changes that"
    )
    return [f"the sticks ride at {ratio:.3f} times the set-point ({len(off)} of {len(runs)} runs); {used}"]


def event_messages(
    kind: str,
    branch: Branch,
    preference: float,
    events: Events,
    unit: str,
    declared: bool | None,
    better: str | None = None,
    how: str = "fitted one by one",
    shared: bool = False,
) -> tuple[str, ...]:
    """Say what slips fitted one by one were like.

    Parameters
    ----------
    kind, branch, preference, events
        Of the law chosen.
    unit
        Written behind forces.
    declared
        Whether the numbers of the direction never visited are declared ones; None: it is visited by other runs.
    better
        What BIC would have chosen, where the kind was declared; None where it chose.
    how
        The slips were fitted.
    shared
        Whether the runs of both directions have chosen together, and these alone would have chosen another.
    """
    drop = events.static - events.kinetic
    other = "plus" if branch == "minus" else "minus"
    why = {
        "coulomb": "no decisive gain from a decay with speed"
        if preference > 0
        else "a decay with speed fits worse",
        "hyperbolic": "friction falls with speed rather than at once",
    }[kind]
    bic = f"(BIC, Coulomb minus hyperbolic: {preference:.1f})"
    alone = f"{kind} law chosen by BIC (Coulomb minus hyperbolic: {preference:.1f}): {why}"
    if shared:
        alone = f"{kind} law, chosen by BIC of both directions together {bic.replace('(', '(here ', 1)}"
    chosen = {
        None: alone,
        kind: f"{kind} law, as declared {bic}",
    }.get(better, f"{kind} law, as declared; a {better} law fits better {bic}: declare that, or no law")
    q = np.quantile(events.static, [0.05, 0.5, 0.95])
    share = float(np.median(events.rms / events.amplitude))
    doubt = (
        f"the law does NOT reproduce these slips (to {percent(share)} of their amplitude only): do not trust its "
        "numbers or their intervals; is the belt's speed right, does the block stick between them, is the "
        "noise too large?"
    )
    unseen = (
        f"branch T_{other} was never visited: its numbers are unidentified, "
        + (
            "the declared ones are kept"
            if declared
            else f"T_{branch}'s are repeated, as its own are not declared"
        ),
    )
    return (
        *((doubt,) if share > POOR else ()),
        f"{len(events.t)} slips {how}; {chosen}",
        f"breakaway force: median {q[1]:.4g}{unit}, 90 % of slips between {q[0]:.4g} and {q[2]:.4g}{unit}",
        f"drop at breakaway: {drop.mean():.4g}{unit}, {drop.std(ddof=1):.2g}{unit} (1 sigma) from slip to slip",
        f"a single slip is reproduced to {percent(share)} of its amplitude (median)",
        *(unseen if declared is not None else ()),
    )
