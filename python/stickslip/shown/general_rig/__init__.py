"""The report of a rig of bodies or matrices."""
