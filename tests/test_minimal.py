"""Is this install alive?"""

import pickle
import subprocess
import sys

import pytest

import stickslip as ss
from stickslip.simulated.instruction_set import check_instruction_set


def test_every_public_name_is_there() -> None:
    assert sorted(ss.__all__) == sorted(set(ss.__all__))
    assert all(hasattr(ss, name) for name in ss.__all__)


def test_names_shared_by_a_module_and_its_function_are_the_function() -> None:
    modules = "stickslip.simulated.simulate, stickslip.fitted.identify, stickslip.fitted.compare"
    code = (
        f"import {modules}, stickslip as ss; "
        + "assert all(callable(f) for f in (ss.simulate, ss.identify, ss.compare))"
    )
    subprocess.run([sys.executable, "-c", code], check=True)


def test_build_config_says_what_is_in_use() -> None:
    config = ss.build_config()
    assert config["version"] == ss.__version__
    assert config["isa"] in config["isa_compiled"]
    assert config["simd_width"] == {"baseline": 2, "avx2": 4, "avx512": 8}[config["isa"]]
    assert config["sanitize"] == ""
    assert {"compiler", "flags", "eigen", "pybind11"} <= set(config)


def test_a_narrower_instruction_set_can_be_asked_for_and_agrees() -> None:
    code = (
        "import stickslip as ss, pickle, sys\n"
        "rig = ss.Rig(alpha1=16, alpha2=8, beta3=4, eta1=0.1, eta12=0.2)\n"
        "run = ss.simulate(ss.Model(rig, friction=ss.PaperFriction()), belt_speed=0.1,"
        " initial=(0.1, 0.1, 0, 0), t_end=50)\n"
        "sys.stdout.buffer.write(pickle.dumps((ss.build_config()['isa'], run.transitions.t)))\n"
    )
    told = {}
    for isa in ss.build_config()["isa_compiled"]:
        result = subprocess.run(
            [sys.executable, "-c", code], env={"STICKSLIP_ISA": isa}, check=False, capture_output=True
        )
        if result.returncode:
            assert b"this machine lacks it" in result.stderr
            continue
        used, told[isa] = pickle.loads(result.stdout)
        assert used == isa
    for times in told.values():
        assert len(times) == len(told["baseline"]) > 4
        assert max(abs(times - told["baseline"])) < 1e-8


@pytest.mark.parametrize("isa", ["avx3", "AVX2"])
def test_an_instruction_set_that_is_none_is_refused(isa: str) -> None:
    result = subprocess.run(
        [sys.executable, "-c", "import stickslip"],
        env={"STICKSLIP_ISA": isa},
        check=False,
        capture_output=True,
        text=True,
    )
    line = f"STICKSLIP_ISA = '{isa}': unknown; it must be one of baseline, avx2, avx512"
    assert result.stderr.strip().endswith(line)


def test_an_instruction_set_that_cannot_be_had_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("STICKSLIP_ISA", "avx512")
    with pytest.raises(
        ss.InputError, match="'avx512': this machine lacks it; the widest that it has is avx2"
    ):
        check_instruction_set({"isa": "avx2", "isa_compiled": ["baseline", "avx2", "avx512"]})
    with pytest.raises(ss.InputError, match="'avx512': this build lacks it; it has baseline"):
        check_instruction_set({"isa": "baseline", "isa_compiled": ["baseline"]})


def test_a_command_starts_without_what_is_slow_to_import() -> None:
    slow = ("matplotlib", "pandas", "xarray", "scipy.signal", "scipy.stats", "scipy.optimize", "pint", "dask")
    code = f"import sys, stickslip.cli.commands; print([name for name in {slow} if name in sys.modules])"
    found = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert found.stdout.strip() == "[]"
