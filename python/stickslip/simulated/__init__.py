"""What a model does: its trajectories, orbits and sweeps, and the plain reference for all of them."""
