"""Effects that come and go: one simulation each time on a coarse grid of frequencies, the fine ones by turning phases.

Within a window, cos(w t) differs from cos(w0 t) by a phase (w - w0) t that hardly changes: it is that of its middle.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from stickslip.declared.effect_kind import EffectKind
from stickslip.discovery.laboratory.hypothesis import Bench, Term, of_term, often, term
from stickslip.discovery.laboratory.null import Null, Projected
from stickslip.likelihoods.fit_state import Fit
from stickslip.likelihoods.score import Columns

Floats = NDArray[np.float64]
# amplitude that responses are taken at: they are linear in it; a smaller one drowns the cosine, which a phase gives
SMALL = 1e-4


def apart(bench: Bench, kind: EffectKind) -> float:
    """Return how far apart the coarse frequencies of a periodic effect are."""
    return bench.policy.coarse_turn / lasts(bench, kind)


def lasts(bench: Bench, kind: EffectKind) -> float:
    """Return how long the longest window is in what a periodic effect comes and goes over; 0: a way nothing goes."""
    return max(bench.length(kind, s.run, s.start, s.stop) for s in bench.stretches)


def coarse(bench: Bench, kind: EffectKind) -> Floats:
    """Return the coarse frequencies of a periodic effect."""
    assert kind.wave is not None
    low, high = often(kind, bench.policy)
    if kind.wave.along_belt:
        low, high = 2 * math.pi / high, 2 * math.pi / low
    return np.arange(low, high, apart(bench, kind))


@dataclass(frozen=True)
class WaveColumns:
    """A sine and a cosine of a coarse frequency as a window's readings see them."""

    w: float
    columns: Columns


def waves_at(
    bench: Bench, fit: Fit, terms: Sequence[Term], kind: EffectKind, frequencies: Sequence[float]
) -> list[WaveColumns]:
    """Return the derivatives by the sine's and the cosine's amplitude at some frequencies, each window."""
    assert kind.wave is not None
    small = SMALL * kind.parameter("a").unit
    windows, out = None, []
    for w in frequencies:
        number = 2 * math.pi / w if kind.wave.along_belt else w
        one = term(kind, {"a": small, kind.wave.parameter: number, "phi": 0.0}, (0.0,) * len(bench.data))
        own = of_term(one, bench.policy)
        at = np.concatenate([fit.at, [n.start for n in own]])
        # a phase turns the sine into a cosine of the same amplitude
        wanted = [len(fit.at) + i for i, n in enumerate(own) if n.name.endswith((".a", ".phi"))]
        windows = windows or bench.windows((*terms, one))  # how often is one of their numbers
        out.append(WaveColumns(float(w), [_both(x, small) for x in windows.columns(at, fit.own, wanted)]))
    return out


def _both(made: Floats | None, small: float) -> Floats | None:
    """A window's sine and cosine of amplitude 1, from its derivatives by the amplitude and by the phase of each run."""
    return None if made is None else np.stack([made[:, :, 0], made[:, :, 1:].sum(axis=2) / small], axis=2)


class Waves:
    """The columns of one periodic effect beside a fit, at every coarse frequency."""

    def __init__(self, bench: Bench, kind: EffectKind, waves: Sequence[WaveColumns]) -> None:
        self.bench, self.kind, self.waves = bench, kind, waves
        self.count = 2 * len(bench.data) + 1  # a sine and a cosine in each run, and how often
        self.run = np.array([s.run for s in bench.stretches])
        self.middle = np.array([bench.place(kind, s.run, s.start, s.stop) for s in bench.stretches])
        whole = max(bench.length(kind, r, 0, len(run.t)) for r, run in enumerate(bench.data))
        self.apart, self.step = apart(bench, kind), bench.policy.fine_turn / whole

    def best(self, null: Null) -> float:
        """Return the frequency that gains most, the population held."""
        return float(self.often(null, null.rights, null.pull[:, None])[0])

    def often(self, null: Null, drawn: list[Floats | None], shared: Floats) -> Floats:
        """Return the frequency that gains most, the population held, for each draw."""
        best, often = np.full(shared.shape[1], -np.inf), np.zeros(shared.shape[1])
        for w, gain in self._every(null, drawn, shared):
            often = np.where(gain > best, w, often)
            best = np.maximum(best, gain)
        return often

    def at(self, w: float) -> Columns:
        """Return the columns of a sine and a cosine at a frequency, turned from the nearest coarse one."""
        near = min(self.waves, key=lambda one: abs(one.w - w))
        turn = self._turn(w - near.w)
        return [None if x is None else x @ each.T for x, each in zip(near.columns, turn, strict=True)]

    def _turn(self, off: float) -> Floats:
        """What turns a sine and a cosine of each window into those of another frequency, (windows, 2, 2)."""
        c, s = np.cos(off * self.middle), np.sin(off * self.middle)
        # sin(w t + d) = cos d sin + sin d cos, cos(w t + d) = cos d cos - sin d sin
        return np.stack([np.stack([c, s], 1), np.stack([-s, c], 1)], 1)

    def _every(
        self, null: Null, rights: list[Floats | None], shared: Floats
    ) -> Iterator[tuple[float, Floats]]:
        half = 0.5 * self.apart
        for wave in self.waves:
            made = null.projected(wave.columns)
            pull = null.along(made.columns, rights, shared.shape[1])
            near = np.arange(-half, half, self.step)
            near = near[wave.w + near > 0]
            for off in near.tolist() or [
                0.0
            ]:  # where windows are next to nothing long, frequencies are far apart
                yield wave.w + off, self._turned(null, made, pull, shared, off)

    def _turned(self, null: Null, made: Projected, pull: Floats, shared: Floats, off: float) -> Floats:
        """Gains of a sine and a cosine in each run, turned in each window as another frequency asks."""
        turn = self._turn(off)
        cross, moved = turn @ made.cross, turn @ pull
        square = turn @ made.square @ turn.transpose(0, 2, 1)
        runs = len(self.bench.data)
        crosses, pulls = np.zeros((runs, 2, cross.shape[2])), np.zeros((runs, 2, pull.shape[2]))
        squares = np.zeros((2 * runs, 2 * runs))
        np.add.at(crosses, self.run, cross)
        np.add.at(pulls, self.run, moved)
        for r in range(runs):
            squares[2 * r : 2 * r + 2, 2 * r : 2 * r + 2] = square[self.run == r].sum(axis=0)
        asked = crosses.reshape(2 * runs, -1), squares, pulls.reshape(2 * runs, -1), shared
        gains = null.gains(*asked)
        if self.bench.wobbles(self.kind):  # a wave as small as belts wobble is no finding
            gains = gains - null.gains(*asked, precision=self.bench.wobble(null.fit.population) ** -2)
        return gains
