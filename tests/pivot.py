"""The two-degree rig with friction in its pivot, as an effect and as a second contact of a rig of matrices."""

from __future__ import annotations

import stickslip as ss


def both_ways(size: float = 0.15) -> tuple[ss.Model, ss.Model]:
    """The named rig with the effect, and the same rig by its matrices."""
    law, pivot = ss.CoulombFriction(static=2, kinetic=1.2), ss.CoulombFriction(static=size, kinetic=size)
    rig = ss.Rig(alpha1=16, alpha2=8, beta3=4, eta1=0.1, eta12=0.2)
    named = ss.Model(rig, friction=law, effects=[ss.effect("pivot_dry_friction", f=size)])
    matrices = ss.MatricesRig(
        M=[[16, 0], [0, 8]],
        C=[[0.1, 0.1], [0.1, 0.2]],
        K=[[16, 1], [1, 4]],
        contact=[[1, 0], [0, 1]],
        against=["belt", "ground"],
        law=["block", "pivot"],
        unit="1",
    )
    return named, ss.Model(matrices, friction={"block": law, "pivot": pivot})  # type: ignore[arg-type]
