"""How far a prescribed speed goes, and the clock it goes by where a run is cut."""

import numpy as np
import pytest
import scipy

import stickslip as ss
from bodies_cases import one_block


@pytest.mark.parametrize(
    "speed",
    [
        ss.Speed.of(0.3),
        ss.Speed.of("0.1 + 0.5*sin(7*t)*exp(-0.2*t)"),
        ss.Speed.steps([0, 1.5, 4], [0.1, "0.02*t", 0]),
        ss.Speed.measured(np.arange(0, 8, 0.01), np.sin(np.arange(0, 8, 0.01))),
    ],
    ids=lambda one: one.text,
)
def test_the_way_is_the_integral(speed: ss.Speed) -> None:
    t = np.array([0.0, 7.3, 0.4, 4.0, 2.2])
    found = speed.way(t)
    for at, come in zip(t, found, strict=True):
        edges = np.unique([0.0, *(one for one in speed.begins if 0 < one < at), at])
        parts = [
            scipy.integrate.quad(lambda s: float(speed(s)), a, b, epsabs=1e-13)[0]
            for a, b in zip(edges[:-1], edges[1:], strict=True)
        ]
        assert come == pytest.approx(sum(parts), abs=1e-10)
    assert float(speed.way(2.2)) == pytest.approx(found[-1], abs=1e-12)


def test_one_speed_follows_another() -> None:
    both = ss.Speed.steps([0, 2], [0.1, 0.3]).followed(ss.Speed.of("0.02*t"), 3.0)
    assert both([1.0, 2.5, 3.0, 5.0]) == pytest.approx([0.1, 0.3, 0.06, 0.1])


def test_the_late_part_of_a_run_keeps_the_clock_of_its_speed() -> None:
    """The last third of a recording was validated on with the speed of its beginning."""
    t = np.arange(5.0, 15.0, 0.01)
    run = ss.load_recording({"t": t, "x": np.sin(t)}, one_block(), belt_speed="0.1 + 0.02*t")
    late = run.window(8.995, 20.0)
    assert float(late.speeds["belt_speed"](0.0)) == pytest.approx(0.1 + 0.02 * 4)
    assert run.window(0.0, 7.0).speeds == run.speeds
