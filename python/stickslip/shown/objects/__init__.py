"""How every object of the package is described: `describe` gives its title, its table and its portrait."""

from stickslip.shown.objects import declared, measured, orbits, results, runs
from stickslip.shown.objects.description import Description, describe

__all__ = ["Description", "declared", "describe", "measured", "orbits", "results", "runs"]
