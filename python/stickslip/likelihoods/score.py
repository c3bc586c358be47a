"""The score test of a candidate: what its columns would gain, by one linear solve."""

from dataclasses import replace

from stickslip.likelihoods.mixed import Floats, Windows, solve


def gain(
    windows: Windows, candidate: int, factor: Floats, noise: Floats, mean: Floats, precision: Floats
) -> float:
    """
    Return how far the deviance falls once the last `candidate` shared columns are let in.

    Parameters
    ----------
    windows : linearised windows, the candidate's columns last among the shared ones
    candidate : number of the candidate's columns
    factor, noise : the population of the fitted null
    mean, precision : prior of the shared step, the candidate's included
    """
    first, last = windows.shared - candidate, windows.shared
    kept = [i for i in range(windows.gram.shape[-1]) if not first <= i < last]
    null = replace(windows, gram=windows.gram[:, :, kept][:, :, :, kept], shared=first)
    without = solve(null, factor, noise, mean[:first], precision[:first]).deviance
    return without - solve(windows, factor, noise, mean, precision).deviance
