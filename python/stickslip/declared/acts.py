"""How an effect acts on a rig of any kind: formulas, whatever place of the rig they are put to."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Literal

Place = Literal["force", "contact", "factor", "reading"]


@dataclass(frozen=True)
class Acts:
    """Formulas of an effect, one of them given; they read its numbers, its states and what is said beside them.

    What couples a place to a further coordinate reads `other` and `other_rate`; where the effect is put, `by` names it.

    Parameters
    ----------
    force
        On a coordinate or a link: deflection, deflection_rate, t, and every coordinate and velocity by its name.
    factor
        Of a contact's friction, of a number of its law, or of a prescribed speed (t alone): u, v, t, `position` (of
        what rubs, along the contact), `travel` (of what it rubs on, beside it), every coordinate and velocity; of an
        effect of the catalogue T_s, too, the law's static limit for v < 0.
    peak, aging
        Added to the kinetic magnitude and, at u = 0, to the static limit; added to the static limit alone: u; dwell.
    bristle
        The whole force of a contact that yields before it slips, of its states; R is the kinetic magnitude.
    reading
        What the sensor of a channel reads: `reading` (the true value), t, every coordinate and velocity.
    states
        By name: its rate, and what it starts as.
    of_belt
        A factor of a prescribed speed, not of a contact's friction.
    gain
        Factor of the force F of a driven slider's drive: F, position and t.
    sharp
        Names of two numbers: where the first is 0, the second is the friction of a contact of its own, which sticks.
    refused
        Why it acts on no such rig, and what would do instead.
    """

    force: str | None = None
    factor: str | None = None
    peak: str | None = None
    aging: str | None = None
    bristle: str | None = None
    reading: str | None = None
    states: Mapping[str, tuple[str, str]] = field(default_factory=dict, hash=False)
    of_belt: bool = False
    gain: str | None = None
    sharp: tuple[str, str] | None = None
    refused: str | None = None

    @property
    def couples(self) -> bool:
        """Whether it reads another coordinate than that of its place."""
        return any(text is not None and "other" in text for text in (self.force, self.factor, self.reading))

    @property
    def place(self) -> Place | None:
        """What it must be put to; None where it acts on no such rig."""
        if self.force is not None:
            return "force"
        if self.factor is not None:
            return "factor"
        if self.reading is not None:
            return "reading"
        return None if self.refused is not None else "contact"


NO_DECLARED_NUMBER = Acts(refused="change the rig's own numbers instead")
DRIVE_ALONE = "it is for a DrivenSlider"
NO_DRIVE_FORCE = Acts(refused=DRIVE_ALONE)
