"""The friction laws by their kind: every file of `friction/` and `formula_laws/`, by the ranks that they give."""

from __future__ import annotations

from collections.abc import Mapping
from importlib import import_module
from pkgutil import iter_modules
from types import ModuleType

from stickslip.declared import formula_laws, friction
from stickslip.declared.friction_law import FrictionLaw


def _found(room: ModuleType) -> Mapping[str, type[FrictionLaw]]:
    laws = [import_module(f"{room.__name__}.{one.name}").LAW for one in iter_modules(room.__path__)]
    return {law.kind: law for law in sorted(laws, key=lambda law: law.rank)}


LAWS = _found(
    friction
)  # what the core of the named rigs has in closed form, and what is identified and discovered
FORMULA_LAWS = _found(formula_laws)  # what is simulated by its formulas
ALL_LAWS: Mapping[str, type[FrictionLaw]] = {**LAWS, **FORMULA_LAWS}
