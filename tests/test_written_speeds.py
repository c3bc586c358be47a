"""Speeds written with a unit, where motions are computed: the same numbers as bare, or one clear line."""

from __future__ import annotations

import numpy as np
import pytest

import stickslip as ss
from stickslip.errors import InputError

BLOCK = ss.Model(
    ss.BlockOnBelt(mass=0.5, stiffness=500), friction=ss.CoulombFriction(static=2.0, kinetic=1.2)
)
PAPER = ss.Model(
    ss.Rig.from_si(m=2.6, J=0.0174, r=0.08, k1=690, k2=45, k3=140, c1=0.28, c2=0.3, length=0.012),
    friction=ss.PaperFriction(),
)
BARE = ss.Model(ss.Rig(alpha1=16, alpha2=8, beta3=4, eta1=0.1, eta12=0.2), friction=ss.PaperFriction())
BODIES = ss.Model(
    ss.BodiesRig(
        body={"a": ss.Body(mass=1.0)},
        link=[ss.Link(between=("a", "ground"), stiffness=40.0)],
        contact=[ss.Contact(body="a", against="belt", law="rubber")],
    ),
    friction={"rubber": ss.StribeckFriction(F_c=3.2, F_s=4.8, v_s=0.25)},
)


@pytest.mark.parametrize(
    ("model", "speed"), [(BLOCK, 0.012), (PAPER, 0.012 / PAPER.rig.scales.velocity), (BODIES, 0.012)]
)
@pytest.mark.parametrize("written", ["12 mm/s", "12mm/s", "0.012 m/s"])
def test_a_unit_changes_no_motion(model: ss.Model, speed: float, written: str) -> None:
    runs = [ss.simulate(model, belt_speed=v, t_end=2.0).state for v in (written, speed)]
    np.testing.assert_allclose(runs[0], runs[1], rtol=1e-9, atol=1e-12)
    over = {"initial.a" if model is BODIES else "initial.x1": [0.0, 0.001]}
    made = [ss.sweep(model, over, belt_speed=v, t_end=2.0) for v in (written, speed)]
    np.testing.assert_allclose(made[0].final_state, made[1].final_state, rtol=1e-9, atol=1e-12)


def test_cycles_take_them_too() -> None:
    periods = [ss.limit_cycle(BLOCK, belt_speed=v).period for v in ("12 mm/s", 0.012)]
    assert periods[0] == pytest.approx(periods[1], rel=1e-9)


@pytest.mark.parametrize(
    ("model", "written", "words"),
    [
        (BLOCK, "12 kg", "measures mass"),
        (BLOCK, "12 furlongs", "furlong"),
        (BARE, "12 mm/s", "nondimensional"),
        (BODIES, "12 kg", "measures no speed"),
    ],
)
def test_what_measures_no_speed_is_refused(model: ss.Model, written: str, words: str) -> None:
    with pytest.raises(InputError, match=words):
        ss.simulate(model, belt_speed=written, t_end=1.0)


@pytest.mark.parametrize("model", [BLOCK, BARE, BODIES])
def test_text_without_a_unit_is_the_number(model: ss.Model) -> None:
    """t_end="1" was taken, belt_speed="12" refused."""
    start = {} if model is BODIES else {"initial": (0.1,) * (2 if model is BLOCK else 4)}
    runs = [ss.simulate(model, belt_speed=v, t_end=t, **start).state for v, t in (("0.1", "2"), (0.1, 2.0))]
    np.testing.assert_array_equal(*runs)


def test_text_without_a_unit_is_in_that_of_the_channel() -> None:
    t = np.arange(0, 2, 0.01)
    channels = {"t": ss.Channel("t", "s"), "a": ss.Channel("a", "mm"), "belt": ss.Channel("b", "mm/s")}
    columns = {"t": t, "a": np.sin(t), "b": 12 + 0 * t}
    runs = [
        ss.load_recording(columns, BODIES.rig, channels=channels, belt_speed=v) for v in ("12", 12, "12 mm/s")
    ]
    assert [run.belt_speed for run in runs] == pytest.approx([0.012] * 3, rel=1e-12)


def test_a_formula_stays_one() -> None:
    run = ss.simulate(BLOCK, belt_speed="0.01 + 0.002*sin(3*t)", t_end=1.0)
    assert np.isfinite(run.state).all()


@pytest.mark.parametrize(
    "speed",
    [
        ss.Speed.of(0.3),
        ss.Speed.of("0.1*sin(2*t)"),
        ss.Speed.steps([0, 1, 2], [0.1, "0.2*t", -0.3]),
        ss.Speed.measured([0, 1, 2, 3], [0, 1, 1, 3]),
    ],
    ids=["number", "formula", "steps", "measured"],
)
def test_a_speed_at_many_times_is_that_of_the_piece_of_each(speed: ss.Speed) -> None:
    t = np.array([[3.5, -1.0, 1.0], [0.5, 2.0, 9.0]])
    said = speed(t)
    assert said.shape == t.shape
    for one, got in zip(t.ravel().tolist(), said.ravel().tolist(), strict=True):
        assert got == pytest.approx(float(speed.at(one, speed.piece(one))[0]), rel=1e-14, abs=1e-15)
    assert float(speed(0.5)) == said[1, 0]
    assert speed(np.zeros((0, 2))).shape == (0, 2)


@pytest.mark.parametrize(
    ("model", "end"), [(BLOCK, 2.0), (PAPER, 2.0 / PAPER.rig.scales.time), (BODIES, 2.0)]
)
def test_a_time_may_have_its_unit(model: ss.Model, end: float) -> None:
    ends = [ss.simulate(model, belt_speed="12 mm/s", t_end=t).t[-1] for t in ("2 s", "2000 ms", end)]
    assert ends == pytest.approx([end] * 3, rel=1e-9)


def test_a_sweep_takes_times_as_a_simulation_does() -> None:
    over = {"initial.x1": [0.0, 0.001]}
    made = [
        ss.sweep(BLOCK, over, belt_speed=0.012, t_end=end, after=after)
        for end, after in ((2.0, 1.0), ("2 s", "1000 ms"), ("2", "1"))
    ]
    for one in made[1:]:
        np.testing.assert_array_equal(one.stick_fraction, made[0].stick_fraction)


@pytest.mark.parametrize("window", [("0.1 s", None), (None, "1"), (1.0,), 3.0])
def test_a_window_that_is_no_two_numbers_gets_one_line(window: object) -> None:
    """It ended in numpy's own error."""
    t = np.arange(0, 2, 0.01)
    channels = {"t": ss.Channel("t", "s"), "x1": ss.Channel("x", "mm")}
    with pytest.raises(InputError, match="window = "):
        ss.load_recording({"t": t, "x": np.sin(t)}, BLOCK.rig, channels=channels, window=window)  # type: ignore[arg-type]


def test_what_measures_no_time_is_refused() -> None:
    with pytest.raises(InputError, match="t_end = '2 mm'"):
        ss.simulate(BLOCK, belt_speed=0.012, t_end="2 mm")


def test_a_forecast_takes_units_as_a_simulation_does() -> None:
    t = np.arange(0, 3, 0.002)
    x1 = ss.simulate(BLOCK, belt_speed=0.012, t_end=3, t_eval=t).x1
    x1 = x1 + 1e-6 * np.random.default_rng(0).standard_normal(t.size)
    past = ss.load_recording({"t": t, "x1": x1}, BLOCK.rig, belt_speed=0.012)
    told = [
        ss.forecast(BLOCK, past, belt_speed=v, horizon=h) for v, h in (("12 mm/s", "300 ms"), (0.012, 0.3))
    ]
    np.testing.assert_allclose(told[0], told[1])
    with pytest.raises(InputError, match="belt_speed = '12 kg'"):
        ss.forecast(BLOCK, past, belt_speed="12 kg", horizon=0.3)
