"""Cases: a declared rig and its recorded runs, as a folder with `rig.toml` holds them."""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import dataclass, fields
from pathlib import Path

from stickslip.arguments import explained
from stickslip.arguments import path as as_path
from stickslip.declared.bodies_model import check_closed_form
from stickslip.declared.declaration import read_candidates, read_channel, read_friction, read_laws, read_rig
from stickslip.declared.effect import AnyEffect, FormulaEffect
from stickslip.declared.friction.paper import PaperFriction
from stickslip.declared.friction_law import FrictionLaw, given_numbers
from stickslip.declared.law_dimensions import in_model
from stickslip.declared.model import IN_A_FOLDER, Model
from stickslip.declared.prescribed import Given
from stickslip.declared.rig import AnyRig, DrivenSlider, Rig
from stickslip.declared.rigs.general import GeneralRig
from stickslip.declared.toml_file import Document, read_toml
from stickslip.declared.uncertainty import Uncertainty
from stickslip.declared.units import Channel
from stickslip.errors import InputError, Place, did_you_mean, number
from stickslip.measured.case_tables import CaseTable, RunTable, check_runs, names_of
from stickslip.measured.channels import channel_factor, check_channels, noise_in_model
from stickslip.measured.findings import Finding, FindingKind
from stickslip.measured.prescribed import prescribed, set_point_of
from stickslip.measured.recording import Recording, Role, load_recording
from stickslip.objects import Drawn, one_line

__all__ = ["Case", "Channel", "Finding", "FindingKind", "Recording", "Role", "load_case", "load_recording"]


@dataclass(frozen=True, eq=False, repr=False)
class Case(Drawn):
    """A rig and its runs.

    Attributes
    ----------
    title
        What the file calls it.
    rig
        The declared rig; a run may override numbers of it (`Recording.rig`).
    friction
        Starting values of the declared law; Table 1 where the file has none.
    noise
        Standard deviation by channel, in the unit of its column; a channel is missing if unknown.
    runs
        The recordings, in the order of the file.
    channels
        Column, unit and scale by channel.
    path
        The file rig.toml.
    undeclared
        Numbers of `friction` that the file does not give: they are where a fit starts, and nobody's word.
    known
        How well the constants and the gains are known, as [uncertainty] says; None: nothing is said of it.
    candidates
        Effects of one's own that `discover` holds against its catalogue, in the order of the file.

    Examples
    --------
    >>> import stickslip as ss
    >>> from stickslip.data import example
    >>> case = ss.load_case(example("paper_slider"))
    >>> run = case.train[0]
    >>> print(f"{len(run)} samples at {1e3 * run.belt_speed:g} mm/s, {len(run.findings)} findings")
    16821 samples at 1.1 mm/s, 2 findings
    """

    title: str
    rig: AnyRig
    friction: FrictionLaw
    noise: Mapping[str, float]
    runs: tuple[Recording, ...]
    channels: Mapping[str, Channel]
    path: Path
    undeclared: tuple[str, ...] = ()
    known: Uncertainty | None = None
    candidates: tuple[FormulaEffect, ...] = ()

    def __repr__(self) -> str:
        roles = ", ".join(
            f"{sum(r.role == role for r in self.runs)} {role}" for role in ("train", "validate")
        )
        odd = f"; {len(self.findings)} findings" if self.findings else ""
        return one_line(
            f"<Case '{self.title}': {type(self.rig).__name__}, {len(self.runs)} runs ({roles}){odd}; {self.path}>"
        )

    @property
    def files(self) -> tuple[Path, ...]:
        """The files it was read from: rig.toml first, then each recording."""
        return self.path, *dict.fromkeys(run.source for run in self.runs)

    @property
    def train(self) -> tuple[Recording, ...]:
        """Runs to fit; `InputError` if there is none."""
        return self._with_role("train")

    @property
    def validate(self) -> tuple[Recording, ...]:
        """Runs on which error is reported; `InputError` if there is none."""
        return self._with_role("validate")

    @property
    def findings(self) -> tuple[str, ...]:
        """What is odd about the runs, each sentence begun with the run's name."""
        return tuple(f"{run.name}: {finding}" for run in self.runs for finding in run.findings)

    def run(self, name: str) -> Recording:
        """Return the run of a name, or raise `InputError` with the nearest one."""
        for one in self.runs:
            if one.name == name:
                return one
        raise InputError(f"unknown run '{name}'; {did_you_mean(name, [one.name for one in self.runs])}")

    @property
    def declared_law(self) -> FrictionLaw | None:
        """The law, if the file declares its kind or any of its numbers: a fit keeps its kind. None if it does not."""
        numbers = {one.name for one in fields(self.friction)}
        silent = isinstance(self.friction, PaperFriction) and numbers <= set(self.undeclared)
        return None if silent else self.friction

    @property
    def declared_numbers(self) -> Mapping[str, float]:
        """What the file says of the law's numbers, by name; none of them where it says nothing."""
        return given_numbers(self.friction, self.undeclared)

    @property
    def uncertainty(self) -> Uncertainty:
        """How well the declared constants and the gains of the sensors are known."""
        known = self.known or Uncertainty.usual(self.rig, channels=self.channels)
        return known.of(self.rig)

    def model(self, *, friction: FrictionLaw | None = None, effects: tuple[AnyEffect, ...] = ()) -> Model:
        """Return the declared model, or one with another law and effects; it knows columns and noise."""
        return Model(
            self.rig,
            friction=friction or self.friction,
            effects=effects,
            channels=dict(self.channels),
            noise=dict(self.noise) or None,
        )

    def _with_role(self, role: Role) -> tuple[Recording, ...]:
        runs = tuple(run for run in self.runs if run.role == role)
        if not runs:
            words = f"no [[run]] has role = '{role}'; give it to at least one"
            if len(self.runs) == 1:
                words += ", or give the one run twice, to = ... and from = ..."
            raise InputError(words, place=Place(str(self.path)))
        return runs


@explained
def load_case(path: str | os.PathLike[str], *, files_from: str | os.PathLike[str] | None = None) -> Case:
    """Read a case: its declared rig and all its runs.

    Parameters
    ----------
    path
        The file rig.toml, or the folder that holds it.
    files_from
        The folder that its recordings must lie in, or below; that of rig.toml if not given. A case that came from
        somebody else reads nothing besides.

    Returns
    -------
    Case
        Its runs in the model's numbers, with what is odd about them.

    Raises
    ------
    InputError
        A key is misspelt, missing or wrong (with its line), a file is missing or holds what is not a run
        (with line and column), a run is there twice, or a window of one overlaps another of another role.

    Examples
    --------
    >>> import stickslip as ss
    >>> from stickslip.data import example
    >>> case = ss.load_case(example("paper_slider"))  # a folder with rig.toml and its recordings
    >>> case.rig
    BlockOnBelt(mass=0.0307, stiffness=168.0)
    >>> [run.role for run in case.runs]
    ['train', 'validate']
    """
    document = read_toml(_case_file(as_path("path", path)))
    if "run" not in document.tables and {"rig", "friction"} <= document.tables.keys():
        words = (
            "no [[run]]: a model file; a case is wanted, the rig.toml that lists the recordings in [[run]]"
        )
        raise InputError(words, place=Place(str(document.path)))
    declared = document.validated(CaseTable)
    rig = read_rig(document, "rig", table=declared.rig)
    law = declared.friction or ({"kind": "coulomb"} if isinstance(rig, DrivenSlider) else {})
    if isinstance(rig, GeneralRig):
        friction = read_laws(document, rig)
        with document.at():
            Model(rig, friction=friction)  # which checks one against the other
    else:
        friction = read_friction(document, "friction", table=law)
        with document.at("friction"):
            friction = in_model(friction, rig)
        with document.at():
            check_closed_form(rig, friction)
    channels = {
        name: read_channel(document, "channels", name, table=table)
        for name, table in declared.channels.items()
    }
    with document.at("channels"):
        check_channels(channels, rig)
    for name, channel in channels.items():
        with document.at("channels", name):
            channel_factor(name, channel, rig)
    with document.at("noise"):
        noise = {name: number(name, value) for name, value in declared.noise.items()}  # type: ignore[arg-type]
        noise_in_model(noise, channels, rig)
    with document.at("uncertainty"):
        usual = Uncertainty.usual(rig, declared.rig, channels)
        known = usual.with_table(declared.uncertainty)
    candidates = read_candidates(document, declared.candidate, rig, friction, channels)
    allowed = document.path.parent if files_from is None else as_path("files_from", files_from)
    check_runs(document, declared.run, allowed)
    named = [
        run.model_copy(update={"name": name})
        for run, name in zip(declared.run, names_of(declared.run), strict=True)
    ]
    runs = tuple(
        _read_run(document, i, run, declared, channels, noise, friction, rig) for i, run in enumerate(named)
    )
    title = declared.title or document.path.resolve().parent.name
    undeclared = tuple(one.name for one in fields(friction) if one.name not in law)
    if isinstance(rig, GeneralRig):  # whose laws have no numbers that stand for nobody's word
        undeclared = ()
    return Case(title, rig, friction, noise, runs, channels, document.path, undeclared, known, candidates)


def _case_file(path: Path) -> Path:
    """Return the file rig.toml of a folder, or the path itself."""
    if not path.is_dir():
        return path
    models = [name for name in IN_A_FOLDER if (path / name).is_file()]
    if models and not (path / "rig.toml").is_file():
        words = f"the folder of a model ({models[0]}); a case is wanted, the folder with rig.toml and the recordings"
        raise InputError(words, place=Place(str(path)))
    return path / "rig.toml"


def _read_run(
    document: Document,
    i: int,
    run: RunTable,
    declared: CaseTable,
    channels: Mapping[str, Channel],
    noise: Mapping[str, float],
    friction: FrictionLaw,
    rig: AnyRig,
) -> Recording:
    if isinstance(rig, GeneralRig):
        return _read_general(document, i, run, rig, channels, noise)
    if run.drive_speed is not None:
        raise document.error(
            "nothing is pulled by a drive in this rig; leave it out", "run", i, "drive_speed"
        )
    with document.at("run", i, "rig"):
        for key in run.rig:
            if key not in declared.rig:
                raise InputError(f"not a number of [rig]; {did_you_mean(key, declared.rig)}", key=key)
    own = read_rig(document, *(("run", i, "rig") if run.rig else ("rig",)), table={**declared.rig, **run.rig})
    given = _belt_speed(document, i, run, own)
    with document.at("run", i):
        set_point_of(own, channels, given)
    return load_recording(
        document.path.parent / run.file,
        own,
        channels=channels,
        belt_speed=given,
        role=run.role,
        noise=noise,
        window=(run.start, run.end),
        name=run.name,
        # Table 1 is no guess in N, and neither are the defaults of a law of which only the kind is given
        friction=friction if isinstance(own, Rig) or set(declared.friction) - {"kind"} else None,
    )


def _read_general(
    document: Document,
    i: int,
    run: RunTable,
    rig: GeneralRig,
    channels: Mapping[str, Channel],
    noise: Mapping[str, float],
) -> Recording:
    """A run of a rig of bodies or matrices."""
    if run.rig:
        words = "one rig is taken for all runs of a case of bodies or matrices; put its numbers into [rig]"
        raise document.error(words, "run", i, "rig")
    with document.at("run", i):
        prescribed(rig, channels, run.speed("belt_speed"), run.speed("drive_speed"))
    return load_recording(
        document.path.parent / run.file,
        rig,
        channels=channels,
        belt_speed=run.speed("belt_speed"),
        drive_speed=run.speed("drive_speed"),
        role=run.role,
        noise=noise,
        window=(run.start, run.end),
        name=run.name,
    )


def _belt_speed(document: Document, i: int, run: RunTable, rig: AnyRig) -> Given:
    """The set-point of a run; a driven slider has none."""
    if isinstance(rig, DrivenSlider):
        if run.belt_speed is not None:
            raise document.error("a driven slider has no belt; leave it out", "run", i, "belt_speed")
        return 0.0
    given = run.speed("belt_speed")
    if given is None:
        place, _ = document.place("run", i, "belt_speed")
        raise InputError("lacks 'belt_speed'; it needs file, role, belt_speed", place=place)
    return given
