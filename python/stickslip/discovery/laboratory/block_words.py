"""What is said beside the verdict on a block on a belt."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from stickslip.declared.effect import CONSTANTS
from stickslip.discovery.result import Alternative, Experiment, FoundEffect
from stickslip.fitted.block_events.table import Measured
from stickslip.measured.recording import Recording
from stickslip.measured.stick_speed import why_idle


def idle(recordings: Sequence[Recording], runs: Sequence[Measured]) -> tuple[str, ...]:
    """Return every run that no slip is found in, with the reason."""
    return tuple(
        f"{recording.name}: no slip is used: {why_idle(recording, len(one.run.track.sticks))}"
        for recording, one in zip(recordings, runs, strict=True)
        if not len(one.events)
    )


def absorbed(signs: Iterable[float]) -> str:
    """Say what becomes of a constant load, by the directions of the runs."""
    if len(set(signs)) == 1:
        return (
            "a constant load on the block is absorbed whole by the friction law: every run slips one way only"
        )
    return "a constant load on the block is not sought: it shifts friction's levels, up one way and down the other"


def set_point(name: str) -> tuple[Alternative, ...]:
    """Return what a gain is as well, no reading being another: a belt of another multiple of its set-points."""
    if name != "sensor_gain":
        return ()
    reason = (
        "a true belt speed of (1 + e) times the set-point, in every run alike, gives the same readings to the last: "
        "measure the speed of the pull"
    )
    return (Alternative("belt speed", 1.0, 0.0, True, True, reason, {}),)


def experiments(effects: Sequence[FoundEffect]) -> tuple[Experiment, ...]:
    """What would break the ties that these runs cannot."""
    out = []
    tied = {(e.name, a.name) for e in effects for a in e.alternatives if a.tied}
    constants = {name for pair in tied for name in pair} & set(CONSTANTS)
    if len(constants) > 1:
        pair = (
            ("sensor_gain", "rig_stiffness") if "sensor_gain" in constants else ("rig_mass", "rig_stiffness")
        )
        out.append(
            Experiment(
                "weigh the block, and hang a known weight on the spring", None, pair, float("inf"), True
            )
        )
        out.append(
            Experiment("repeat with another spring of known stiffness", None, pair, float("inf"), True)
        )
    if ("sensor_gain", "belt speed") in tied:
        out.append(
            Experiment(
                "measure the speed of the pull", None, ("sensor_gain", "belt speed"), float("inf"), True
            )
        )
    if any({"belt_seam", "harmonic_forcing"} == set(pair) for pair in tied):
        what = "two speeds whose runs both last several periods"
        out.append(Experiment(what, None, ("belt_seam", "harmonic_forcing"), float("inf"), True))
    return tuple(out)
