"""Formulas that a person writes: parsed into a small tree, checked, evaluated; never run as Python."""
