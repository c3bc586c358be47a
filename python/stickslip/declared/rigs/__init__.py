"""Rigs of any number of coordinates and contacts: by their bodies, or by their matrices."""
