"""What can go wrong, said in one line: what, where, and what would be right."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass
from difflib import get_close_matches
from typing import Self, SupportsFloat

QUOTED = 200  # characters of the user's own text that a message shows at most
SENTENCE = 600  # characters of what is said of it


def quoted(text: object, most: int = QUOTED) -> str:
    """Return a user's text fit for a line: control characters escaped, the middle of a long one left out."""
    told = "".join(
        c if c.isprintable() else c.encode("unicode_escape").decode() for c in str(text)[: 2 * most]
    )
    if len(told) <= most and len(str(text)) <= 2 * most:
        return told
    return f"{told[: most - 3]}..."


@dataclass(frozen=True)
class Place:
    """Where in the user's material a fault lies; what is None is left out of the sentence."""

    file: str | None = None
    line: int | None = None
    table: str | None = None
    column: str | None = None

    def __str__(self) -> str:
        head = "" if self.file is None else quoted(self.file)
        if self.line is not None:
            head += f" line {self.line}"
        table = None if self.table is None else f"[{quoted(self.table)}]"
        column = None if self.column is None else f"column '{quoted(self.column)}'"
        return ", ".join(part for part in (head.strip(), table, column) if part)


class StickslipError(ValueError):
    """Base of every error this package raises on purpose.

    Examples
    --------
    >>> import stickslip as ss
    >>> try:
    ...     ss.load_model("nowhere.toml")
    ... except ss.StickslipError as error:
    ...     print(error)
    nowhere.toml: no such file
    """


class InputError(StickslipError):
    """Something given by the user is wrong.

    Parameters
    ----------
    what
        One line: what is wrong and what would be right.
    key
        Name of the number or key at fault, where there is one.
    value
        What was given for `key`; None leaves it out of the sentence.
    place
        File, line, table and column.

    Examples
    --------
    >>> import stickslip as ss
    >>> try:
    ...     ss.effect("sensor_lagg", tau=0.1)
    ... except ss.InputError as error:
    ...     print(error)
    unknown effect 'sensor_lagg'; did you mean 'sensor_lag'?
    """

    def __init__(
        self, what: str, *, key: str | None = None, value: object = None, place: Place | None = None
    ) -> None:
        self.what, self.key, self.value, self.place = what, key, value, place
        super().__init__(self._sentence())

    def _sentence(self) -> str:
        given = "" if self.value is None else f" = {_short(self.value)}"
        key = None if self.key is None else quoted(self.key)
        what = quoted(self.what, SENTENCE)
        if self.place is None:
            subject = "" if key is None else f"{key}{given}"
        else:
            subject = str(self.place)
            if key is not None:
                joint = " " if self.place.table is not None else ", "
                subject += f"{joint}key '{key}'{given}"
        return f"{subject}: {what}" if subject else what

    def placed(self, place: Place) -> Self:
        """Return the same error, said to lie at `place`; one that has a place already keeps it."""
        if self.place is not None:
            return self
        return type(self)(self.what, key=self.key, value=self.value, place=place)

    def __reduce__(self) -> tuple[object, ...]:
        # errors cross process borders in a distributed sweep
        return _rebuilt, (type(self), self.what, self.key, self.value, self.place)


class ModelWarning(UserWarning):
    """What is computed is what was declared, but it can hardly be meant.

    Examples
    --------
    >>> import warnings
    >>> import stickslip as ss
    >>> with warnings.catch_warnings(record=True) as caught:
    ...     warnings.simplefilter("always")
    ...     link = ss.Link(between=("a", "ground"), stiffness=-1)
    ...     rig = ss.BodiesRig(body={"a": ss.Body(mass=1)}, link=[link])
    >>> caught[0].category is ss.ModelWarning
    True
    """


class CallError(InputError, TypeError):
    """A call with a name that is unknown, missing or given twice; Python's own TypeError, with what would be right."""


def _rebuilt(
    kind: type[InputError], what: str, key: str | None, value: object, place: Place | None
) -> InputError:
    return kind(what, key=key, value=value, place=place)


def _short(value: object) -> str:
    """Show a value as the user wrote it, cut to a line."""
    import numpy as np

    if isinstance(value, np.generic):
        value = value.item()
    try:
        text = repr(value).replace("\n", " ")
    except ValueError:  # an integer of thousands of digits
        return "a number of thousands of digits"
    return text if len(text) <= 40 else text[:37] + "..."


MANY = 16  # names that are still worth listing in one line


def nearest(name: str, known: Iterable[str]) -> str | None:
    """Return the known name that `name` is most likely meant to be, or None."""
    names = list(known)
    folded = {known_name.lower(): known_name for known_name in names}
    found = get_close_matches(name.lower(), folded, n=1, cutoff=0.55)
    return folded[found[0]] if found else None


def did_you_mean(name: str, known: Iterable[str]) -> str:
    """Say what would have been right for an unknown `name`: the nearest one, or all of them."""
    names = list(known)
    whole = [one for one in names if one.endswith(f".{name}")]
    if whole:  # "x1" for "initial.x1"
        return f"did you mean {' or '.join(repr(one) for one in whole[:3])}?"
    guess = nearest(name, names)
    if guess is not None:
        return f"did you mean '{guess}'?"
    holding = [one for one in names if len(name) > 2 and _part(name.lower(), one.lower())]
    if holding:
        return f"did you mean {' or '.join(repr(one) for one in holding[:3])}?"
    if len(names) > MANY:
        return f"none known is like it ({', '.join(names[:4])}, ...)"
    return f"it must be one of {', '.join(names)}" if names else "none is known here"


def _part(name: str, whole: str) -> bool:
    return name in whole.split("_") or whole.startswith(f"{name}_")


def unknown(what: str, name: str, known: Iterable[str]) -> InputError:
    """Return the error for a `name` that is not a `what`, with the nearest known one."""
    return InputError(f"unknown {what} '{name}'; {did_you_mean(name, known)}")


def number(
    name: str,
    value: SupportsFloat | None,
    *,
    above: float = -math.inf,
    least: float = -math.inf,
    below: float = math.inf,
    most: float = math.inf,
    why: str = "",
) -> float:
    """Return `value` as a finite float within bounds, or raise `InputError` naming it.

    Parameters
    ----------
    name
        Name said in the error.
    value
        A real number; numpy scalars and 0-d arrays count, booleans and text do not.
    above, least, below, most
        Open and closed lower bound, open and closed upper bound.
    why
        Meaning of the bound, appended to the sentence.

    Raises
    ------
    InputError
        Not a number, NaN, infinite or out of bounds.
    """
    if type(value) is float and above < value < below and least <= value <= most:
        return value  # nearly every call: a float in its bounds (NaN and infinity compare false)
    if not _is_real(value):
        raise InputError("not a number; give one like 0.5", key=name, value=value)
    try:
        result = float(value)  # type: ignore[arg-type]  # _is_real has seen to it
    except OverflowError:  # an integer of hundreds of digits
        result = math.inf
    if math.isnan(result):
        raise InputError("not a number; it must be finite", key=name, value=value)
    if math.isinf(result):
        raise InputError("infinite; it must be finite", key=name, value=value)
    tail = f" ({why})" if why else ""
    for broken, words in (
        (result <= above, f"must be above {above:g}"),
        (result < least, f"must be at least {least:g}"),
        (result >= below, f"must be below {below:g}"),
        (result > most, f"must be at most {most:g}"),
    ):
        if broken:
            raise InputError(words + tail, key=name, value=result if result != value else value)
    return result


def _is_real(value: object) -> bool:
    import numpy as np  # when it is needed: `import stickslip` and `--help` do without it

    if isinstance(value, (bool, np.bool_, str, bytes, complex)) or value is None:
        return False
    if isinstance(value, np.ndarray):
        return value.ndim == 0 and value.dtype.kind in "iuf"
    return isinstance(value, (int, float, np.integer, np.floating))
