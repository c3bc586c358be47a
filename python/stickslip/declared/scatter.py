"""How friction and the belt differ from event to event, as a model carries it."""

from __future__ import annotations

import dataclasses
import math
from dataclasses import dataclass

from stickslip.arguments import explained
from stickslip.errors import number
from stickslip.objects import Displayed


@explained
@dataclass(frozen=True)
class EventScatter(Displayed):
    """How friction and the belt's speed differ from event to event: relative standard deviations.

    `forecast` uses it where the past is too short to show it; a simulation is of the mean event.

    Parameters
    ----------
    level
        Of friction as a whole.
    along
        Of friction along the way slipped, about its mean over an event.
    length
        Correlation length of that, over the way slipped in an event.
    static
        Of static friction, beside what it shares with kinetic friction.
    belt
        Of the belt's speed.

    Raises
    ------
    InputError
        A number is negative, or the length is 0.

    Examples
    --------
    >>> import stickslip as ss
    >>> law = ss.CoulombFriction(static=2.0, kinetic=1.2)
    >>> scatter = ss.EventScatter(level=0.02, along=0.01, length=0.4, static=0.01, belt=0.004)
    >>> ss.Model(ss.BlockOnBelt(), friction=law, scatter=scatter).scatter.level
    0.02
    """

    level: float
    along: float
    length: float
    static: float
    belt: float

    @property
    def kinetic(self) -> float:
        """Of kinetic friction at one place."""
        return math.hypot(self.level, self.along)

    def __post_init__(self) -> None:
        for one in dataclasses.fields(self):
            least = {"above": 0} if one.name == "length" else {"least": 0}
            object.__setattr__(self, one.name, number(one.name, getattr(self, one.name), **least))  # type: ignore[arg-type]
