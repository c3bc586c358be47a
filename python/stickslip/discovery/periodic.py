"""Where periodic effects may sit: a periodogram of the residual through the model's own response.

For a frequency w0 the core gives the response of every window to a unit sine and cosine. Near w0 the same response
serves, turned by (w - w0) t_j at the window's middle t_j, so that a coarse grid of simulations and a fine grid of
rotations cover all frequencies. A seam is the same with the belt's travel s = v_b t - x1 for time.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from stickslip.declared.catalogue import CATALOGUE
from stickslip.declared.effect import AnyEffect, Effect, effect, tabulated
from stickslip.declared.effect_kind import Wave
from stickslip.discovery.rivals import PERIODIC, Start
from stickslip.fitted.engine import Engine
from stickslip.fitted.solve import Fit
from stickslip.fitted.unknowns import Hypothesis, Unknown
from stickslip.fitted.window import Window

Floats = NDArray[np.float64]
TABLE_KNOTS = 8  # a spline through so many a turn is a sine to half a percent
HIGHEST = 14.0  # angular frequency that a motion still shows
SMALL = 1e-6  # amplitude at which responses are taken; they are linear in it


@dataclass(frozen=True)
class Line:
    """A sine in time: the fall of chi-squared that it promises, its frequency, the weights of sine and cosine by run
    (runs, 2).
    """

    gain: float
    w: float
    amplitudes: Floats


@dataclass
class _Line:
    """Normal equations of one effect at one coarse frequency, by window: with itself (m, 2, 2), with the residual
    (m, 2), with the base's unknowns (m, 2, p); and the windows' phase coordinate (m,).
    """

    N: list[Floats]
    g: list[Floats]
    C: list[Floats]
    at: list[float]


@dataclass
class _Base:
    """The fit that is searched, its windows' own states projected out and each window weighed by its misfit."""

    fit: Fit
    projections: list[_Projector]
    residuals: list[Floats]
    slopes: list[Floats]  # of the base's unknowns, (n, p)
    size: list[float]
    L: Floats  # inverse normal matrix of the base's unknowns
    g: Floats

    @classmethod
    def of(cls, fit: Fit) -> _Base:
        """Take a fit apart."""
        engine, p = fit.engine, len(fit.vector)
        _, precision = engine.hypothesis.prior(len(engine.data))
        projections = [_Projector(b.K) for b in fit.blocks]
        residuals = [P(b.r) for P, b in zip(projections, fit.blocks, strict=True)]
        size = [
            max(1.0, float(r @ r) / len(r)) for r in residuals
        ]  # one gone astray must not outvote the others
        slopes, A, g = [], np.diag(precision), np.zeros(p)
        for w, b, P, r, s in zip(fit.windows, fit.blocks, projections, residuals, size, strict=True):
            J = np.zeros((len(b.r), p))
            J[:, engine.hypothesis.columns(w.run)] = P(b.J)
            slopes.append(J)
            A += J.T @ J / s
            g += J.T @ r / s
        inverse = np.asarray(np.linalg.pinv(A, hermitian=True), dtype=np.float64)
        return cls(fit, projections, residuals, slopes, size, inverse, g)


def periodic_starts(
    fit: Fit,
    names: Sequence[str] = PERIODIC,
    *,
    peaks: int = 2,
    highest: float = HIGHEST,
    step: float = 0.4,
) -> dict[str, list[Start]]:
    """Best starts of the periodic effects on top of a fit, `peaks` of each.

    Parameters
    ----------
    fit : the hypothesis whose residual is searched.
    names : effects to look for.
    highest : largest angular frequency (in time and in belt travel).
    step : of the coarse grid; a window of two cycles turns by less than a radian over half of it.
    """
    taken = {one.name for one in fit.engine.hypothesis.model.effects}
    names = [n for n in names if n not in taken]
    if not names:
        return {}
    base = _Base.of(fit)
    found: dict[str, list[tuple[float, float, Floats]]] = {n: [] for n in names}
    for w0 in np.arange(step, highest, step):
        for name, line in _responses(base, names, float(w0)).items():
            found[name] += _fine(base, line, float(w0), step)
    return {name: _best(name, lines, peaks, step) for name, lines in found.items()}


def strongest_line(fit: Fit, where: str, *, highest: float = HIGHEST, step: float = 0.4) -> Line:
    """The sine in time at a place that promises most to first order, of any frequency up to `highest` and with a phase
    of its own in each run, the base refitted.

    The catalogue has a force on the block and a ripple of the belt; this is for what acts elsewhere, or is no sine.
    """
    base, found = _Base.of(fit), []
    for w0 in np.arange(step, highest, step):
        line = _line_at(base, where, float(w0))
        found.append(max(_fine(base, line, float(w0), step), key=lambda one: one[0]))
    return Line(*max(found, key=lambda one: one[0]))


def _line_at(base: _Base, where: str, w0: float) -> _Line:
    """Responses to the sine and cosine that a periodic curve's knots give."""
    turns = np.linspace(0.0, 1.0, TABLE_KNOTS + 1)
    period = 2 * np.pi / w0
    zero = np.zeros(len(turns))
    term = tabulated(where, "t", period * turns, zero, period=period)
    waves = np.stack([np.sin(2 * np.pi * turns), np.cos(2 * np.pi * turns)], 1)[:-1]
    names = [f"{term.name}.value_{i}" for i in range(len(waves))]
    return _response(base, [term], names, zero[:-1], {term.name: waves})[term.name]


class _Projector:
    """Takes a window's own states out of a vector or matrix."""

    def __init__(self, K: Floats) -> None:
        self.q = np.linalg.qr(K)[0] if K.shape[1] else K

    def __call__(self, x: Floats) -> Floats:
        return np.asarray(x - self.q @ (self.q.T @ x))


def _responses(base: _Base, names: Sequence[str], w0: float) -> dict[str, _Line]:
    terms = [_small(name, w0) for name in names]
    numbers = [f"{t.name}.{p}" for t in terms for p in ("a", "phi")]
    start = np.array([t.parameters[p] for t in terms for p in ("a", "phi")])
    eye = np.diag(np.tile([1.0, 1 / SMALL], len(terms)))
    return _response(
        base, terms, numbers, start, {t.name: eye[:, 2 * i : 2 * i + 2] for i, t in enumerate(terms)}
    )


def _response(
    base: _Base,
    terms: Sequence[AnyEffect],
    numbers: Sequence[str],
    start: Floats,
    waves: Mapping[str, Floats],
) -> dict[str, _Line]:
    """Normal equations of each term's two waves; `waves` says how the numbers make them up, (numbers, 2)."""
    fit = base.fit
    h = fit.engine.hypothesis
    values = h.at(fit.vector, len(fit.engine.data)).model
    unknowns = tuple(Unknown(n, float(v), False, 0.0, 1.0) for n, v in zip(numbers, start, strict=True))
    both = Hypothesis(values.with_effects([*values.effects, *terms]), unknowns, h.phases)
    engine = Engine(fit.engine.data, both, fit.engine.threads, fit.engine.learned)
    out = {term.name: _Line([], [], [], []) for term in terms}
    blocks = engine.linearised(np.asarray(start), fit.windows)
    for j, (w, b) in enumerate(zip(fit.windows, blocks, strict=True)):
        r, s = base.residuals[j], base.size[j]
        for name, line in out.items():
            D = np.zeros((len(r), 2)) if b is None else np.nan_to_num(b.J) @ waves[name]
            D = base.projections[j](D)
            line.N.append(D.T @ D / s)
            line.g.append(D.T @ r / s)
            line.C.append(D.T @ base.slopes[j] / s)
            line.at.append(_middle(fit, w, name))
    return out


def _wave(name: str) -> Wave:
    wave = CATALOGUE[name].wave
    assert wave is not None, name
    return wave


def _small(name: str, w0: float) -> Effect:
    wave = _wave(name)
    number = 2 * np.pi / w0 if wave.along_belt else w0
    return effect(name, a=SMALL, phi=0.0, **{wave.parameter: float(number)})


def _middle(fit: Fit, window: Window, name: str) -> float:
    run = fit.engine.data[window.run]
    part = slice(window.start, window.stop)
    kind = CATALOGUE.get(name)  # a learned table is none of it: its waves run in time
    if kind is None or kind.wave is None or not kind.wave.along_belt:
        return float(np.mean(run.t[part]))
    return float(np.mean(run.belt_speed * run.t[part] - run.readings[part, 0]))


def _fine(base: _Base, line: _Line, w0: float, step: float) -> list[tuple[float, float, Floats]]:
    """(gain, frequency, (runs, 2) amplitudes) over the fine grid about w0, the base's unknowns refitted."""
    N, g, C, at = np.array(line.N), np.array(line.g), np.array(line.C), np.array(line.at)
    span = float(np.ptp(at)) + 1e-9
    runs = np.array([w.run for w in base.fit.windows])
    count = len(base.fit.engine.data)
    member = (runs[None, :] == np.arange(count)[:, None]).astype(float)
    deltas = np.linspace(-step / 2, step / 2, max(3, int(step * span / 0.8) | 1))
    c, s = np.cos(np.outer(deltas, at)), np.sin(np.outer(deltas, at))
    turn = np.stack([np.stack([c, -s], -1), np.stack([s, c], -1)], -2)  # window amplitudes = turn @ run's
    back = turn.swapaxes(-1, -2)

    def by_run(of_windows: Floats) -> Floats:
        """Sums over the windows of each run; (deltas, windows, 2, k) to (deltas, runs, 2, k)."""
        return np.asarray(np.einsum("rw,dwij->drij", member, of_windows, optimize=True))

    NN, gg = by_run(back @ N @ turn), by_run(back @ g[:, :, None]).reshape(len(deltas), -1)
    CC = by_run(back @ C).reshape(len(deltas), 2 * count, -1)
    A = -CC @ base.L @ CC.swapaxes(-1, -2)
    for r in range(count):
        A[:, 2 * r : 2 * r + 2, 2 * r : 2 * r + 2] += NN[:, r]
    A += 1e-6 * np.eye(2 * count) * (np.einsum("dii->di", A)[:, None, :] + 1e-12)
    b = gg - CC @ (base.L @ base.g)
    amplitudes = np.linalg.solve(A, b[:, :, None])[:, :, 0]
    gains = np.einsum("di,di->d", b, amplitudes)
    return [
        (float(gain), w0 + float(delta), one.reshape(count, 2))
        for gain, delta, one in zip(gains, deltas, amplitudes, strict=True)
    ]


def _best(name: str, found: list[tuple[float, float, Floats]], peaks: int, step: float) -> list[Start]:
    starts: list[Start] = []
    used: list[float] = []
    wave = _wave(name)
    for _, w, amplitudes in sorted(found, key=lambda one: -one[0]):
        if len(starts) == peaks:
            break
        if any(abs(w - other) < step for other in used):
            continue
        used.append(w)
        size = float(np.median(np.hypot(amplitudes[:, 0], amplitudes[:, 1])))
        size = min(size, wave.largest)
        phases = tuple(float(np.arctan2(b, a)) for a, b in amplitudes)
        number = 2 * np.pi / w if wave.along_belt else w
        starts.append(
            Start(effect(name, a=max(size, 1e-4), phi=0.0, **{wave.parameter: float(number)}), phases)
        )
    return starts
