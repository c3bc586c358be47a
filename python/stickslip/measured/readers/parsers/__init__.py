"""Parsers of binary files, run in a process of their own: a damaged file cannot end the program."""
