"""A model of any rig as it is simulated: equations, laws as trees, prescribed speeds, names of states."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from stickslip.declared.bodies_model import law_of
from stickslip.declared.effect import Tabulated
from stickslip.declared.formula.tree import Name
from stickslip.declared.formula.value import value
from stickslip.declared.law_form import BranchForm, LawForm
from stickslip.declared.model import Model
from stickslip.declared.places import Places, prescribed, seen
from stickslip.declared.rigs.general import Equations
from stickslip.declared.rigs.named import equations_of
from stickslip.declared.rubbing import rubbing, with_contacts
from stickslip.declared.speeds import Speed
from stickslip.errors import InputError
from stickslip.simulated.placed_effects import NO_EFFECTS, Effects, effects_of

Floats = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class General:
    """What is simulated of a model of any rig.

    Attributes
    ----------
    equations
        M q'' + C q' + K q = force - directions' T + drive.
    laws
        One a contact.
    belt, drive
        Prescribed speeds.
    order
        Place of each of the rig's own states among (q, v).
    state_names, hidden
        The rig's states, and those of the laws: by their own names where there is one contact, else
        "<contact>.<state>". After them those of effects, "<effect>.<state>".
    effects
        What the model's effects add beside changes of the laws.
    drive_name
        What the drive's speed is called in sweeps and sensitivities; of a driven slider it is a force.
    """

    equations: Equations
    laws: tuple[LawForm, ...]
    belt: Speed
    drive: Speed
    order: tuple[int, ...]
    state_names: tuple[str, ...]
    effects: Effects = field(default_factory=lambda: NO_EFFECTS)
    drive_name: str = "drive_speed"

    @property
    def of_rig(self) -> int:
        """How many contacts the rig has; those that effects add come after."""
        return len(self.laws) - sum(one.rubs is not None for one in self.effects.all)

    def modes(self, given: Sequence[int]) -> list[int]:
        """Return modes as the core has them; those of laws without stick and of effects follow from the state."""
        known = [2 if law.compliant else mode for mode, law in zip(given, self.laws, strict=False)]
        return [*known, *[2] * (len(self.laws) - len(given))]

    @property
    def hidden(self) -> tuple[str, ...]:
        """Names of the laws' states."""
        alone = len(self.laws) == 1
        of_laws = (
            one.name if alone or "." in one.name else f"{contact.name}.{one.name}"
            for contact, law in zip(self.equations.contacts, self.laws, strict=True)
            for one in law.states
        )
        return (*of_laws, *(one.name for push in self.effects.pushes for one in push.states))

    def called(self, key: str) -> str:
        """What "belt_speed" and "drive_speed" are called outside."""
        return self.drive_name if key == "drive_speed" else key

    def seen(self, z: Floats, t: float) -> dict[str, float]:
        """Return what formulas may read of the rig at the start (q, v): its coordinates, speeds and time."""
        now = {prescribed("drive_speed").name: float(self.drive(t))} if self.effects.pushes else {}
        return {**seen(z, len(self.equations.names), t, 0.0, 0.0), **now}

    def start(self, initial: Floats, given: Mapping[str, float], t: float) -> Floats:
        """Return (q, v, states of the laws) at the start; states that are not given as the laws start.

        Raises
        ------
        InputError
            A law's state has no steady value at the starting speed, and none is given.
        """
        n = len(self.equations.names)
        z = np.zeros(2 * n)
        z[list(self.order)] = initial
        hidden, names = list[float](), iter(self.hidden)
        rig = self.seen(z, t)
        for contact, law in zip(self.equations.contacts, self.laws, strict=True):
            belt = float(self.belt(t)) if contact.against == "belt" else 0.0
            v = float(contact.direction @ z[n:]) - belt
            for one in law.states:
                name = next(names)
                size = given.get(name)
                if size is None:
                    with np.errstate(divide="ignore"):
                        size = float(value(one.start, {**rig, **law.numbers, "u": abs(v), "v": v}))
                if not np.isfinite(size):
                    words = (
                        f"the law's state {name} is not finite in steady motion at v = {v:g}; give its start"
                    )
                    raise InputError(words, key="hidden")
                hidden.append(size)
        for push in self.effects.pushes:
            for own in push.states:
                usual = float(value(own.start, {**rig, **self.effects.numbers}))
                hidden.append(given.get(own.name, usual))
        return np.array([*z, *hidden])


def with_rubbing(
    own: Equations, laws: tuple[LawForm, ...], effects: Effects
) -> tuple[Equations, tuple[LawForm, ...]]:
    """Return equations and laws with the contacts that effects add; errors are those of `with_contacts`."""
    for one in effects.all:
        if one.rubs is not None:
            (number,) = one.numbers
            dry = BranchForm(Name(number), Name(number))
            laws = (*laws, LawForm(dry, dry, one.numbers))
    return with_contacts(own, rubbing(effects.all)), laws


def general(
    model: Model,
    belt_speed: object,
    drive_speed: object = None,
    *,
    differing: Callable[[LawForm, int], LawForm] = lambda law, _: law,
) -> General:
    """Return what is simulated of a model; a named rig becomes one of matrices.

    `differing` makes of the declared law of a contact what effects are put to.

    Raises
    ------
    InputError
        A speed is missing, or given where nothing moves at it; an effect acts on no such rig.
    """
    rig = model.rig
    own, order = equations_of(rig)
    if any(isinstance(one, Tabulated) for one in model.effects):
        raise InputError(
            "a curve acts where all speeds are numbers and no law or effect is a formula", key="effects"
        )
    effects = effects_of(model.effects, Places(rig, own, order))
    plain = [law_of(model.friction, one).form() for one in own.contacts]
    laws = tuple(effects.changed(j, differing(law, j), law) for j, law in enumerate(plain))
    own, laws = with_rubbing(own, laws, effects)
    speeds = []
    for key, given, needed in (
        ("belt_speed", belt_speed, own.on_belt),
        ("drive_speed", drive_speed, own.driven),
    ):
        if given is None and needed:
            what = "a contact rubs on the belt" if key == "belt_speed" else "a link is pulled by the drive"
            raise InputError(f"missing: {what}; give its speed", key=key)
        if given is not None and not needed:
            what = "no contact rubs on a belt" if key == "belt_speed" else "nothing is pulled by a drive"
            raise InputError(f"{what} in this rig; leave it out", key=key)
        speeds.append(Speed.of(0.0 if given is None else given, key))
    effects = replace(effects, prescribed=(speeds[0], speeds[1]))
    belt, drive = (effects.moved(key, one) for key, one in zip(effects.keys, speeds, strict=True))
    return General(own, laws, belt, drive, order, rig.state_names, effects)
