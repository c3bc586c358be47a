"""A case without files: recordings, or columns in memory, with their rig."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import fields, replace
from pathlib import Path
from typing import Any

from numpy.typing import ArrayLike

from stickslip.arguments import must_be
from stickslip.declared.bodies_model import named_laws
from stickslip.declared.candidate import distinct, on_rig
from stickslip.declared.effect import FormulaEffect
from stickslip.declared.friction.coulomb import CoulombFriction
from stickslip.declared.friction.paper import PaperFriction
from stickslip.declared.friction_law import FrictionLaw
from stickslip.declared.law_dimensions import in_model
from stickslip.declared.rig import AnyRig, Rig
from stickslip.declared.units import Channel
from stickslip.errors import InputError
from stickslip.measured.case import Case
from stickslip.measured.case_tables import told_apart
from stickslip.measured.recording import Recording, load_recording

SHARE = 2 / 3  # of a run's time that is trained on, where nothing is there to validate on
IN_MEMORY = Path("columns in memory")  # in place of rig.toml
Columns = Mapping[str, ArrayLike]


def case_in_memory(
    source: Recording | Sequence[Recording] | Columns,
    rig: AnyRig | None,
    *,
    channels: Mapping[str, Channel] | None = None,
    belt_speed: float | str | None = None,
    noise: Mapping[str, float] | None = None,
    friction: FrictionLaw | None = None,
    candidates: Iterable[FormulaEffect] = (),
) -> Case:
    """Return a case of what is in memory.

    Parameters
    ----------
    source
        Recordings, or the columns (n,) of one by name, as a data frame has them.
    rig
        What it was recorded on; that of the recordings if absent.
    channels, belt_speed, noise
        Of columns, as `load_recording` takes them.
    friction
        The declared law; nothing is declared if absent.
    candidates
        Effects of one's own for `discover`, from `stickslip.candidate`.

    Returns
    -------
    Case
        Where no recording has the role "validate", the last third of each is one.

    Raises
    ------
    InputError
        Columns without a rig, recordings of several rigs or kinds of channels, or what else `load_recording` refuses.
    """
    if hasattr(source, "keys"):  # a data frame is no Mapping
        if rig is None:
            raise InputError(
                "columns in memory need their rig; give rig=BlockOnBelt(...) or Rig(...)", key="rig"
            )
        columns: Columns = dict(source)  # type: ignore[arg-type]
        speed = 0.0 if belt_speed is None else belt_speed
        given = [
            load_recording(columns, rig, channels=channels, belt_speed=speed, noise=noise, friction=friction)
        ]
    else:
        for name, one in (("channels", channels), ("belt_speed", belt_speed), ("noise", noise)):
            if one is not None:
                raise InputError("is for columns in memory; recordings have their own", key=name)
        given = [source] if isinstance(source, Recording) else [*source]
        for run in given:
            must_be(
                "case", run, Recording, "load_case(path) gives a case, load_recording(path, rig) a recording"
            )
    if not given:
        raise InputError("is empty; give recordings", key="case")
    first = given[0]
    if any(run.channels != first.channels for run in given):
        raise InputError("the recordings have different channels; record them alike", key="case")
    names = told_apart([run.name for run in given])
    given = [
        run if run.name == name else replace(run, name=name) for run, name in zip(given, names, strict=True)
    ]
    if all(run.role == "train" for run in given):
        given = [part for run in given for part in _cut(run)]
    own_rig = rig or first.rig
    law: Any = named_laws(friction) or (PaperFriction() if isinstance(own_rig, Rig) else CoulombFriction())
    silent = () if friction else tuple(one.name for one in fields(law))
    known = {name: first.noise.get("x1" if name == "spring_force" else name) for name in first.channels}
    own = {name: size / abs(first.factors[name]) for name, size in known.items() if size is not None}
    case = Case(
        first.name, own_rig, in_model(law, own_rig), own, tuple(given), first.channels, IN_MEMORY, silent
    )
    return with_candidates(case, candidates)


def with_candidates(case: Case, candidates: Iterable[FormulaEffect]) -> Case:
    """Return a case with these effects of one's own beside its own.

    Raises
    ------
    InputError
        One that does not act on its rig, or a name that is there twice.
    """
    more = []
    for one in distinct(candidates):
        try:
            more.append(on_rig(one, case.rig, case.friction, case.channels))
        except InputError as error:
            key = ".".join(part for part in ("candidates", one.name, error.key) if part)
            raise InputError(error.what, key=key, value=error.value) from None
    return replace(case, candidates=distinct((*case.candidates, *more)))


def _cut(run: Recording) -> tuple[Recording, Recording]:
    """The first part of a run to train on, the rest to validate on."""
    start, end = float(run.t[0]), float(run.t[-1])
    at = start + SHARE * (end - start)
    late = replace(run.window(at, end + 1), role="validate", name=f"{run.name}_late")
    return replace(run.window(start, at), name=f"{run.name}_early"), late
