"""The force of a driven slider's drive as the command line takes it: a number, a formula of t, or a record."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from stickslip.declared.drive import drive_of
from stickslip.declared.model import Model
from stickslip.declared.rig import DrivenSlider
from stickslip.declared.speeds import Speed
from stickslip.declared.units import Channel
from stickslip.errors import InputError
from stickslip.measured.channels import by_heads, channel_factor, head_of
from stickslip.measured.readers.tables import open_table

Floats = NDArray[np.float64]
KEY = "--drive"


def is_record(text: str) -> bool:
    """Say whether a drive is given by a file."""
    return Path(text).suffix.lower() == ".csv" or Path(text).is_file()


def read_drive(text: str | None, model: Model, after: float | None = None) -> Speed | None:
    """Return the force of the drive [N]; None of a rig that has none.

    Parameters
    ----------
    text
        As given. A record has the columns that the channels of the model say, or t [s] and drive [N].
    model
        What it moves.
    after
        Time that a record must go beyond, by its own clock; None: it is taken to begin at 0.

    Raises
    ------
    InputError
        Missing for a driven slider, given for another rig, or none of these.
    """
    if not isinstance(model.rig, DrivenSlider):
        if text is not None:
            raise InputError("no force moves this rig; leave it out", key=KEY)
        return None
    if text is None:
        words = "missing: the force on the slider, like '4 N', '20*sin(3*t)', or the file of a run"
        raise InputError(words, key=KEY)
    try:
        if not is_record(text):
            return drive_of(text, model.rig)
        t, force = _recorded(text, model)
        if after is not None and not t[-1] > after:
            words = f"ends at t = {t[-1]:.6g} s, and what is forecast begins after {after:.6g} s"
            raise InputError(words, key="drive", value=text)
        return drive_of((t if after is not None else t - t[0], force), model.rig)
    except InputError as error:
        if error.key != "drive":
            raise
        raise InputError(error.what, key=KEY, value=error.value) from None


def _recorded(text: str, model: Model) -> tuple[Floats, Floats]:
    """Times and forces of a file, SI."""
    own = {"t": Channel("t", "s"), "drive": Channel("drive", "N")}
    known = own if model.channels is None or "drive" not in model.channels else model.channels
    both = {key: known[key] for key in ("t", "drive")}
    opened = open_table(text, [one.column for one in both.values()])
    if head_of(both["drive"].column, opened.contents) is None:  # not as the model's channels call it
        both = own
    both, _ = by_heads(opened, both, text)
    units = {one.column: one.unit for one in both.values()}
    values = opened.read(list(units), units).values
    t, force = (values[one.column] * channel_factor(key, one, model.rig) for key, one in both.items())
    return t, force
