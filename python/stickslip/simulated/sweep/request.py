"""A sweep as asked for: everything its result depends on, checked, and how members are computed from it."""

from __future__ import annotations

import hashlib
import itertools
import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from stickslip import _core
from stickslip.declared.model import Model
from stickslip.simulated.lowering import Lowered, lower
from stickslip.simulated.sweep.grid import Grid
from stickslip.simulated.sweep.observables import OBSERVABLES, POINTS, Arrays, bits, from_rows

Floats = NDArray[np.float64]
BATCH, BATCHES_A_BLOCK = 1024, 8
LEAST = 64  # members that the core is given at once, at least
TYPICAL = 200.0  # a run this long takes some 40 microseconds


@dataclass(frozen=True)
class GridBlock:
    """Members start..stop: a chunk of every result. `index` gives its place in the grid."""

    start: int
    stop: int
    index: tuple[slice, ...]

    @property
    def shape(self) -> tuple[int, ...]:
        """Lengths along the grid's dimensions."""
        return tuple(one.stop - one.start for one in self.index)


@dataclass(frozen=True)
class Request:
    """All that a sweep's numbers depend on. Picklable: a worker elsewhere computes from it alone."""

    model: Model
    grid: Grid
    belt_speed: float
    initial: tuple[float, ...]
    t_end: float
    after: float
    rtol: float
    atol: float
    observe: tuple[str, ...]
    points: int
    lanes: bool
    max_transitions: int
    max_steps: int = 5_000_000

    @cached_property
    def lowered(self) -> Lowered:
        """The model as the core takes it."""
        return lower(self.model, self.belt_speed)

    def __getstate__(self) -> dict[str, object]:
        # what the core takes does not cross processes; it is made again
        return {name: value for name, value in self.__dict__.items() if name != "lowered"}

    @property
    def batch(self) -> int:
        """Members handed to the core at once.

        It does not depend on threads or workers: what shares a lane with a member touches its last bits, so that
        fixed batches, each by one thread, make every way of computing equal to the last bit.
        """
        by_length = int(BATCH * min(1.0, TYPICAL / self.t_end))
        return max(LEAST, min(by_length, math.ceil(self.grid.members / 16)))

    @property
    def block_shape(self) -> tuple[int, ...]:
        """Shape of a chunk: trailing dimensions whole, one cut, leading ones 1; so it is a run of members."""
        batches = max(1, min(BATCHES_A_BLOCK, self.grid.members // (8 * self.batch)))
        target, shape = self.batch * batches, [1] * len(self.grid.shape)
        for i in reversed(range(len(shape))):
            shape[i] = min(self.grid.shape[i], target)
            target //= self.grid.shape[i]
            if target < 1 or shape[i] < self.grid.shape[i]:
                break
        return tuple(shape)

    def blocks(self) -> Iterator[GridBlock]:
        """All chunks, in the order of their members."""
        start = 0
        cuts = [range(0, n, c) for n, c in zip(self.grid.shape, self.block_shape, strict=True)]
        for flat in range(math.prod(len(one) for one in cuts)):
            where = np.unravel_index(flat, tuple(len(one) for one in cuts))
            corners = [cut[int(i)] for cut, i in zip(cuts, where, strict=True)]
            index = tuple(
                slice(a, min(a + c, n))
                for a, c, n in zip(corners, self.block_shape, self.grid.shape, strict=True)
            )
            stop = start + math.prod(one.stop - one.start for one in index)
            yield GridBlock(start, stop, index)
            start = stop

    def batches(self, block: GridBlock) -> list[tuple[int, int]]:
        """Members of a block as (start, stop) for the core; ever fewer at the very end, where threads run dry."""
        cuts, last = [block.start], block.stop == self.grid.members
        while (left := block.stop - cuts[-1]) > 0:
            size = min(self.batch, max(LEAST, left // 2)) if last else self.batch
            cuts.append(cuts[-1] + min(size, left))
        return list(itertools.pairwise(cuts))

    def compute(self, start: int, stop: int) -> Arrays:
        """Compute members start..stop, one batch, and return their results by name, members first."""
        observe = bits(self.observe)
        rows, points = _core.sweep(
            structure=self.lowered.structure,
            base=np.concatenate([self.lowered.parameters, self.initial]),
            varied=self.grid.slots,
            values=self.grid.values(start, stop),
            t_end=self.t_end,
            after=self.after,
            rtol=self.rtol,
            atol=self.atol,
            observe=observe,
            points=self.points if observe & POINTS else 0,
            lanes=self.lanes,
            max_transitions=self.max_transitions,
            max_steps=self.max_steps,
        )
        states = self.model.rig.state_names
        span = self.t_end - self.after
        return from_rows(self.observe, np.asarray(rows), np.asarray(points), states=states, span=span)

    def compute_block(self, block: GridBlock) -> Arrays:
        """Compute a chunk."""
        return joined([self.compute(*batch) for batch in self.batches(block)])

    def extra(self, name: str) -> tuple[int, ...]:
        """Shape of a result beyond the grid's."""
        lengths = {"state": len(self.model.rig.state_names), "point": self.points}
        return tuple(lengths[dim] for dim in OBSERVABLES[name].dims)

    def bytes_a_member(self) -> int:
        """Memory of a member's results."""
        return sum(
            np.dtype(OBSERVABLES[name].dtype).itemsize * math.prod(self.extra(name)) for name in self.observe
        )

    @property
    def fixed_speeds(self) -> Mapping[str, object]:
        """Prescribed speeds that do not vary, by name."""
        return {"belt_speed": self.belt_speed}

    def more_settings(self) -> Mapping[str, object]:
        """Return what other kinds of sweeps depend on beside."""
        return {}

    def settings(self) -> Mapping[str, object]:
        """Everything the numbers depend on, as JSON takes it, for a store to be known by."""
        over = {
            column.name: f"{column.dim}, {len(column.values)} values, sha256 "
            + hashlib.sha256(column.values.tobytes()).hexdigest()[:16]
            for column in self.grid.columns
        }
        build = _core.build_config()
        plain = (
            "belt_speed",
            "t_end",
            "after",
            "rtol",
            "atol",
            "points",
            "lanes",
            "max_transitions",
            "max_steps",
        )
        return {
            "model": self.model.toml(),
            "over": over,
            "initial": list(self.initial),
            "observe": list(self.observe),
            **{name: getattr(self, name) for name in plain},
            **self.more_settings(),
            "instruction_set": str(build.get("isa", "")),
            "stickslip_version": str(build.get("version", "")),
        }


def joined(parts: list[Arrays]) -> Arrays:
    """Join batches along the members."""
    return {name: np.concatenate([part[name] for part in parts]) for name in parts[0]}
