"""Discovery: identify the declared law, find what it leaves, name the cause, add it, and report the error."""

from stickslip.discovery.loop import discover
from stickslip.discovery.result import Found, Verdict

__all__ = ["Found", "Verdict", "discover"]
