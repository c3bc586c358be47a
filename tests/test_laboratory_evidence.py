"""What speaks for an effect of a search, on hypotheses whose evidence is given by hand."""

from types import SimpleNamespace

import numpy as np
import pytest

from stickslip.discovery.laboratory.gate import wandering_belt
from stickslip.discovery.laboratory.outcome import alternatives
from stickslip.discovery.laboratory.search import Searched
from stickslip.discovery.laboratory.trials import Trial
from stickslip.likelihoods.memory import MOST, correlation

EVENTS = 20


def trial(deviance: float, remembered: float = 0.0, *names: str) -> Trial:
    """A hypothesis without numbers of its own."""
    law = SimpleNamespace(friction=SimpleNamespace(numbers={}))
    windows = SimpleNamespace(numbers=(), prior=SimpleNamespace(at=lambda _: (None, None)), model=law)
    fit = SimpleNamespace(deviance=deviance, own=np.zeros((EVENTS, 3)), windows=windows, at=(), solution=())
    one = Trial(tuple(SimpleNamespace(name=name) for name in names), fit)
    one.__dict__["remembered"] = remembered
    return one


@pytest.mark.parametrize(
    ("beside", "without", "worth"),
    [
        (
            (99.0, 30.0),
            (100.0, 0.0),
            1.0,
        ),  # events are alike beside it alone: a fit by single events gains nothing
        ((80.0, 0.0), (100.0, 15.0), 5.0),  # events that are alike without it explain most of it
        ((80.0, 10.0), (100.0, 10.0), 20.0),
    ],
)
def test_memory_speaks_against_an_effect_and_never_for_it(
    beside: tuple[float, float], without: tuple[float, float], worth: float
) -> None:
    assert trial(*beside).over(trial(*without)) == pytest.approx(worth)


def test_rivals_are_held_against_the_best_fit_of_an_effect() -> None:
    """A step's fit went astray; what was chosen was fitted again and does far better than the rival."""
    null = trial(5000.0)
    astray, rival = trial(3000.0, 0.0, "droop"), trial(1200.0, 0.0, "drift")
    near = trial(1001.0, 0.0, "forcing")
    chosen = trial(1000.0, 0.0, "droop")
    step = SimpleNamespace(trials=[astray, rival, near], base=null)
    found = Searched(null, chosen, [step])
    assert [one.name for one in alternatives(found, "droop")] == ["forcing"]
    step.trials.append(best := trial(900.0, 0.0, "seam"))
    first = alternatives(found, "droop")[0]
    assert (first.name, first.delta) == ("seam", best.deviance - chosen.deviance)
    assert first.reason == "fits these runs better than the winner, but as what scatters might"


def test_a_belt_that_wanders_slowly_is_drawn_so() -> None:
    """As much of its variance as neighbouring belts are alike by, and that hardly changes from one to the next."""
    members, share, draws = np.arange(60), 0.6, 400
    windows = SimpleNamespace(by_run=[members, np.array([60])])
    fit = SimpleNamespace(own=np.zeros((61, 5)), windows=windows, population=SimpleNamespace(belt=0.005))
    made = wandering_belt(fit, np.full(draws, share), np.random.default_rng(0))
    assert made.shape == (61, draws)
    assert made.std() == pytest.approx(0.005 * np.sqrt(share), rel=0.05)
    assert np.corrcoef(made[1:60].ravel(), made[:59].ravel())[0, 1] == pytest.approx(MOST, abs=0.02)
    found, _ = correlation([made[:60, k] for k in range(draws)])
    assert found > 0.8
