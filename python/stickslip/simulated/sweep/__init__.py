"""Sweeps: many trajectories of one model over a grid of its numbers."""
