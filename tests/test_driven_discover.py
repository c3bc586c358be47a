"""The loop for a driven slider: on records simulated in closed form, and on the public EMPS record if at hand."""

from __future__ import annotations

import json
import os
import re
from collections.abc import Callable
from functools import cache
from importlib.resources import files
from pathlib import Path

import jsonschema
import numpy as np
import pytest
import scipy
from click.testing import CliRunner

import driven_truth as truth
import stickslip as ss
from quick_figures import quickly
from stickslip.cli.commands import main
from stickslip.discovery.driven_slider.published import inverse_model, loop_errors, symmetric_model
from stickslip.discovery.result import Found
from stickslip.likelihoods.driven_slider.motion import Band, instant
from stickslip.simulated.driven_slider import Loop
from studies import few

SHARED = Path(os.environ.get("STICKSLIP_SHARED", Path(__file__).resolve().parents[2] / "shared"))
EMPS = SHARED / "data" / "emps" / "DATA_EMPS.mat"
needs_emps = pytest.mark.skipif(
    not EMPS.exists(), reason="DATA_EMPS.mat may not be passed on; put its folder's root in STICKSLIP_SHARED"
)


def test_the_band_is_one_filter_however_it_is_applied() -> None:
    taps = scipy.signal.firwin(61, 30.0, fs=500.0)
    over = Band(30.0, taps, 4)
    x = np.random.default_rng(0).standard_normal((400, 3))
    at = over.kept(400)
    np.testing.assert_allclose(over(x)[:, 0], np.convolve(x[:, 0], taps, mode="same")[at], atol=1e-12)
    t = np.arange(400) / 500
    slow = np.sin(2 * np.pi * 5 * t)
    np.testing.assert_allclose(over(slow), slow[at], atol=5e-3)  # no delay


def test_second_differences_become_accelerations() -> None:
    dt, w = 1e-3, 2 * np.pi * 80
    t = np.arange(200) * dt
    x = np.sin(w * t)
    mean = np.zeros_like(x)
    mean[1:-1] = np.diff(x, 2) / dt**2
    exact = -(w**2) * x
    inner = slice(5, -5)
    raw, ours = (np.max(np.abs(one[inner] - exact[inner])) / w**2 for one in (mean, instant(mean)))
    assert raw > 0.02
    assert ours < 0.003


NEAR = 0.25  # of the floor, which knows the law: 7 s of training leave some of it open
PHYSICS = {
    "nothing": {},
    "ripple": {"force": lambda x, _: 0.8 * np.sin(2 * np.pi * x / 0.004 + 1)},
    "late": {"delay": 1},
    "unlisted": {"friction": lambda x: 1 + 0.25 * np.sin(2 * np.pi * x / 0.35)},
}


Searched = Callable[[str], tuple[ss.Case, Found]]


@pytest.fixture(scope="module")
def searched(tmp_path_factory: pytest.TempPathFactory) -> Searched:
    """Make a record with nothing, a ripple, a late drive or an unlisted friction, and say what the loop makes of it."""

    @cache
    def of(name: str) -> tuple[ss.Case, Found]:
        folder = tmp_path_factory.mktemp(name)
        case = ss.load_case(truth.write_case(folder, seconds=11.6, train=7.0, **PHYSICS[name]))
        return case, ss.discover(case)

    return of


@pytest.mark.study
def test_nothing_is_named_where_nothing_is(searched: Searched) -> None:
    _, found = searched("nothing")
    assert found.verdict.value == "no_effect"
    assert found.effects == ()
    for name, true in (("damping", truth.DAMPING), ("kinetic", truth.MINUS), ("kinetic_plus", truth.PLUS)):
        one = found.law[name]
        assert one.low is not None
        assert one.high is not None
        assert abs(one.value - true) < one.high - one.low
        assert one.value == pytest.approx(true, rel=0.02)
    assert found.error.before == pytest.approx(found.error.floor, rel=NEAR)


@pytest.mark.slow
def test_a_ripple_is_found_with_its_wavelength(searched: Searched) -> None:
    _, found = searched("ripple")
    assert [one.name for one in found.effects] == ["position_ripple"]
    numbers = found.effects[0].parameters
    assert numbers["L"].value == pytest.approx(0.004, rel=1e-3)
    assert numbers["a"].value == pytest.approx(0.8, rel=0.05)
    (phase,) = found.effects[0].phases.values()
    assert phase == pytest.approx(1.0, abs=0.15)
    assert found.error.after < 0.5 * found.error.before
    assert found.error.after == pytest.approx(found.error.floor, rel=NEAR)
    proof = found.effects[0].evidence
    assert proof.delta_chi2 > 5 * proof.control


@pytest.mark.study
def test_a_late_drive_is_found(searched: Searched) -> None:
    _, found = searched("late")
    (effect,) = found.effects
    named = {effect.name, *(one.name for one in effect.alternatives if one.tied)}
    assert "drive_delay" in named
    value = next(iter(effect.parameters.values())).value
    assert value == pytest.approx(1 / truth.RATE, rel=0.2)


@pytest.mark.slow
def test_what_has_no_name_is_a_curve(searched: Searched) -> None:
    _, found = searched("unlisted")
    assert found.verdict.value == "unlisted_effect"
    (effect,) = found.effects
    assert (effect.name, effect.where, effect.depends_on) == ("unlisted", "contact", ("x1",))
    curve = effect.curve
    assert curve is not None
    true = 0.25 * np.sin(2 * np.pi * curve.x / 0.35)
    scale = 1 + curve.value - np.mean(curve.value)
    assert np.std(scale - (1 + true - np.mean(true))) < 0.03
    assert found.error.after < 0.3 * found.error.before
    again = found.after.toml()
    assert "tabulated" in again


@pytest.mark.slow
@pytest.mark.parametrize("name", few(PHYSICS, ["unlisted"]))
def test_the_report_holds_to_the_schema_and_the_models_load(
    searched: Searched, name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    schema = json.loads((files("stickslip.shown.report") / "report.schema.json").read_text(encoding="utf-8"))
    from stickslip.shown.report.write import write_report

    case, found = searched(name)
    if name != "unlisted":  # which has every figure
        quickly(monkeypatch)
    written = write_report(found, case, tmp_path / name)
    report = json.loads((tmp_path / name / "report.json").read_text())
    jsonschema.validate(report, schema)
    assert {"before", "after", "floor"} <= report["error"].keys()
    assert ss.load_model(tmp_path / name / "model_after.toml") == found.after
    page = (tmp_path / name / "report.html").read_text()
    assert "<svg" in page
    assert "http" not in re.sub(r"<script>.*?</script>|http://www.w3.org", "", page, flags=re.DOTALL)
    assert '<div class="live">' in page
    assert all(one.stat().st_size > 0 for one in written)


def test_the_command_line_refuses_what_it_cannot_search(tmp_path: Path) -> None:
    toml = truth.write_case(tmp_path)
    toml.write_text(
        toml.read_text()
        .replace('kind = "coulomb"', 'kind = "hyperbolic"')
        .replace("static = 6.0\nkinetic = 6.0", "scale = 6.0")
    )
    result = CliRunner().invoke(main, ["discover", str(toml), "--out", str(tmp_path / "out")])
    assert result.exit_code != 0
    assert "the law of a driven slider is coulomb" in result.output
    assert not (tmp_path / "out").exists()


@pytest.fixture(scope="module")
def emps() -> dict[str, np.ndarray]:
    return {k: v.ravel() for k, v in scipy.io.loadmat(EMPS).items() if not k.startswith("__")}


SYMMETRIC = {"M": 95.1089, "Fv": 203.5034, "Fc": 20.3935, "offset": -3.1648}
ASYMMETRIC = {
    "M": 95.1540,
    "Fv_plus": 166.7061,
    "Fc_plus": 20.1440,
    "Fv_minus": 240.4236,
    "Fc_minus": 20.6277,
}


@needs_emps
@pytest.mark.parametrize(
    ("asymmetric", "published", "error"), [(False, SYMMETRIC, 0.0408), (True, ASYMMETRIC, 0.0311)]
)
def test_the_published_fits_are_repeated(
    emps: dict[str, np.ndarray], asymmetric: bool, published: dict[str, float], error: float
) -> None:
    fit = inverse_model(emps["t"], emps["qm"], emps["gtau"] * emps["vir"], asymmetric=asymmetric)
    assert fit.parameters.keys() == published.keys()
    for name, value in published.items():
        assert fit.parameters[name] == pytest.approx(value, rel=5e-3), name
    assert abs(fit.relative_error - error) < 3e-3


@needs_emps
def test_the_simulated_loop_is_as_near_as_published(emps: dict[str, np.ndarray]) -> None:
    loop = Loop(float(emps["gtau"][0]), float(emps["kp"][0]), float(emps["kv"][0]))
    model = symmetric_model(SYMMETRIC)
    _, errors = loop_errors(model, loop, emps["t"], emps["qg"], emps["qm"], emps["vir"])
    assert errors.position < 2 * 0.0001375
    assert 0.5 * 0.00229 < errors.velocity < 2 * 0.00229
    assert 0.5 * 0.0860 < errors.acceleration < 2 * 0.0860
    assert 0.5 * 0.0585 < errors.force < 2 * 0.0585


@needs_emps
@pytest.mark.study
def test_the_loop_on_the_public_record(tmp_path: Path) -> None:
    toml = (Path(__file__).parents[1] / "examples" / "emps" / "rig.toml").read_text()
    (tmp_path / "rig.toml").write_text(toml)
    (tmp_path / "DATA_EMPS.mat").symlink_to(EMPS)
    found = ss.discover(ss.load_case(tmp_path, files_from=EMPS.parent))
    effects = {one.name: one for one in found.effects}
    assert {"viscous_asymmetry", "position_ripple"} <= effects.keys()
    assert effects.keys() & {"drive_delay", "drive_lag"}
    assert effects.keys() & {"viscous_saturation", "stribeck_peak"}
    assert effects["position_ripple"].parameters["L"].value == pytest.approx(0.0025, rel=2e-3)
    assert found.error.after < 0.5 * found.error.before
    assert found.error.after < 2 * found.error.floor
