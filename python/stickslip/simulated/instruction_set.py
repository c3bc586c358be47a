"""The instruction set that STICKSLIP_ISA asks for: one that cannot be had is an error, not silently another."""

from __future__ import annotations

import os
from collections.abc import Mapping

from stickslip import _core
from stickslip.errors import InputError

NAMES = ("baseline", "avx2", "avx512")  # narrower first
VARIABLE = "STICKSLIP_ISA"


def check_instruction_set(config: Mapping[str, object] | None = None) -> None:
    """Refuse what the environment asks for unless the core uses it; `config` as from `build_config`.

    Raises
    ------
    InputError
        The name is unknown, or the build or this machine lacks the instruction set.
    """
    asked = os.environ.get(VARIABLE)
    if not asked:
        return
    config = config or _core.build_config()
    compiled = config["isa_compiled"]
    if asked not in NAMES:
        raise InputError(f"unknown; it must be one of {', '.join(NAMES)}", key=VARIABLE, value=asked)
    if isinstance(compiled, list) and asked not in compiled:
        raise InputError(f"this build lacks it; it has {', '.join(compiled)}", key=VARIABLE, value=asked)
    if asked != config["isa"]:
        words = f"this machine lacks it; the widest that it has is {config['isa']}"
        raise InputError(words, key=VARIABLE, value=asked)
