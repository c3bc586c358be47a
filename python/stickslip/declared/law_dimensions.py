"""Does a law go with its contact? Newtons for what slides, newton metres for what turns."""

from __future__ import annotations

from stickslip.declared.dimensions import FORCE, Dimension
from stickslip.declared.formula.dimension import Dimensions, dimensions, measures, said
from stickslip.declared.formula_law import LawByFormula
from stickslip.declared.formula_laws.formula import FormulaFriction
from stickslip.declared.law_form import VARIABLES, LawForm
from stickslip.errors import InputError


def of_contact(what: Dimension, rotation: bool) -> Dimensions:
    """Return what a number of this dimension measures at a contact that slides, or turns."""
    length, stiffness = ("rad", "N m/rad") if rotation else ("m", "N/m")
    return dimensions(length) ** what.a * dimensions("1/s") ** what.b * dimensions(stiffness) ** what.c


def check_law(law: LawByFormula, rotation: bool) -> None:
    """Refuse a law whose units are not those of its contact; numbers given bare are taken to be in SI.

    Raises
    ------
    InputError
        A number or a formula measures something else.
    """
    if isinstance(law, FormulaFriction):
        if law.declared_units or any(one.unit != "1" for _, one in law.states):
            _check_formulas(law, law.form(), rotation)
        return
    for name, unit in law.declared_units.items():
        check_size(name, unit, law.dimensions[name.removesuffix("_plus")], rotation)


def check_size(name: str, unit: str | None, what: Dimension, rotation: bool) -> None:
    """Refuse a number given in a unit of something else than it measures at a contact that slides, or turns."""
    needed = of_contact(what, rotation)
    if unit is not None and dimensions(unit) != needed:
        where = "a contact that turns" if rotation else "a contact that slides"
        raise InputError(f"is {said(dimensions(unit))}; at {where} it must be {said(needed)}", key=name)


def _check_formulas(law: FormulaFriction, form: LawForm, rotation: bool) -> None:
    of = {name: of_contact(what, rotation) for name, what in VARIABLES.items()}
    of |= {name: dimensions(law.declared_units.get(name, "")) for name in law.numbers}
    of |= {name: dimensions(one.unit) for name, one in law.states}
    force = of_contact(FORCE, rotation)
    for branch in (form.minus, form.plus):
        asked = [
            ("kinetic", branch.kinetic, force),
            ("static", branch.static, force),
            ("force", branch.force, force),
        ]
        for one, rate in zip(form.states, branch.rates, strict=True):
            own = dimensions(str(one.dimension))
            asked += [(f"states.{one.name}.rate", rate, own / dimensions("s"))]
            asked += [(f"states.{one.name}.start", one.start, own)]
        for key, tree, needed in asked:
            if tree is None:
                continue
            try:
                found = measures(tree, of, form.numbers)
            except InputError as error:
                raise InputError(error.what, key=key) from None
            if found is not None and found != needed:
                raise InputError(f"is {said(found)}; it must be {said(needed)}", key=key)
