"""From a declared model to what the core computes with: a structure, a flat vector, rows of seeds.

The only place that knows the core's slot names. A public name may move several slots (a Coulomb law without
`static_plus` has one `static` for both directions), which is why a seed is a row of weights.
"""

from __future__ import annotations

import weakref
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from stickslip import _core
from stickslip.declared.bodies_model import check_closed_form
from stickslip.declared.effect import CATALOGUE, CONSTANTS, Effect, FormulaEffect, Tabulated
from stickslip.declared.friction_law import FrictionLaw
from stickslip.declared.model import Model
from stickslip.declared.rig import BlockOnBelt, Rig, on_belt
from stickslip.errors import InputError, unknown
from stickslip.simulated.named_tapes import Tapes, tapes
from stickslip.simulated.states import AT, COUNT, HIDDEN, VISIBLE

Floats = NDArray[np.float64]

SLOTS: Mapping[str, int] = {name: i for i, name in enumerate(_core.PARAMETERS)}
TABLES = ("tabulated", "second_tabulated")  # the core's names of a model's curves
WIDTH = len(_core.PARAMETERS) + _core.TABLES * _core.MAX_KNOTS
# what no motion depends on, though a lag has a state
READ_ALONE = frozenset(kind.name for kind in CATALOGUE.values() if kind.physics == "reading")
READING_EFFECTS = frozenset(name for name in READ_ALONE if not CATALOGUE[name].hidden)


class _Put(Protocol):
    """Store a value under a public name, in the slots given or in the one of that name."""

    def __call__(self, name: str, value: float, *targets: str) -> None: ...


@dataclass(frozen=True)
class Lowered:
    """A model as the core takes it; `slots` maps every public parameter name to its slots.

    `factors`, where it is not 1, is by what a slot, or each of several, moves with its name: a rig's constant that an
    effect corrects.
    `hidden` names the states that the model's effects add. `tapes` are there where a formula acts on the motion: its
    numbers have the places of effects that the model does not have. `made_of` is what `lower` made it of, and
    makes it of again in another process.
    """

    structure: _core.Structure
    parameters: Floats
    slots: Mapping[str, tuple[int, ...]]
    dimension: int
    factors: Mapping[str, float | Floats] = field(default_factory=dict)
    hidden: tuple[str, ...] = ()
    tapes: Tapes | None = None
    made_of: tuple[Model, float] = field(kw_only=True)

    def __reduce__(self) -> tuple[object, ...]:
        return lower, self.made_of  # what the core takes does not cross processes

    def windows(self, *, parameters: Floats, **asked: Any) -> Mapping[str, object]:
        """Return what `_core.simulate_windows` makes of windows; all structures are the model's."""
        return simulated_windows([self] * len(parameters), parameters=parameters, **asked)

    def run(
        self, *, parameters: Floats, initial: Floats, t: Floats, contact: int, **asked: Any
    ) -> Mapping[str, object]:
        """Return states (n, 9) and modes (n,) at times t, without derivatives."""
        if self.tapes is not None:
            return self.tapes.run(parameters, initial, t, contact, **asked)
        out: Mapping[str, object] = _core.simulate(
            structure=self.structure,
            parameters=parameters,
            initial=initial,
            t_end=float(t[-1]),
            contact=contact,
            t_eval=t,
            locator=_core.Locator.henon,
            seeds=np.zeros((0, WIDTH + COUNT)),
            **asked,
        )
        return out

    def initial(self, state: Iterable[float]) -> Floats:
        """Return the core's full initial state from the visible one, followed by any hidden ones."""
        given = list(state)
        visible, hidden = given[: self.dimension], given[self.dimension :]
        gap, rest = [0.0] * (len(VISIBLE) - len(visible)), [0.0] * (len(HIDDEN) - len(hidden))
        return np.array([*visible, *gap, *hidden, *rest], dtype=np.float64)

    def seeds(self, names: Iterable[str]) -> Floats:
        """Return one row of weights a full name (see `Model.full_name`), over all slots and states.

        Raises
        ------
        InputError
            A name is unknown; the nearest one is given.
        """
        chosen = list(names)
        rows = np.zeros((len(chosen), WIDTH + COUNT))
        for row, name in zip(rows, chosen, strict=True):
            row[list(self._columns(name))] = self.factors.get(name, 1.0)
        return rows

    def known_names(self) -> list[str]:
        """Every name a sensitivity may ask for."""
        visible = _core.STATES[: self.dimension]
        return [*self.slots, *(f"initial.{name}" for name in (*visible, *self.hidden))]

    def _columns(self, name: str) -> tuple[int, ...]:
        owner = name.partition(".")[0]
        read = owner in READING_EFFECTS and ("m" not in self.hidden or name not in self.slots)
        if read or owner.startswith("learned_"):
            raise InputError("acts on the reading, not on the motion; no state depends on it", key=name)
        if name in self.slots:
            return self.slots[name]
        if name.startswith("initial.") and name in self.known_names():
            return (WIDTH + AT[name.removeprefix("initial.")],)
        hidden = name.removeprefix("initial.")
        owners = [kind.name for kind in CATALOGUE.values() if hidden in kind.hidden]
        if owners and name != hidden:
            words = f"is a state of the effect {' and of '.join(owners)}, which the model does not have"
            raise InputError(words, key=name)
        raise unknown("parameter", name, self.known_names())


def simulated_windows(
    lowered: Sequence[Lowered], *, parameters: Floats, **asked: Any
) -> Mapping[str, object]:
    """
    Return what `_core.simulate_windows` makes of windows.

    Parameters
    ----------
    lowered : one model for each row of parameters, alike but for where their curves have knots; one and the same where
        a formula acts on the motion
    parameters, asked : as the core has them
    """
    tapes = lowered[0].tapes
    if tapes is not None:
        return tapes.windows(parameters=parameters, **asked)
    structures = [one.structure for one in lowered]
    out: Mapping[str, object] = _core.simulate_windows(structures=structures, parameters=parameters, **asked)
    return out


_LAST: dict[int, tuple[weakref.ref[Model], float, Lowered]] = {}


def lower(model: Model, belt_speed: float) -> Lowered:
    """Translate `model` on a belt of the given set-point speed.

    The last few translations of models without effects are kept: such a model cannot change, and a short
    trajectory takes no longer than its translation.
    """
    kept = _LAST.get(id(model))
    if kept is not None and kept[0]() is model and kept[1] == belt_speed:
        return kept[2]
    lowered = _translate(model, belt_speed)
    if not model.effects:
        if len(_LAST) >= 64:
            _LAST.clear()
        lowered.parameters.flags.writeable = False
        _LAST[id(model)] = (weakref.ref(model), belt_speed, lowered)
    return lowered


def _translate(model: Model, belt_speed: float) -> Lowered:
    parameters = np.zeros(WIDTH)
    slots: dict[str, tuple[int, ...]] = {}

    def put(name: str, value: float, *targets: str) -> None:
        places = tuple(SLOTS[target] for target in (targets or (name,)))
        for place in places:  # far cheaper than an index list
            parameters[place] = value
        slots[name] = places

    formulas = [one for one in model.effects if isinstance(one, FormulaEffect)]
    check_closed_form(model.rig, model.friction)
    rig_kind = _lower_rig(on_belt(model.rig), put, parameters)
    law_kind = _lower_law(model.friction, put)
    put("belt_speed", belt_speed)
    bits, tables, factors = 0, list[Tabulated](), dict[str, float | Floats]()
    for term in model.effects:
        if isinstance(term, FormulaEffect):
            continue
        if isinstance(term, Tabulated):
            if term.of_reading:  # acts on the reading, not on the motion
                continue
            bits |= _lower_table(term, len(tables), put, parameters, slots)
            tables.append(term)
            continue
        if term.name in CONSTANTS:
            _correct(term, parameters, slots, factors)
            continue
        bits |= _lower_effect(term, put)
    structure = _core.Structure(
        rig=rig_kind,
        law=law_kind,
        effects=bits,
        tables=[
            (
                _core.TABLE_PLACES.index(one.where),
                _core.TABLE_VARIABLES.index(one.variable),
                one.period or 0.0,
                list(one.knots),
            )
            for one in tables
        ],
    )
    _put_formulas(formulas, model, put)
    return Lowered(
        structure,
        parameters,
        slots,
        len(model.rig.state_names),
        factors,
        hidden_states(model),
        tapes(model, belt_speed, slots, WIDTH) if any(one.acts != "reading" for one in formulas) else None,
        made_of=(model, belt_speed),
    )


def _put_formulas(formulas: Sequence[FormulaEffect], model: Model, put: _Put) -> None:
    """Give the numbers of formulas the places of effects that the model does not have."""
    for one in formulas:
        if one.states:
            words = f"the effect '{one.name}' has states of its own, which no reading shows where a window begins; "
            raise InputError(words + "it can be simulated, and no more", key="effects")
    taken = {one.name for one in model.effects}
    free = [name for name in SLOTS if (owner := name.partition(".")[0]) in CATALOGUE and owner not in taken]
    acting = [one for one in formulas if one.acts != "reading"]
    numbers = {f"{one.label}.{name}": size for one in acting for name, size in one.parameters.items()}
    if len(numbers) > len(free):
        words = (
            f"formulas have {len(numbers)} numbers; {len(free)} are the most beside the model's other effects"
        )
        raise InputError(words, key="effects")
    for (name, size), place in zip(numbers.items(), free, strict=False):
        put(name, size, place)


def hidden_states(model: Model) -> tuple[str, ...]:
    """Names of the states that the model's effects add, in the core's order."""
    owned = {name for one in model.effects if isinstance(one, Effect) for name in one.kind.hidden}
    return tuple(name for name in HIDDEN if name in owned)


def _lower_rig(rig: Rig | BlockOnBelt, put: _Put, parameters: Floats) -> _core.RigKind:
    if isinstance(rig, BlockOnBelt):
        put("mass", rig.mass, "alpha1")
        put("damping", rig.damping, "eta1")
        put("stiffness", rig.stiffness)
        return _core.RigKind.block_on_belt
    for name in ("alpha1", "alpha2", "beta3", "eta1", "eta12"):
        put(name, getattr(rig, name))
    parameters[SLOTS["coupling"]] = 1.0 if rig.coupling == "reciprocal" else -1.0
    return _core.RigKind.two_degree


def _lower_law(law: FrictionLaw, put: _Put) -> int:
    own = law.kind + "."
    for name in law.single:
        put(name, getattr(law, name), own + name)
    for name in law.each_way:
        value, other = getattr(law, name), getattr(law, f"{name}_plus")
        if other is None:
            put(name, value, f"{own}{name}_minus", f"{own}{name}_plus")
        else:
            put(name, value, f"{own}{name}_minus")
            put(f"{name}_plus", other, f"{own}{name}_plus")
    return _core.LAWS.index(law.kind)


def _correct(
    term: Effect, parameters: Floats, slots: dict[str, tuple[int, ...]], factors: dict[str, float | Floats]
) -> None:
    """Put the true constant of the rig in the place of the declared one; a sensor's gain moves nothing."""
    name = term.kind.corrects
    if name is None or name == "reading":
        return
    if "alpha1" in slots:  # of (2.1) the mass, too: what the springs have beside it is apart
        e, place = term.parameters["e"], SLOTS[name]
        (first,) = slots["alpha1"]
        parameters[place] = e * parameters[first]
        slots |= {"alpha1": (first, place), f"{term.name}.e": (place,)}
        factors |= {"alpha1": np.array([1.0, e]), f"{term.name}.e": float(parameters[first])}
        return
    (place,) = slots[f"{term.name}.e"] = slots[name]
    factors[name], factors[f"{term.name}.e"] = 1 + term.parameters["e"], float(parameters[place])
    parameters[place] *= factors[name]


def _lower_table(
    term: Tabulated, which: int, put: _Put, parameters: Floats, slots: dict[str, tuple[int, ...]]
) -> int:
    """Give a curve its places; the bit of its effect."""
    for i, value in enumerate(term.values):
        place = len(SLOTS) + which * _core.MAX_KNOTS + i
        parameters[place] = value
        slots[f"{term.name}.value_{i}"] = (place,)
    if term.period is not None:
        _, last = slots.popitem()  # it is the first again
        slots[f"{term.name}.value_0"] += last
        for key in ("w", "phi"):
            put(f"{term.name}.{key}", term.parameters[key], f"{TABLES[which]}.{key}")
    return 1 << _core.EFFECTS.index(TABLES[which])


def _lower_effect(term: Effect, put: _Put) -> int:
    if term.name in READING_EFFECTS:  # acts on the reading, not on the motion
        for name, value in term.parameters.items():
            if f"{term.name}.{name}" in SLOTS:  # a lag that follows in the chain sees it
                put(f"{term.name}.{name}", value)
        return 0
    for name, value in term.parameters.items():
        put(f"{term.name}.{name}", value)
    return 1 << _core.EFFECTS.index(term.name)
