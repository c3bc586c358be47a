"""Every number that steers the likelihood of a measurement, in one place."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Policy:
    """
    What steers the estimate of the population.

    Parameters
    ----------
    start_sd : standard deviation of a random effect from which its estimate starts
    most_steps : steps of the optimiser of the variances; effort is counted in work
    gradient_tolerance : slope of the log likelihood at which the optimiser stops
    """

    start_sd: float = 0.02
    most_steps: int = 200
    gradient_tolerance: float = 1e-4


POLICY = Policy()
