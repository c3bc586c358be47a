"""Windows of the rig of (2.1) linearised, each with friction and a belt speed of its own."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from stickslip import _core
from stickslip.declared.effect import tabulated
from stickslip.declared.model import Model
from stickslip.fitted.data import Data
from stickslip.fitted.readings import Chain, read, states_read
from stickslip.fitted.window import DWELL, LAGGED, STATES, STICK
from stickslip.likelihoods.mixed import Floats
from stickslip.likelihoods.policy import POLICY, Policy
from stickslip.likelihoods.stretches import Stretch
from stickslip.simulated.lowering import SLOTS, WIDTH, lower

OWN = (0, 2, 3)  # x1, y1, y2 where a window begins; the block moves with the belt


class RigWindows:
    """
    The stretches of the runs under a model whose friction and belt differ from window to window.

    Parameters
    ----------
    model : the declared model
    data : the runs
    stretches : where the windows are
    names : positive numbers of rig and law that all windows share; their steps are of the logarithm
    policy : what steers the windows

    A window's own numbers are x1, y1, y2 at its start, then a friction curve at `policy.knots` places of x1, then
    the belt's speed relative to the set-point.
    """

    def __init__(
        self,
        model: Model,
        data: Sequence[Data],
        stretches: Sequence[Stretch],
        names: Sequence[str],
        policy: Policy = POLICY,
    ) -> None:
        self.data, self.stretches, self.names, self.policy = list(data), list(stretches), tuple(names), policy
        self.own = len(OWN) + policy.knots + 1
        x = np.concatenate([run.readings[run.weight[:, 0] > 0, 0] for run in data])
        knots = np.linspace(x.min(), x.max(), policy.knots)
        flat = tabulated("contact", "x1", knots, np.zeros(policy.knots))
        curved = Model(model.rig, friction=model.friction, effects=(*model.effects, flat))
        self.lowered = [lower(curved, run.belt_speed) for run in data]
        self.slots = self.lowered[0].slots
        term = next(k for k in self.slots if k.endswith(".value_0")).removesuffix("0")
        self.curve = [self.slots[f"{term}{i}"][0] for i in range(policy.knots)]
        known = set(self.slots)
        self.kept = np.array(states_read(known, data[0].readings.shape[1]), dtype=np.int32)

    def declared(self) -> Floats:
        """Return the shared numbers as declared, (p,), logarithms."""
        return np.log([self.lowered[0].parameters[self.slots[name][0]] for name in self.names])

    def start(self) -> Floats:
        """Return the windows' own numbers from the readings around their starts, (w, own)."""
        own = np.zeros((len(self.stretches), self.own))
        for row, w in zip(own, self.stretches, strict=True):
            row[: len(OWN)] = self.data[w.run].local_state(w.start)[list(OWN)]
        return own

    def blocks(self, shared: Floats, own: Floats) -> list[Floats | None]:
        """
        Return [J, S, K, r] of each window over the noise, (readings, channels, p + own + 1); None where it fails.

        Parameters
        ----------
        shared : (p,) logarithms of the shared numbers
        own : (w, own) the windows' own numbers
        """
        out: list[Floats | None] = [None] * len(self.stretches)
        for number in range(len(self.data)):
            chosen = [i for i, w in enumerate(self.stretches) if w.run == number]
            if chosen:
                for i, block in zip(chosen, self._run(number, chosen, shared, own[chosen]), strict=True):
                    out[i] = block
        return out

    def _run(self, number: int, chosen: list[int], shared: Floats, own: Floats) -> list[Floats | None]:
        run = self.data[number]
        places = [self.stretches[i] for i in chosen]
        offset = np.concatenate([[0], np.cumsum([w.stop - w.start for w in places])]).astype(np.int64)
        samples = np.concatenate([np.arange(w.start, w.stop) for w in places])
        belt = run.belt_speed * (1 + own[:, -1])
        raw = self._simulated(number, places, shared, own, belt, run.t[samples], offset)
        columns = len(self.names) + self.own
        slopes = dict(zip(self.kept.tolist(), np.asarray(raw["slopes"]), strict=True))
        values = {k: float(self.lowered[number].parameters[v[0]]) for k, v in self.slots.items()}
        names = ("",) * columns
        channels = run.readings.shape[1]
        chain = read(
            run.t[samples],
            np.asarray(raw["state"]),
            slopes,
            names,
            values,
            run.belt_speed,
            channels,
            (),
            offset,
        )
        self._own_belt(chain, np.repeat(belt, np.diff(offset)), run.belt_speed)
        chain.slopes[:, :, : len(self.names)] *= np.exp(shared)
        residual = run.readings[samples] - chain.values
        block = np.concatenate([chain.slopes, residual[:, :, None]], axis=2) * run.weight[samples][:, :, None]
        done = np.asarray(raw["outcome"]) == _core.Outcome.finished
        parts = [block[a:b] for a, b in zip(offset[:-1], offset[1:], strict=True)]
        return [
            part if ok and np.isfinite(part).all() else None for part, ok in zip(parts, done, strict=True)
        ]

    @staticmethod
    def _own_belt(chain: Chain, belt: Floats, set_point: float) -> None:
        """Let a recorded belt show the window's own speed."""
        if chain.values.shape[1] == 3:
            chain.values[:, 2] += belt - set_point
            chain.slopes[:, 2, -1] += set_point

    def _simulated(
        self,
        number: int,
        places: Sequence[Stretch],
        shared: Floats,
        own: Floats,
        belt: Floats,
        t: Floats,
        offset: NDArray[np.int64],
    ) -> dict[str, object]:
        """Run the core, one set of parameters a window."""
        parameters = np.tile(self.lowered[number].parameters, (len(places), 1))
        for name, value in zip(self.names, np.exp(shared), strict=True):
            parameters[:, list(self.slots[name])] = value
        parameters[:, self.curve] = own[:, len(OWN) : -1]
        parameters[:, SLOTS["belt_speed"]] = belt
        initial = np.zeros((len(places), STATES))
        initial[:, OWN], initial[:, 1] = own[:, : len(OWN)], belt
        initial[:, LAGGED], initial[:, DWELL] = own[:, 0], [w.dwell for w in places]
        seeds = self._seeds(self.data[number].belt_speed)
        return dict(
            _core.simulate_windows(
                structure=self.lowered[number].structure,
                parameters=parameters,
                set=np.arange(len(places), dtype=np.int32),
                initial=initial,
                contact=np.full(len(places), STICK, dtype=np.int32),
                t=t,
                offset=offset,
                rtol=self.policy.relative_tolerance,
                atol=self.policy.absolute_tolerance,
                seeds=seeds,
                column=np.arange(len(seeds), dtype=np.int32),
                columns=len(seeds),
                kept=self.kept,
                max_transitions=self.policy.most_transitions,
                max_steps=self.policy.most_steps,
                order=0,
                threads=1,
            )
        )

    def _seeds(self, set_point: float) -> Floats:
        p = len(self.names)
        seeds = np.zeros((p + self.own, WIDTH + STATES))
        for row, name in zip(seeds, self.names, strict=False):
            row[list(self.slots[name])] = 1.0
        for row, state in zip(seeds[p:], OWN, strict=False):
            row[WIDTH + state] = 1.0
        for row, slot in zip(seeds[p + len(OWN) :], self.curve, strict=False):
            row[slot] = 1.0
        seeds[-1, [SLOTS["belt_speed"], WIDTH + 1]] = set_point
        return seeds
