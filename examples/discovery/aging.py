"""A rig whose static friction grows with the time at rest, which its model does not know: the case and the search.

python examples/discovery/aging.py FOLDER              # writes FOLDER/rig.toml and its runs
python examples/discovery/aging.py FOLDER --search     # and FOLDER/found, as `stickslip discover` does
python examples/discovery/aging.py FOLDER --search --figures docs/figures
"""

import argparse
import shutil
from pathlib import Path

import numpy as np

import stickslip as ss

RIG = {
    "m": 2.6, "J": 0.0174, "r": 0.08, "k1": 690.0, "k2": 45.0, "k3": 140.0, "c1": 0.28, "c2": 0.3, "length": 0.012
}  # fmt: skip
LAW = ss.PaperFriction(T_s_minus=6.1, T_s_plus=3.5, T_min_plus=0.95)
CAUSE = ss.effect("static_aging", dT=0.7, tau=2.2)
SPEEDS = {"train": (0.05, 0.09, 0.15, -0.06, -0.12), "validate": (0.07, -0.09)}  # of the model
NOISE, SAMPLES, STEP = 1e-3, 1500, 0.06


def write(folder: Path) -> None:
    """Simulate the runs and write the case."""
    folder.mkdir(parents=True, exist_ok=True)
    model = ss.Model(ss.Rig.from_si(**RIG), friction=LAW, effects=[CAUSE])
    scales, noise = model.rig.scales, np.random.default_rng(1)
    mm, s = 1e3 * scales.length, scales.time
    lines = [
        'title = "a rig whose static friction ages"',
        "",
        "[rig]",
        *(f"{k} = {v}" for k, v in RIG.items()),
    ]
    lines += ["", "[noise]", f"x1 = {NOISE * mm:.4g}", f"y1 = {NOISE * mm:.4g}"]
    runs = [(role, speed) for role, speeds in SPEEDS.items() for speed in speeds]
    t = STEP * np.arange(SAMPLES)
    for number, (role, speed) in enumerate(runs, 1):
        run = ss.simulate(model, belt_speed=speed, initial=(0.1, 0.1, 0, 0), t_end=t[-1], t_eval=t)
        readings = run.state[:, [0, 2]] + NOISE * noise.standard_normal((SAMPLES, 2))
        table, file = np.column_stack([s * t, mm * readings]), f"run_{number:02d}.csv"
        np.savetxt(folder / file, table, "%.7g", ",", header="t,x1,y1", comments="")
        lines += ["", "[[run]]", f'file = "{file}"', f'role = "{role}"']
        lines += [f'belt_speed = "{1e3 * scales.velocity * speed:.6g} mm/s"']
    units = {"t": "s", "x1": "mm", "y1": "mm"}
    lines += ["", "[channels]", *(f'{c} = {{ column = "{c}", unit = "{u}" }}' for c, u in units.items()), ""]
    (folder / "rig.toml").write_text("\n".join(lines), encoding="utf-8")


def main() -> None:
    """Write the case; search it; copy figures."""
    asked = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    asked.add_argument("folder", type=Path)
    asked.add_argument("--search", action="store_true")
    asked.add_argument("--figures", type=Path)
    told = asked.parse_args()
    if told.figures:
        told.figures.mkdir(parents=True, exist_ok=True)  # a search takes a minute: a bad path fails before it
    write(told.folder)
    if told.search:
        from stickslip.shown.report.write import write_report

        case = ss.load_case(told.folder)
        found = ss.discover(case, progress=print)
        write_report(found, case, told.folder / "found")
        for one in found.effects:
            print(one.name, one.parameters, one.evidence.sentence)
        print(f"error {found.error.before:.4f} -> {found.error.after:.4f}, floor {found.error.floor:.4f}")
    if told.figures:
        for name in ("ranking", "portrait"):
            shutil.copyfile(
                told.folder / "found" / "figures" / f"{name}.png", told.figures / f"discovery_{name}.png"
            )


if __name__ == "__main__":
    main()
