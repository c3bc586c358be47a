"""Every number that steers the likelihood of a measurement, in one place."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Policy:
    """
    What steers windows and the estimate of the population.

    Parameters
    ----------
    start_sd : standard deviation of a random effect from which its estimate starts
    most_turns : steps of the optimiser of the variances; effort is counted in work
    gradient_tolerance : slope of the log likelihood at which the optimiser stops
    knots : places along the way slipped at which a window's own friction is a number
    stick_band : share of the belt's speed within which the block sticks
    fewest_stuck : samples of a stick that a window may begin in
    relative_tolerance, absolute_tolerance : of the integration
    most_transitions, most_steps : of one window; beyond, its numbers are no rig's
    """

    start_sd: float = 0.02
    most_turns: int = 200
    gradient_tolerance: float = 1e-4
    knots: int = 10
    stick_band: float = 0.25
    fewest_stuck: int = 5
    relative_tolerance: float = 1e-7
    absolute_tolerance: float = 1e-9
    most_transitions: int = 300
    most_steps: int = 20_000


POLICY = Policy()
