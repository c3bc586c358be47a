"""What an identification says of a constant that was declared beside the law."""

from __future__ import annotations

import math
from dataclasses import dataclass

BEYOND = 3.0  # standard uncertainties within which a constant is as declared


@dataclass(frozen=True)
class Constant:
    """What the runs say of a declared constant, or of a sensor's gain (declared as 1), with its 95 % interval.

    `uncertainty` is the relative standard uncertainty of what was declared, None where it was not made use of.
    """

    value: float
    low: float
    high: float
    declared: float
    uncertainty: float | None

    @property
    def off(self) -> float:
        """How many standard uncertainties the value lies above what is declared; 0 where none was made use of."""
        return self._off(self.value)

    @property
    def beyond(self) -> bool:
        """Whether the whole interval lies beyond three standard uncertainties of what is declared."""
        ends = [self._off(one) for one in (self.low, self.high)]
        return min(ends) > BEYOND or max(ends) < -BEYOND

    def _off(self, value: float) -> float:
        if not self.uncertainty:
            return 0.0
        ratio = value / self.declared
        return math.log(ratio) / self.uncertainty if ratio > 0 else -math.inf
