"""Output-error fitting by multiple shooting: the law's parameters that make a simulation meet the readings.

The readings are cut into windows. Each window has parameters of its own (its initial state, and what scatters
from event to event), all windows share the law's. The normal equations have the shape of an arrow; the shared
block is reached by eliminating the windows' blocks one at a time (Schur complement), so the cost grows with the
number of windows, not with its cube. Noise on the readings is the only noise assumed, and there is no
differentiation: force-domain fits are biased near capture and release, these are not.
"""

from __future__ import annotations

import inspect
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Protocol

import numpy as np

from stickslip.declared.model import Model
from stickslip.errors import StickslipError
from stickslip.measured.fit_window import Array, FitWindow

FARTHEST = 10.0
TINY = 1e-12  # share added to a diagonal, where few samples tell two numbers of a window as one
STEP = 1e-5  # relative step of the differences; the simulation's error is far below it


class SimulatedRun(Protocol):
    """What a simulator gives back, as far as fitting needs it."""

    @property
    def state(self) -> Array:
        """States, (n, d)."""

    @property
    def sensitivity(self) -> Array:
        """Derivatives, (n, d, p); needed only from a simulator that takes `sensitivity`."""


Simulator = Callable[..., SimulatedRun]


class _Means:
    """A run at two instants for each row, as the means of these."""

    def __init__(self, run: SimulatedRun) -> None:
        self.state: Array = 0.5 * (run.state[::2] + run.state[1::2])
        self.sensitivity: Array = np.empty((len(self.state), 0, 0))


@dataclass(frozen=True)
class Shot:
    """Result of `shoot`.

    Attributes
    ----------
    names, values, covariance
        Shared parameters, (p,) and (p, p). The covariance assumes that the noise is white and the model right.
    sandwich : (p, p) array
        Covariance that does not: windows are the independent units.
    windows : list of FitWindow
        With initial states and local parameters at their estimates.
    local_std : list of mapping
        Standard deviation of each window's local parameters.
    residuals : list of (n, c) array
        Readings minus simulation in standard deviations of the noise.
    chi2, dof : float, int
        Sum of squared residuals and its degrees of freedom.
    prior_share : (p,) array
        Share of each parameter's information that came from its declared start, not from the readings.
    """

    names: tuple[str, ...]
    values: Array
    covariance: Array
    sandwich: Array
    windows: list[FitWindow]
    local_std: list[Mapping[str, float]]
    residuals: list[Array]
    chi2: float
    dof: int
    prior_share: Array

    @property
    def reduced(self) -> float:
        """chi2 / dof: 1 where noise alone separates simulation and readings."""
        return self.chi2 / max(self.dof, 1)


@dataclass
class _ShotBlock:
    """One window linearised: residual r, d r/d shared (J), d r/d local (K)."""

    r: Array
    J: Array
    K: Array


class _Problem:
    def __init__(self, model: Model, names: Sequence[str], noise: Array, simulator: Simulator) -> None:
        self.model = model
        self.names = tuple(names)
        self.noise = noise
        self.atol = 1e-6 * float(np.min(noise))
        self.simulate = simulator
        self.exact = "sensitivity" in inspect.signature(simulator).parameters
        self.state_names: tuple[str, ...] = tuple(model.rig.state_names)
        self._latest: tuple[bytes, Model] = b"", model

    def model_at(self, shared: Array, local: Mapping[str, float]) -> Model:
        """The model with these numbers; that of the shared ones is kept, for all windows have the same."""
        if self._latest[0] != (key := shared.tobytes()):
            self._latest = key, self.model.replace(dict(zip(self.names, shared.tolist(), strict=True)))
        return self._latest[1].replace(local) if local else self._latest[1]

    def run(self, shared: Array, window: FitWindow, sensitivity: tuple[str, ...] = ()) -> SimulatedRun:
        """Simulate one window: a row's state as the mean that it is, derivatives as they are in its middle."""
        t = window.middles if sensitivity else window.instants
        run = self.simulate(
            self.model_at(shared, window.local),
            belt_speed=window.belt_speed,
            initial=tuple(window.initial),
            t_end=float(t[-1]),
            t_eval=t,
            **({"sensitivity": sensitivity, "rtol": 1e-9, "atol": self.atol} if self.exact else {}),
        )
        if len(run.state) != len(t):
            raise StickslipError("the simulation stopped before the end of the window")
        return run if len(t) == len(window.t) else _Means(run)

    def _weighed(self, difference: Array, window: FitWindow) -> Array:
        """Over the noise, flat, 0 where a reading is missing; (n, c, ..) to (n c, ..), in place."""
        noise = self.noise.reshape((1, -1) + (1,) * (difference.ndim - 2)) / np.sqrt(window.averaged)
        difference /= noise
        difference[~np.isfinite(window.readings)] = 0.0
        return difference.reshape(-1, *difference.shape[2:])

    def residual(self, shared: Array, window: FitWindow) -> Array:
        """(readings - simulation)/noise, flat."""
        state = self.run(shared, window).state
        return self._weighed(window.readings - state[:, list(window.columns)], window)

    def linearise(self, shared: Array, window: FitWindow, scale: Array) -> _ShotBlock:
        """Exact derivatives from the simulator where it has them, central differences where not."""
        if self.exact:
            own_names = (*(f"initial.{n}" for n in window.free), *window.local)
            run = self.run(shared, window, (*self.names, *own_names))
            columns = list(window.columns)
            state = run.state if window.averaged == 1 else self.run(shared, window).state
            r = self._weighed(window.readings - state[:, columns], window)
            slopes = run.sensitivity[:, columns, :]
            del run  # holds all states' derivatives
            D = self._weighed(np.negative(slopes, out=slopes), window)
            if not np.isfinite(D).all():
                return self._by_differences(shared, window, scale)
            return _ShotBlock(r, D[:, : shared.size], D[:, shared.size :])
        return self._by_differences(shared, window, scale)

    def _by_differences(self, shared: Array, window: FitWindow, scale: Array) -> _ShotBlock:
        r = self.residual(shared, window)
        J = np.empty((r.size, shared.size))
        for i, s in enumerate(scale):
            h = np.zeros_like(shared)
            h[i] = STEP * s
            J[:, i] = (self.residual(shared + h, window) - self.residual(shared - h, window)) / (2 * h[i])
        own = pack(window, self.state_names)
        own_scale = np.maximum(np.abs(own), self._own_floor(window))
        K = np.empty((r.size, own.size))
        for i in range(own.size):
            h = np.zeros_like(own)
            h[i] = STEP * own_scale[i]
            up, down = unpack(window, own + h, self.state_names), unpack(window, own - h, self.state_names)
            K[:, i] = (self.residual(shared, up) - self.residual(shared, down)) / (2 * h[i])
        return _ShotBlock(r, J, K)

    def _own_floor(self, window: FitWindow) -> Array:
        """Sizes below which a window's own parameter counts as zero, in its unit."""
        size = float(np.nanstd(window.readings)) + 10 * float(np.min(self.noise))
        speed = size / max(float(window.t[-1]), 1e-300) + abs(window.belt_speed)
        state = [speed if n.endswith("2") else size for n in window.free]
        return np.array(state + [1e-3 * abs(v) + 1e-12 for v in window.local.values()])


def pack(window: FitWindow, state_names: Sequence[str]) -> Array:
    """A window's own parameters as one vector: free initial components, then local parameters."""
    initial = [window.initial[state_names.index(n)] for n in window.free]
    return np.array([*initial, *window.local.values()], dtype=float)


def unpack(window: FitWindow, own: Array, state_names: Sequence[str]) -> FitWindow:
    """The window with its own parameters replaced by `own` (see `pack`)."""
    initial = window.initial.copy()
    for n, v in zip(window.free, own, strict=False):
        initial[state_names.index(n)] = v
    local = dict(zip(window.local, own[len(window.free) :].tolist(), strict=True))
    return replace(window, initial=initial, local=local)


def shoot(
    model: Model,
    windows: Sequence[FitWindow],
    names: Sequence[str],
    *,
    noise: Array,
    simulator: Simulator,
    prior_std: Array | None = None,
    declared: Array | None = None,
    iterations: int = 40,
    tolerance: float = 1e-2,
    progress: Callable[[float], None] | None = None,
) -> Shot:
    """Fit shared parameters `names` and each window's own to the readings (Levenberg-Marquardt).

    Parameters
    ----------
    model : Model
        Gives the parameters' starting values.
    windows : sequence of FitWindow
    names : sequence of str
        Shared parameters, as `Model.parameters` names them.
    noise : (c,) array
        Standard deviation of a single reading of each channel.
    simulator : callable
        `stickslip.simulate` or anything with its signature.
    prior_std : (p,) array, optional
        How far the declared start can be off. It only holds what the readings say nothing about;
        `Shot.prior_share` tells where it mattered. Default: as much as the value itself.
    declared : (p,) array, optional
        Values the prior is centred on; default: the starting values.
        Values are held within a factor of ten of them.
    tolerance : float
        Stops when a step lowers chi2 by less.
    progress : callable, optional
        Gets chi2/dof after each iteration.

    Returns
    -------
    Shot

    Raises
    ------
    StickslipError
        If the start itself cannot be simulated.
    """
    problem = _Problem(model, names, noise, simulator)
    shared = np.array([model.parameters[n] for n in names], dtype=float)
    centre = shared.copy() if declared is None else declared
    spread = np.maximum(np.abs(centre), 1e-3) if prior_std is None else prior_std
    scale = np.maximum(np.abs(shared), 0.05)
    windows = list(windows)
    prior = np.diag(1.0 / spread**2)
    readings = sum(int(np.isfinite(w.readings).sum()) for w in windows)
    dof = readings - shared.size - sum(len(w.free) + len(w.local) for w in windows)
    cost = _cost(problem, shared, windows, centre, prior)
    damping = 1e-3
    for _ in range(iterations):
        blocks = [problem.linearise(shared, w, scale) for w in windows]
        before = cost
        shared, windows, cost, damping = _improve(
            problem, shared, windows, blocks, centre, prior, cost, damping
        )
        if progress is not None:
            progress(cost / max(dof, 1))
        if before - cost < tolerance:
            break
    blocks = [problem.linearise(shared, w, scale) for w in windows]
    return _conclude(problem, shared, windows, blocks, prior, dof)


def states(model: Model, window: FitWindow, simulator: Simulator) -> Array:
    """States (n, d) of a window simulated from its own start, with its own numbers in the model."""
    return _Problem(model, (), np.ones(len(window.columns)), simulator).run(np.empty(0), window).state


def _cost(p: _Problem, shared: Array, windows: Sequence[FitWindow], centre: Array, prior: Array) -> float:
    """chi2 plus the prior's penalty; infinite where the parameters are inadmissible."""
    off = shared - centre
    try:
        chi2 = sum(float(np.sum(p.residual(shared, w) ** 2)) for w in windows)
    except StickslipError:
        return np.inf
    total = chi2 + float(off @ prior @ off)
    return total if np.isfinite(total) else np.inf


def _eliminate(
    blocks: Sequence[_ShotBlock], base: Array, gradient: Array, damping: float
) -> tuple[Array, Array, list[Array]]:
    """Reduced normal matrix and gradient of the shared parameters, and what each window needs to follow."""
    A = base + damping * np.diag(np.diag(base) + sum((b.J**2).sum(axis=0) for b in blocks))
    g = gradient.copy()
    follow: list[Array] = []
    for b in blocks:
        C = b.K.T @ b.K
        C[np.diag_indices_from(C)] *= 1 + damping + TINY
        C[np.diag_indices_from(C)] += 1e-12
        E = b.J.T @ b.K
        X: Array = np.asarray(np.linalg.solve(C, np.column_stack([E.T, b.K.T @ b.r])), dtype=float)
        A = A + b.J.T @ b.J - E @ X[:, :-1]
        g = g + b.J.T @ b.r - E @ X[:, -1]
        follow.append(X)
    return A, g, follow


def _improve(
    p: _Problem,
    shared: Array,
    windows: list[FitWindow],
    blocks: Sequence[_ShotBlock],
    centre: Array,
    prior: Array,
    cost: float,
    damping: float,
) -> tuple[Array, list[FitWindow], float, float]:
    """One accepted step, or the old values once the damping says that there is none."""
    while damping < 1e8:
        A, g, follow = _eliminate(blocks, prior, prior @ (shared - centre), damping)
        step = above_zero(shared, np.asarray(-np.linalg.solve(A, g), dtype=float), A, g, centre)
        moved = []
        for w, X in zip(windows, follow, strict=True):
            own = pack(w, p.state_names) - X[:, -1] - X[:, :-1] @ step
            moved.append(unpack(w, own, p.state_names))
        there = limited(shared + step, centre)
        trial = _cost(p, there, moved, centre, prior)
        if trial < cost:
            return there, moved, trial, max(damping / 10, 1e-9)
        damping = damping * 5
    return shared, windows, cost, damping


def above_zero(shared: Array, step: Array, A: Array, g: Array, declared: Array) -> Array:
    """The step along the bound where it would take numbers declared as 0 below that: the others follow."""
    pinned = (declared == 0) & (shared + step < 0)
    if not pinned.any():
        return step
    out = np.where(pinned, -shared, 0.0)
    free = ~pinned
    out[free] = -np.linalg.solve(A[np.ix_(free, free)], g[free] + A[np.ix_(free, pinned)] @ out[pinned])
    return out


def limited(values: Array, declared: Array) -> Array:
    """Values held within a factor `FARTHEST` of what was declared, of its sign; where that is 0, not below it.

    No number of a law may be negative that is 0 where it does nothing. A law that cannot
    explain the readings would else run off to where its terms are spikes or vanish.
    """
    size = np.abs(declared)
    bounded = np.sign(declared) * np.clip(np.sign(declared) * values, size / FARTHEST, size * FARTHEST)
    return np.where(size > 0, bounded, np.maximum(values, 0.0))


def _conclude(
    p: _Problem, shared: Array, windows: list[FitWindow], blocks: Sequence[_ShotBlock], prior: Array, dof: int
) -> Shot:
    A, _, follow = _eliminate(blocks, prior, np.zeros_like(shared), 0.0)
    covariance = np.asarray(np.linalg.inv(A) if shared.size else np.zeros((0, 0)), dtype=float)
    meat = np.zeros_like(A)
    local_std: list[Mapping[str, float]] = []
    for w, b, X in zip(windows, blocks, follow, strict=True):
        # score of the window after its own parameters are eliminated
        s = b.J.T @ b.r - (b.J.T @ b.K) @ X[:, -1]
        meat += np.outer(s, s)
        own = np.linalg.pinv(b.K.T @ b.K) + X[:, :-1] @ covariance @ X[:, :-1].T
        std = np.sqrt(np.maximum(np.diag(own), 0))[len(w.free) :]
        local_std.append(dict(zip(w.local, std.tolist(), strict=True)))
    n = max(len(windows) - 1, 1)
    return Shot(
        names=p.names,
        values=shared,
        covariance=covariance,
        sandwich=covariance @ meat @ covariance * (len(windows) / n),
        windows=windows,
        local_std=local_std,
        residuals=[b.r.reshape(w.readings.shape) for w, b in zip(windows, blocks, strict=True)],
        chi2=float(sum(np.sum(b.r**2) for b in blocks)),
        dof=dof,
        prior_share=np.diag(covariance) * np.diag(prior),
    )
