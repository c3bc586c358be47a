"""Every number that steers the likelihood of a measurement and the search over it, in one place."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Policy:
    """
    What steers windows, the estimate of the population, and the search.

    Parameters
    ----------
    level_sd, curve_sd, static_sd, belt_sd : relative scatter from which an estimate starts, the centres of weak priors
    scatter_spread : width of those priors, in the logarithm
    curve_length, length_spread : correlation length of friction within a slip over the way slipped, and its prior
    law_spread : width of the prior of a number of the law about the declared one, in the logarithm
    tail : degrees of freedom of Student's t for the declared constants, which are now and then far off
    knots : places along the way slipped at which a window's own friction is a number
    fewest_stuck : samples of a stick that a window may begin in
    knee : times the median chi-squared beyond which a window counts by its logarithm
    held : steps of a fit before the population is freed from where it starts
    most_steps : of a fit
    settled : fall of the cost at which a fit stops
    tolerance : of the integration, relative; the absolute one is a hundredth
    most_transitions, most_integration_steps : of one window; beyond, its numbers are no rig's
    wobble : relative standard deviation of a belt's speed, the largest that is no finding
    wildest_belt : the largest that may be scatter; a belt that is worse is lacking in the model
    repeats : relative scatter of friction within a run below which every event is like every other
    lost_windows : share of windows that may fail before a hypothesis is no model of them
    noise_left : chi-squared per reading of the median window above which a fit is no model of the windows
    fewest_windows : below which scatter cannot be told
    most_effects : in a verdict
    stands_in : size of what names leave, over what they explain, from which they only stand in for what acts
    fullest : candidates that are fitted in full
    candidate_steps : of a candidate's fit, and of the null's from there
    stuck : share of the best gain that the null gains too from its rival's place; all is then scored again
    noticed : difference of two deviances below which it is not
    frequencies : angular, in time, that are sought: up to what a motion shows
    wavelengths : along the belt, that are sought
    coarse_turn : radians over the longest window between frequencies that are simulated
    fine_turn : radians over the longest run between frequencies that are scored
    slow : angular frequencies at which belts wobble
    grid : values tried of a number that no score reaches
    singular : where the score of a time constant, or of a force that is singular at 0, is taken
    curve_shapes : of a curve that no name explains
    draws : of the bootstrap
    false_alarm : how often a rig that lacks nothing may be told an effect
    """

    level_sd: float = 0.015
    curve_sd: float = 0.015
    static_sd: float = 0.015
    belt_sd: float = 0.004
    scatter_spread: float = 2.0
    curve_length: float = 0.4
    length_spread: float = 0.8
    law_spread: float = 0.7
    tail: float = 4.0
    knots: int = 10
    fewest_stuck: int = 5
    knee: float = 4.0
    held: int = 5
    most_steps: int = 25
    settled: float = 0.1
    tolerance: float = 1e-7
    most_transitions: int = 300
    most_integration_steps: int = 20_000
    wobble: float = 0.005
    wildest_belt: float = 0.02
    repeats: float = 4e-3
    lost_windows: float = 0.2
    noise_left: float = 2.0
    fewest_windows: int = 12
    most_effects: int = 3
    stands_in: float = 0.1
    fullest: int = 4
    candidate_steps: int = 16
    stuck: float = 0.5
    noticed: float = 20.0
    frequencies: tuple[float, float] = (0.3, 14.0)
    wavelengths: tuple[float, float] = (0.8, 15.0)
    coarse_turn: float = 1.5
    fine_turn: float = 2.5
    slow: tuple[float, float] = (0.3, 2.5)
    grid: int = 6
    singular: float = 0.02
    curve_shapes: int = 6
    draws: int = 100
    false_alarm: float = 0.02


POLICY = Policy()
