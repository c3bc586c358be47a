"""The friction laws by their kind: every file of `friction/`, by the ranks that they give."""

from __future__ import annotations

from collections.abc import Mapping
from importlib import import_module
from pkgutil import iter_modules

from stickslip.declared import friction
from stickslip.declared.friction_law import FrictionLaw

_FOUND: list[type[FrictionLaw]] = [
    import_module(f"{friction.__name__}.{one.name}").LAW for one in iter_modules(friction.__path__)
]
LAWS: Mapping[str, type[FrictionLaw]] = {law.kind: law for law in sorted(_FOUND, key=lambda law: law.rank)}
