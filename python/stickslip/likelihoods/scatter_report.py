"""What is said of a law that was identified where friction scatters."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from stickslip.declared.friction.paper import PaperFriction
from stickslip.declared.model import Model
from stickslip.declared.rig import Rig
from stickslip.declared.uncertainty import SIGMAS_95
from stickslip.fitted.constant import Constant
from stickslip.fitted.identified import Branch, Estimate, Events, Identified, estimate
from stickslip.fitted.identify import Material
from stickslip.fitted.identify_words import event_messages, number_messages
from stickslip.fitted.scatter import few
from stickslip.fitted.slip_levels import MAKE, DeclaredLaw, Kind, preferred
from stickslip.likelihoods.belt_windows import BeltWindows
from stickslip.likelihoods.correlated import covariance
from stickslip.likelihoods.declared_numbers import BESIDE, fitted_model
from stickslip.likelihoods.fit_state import Fit
from stickslip.likelihoods.scaled import Scaled
from stickslip.likelihoods.scatter_size import scatter
from stickslip.likelihoods.scatter_words import scatter_messages
from stickslip.likelihoods.shared import Declared
from stickslip.simulated.states import X1, X2

Floats = NDArray[np.float64]
KINDS: Mapping[type[object], Kind] = {kind: name for name, kind in MAKE.items()}


@dataclass(frozen=True)
class ScatterNumbers:
    """Numbers of the law in the declared units: (p,) values, (p, p) covariance, (p,) shares of the prior in them."""

    names: tuple[str, ...]
    values: Floats
    covariance: Floats
    share: Floats


def of_rig(material: Material, declared: Declared, fit: Fit) -> Identified:
    """Return what was identified on the rig of (2.1)."""
    start = material.friction or PaperFriction()
    scatter = fit.population.declared()
    model = fitted_model(Model(material.rig, friction=start, scatter=scatter), fit.values())
    return _general(material, declared, fit, model, _numbers(fit, _bare), None)


def of_block(
    material: Material, units: Scaled, declared: Declared, fit: Fit, preference: float
) -> Identified:
    """Return what was identified of a block on a belt; `preference` is BIC(Coulomb) - BIC(hyperbolic)."""
    values = fit.values()
    made = replace(fitted_model(fit.windows.model, values), scatter=fit.population.declared())
    model = units.model(made, values, _belt(fit).sensors.gains[0])
    found = _numbers(fit, units.size)
    general = _general(material, declared, fit, model, found, units)
    if type(made.friction) not in KINDS:
        return general
    return _one_way(material, general, fit, units, preference)


def way(material: Material) -> Branch:
    """Return the branch that a block shows whose runs all go one way."""
    return "minus" if material.runs[0].belt_speed > 0 else "plus"


def _numbers(fit: Fit, size: Callable[[str], float]) -> ScatterNumbers:
    """The law's numbers, their covariance that of correlated events, a few more uncertain by Student's t."""
    assert fit.solution is not None
    numbers = fit.windows.numbers
    law = fit.windows.model.friction.numbers
    at = [i for i, n in enumerate(numbers) if n.name in law]
    names = tuple(numbers[i].name for i in at)
    values = np.array([numbers[i].value(float(fit.at[i])) for i in at])
    slope = np.array([numbers[i].slope(float(fit.at[i])) for i in at])
    units = np.array([size(name) for name in names])
    _, prior = fit.windows.prior.at(fit.at)
    share = np.diag(fit.solution.covariance)[at] * np.diag(prior)[at]
    wide = covariance(fit)[np.ix_(at, at)] * few(len(fit.own)) ** 2
    scale = slope * units
    return ScatterNumbers(names, values * units, wide * np.outer(scale, scale), np.minimum(share, 1.0))


def _general(
    material: Material,
    declared: Declared,
    fit: Fit,
    model: Model,
    found: ScatterNumbers,
    units: Scaled | None,
) -> Identified:
    """What was identified, every number of the law under its own name."""
    start = material.friction.numbers if material.friction is not None else PaperFriction().numbers
    starts = {n: float(start.get(n, v)) for n, v in zip(found.names, found.values, strict=True)}
    std = np.sqrt(np.diag(found.covariance))
    estimates = {
        n: estimate(float(v), float(s), float(share), starts[n])
        for n, v, s, share in zip(found.names, found.values, std, found.share, strict=True)
    }
    seen = [i for i, n in enumerate(found.names) if estimates[n].status != "unidentified"]
    law = model.replace({n: e.value for n, e in estimates.items() if e.status == "unidentified"})
    length = 1.0 if units is None else units.scales.length
    speed = length if units is None else length * units.scales.omega
    sizes, covered = scatter(fit, length), _covered(fit, speed)
    constants = _constants(fit, declared, _bare if units is None else units.size)
    chi2, noise = _left(fit), np.mean([run.noise for run in fit.windows.data], axis=0)
    events = len(fit.own)
    return Identified(
        rig=material.rig,
        law=law.friction,
        estimates=estimates,
        names=tuple(found.names[i] for i in seen),
        covariance=found.covariance[np.ix_(seen, seen)],
        covered=covered,
        noise=dict(zip(("x1", "y1"), (noise * length).tolist(), strict=False)),
        reduced_chi2=chi2,
        scatter=sizes,
        constants=constants,
        fitted=law,
        diagnostics={
            "windows": float(events),
            "events": float(events),
            "reduced_chi2_windows": chi2,
            "runs": float(len(material.runs)),
            "misfit": _misfit(fit),
        },
        messages=(
            *scatter_messages(fit, chi2, sizes, constants, material),
            *number_messages(estimates, covered, starts, material.undeclared),
        ),
    )


def _one_way(material: Material, found: Identified, fit: Fit, units: Scaled, preference: float) -> Identified:
    """A block's law, its own direction identified, the other as declared or repeated."""
    branch, name = way(material), KINDS[type(found.law)]
    kind = MAKE[name]
    own, other = ("", "_plus") if branch == "minus" else ("_plus", "")
    told = DeclaredLaw(material.friction, frozenset(material.undeclared))
    numbers = found.estimates
    known = told.unseen(branch, kind, list(numbers))
    estimates = {n + own: one for n, one in numbers.items()}
    for n, one in numbers.items():
        value = one.value if known is None else known[n]
        estimates[n + other] = Estimate(value, None, None, None, "unidentified")
    law = kind(**{n: one.value for n, one in estimates.items()})
    events = _events(fit, units)
    assert found.fitted is not None
    words = event_messages(
        name,
        branch,
        preference,
        events,
        material.unit,
        known is not None,
        better=preferred(preference) if told.kind else None,
        how="fitted together, each with friction of its own",
    )
    shown = set(np.asarray(events.run, dtype=int).tolist())
    idle = [
        f"{r.name}: no slip is used: {material.idle(i)}"
        for i, r in enumerate(material.runs)
        if i not in shown
    ]
    kept = [m for m in found.messages if not m.startswith(("branch T_", "unidentified"))]
    return Identified(
        **{
            **vars(found),
            "law": law,
            "fitted": replace(found.fitted, friction=law),
            "estimates": estimates,
            "names": tuple(n + own for n in found.names),
            "events": events,
            "messages": (*words, *kept, *idle),
            "diagnostics": {
                **found.diagnostics,
                **events.levels(),
                "bic_preference_for_hyperbolic": preference,
            },
        }
    )


def _belt(fit: Fit) -> BeltWindows:
    assert isinstance(fit.windows, BeltWindows)
    return fit.windows


def _bare(_: str) -> float:
    return 1.0


def _constants(fit: Fit, declared: Declared, size: Callable[[str], float]) -> dict[str, Constant]:
    """Constants and gains as fitted, a gain as 1 + e; of (2.1) the springs' stiffness as the unit of time, omega."""
    place = {n.name: i for i, n in enumerate(fit.windows.numbers)}
    wide, known = np.sqrt(np.diag(covariance(fit))), np.sqrt(np.diag(declared.covariance))
    out = {}
    for name, uncertainty in zip(declared.names, known.tolist(), strict=True):
        i = place[name]
        number, x, half = fit.windows.numbers[i], float(fit.at[i]), SIGMAS_95 * float(wide[i])
        if name == BESIDE and BESIDE not in _belt(fit).fixed:
            out["omega"] = _omega(_belt(fit), x, half, uncertainty)
            continue
        gain = name in declared.gains
        unit = 1.0 if gain else size(name)
        value, low, high, told = (
            float(gain) + number.value(at) * unit for at in (x, x - half, x + half, number.start)
        )
        out[declared.gains.get(name, name)] = Constant(value, low, high, told, uncertainty)
    return out


def _omega(windows: BeltWindows, beside: float, half: float, known: float) -> Constant:
    """What the springs of (2.1) beside alpha1 say of its unit of time, omega."""
    mass, rig = windows.fixed["alpha1"], windows.model.rig
    assert isinstance(rig, Rig)
    assert rig.scales is not None
    value, low, high = (
        rig.scales.omega * math.sqrt(1 + at / mass) for at in (beside, beside - half, beside + half)
    )
    return Constant(value, low, high, rig.scales.omega, 0.5 * known / mass)


def _covered(fit: Fit, size: float) -> Mapping[Branch, tuple[float, float] | None]:
    """Range of |v_w| in slip on each branch; the belt's speed is each window's own."""
    seen: dict[Branch, list[Floats]] = {"minus": [], "plus": []}
    windows = _belt(fit)
    motions = windows.motions(fit.at, fit.own)
    for motion, own, run in zip(motions, fit.own, windows.runs, strict=True):
        if motion is None:
            continue
        v_w = motion.state[:, X2] - windows.data[run].belt_speed * (1 + own[-1])
        seen["minus"].append(-v_w[motion.mode < 0])
        seen["plus"].append(v_w[motion.mode > 0])
    covered: dict[Branch, tuple[float, float] | None] = {}
    for branch, parts in seen.items():
        u = np.concatenate(parts) * size if parts else np.zeros(0)
        covered[branch] = (float(u.min()), float(u.max())) if u.size else None
    return covered


def _left(fit: Fit) -> float:
    """Chi-squared per degree of freedom, what the windows' own numbers take counted."""
    assert fit.linear is not None
    count = float(fit.linear.count.sum())
    chi2 = sum(float((b[:, :, -1] ** 2).sum()) for b in fit.blocks if b is not None)
    return chi2 / max(count - float(fit.freedom.sum()) - len(fit.at), 1.0)


def _misfit(fit: Fit) -> float:
    """Root mean square of readings minus simulation over the readings' spread within windows, of the worse channel."""
    windows = _belt(fit)
    off, spread = np.zeros(windows.channels), np.zeros(windows.channels)
    for block, w in zip(fit.blocks, windows.stretches, strict=True):
        if block is None:
            continue
        weight = windows.data[w.run].weight[w.start : w.stop]
        readings = np.where(weight > 0, windows.data[w.run].readings[w.start : w.stop], np.nan)
        off += ((block[:, :, -1] * windows.data[w.run].noise) ** 2).sum(axis=0)
        spread += np.nansum((readings - np.nanmean(readings, axis=0)) ** 2, axis=0)
    return float(np.sqrt(np.max(off[:2] / np.maximum(spread[:2], 1e-300))))


def _events(fit: Fit, units: Scaled) -> Events:
    """Every slip of a block with its levels: spring and damper where it breaks away, the mean of the kinetic curve."""
    windows, values = _belt(fit), fit.values()
    law = fitted_model(windows.model, values).friction
    force, length = units.size("static"), units.scales.length
    motions, rows = windows.motions(fit.at, fit.own), []
    for own, block, motion, w in zip(fit.random, fit.blocks, motions, windows.stretches, strict=True):
        if motion is None or block is None:
            continue
        run = windows.data[w.run]
        way, x = float(np.sign(run.belt_speed)), motion.state[:, X1]
        slips = np.flatnonzero(motion.mode != 0)
        begins = max(int(slips[0]), 1) if len(slips) else 0
        pull = run.belt_speed * (values["damping"] + 0.5 * values["stiffness"] * (motion.t[1] - motion.t[0]))
        static = way * (values["stiffness"] * float(x[begins - 1]) + pull)
        amplitude = float(np.abs(x[begins - 1] - x[begins:]).max())
        kinetic = float(law.magnitude(np.array([-0.5 * amplitude * way]))[0]) * (
            1 + own[windows.kinetic].mean()
        )
        rms = float(np.sqrt(np.mean(block[:, 0, -1] ** 2))) * run.noise[0]
        at = motion.t[begins] / units.scales.omega
        rows.append((at, static * force, kinetic * force, amplitude * length, rms * length, float(w.run)))
    return Events(*np.array(rows).T)
