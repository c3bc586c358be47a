"""A rig of bodies event by event with SciPy's solve_ivp: written apart from the package, slow and obvious."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
import scipy
from numpy.typing import NDArray

Floats = NDArray[np.float64]


@dataclass
class Apart:
    """M q'' + C q' + K q = force - D' T, T_j = sgn(v_j) kinetic_j(|v_j|), v = D q' - V(t) of each contact."""

    M: Floats
    C: Floats
    K: Floats
    D: Floats
    kinetic: Sequence[Callable[[float], float]]
    static: Sequence[float]
    V: Sequence[Callable[[float], tuple[float, float]]]  # speed and its rate
    force: Floats

    def load(self, t: float, z: Floats) -> Floats:  # noqa: ARG002  # of a rig that is pulled it depends on both
        """Force on the coordinates beside springs, dampers and friction."""
        return self.force

    def holding(self, t: float, z: Floats, modes: Sequence[int]) -> Floats:
        """T of every contact: the law's where it slips, what holds it where it sticks."""
        n = len(self.M)
        T = np.zeros(len(self.D))
        for j, s in enumerate(modes):
            if s:
                T[j] = s * self.kinetic[j](s * float(self.D[j] @ z[n:] - self.V[j](t)[0]))
        stuck = [j for j, s in enumerate(modes) if s == 0]
        if stuck:
            free = np.linalg.solve(self.M, self.load(t, z) - self.C @ z[n:] - self.K @ z[:n] - self.D.T @ T)
            D = self.D[stuck]
            G = D @ np.linalg.solve(self.M, D.T)
            T[stuck] = np.linalg.solve(G, D @ free - [self.V[j](t)[1] for j in stuck])
        return T

    def field(self, t: float, z: Floats, modes: Sequence[int]) -> Floats:
        n = len(self.M)
        total = self.load(t, z) - self.C @ z[n:] - self.K @ z[:n] - self.D.T @ self.holding(t, z, modes)
        return np.concatenate([z[n:], np.linalg.solve(self.M, total)])

    def margins(self, t: float, z: Floats, modes: Sequence[int]) -> dict[tuple[int, int], float]:
        """What ends the modes: above 0 while they last, by contact and the mode that follows."""
        n, out = len(self.M), {}
        T = self.holding(t, z, modes)
        for j, s in enumerate(modes):
            if s:
                out[j, 0] = s * float(self.D[j] @ z[n:] - self.V[j](t)[0])
            else:
                out[j, 1], out[j, -1] = self.static[j] - T[j], self.static[j] + T[j]
        return out

    def margins_once(self, t: float, z: Floats, modes: Sequence[int]) -> dict[tuple[int, int], float]:
        """The same for all events of a step, which SciPy asks one by one with the same array."""
        asked, modes_then, margins = self.__dict__.get("last", (None, (), {}))
        if asked is not z or modes_then != modes:
            margins = self.margins(t, z, modes)
            self.__dict__["last"] = z, modes, margins
        return margins

    def settled(self, t: float, z: Floats, modes: list[int]) -> list[int]:
        while True:
            margins = {k: m / (2 * self.static[k[0]]) for k, m in self.margins(t, z, modes).items() if k[1]}
            worst = min(margins.values(), default=0.0)
            if worst > -1e-11:
                return modes
            j, s = min(margins, key=lambda k: margins[k])
            modes = [s if i == j else one for i, one in enumerate(modes)]

    def run(self, z: Floats, t_end: float) -> tuple[list[float], list[tuple[int, ...]], Floats]:
        """Times and modes of all transitions, and the state at the end."""
        n = len(self.M)
        v = [float(self.D[j] @ z[n:] - self.V[j](0.0)[0]) for j in range(len(self.D))]
        modes = self.settled(0.0, z, [0 if abs(one) < 1e-14 else int(np.sign(one)) for one in v])
        t, times, seen = 0.0, list[float](), list[tuple[int, ...]]()
        while t < t_end:
            keys = list(self.margins(t, z, modes))
            events = []
            for key in keys:

                def event(
                    t: float, z: Floats, key: tuple[int, int] = key, m: Sequence[int] = tuple(modes)
                ) -> float:
                    return self.margins_once(t, z, m)[key]

                event.terminal, event.direction = True, -1  # type: ignore[attr-defined]
                events.append(event)
            sol = scipy.integrate.solve_ivp(
                lambda t, z, m=tuple(modes): self.field(t, z, m), (t, t_end), z, "DOP853", events=events,
                rtol=1e-12, atol=1e-13, max_step=0.25,
            )  # fmt: skip
            t, z = float(sol.t[-1]), sol.y[:, -1]
            if sol.status != 1:
                break
            j, after = keys[next(i for i, one in enumerate(sol.t_events) if len(one))]
            modes = [after if i == j else one for i, one in enumerate(modes)]
            if after == 0:
                d = np.linalg.solve(self.M, self.D[j])
                z = z.copy()
                z[n:] -= d * (self.D[j] @ z[n:] - self.V[j](t)[0]) / (self.D[j] @ d)
            modes = self.settled(t, z, modes)
            times.append(t)
            seen.append(tuple(modes))
        return times, seen, z
