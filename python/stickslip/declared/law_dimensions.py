"""Does a law go with its contact? Newtons for what slides, newton metres for what turns."""

from __future__ import annotations

from stickslip.declared.dimensions import FORCE
from stickslip.declared.formula.dimension import dimensions, measures, said
from stickslip.declared.formula_laws.formula import FormulaFriction
from stickslip.declared.friction_law import FrictionLaw
from stickslip.declared.law_form import VARIABLES, LawForm
from stickslip.declared.law_numbers import check_size, measure_of, of_contact
from stickslip.declared.rig import AnyRig, Rig
from stickslip.declared.rigs.general import GeneralRig
from stickslip.errors import InputError


def check_law(law: FrictionLaw, rotation: bool) -> None:
    """Refuse a law whose units are not those of its contact; numbers given bare are taken to be in SI.

    Raises
    ------
    InputError
        A number or a formula measures something else, or bare ones do not go with those that have a unit.
    """
    _check_units(law, rotation)
    if law.declared_units and not isinstance(law, FormulaFriction):
        law.with_numbers({name: float(size) for name, size in law.numbers.items()})


def _check_units(law: FrictionLaw, rotation: bool) -> None:
    if isinstance(law, FormulaFriction):
        if law.declared_units or any(one.unit != "1" for _, one in law.states):
            _check_formulas(law, law.form(), rotation)
        return
    for name, unit in law.declared_units.items():
        check_size(name, unit, measure_of(law.dimensions, name), rotation)


def in_model(law: FrictionLaw, rig: AnyRig) -> FrictionLaw:
    """Return a law in the numbers of a rig's model: those given with a unit are turned where the model has scales.

    Raises
    ------
    InputError
        A number has a unit of something else. Or it has one, but the rig of (2.1) has no scales, or the law is a
        formula or a curve.
    """
    if isinstance(rig, GeneralRig) or not law.declared_units:  # the model of such a rig asks each contact
        return law
    given = law.declared_units
    if not isinstance(rig, Rig):
        check_law(law, rotation=False)
        return law
    _check_units(law, rotation=False)
    name = next(iter(given))
    if rig.scales is None:
        words = "has a unit, but the rig is nondimensional: give it bare, or declare the rig in SI"
        raise InputError(words, key=name)
    if not set(given) <= set(law.numbers) or isinstance(law, FormulaFriction):
        words = f"the numbers of the law '{law.kind}' on the rig of (2.1) are nondimensional; give it bare"
        raise InputError(words, key=name)
    sizes = {one: measure_of(law.dimensions, one).size(rig.scales) for one in given}
    return law.with_numbers({one: law.numbers[one] / size for one, size in sizes.items()})


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
