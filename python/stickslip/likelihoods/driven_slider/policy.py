"""Every number that steers the search of a driven slider and is not in the general policy, in one place.

Draws of the gate, how often a rig that lacks nothing may be told an effect, how many candidates are fitted in full and
in how many steps are those of `stickslip.likelihoods.policy`; what ties two rivals is that of every search.
"""

from dataclasses import dataclass


@dataclass(frozen=True)
class DrivenPolicy:
    """
    What steers noise, candidates and what is shown. What halving or doubling each would move is not measured yet.

    Parameters
    ----------
    order : highest order of the autoregression of the innovations; so many rows are lost at a run's start
    least_force, least_reading : noise that a record cannot be better than, of the drive's size and of the way
    rounds : of a fit and its noise in turn
    doubt : standard deviations of the velocity below which the slider may be at rest
    highest : of the sampling rate, the frequency up to which forces are sought
    fewest_waves : periods within the reach below which a wave is none
    apart : periods over the record between neighbouring waves that are scored
    most_waves : of one kind that are scored; what keeps the time linear in the samples
    values : of a speed, a bristle's length, a lag or a delay that are scored
    slowest : of the fastest speed, the least at which a curve of friction may bend
    bristle : of the reach, the lengths of a bristle that are sought
    late : samples by which a drive may lag or be late at most
    most : effects in a verdict; a real drive has many, each of a percent
    faithful : share of what a curve gains that a name must gain to be preferred to it
    far : standard uncertainties by which a declared constant must be off to be an effect; docs/case.md promises 3
    knots : of a learned curve
    middle : of the fastest speed, below which a curve in velocity is not learned
    same_wave : relative difference below which two waves are one
    answers : latest readings to which a drive may answer
    chance : of an open loop to be said to be closed
    coherent : coherence of drive and acceleration at which the band that is shown ends
    edge : width of that band's edge over its limit
    cycles : periods of the band's limit in a record, at least
    ahead : seconds of a forecast whose error is shown
    interval_draws : of the normal distribution behind the intervals
    at_once, together, remembered : columns computed, solved for and kept at hand; memory and speed alone
    """

    order: int = 20
    least_force: float = 1e-5
    least_reading: float = 1e-9
    rounds: int = 3
    doubt: float = 4.0
    highest: float = 0.1
    fewest_waves: float = 3.0
    apart: float = 0.7
    most_waves: int = 1000
    values: int = 16
    slowest: float = 0.003
    bristle: tuple[float, float] = (3e-5, 0.03)
    late: float = 6.0
    most: int = 10
    faithful: float = 0.5
    far: float = 3.0
    knots: int = 9
    middle: float = 0.04
    same_wave: float = 0.05
    answers: int = 3
    chance: float = 1e-6
    coherent: float = 0.5
    edge: float = 0.3
    cycles: float = 40.0
    ahead: float = 0.25
    interval_draws: int = 500
    at_once: int = 768
    together: int = 48
    remembered: int = 200


STEER = DrivenPolicy()
