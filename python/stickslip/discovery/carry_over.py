"""What the train runs name is claimed only where runs that were not used are forecast no worse with it."""

from __future__ import annotations

from stickslip.discovery.result import Found, Verdict


def unclaimed(found: Found) -> str | None:
    """Return why names are not claimed: the error on runs never used rises with them. None where it does not."""
    if found.verdict is not Verdict.effect_found or not found.error.rises:
        return None
    names = ", ".join(one.name for one in found.effects)
    return (
        f"{names} would be named by the train runs, but the error on runs never used RISES from "
        f"{found.error.before:.3g} to {found.error.after:.3g}: nothing is claimed"
    )
