"""Do intervals of `identify` on driven sliders cover? Records of known truth, and what is said of one more effect.

    python bench/discovery/driven_coverage.py --seed 1 --cases 64 [--planted 16]

draws records as `driven.py` does, identifies each, and prints how often the 95 % intervals hold the truth, by how many
standard errors numbers are off, and how often the declared law is said not to explain the readings, or the mass not to
be as declared.
"""

from __future__ import annotations

import os
import tempfile
import time
from pathlib import Path

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import click
import numpy as np
from driven import DESIGN, wilson
from driven_draw import LEVELS, PLANTED, Drawn, draw, write

import stickslip as ss
from stickslip.fitted.identified import Identified

NAMES = ("mass", "damping", "kinetic", "kinetic_plus")


def identified(drawn: Drawn) -> Identified:
    """Identify one record, read from its file."""
    with tempfile.TemporaryDirectory() as folder:
        return ss.identify(ss.load_case(write(drawn, Path(folder))))


def off(drawn: Drawn, found: Identified) -> tuple[list[float], list[bool]]:
    """Standard errors by which every number is off, and whether its interval holds the truth."""
    slider, errors, held = drawn.slider, [], []
    for name, true in zip(NAMES, (slider.mass, slider.damping, slider.minus, slider.plus), strict=True):
        one = found.estimates[name]
        assert one.std is not None
        assert one.low is not None
        assert one.high is not None
        errors.append((one.value - true) / one.std)
        held.append(one.low <= true <= one.high)
    return errors, held


@click.command(help=__doc__)
@click.option("--seed", default=1, show_default=True)
@click.option("--cases", default=64, show_default=True)
@click.option("--planted", default=0, show_default=True)
def main(seed: int, cases: int, planted: int) -> None:
    """Run the bench."""
    names = ["" for _ in range(cases)] + [list(PLANTED)[i % len(PLANTED)] for i in range(planted)]
    errors, held, sent, seconds = [], [], {"": 0, "planted": 0}, []
    for i, name in enumerate(names):
        closed, coloured, level = DESIGN[i % len(DESIGN)]
        level = max(level, LEVELS[1]) if name else level
        rng = np.random.default_rng([seed, i])
        drawn = draw(rng, planted=name, closed=closed, coloured=coloured, level=level)
        began = time.process_time()
        found = identified(drawn)
        seconds.append(time.process_time() - began)
        mass = found.constants.get("mass")
        lacks = any("does not explain" in one for one in found.messages) or bool(mass and mass.beyond)
        sent["planted" if name else ""] += lacks
        z, inside = off(drawn, found)
        if not name:
            errors.append(z)
            held.append(inside)
        said = " ".join(f"{one:.1f}" for one in z)
        print(
            f"{i:3d} {name or 'nothing':18s} {drawn.words}: {said}{' lacks something' if lacks else ''}",
            flush=True,
        )
    if held:
        rms = np.sqrt(np.mean(np.square(errors), axis=0))
        for k, name in enumerate(NAMES):
            print(
                f"{name:13s} {np.mean(np.array(held)[:, k]):.3f} hold the truth, {rms[k]:.2f} standard errors off"
            )
        low, high = wilson(int(np.sum(held)), 4 * len(held))
        print(f"all           {np.mean(held):.3f} ({low:.3f} to {high:.3f})")
    print(
        f"sent to discover: {sent['']} of {cases} that lack nothing, {sent['planted']} of {planted} that do"
    )
    print(f"processor seconds: {np.median(seconds):.0f} in the median, {max(seconds):.0f} at most")


if __name__ == "__main__":
    main()
