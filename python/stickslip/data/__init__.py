"""Recordings that come with the package."""

from __future__ import annotations

from importlib.resources import files
from pathlib import Path

from stickslip.errors import unknown

__all__ = ["example", "examples"]


def examples() -> tuple[str, ...]:
    """Return the names of the cases that come with the package."""
    return tuple(sorted(one.parent.name for one in _here().glob("*/rig.toml")))


def example(name: str = "paper_slider") -> Path:
    """Return the folder of a case that comes with the package, for `load_case`.

    Parameters
    ----------
    name
        "paper_slider": paper on paper pulled by a spring, 14.4 s at 2 kHz.

    Raises
    ------
    InputError
        There is no such case.
    """
    if name not in examples():
        raise unknown("example", name, examples())
    return _here() / name


def _here() -> Path:
    return Path(str(files(__name__)))
