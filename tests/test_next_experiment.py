"""The next experiment for rivals that are tied: what tells them apart, less what each run would fit anew."""

from pathlib import Path

import pytest

import stickslip as ss
from found_by_hand import found_lag
from scattering import RIG, case
from stickslip.declared.model import Model
from stickslip.discovery.next_experiment import next_experiments
from stickslip.discovery.result import Experiment
from stickslip.fitted.data import Data, prepare

LEVELS = ("T_s_minus", "A2")


@pytest.fixture(scope="module")
def data(tmp_path_factory: pytest.TempPathFactory) -> list[Data]:
    folder: Path = tmp_path_factory.mktemp("next")
    return prepare(ss.load_case(case(folder, (), 0.01, 0.0, 5)).train)


def menu(
    data: list[Data], other: ss.Effect, free: tuple[str, ...] = (), tau: float = 0.1
) -> tuple[Experiment, ...]:
    """Further runs between a lag of the sensor of x1 and another effect, under the name of the rival by hand."""
    rig, law = ss.Rig(**RIG), ss.PaperFriction()
    fitted = {
        frozenset({name}): Model(rig, friction=law, effects=(one,))
        for name, one in (("sensor_lag", ss.effect("sensor_lag", tau=tau)), ("sensor_delay", other))
    }
    return next_experiments(fitted, frozenset({"sensor_lag"}), data, (found_lag(),), free)


def test_rivals_that_read_unlike_are_told_by_the_runs_that_set_them_apart(data: list[Data]) -> None:
    """Both move the rig alike, what the sensors say differs: states would tell nothing."""
    found = menu(data, ss.effect("sensor_delay", delay=0.1))
    assert [one.separability for one in found] == sorted((one.separability for one in found), reverse=True)
    assert found[0].sufficient
    assert found[0].between == ("sensor_lag", "sensor_delay")


def test_rivals_that_read_alike_are_told_by_no_run(data: list[Data]) -> None:
    assert all(not one.sufficient for one in menu(data, ss.effect("sensor_lag", tau=0.1)))


def test_what_each_run_fits_anew_tells_nothing(data: list[Data]) -> None:
    cubic = ss.effect("spring_cubic_k1", k=0.3)
    held, free = (menu(data, cubic, names, tau=1e-6) for names in ((), LEVELS))
    by_what = {one.what: one.separability for one in held}
    assert all(one.separability < by_what[one.what] for one in free)
