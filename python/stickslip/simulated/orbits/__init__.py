"""Orbits: limit cycles, their branches, steady sliding, Lyapunov exponents."""
