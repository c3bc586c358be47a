"""What may be hidden in a drawn case: the listed effects, effects outside the list, and their usual sizes.

A listed effect's parameters carry the report's names; ``fields`` maps them to the numbers of `rigsim`. A
range ``(low, high)`` is drawn log-uniformly; ``signed`` gives either sign. Phases are drawn for each run and
are not scored.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np


@dataclass(frozen=True)
class Kind:
    """One effect: where it acts, what it depends on, its numbers and how they are drawn."""

    where: str
    depends_on: tuple[str, ...]
    fields: Mapping[str, str]
    ranges: Mapping[str, tuple[float, float]]
    signed: tuple[str, ...] = ()
    phase: str = ""
    reading: bool = False  # acts on a reading, not on the motion
    absorbed: bool = False  # whole by the friction law, whatever the runs: never drawn
    also_where: tuple[str, ...] = field(default=())  # places a report may fairly name instead
    also_depends_on: tuple[str, ...] = field(default=())  # variables a report may fairly name instead

    def draw(self, rng: np.random.Generator) -> dict[str, float]:
        """Parameters of one case."""
        values = {}
        for name, (low, high) in self.ranges.items():
            value = float(np.exp(rng.uniform(np.log(low), np.log(high))))
            values[name] = -value if name in self.signed and rng.random() < 0.5 else value
        return values


def _same(prefix: str, *names: str) -> dict[str, str]:
    return {name: f"{prefix}_{name}" for name in names}


LISTED: dict[str, Kind] = {
    "block_viscous_damping": Kind("block", ("x2",), {"c": "block_c"}, {"c": (0.5, 1.4)}),
    "block_quadratic_damping": Kind("block", ("x2",), {"c": "block_cq"}, {"c": (3.0, 9.0)}),
    "spring_cubic_k1": Kind("block", ("x1",), {"k": "k1_cubic"}, {"k": (9.0, 27.0)}),
    "spring_cubic_k2": Kind("both", ("x1", "y1"), {"k": "k2_cubic"}, {"k": (7.0, 22.0)}),
    "spring_cubic_k3": Kind("angle_body", ("y1",), {"k": "k3_cubic"}, {"k": (16.0, 48.0)}),
    "spring_gap_k3": Kind(
        "angle_body", ("y1",), _same("gap", "k", "d"), {"k": (4.5, 13.0), "d": (0.03, 0.07)}
    ),
    "constant_load": Kind("block", (), {"f": "load"}, {"f": (0.2, 0.6)}, ("f",), absorbed=True),
    "harmonic_forcing": Kind(
        "block", ("t",), _same("force", "a", "w"), {"a": (0.18, 0.6), "w": (1.3, 4.0)}, phase="force_phi"
    ),
    "pivot_dry_friction": Kind("angle_body", ("y2",), {"f": "pivot_f"}, {"f": (0.06, 0.2)}),
    "normal_force_feedback": Kind(
        "contact", ("y1", "y2"), _same("nf", "beta2", "eta2"), {"beta2": (0.5, 1.3), "eta2": (0.12, 0.4)}
    ),
    "stribeck_peak": Kind(
        "contact", ("v_w",), {"dT": "peak_dT", "v_s": "peak_vs"}, {"dT": (0.45, 1.2), "v_s": (0.013, 0.035)}
    ),
    "static_aging": Kind(
        "contact", ("memory",), _same("aging", "dT", "tau"), {"dT": (0.7, 1.8), "tau": (0.8, 2.5)}
    ),
    "friction_memory": Kind("contact", ("memory",), {"tau": "memory_tau"}, {"tau": (0.035, 0.1)}),
    "friction_drift": Kind("contact", ("t",), {"r": "drift_r"}, {"r": (0.0006, 0.002)}, ("r",)),
    "belt_seam": Kind(
        "contact",
        ("t", "x1"),
        _same("seam", "a", "L"),
        {"a": (0.05, 0.15), "L": (1.6, 4.0)},
        phase="seam_phi",
    ),
    "contact_compliance": Kind(
        "contact", ("memory",), _same("bristle", "k", "c"), {"k": (220.0, 650.0), "c": (0.25, 1.0)}
    ),
    "belt_speed_ripple": Kind(
        "belt", ("t",), _same("ripple", "a", "w"), {"a": (0.06, 0.2), "w": (2.5, 9.0)}, phase="ripple_phi"
    ),
    "belt_load_droop": Kind(
        "belt", ("memory",), _same("droop", "k", "tau"), {"k": (0.002, 0.007), "tau": (0.45, 1.7)}
    ),
    "sensor_lag": Kind("x1 channel", ("memory",), {"tau": "lag_tau"}, {"tau": (0.1, 0.35)}, reading=True),
    "sensor_delay": Kind(
        "y1 channel", ("memory",), {"delay": "delay"}, {"delay": (0.06, 0.22)}, reading=True
    ),
    "sensor_crosstalk": Kind("x1 channel", ("y1",), {"c": "crosstalk_c"}, {"c": (0.08, 0.28)}, reading=True),
    "sensor_nonlinearity": Kind(
        "x1 channel", ("x1",), {"q": "nonlinear_q"}, {"q": (0.1, 0.35)}, reading=True
    ),
    "sensor_drift": Kind(
        "x1 channel", ("t",), {"r": "drift_x1"}, {"r": (0.0004, 0.0012)}, ("r",), reading=True
    ),
}
"""The effects of the list, under the names a report uses."""

MISDECLARED: dict[str, Kind] = {
    "rig_mass": Kind("block", (), {}, {"e": (0.06, 0.25)}, ("e",)),
    "rig_stiffness": Kind("block", (), {}, {"e": (0.06, 0.25)}, ("e",)),
}
"""Constants of a block on a belt that are not as declared, under the names a report uses: true over declared less 1."""

UNLISTED: dict[str, Kind] = {
    "block_quadratic_spring": Kind("block", ("x1",), {"k": "spring_quadratic"}, {"k": (2.5, 7.0)}, ("k",)),
    "block_end_stop": Kind("block", ("x1",), _same("stop", "k", "x"), {"k": (6.0, 16.0), "x": (0.12, 0.2)}),
    "block_soft_spring": Kind("block", ("x1",), _same("tanh", "k", "d"), {"k": (0.3, 0.8), "d": (0.03, 0.1)}),
    "block_magnetic_detent": Kind(
        "block",
        ("x1",),
        {"a": "detent_a", "k": "detent_k", "phi": "detent_phi"},
        {"a": (0.2, 0.5), "k": (18.0, 40.0), "phi": (0.1, 6.0)},
    ),
    "block_cubic_damping": Kind("block", ("x2",), {"c": "block_cubic_c"}, {"c": (15.0, 45.0)}),
    "block_one_way_damping": Kind("block", ("x2",), {"c": "block_asym_c"}, {"c": (1.2, 3.0)}),
    "block_hysteretic_spring": Kind(
        "block",
        ("memory",),
        _same("hyst", "k", "d"),
        {"k": (4.0, 12.0), "d": (0.03, 0.08)},
        also_depends_on=("x1", "x2"),
    ),
    "block_pulsating_stiffness": Kind(
        "block", ("t", "x1"), _same("stiff", "a", "w"), {"a": (1.0, 3.0), "w": (1.3, 4.0)}, phase="stiff_phi"
    ),
    "angle_quadratic_damping": Kind("angle_body", ("y2",), {"c": "angle_cq"}, {"c": (2.0, 6.0)}),
    "angle_cubic_damping": Kind("angle_body", ("y2",), {"c": "angle_cubic_c"}, {"c": (18.0, 60.0)}),
    "angle_quadratic_spring": Kind("angle_body", ("y1",), {"k": "angle_spring_q"}, {"k": (3.0, 9.0)}, ("k",)),
    "angle_harmonic_forcing": Kind(
        "angle_body",
        ("t",),
        _same("angle_force", "a", "w"),
        {"a": (0.08, 0.3), "w": (1.3, 4.0)},
        phase="angle_force_phi",
    ),
    "contact_worn_patch": Kind(
        "contact",
        ("x1",),
        {"a": "patch_a", "x0": "patch_x0", "w": "patch_w"},
        {"a": (0.12, 0.35), "x0": (0.1, 0.22), "w": (0.03, 0.08)},
        ("a", "x0"),
    ),
    "contact_load_by_x1": Kind("contact", ("x1",), {"a": "load_x1"}, {"a": (0.15, 0.5)}, ("a",)),
    "contact_load_by_y1_squared": Kind("contact", ("y1",), {"a": "load_y1sq"}, {"a": (5.0, 15.0)}, ("a",)),
    "contact_speed_bump": Kind(
        "contact",
        ("v_w",),
        {"a": "bump_a", "u": "bump_u", "w": "bump_w"},
        {"a": (0.4, 1.0), "u": (0.08, 0.16), "w": (0.02, 0.05)},
        ("a",),
    ),
    "contact_viscous": Kind("contact", ("v_w",), {"c": "viscous_c"}, {"c": (1.0, 3.0)}),
    "contact_warm_up": Kind(
        "contact", ("t",), _same("warm", "a", "tau"), {"a": (0.06, 0.18), "tau": (8.0, 25.0)}, ("a",)
    ),
    "contact_wandering_friction": Kind("contact", ("t",), {"a": "wander_a"}, {"a": (0.02, 0.06)}),
    "belt_square_wave": Kind(
        "belt",
        ("t",),
        _same("belt_square", "a", "w"),
        {"a": (0.08, 0.2), "w": (0.8, 3.0)},
        phase="belt_square_phi",
    ),
    "belt_warm_up": Kind(
        "belt", ("t",), _same("belt_warm", "a", "tau"), {"a": (0.08, 0.25), "tau": (8.0, 25.0)}, ("a",)
    ),
    "y1_saturation": Kind("y1 channel", ("y1",), {"y": "y1_saturation"}, {"y": (0.12, 0.25)}, reading=True),
    "y1_quadratic": Kind(
        "y1 channel", ("y1",), {"q": "y1_quadratic"}, {"q": (0.3, 1.0)}, ("q",), reading=True
    ),
    "y1_crosstalk": Kind(
        "y1 channel", ("x1",), {"c": "y1_crosstalk"}, {"c": (0.05, 0.2)}, ("c",), reading=True
    ),
    "x1_cubic": Kind("x1 channel", ("x1",), {"q": "x1_cubic"}, {"q": (0.5, 1.5)}, reading=True),
    "y1_lag": Kind("y1 channel", ("memory",), {"tau": "y1_lag_tau"}, {"tau": (0.1, 0.35)}, reading=True),
    "y1_drift": Kind("y1 channel", ("t",), {"r": "drift_y1"}, {"r": (0.0003, 0.001)}, ("r",), reading=True),
    "angle_viscous_damping": Kind("angle_body", ("y2",), {"c": "angle_c"}, {"c": (0.2, 0.6)}),
    "block_creep": Kind(
        "block",
        ("memory",),
        _same("maxwell", "k", "tau"),
        {"k": (1.5, 5.0), "tau": (0.5, 3.0)},
        also_depends_on=("x1", "x2"),
    ),
    "block_two_tones": Kind(
        "block", ("t",), _same("tones", "a", "w"), {"a": (0.08, 0.3), "w": (1.3, 4.0)}, phase="tones_phi"
    ),
    "contact_load_by_y2_squared": Kind("contact", ("y2",), {"a": "load_y2sq"}, {"a": (1.5, 5.0)}, ("a",)),
    "contact_quadratic_viscous": Kind("contact", ("v_w",), {"c": "viscous_cq"}, {"c": (3.0, 9.0)}),
    "belt_drift": Kind("belt", ("t",), {"r": "belt_drift_r"}, {"r": (0.001, 0.003)}, ("r",)),
}
"""Effects outside the list, with the truth on place and variable."""

READING_FIELDS = (
    "delay",
    "nonlinear_q",
    "drift_x1",
    "y1_saturation",
    "y1_quadratic",
    "y1_crosstalk",
    "x1_cubic",
    "drift_y1",
)
"""Numbers that act on readings only and that the simulator does not see."""

# Pairs that no data of this kind can hold apart, or that cancel: not drawn together.
FORBIDDEN_PAIRS = frozenset(
    frozenset(pair)
    for pair in (
        ("sensor_lag", "sensor_delay"),
        ("static_aging", "contact_compliance"),
        ("friction_memory", "contact_compliance"),
    )
)


def kind(name: str) -> Kind:
    """The effect of that name, listed or not."""
    return (LISTED | MISDECLARED | UNLISTED)[name]
