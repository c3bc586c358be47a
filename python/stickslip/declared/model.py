"""The model: a rig, a friction law, and the effects it has beside them."""

from __future__ import annotations

import dataclasses
import os
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Self

from stickslip.arguments import explained, listed, must_be
from stickslip.arguments import path as as_path
from stickslip.declared.bodies_model import check_general, named_laws
from stickslip.declared.catalogue import CONSTANTS
from stickslip.declared.check_model import check_belt, check_driven, idle, needs_angle_body
from stickslip.declared.contact_laws import ContactLaws
from stickslip.declared.declaration import (
    effect_table,
    friction_table,
    read_channel,
    read_effect,
    read_laws,
    read_rig,
    read_scatter,
    rig_table,
)
from stickslip.declared.effect import AnyEffect, Effect, FormulaEffect, Tabulated, with_numbers
from stickslip.declared.effect_numbers import effects_in_model
from stickslip.declared.friction_law import FrictionLaw
from stickslip.declared.law_dimensions import in_model
from stickslip.declared.number_names import check_number_names
from stickslip.declared.rig import AnyRig, BlockOnBelt, DrivenSlider, Rig
from stickslip.declared.rigs.general import GeneralRig
from stickslip.declared.scatter import EventScatter
from stickslip.declared.toml_file import read_toml, write_text
from stickslip.declared.units import DIMENSIONS, Channel, refuse_sensor
from stickslip.errors import InputError, Place, did_you_mean, number, unknown
from stickslip.objects import Drawn

NOT_IN_MODEL = ("belt_speed",)  # named like parameters in sweeps and sensitivities, but given to `simulate`

IN_A_FOLDER = ("model_after.toml", "model.toml")  # what discover and identify write

_HEADER = """\
# A model of stickslip: stickslip.load_model reads it.
# [rig] as in (2.1), [friction] as in (4.1)-(4.3) or another kind, an [[effect]] for each thing these lack,
# nondimensional; [rig.scales] turns them back to SI (a block on a belt has none: its numbers are as given).
# [channels] and [noise]: columns and units of the readings. [scatter]: how friction differs from event to event.
"""


_GENERAL_HEADER = """\
# A model of stickslip: stickslip.load_model reads it.
# [rig] with its bodies, links and contacts (or its matrices), [friction] or a [law.<name>] for every name that
# contacts give. Bare numbers are in SI.
"""


@explained
@dataclass(frozen=True, repr=False)
class Model(Drawn):
    """A rig, its friction law and its effects.

    Parameters
    ----------
    rig
        `Rig`, `BlockOnBelt` or `DrivenSlider`; `BodiesRig` or `MatricesRig`.
    friction
        `PaperFriction`, `CoulombFriction` or `HyperbolicFriction`; or a law by a formula: `StribeckFriction`,
        `TabulatedFriction`, `LuGreFriction`, `DahlFriction`, `RateAndStateFriction`, `FormulaFriction`. Where contacts
        name their laws, a table of laws by name.
    effects
        From `effect` and `tabulated`, each name once; on a rig of bodies or matrices once a place.
    channels
        Columns and units in which readings are recorded (keys t, x1, y1, belt, spring_force), for a model
        that was identified; None: nondimensional readings in columns of these names.
    noise
        Standard deviation of the readings by channel, in the channel's unit.
    scatter
        How friction and the belt differ from event to event, for `forecast`; None: as its past shows. Of a rig of
        (2.1) or a block on a belt.

    Raises
    ------
    InputError
        Something is of the wrong kind, or an effect is there twice, needs what the rig lacks, or could do nothing under
        the law or beside another effect.

    Examples
    --------
    >>> import stickslip as ss
    >>> rig = ss.Rig(alpha1=16, alpha2=8, beta3=4, eta1=0.1, eta12=0.2)
    >>> model = ss.Model(rig, friction=ss.PaperFriction())
    >>> worn = model.replace(T_s_minus=5.0).with_effects([ss.effect("belt_speed_ripple", a=0.1, w=6.3)])
    >>> worn.parameters["T_s_minus"], worn.parameters["belt_speed_ripple.a"]
    (5.0, 0.1)
    """

    rig: AnyRig
    friction: FrictionLaw = field(kw_only=True)
    effects: tuple[AnyEffect, ...] = field(default=(), kw_only=True)
    channels: Mapping[str, Channel] | None = field(default=None, kw_only=True, hash=False)
    noise: Mapping[str, float] | None = field(default=None, kw_only=True, hash=False)
    scatter: EventScatter | None = field(default=None, kw_only=True)

    def __post_init__(self) -> None:
        must_be("rig", self.rig, (Rig, BlockOnBelt, DrivenSlider, GeneralRig))
        object.__setattr__(self, "friction", named_laws(self.friction))
        must_be("friction", self.friction, FrictionLaw, "like CoulombFriction(static=1, kinetic=0.5)")
        object.__setattr__(self, "friction", in_model(self.friction, self.rig))
        if isinstance(self.effects, (Effect, Tabulated, FormulaEffect, str)):
            raise InputError("must be a list of effects; put it in [ ]", key="effects")
        object.__setattr__(self, "effects", tuple(listed("effects", self.effects, "effects")))
        for one in self.effects:
            must_be("effects", one, (Effect, Tabulated, FormulaEffect), "effect(name, ...) makes one")
        object.__setattr__(self, "effects", effects_in_model(self.effects, self.rig))
        labels = [one.name if isinstance(one, Tabulated) else one.label for one in self.effects]
        for name in labels:
            if labels.count(name) > 1:
                raise InputError(f"effect '{name}' is there twice; give it once")
        names = [one.name for one in self.effects]
        if not isinstance(self.rig, GeneralRig) and (why := idle(self.friction, names)):
            raise InputError(why, key="effects")
        self._check_readings()
        check_number_names(self.rig, self.friction, self.effects)
        check_general(self.rig, self.friction, self.effects, {**(self.noise or {}), **(self.channels or {})})
        if isinstance(self.rig, GeneralRig):
            return
        if not isinstance(self.rig, DrivenSlider):
            check_belt(self.effects)
        if isinstance(self.rig, BlockOnBelt):
            for one in self.effects:
                if needs_angle_body(one):
                    raise InputError(f"effect '{one.name}' needs the angle body, which a BlockOnBelt has not")
        elif isinstance(self.rig, DrivenSlider):
            check_driven(self.friction, self.effects)
        elif wrong := [n for n in names if n in CONSTANTS and CONSTANTS[n].corrects != "stiffness"]:
            raise InputError(
                f"effect '{wrong[0]}' is for a BlockOnBelt; change the rig's own numbers instead"
            )

    def _check_readings(self) -> None:
        if self.channels is not None:
            for name, channel in must_be("channels", self.channels, Mapping).items():
                refuse_sensor(name, must_be("channels", channel, Channel), self.rig)
        if self.noise is not None:
            must_be("noise", self.noise, Mapping)
            checked = {name: number(name, value, above=0) for name, value in self.noise.items()}
            object.__setattr__(self, "noise", checked)
        if self.scatter is not None:
            must_be("scatter", self.scatter, EventScatter)
            if not isinstance(self.rig, (Rig, BlockOnBelt)):
                words = (
                    "is of a rig of (2.1) or a block on a belt; forecasts of this rig take it from their past"
                )
                raise InputError(words, key="scatter")

    @property
    def parameters(self) -> dict[str, float]:
        """Every number of the model by the name that sweeps and sensitivities use.

        Names of the rig and the law are their own ("alpha1", "T_s_minus", "mass"); an effect's are
        "<effect>.<parameter>". Optional numbers that are not set are left out.
        """
        if isinstance(self.rig, GeneralRig):
            return {**self.rig.numbers, **self.friction.numbers, **self._of_effects()}
        values = {one.name: getattr(self.rig, one.name) for one in dataclasses.fields(self.rig)}
        flat = {name: value for name, value in values.items() if isinstance(value, float)}
        flat |= self.friction.numbers
        return flat | self._of_effects()

    def _of_effects(self) -> dict[str, float]:
        named = [(one.name if isinstance(one, Tabulated) else one.label, one) for one in self.effects]
        return {f"{name}.{key}": size for name, one in named for key, size in one.parameters.items()}

    def parameter_name(self, name: str) -> str:
        """Return the full name of a parameter; "effect.c" stands for the only effect that has a `c`.

        Raises
        ------
        InputError
            Unknown (with the nearest known name) or ambiguous.
        """
        return self._named(name, self.parameters)

    def full_name(self, name: str) -> str:
        """Return what a short name "effect.c" stands for, and any other name as it is."""
        return self.parameter_name(name) if name.startswith("effect.") else name

    def _named(self, name: str, known: Mapping[str, float]) -> str:
        if name in known:
            return name
        if name.startswith("effect."):
            ending = name.removeprefix("effect")
            found = [one for one in known if one.endswith(ending)]
            if len(found) == 1:
                return found[0]
            if found:
                raise InputError(f"'{name}' is ambiguous; give one of {', '.join(found)}")
        if name in self._optional():
            raise InputError(f"'{name}' is not set in this law; set it there first")
        if name in NOT_IN_MODEL or name.startswith("initial."):
            raise InputError(f"'{name}' is not a number of the model; give it to simulate or sweep")
        states = [f"initial.{state}" for state in self.rig.state_names]
        raise unknown("parameter", name, [*known, *NOT_IN_MODEL, *states])

    def replace(self, values: Mapping[str, float] | None = None, /, **named: float) -> Self:
        """Return the model with some parameters changed.

        Parameters
        ----------
        values
            By name, for names with a dot ("belt_seam.L").
        **named
            The same as keywords. A rig's scales stay as they are.

        Raises
        ------
        InputError
            Unknown name (with the nearest known one) or a value out of bounds.
        """
        if values is not None:
            must_be("values", values, Mapping, "like {'belt_seam.L': 2.0}")
        if isinstance(self.rig, GeneralRig):
            return self._replaced({**(values or {}), **named}, self.rig)
        rig: dict[str, float] = {}
        law: dict[str, float] = {}
        effects: dict[str, dict[str, float]] = {}
        ours = {one.name for one in dataclasses.fields(self.rig)}
        known, optional = self.parameters, self._optional()
        for given, value in {**(values or {}), **named}.items():
            name = given if given in optional else self._named(given, known)
            if "." in name:
                owner, _, parameter = name.partition(".")
                effects.setdefault(owner, {})[parameter] = value
            elif name in ours:
                rig[name] = value
            else:
                law[name] = value
        return dataclasses.replace(
            self,
            rig=dataclasses.replace(self.rig, **rig),  # type: ignore[arg-type]  # floats by name
            friction=self.friction.with_numbers(law),
            effects=tuple(one.replace(**effects.get(one.name, {})) for one in self.effects),
        )

    def _replaced(self, values: Mapping[str, float], own: GeneralRig) -> Self:
        """Return a model of bodies or matrices with some numbers changed."""
        rig, law, optional = dict[str, float](), dict[str, float](), self._optional()
        effects, added = dict[str, float](), self._of_effects()
        for given, value in values.items():
            name = given if given in optional else self._named(given, self.parameters)
            group = rig if name in own.numbers else effects if name in added else law
            group[name] = value
        return dataclasses.replace(
            self,
            effects=tuple(with_numbers(one, effects) for one in self.effects),
            rig=own.with_numbers(rig),
            friction=self.friction.with_numbers(law) if law else self.friction,
        )

    def _optional(self) -> set[str]:
        """Names of the law's numbers that default to None."""
        if isinstance(self.friction, ContactLaws):
            return {
                f"{name}.{one.name}"
                for name, law in self.friction.laws
                for one in dataclasses.fields(law)
                if one.default is None
            }
        return {one.name for one in dataclasses.fields(self.friction) if one.default is None}

    def with_effects(self, effects: Iterable[AnyEffect]) -> Self:
        """Return the model with these effects instead of its own."""
        return dataclasses.replace(self, effects=effects)  # type: ignore[arg-type]  # made a tuple there

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write the model as TOML; `load_model` reads it back equal, to the last bit.

        Raises
        ------
        InputError
            The file cannot be written; nothing half-written is left.
        """
        write_text(as_path("path", path), self.toml())

    def toml(self) -> str:
        """Return the text that `save` writes."""
        import tomlkit

        tables: dict[str, object] = {"rig": rig_table(self.rig)}
        if isinstance(self.friction, ContactLaws):
            tables["law"] = {name: friction_table(law) for name, law in self.friction.laws}
        else:
            tables["friction"] = friction_table(self.friction)
        if self.effects:
            tables["effect"] = [effect_table(one) for one in self.effects]
        if self.channels is not None:
            tables["channels"] = {name: one.table for name, one in self.channels.items()}
        if self.noise is not None:
            tables["noise"] = dict(self.noise)
        if self.scatter is not None:
            tables["scatter"] = dataclasses.asdict(self.scatter)
        return (
            (_GENERAL_HEADER if isinstance(self.rig, GeneralRig) else _HEADER) + "\n" + tomlkit.dumps(tables)
        )


def load_model(path: str | os.PathLike[str]) -> Model:
    """Read a model from TOML.

    Parameters
    ----------
    path
        A file as `Model.save` writes it, or the folder in which `identify` or `discover` put one.
        [rig] may also be in SI; Table 1 where there is no [friction].

    Returns
    -------
    Model

    Raises
    ------
    InputError
        No such file, not TOML, or a key that is misspelt, missing or out of bounds, with its line.

    Examples
    --------
    >>> import stickslip as ss
    >>> rig = ss.Rig(alpha1=16, alpha2=8, beta3=4, eta1=0.1, eta12=0.2)
    >>> model = ss.Model(rig, friction=ss.PaperFriction())
    >>> model.save("model.toml")
    >>> ss.load_model("model.toml") == model
    True
    """
    document = read_toml(model_file(as_path("path", path)))
    tables = document.tables
    if "run" in tables:
        raise document.error(
            "this is a case with its runs, not a model; identify or discover make a model of it", "run", 0
        )
    known = ("rig", "friction", "law", "effect", "channels", "noise", "scatter")
    for key, table in tables.items():
        if key not in known:
            raise document.error(f"unknown; {did_you_mean(key, known)}", key)
        if not isinstance(table, list if key == "effect" else Mapping):
            raise document.error(f"must be a table [{'[effect]' if key == 'effect' else key}]", key)
    if "rig" not in tables:
        raise document.error("a model lacks its table [rig]")
    listed = enumerate(_list(tables.get("effect")))
    effects = [read_effect(document, "effect", i, table=one) for i, one in listed]
    channels = None
    rig = read_rig(document, "rig", table=_table(tables["rig"]))
    known_channels = [*rig.channel_units] if isinstance(rig, GeneralRig) else [*DIMENSIONS]
    if "channels" in tables:
        channels = {}
        for name, table in _table(tables["channels"]).items():
            if name not in known_channels and not (isinstance(rig, GeneralRig) and "reads" in _table(table)):
                hint = did_you_mean(name, known_channels)
                raise document.error(f"unknown channel; {hint}", "channels", name)
            channels[name] = read_channel(document, "channels", name, table=_table(table))
    noise = None
    if "noise" in tables:
        with document.at("noise"):
            noise = {name: number(name, value, above=0) for name, value in _table(tables["noise"]).items()}  # type: ignore[arg-type]
    law = read_laws(document, rig)
    scatter = read_scatter(document, _table(tables["scatter"])) if "scatter" in tables else None
    with document.at():
        return Model(
            rig, friction=law, effects=tuple(effects), channels=channels, noise=noise, scatter=scatter
        )


def model_file(path: Path) -> Path:
    """Return the model file of a folder of results, or the path itself."""
    if not path.is_dir():
        return path
    for name in IN_A_FOLDER:
        if (path / name).is_file():
            return path / name
    hint = "; give rig.toml to identify or discover first" if (path / "rig.toml").is_file() else ""
    raise InputError(f"a folder without {' or '.join(IN_A_FOLDER)}{hint}", place=Place(str(path)))


def _table(value: object) -> Mapping[str, object]:
    return value if isinstance(value, Mapping) else {}


def _list(value: object) -> list[Mapping[str, object]]:
    return [_table(one) for one in value] if isinstance(value, list) else []
