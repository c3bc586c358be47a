"""Accelerometers, load cells and second sensors: what `identify`, `compare` and `forecast` make of them.

Records are of the simulator written apart, with friction that scatters by 2 %.
"""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import scipy
from click.testing import CliRunner
from numpy.typing import NDArray

import stickslip as ss
from bodies_cases import CASES
from bodies_lab import Laboratory, at_rest, coulomb
from differences import held_against_differences
from stickslip.cli.commands import main
from stickslip.declared.uncertainty import Uncertainty
from stickslip.declared.units import Channel
from stickslip.errors import InputError
from stickslip.fitted.bodies_data import prepare_bodies
from stickslip.fitted.bodies_sensors import jumps
from stickslip.likelihoods.bodies_bench import bench_of
from stickslip.likelihoods.policy import POLICY

Floats = NDArray[np.float64]
m, k, c, SPEED = 0.5, 500.0, 1.0, 0.05
SLIDER = ss.BodiesRig(
    body={"slider": ss.Body(mass=m)},
    link=[ss.Link(between=("slider", "drive"), stiffness=k, damping=c)],
    contact=[ss.Contact(body="slider")],
)
STARTS = ss.CoulombFriction(static=3.4, kinetic=2.7)


def pulled(seed: int, lasts: float) -> dict[str, Floats]:
    """A slider pulled by a spring and a damper, without noise: what any sensor would read."""
    lab = Laboratory(
        M=np.array([[m]]), C=np.array([[c]]), K=np.array([[k]]), D=np.array([[1.0]]), laws=[coulomb(4.0, 2.4)],
        kinetic=[], static=[], V=[at_rest], force=np.zeros(1), level_sd=0.02, static_sd=0.02, sensing=True,
        rng=np.random.default_rng(seed), more=lambda t, _: np.array([k * SPEED * t + c * SPEED]),
    )  # fmt: skip
    t = np.arange(0.0, lasts, 0.001)
    x, v = lab.record(np.zeros(2), t).T
    a, T = lab.sensed.T
    return {"t": t, "slider": x, "v_slider": v, "a_slider": a, "T_slider": T,
            "F_link_1": k * (x - SPEED * t) + c * (v - SPEED)}  # fmt: skip


def noisy(true: dict[str, Floats], seed: int, **sizes: float) -> dict[str, Floats]:
    rng = np.random.default_rng(seed)
    return {"t": true["t"]} | {
        name: true[name] + size * rng.normal(size=len(true["t"])) for name, size in sizes.items()
    }


@pytest.fixture(scope="module")
def run() -> dict[str, Floats]:
    return pulled(1, 4.0)


@pytest.fixture(scope="module")
def recording(run: dict[str, Floats]) -> ss.Recording:
    """An accelerometer in g and a load cell in the spring, in mN."""
    columns = noisy(run, 2, a_slider=0.05, F_link_1=0.01)
    columns = {"t": columns["t"], "acc": columns["a_slider"] / 9.80665, "cell": 1e3 * columns["F_link_1"]}
    channels = {"t": Channel("t", "s"), "a_slider": Channel("acc", "g"), "F_link_1": Channel("cell", "mN")}
    return ss.load_recording(columns, SLIDER, channels=channels, drive_speed=SPEED)


def test_an_acceleration_and_the_force_in_a_link_tell_the_law(
    run: dict[str, Floats], recording: ss.Recording
) -> None:
    assert recording.coordinates["a_slider"] == pytest.approx(run["a_slider"], abs=0.3)
    found = ss.identify(recording, friction=STARTS)
    assert isinstance(found, ss.IdentifiedRig)
    for name, true in (("static", 4.0), ("kinetic", 2.4)):
        one = found.estimates[name]
        assert one.low is not None
        assert one.high is not None
        assert one.low < true < one.high
        assert one.high - one.low < 0.1 * true
    for kind in ("kinetic", "static"):
        spread = found.scatter[f"friction.{kind}"]
        assert spread.low < 0.02 < spread.high < 0.05
    assert found.reduced_chi2 == pytest.approx(1.0, abs=0.1)
    assert found.noise == pytest.approx({"a_slider": 0.05, "F_link_1": 0.01}, rel=0.1)
    for name, true in (("slider.mass", m), ("link_1.stiffness", k), ("gain.a_slider", 1.0)):
        assert abs(found.constants[name].value / true - 1) < 0.03
    assert found.wrong == ()


def test_friction_and_a_position_that_two_sensors_read_tell_the_law(run: dict[str, Floats]) -> None:
    """The second sensor reads 3 % too much, and the load cell stands 0.2 N off."""
    columns = noisy(run, 3, slider=1e-5, T_slider=0.02)
    columns["again"] = 1.03 * run["slider"] + 2e-5 * np.random.default_rng(4).normal(size=len(run["t"]))
    columns["T_slider"] += 0.2
    channels = {
        "t": Channel("t", "s"),
        "slider": Channel("slider", "m"),
        "again": Channel("again", "m", reads="slider"),
        "T_slider": Channel("T_slider", "N", offset_uncertainty=0.5),
    }
    recording = ss.load_recording(columns, SLIDER, channels=channels, drive_speed=SPEED)
    found = ss.identify(recording, friction=STARTS)
    assert isinstance(found, ss.IdentifiedRig)
    for name, true in (("static", 4.0), ("kinetic", 2.4)):
        one = found.estimates[name]
        assert one.low is not None
        assert one.high is not None
        assert one.low < true < one.high
    assert found.reduced_chi2 == pytest.approx(1.0, abs=0.1)
    assert found.wrong == ("gain.again",)
    assert found.constants["gain.again"].low < 1.03 < found.constants["gain.again"].high
    offset = found.offsets["T_slider"]
    assert offset.low is not None
    assert offset.high is not None
    assert offset.low < -0.2 < offset.high
    assert offset.high - offset.low < 0.2
    assert "offset.T_slider" in str(found)


def test_a_level_that_no_reading_shows_is_known_no_better_than_its_scatter(run: dict[str, Floats]) -> None:
    """
    Of velocities alone: what is seen is how far static friction is above kinetic, and by how much that differs.

    With scatter held where it is the upper end of the interval was 1.56 times the lower one.
    """
    found = ss.identify(
        ss.load_recording(noisy(run, 2, v_slider=1e-4), SLIDER, drive_speed=SPEED), friction=STARTS
    )
    assert isinstance(found, ss.IdentifiedRig)
    static, kinetic = found.estimates["static"], found.estimates["kinetic"]
    assert static.value - kinetic.value == pytest.approx(1.6, rel=0.2)
    assert static.low is not None
    assert static.high is not None
    assert static.high > 1.8 * static.low


@pytest.mark.parametrize("seed", [2, 4, 5])
def test_a_load_cell_under_the_contact_tells_the_law_alone(run: dict[str, Floats], seed: int) -> None:
    """A window that lets go some samples late has no slope that says so: it is sought."""
    found = ss.identify(
        ss.load_recording(noisy(run, seed, T_slider=0.02), SLIDER, drive_speed=SPEED), friction=STARTS
    )
    assert isinstance(found, ss.IdentifiedRig)
    for name, true in (("static", 4.0), ("kinetic", 2.4)):
        one = found.estimates[name]
        assert one.low is not None
        assert one.high is not None
        assert one.low < true < one.high
        assert one.high - one.low < 0.1 * true
    assert found.reduced_chi2 == pytest.approx(1.0, abs=0.1)


@pytest.mark.parametrize("read", [("a_bit", "F_link_1"), ("a_bit", "F_link_2"), ("T_bit", "table")])
def test_motion_that_is_not_read_is_found_from_accelerations_and_forces(read: tuple[str, ...]) -> None:
    """Of a drill string: by what its bit's accelerometer and its shaft, or the bit's friction and its table, tell."""
    case = CASES["drill"]()
    t = np.arange(0.0, 10.0, case.dt)
    run = ss.simulate(case.model, **case.speeds, initial=case.initial, t_end=t[-1], t_eval=t)  # type: ignore[arg-type]
    rng = np.random.default_rng(1)
    columns = {"t": t} | {
        name: getattr(run, name)
        + 0.01 * np.std(scipy.signal.detrend(getattr(run, name))) * rng.normal(size=len(t))
        for name in read
    }
    own = ss.load_recording(columns, case.model.rig, **case.speeds)  # type: ignore[arg-type]
    (found,) = prepare_bodies(case.model.rig, [own])  # type: ignore[arg-type]
    for i, name in enumerate(("table", "bit")):
        true, rate = getattr(run, name), getattr(run, f"v_{name}")
        assert np.std(found.q[:, i] - true) < 0.05 * np.std(scipy.signal.detrend(true))
        assert np.std(found.v[:, i] - rate) < 0.1 * np.std(rate)
    assert ((run.mode[:, 0] == 0) == found.stuck[:, 0]).mean() > 0.85
    start = ss.StribeckFriction(F_c=1.0, F_s=2.3, v_s=1.0)
    laws = ss.identify(own, friction={"bit_law": start})
    assert isinstance(laws, ss.IdentifiedRig)
    assert laws.estimates["bit_law.F_s"].value == pytest.approx(2.0, rel=0.03)
    assert laws.estimates["bit_law.F_c"].value == pytest.approx(1.2, rel=0.1)
    assert laws.wrong == ()


def test_motion_is_found_at_a_high_rate_too() -> None:
    """At 200 kHz the samples are so near each other that one by one they would determine nothing to rounding."""
    model = ss.Model(SLIDER, friction=ss.CoulombFriction(static=4.0, kinetic=2.4))
    t = np.arange(0.0, 0.6, 5e-6)
    made = ss.simulate(model, drive_speed=SPEED, initial=(0, 0), t_end=t[-1], t_eval=t)
    true = {"t": t, "a_slider": made.a_slider, "T_slider": made.T_slider}
    own = ss.load_recording(noisy(true, 1, a_slider=0.5, T_slider=0.2), SLIDER, drive_speed=SPEED)
    (found,) = prepare_bodies(SLIDER, [own])
    assert np.std(found.v[:, 0] - made.v_slider) < 0.05 * np.std(made.v_slider)
    assert np.std(found.q[:, 0] - made.slider) < 0.05 * np.std(made.slider - SPEED * t)


def test_derivatives_are_those_of_differences() -> None:
    """Of every kind of sensor, two of a kind, gains and offsets."""
    case = CASES["drill"]()
    t = np.arange(0.0, 5.0, case.dt)
    run = ss.simulate(case.model, **case.speeds, initial=case.initial, t_end=t[-1], t_eval=t)  # type: ignore[arg-type]
    read = ("table", "v_bit", "a_table", "a_bit", "F_link_1", "F_link_2", "T_bit")
    columns = {"t": t, **{name: getattr(run, name) for name in read}, "second": run.F_link_2}
    channels = {name: Channel(name) for name in columns} | {"second": Channel("second", reads="F_link_2")}
    channels["a_bit"] = Channel("a_bit", offset_uncertainty=0.1)
    noise = {name: 1e-2 * float(np.std(one)) for name, one in columns.items() if name != "t"}
    own = ss.load_recording(columns, case.model.rig, channels=channels, noise=noise, **case.speeds)  # type: ignore[arg-type]
    known = Uncertainty.usual(case.model.rig, channels=channels)
    assert known.gains.keys() == {*read, "second"}
    windows = replace(bench_of(case.model, [own], known), policy=replace(POLICY, tolerance=1e-11)).windows()
    at = np.array([one.start for one in windows.numbers])
    for i, one in enumerate(windows.numbers):
        at[i] += 0.003 * one.name.startswith(("gain", "offset")) + 0.01 * (
            one.name in case.model.rig.uncertain
        )  # type: ignore[union-attr]
    assert "offset.a_bit" in [one.name for one in windows.numbers]
    held_against_differences(windows, at, "sensors")


def test_readings_beside_a_jump_say_nothing() -> None:
    x = np.array([1.0, 1.1, 1.2, 5.0, 5.1, 5.2, 5.1, 5.0])
    assert np.flatnonzero(jumps(x, 0.05)).tolist() == [2, 3]
    assert not jumps(np.sin(np.linspace(0.0, 20.0, 200)), 1e-3).any()


def test_a_comparison_and_a_forecast(run: dict[str, Floats], recording: ss.Recording) -> None:
    model = ss.Model(SLIDER, friction=ss.CoulombFriction(static=4.0, kinetic=2.4))
    compared = ss.compare(model, recording)
    assert compared.channels == ("a_slider", "F_link_1")
    assert compared.row("noise left").simulated == pytest.approx(1.0, abs=0.1)
    row = compared.row("time between slips of slider")
    assert row.measured == pytest.approx(row.simulated, rel=0.05)
    held, wide = [], []
    for end in (2.0, 2.4, 2.8, 3.2):  # an event each
        told = ss.forecast(model, recording.window(0.0, end), horizon=0.3)
        assert list(told)[:3] == ["t", "a_slider", "F_link_1"]
        come = slice(round(end * 1000), round(end * 1000) + len(told))
        for name, true in (("a_slider", run["a_slider"] / 9.80665), ("F_link_1", 1e3 * run["F_link_1"])):
            low, high = told[f"{name}_low"].to_numpy(), told[f"{name}_high"].to_numpy()
            held.append(((low < true[come]) & (true[come] < high)).mean())
            wide.append(np.median(high - low) / np.ptp(true))
    assert np.mean(held) > 0.8
    assert max(wide) < 0.2


def test_a_case_with_sensors(tmp_path: Path, run: dict[str, Floats]) -> None:
    columns = noisy(run, 5, a_slider=0.05, F_link_1=0.01)
    np.savetxt(
        tmp_path / "run.csv",
        np.column_stack(list(columns.values())),
        delimiter=",",
        header="t,a,F",
        comments="",
    )
    text = """
[rig]
kind = "bodies"
body.slider.mass = 0.5
link = [{between = ["slider", "drive"], stiffness = 500, damping = 1}]
contact = [{body = "slider"}]
[friction]
kind = "coulomb"
static = 3.4
kinetic = 2.7
[uncertainty]
F_link_1 = 0.002
[[run]]
file = "run.csv"
role = "train"
drive_speed = "50 mm/s"
[channels]
t = { column = "t", unit = "s" }
a_slider = { column = "a", unit = "m/s^2", offset = 0.5, offset_uncertainty = 0.1 }
cell = { column = "F", unit = "N", reads = "F_link_1" }
"""
    (tmp_path / "rig.toml").write_text(text.replace("F_link_1 = 0.002", "cell = 0.002"))
    case = ss.load_case(tmp_path)
    assert case.uncertainty.gains == {"a_slider": 0.005, "cell": 0.002}
    read = case.runs[0]
    assert read.coordinates["a_slider"] == pytest.approx(columns["a_slider"] + 0.5)
    assert read.to_readings("a_slider", read.coordinates["a_slider"]) == pytest.approx(columns["a_slider"])
    saved = case.model()
    saved.save(tmp_path / "model.toml")
    asked = [
        "simulate",
        str(tmp_path / "model.toml"),
        "--drive-speed",
        "50 mm/s",
        "--t-end",
        "1 s",
        "--sensors",
    ]
    said = CliRunner().invoke(main, [*asked, "--out", str(tmp_path / "sim.csv")])
    assert said.exit_code == 0, said.output
    heads = "t [s],slider [m],v_slider [m/s],mode_slider,a_slider [m/s^2],F_link_1 [N],T_slider [N]"
    assert (tmp_path / "sim.csv").read_text().splitlines()[0] == heads
    assert ss.load_model(tmp_path / "model.toml").channels == saved.channels
    (tmp_path / "rig.toml").write_text(text)
    with pytest.raises(InputError, match="'F_link_1': neither a number of \\[rig\\] nor a recorded gain"):
        ss.load_case(tmp_path)


@pytest.mark.parametrize(
    ("name", "channel", "words"),
    [
        (
            "a_slider",
            Channel("a", "m/s"),
            "measures length / time, but this is an acceleration; give a unit like 'm/s\\^2'",
        ),
        ("a_slider", Channel("a", "rad/s^2"), "but this is an acceleration"),
        ("F_link_1", Channel("a", "N m"), "but this is a force; give a unit like 'N'"),
        ("F_link_2", Channel("a", "N"), "unknown channel of this rig; did you mean 'F_link_1'"),
        ("T_slider", Channel("a", "kg"), "but this is a force"),
        ("again", Channel("a", "m", reads="slide"), "again.reads: no such reading; did you mean 'slider'"),
        ("again", Channel("a", "m", reads="drive"), "again.reads: no such reading"),
        ("v_slider", Channel("a", "m", reads="slider"), "'v_slider' is a reading of its own"),
        ("drive", Channel("a", "m/s", offset=0.1), "time and prescribed speeds have no offset"),
    ],
)
def test_misdeclared_channels_are_refused(name: str, channel: Channel, words: str) -> None:
    t = np.arange(0.0, 1.0, 0.01)
    channels = {"t": Channel("t", "s"), "slider": Channel("x", "m"), name: channel}
    with pytest.raises(InputError, match=words):
        ss.load_recording({"t": t, "x": t, "a": t}, SLIDER, channels=channels, drive_speed=SPEED)


def test_what_sensors_cannot_tell_is_said() -> None:
    t = np.arange(0.0, 1.0, 0.01)
    with pytest.raises(
        InputError,
        match="accelerations alone do not say where the bodies are; record one of slider, v_slider, F_link_1, T_slider",
    ):
        ss.load_recording({"t": t, "a_slider": t}, SLIDER, drive_speed=SPEED)
    with pytest.raises(InputError, match="must not be negative"):
        Channel("a", offset_uncertainty=-1.0)
    block = {"t": Channel("t"), "x1": Channel("x", offset=1.0)}
    with pytest.raises(InputError, match=r"x1\.offset = 1\.0: is for rigs of bodies or matrices"):
        ss.load_recording({"t": t, "x": t}, ss.BlockOnBelt(mass=1, stiffness=1), channels=block)
    with pytest.raises(InputError, match=r"x1\.offset = 1\.0: is for rigs of bodies or matrices"):
        ss.Model(ss.BlockOnBelt(mass=1, stiffness=1), friction=STARTS, channels=block)
