"""Friction laws that are formulas: a file each."""
