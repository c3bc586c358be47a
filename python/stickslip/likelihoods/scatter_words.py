"""What is said of a law where friction scatters: the fit, the scatter, and whether more than scatter is there."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import scipy

from stickslip.declared.scale import percent, plainly, scales
from stickslip.fitted.constant import BEYOND, Constant
from stickslip.fitted.identified import Scatter
from stickslip.fitted.identify import Material
from stickslip.fitted.identify_words import EXPLAINED
from stickslip.likelihoods.fit_state import Fit
from stickslip.likelihoods.memory import correlation
from stickslip.likelihoods.repeating import swollen

CHANCE = 0.01  # of a law that is right, to be doubted


def scatter_messages(
    fit: Fit, chi2: float, sizes: Scatter, constants: Mapping[str, Constant], material: Material
) -> tuple[str, ...]:
    """Return the sentences beside the table."""
    out = [
        f"fitted on {len(fit.own)} events, each with friction of its own: simulation and readings differ by "
        f"{plainly(np.sqrt(chi2), 3)} times the noise (chi-squared {plainly(chi2, 3)} per degree of freedom)",
        differing({"static": sizes.static.value, "kinetic": sizes.kinetic.value, "belt": sizes.belt.value}),
    ]
    if sizes.length is not None:
        way = scales(material.rig, material.recordings[0].channels)["x1"].of(sizes.length, 2)
        out.append(
            f"neighbouring events are alike: correlation {sizes.correlation.value:.2f} from one to the next, over "
            f"{way} along the belt; the intervals know of it"
        )
    moved = [_moved(name, one) for name, one in constants.items() if _far(one)]
    if moved:
        out.append(
            f"{'; '.join(moved)}: farther than three standard uncertainties; `stickslip discover` tells whether it is "
            "that constant or something that acts"
        )
    elif chi2 > EXPLAINED or swollen(fit) or unlike(fit):
        out.append(
            "the declared law and scatter do not explain the readings: the events of one run have more in common than "
            "scatter has; `stickslip discover` looks for what is missing"
        )
    return tuple(out)


def differing(sizes: Mapping[str, float]) -> str:
    """
    Return the sentence on how events differ.

    Parameters
    ----------
    sizes : relative standard deviations of "static" and "kinetic" friction, and of the "belt", what is known of them
    """
    names = {"static": "static", "kinetic": "kinetic", "belt": "the belt's speed"}
    said = ", ".join(f"{name} by {percent(sizes[k])}" for k, name in names.items() if k in sizes)
    return f"friction differs from event to event: {said} (standard deviations); the law is that of the mean event"


def _far(one: Constant) -> bool:
    return abs(one.off) > BEYOND


def _moved(name: str, one: Constant) -> str:
    called = name if one.declared != 1.0 else f"the gain of {name}"
    return f"{called} is {one.value:.4g} rather than {one.declared:.4g}"


def unlike(fit: Fit) -> bool:
    """
    Return whether the events of a run have in common what scatter of their own has not.

    Static friction, the mean and the slope of kinetic friction along the way slipped: the means of the runs against the
    differences within them, by F, a mean of correlated events known less well by (1 + m)/(1 - m).
    """
    curve = fit.random[:, fit.windows.kinetic]
    along = np.linspace(-1, 1, curve.shape[1])
    features = (fit.random[:, 0], curve.mean(axis=1), curve @ along / (along @ along))
    runs = [members for members in fit.windows.by_run if len(members) > 1]
    count = sum(len(members) for members in runs)
    if count <= len(runs):
        return False
    for one in features:
        within = sum(float(np.sum((one[m] - one[m].mean()) ** 2)) for m in runs) / (count - len(runs))
        m, _ = correlation([one[k] for k in runs])
        apart = sum(len(k) * float(one[k].mean()) ** 2 for k in runs) / len(runs)
        ratio = apart / max(within * (1 + m) / (1 - m), 1e-300)
        if scipy.stats.f.sf(ratio, len(runs), count - len(runs)) < CHANCE / len(features):
            return True
    return False
