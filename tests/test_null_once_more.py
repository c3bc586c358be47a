"""The null of a search is fitted once more where the first fit may not be the best."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import stickslip as ss
from scattering import case
from stickslip.discovery.laboratory.two_degree import bench_of
from stickslip.fitted.data import prepare
from stickslip.likelihoods import fit as fitting
from stickslip.likelihoods.event_windows import EventWindows
from stickslip.likelihoods.fit_state import Fit
from stickslip.likelihoods.policy import POLICY

Floats = NDArray[np.float64]


@pytest.fixture(scope="module")
def found(tmp_path_factory: pytest.TempPathFactory) -> Fit:
    """Return the fit of a rig that lacks nothing, friction of its events 3 % apart."""
    folder: Path = tmp_path_factory.mktemp("scatter")
    read = ss.load_case(case(folder, (), 0.03, 0.0, seed=4, few=True))
    return fitting.fitted(fitting.begun(bench_of(read, prepare(read.train)).windows()), POLICY)


def test_a_fit_that_settled_is_not_repeated(found: Fit, monkeypatch: pytest.MonkeyPatch) -> None:
    """Repeated it ends where it was: that took a third of a null's time."""
    assert not fitting.doubtful(found, POLICY)
    again = fitting.fitted(replace(found, population=found.windows.scatter()), POLICY)
    assert again.deviance == pytest.approx(found.deviance, abs=1.0)
    begun: list[EventWindows] = []

    def counted(fit: Fit, *_: object, **__: object) -> Fit:
        begun.append(fit.windows)
        return found

    monkeypatch.setattr(fitting, "fitted", counted)
    assert fitting.null(found.windows, POLICY, twice=True) is found
    assert len(begun) == 1


def test_a_place_is_linearised_once(found: Fit, monkeypatch: pytest.MonkeyPatch) -> None:
    """However often a step from there fails."""
    places, tried = list[bytes](), list[float]()
    kind = type(found.windows)
    blocks = kind.blocks

    def counted(self: EventWindows, at: Floats, own: Floats, *few: Any, **more: Any) -> list[Floats | None]:
        if not few and not more:  # all windows with all derivatives
            places.append(at.tobytes() + own.tobytes())
        return blocks(self, at, own, *few, **more)

    class NothingSaved:
        """Costs under which every place is as good as another."""

        def __init__(self, *_: object) -> None:
            pass

        def total(self, blocks: list[Floats | None], _: Floats, at: Floats) -> tuple[Floats, float]:
            tried.append(float(at[0]))
            return np.zeros(len(blocks)), 0.0

    monkeypatch.setattr(kind, "blocks", counted)
    monkeypatch.setattr(fitting, "Cost", NothingSaved)
    monkeypatch.setattr(fitting, "rescued", lambda fit: fit)  # no other place is sought
    monkeypatch.setattr(fitting, "lifted", lambda fit: fit)
    fitting.fitted(found, POLICY)
    assert len(tried) > 3
    assert len(set(places)) == len(places)


def test_a_scatter_that_ended_at_nothing_has_another_try(found: Fit) -> None:
    """There it has no slope, so that the fit stands still."""
    nothing = replace(found.population, level=1e-5, curve=1e-5, static=1e-5)
    still = fitting.closed(replace(found, population=nothing), POLICY, turns=0)
    assert still.deviance > found.deviance + 100
    assert fitting.doubtful(still, POLICY)


@pytest.mark.parametrize("why", ["steps", "swollen", "noise"])
def test_a_fit_that_is_no_usual_model_is_repeated(found: Fit, why: str) -> None:
    odd = {
        "steps": {"steps": POLICY.most_steps},
        "swollen": {"population": replace(found.population, static=0.3)},
        "noise": {"noise": found.noise},
    }[why]
    other = replace(found, **odd)  # type: ignore[arg-type]
    if why == "noise":
        assert found.linear is not None
        other = replace(other, linear=replace(found.linear, gram=3 * found.linear.gram))
    assert fitting.doubtful(other, POLICY)
