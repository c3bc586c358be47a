"""Windows of several runs are simulated together: what comes of them is what comes of each run alone."""

import subprocess
import sys
from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import stickslip as ss
from stickslip import _core
from stickslip.discovery.workers import Workers
from stickslip.fitted.data import Data
from stickslip.likelihoods.belt_windows import BeltWindows
from stickslip.likelihoods.rig_windows import RigSensors
from stickslip.likelihoods.shared import Declared, SharedNumber
from stickslip.likelihoods.stretches import stretches
from stickslip.likelihoods.threads import side_by_side, threads
from stickslip.simulated.lowering import WIDTH, simulated_windows
from stickslip.simulated.states import COUNT
from test_rig_windows import EFFECTS, LAW, MODEL, RIG, recorded

PHASES = (0.4, 1.7, -0.9)


@pytest.fixture(scope="module")
def data() -> list[Data]:
    """Three runs at speeds of their own, one of them backward, with a channel of the belt."""
    runs = [replace(recorded(MODEL, v)[0], name=f"run{i}") for i, v in enumerate((0.1, 0.16, -0.12))]
    out = []
    for run in runs:
        belt = np.full((len(run.t), 1), run.belt_speed)
        readings = np.hstack([run.readings, belt])
        weight, noise = np.full_like(readings, run.weight[0, 0]), np.full(3, run.noise[0])
        held = np.zeros_like(readings, dtype=bool)
        out.append(replace(run, readings=readings, weight=weight, noise=noise, held=held))
    return out


def windows_of(data: list[Data], name: str, runs: range) -> BeltWindows:
    """Windows of some of the runs; each run has phases of its own."""
    effects = EFFECTS[name]
    model = ss.Model(RIG, friction=ss.PaperFriction(), effects=effects)
    numbers = [
        SharedNumber(n, float(np.log(model.parameters[n])), float(np.log(model.parameters[n])), 1.0, True)
        for n in LAW
    ]
    numbers += [SharedNumber(n, 0.002, 0.0, 0.01) for n in ("gain.x1", "gain.y1")]
    for one in effects:
        for k, v in one.parameters.items():
            if k == "phi":
                numbers += [
                    SharedNumber(f"{one.name}.phi", PHASES[r], 0.0, np.inf, run=i) for i, r in enumerate(runs)
                ]
            else:
                numbers.append(SharedNumber(f"{one.name}.{k}", v, v, np.inf))
    some = [data[r] for r in runs]
    return BeltWindows(model, some, stretches(some), numbers, Declared(), RigSensors())


def own_of(windows: BeltWindows) -> NDArray[np.float64]:
    """Numbers of the windows' own, off what the readings show."""
    own = windows.first()
    own[:, windows.begins :] += 0.01 * np.random.default_rng(1).normal(size=own[:, windows.begins :].shape)
    return own


@pytest.mark.parametrize("name", EFFECTS)
def test_runs_together_are_what_each_is_alone(data: list[Data], name: str) -> None:
    whole = windows_of(data, name, range(3))
    own = own_of(whole)
    columns = {(n.name, n.run): j for j, n in enumerate(whole.numbers)}
    together, motions = whole.blocks(whole.start, own), whole.motions(whole.start, own)
    for run in range(3):
        alone = windows_of(data, name, range(run, run + 1))
        members = whole.by_run[run]
        shared = [columns[n.name, None if n.run is None else run] for n in alone.numbers]
        others = [j for (_, r), j in columns.items() if r not in (None, run)]
        every = zip(
            members,
            alone.blocks(alone.start, own[members]),
            alone.motions(alone.start, own[members]),
            strict=True,
        )
        for i, block, motion in every:
            here = together[i]
            assert block is not None
            assert here is not None
            assert motion is not None
            own_motion = motions[i]
            assert own_motion is not None
            p = len(whole.numbers)
            size = np.abs(block).max(axis=(0, 1)) + 1.0
            found = np.concatenate([here[:, :, shared], here[:, :, p:]], axis=2)
            assert np.abs((found - block) / size).max() < 1e-6
            assert not here[:, :, others].any()  # phases of other runs
            np.testing.assert_allclose(own_motion.readings, motion.readings, rtol=0, atol=1e-9)


def test_some_of_the_windows_are_what_they_are_among_all(data: list[Data]) -> None:
    windows = windows_of(data, "ripple", range(3))
    own = own_of(windows)
    chosen = np.arange(len(own)) % 3 == 1
    every, some = windows.blocks(windows.start, own), windows.blocks(windows.start, own, chosen)
    for one, other, asked in zip(every, some, chosen, strict=True):
        assert (other is not None) == asked
        if other is not None:
            np.testing.assert_array_equal(one, other)


@pytest.mark.parametrize("kept", [(0,), (1,), (3, 0), (2,), ()])
def test_derivatives_of_some_states_are_what_they_are_among_all(
    data: list[Data], monkeypatch: pytest.MonkeyPatch, kept: tuple[int, ...]
) -> None:
    """States whose derivatives nobody asked for are sampled without them, and have the same values."""
    windows = windows_of(data, "memory", range(3))
    asked = dict[str, Any]()

    def simulated(_: object, **given: object) -> dict[str, object]:
        asked.update(given)
        raise KeyboardInterrupt

    own = own_of(windows)
    monkeypatch.setattr("stickslip.likelihoods.belt_point.simulated_windows", simulated)
    with pytest.raises(KeyboardInterrupt):
        windows.blocks(windows.start, own)
    made = [windows.made[i] for i in windows.batches[0]]
    every = simulated_windows(made, **asked | {"kept": np.arange(COUNT, dtype=np.int32)})
    some = simulated_windows(made, **asked | {"kept": np.array(kept, dtype=np.int32)})
    assert len(asked["seeds"]) > 12  # more than one group of them
    np.testing.assert_allclose(every["state"], some["state"], rtol=1e-13, atol=1e-14)
    np.testing.assert_allclose(every["slopes"][list(kept)], some["slopes"], rtol=1e-13, atol=1e-13)
    assert all(np.abs(every["slopes"][k]).max() > 0 for k in range(4))


def test_threads_change_nothing(data: list[Data]) -> None:
    windows = windows_of(data, "memory", range(3))
    own = own_of(windows)
    alone = windows.blocks(windows.start, own)
    with side_by_side(3):
        assert threads() == 3
        beside = windows.blocks(windows.start, own)
    assert threads() == 1
    for one, other in zip(alone, beside, strict=True):
        np.testing.assert_array_equal(one, other)


def test_no_more_is_computed_ahead_than_there_are_processes() -> None:
    begun: list[int] = []

    def told(item: int) -> int:
        begun.append(item)
        return item * item

    def items() -> Iterator[int]:
        yield from range(10)

    made = Workers(1).ahead(told, items())
    assert next(made) == 0
    assert next(made) == 1
    assert begun == [0, 1]


def test_what_is_needed_later_is_loaded_while_others_work() -> None:
    code = (
        "import sys\n"
        "from stickslip.discovery.workers import Workers\n"
        "Workers.load_later('stickslip.shown.report.files')\n"
        "workers = Workers(2)\n"
        "assert 'stickslip.shown.report.files' not in sys.modules\n"
        "print(workers.map(abs, [-1, -2]), 'stickslip.shown.report.files' in sys.modules)\n"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.split() == ["[1,", "2]", "True"]


def test_every_row_of_numbers_has_a_structure(data: list[Data]) -> None:
    windows = windows_of(data, "nothing", range(3))
    lowered = windows.lowered[0]
    asked = {
        "parameters": lowered.parameters[None],
        "set": np.zeros(1, dtype=np.int32),
        "initial": np.zeros((1, COUNT)),
        "contact": np.zeros(1, dtype=np.int32),
        "t": np.array([0.0, 0.1]),
        "offset": np.array([0, 2]),
        "rtol": 1e-6,
        "atol": 1e-8,
        "seeds": np.zeros((0, WIDTH + COUNT)),
        "column": np.zeros(0, dtype=np.int32),
        "columns": 0,
        "kept": np.zeros(0, dtype=np.int32),
        "max_transitions": 10,
        "max_steps": 1000,
    }
    assert len(_core.simulate_windows(structures=[lowered.structure], **asked)["state"]) == 2
    other = windows_of(data, "droop", range(1)).lowered[0].structure
    for wrong in ([], [lowered.structure] * 2):
        with pytest.raises(ValueError, match="structures must be one for each row of parameters"):
            _core.simulate_windows(structures=wrong, **asked)
    asked |= {"parameters": np.repeat(asked["parameters"], 2, axis=0)}
    with pytest.raises(ValueError, match="of one rig, law and effects"):
        _core.simulate_windows(structures=[lowered.structure, other], **asked)
