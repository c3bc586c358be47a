"""A laboratory with rigs of bodies: runs by SciPy, event by event, friction drawn anew at every stick.

Written apart from the package, after `bodies_scipy`: here every contact's friction is larger or smaller from the time
it comes to rest until it does so again, readings are sampled with noise, and sensors and rigs may have faults.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import numpy as np
import scipy
from numpy.typing import NDArray

from bodies_scipy import Apart

Floats = NDArray[np.float64]


Law = Callable[[float, float], tuple[Callable[[float], float], float]]  # of a level and an excess of its own


@dataclass
class Laboratory(Apart):
    """The same rig with friction that scatters: relative standard deviations of kinetic and static friction."""

    laws: Sequence[Law] = ()
    level_sd: float = 0.0
    static_sd: float = 0.0
    rng: np.random.Generator = field(default_factory=lambda: np.random.default_rng(0))
    more: Callable[[float, Floats], Floats] | None = None  # a force on the coordinates that no law has
    sensing: bool = False  # keep accelerations and friction at the samples in `sensed`

    def __post_init__(self) -> None:
        self.kinetic, self.static = [lambda _u: 0.0] * len(self.laws), [0.0] * len(self.laws)
        for j in range(len(self.laws)):
            self.draw(j)

    def draw(self, j: int) -> None:
        """Give a contact the friction of its next event."""
        kinetic, static = list(self.kinetic), list(self.static)
        drawn = self.laws[j](self.level_sd * self.rng.normal(), self.static_sd * self.rng.normal())
        kinetic[j], static[j] = drawn
        self.kinetic, self.static = kinetic, static

    def load(self, t: float, z: Floats) -> Floats:
        """As of the plain rig, with one force more."""
        return self.force if self.more is None else self.force + self.more(t, z)

    def record(self, z: Floats, times: Floats) -> Floats:
        """States at the times, (n, d), from the state at the first of them."""
        n = len(self.M)
        v = [float(self.D[j] @ z[n:] - self.V[j](times[0])[0]) for j in range(len(self.D))]
        modes = self.settled(times[0], z, [0 if abs(one) < 1e-12 else int(np.sign(one)) for one in v])
        out, t = np.empty((len(times), len(z))), float(times[0])
        out[0] = z
        self.sensed = np.full((len(times), n + len(self.D)), np.nan)
        self.sensed[0] = self._sensed(t, z, modes)
        while t < times[-1]:
            keys = list(self.margins(t, z, modes))
            events = []
            for key in keys:

                def event(
                    t: float, z: Floats, key: tuple[int, int] = key, m: Sequence[int] = tuple(modes)
                ) -> float:
                    return self.margins_once(t, z, m)[key]

                event.terminal, event.direction = True, -1  # type: ignore[attr-defined]
                events.append(event)
            here = times[(times > t)]
            sol = scipy.integrate.solve_ivp(
                lambda t, z, m=tuple(modes): self.field(t, z, m), (t, times[-1]), z, "DOP853", events=events,
                t_eval=here, rtol=1e-8, atol=1e-9, max_step=0.25,
            )  # fmt: skip
            if len(sol.t):
                out[np.searchsorted(times, sol.t)] = sol.y.T
                if self.sensing:
                    rows = [self._sensed(*one, modes) for one in zip(sol.t.tolist(), sol.y.T, strict=True)]
                    self.sensed[np.searchsorted(times, sol.t)] = rows
            if sol.status != 1:
                break
            which = next(i for i, one in enumerate(sol.t_events) if len(one))
            t, z = float(sol.t_events[which][0]), sol.y_events[which][0].copy()
            j, after = keys[which]
            modes = [after if i == j else one for i, one in enumerate(modes)]
            if after == 0:
                d = np.linalg.solve(self.M, self.D[j])
                z[n:] -= d * (self.D[j] @ z[n:] - self.V[j](t)[0]) / (self.D[j] @ d)
                self.draw(j)
            modes = self.settled(t, z, modes)
        return out

    def _sensed(self, t: float, z: Floats, modes: list[int]) -> Floats:
        """Accelerations, and friction at the contacts."""
        return np.concatenate([self.field(t, z, modes)[len(self.M) :], self.holding(t, z, modes)])


def at_rest(_t: float) -> tuple[float, float]:
    """The ground."""
    return 0.0, 0.0


def riding(speed: float) -> Callable[[float], tuple[float, float]]:
    """A belt."""
    return lambda _t: (speed, 0.0)


def stribeck(F_c: float, F_s: float, v_s: float) -> Law:
    """F_c + (F_s - F_c) exp(-u/v_s), all of it larger by a level, F_s by an excess of its own."""

    def drawn(level: float, own: float) -> tuple[Callable[[float], float], float]:
        top = (1 + own) * F_s
        return lambda u: (1 + level) * (F_c + (top - F_c) * float(np.exp(-max(u, 0.0) / v_s))), (
            1 + level
        ) * top

    return drawn


def coulomb(static: float, kinetic: float) -> Law:
    """The same of a law of two numbers."""
    return lambda level, own: (lambda _u: (1 + level) * kinetic, (1 + level) * (1 + own) * static)
