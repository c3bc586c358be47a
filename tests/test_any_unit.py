"""What runs say does not depend on how large numbers are in SI: of a rig of micrometres it is what it is of metres.

Information of 1e-10 of a unit was added to what is known of every number. Of a spring of 4e6 N/m^3, known to 2e5, that
was more than all that the readings tell: intervals were too narrow by half, and of finer rigs no score was left.
"""

from __future__ import annotations

from dataclasses import replace
from functools import lru_cache

import numpy as np
import pytest
from numpy.typing import NDArray

import stickslip as ss
from bodies_cases import CASES, recorded, recording
from stickslip.declared.uncertainty import Uncertainty
from stickslip.discovery.general_rig.bench import GeneralBench, bench_of
from stickslip.discovery.laboratory.hypothesis import label, term
from stickslip.discovery.laboratory.screen import screened
from stickslip.likelihoods.bodies_windows import BodiesWindows
from stickslip.likelihoods.correlated import covariance
from stickslip.likelihoods.fit import begun, closed, fitted
from stickslip.likelihoods.fit_state import Fit

Floats = NDArray[np.float64]
CUBIC = 4e6  # N/m^3, of the pin along the disc
M, C, K = [[0.5, 0.0], [0.0, 0.3]], [[0.4, 0.0], [0.0, 0.3]], [[800.0, 90.0], [90.0, 1500.0]]
STEPS = 4  # of a fit: where it is to go is not asked


@lru_cache(maxsize=1)
def run() -> tuple[Floats, Floats]:
    """A pin whose spring is cubic, too."""
    return recorded(
        CASES["pin"](),
        3,
        level=0.02,
        static=0.02,
        lasts=3.0,
        more=lambda _t, z: np.array([-CUBIC * z[0] ** 3, 0.0]),
    )


def bench(length: float, mass: float, time: float) -> GeneralBench:
    """The same pin, its lengths, masses and times so many times as large."""
    case = CASES["pin"]()
    force = mass * length / time**2
    rig = ss.MatricesRig(
        M=(mass * np.array(M)).tolist(),
        C=(mass / time * np.array(C)).tolist(),
        K=(mass / time**2 * np.array(K)).tolist(),
        contact=[1.0, 0.0],
        names=["along", "across"],
    )
    model = ss.Model(rig, friction=ss.CoulombFriction(static=4.0 * force, kinetic=2.0 * force))
    t, read = run()
    speeds = {"belt_speed": 0.05 * length / time}
    own = replace(case, model=model, speeds=speeds, noise=case.noise * length)
    made = bench_of(
        model, [recording(own, t * time, read * length)], Uncertainty.usual(rig, channels=case.channels)
    )
    return replace(made, policy=replace(made.policy, most_steps=STEPS))


def with_cubic(made: GeneralBench, k: float) -> Fit:
    (kind,) = [one for one in made.kinds() if label(one) == "spring_cubic_k1@along"]
    return fitted(begun(made.windows((term(kind, {"k": k}),))), made.policy)


@lru_cache(maxsize=8)
def told(length: float, mass: float, time: float) -> tuple[dict[str, float], float, float]:
    """Scores by name beside the declared model; the spring as found and its error, over what it is."""
    made = bench(length, mass, time)
    null = closed(begun(made.windows()), made.policy, 0)
    gains = {one.term.name: one.gain for one in screened(made, null, ()).ranked}
    true = CUBIC * mass / (length * time) ** 2
    fit = with_cubic(made, true)
    place = [n.name for n in fit.windows.numbers].index("spring_cubic_k1@along.k")
    return gains, fit.at[place] / true, float(np.sqrt(covariance(fit)[place, place])) / true


@pytest.mark.parametrize(
    ("length", "mass", "time"), [(1e-3, 1.0, 1.0), (1e-6, 1e-9, 1e-3), (1e3, 1e6, 1.0), (1.0, 1.0, 1e3)]
)
def test_a_rig_of_another_size_is_told_the_same(length: float, mass: float, time: float) -> None:
    gains, found, error = told(1.0, 1.0, 1.0)
    other, there, beside = told(length, mass, time)
    assert gains["spring_cubic_k1@along"] > 20
    assert other.keys() == gains.keys()
    for name, gain in gains.items():
        assert other[name] == pytest.approx(gain, rel=1e-2, abs=0.5), name
    assert there == pytest.approx(found, rel=1e-3)
    assert beside == pytest.approx(error, rel=1e-2)


def test_an_error_is_what_the_likelihood_falls_by() -> None:
    """A size held two errors off, all else at its best, costs four; it cost less than two."""
    made = bench(1.0, 1.0, 1.0)
    made = replace(made, policy=replace(made.policy, most_steps=40, settled=1e-3))
    fit = with_cubic(made, CUBIC)
    place = [n.name for n in fit.windows.numbers].index("spring_cubic_k1@along.k")
    assert fit.solution is not None
    at, error = float(fit.at[place]), float(np.sqrt(fit.solution.covariance[place, place]))
    for side in (-1, 1):
        there = at + 2 * side * error
        numbers = list(fit.windows.numbers)
        numbers[place] = replace(numbers[place], start=there, low=there, high=there + 1e-6 * error)
        held = BodiesWindows(
            fit.windows.model, made.data, made.stretches, numbers, made.declared, made.policy
        )
        off = fitted(
            replace(fit, windows=held, at=np.where(np.arange(len(fit.at)) == place, there, fit.at)),
            made.policy,
        )
        assert off.deviance - fit.deviance == pytest.approx(4.0, rel=0.35)


@lru_cache(maxsize=4)
def followed_slider(length: float, mass: float, time: float) -> Floats:
    """A driven slider of another size: what is forecast of it, and by how much its run is missed, over its lengths."""
    force = mass * length / time**2
    model, plain = (
        ss.Model(
            ss.DrivenSlider(mass=95.1 * m, damping=203.5 * m / by),
            friction=ss.CoulombFriction(static=20.4 * f, kinetic=20.4 * f),
        )
        for m, by, f in ((mass, time, force), (1.0, 1.0, 1.0))
    )
    t = np.arange(0.0, 1.0, 1e-3)
    drive = 60 * np.sin(6 * t) + 20 * np.sin(1.3 * t)
    run = ss.simulate(plain, drive=(t, drive), initial=(0.0, 0.0), t_end=float(t[-1]), t_eval=t)
    x = run.x1 + 1e-6 * np.random.default_rng(0).standard_normal(len(t))
    units = {name: ss.Channel(name, unit) for name, unit in (("t", "s"), ("x1", "m"), ("drive", "N"))}
    recording = ss.load_recording(
        {"t": t * time, "x1": x * length, "drive": drive * force}, model.rig, channels=units
    )
    ahead = ss.forecast(model, recording, horizon=0.1 * time, drive=10.0 * force)
    missed = next(
        one.simulated for one in ss.compare(model, recording).rows if one.quantity == "position missed"
    )
    assert missed is not None
    return np.array([*ahead.iloc[-1, 1:], missed]) / length


@pytest.mark.parametrize(("length", "mass", "time"), [(1e-6, 1e-9, 1.0), (1e3, 1.0, 1e-2)])
def test_a_driven_slider_of_another_size_is_followed_the_same(
    length: float, mass: float, time: float
) -> None:
    """What a step of the fit of its start gained was held against 1e-8 of a metre, though all moves by micrometres."""
    np.testing.assert_allclose(followed_slider(length, mass, time), followed_slider(1.0, 1.0, 1.0), rtol=1e-6)
