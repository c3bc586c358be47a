"""Runs whose belt or drive is moved in steps or as a channel reads, against records of a simulator written apart."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

import stickslip as ss
from bodies_cases import one_block
from bodies_lab import Laboratory, at_rest, coulomb
from stickslip.declared.uncertainty import Uncertainty
from stickslip.errors import InputError
from stickslip.fitted.bodies_data import prepare_bodies
from stickslip.likelihoods.bodies_bench import bench_of
from stickslip.likelihoods.bodies_windows import RunWindows
from stickslip.measured.straight_pieces import straight_pieces

Floats = NDArray[np.float64]
Moved = Callable[[float], tuple[float, float]]
DT, NOISE = 0.004, 1e-5
STEPS = [(0.0, 0.03), (1.0, 0.0), (2.0, 0.015), (4.0, 0.0), (4.5, 0.04)]
BY_HAND = "0.02 + 0.012*sin(0.9*t) + 0.005*sin(2.3*t + 1)"
TRUTH = {"static": 4.0, "kinetic": 2.4}
START = ss.CoulombFriction(static=4.4, kinetic=2.1)


def by_hand(t: float) -> tuple[float, float]:
    """The same speed and its rate."""
    speed = 0.02 + 0.012 * np.sin(0.9 * t) + 0.005 * np.sin(2.3 * t + 1)
    return float(speed), float(0.0108 * np.cos(0.9 * t) + 0.0115 * np.cos(2.3 * t + 1))


def block(times: Floats, start: Floats, moved: Moved) -> Floats:
    """States of a block of 0.5 kg on 500 N/m and 0.5 N s/m."""
    laboratory = Laboratory(
        M=np.array([[0.5]]), C=np.array([[0.5]]), K=np.array([[500.0]]), D=np.array([[1.0]]),
        laws=[coulomb(4.0, 2.4)], kinetic=[], static=[], V=[moved], force=np.zeros(1),
    )  # fmt: skip
    return laboratory.record(start, times)


RIG = ss.BodiesRig(
    body={"x": ss.Body(mass=0.5)},
    link=[ss.Link(between=("x", "ground"), stiffness=500.0, damping=0.5)],
    contact=[ss.Contact(body="x", against="belt")],
)


def stop_and_go() -> tuple[Floats, Floats]:
    """Times and states under steps of the belt, which SciPy takes one after the other."""
    t, z, out = np.arange(0, 7, DT), np.array([0.0, STEPS[0][1]]), []
    edges = [begin for begin, _ in STEPS] + [7.0]
    for (begin, speed), end in zip(STEPS, edges[1:], strict=True):
        part = np.append(t[(t >= begin - 1e-9) & (t < end - 1e-9)], end)
        states = block(part, z, lambda _t, v=speed: (v, 0.0))  # type: ignore[misc]
        z = states[-1]
        out.append(states[:-1])
    return t, np.concatenate(out)


def steps(of: list[tuple[float, float]] = STEPS) -> list[dict[str, object]]:
    return [{"from": begin, "value": value} for begin, value in of]


def covers(found: ss.IdentifiedRig) -> bool:
    ends = {name: found.estimates[name] for name in TRUTH}
    return all(e.low < TRUTH[name] < e.high for name, e in ends.items())  # type: ignore[operator]


@pytest.fixture(scope="module")
def turned() -> dict[str, Floats]:
    """A record of a belt turned by hand, its tachometer with noise."""
    t, rng = np.arange(0, 8, DT), np.random.default_rng(1)
    x = block(t, np.array([0.0, by_hand(0.0)[0]]), by_hand)[:, 0]
    speed = np.array([by_hand(one)[0] for one in t])
    return {
        "t": t,
        "x": x + NOISE * rng.standard_normal(t.size),
        "belt": speed + 2e-4 * rng.standard_normal(t.size),
    }


def test_a_law_on_a_belt_that_stops_and_goes() -> None:
    t, states = stop_and_go()
    speed = ss.Speed.steps(*zip(*STEPS, strict=True))
    ours = ss.simulate(
        ss.Model(RIG, friction=ss.CoulombFriction(**TRUTH)),
        belt_speed=speed,
        initial=(0.0, 0.03),
        t_end=float(t[-1]),
        t_eval=t,
    )
    assert np.abs(ours.state - states).max() < 1e-6
    x = states[:, 0] + NOISE * np.random.default_rng(1).standard_normal(t.size)
    run = ss.load_recording({"t": t, "x": x}, RIG, belt_speed=steps())
    found = ss.identify(run, friction=START)
    assert isinstance(found, ss.IdentifiedRig)
    assert covers(found)
    assert found.reduced_chi2 == pytest.approx(1.0, abs=0.1)
    compared = ss.compare(found.model, run)
    assert compared.row("noise left").simulated == pytest.approx(1.0, abs=0.15)
    ahead = ss.forecast(found.model, run.window(0, 6.5), horizon=0.4)  # the last step goes on
    true = x[len(run.window(0, 6.5)) :][: len(ahead)]
    assert np.mean((true > ahead["x_low"]) & (true < ahead["x_high"])) > 0.85


def test_jumps_of_a_measured_belt_are_nothing_that_is_missing() -> None:
    """When a jump came between two samples is not known; on 25 mm/s it moved a block by ten times the noise."""
    t, states = stop_and_go()
    rng, speed = np.random.default_rng(1), ss.Speed.steps(*zip(*STEPS, strict=True))
    columns = {
        "t": t,
        "x": states[:, 0] + NOISE * rng.standard_normal(t.size),
        "belt": speed(t) + 1e-4 * rng.standard_normal(t.size),
    }
    run = ss.load_recording(columns, RIG, belt_speed="measured")
    (data,) = prepare_bodies(RIG, [run])
    assert data.leaps == [int(np.searchsorted(t, begin - 1e-9)) for begin, _ in STEPS[1:]]
    (late,) = prepare_bodies(RIG, [run.window(0.5, 9.0)])
    assert late.leaps == [one - 125 for one in data.leaps]
    found = ss.identify(run, friction=START)
    assert isinstance(found, ss.IdentifiedRig)
    assert covers(found)
    assert found.reduced_chi2 == pytest.approx(1.0, abs=0.1)


def test_a_belt_that_was_measured_tells_as_its_formula_does(turned: dict[str, Floats]) -> None:
    measured = ss.load_recording(turned, RIG, belt_speed="measured")
    told = ss.load_recording({name: turned[name] for name in ("t", "x")}, RIG, belt_speed=BY_HAND)
    assert measured.taken == ("belt",)
    assert len(measured.speeds["belt_speed"].pieces) < 60
    assert measured.speeds["belt_speed"](turned["t"]) == pytest.approx(
        told.speeds["belt_speed"](turned["t"]), abs=4e-4
    )
    found, exact = (ss.identify(one, friction=START) for one in (measured, told))
    assert isinstance(found, ss.IdentifiedRig)
    assert isinstance(exact, ss.IdentifiedRig)
    assert covers(found)
    assert covers(exact)
    assert found.reduced_chi2 == pytest.approx(1.0, abs=0.15)
    for name in TRUTH:
        assert found.estimates[name].value == pytest.approx(exact.estimates[name].value, rel=5e-3)
    # it is no reading beside the speed: neither its noise nor its gain is found
    assert set(found.noise) == {"x"}
    assert not any("belt" in name for name in found.constants)


def test_a_tachometer_that_reads_too_much_is_no_wrong_law(turned: dict[str, Floats]) -> None:
    run = ss.load_recording({**turned, "belt": 1.01 * turned["belt"]}, RIG, belt_speed="measured")
    found = ss.identify(run, friction=START)
    assert isinstance(found, ss.IdentifiedRig)
    assert covers(found)
    assert found.reduced_chi2 < 1.2


def test_a_belt_set_to_a_number_beside_one_by_a_formula_is_off_by_itself(turned: dict[str, Floats]) -> None:
    """The share that it was off by moved the static limit."""
    columns = {name: turned[name] for name in ("t", "x")}
    runs = [ss.load_recording(columns, RIG, belt_speed=speed) for speed in (0.02, BY_HAND)]
    model = ss.Model(RIG, friction=START)
    windows = bench_of(model, runs, Uncertainty.usual(RIG, channels=runs[0].channels)).windows()
    names = [one.name for one in windows.numbers]
    at = np.array([one.usual if one.name != "belt_off" else 0.01 for one in windows.numbers])
    assert names.count("belt_off") == 2  # each for itself
    still = np.where([name == "belt_off" for name in names], 0.0, at)
    point, usual = (RunWindows(windows, 0, one, [names.index("belt_off")]) for one in (at, still))
    own = windows.first()[0]
    (values, seeds), (plain, _) = point.started(0, own), usual.started(0, own)
    place = usual.lowered.layout["parameters"] + usual.lowered.places["belt_speed"]
    assert values[place] == pytest.approx(0.0202)
    assert values - plain == pytest.approx(0.01 * seeds[0])
    assert np.count_nonzero(seeds[0]) <= 3  # with the speed, and the way, that the window begins with


def test_what_comes_after_a_measured_speed_must_be_given(turned: dict[str, Floats]) -> None:
    run = ss.load_recording(turned, RIG, belt_speed="measured")
    past = run.window(0.0, 7.5)
    model = ss.Model(RIG, friction=ss.CoulombFriction(**TRUTH))
    with pytest.raises(InputError, match="belt_speed: missing: the past's was measured"):
        ss.forecast(model, past, horizon=0.4)
    ahead = ss.forecast(model, past, horizon=0.4, belt_speed=BY_HAND)  # by the clock of the record
    true = turned["x"][len(past) :][: len(ahead)]
    assert np.mean((true > ahead["x_low"]) & (true < ahead["x_high"])) > 0.85
    early, late = run.window(0.0, 4.0), run.window(4.0, 9.0)
    assert late.speeds["belt_speed"](1.0) == pytest.approx(run.speeds["belt_speed"](5.0))
    assert early.taken == late.taken == ("belt",)


def test_a_belt_that_stands_still_by_its_channel() -> None:
    t = np.arange(0, 6, 0.01)
    rng = np.random.default_rng(2)
    speed = np.where(t < 2, 0.1, np.where(t < 4, 0.0, 0.05))
    run = ss.load_recording(
        {"t": t, "x": np.sin(t), "belt": speed + 1e-3 * rng.standard_normal(t.size)},
        one_block(),
        belt_speed="measured",
    )
    found = run.speeds["belt_speed"]
    assert found.text == "measured, 600 samples in 5 pieces"
    assert float(found(3.0)) == 0.0
    assert found([1.0, 5.0]) == pytest.approx([0.1, 0.05], abs=3e-4)
    steady = {"t": t, "x": np.sin(t), "belt": 0.1 + 1e-3 * rng.standard_normal(t.size)}
    assert ss.load_recording(steady, one_block(), belt_speed="measured").belt_speed == pytest.approx(
        0.1, abs=1e-4
    )
    dead = {"t": t, "x": np.sin(t), "belt": 0 * t}
    assert ss.load_recording(dead, one_block(), belt_speed="measured").belt_speed == 0


def test_a_drive_goes_where_it_was_read_to_go() -> None:
    rig = ss.BodiesRig(
        body={"x": ss.Body(mass=0.5)},
        link=[ss.Link(between=("x", "drive"), stiffness=500)],
        contact=[ss.Contact(body="x")],
    )
    t, rng = np.arange(0, 20, 0.01), np.random.default_rng(0)
    speed, come = 0.02 + 0.015 * np.sin(0.7 * t), 0.02 * t + 0.015 / 0.7 * (1 - np.cos(0.7 * t))
    columns = {"t": t, "x": come, "drive": 1.002 * speed + 3e-4 * rng.standard_normal(t.size)}
    off = []
    for more in ({}, {"x_drive": 0.3 + come + 1e-5 * rng.standard_normal(t.size)}):
        run = ss.load_recording({**columns, **more}, rig, drive_speed="measured")
        assert run.taken == ("drive",)
        off.append(np.abs(run.speeds["drive_speed"].way(t) - come).max())
    assert off[1] < 8e-5 < off[0]


def test_a_slider_pulled_by_a_measured_drive() -> None:
    pulled = ss.BodiesRig(
        body={"x": ss.Body(mass=0.5)},
        link=[ss.Link(between=("x", "drive"), stiffness=500.0, damping=0.5)],
        contact=[ss.Contact(body="x")],
    )
    t, rng = np.arange(0, 6, DT), np.random.default_rng(3)
    speed, come = 0.02 + 0.012 * np.sin(0.9 * t), 0.02 * t + 0.012 / 0.9 * (1 - np.cos(0.9 * t))

    def force(s: float, _z: Floats) -> Floats:
        way = 0.02 * s + 0.012 / 0.9 * (1 - np.cos(0.9 * s))
        return np.array([500.0 * way + 0.5 * (0.02 + 0.012 * np.sin(0.9 * s))])

    laboratory = Laboratory(
        M=np.array([[0.5]]), C=np.array([[0.5]]), K=np.array([[500.0]]), D=np.array([[1.0]]),
        laws=[coulomb(4.0, 2.4)], kinetic=[], static=[], V=[at_rest], force=np.zeros(1), more=force,
    )  # fmt: skip
    columns = {
        "t": t,
        "x": laboratory.record(np.zeros(2), t)[:, 0] + NOISE * rng.standard_normal(t.size),
        "drive": 1.003 * speed + 2e-4 * rng.standard_normal(t.size),
        "x_drive": 0.1 + come + NOISE * rng.standard_normal(t.size),
    }
    columns["x"] += 0.1  # both are counted from elsewhere
    run = ss.load_recording(columns, pulled, drive_speed="measured")
    found = ss.identify(run, friction=START)
    assert isinstance(found, ss.IdentifiedRig)
    assert covers(found)
    assert found.reduced_chi2 == pytest.approx(1.0, abs=0.15)
    assert set(found.noise) == {"x"}


@settings(max_examples=20, deadline=None)
@given(
    st.integers(0, 2**32 - 1),
    st.sampled_from([5e-4, 2e-3, 1e-2]),
    st.floats(0.2, 1.5),
)
def test_straight_pieces_are_nearer_than_the_noise(seed: int, noise: float, often: float) -> None:
    t, rng = np.arange(0, 20, 0.01), np.random.default_rng(seed)
    true = 0.1 + 0.05 * np.sin(often * t + rng.uniform(0, 6))
    found = straight_pieces(t, true + noise * rng.standard_normal(t.size))
    left = np.interp(t, found.t, found.values) - true
    assert np.sqrt(np.mean(left**2)) < 0.8 * noise
    assert len(found.t) < 200


@settings(max_examples=15, deadline=None)
@given(
    st.lists(
        st.tuples(st.integers(1, 9), st.floats(0.0, 0.2)),
        min_size=1,
        max_size=5,
        unique_by=lambda one: one[0],
    )
)
def test_the_forms_of_steps_agree(of: list[tuple[int, float]]) -> None:
    """In numbers, with units, as formulas and as a `Speed`."""
    of = sorted(of)
    t = np.arange(0, 10, 0.1)
    columns = {"t": t, "x": np.sin(t)}
    plain = ss.Speed.steps([begin for begin, _ in of], [value for _, value in of])
    forms: list[object] = [
        plain,
        steps([(begin, value) for begin, value in of]),
        [{"from": f"{1e3 * begin!r} ms", "value": f"{1e3 * value!r} mm/s"} for begin, value in of],
        [{"from": begin, "value": f"{value!r} + 0*t"} for begin, value in of],
    ]
    for form in forms:
        run = ss.load_recording(columns, one_block(), belt_speed=form)  # type: ignore[arg-type]
        assert run.speeds["belt_speed"](t) == pytest.approx(plain(t), abs=1e-12)


CASE = """[rig]
kind = "bodies"
body.x.mass = "0.5 kg"
link = [{ between = ["x", "ground"], stiffness = "500 N/m" }]
contact = [{ body = "x", against = "belt" }]
[friction]
kind = "coulomb"
static = 2
kinetic = 1.2
[[run]]
file = "a.csv"
role = "train"
SPEED
[channels]
t = { column = "t", unit = "s" }
x = { column = "x", unit = "mm" }
belt = { column = "v", unit = "mm/s" }
"""


def case(folder: Path, speed: str) -> ss.Recording:
    t = np.arange(0, 10, 0.05)
    rows = np.column_stack([t, np.sin(t), 100 + 10 * np.sin(t)])
    np.savetxt(folder / "a.csv", rows, delimiter=",", header="t,x,v", comments="")
    (folder / "rig.toml").write_text(CASE.replace("SPEED", speed), encoding="utf-8")
    return ss.load_case(folder).runs[0]


def test_a_case_has_steps_and_measured_speeds(tmp_path: Path) -> None:
    one = '[{ from = 0, value = 100 }, { from = "5 s", value = 0 }, { from = 8, value = "0.02*t" }]'
    wide = '[\n  { from = 0, value = "0.1 m/s" },\n  { from = 5, value = 0 },  # [it stops]\n'
    wide += '  { from = 8, value = "0.02*t" },\n]'
    for text in (one, wide):
        run = case(tmp_path, f"belt_speed = {text}")
        assert run.speeds["belt_speed"]([1.0, 6.0, 9.0]) == pytest.approx([0.1, 0.0, 0.18])
        assert run.speeds["belt_speed"].text == "0.1 from 0, 0 from 5, 0.02*t from 8"
        assert np.isnan(run.belt_speed)
    run = case(tmp_path, "[[run.belt_speed]]\nfrom = 0\nvalue = 20")
    assert run.belt_speed == pytest.approx(0.02)
    run = case(tmp_path, 'belt_speed = "measured"')
    assert run.speeds["belt_speed"](run.t) == pytest.approx(0.1 + 0.01 * np.sin(run.t), abs=2e-4)


@pytest.mark.parametrize(
    ("speed", "said"),
    [
        ("", '10, [run 1] key \'belt_speed\': missing: a contact rubs on the belt; give its speed, or "measured"'),
        ("[\n{ from = 0, value = 1 },\n{ from = 2, valeu = 3 }]", "15, [run 1 belt_speed 2] key 'valeu': unknown"),
        ("[\n{ from = 0, value = 1 },\n{ from = 2 }]", "15, [run 1 belt_speed 2]: lacks 'value'"),
        ("[\n{ from = 0, value = 1 },\n{ from = 2, value = '3 N' }]", "15, [run 1 belt_speed 2] key 'value' = '3 N'"),
        ("[\n{ from = 0, value = 1 },\n{ from = '2 m', value = 3 }]", "15, [run 1 belt_speed 2] key 'from' = '2 m'"),
        ("[{ from = 1, value = 1 }, { from = 0, value = 2 }]", "13, [run 1] key 'belt_speed': its times must"),
        ("[{ from = 1, value = 1 }, 4]", "13, [run 1 belt_speed 2]: no step"),
        ("[]", "13, [run 1] key 'belt_speed': has no steps"),
    ],
)  # fmt: skip
def test_wrong_steps_are_said_in_a_line(tmp_path: Path, speed: str, said: str) -> None:
    with pytest.raises(InputError) as error:
        case(tmp_path, speed and f"belt_speed = {speed}")
    assert f"rig.toml line {said}" in str(error.value)
    assert "\n" not in str(error.value)


def test_what_is_missing_of_a_measured_speed_is_said() -> None:
    t = np.arange(0, 4, 0.01)
    columns = {"t": t, "x": np.sin(t)}
    with pytest.raises(InputError, match="no channel 'belt' is recorded"):
        ss.load_recording(columns, one_block(), belt_speed="measured")
    gap = np.where(np.arange(t.size) == 50, np.nan, 0.1)
    with pytest.raises(InputError, match="column 'belt': nan at sample 50"):
        ss.load_recording({**columns, "belt": gap}, one_block(), belt_speed="measured")
    with pytest.raises(InputError, match="or \"measured\", as channel 'belt' reads it"):
        ss.load_recording({**columns, "belt": 0 * t + 0.1}, one_block())
    with pytest.raises(InputError, match="must be one number on a named rig"):
        ss.load_recording({"t": t, "x1": np.sin(t)}, ss.BlockOnBelt(), belt_speed="measured")
    with pytest.raises(InputError, match="belt_speed: must be one number on a named rig"):
        ss.load_recording({"t": t, "x1": np.sin(t)}, ss.BlockOnBelt(), belt_speed=steps())
