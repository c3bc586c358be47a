"""Stick-slip friction rigs: simulate them, identify them from recordings, find what the model lacks."""

from importlib.metadata import version

from stickslip._core import build_config

__version__ = version("stickslip")

__all__ = ["__version__", "build_config"]
