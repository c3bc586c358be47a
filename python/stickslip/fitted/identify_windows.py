"""The law by output error over windows: every window has an initial state of its own, all share the law."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import fields, replace

import numpy as np

from stickslip.declared.friction.paper import PaperFriction
from stickslip.declared.friction_law import FrictionLaw
from stickslip.declared.model import Model
from stickslip.declared.rig import AnyRig, BlockOnBelt, Rig, on_belt
from stickslip.fitted.covered_speeds import covered_speeds
from stickslip.fitted.identified import Branch, Identified, estimate
from stickslip.fitted.identify_check import explainable, misfit
from stickslip.fitted.identify_words import EXPLAINED, fit_messages
from stickslip.fitted.shooting import Shot, Simulator, shoot
from stickslip.measured import cutting
from stickslip.measured.fit_window import Array, FitWindow
from stickslip.measured.prepared import Measured

Progress = Callable[[str, float], None]


def natural_period(rig: AnyRig) -> float:
    """Period of the free block on its springs, in the rig's unit of time."""
    rig = on_belt(rig)
    if isinstance(rig, BlockOnBelt):
        return float(2 * np.pi * np.sqrt(rig.mass / rig.stiffness))
    return 2 * np.pi


def columns(rig: AnyRig) -> tuple[int, ...]:
    """State column of each recorded channel: x1, and y1 for the rig of (2.1)."""
    return (0, 2) if isinstance(rig, Rig) else (0,)


def single_noise(runs: Sequence[Measured]) -> Array:
    """Standard deviation of a single reading of each channel (c,), over all runs."""
    return np.asarray(np.mean([r.noise * np.sqrt(r.averaged) for r in runs], axis=0))


def law_parameters(law: FrictionLaw) -> dict[Branch, tuple[str, ...]]:
    """Names of the numbers each branch has to be identified from."""
    if isinstance(law, PaperFriction):
        return {
            "minus": ("T_s_minus", "A1", "A2", "t1", "t2", "T_min_minus"),
            "plus": ("T_s_plus", "T_min_plus"),
        }  # not the ends of the fitted ranges, v_w_min and v_w_max: the other numbers can do what they do
    names = [f.name for f in fields(law) if getattr(law, f.name) is not None]
    plus = tuple(n for n in names if n.endswith("_plus"))
    minus = tuple(n for n in names if not n.endswith("_plus"))
    return {"minus": minus, "plus": plus or minus}


def identify_by_windows(
    runs: Sequence[Measured],
    rig: AnyRig,
    start: FrictionLaw,
    simulator: Simulator,
    tell: Progress,
    undeclared: Sequence[str],
) -> Identified:
    """Fit the law to windows, then to whole runs if it explains those as well."""
    branches = law_parameters(start)
    names = tuple(dict.fromkeys([*branches["minus"], *branches["plus"]]))
    model = Model(rig, friction=start)
    declared = np.array([model.parameters[n] for n in names], dtype=float)
    noise = single_noise(runs)
    period, cols = natural_period(rig), columns(rig)
    windows = [_window(r, b, i, cols) for i, r in enumerate(runs) for b in cutting.cut(r.track, period)]
    steps = iter(np.linspace(0.1, 0.9, 80))

    def fit(model: Model, windows: Sequence[FitWindow], what: str) -> Shot:
        return shoot(
            model,
            windows,
            names,
            noise=noise,
            simulator=simulator,
            declared=declared,
            progress=lambda _: tell(what, float(next(steps, 0.9))),
        )

    short = fit(model, windows, "fitting windows")
    explainable(short, noise)
    found = model.replace(**dict(zip(names, short.values.tolist(), strict=True)))
    whole = _whole_runs(runs, short, cols)
    best, where = short, "windows"
    try:
        long = fit(found, whole, "fitting whole runs")
        if _explains(long, short):
            best, where = long, "whole runs"
    except (np.linalg.LinAlgError, ValueError):
        pass  # whole runs are a refinement; a law that cannot follow one keeps the windows' estimate
    return _conclude(runs, rig, start, names, declared, best, short, where, simulator, undeclared)


def _window(run: Measured, bounds: tuple[int, int], number: int, cols: tuple[int, ...]) -> FitWindow:
    """A window of a run, with the state at its start."""
    made = cutting.window(run.track, run.readings, bounds, run=number, columns=cols)
    return replace(made, averaged=run.averaged)


def _whole_runs(runs: Sequence[Measured], short: Shot, cols: tuple[int, ...]) -> list[FitWindow]:
    """One window a run, from the state its first short window was found to start in."""
    first = {w.run: w for w in reversed(short.windows)}
    return [replace(_window(r, (0, len(r.t)), i, cols), initial=first[i].initial) for i, r in enumerate(runs)]


def _explains(long: Shot, short: Shot) -> bool:
    """Whether whole runs cost no more than their fewer free states must (three standard deviations)."""
    gained = max(long.dof - short.dof, 0)
    excess = (long.chi2 - short.chi2) / max(1.0, short.reduced)
    return bool(np.isfinite(long.chi2) and excess < gained + 3 * np.sqrt(2 * gained) + 3)


def _widened(shot: Shot) -> Array:
    """Covariance that allows for what the law leaves unexplained."""
    covariance = shot.covariance * max(1.0, shot.reduced)
    if shot.reduced > EXPLAINED and len(shot.windows) >= 20:
        # the law is not the whole truth: let the scatter between windows speak where it is larger
        ratio = np.diag(shot.sandwich) / np.maximum(np.diag(covariance), 1e-300)
        stretch = np.sqrt(np.maximum(ratio, 1.0))
        covariance = covariance * np.outer(stretch, stretch)
    return covariance


def _conclude(
    runs: Sequence[Measured],
    rig: AnyRig,
    start: FrictionLaw,
    names: tuple[str, ...],
    declared: Array,
    best: Shot,
    short: Shot,
    where: str,
    simulator: Simulator,
    undeclared: Sequence[str],
) -> Identified:
    covariance = _widened(best)
    seen = best.prior_share < 0.99
    values = np.where(seen, best.values, declared)
    law = Model(rig, friction=start).replace(**dict(zip(names, values.tolist(), strict=True))).friction
    estimates = {
        n: estimate(v, float(np.sqrt(c)), float(share), float(d))
        for n, v, c, share, d in zip(
            names, values, np.diag(covariance), best.prior_share, declared, strict=True
        )
    }
    kept, noise = np.flatnonzero(seen), single_noise(runs)
    covered = covered_speeds(Model(rig, friction=law), best.windows, simulator)
    starts = dict(zip(names, declared.tolist(), strict=True))
    messages = fit_messages(estimates, covered, best, where, starts, undeclared)
    return Identified(
        rig=rig,
        law=law,
        estimates=estimates,
        names=tuple(names[i] for i in kept),
        covariance=covariance[np.ix_(kept, kept)],
        covered=covered,
        noise=dict(zip(("x1", "y1"), noise.tolist(), strict=False)),
        reduced_chi2=best.reduced,
        diagnostics={
            "windows": float(len(best.windows)),
            "reduced_chi2_windows": short.reduced,
            "runs": float(len(runs)),
            "whole_runs": float(where == "whole runs"),
            "misfit": misfit(best, noise),
        },
        messages=messages,
    )
