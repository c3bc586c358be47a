"""Long records are thinned before they are fitted: what is said of it, what it costs, and that the answers stay."""

from __future__ import annotations

import tracemalloc
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import stickslip as ss
from stickslip.declared.units import Channel
from stickslip.fitted.data import prepare
from stickslip.likelihoods.identify import identify
from stickslip.measured import thinning
from stickslip.measured.fit_window import half_apart
from stickslip.measured.recording import Recording
from stickslip.measured.thinning import How, thinned

RIG = ss.Rig(alpha1=16, alpha2=8, beta3=4, eta1=0.1, eta12=0.2)
BLOCK = ss.BlockOnBelt(mass=1.0, stiffness=1.0, damping=0.02)
NOISE = 1e-4


def moved(count: int, dt: float, start: tuple[float, ...] = (0.1, 0.1, 0, 0)) -> np.ndarray:
    """x1 and y1 without noise, (n, 2)."""
    model = ss.Model(RIG, friction=ss.PaperFriction())
    t = np.arange(count) * dt
    run = ss.simulate(model, belt_speed=0.1, initial=start, t_end=float(t[-1] + dt), t_eval=t)
    return run.state[:, [0, 2]]


def recording(x: np.ndarray, dt: float, rig: ss.Rig | ss.BlockOnBelt = RIG, **more: object) -> Recording:
    """A recording of displacements (n, c) at equal steps."""
    columns = {"t": np.arange(len(x)) * dt, **dict(zip(("x1", "y1"), x.T, strict=False))}
    return ss.load_recording(columns, rig, belt_speed=0.1, **more)  # type: ignore[arg-type]


@pytest.fixture(scope="module")
def clean() -> np.ndarray:
    """100 000 samples, 2 ms apart."""
    return moved(100_000, 0.002)


@pytest.fixture(scope="module")
def long(clean: np.ndarray) -> Recording:
    """The same as a sensor reads them."""
    noisy = clean + NOISE * np.random.default_rng(0).standard_normal(clean.shape)
    return recording(noisy, 0.002, noise={"x1": NOISE, "y1": NOISE})


def test_a_short_record_is_the_same_object(long: Recording) -> None:
    short = replace(long.window(0.0, 0.002 * 30_000))
    (got,), said = thinned([short], RIG)
    assert got is short
    assert said == ()


def test_means_are_means_of_readings_and_times(long: Recording, clean: np.ndarray) -> None:
    (got,), (said,) = thinned([long], RIG)
    k = said.neighbours
    assert said.how is How.MEAN
    assert k == 4
    assert got.averaged == k
    assert len(got) == said.kept == 25_000
    np.testing.assert_allclose(got.t, long.t.reshape(-1, k).mean(axis=1))
    np.testing.assert_allclose(got.x1, long.x1.reshape(-1, k).mean(axis=1), rtol=1e-12)
    np.testing.assert_allclose(got.raw["y1"], got.y1)
    assert got.noise["x1"] == pytest.approx(NOISE / 2)
    off = got.x1 - clean[:, 0].reshape(-1, k).mean(axis=1)
    assert np.std(off) == pytest.approx(NOISE / 2, rel=0.02)
    assert np.abs(np.corrcoef(off[:-1], off[1:])[0, 1]) < 0.02  # white as before
    assert str(said) == "recording: thinned: 4 neighbours averaged: 25000 samples for 100000"


def test_the_bend_within_a_mean_stays_below_half_its_noise(clean: np.ndarray) -> None:
    quiet = 1e-6
    noisy = clean + quiet * np.random.default_rng(1).standard_normal(clean.shape)
    (got,), said = thinned([recording(noisy, 0.002, noise={"x1": quiet, "y1": quiet})], RIG)
    k = said[0].neighbours if said else 1
    assert k == got.averaged < 4
    if k > 1:
        whole = len(clean) // k * k
        shift = clean[:whole].reshape(-1, k, 2).mean(axis=1) - clean[:whole].reshape(-1, k, 2)[
            :, k // 2 - 1 : k // 2 + 1
        ].mean(axis=1)
        assert np.quantile(np.abs(shift), 0.99) < 0.5 * quiet / np.sqrt(k)


@pytest.mark.parametrize("count", [2, 3, 7, 10])
def test_two_instants_stand_for_a_mean_of_a_cubic(count: int) -> None:
    at = np.arange(4 * count) * 0.1
    rows = at.reshape(-1, count).mean(axis=1)
    half = half_apart(rows, count)
    for power in range(4):
        both = 0.5 * ((rows - half) ** power + (rows + half) ** power)
        np.testing.assert_allclose(both, (at**power).reshape(-1, count).mean(axis=1), rtol=1e-12)


@pytest.mark.study
def test_a_thinned_record_gives_the_same_law(long: Recording, monkeypatch: pytest.MonkeyPatch) -> None:
    law = ss.PaperFriction()
    run = long.window(0.0, 0.002 * 50_000)
    monkeypatch.setattr(thinning, "UNTOUCHED", 15_000)
    short = identify(run, rig=RIG, friction=law)
    monkeypatch.setattr(thinning, "UNTOUCHED", 10**6)
    whole = identify(run, rig=RIG, friction=law)
    assert [one.neighbours for one in short.thinned] == [4]
    assert whole.thinned == ()
    assert any("4 neighbours averaged" in line for line in short.messages)
    assert short.to_dict()["thinned"][0]["how"] == "averaged"  # type: ignore[index]
    assert short.noise["x1"] == pytest.approx(whole.noise["x1"])
    seen = [n for n, one in whole.estimates.items() if one.status == "identified"]
    assert len(seen) >= 5
    for name in seen:
        ours, theirs = short.estimates[name], whole.estimates[name]
        assert ours.std is not None
        assert theirs.std is not None
        assert ours.std == pytest.approx(theirs.std, rel=0.05)
        assert abs(ours.value - theirs.value) < 0.2 * theirs.std, name  # all but the same readings


def test_a_glitch_is_found_before_it_is_averaged(long: Recording) -> None:
    x = np.array(long.x1)
    x[50_001] += 20 * NOISE
    (got,), _ = thinned([replace(long, x1=x)], RIG)
    (same,), _ = thinned([long], RIG)
    assert abs(got.x1[12_500] - same.x1[12_500]) < 2 * NOISE  # one in four of 20 would be 5


def test_missing_readings_make_no_means(long: Recording) -> None:
    x, y = np.array(long.x1), np.array(long.y1)
    x[40_000:44_000] = np.nan
    y[60_000:64_000] = y[60_000]
    (got,), (said,) = thinned([replace(long, x1=x, y1=y)], RIG)
    assert np.isnan(got.x1[10_000:11_000]).all()
    assert np.isnan(got.x1).sum() == 1000
    assert got.y1 is not None
    assert np.isnan(got.y1[15_001:16_000]).all()
    assert np.isnan(got.y1).sum() <= 1001
    assert len(said.left_out) == 1
    assert "y1 repeats one reading over 3999 samples" in said.left_out[0]
    data = prepare([got])[0]
    assert (data.weight[10_000:11_000, 0] == 0).all()
    assert (data.weight[15_001:16_000, 1] == 0).all()


def test_no_mean_is_taken_across_a_gap(long: Recording) -> None:
    kept = np.ones(len(long), dtype=bool)
    kept[30_002:45_002] = False
    cut = replace(long, t=long.t[kept], x1=long.x1[kept], y1=np.asarray(long.y1)[kept], raw={})
    (got,), (said,) = thinned([cut], RIG)
    k = said.neighbours
    assert said.samples == 85_000
    assert len(got) == 85_000 // k - 1
    assert np.diff(got.t).max() > 15_000 * 0.002


def test_coarse_readings_are_picked_not_averaged(clean: np.ndarray) -> None:
    step = 1e-3
    noisy = clean + 1e-4 * np.random.default_rng(2).standard_normal(clean.shape)
    coarse = np.round(noisy / step) * step
    run = recording(coarse, 0.002)
    (got,), (said,) = thinned([run], RIG)
    assert said.how is How.ONE
    assert got.averaged == 1
    np.testing.assert_array_equal(got.t, run.t[:: said.neighbours])
    there = np.isfinite(got.x1)
    np.testing.assert_array_equal(got.x1[there], run.x1[:: said.neighbours][there])
    assert there.mean() > 0.99


def test_noise_that_is_alike_from_sample_to_sample_falls_less(clean: np.ndarray) -> None:
    white = np.random.default_rng(3).standard_normal((len(clean) + 1, 2))
    alike = NOISE * (white[1:] + white[:-1]) / np.sqrt(2)
    run = recording(clean + alike, 0.002, noise={"x1": NOISE, "y1": NOISE})
    (got,), (said,) = thinned([run], RIG)
    k = said.neighbours
    means = alike.reshape(-1, k, 2).mean(axis=1)
    assert got.noise["x1"] == pytest.approx(float(np.std(means[:, 0])), rel=0.15)
    assert got.noise["x1"] > 1.15 * NOISE / np.sqrt(k)


def test_what_is_longer_than_can_be_fitted_keeps_its_beginning(long: Recording) -> None:
    (got, other), said = thinned([long, long], RIG, most=20_000)
    assert len(got) == len(other) == 10_000
    np.testing.assert_array_equal(
        got.t, thinned([long], RIG)[0][0].t[: len(got)] if said[0].neighbours == 4 else got.t
    )
    assert said[0].share == pytest.approx(10_000 * said[0].neighbours / 100_000, rel=1e-3)
    assert "of its first" in str(said[0])


def test_noise_of_runs_sampled_unequally_is_that_of_one_sensor(long: Recording) -> None:
    slow = recording(moved(4000, 0.02), 0.02)
    slow = replace(slow, x1=slow.x1 + NOISE * np.random.default_rng(4).standard_normal(4000))
    slow = replace(slow, y1=slow.y1 + NOISE * np.random.default_rng(5).standard_normal(4000))
    (quick, same), _ = thinned([replace(long, noise={}), replace(slow, noise={})], RIG)
    assert same.averaged == 1
    first, second = prepare([quick, same])
    assert first.noise[0] == pytest.approx(NOISE / 2, rel=0.1)
    assert second.noise[0] == pytest.approx(2 * first.noise[0], rel=1e-9)


@pytest.mark.study
def test_a_block_on_a_belt_is_thinned_too() -> None:
    model = ss.Model(BLOCK, friction=ss.CoulombFriction(static=1.0, kinetic=0.6))
    t = np.arange(45_000) * 0.002
    run = ss.simulate(model, belt_speed=0.1, initial=(0.0, 0.1), t_end=float(t[-1]), t_eval=t)
    x = run.state[:, :1] + 1e-3 * np.random.default_rng(6).standard_normal((len(t), 1))
    found = identify(recording(x, 0.002, BLOCK), rig=BLOCK, scatter=True)
    assert [one.neighbours for one in found.thinned] == [2]
    assert found.estimates["static"].value == pytest.approx(1.0, abs=0.01)
    assert found.estimates["kinetic"].value == pytest.approx(0.6, abs=0.01)


def test_a_driven_slider_keeps_its_readings() -> None:
    rig = ss.DrivenSlider(mass=1.0, damping=0.0)
    t = np.arange(40_000) * 1e-3
    columns = {"t": t, "x1": np.sin(t), "drive": np.cos(t)}
    units = {"t": "s", "x1": "m", "drive": "N"}
    channels = {name: Channel(name, unit) for name, unit in units.items()}
    run = ss.load_recording(columns, rig, channels=channels)
    (got,), said = thinned([run], rig)
    assert got is run
    assert said == ()
    (got,), said = thinned([run], rig, most=10_000)
    assert len(got) == 10_000
    assert got.drive is not None
    assert len(got.drive) == 10_000
    assert said[0].how is How.ALL


def written(folder: Path, x: np.ndarray, dt: float) -> Path:
    """A case of one long train run and a short one to validate on."""
    folder.mkdir()
    noisy = x + NOISE * np.random.default_rng(7).standard_normal(x.shape)
    for name, rows in (("a", slice(None)), ("b", slice(0, 3000))):
        table = np.column_stack([np.arange(len(x))[rows] * dt, noisy[rows]])
        np.savetxt(folder / f"{name}.csv", table, fmt="%.6f", delimiter=",", header="t,x1,y1", comments="")
    (folder / "rig.toml").write_text(
        "[rig]\nalpha1=16.0\nalpha2=8.0\nbeta3=4.0\neta1=0.1\neta12=0.2\n"
        + "".join(
            f'[[run]]\nfile="{f}.csv"\nrole="{role}"\nbelt_speed=0.1\n'
            for f, role in (("a", "train"), ("b", "validate"))
        )
        + "[channels]\n"
        + "".join(f'{c}={{column="{c}",unit="1"}}\n' for c in ("t", "x1", "y1"))
    )
    return folder


@pytest.mark.study
def test_reading_and_identification_cost_200_bytes_a_sample_beyond_the_columns(tmp_path: Path) -> None:
    x = moved(120_000, 0.002)
    sizes = (60_000, 120_000)
    folders = [written(tmp_path / str(n), x[:n], 0.002) for n in sizes]
    peaks = []
    for folder in (folders[0], *folders):  # the first pays for what is imported
        tracemalloc.start()
        case = ss.load_case(folder)
        read = tracemalloc.get_traced_memory()[1]
        identify(case)
        peaks.append((read, tracemalloc.get_traced_memory()[1]))
        tracemalloc.stop()
    columns = 2 * 3 * 8  # as read, and as the model's numbers
    for small, large in zip(*peaks[1:], strict=True):
        assert (large - small) / (sizes[1] - sizes[0]) < columns + 200
