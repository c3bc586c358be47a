"""Which names are left to claim where runs never used speak against all of them."""

from __future__ import annotations

from dataclasses import dataclass, replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

import stickslip as ss
from stickslip.discovery.carry_over import claimed, deciding, of_falls
from stickslip.discovery.laboratory.fewer import beside_others, fewer
from stickslip.discovery.laboratory.gate import SearchGate
from stickslip.discovery.laboratory.hypothesis import Term
from stickslip.discovery.laboratory.search import Searched, SearchStep
from stickslip.discovery.laboratory.trials import Trial
from stickslip.discovery.result import ErrorBlock, FoundEffect, Likelihood, Verdict

DAMPED, CUBIC, FORCED = (
    Term(ss.effect("block_viscous_damping", c=1.0)),
    Term(ss.effect("spring_cubic_k1", k=1.0)),
    Term(ss.effect("harmonic_forcing", a=1.0, w=1.0, phi=0.0), (0.0,)),
)


@dataclass(frozen=True)
class Worth(Trial):
    """A hypothesis of a deviance that is given, its numbers without a price."""

    def worth(self) -> float:
        return float(self.fit.deviance)

    def over(self, other: Trial) -> float:
        return float(other.fit.deviance - self.fit.deviance)


def trial(deviance: float, *terms: Term) -> Trial:
    fit: Any = SimpleNamespace(deviance=deviance)
    return Worth(terms, fit)


def gate(threshold: float) -> SearchGate:
    return SearchGate(np.zeros(1), threshold)


def searched(chosen: Trial, *tried: Trial, waves: dict[str, SearchGate] | None = None) -> Searched:
    null = trial(1000.0)
    step = SearchStep(null, None, list(tried), gate(10.0), waves=waves or {})  # type: ignore[arg-type]
    return Searched(null, chosen, [step])


def names(found: Searched) -> list[str]:
    return sorted(found.chosen.names)


def test_the_best_of_the_most_comes_first() -> None:
    all_three = trial(100.0, DAMPED, CUBIC, FORCED)
    tried = (
        trial(900.0, DAMPED), trial(500.0, CUBIC), trial(980.0, FORCED),
        trial(300.0, DAMPED, CUBIC), trial(200.0, CUBIC, FORCED),
    )  # fmt: skip
    every = list(fewer(searched(all_three, *tried)))
    assert [names(one) for one in every] == [
        ["harmonic_forcing", "spring_cubic_k1"],
        ["block_viscous_damping", "spring_cubic_k1"],
        ["spring_cubic_k1"],
        ["block_viscous_damping"],
        ["harmonic_forcing"],
    ]
    assert {name: one.fit.deviance for name, one in every[0].without.items()} == {
        "harmonic_forcing": 500.0,
        "spring_cubic_k1": 980.0,
    }


def test_a_name_that_does_not_pass_its_gate_beside_the_others_is_not_left() -> None:
    both = trial(100.0, DAMPED, FORCED)
    tried = trial(991.0, DAMPED), trial(960.0, FORCED)
    assert [names(one) for one in fewer(searched(both, *tried))] == [["harmonic_forcing"]]
    strict = {"harmonic_forcing": gate(50.0)}
    assert list(fewer(searched(both, *tried, waves=strict))) == []


def test_of_one_name_alone_nothing_is_left() -> None:
    one = trial(500.0, CUBIC)
    assert list(fewer(searched(one, one))) == []
    assert beside_others(searched(one, one)) == {}


def test_every_effect_is_held_against_the_others_without_it() -> None:
    both, damped, forced = trial(100.0, DAMPED, FORCED), trial(105.0, DAMPED), trial(900.0, FORCED)
    found = replace(
        searched(both, damped, forced), without={"block_viscous_damping": forced, "harmonic_forcing": damped}
    )
    assert {k: (one.fit.deviance, spare) for k, (one, spare) in beside_others(found).items()} == {
        "block_viscous_damping": (900.0, 790.0),
        "harmonic_forcing": (105.0, 0.0),
    }


def test_few_events_say_nothing_and_many_say_it_by_their_ranks() -> None:
    assert of_falls([-1.0] * 4) is None
    against = of_falls([-1.0, -2.0, -3.0, -4.0, -5.0, -6.0], 3.0, "sensor_lag")
    assert against == Likelihood(-21.0, 6, pytest.approx(1 / 64), 3.0, "sensor_lag")
    assert not against.carries
    one_astray = of_falls([5.0, 6.0, 7.0, 8.0, 9.0, -300.0], 300.0)
    assert one_astray is not None
    assert one_astray.carries


def test_one_effect_that_does_not_carry_over_decides() -> None:
    whole, good, bad, few = [90.0] * 9, [5.0] * 9, [-2.0] * 9, [-9.0] * 4
    one = deciding(whole, 1.0, {"lag": (good, 3.0), "drift": (bad, 2.0)})
    assert one is not None
    assert (one.name, one.gain, one.spare) == ("drift", -18.0, 2.0)
    every = deciding(whole, 1.0, {"lag": (good, 3.0), "drift": (few, 2.0)})
    assert every is not None
    assert (every.name, every.gain, every.spare) == ("", 810.0, 1.0)
    assert deciding([], None, {}) is None


@dataclass(frozen=True)
class Said:
    """What of a result decides."""

    effects: tuple[FoundEffect, ...]
    error: ErrorBlock
    messages: tuple[str, ...] = ()
    unclaimed: tuple[FoundEffect, ...] = ()

    @property
    def verdict(self) -> Verdict:
        return Verdict.effect_found if self.effects else Verdict.no_effect


def said(*kinds: str, likelihood: Likelihood | None = None) -> Any:
    effects: Any = tuple(SimpleNamespace(name=one, where="block", curve=None) for one in kinds)
    return Said(effects, ErrorBlock("metric", 0.2, 0.1, 0.05, (), likelihood=likelihood))


def test_what_is_claimed_is_the_first_that_carries_over() -> None:
    bad, good = Likelihood(-9.0, 9, 0.01, 1.0, "friction_drift"), Likelihood(90.0, 9, 1.0, 1.0)
    whole, made = said("sensor_lag", "friction_drift", likelihood=bad), []

    def parts() -> Any:
        for one in (
            said("friction_drift", likelihood=bad),
            said("sensor_lag", likelihood=good),
            said("spring"),
        ):
            made.append(one)
            yield one

    found = claimed(whole, parts(), lambda: said())
    assert [one.name for one in found.effects] == ["sensor_lag"]
    assert found.messages == (
        "friction_drift would be named beside sensor_lag by the train runs, but runs never used are less likely with "
        "friction_drift, by 9 in -2 log likelihood over 9 events (p = 0.01): not claimed",
    )
    assert len(made) == 2
    silent = claimed(whole, (), lambda: said())
    assert silent.effects == ()
    assert [one.name for one in silent.unclaimed] == ["sensor_lag", "friction_drift"]
    assert claimed(said("sensor_lag", likelihood=good), parts(), lambda: said()).messages == ()
