"""What differs from window to window on a rig of several contacts: friction of each law, and the belt's speed."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from stickslip.declared.formula.tree import Apply, Name, Number, Tree, names, substituted
from stickslip.declared.formula.value import value
from stickslip.declared.law_form import BranchForm, LawForm
from stickslip.likelihoods.policy import Policy
from stickslip.likelihoods.population import LEAST, MOST
from stickslip.simulated.general import General

Floats = NDArray[np.float64]
KINETIC, STATIC = "own_kinetic_", "own_static_"  # of a contact by its place: numbers that no law has
OWN = {"kinetic": KINETIC, "static": STATIC}
AT_REST = {"u": 0.0, "t": 0.0, "dwell": 0.0}
AT_SLOW = {"u": Number(0.0)}
FAST, NONE = 1e12, 1e-6  # a slip beyond any, in whatever unit, and the share of a force that is none


@dataclass(frozen=True)
class ContactScatter:
    """
    Relative standard deviations of what differs from window to window.

    Parameters
    ----------
    names : of what differs: "<law>.static" beside what it shares with "<law>.kinetic", and "belt"
    sizes : a standard deviation each
    of : (effects,) which of them each random effect of a window has
    """

    names: tuple[str, ...]
    sizes: tuple[float, ...]
    of: tuple[int, ...]

    @property
    def friction(self) -> tuple[float, ...]:
        """Standard deviations of friction; 0 where nothing has any."""
        sizes = (size for name, size in zip(self.names, self.sizes, strict=True) if name != "belt")
        return (*sizes, 0.0)

    def coordinates(self) -> Floats:
        """Return the logarithms, (k,)."""
        return np.log(np.maximum(self.sizes, LEAST))

    def moved(self, coordinates: Floats) -> ContactScatter:
        """Return the same effects with other standard deviations."""
        return ContactScatter(self.names, tuple(float(x) for x in np.exp(coordinates)), self.of)

    def wider(self, times: float) -> ContactScatter:
        """Return the scatter in which friction differs so many times as much."""
        of = zip(self.names, self.sizes, strict=True)
        return ContactScatter(
            self.names, tuple(size if name == "belt" else times * size for name, size in of), self.of
        )

    def without(self) -> ContactScatter:
        """Return the scatter in which nothing differs."""
        return ContactScatter(self.names, (0.0,) * len(self.sizes), self.of)

    def factor(self, places: Sequence[Floats]) -> Floats:
        """Return the factor of each run, (runs, effects, effects)."""
        one = np.diag([self.sizes[k] for k in self.of])
        return np.tile(one, (len(places), 1, 1))

    def parts(self, places: Sequence[Floats]) -> dict[int, slice | list[int]]:  # noqa: ARG002  # as every scatter's
        """Return the white columns that each coordinate scales."""
        return {k: [i for i, own in enumerate(self.of) if own == k] for k in range(len(self.names))}

    def usual(self, policy: Policy) -> tuple[Floats, Floats]:
        """Return centre and width of the prior of the coordinates, (k,) each."""
        sizes = {"static": policy.static_sd, "kinetic": policy.level_sd, "belt": policy.belt_sd}
        centre = np.log([sizes[name.rpartition(".")[2]] for name in self.names])
        return centre, np.full(len(self.names), policy.scatter_spread)

    def bounds(self, policy: Policy) -> tuple[Floats, Floats]:
        """Return the least and the largest coordinates sought, (k,) each."""
        most = [policy.wildest_belt if name == "belt" else MOST for name in self.names]
        return np.full(len(most), np.log(LEAST)), np.log(most)


def scattering(law: LawForm, place: int) -> LawForm:
    """
    Return a law that each window has its own of: 1 + own_kinetic times as large, the limit 1 + own_static times more.

    Where sliding begins at the static limit (`stribeck`, `hyperbolic`), friction of slow sliding goes with it. A limit
    below the friction that sliding begins with lets go with that: a contact would stick again at once, without end.

    Parameters
    ----------
    law : of a contact
    place : of the contact
    """
    kinetic, static = f"{KINETIC}{place}", f"{STATIC}{place}"
    level: Tree = Apply("add", (Number(1.0), Name(kinetic)))
    more: Tree = Apply("add", (Number(1.0), Name(static)))

    def times(by: Tree, tree: Tree) -> Tree:
        return Apply("multiply", (by, tree))

    def branch(one: BranchForm) -> BranchForm:
        if one.force is not None:
            return BranchForm(force=times(level, one.force), rates=one.rates)
        assert one.kinetic is not None
        slides, begins = one.kinetic, substituted(one.kinetic, AT_SLOW)
        limit = one.static or begins
        if (peak := _of_slow_sliding(law, slides, limit)) is not None:
            top = begins if names(limit) & {"dwell", "t"} else limit  # the same, and what is shorter
            slides = substituted(slides, {peak: Apply("add", (Name(peak), times(Name(static), top)))})
            holds = times(more, limit)
        else:
            holds = Apply("max", (times(more, limit), begins))
        return BranchForm(times(level, slides), times(level, holds), rates=one.rates)

    numbers = {**law.numbers, kinetic: 0.0, static: 0.0}
    return LawForm(branch(law.minus), branch(law.plus), numbers, law.states)


def _of_slow_sliding(law: LawForm, slides: Tree, limit: Tree) -> str | None:
    """The number that is added to friction of slow sliding, and to none of fast; None if the limit is another."""

    def force(u: float, name: str, more: float) -> float:
        with np.errstate(all="ignore"):
            return float(value(slides, {**law.numbers, **AT_REST, "u": u, name: law.numbers[name] + more}))

    if names(slides) & {one.name for one in law.states}:
        return None
    holds = float(value(limit, {**law.numbers, **AT_REST}))
    for name in law.numbers:
        slow, fast = (force(u, name, holds) - force(u, name, 0.0) for u in (0.0, FAST))
        if force(0.0, name, 0.0) == holds and math.isclose(slow, holds) and abs(fast) < NONE * holds:
            return name
    return None


def kinds(law: LawForm) -> tuple[str, ...]:
    """Return what of a contact's friction differs, by names of `ContactScatter`."""
    return tuple(OWN) if not law.compliant else tuple(kind for kind in OWN if kind != "static")


def differing(own: General, belted: bool) -> ContactScatter:
    """Return what differs: contacts of one law differ alike, each by itself; without stick there is no static limit."""
    names, of = list[str](), list[int]()
    for contact, law in zip(own.equations.contacts[: own.of_rig], own.laws, strict=False):
        for kind in kinds(law):
            name = f"{contact.law or 'friction'}.{kind}"
            if name not in names:
                names.append(name)
            of.append(names.index(name))
    if belted:
        of.append(len(names))
        names.append("belt")
    return ContactScatter(tuple(names), (0.0,) * len(names), tuple(of))
