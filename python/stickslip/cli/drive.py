"""The force of a driven slider's drive as the command line takes it: a number, a formula of t, or a record."""

from __future__ import annotations

from pathlib import Path

from stickslip.declared.drive import drive_of
from stickslip.declared.model import Model
from stickslip.declared.rig import DrivenSlider
from stickslip.declared.speeds import Speed
from stickslip.errors import InputError
from stickslip.measured.readers.tables import read_columns
from stickslip.measured.recording import load_recording

KEY = "--drive"


def is_record(text: str) -> bool:
    """Say whether a drive is given by a file."""
    return Path(text).suffix.lower() == ".csv" or Path(text).is_file()


def read_drive(text: str | None, model: Model) -> Speed | None:
    """Return the force of the drive [N]; None of a rig that has none.

    Parameters
    ----------
    text
        As given. A record is read by the channels of the model, or has columns t [s] and drive [N].
    model
        What it moves.

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
        return drive_of(_recorded(text, model) if is_record(text) else text, model.rig)
    except InputError as error:
        if error.key != "drive":
            raise
        raise InputError(error.what, key=KEY, value=error.value) from None


def _recorded(text: str, model: Model) -> object:
    if model.channels is None or "drive" not in model.channels:
        values = read_columns(text, ("t", "drive")).values
        return values["t"], values["drive"]
    run = load_recording(text, model.rig, channels=model.channels)
    return run.t, run.drive
