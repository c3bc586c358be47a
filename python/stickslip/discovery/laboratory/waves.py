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
SMALL = 1e-7  # amplitude that responses are taken at; they are linear in it


@dataclass(frozen=True)
class Wave:
    """A sine and a cosine of a coarse frequency as a window's readings see them."""

    w: float
    columns: Columns


class Waves:
    """The columns of one periodic effect beside a fit."""

    def __init__(self, bench: Bench, fit: Fit, terms: Sequence[Term], kind: EffectKind) -> None:
        assert kind.wave is not None
        self.bench, self.fit, self.terms, self.kind, self.wave = bench, fit, terms, kind, kind.wave
        self.count = 2 * len(bench.data) + 1  # a sine and a cosine in each run, and how often
        self.run = np.array([s.run for s in bench.stretches])
        self.middle = np.array([bench.place(kind, s.run, s.start, s.stop) for s in bench.stretches])
        long = float(np.max([bench.length(kind, s.run, s.start, s.stop) for s in bench.stretches]))
        whole = max(bench.length(kind, r, 0, len(run.t)) for r, run in enumerate(bench.data))
        policy = bench.policy
        ends = often(kind, policy)
        if self.wave.along_belt:
            ends = 2 * math.pi / ends[1], 2 * math.pi / ends[0]
        self.apart, self.step = policy.coarse_turn / long, policy.fine_turn / whole
        self.coarse = np.arange(*ends, self.apart)
        self.waves = [Wave(float(w), self.columns(float(w))) for w in self.coarse]

    def columns(self, w: float) -> list[Floats | None]:
        """Return the derivatives by the sine's and the cosine's amplitude, each window."""
        number = 2 * math.pi / w if self.wave.along_belt else w
        made = []
        for phi in (0.0, math.pi / 2):
            small = SMALL * self.kind.parameter("a").unit
            numbers = {"a": small, self.wave.parameter: number, "phi": phi}
            one = term(self.kind, numbers, (phi,) * len(self.bench.data))
            windows = self.bench.windows((*self.terms, one))
            at = np.concatenate([self.fit.at, [n.start for n in of_term(one, self.bench.policy)]])
            made.append(windows.blocks(at, self.fit.own, shared=[len(self.fit.at)], local=False))
        return [
            None if a is None or b is None else np.concatenate([a[:, :, :1], b[:, :, :1]], axis=2)
            for a, b in zip(*made, strict=True)
        ]

    def best(self, null: Null) -> float:
        """Return the frequency that gains most, the population held."""
        shared = null.pull[:, None]
        found = [(float(g[0]), w) for w, g in self._every(null, null.rights, shared)]
        return max(found)[1]

    def gains(self, null: Null, drawn: list[Floats | None], shared: Floats) -> Floats:
        """Return the largest gain over all frequencies, for each draw."""
        best = np.zeros(shared.shape[1])
        for _, gain in self._every(null, drawn, shared):
            best = np.maximum(best, gain)
        return best

    def _every(
        self, null: Null, rights: list[Floats | None], shared: Floats
    ) -> Iterator[tuple[float, Floats]]:
        half = 0.5 * self.apart
        for wave in self.waves:
            made = null.projected(wave.columns)
            pull = null.along(made.columns, rights, shared.shape[1])
            for off in np.arange(-half, half, self.step):
                if wave.w + off > 0:
                    yield wave.w + float(off), self._turned(null, made, pull, shared, float(off))

    def _turned(self, null: Null, made: Projected, pull: Floats, shared: Floats, off: float) -> Floats:
        """Gains of a sine and a cosine in each run, turned in each window as another frequency asks."""
        c, s = np.cos(off * self.middle), np.sin(off * self.middle)
        # sin(w t + d) = cos d sin + sin d cos, cos(w t + d) = cos d cos - sin d sin
        turn = np.stack([np.stack([c, s], 1), np.stack([-s, c], 1)], 1)
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
