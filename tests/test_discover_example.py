"""The numbers that docs/discovery.md gives of its example are those of the search."""

import re
import subprocess
import sys
from pathlib import Path

import pytest

import stickslip as ss

ROOT = Path(__file__).parent.parent


@pytest.mark.study
def test_the_example_of_the_page(tmp_path: Path) -> None:
    page = re.sub(r"\s+", " ", (ROOT / "docs" / "discovery.md").read_text(encoding="utf-8"))
    program = ROOT / "examples" / "discovery" / "aging.py"
    subprocess.run([sys.executable, program, tmp_path / "aging"], check=True)
    found = ss.discover(ss.load_case(tmp_path / "aging"))
    _overlay(found, tmp_path)
    (effect,) = found.effects
    assert effect.name == "static_aging"
    number = r"([\d.]+)"
    for name, form in (("dT", rf"dT = {number} \(95 %: {number} to {number}\)"),
                       ("tau", rf"tau = {number} \({number} to {number}\)")):  # fmt: skip
        shown = re.search(form, page)
        assert shown is not None
        one = effect.parameters[name]
        assert [float(text) for text in shown.groups()] == pytest.approx(
            [one.value, one.low, one.high], rel=1e-3
        )
    shown = re.search(
        rf"falls from {number} to {number} of the signal, and noise alone would leave {number}\.", page
    )
    assert shown is not None
    errors = [found.error.before, found.error.after, found.error.floor]
    assert [float(text) for text in shown.groups()] == pytest.approx(errors, rel=5e-3)
    proof = effect.evidence
    asked = (
        r"lowers -2 log likelihood by ([\d.]+), where ([\d.]+) is asked for; .* held out falls to ([\d.]+) of"
    )
    shown = re.search(asked, page)
    assert shown is not None
    assert [float(text.replace(" ", "")) for text in shown.groups()] == pytest.approx(
        [proof.delta_chi2, proof.threshold, proof.held_out_ratio], rel=5e-3
    )


def _overlay(found: ss.Found, folder: Path) -> None:
    """The page's overlay runs, and the model after stays with the recording over its first cycle."""
    (folder / "aging" / "found").mkdir(exist_ok=True)
    found.model.save(folder / "aging" / "found" / "model_after.toml")
    page = (ROOT / "docs" / "discovery.md").read_text(encoding="utf-8")
    (code,) = (one for one in re.findall(r"```python\n(.*?)```", page, re.DOTALL) if "load_model" in one)
    names: dict[str, object] = {}
    exec(code.replace('"aging', f'"{folder}/aging'), names)
    run, made = names["run"], names["made"]
    assert isinstance(made, ss.Trajectory)
    first = made.t < 6.0
    off = made.state[first, 0] - run.x1[first]  # type: ignore[attr-defined]
    assert float((off**2).mean() ** 0.5) < 0.1 * float(run.x1.std())  # type: ignore[attr-defined]
