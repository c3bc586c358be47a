"""How every object of the package is described: `describe` gives its title, its table and its portrait."""

from stickslip.shown.objects import bodies, declared, measured, orbits, results, runs
from stickslip.shown.objects.description import Description, describe

__all__ = ["Description", "bodies", "declared", "describe", "measured", "orbits", "results", "runs"]
