"""Rebuild the figures and numbers of docs/emps.md: python bench/emps_figures.py PATH/DATA_EMPS.mat"""

from __future__ import annotations

import os
import sys
import tempfile
from pathlib import Path

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

from scipy.io import loadmat

import stickslip as ss
from stickslip.discovery.driven_slider.published import inverse_model, loop_errors, symmetric_model
from stickslip.discovery.driven_slider.result import DrivenFound
from stickslip.shown.driven_slider.figures import drawn
from stickslip.shown.plot.curves import save_figure
from stickslip.simulated.driven_slider import Loop

ROOT = Path(__file__).resolve().parents[1]
KEPT = ("friction", "residual_in_time", "wavelengths", "weights")


def main(path: Path) -> None:
    """Print the numbers and write the figures."""
    data = {k: v.ravel() for k, v in loadmat(path).items() if not k.startswith("__")}
    t, x, command, goal = (data[k] for k in ("t", "qm", "vir", "qg"))
    gain, kp, kv = (float(data[k][0]) for k in ("gtau", "kp", "kv"))
    for asymmetric in (False, True):
        fit = inverse_model(t, x, gain * command, asymmetric=asymmetric)
        print({k: round(v, 4) for k, v in fit.parameters.items()}, f"{100 * fit.relative_error:.3f} %")
        if not asymmetric:
            loop = Loop(gain, kp, kv)
            print(
                "symmetric, simulated loop:",
                loop_errors(symmetric_model(fit.parameters), loop, t, goal, x, command)[1],
            )
    with tempfile.TemporaryDirectory() as folder:
        (Path(folder) / "rig.toml").write_text((ROOT / "examples" / "emps" / "rig.toml").read_text())
        (Path(folder) / "DATA_EMPS.mat").symlink_to(path.resolve())
        found = ss.discover(ss.load_case(folder, files_from=path.resolve().parent))
    assert isinstance(found, DrivenFound)
    for one in found.effects:
        numbers = {k: (f"{v.value:.5g}", f"{v.low:.5g}", f"{v.high:.5g}") for k, v in one.parameters.items()}
        tied = [a.name for a in one.alternatives if a.tied]
        proof = one.evidence
        print(
            one.name,
            numbers,
            f"{proof.delta_chi2:.0f} against {proof.control:.0f} of {proof.control_name};",
            tied,
            proof.sentence,
        )
    print(found.error.runs[0].rmse, found.gate.threshold, found.noise, found.cutoff, f"{found.seconds:.0f} s")
    print(
        "before", found.law_before, "after", found.law, found.residual_before.chi2, found.residual_after.chi2
    )
    for name, figure in drawn(found).items():
        if name in KEPT:
            save_figure(figure, ROOT / "docs" / "figures" / f"emps_{name}")


if __name__ == "__main__":
    main(Path(sys.argv[1]))
