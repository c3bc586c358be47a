"""`discover` on rigs of bodies and matrices, against records of a simulator written apart."""

import json
from dataclasses import replace
from pathlib import Path

import jsonschema
import numpy as np
import pytest
from click.testing import CliRunner
from numpy.typing import NDArray

import stickslip as ss
from bodies_cases import CASES, recorded, recording
from bodies_files import written
from quick_figures import quickly
from stickslip.cli.commands import main
from stickslip.declared.uncertainty import Uncertainty
from stickslip.discovery.general_rig.bench import GeneralBench, bench_of, of_single_events
from stickslip.discovery.general_rig.kinds import Sizes
from stickslip.discovery.general_rig.result import GeneralFound
from stickslip.discovery.laboratory import search as search_of
from stickslip.discovery.laboratory import trials as trials_of
from stickslip.discovery.laboratory.hypothesis import label
from stickslip.discovery.laboratory.trials import Trial
from stickslip.discovery.result import Verdict
from stickslip.errors import InputError
from stickslip.likelihoods.fit import null
from stickslip.shown.report.places import unit_at, unit_of

Floats = NDArray[np.float64]
SCHEMA = Path(ss.__file__).parent / "shown" / "report" / "report.schema.json"
GAINS = np.array([1.0015, 0.9985])  # of a drill string's sensors, well within what is usual
HUM, PUSH = 62.0, 0.25  # rad/s and N


def bench(name: str, seed: int = 40, lasts: float = 5.0) -> GeneralBench:
    """A record with scatter, cut into windows."""
    case = CASES[name]()
    run = recording(case, *recorded(case, seed, level=0.02, static=0.02, lasts=lasts))
    return bench_of(case.model, [run], Uncertainty.usual(case.model.rig, channels=case.channels))


@pytest.fixture(scope="module")
def hummed(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A pin on a disc that something shakes across: no declared number says so. The report of the command."""
    folder = tmp_path_factory.mktemp("hum")
    runs = []
    for seed, (role, lasts) in enumerate((("train", 2.4), ("train", 2.4), ("validate", 2.0))):

        def shaken(t: float, _: Floats, phase: float = 1.0 + seed) -> Floats:
            return np.array([0.0, PUSH * np.sin(HUM * t + phase)])

        runs.append(
            (role, *recorded(CASES["pin"](), 50 + seed, level=0.02, static=0.02, lasts=lasts, more=shaken))
        )
    written(folder, runs)
    with pytest.MonkeyPatch.context() as patch:
        quickly(patch)
        said = CliRunner().invoke(main, ["discover", str(folder), "--out", str(folder / "found")])
    assert said.exit_code == 0, said.output
    assert "harmonic forcing of across" in said.output
    return folder


@pytest.mark.slow
def test_what_acts_is_named_at_its_place_with_an_interval_that_covers(hummed: Path) -> None:
    report = json.loads((hummed / "found" / "report.json").read_text())
    jsonschema.validate(report, json.loads(SCHEMA.read_text()))
    assert report["verdict"] == "effect_found"
    (one,) = report["effects"]
    assert (one["name"], one["where"]) == ("harmonic_forcing", "across")
    for name, true in (("a", PUSH), ("w", HUM)):
        number = one["parameters"][name]
        assert number["low"] < true < number["high"]
        assert number["high"] - number["low"] < 0.2 * true
    assert one["parameters"]["a"]["unit"] == "N"
    assert report["error"]["after"] < 0.8 * report["error"]["before"]
    assert report["error"]["floor"] < report["error"]["after"]
    for kind in ("kinetic", "static"):
        assert report["scatter"][kind]["value"] == pytest.approx(
            0.02 * (1 if kind == "kinetic" else 2**0.5), rel=0.4
        )
    assert report["declared"]["K_11"]["unit"] == "N/m"
    assert report["declared"]["K_11"]["runs"]["low"] < 800.0 < report["declared"]["K_11"]["runs"]["high"]


def test_other_commands_take_the_models(hummed: Path, tmp_path: Path) -> None:
    after = hummed / "found" / "model_after.toml"
    model = ss.load_model(after)
    assert [one.label for one in model.effects] == ["harmonic_forcing@across"]  # type: ignore[union-attr]
    run = ss.load_case(hummed).validate[0]
    plain = ss.compare(ss.load_model(hummed / "found" / "model_before.toml"), run)
    found = ss.compare(model, run)
    assert found.row("forecast error").simulated < 0.8 * plain.row("forecast error").simulated  # type: ignore[operator]
    out = tmp_path / "next.csv"
    said = CliRunner().invoke(
        main,
        ["forecast", str(after), str(hummed / "run_3.csv"), "--belt-speed", "50 mm/s", "--horizon", "100", "--out",
         str(out)],
    )  # fmt: skip
    assert said.exit_code == 0, said.output
    assert out.read_text().startswith("t,along,across,along_low,along_high")


@pytest.mark.study
def test_where_nothing_acts_nothing_is_named() -> None:
    """The angles grow to 10 rad: with gains that the runs do not have the twist, and all that follows, was wrong."""
    case = CASES["drill"]()

    def run(seed: int, role: str, lasts: float) -> ss.Recording:
        t, read = recorded(case, seed, level=0.02, static=0.02, lasts=lasts)
        return recording(case, t, GAINS * read, role=role)

    runs = [run(60, "train", 5.0), run(61, "train", 5.0), run(62, "validate", 5.0)]
    found = ss.discover(runs, friction=case.model.friction)  # type: ignore[arg-type]
    assert isinstance(found, GeneralFound)
    assert found.verdict is Verdict.no_effect
    assert found.effects == ()
    assert found.error.after == found.error.before < 0.02
    assert found.gate.observed < found.gate.threshold
    assert found.residual_after.chi2 == pytest.approx(1.0, abs=0.1)


def test_effects_stand_at_every_place_that_has_what_they_act_on() -> None:
    names = {label(one) for one in bench("drill").kinds()}
    assert {"spring_cubic_k1@link_1", "spring_cubic_k1@link_2", "sensor_lag@table", "sensor_lag@bit"} <= names
    assert {"belt_speed_ripple@drive", "belt_seam@bit", "harmonic_forcing@table"} <= names
    assert "block_viscous_damping@link_1" in names  # a declared damping goes as far as twice of what it is
    assert not any(
        one.startswith(("constant_load", "spring_cubic_k2", "contact_compliance")) for one in names
    )
    assert "block_quadratic_damping@bit" not in names  # what the bit rubs on is the ground: friction by speed
    chain = {label(one) for one in bench("chain", lasts=8.0).kinds()}
    assert {"belt_seam@a", "belt_seam@c", "block_viscous_damping@link_4", "belt_speed_ripple"} <= chain


def test_bounds_are_in_the_units_of_the_place() -> None:
    own = bench("drill", lasts=12.0)
    kinds = {label(one): one for one in own.kinds()}
    cubic = kinds["spring_cubic_k1@link_1"].parameter("k")
    sizes = Sizes(own.model, own.data)
    assert (
        1.0 < sizes.deflection(0) / (2.0 / 12.0) < 2.0
    )  # static friction over stiffness, and what swings beyond
    # in numbers like those of (2.1) the spring's force is 5 at 5/16: 200 is 200 * 5 (5/16)^2/5 of it
    share = cubic.spread / 12.0 * sizes.deflection(0) ** 2  # type: ignore[operator]
    assert share == pytest.approx(200 * (5 / 16) ** 3 / 5, rel=1e-6)
    assert cubic.unit == pytest.approx(cubic.spread / 200.0)  # type: ignore[operator]
    tau = kinds["sensor_lag@bit"].parameter("tau")
    assert tau.sought == pytest.approx([x * own.data[0].periods[0] / (2 * np.pi) for x in (0.004, 3.0)])
    rig = own.model.rig
    assert unit_at(rig, "spring_cubic_k1", "link_1", "k") == "N m/rad^3"  # type: ignore[arg-type]
    assert unit_at(rig, "sensor_drift", "bit channel", "r") == "rad/s"  # type: ignore[arg-type]
    assert unit_of(rig, "bit.inertia") == "kg m^2"  # type: ignore[arg-type]


def test_windows_that_hold_two_events_are_left_out() -> None:
    own = bench("pin", lasts=3.0)
    fit = null(own.windows(), own.policy)
    assert of_single_events(own, fit) is own
    cut = own.stretches
    joined = [*cut[:-2], type(cut[0])(0, cut[-2].start, cut[-1].stop, cut[-2].modes, cut[-2].dwell)]
    wide = GeneralBench(own.model, own.data, joined, own.declared, own.policy)
    kept = of_single_events(wide, null(wide.windows(), own.policy))
    assert kept.stretches == joined[:-1]


def test_too_short_a_record_is_refused() -> None:
    case = CASES["pin"]()
    runs = [
        recording(case, *recorded(case, 70, lasts=1.0)),
        recording(case, *recorded(case, 71, lasts=1.0), role="validate"),
    ]
    with pytest.raises(InputError, match="12 are needed to see how friction scatters"):
        ss.discover(runs, friction=case.model.friction)  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("rows", "said"), [((50, 115), "is too short to be forecast"), ((0, 10), "has 10 samples; at least 60")]
)
def test_too_short_a_validate_run_is_refused_before_the_search(
    tmp_path: Path, rows: tuple[int, int], said: str
) -> None:
    """The search was made first; of a few samples the run was not named."""
    command = CliRunner().invoke
    assert command(main, ["example", "bodies", "--out", str(tmp_path)]).exit_code == 0
    file = tmp_path / "run_02.csv"
    head, *lines = file.read_text().splitlines()
    file.write_text("\n".join([head, *lines[slice(*rows)], ""]))
    result = command(main, ["discover", str(tmp_path), "--out", str(tmp_path / "found")])
    assert result.exit_code == 2
    assert f"run 'run_02' {said}" in result.output
    assert "scoring" not in result.output


def test_a_channel_that_never_changes_is_refused() -> None:
    """Sizes of effects there overflowed."""
    case = CASES["pin"]()
    t, read = recorded(case, 70, lasts=4.0)
    read[:, 1] = 0.0
    runs = [recording(case, t, read), recording(case, t, read, role="validate")]
    with pytest.raises(InputError, match=r"across.* reads the same at all times"):
        ss.discover(runs, friction=case.model.friction)  # type: ignore[arg-type]


def test_a_constant_beside_which_nothing_moves_is_no_finding(monkeypatch: pytest.MonkeyPatch) -> None:
    """Its fit went astray from a null that explained nothing, and the whole search was given up."""
    own = bench("pin", lasts=3.0)
    assert isinstance(own.model.rig, ss.MatricesRig)
    K = 1.3 * np.array(own.model.rig.K)
    rig = replace(own.model.rig, K=K)
    off = replace(
        own, model=ss.Model(rig, friction=own.model.friction), policy=replace(own.policy, most_effects=0)
    )
    base = Trial((), null(off.windows(), off.policy))
    known = Uncertainty.usual(rig, channels=("along", "across"))

    def fails(*_: object, **__: object) -> None:
        raise FloatingPointError

    monkeypatch.setattr(trials_of, "fitted", fails)
    assert search_of.search(off, known, lambda _: None, base=base).chosen is base
