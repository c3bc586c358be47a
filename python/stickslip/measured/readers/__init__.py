"""Readers of files: columns of numbers, with the line and the column of what cannot be read."""
