"""Cases and recordings: units, windows, overrides, findings; and the shared cases where they are at hand."""

import json
import os
import pickle
import time
from pathlib import Path

import numpy as np
import pytest

from stickslip.data import example, examples
from stickslip.declared.friction.coulomb import CoulombFriction
from stickslip.declared.friction.paper import PaperFriction
from stickslip.declared.model import load_model
from stickslip.declared.rig import BlockOnBelt, Rig
from stickslip.errors import InputError
from stickslip.measured.case import Case, Channel, Recording, load_case, load_recording
from stickslip.measured.findings import FindingKind

ND = Rig(alpha1=16, alpha2=8, beta3=4, eta1=0.1, eta12=0.2)
SI = {"m": 40.0, "J": 0.3, "r": 0.1, "k1": 6e3, "k2": 4e2, "k3": 1.2e3, "c1": 2.0, "c2": 3.0, "length": 0.01}
SHARED = Path(os.environ.get("STICKSLIP_SHARED", Path(__file__).resolve().parents[2] / "shared")) / "cases"
needs_shared = pytest.mark.skipif(not SHARED.is_dir(), reason="the shared cases are not at hand")


def write(folder: Path, name: str = "run.csv", **columns: np.ndarray) -> Path:
    lines = [
        ",".join(columns),
        *(",".join(repr(float(x)) for x in row) for row in zip(*columns.values(), strict=True)),
    ]
    (folder / name).write_text("\n".join(lines) + "\n")
    return folder / name


def signals(n: int = 200, dt: float = 0.01) -> dict[str, np.ndarray]:
    t = dt * np.arange(n)
    return {
        "t": t,
        "x1": 0.3 * np.sin(40 * t),
        "y1": 0.1 * np.cos(23 * t),
        "belt": 0.1 + 0.001 * np.sin(71 * t),
    }


def kinds(recording: Recording) -> list[FindingKind]:
    return [finding.kind for finding in recording.findings]


def write_case(folder: Path, runs: str, *, rig: dict[str, float] | None = None, channels: str = "") -> Path:
    table = "\n".join(f"{name} = {value}" for name, value in (SI if rig is None else rig).items())
    channels = channels or (
        't = { column = "t", unit = "s" }\n'
        'x1 = { column = "x1", unit = "mm" }\n'
        'y1 = { column = "y1", unit = "mm" }\n'
    )
    (folder / "rig.toml").write_text(f"[rig]\n{table}\n{runs}\n[channels]\n{channels}")
    return folder / "rig.toml"


def test_bare_recording(tmp_path: Path) -> None:
    s = signals()
    run = load_recording(write(tmp_path, **s), ND, belt_speed=0.1)
    for name in ("t", "x1", "y1", "belt"):
        np.testing.assert_array_equal(getattr(run, name), s[name])
        assert run.factor(name) == 1
    assert (run.belt_speed, run.name, run.role, run.noise, run.findings) == (0.1, "run", "train", {}, ())
    assert len(run) == 200
    assert isinstance(pickle.loads(pickle.dumps(run)), Recording)


def test_units_of_an_si_rig(tmp_path: Path) -> None:
    """Each channel, by hand from omega = sqrt((k1 + k2)/m) and length."""
    s = signals()
    rig = Rig.from_si(**SI)
    omega, length = np.sqrt(6400 / 40), 0.01
    channels = {
        "t": Channel("t", "ms"),
        "x1": Channel("x1", "um", 2.0),
        "y1": Channel("y1", "deg"),
        "belt": Channel("belt", "mm/s"),
    }
    run = load_recording(
        write(tmp_path, **s), rig, channels=channels, belt_speed=50.0, noise={"x1": 3.0, "y1": 0.5}
    )
    np.testing.assert_allclose(run.t, s["t"] * 1e-3 * omega, rtol=1e-14)
    np.testing.assert_allclose(run.x1, s["x1"] * 2e-6 / length, rtol=1e-14)
    np.testing.assert_allclose(run.y1, np.deg2rad(s["y1"]) * 0.1 / length, rtol=1e-14)
    np.testing.assert_allclose(run.belt, s["belt"] * 1e-3 / (length * omega), rtol=1e-14)
    assert run.belt_speed == pytest.approx(0.05 / (length * omega), rel=1e-14)
    assert run.noise == pytest.approx({"x1": 3e-6 / length, "y1": np.deg2rad(0.5) * 0.1 / length}, rel=1e-14)
    for name in ("t", "x1", "y1", "belt"):
        np.testing.assert_allclose(run.to_readings(name, getattr(run, name)), run.raw[name], rtol=1e-14)
        np.testing.assert_allclose(run.from_readings(name, run.raw[name]), getattr(run, name), rtol=1e-14)
        assert run.unit(name) == channels[name].unit


def test_belt_set_point_without_a_belt_channel(tmp_path: Path) -> None:
    s = signals()
    del s["belt"]
    file = write(tmp_path, **s)
    si = Rig.from_si(**SI)
    channels = {"t": Channel("t", "s"), "x1": Channel("x1", "mm"), "y1": Channel("y1", "rad")}
    velocity = 0.01 * np.sqrt(160)
    assert load_recording(file, si, channels=channels, belt_speed=0.2).belt_speed == pytest.approx(
        0.2 / velocity
    )
    text = load_recording(file, si, channels=channels, belt_speed="20 cm/s").belt_speed
    assert text == pytest.approx(0.2 / velocity)
    assert load_recording(file, ND, belt_speed=-0.2).belt_speed == -0.2


def test_spring_force_of_a_block_on_a_belt(tmp_path: Path) -> None:
    t = 1e-3 * np.arange(50)
    share = 0.3 + 0.02 * np.sin(90 * t)
    channels = {"t": Channel("time", "s"), "spring_force": Channel("F", "mN", 301.0)}
    rig = BlockOnBelt(mass=0.0307, stiffness=168)
    run = load_recording(
        write(tmp_path, time=t, F=share),
        rig,
        channels=channels,
        belt_speed="1100 um/s",
        noise={"spring_force": 2.0},
    )
    np.testing.assert_allclose(run.x1, share * 0.301 / 168, rtol=1e-14)
    assert run.y1 is None
    assert run.belt is None
    assert run.belt_speed == pytest.approx(1.1e-3)
    assert run.noise == pytest.approx({"x1": 2e-3 / 168})
    assert (run.channel("x1"), run.unit("x1")) == ("spring_force", "mN")
    np.testing.assert_allclose(run.to_readings("x1", run.x1), share, rtol=1e-14)


def test_windows_and_overrides(tmp_path: Path) -> None:
    t = 0.5 * np.arange(60)
    write(tmp_path, t=t, x=np.sin(t))
    runs = """
    [[run]]
    file = "run.csv"
    role = "train"
    belt_speed = 0.1
    to = 10
    [[run]]
    file = "run.csv"
    role = "validate"
    belt_speed = "1 cm/s"
    from = 10
    to = 20
    rig = { k = 1002.0 }
    [[run]]
    file = "run.csv"
    role = "validate"
    belt_speed = 0.3
    from = 20
    name = "last"
    """
    channels = 't = { column = "t", unit = "s" }\nspring_force = { column = "x", unit = "N" }\n'
    path = write_case(tmp_path, runs, rig={"kind": '"block_on_belt"', "m": 2.0, "k": 100}, channels=channels)  # type: ignore[dict-item]
    case = load_case(path)
    first, second, last = case.runs
    assert [run.name for run in case.runs] == ["run_to_10", "run_from_10_to_20", "last"]
    assert np.concatenate([run.t for run in case.runs]).tolist() == t.tolist()
    assert second.t[[0, -1]].tolist() == [10.0, 19.5]
    assert (first.rig, second.rig) == (case.rig, BlockOnBelt(mass=2, stiffness=1002))
    np.testing.assert_allclose(second.x1 * 1002, np.sin(second.t))
    np.testing.assert_allclose(last.x1 * 100, np.sin(last.t))
    assert second.belt_speed == pytest.approx(0.01)
    assert (case.train, case.validate) == ((first,), (second, last))
    assert case.run("last") is last
    with pytest.raises(InputError, match="did you mean 'last'"):
        case.run("lst")
    with pytest.raises(InputError, match="holds no samples"):
        first.window(50, 60)
    assert len(first.window(2.0, 4.0)) == 4


def test_a_case_knows_its_model(tmp_path: Path) -> None:
    s = signals()
    for name in ("a.csv", "b.csv"):
        write(tmp_path, name, **s)
    runs = "\n".join(f'[[run]]\nfile = "{n}.csv"\nrole = "{role}"\nbelt_speed = 0.1' for n, role in
                     (("a", "train"), ("b", "validate")))  # fmt: skip
    case = load_case(write_case(tmp_path, "[noise]\nx1 = 0.02\n[friction]\nT_s_plus = 3.5\n" + runs).parent)
    assert isinstance(case, Case)
    assert case.rig == Rig.from_si(**SI)
    assert case.friction == PaperFriction(T_s_plus=3.5)
    assert case.title == tmp_path.name
    model = case.model(friction=CoulombFriction())
    assert (model.rig, model.friction, model.noise) == (case.rig, CoulombFriction(), {"x1": 0.02})
    model.save(tmp_path / "model.toml")
    again = load_model(tmp_path / "model.toml")
    assert again == model
    forecast = load_recording(tmp_path / "b.csv", again.rig, channels=again.channels, noise=again.noise)
    np.testing.assert_array_equal(forecast.x1, case.runs[1].x1)
    assert forecast.noise == case.runs[1].noise


def test_clean_noise_is_not_reported(tmp_path: Path) -> None:
    rng = np.random.default_rng(1)
    s = signals(2500)
    for name in ("x1", "y1", "belt"):
        s[name] = s[name] + 1e-3 * rng.standard_normal(2500)
    run = load_recording(
        write(tmp_path, **s), ND, belt_speed=0.1, noise={"x1": 1e-3}, friction=PaperFriction()
    )
    assert run.findings == ()


def test_gaps_and_irregular_times(tmp_path: Path) -> None:
    s = {name: np.delete(column, np.r_[50:60, 120]) for name, column in signals().items()}
    s["t"][80] += 0.003
    run = load_recording(write(tmp_path, **s), ND, belt_speed=0.1)
    assert kinds(run) == [FindingKind.GAP, FindingKind.IRREGULAR]
    gap, irregular = run.findings
    assert "2 gap(s), 11 sample(s) missing, the first from 0.49 to 0.6" in gap.message
    assert gap.samples == (49, 109)
    assert irregular.samples == (80, 81)
    assert len(run) == 189  # usable all the same


def test_clipped_channel(tmp_path: Path) -> None:
    s = signals(2000)
    s["x1"] = np.clip(s["x1"] + 1e-3 * np.random.default_rng(2).standard_normal(2000), -0.25, 1.0)
    run = load_recording(write(tmp_path, **s), ND, belt_speed=0.1)
    assert kinds(run) == [FindingKind.CLIPPED]
    assert "lowest value -0.25" in run.findings[0].message
    assert set(run.findings[0].samples) == set(np.flatnonzero(s["x1"] == -0.25).tolist())


def test_quantised_channel(tmp_path: Path) -> None:
    s = signals(2000)
    rng = np.random.default_rng(3)
    s["y1"] = 0.004 * np.round((s["y1"] + 4e-3 * rng.standard_normal(2000)) / 0.004)
    run = load_recording(write(tmp_path, **s), ND, belt_speed=0.1)
    assert kinds(run) == [FindingKind.QUANTISED]
    assert "y1: quantised in steps of 0.004" in run.findings[0].message


def test_dead_channel_and_belt_off_its_set_point(tmp_path: Path) -> None:
    s = signals()
    s["y1"] = np.full(200, 0.7)
    run = load_recording(write(tmp_path, **s), ND, belt_speed=100.0)
    assert kinds(run) == [FindingKind.CONSTANT, FindingKind.BELT]
    assert "averages 0.1 , its set-point is 100" in run.findings[1].message.replace("  ", " ")
    assert FindingKind.BELT in kinds(load_recording(tmp_path / "run.csv", ND, belt_speed=-0.1))


def test_glitch(tmp_path: Path) -> None:
    s = signals(1000)
    s["x1"] = s["x1"] + 1e-3 * np.random.default_rng(4).standard_normal(1000)
    s["x1"][321] += 0.1
    run = load_recording(write(tmp_path, **s), ND, belt_speed=0.1)
    assert kinds(run) == [FindingKind.GLITCHES]
    assert run.findings[0].samples == (321,)


def test_wrong_length_unit_is_of_absurd_size(tmp_path: Path) -> None:
    """The right dimension and the wrong unit: metres declared for millimetres."""
    s = signals()
    file = write(tmp_path, **s)
    rig = Rig.from_si(**SI)
    for unit, expected in (("mm", []), ("m", [FindingKind.SIZE]), ("nm", [FindingKind.SIZE])):
        channels = {"t": Channel("t", "s"), "x1": Channel("x1", unit), "y1": Channel("y1", "mm")}
        run = load_recording(file, rig, channels=channels, friction=PaperFriction())
        assert kinds(run) == expected, unit


def test_a_million_rows_load_fast(tmp_path: Path) -> None:
    n = 1_000_000
    lines = b"0.1234567,-0.7654321\n" * n
    t = "\n".join(f"{1e-3 * i:.3f}" for i in range(n)).encode().split(b"\n")
    rows = b"\n".join(a + b"," + b for a, b in zip(t, lines.split(b"\n"), strict=False))
    (tmp_path / "run.csv").write_bytes(b"t,x1,y1\n" + rows)
    start = time.perf_counter()
    run = load_recording(tmp_path / "run.csv", ND)
    assert time.perf_counter() - start < 10  # 1 s here; row by row it would be a minute
    assert len(run) == n


def test_the_shipped_example() -> None:
    assert "paper_slider" in examples()
    case = load_case(example())
    assert case.rig == BlockOnBelt(mass=0.0307, stiffness=168)
    assert [(run.role, len(run)) for run in case.runs] == [("train", 16821), ("validate", 11900)]
    run = case.runs[0]
    assert run.belt_speed == pytest.approx(1.1e-3)
    # the slider's weight is m g; the spring pulls it with 23 % to 46 % of that
    np.testing.assert_allclose(
        [run.raw["spring_force"].min(), run.raw["spring_force"].max()], [0.232, 0.461], atol=1e-3
    )
    np.testing.assert_allclose(run.x1 * 168, run.raw["spring_force"] * 0.0307 * 9.81, rtol=1e-9)
    found = {finding.kind: finding for finding in run.findings}
    assert set(found) == {FindingKind.QUANTISED, FindingKind.GLITCHES}
    assert (example() / "LICENSE.CeCILL-B.txt").is_file()
    with pytest.raises(InputError, match="did you mean 'paper_slider'"):
        example("paper_slide")


def test_the_example_slides_the_way_of_the_belt() -> None:
    """In stick the deflection grows at the belt's speed: the sign convention of `BlockOnBelt`."""
    run = load_case(example()).runs[0]
    step = 40
    speed = (run.x1[step:] - run.x1[:-step]) / (run.t[step:] - run.t[:-step])
    # far more of the time is spent loading than slipping back
    assert np.mean(speed > 0) > 0.65
    # nominal stiffness and gain: the plateau lies some 15 % above the belt's speed
    assert np.quantile(speed, 0.8) == pytest.approx(run.belt_speed, rel=0.2)


@needs_shared
@pytest.mark.parametrize("number", range(24))
def test_shared_cases_load_clean(number: int) -> None:
    case = load_case(SHARED / f"case_{number:02d}")
    assert [run.role for run in case.runs] == ["train"] * 6 + ["validate"] * 2
    assert all(len(run) == 2501 for run in case.runs)
    assert all(0.05 < abs(run.belt_speed) < 0.25 for run in case.runs)
    assert case.findings == ()


@needs_shared
@pytest.mark.parametrize("number", range(24))
def test_shared_cases_scale_to_the_truth(number: int) -> None:
    answer = json.loads((SHARED / "answers.json").read_text())["cases"][number]
    case = load_case(SHARED / f"case_{number:02d}")
    rig, truth, scales = case.rig, answer["rig"], answer["scales"]
    assert isinstance(rig, Rig)
    pairs = {"alpha1": "a1", "alpha2": "a2", "beta3": "b3", "eta1": "e1", "eta12": "e12"}
    for name, key in pairs.items():
        assert getattr(rig, name) == pytest.approx(truth[key], rel=1e-9)
    if scales["on"]:
        assert rig.scales is not None
        found = [rig.scales.length, rig.scales.omega, rig.scales.k2, rig.scales.r]
        np.testing.assert_allclose(found, [scales[key] for key in ("L", "w", "k2", "r")], rtol=1e-9)
    np.testing.assert_allclose(list(case.runs[0].noise.values()), answer["noise"], rtol=1e-3)
