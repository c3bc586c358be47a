"""Sentences on effects that take more than the declared friction has."""

from __future__ import annotations

from stickslip.declared.friction_law import FrictionLaw

DRIVES = "friction is negative then and drives the block"


def takes_too_much(name: str, height: float, law: FrictionLaw) -> str:
    """Say that a peak or a growth of negative height leaves less than no friction."""
    limits = law.static_limits
    words = f"takes more than the declared friction has (static limits {limits[0]:.4g} and {limits[1]:.4g})"
    return f"{name}.dT = {height:g}: {words}; {DRIVES}"
