"""Where states of laws begin in a window of a rig of bodies: bristles, ages of contacts.

No reading shows them. Each is one of the window's own numbers, as the velocities are; a fit starts from what carries
the load that the readings tell where a contact sticks to the eye, and from steady sliding where it slips.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from stickslip.declared.formula.derivative import derivative
from stickslip.declared.formula.tree import Tree, substituted
from stickslip.declared.formula.value import value
from stickslip.declared.law_form import LawForm
from stickslip.errors import InputError
from stickslip.fitted.bodies_data import BodiesData
from stickslip.likelihoods.bodies_cuts import Cut
from stickslip.likelihoods.bodies_release import carried
from stickslip.simulated.general import General

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class LawStates:
    """
    The states of the laws of a rig, in their order.

    Parameters
    ----------
    own : the rig as it is simulated
    laws : of its contacts, as declared: what effects make of them is small beside a guess
    """

    own: General
    laws: Sequence[LawForm]

    @property
    def count(self) -> int:
        """How many there are."""
        return sum(len(law.states) for law in self.laws)

    def sizes(self, runs: Sequence[BodiesData]) -> Floats:
        """How large each is in the fastest sliding that the runs show, (count,)."""
        out = list[float]()
        for contact, law in zip(self.own.equations.contacts, self.laws, strict=False):
            if law.states:
                v = np.concatenate([contact.slip(run.v, run.belt(run.t)) for run in runs])
                out += [abs(x) for x in _steady(law, float(v[np.argmax(np.abs(v))]))]
        return np.array([x if np.isfinite(x) and x > 0 else 1.0 for x in out])

    def every(self, runs: Sequence[BodiesData], windows: Sequence[Cut]) -> tuple[Floats, Floats]:
        """Return about what each is at the start of windows, (w, count), and how large each is, (count,)."""
        return np.array([self.at(runs[one.run], one) for one in windows]), self.sizes(runs)

    def at(self, run: BodiesData, window: Cut) -> Floats:
        """Return about what each is at the start of a window, (count,)."""
        rig, s, out = self.own.equations, window.start, list[float]()
        for contact, law, mode in zip(rig.contacts, self.laws, window.modes, strict=False):
            states = _steady(law, float(contact.slip(run.v[s], run.belt(run.t[s]))))
            if mode == 0 and _bristles(law):
                states = [
                    _Bristle(law).carrying(carried(rig, run, s, contact.direction, run.q[s]), states[0])
                ]
            out += states
        return np.asarray(np.nan_to_num(np.array(out)))


def refuse_hidden(laws: Sequence[LawForm]) -> None:
    """
    Refuse laws of whose states the readings say nothing where a contact sticks to the eye.

    Raises
    ------
    InputError
        A law has states, and is no bristle: no force at rest that follows from its one state.
    """
    for law in laws:
        if law.states and not (_bristles(law) and _Bristle(law).carries()):
            words = "a law with states of its own can be simulated, and no more as yet, unless it has one that carries"
            raise InputError(
                f"{words} the load at rest, as a bristle does: no reading shows them", key="friction"
            )


def _bristles(law: LawForm) -> bool:
    return law.compliant and len(law.states) == 1


def _steady(law: LawForm, v: float) -> list[float]:
    of = {**law.numbers, "u": abs(v), "v": v}
    with np.errstate(all="ignore"):
        return [float(value(one.start, of)) for one in law.states]


class _Bristle:
    """The one state of a law that carries a load at rest."""

    def __init__(self, law: LawForm) -> None:
        self.law, self.name = law, law.states[0].name
        assert law.minus.force is not None
        self.held = substituted(law.minus.force, {f"{self.name}_rate": law.minus.rates[0]})
        self.slope = derivative(self.held, self.name)

    def _at(self, tree: Tree, z: float) -> float:
        of = {**self.law.numbers, "t": 0.0, "dwell": 0.0, self.name: z, "u": 0.0, "v": 0.0}
        with np.errstate(all="ignore"):
            return float(value(tree, of))

    def carries(self) -> bool:
        """Return whether its force at rest follows from it."""
        usual = _steady(self.law, 1.0)[0]
        slope = self._at(self.slope, usual)
        return bool(np.isfinite(slope) and slope != 0)

    def carrying(self, load: float, usual: float) -> float:
        """Return the state whose force at rest is a load, of one that it is straight in; else about that."""
        z = usual if np.isfinite(usual) else 0.0
        return z - (self._at(self.held, z) - load) / self._at(self.slope, z)
