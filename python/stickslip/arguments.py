"""What a call gets wrong, said in one line before any work begins: names unknown or missing, the wrong kind."""

from __future__ import annotations

import errno
import functools
import inspect
import os
from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from stickslip.errors import CallError, InputError, did_you_mean, number

C = TypeVar("C", bound=Callable[..., object])
T = TypeVar("T")


def explained(called: C) -> C:
    """Let a public function or class say an argument that is misspelt, missing or without its name in one line.

    The error is a `CallError`: an `InputError` that is a `TypeError` too, as Python's own would be. A call that
    is right pays nothing but a frame.
    """
    function: Callable[..., object] = called.__init__ if isinstance(called, type) else called  # type: ignore[misc]
    elsewhere: Mapping[str, str] = getattr(called, "elsewhere", {})
    name = called.__qualname__ if function is called else called.__name__

    @functools.wraps(function)
    def call(*given: object, **named: object) -> object:
        try:
            return function(*given, **named)
        except TypeError as error:
            inside = error.__traceback__ is not None and error.__traceback__.tb_next is not None
            fault = None if inside else _fault(name, inspect.signature(function), given, named, elsewhere)
            if fault is None:
                raise
            raise fault from None

    if isinstance(called, type):
        called.__init__ = call  # type: ignore[misc]
        return called
    return call  # type: ignore[return-value]


def also_called(short: Mapping[str, str]) -> Callable[[type[T]], type[T]]:
    """Let a class take numbers by short names, too: `short` has the full name by the short one."""

    def taking(called: type[T]) -> type[T]:
        init: Callable[..., None] = called.__init__

        @functools.wraps(init)
        def call(self: T, *given: object, **named: object) -> None:
            for key, full in short.items():
                if key in named:
                    if full in named:
                        raise CallError(
                            f"'{key}' and '{full}' are the same number; give one", key=called.__name__
                        )
                    named[full] = named.pop(key)
            init(self, *given, **named)

        called.__init__ = call  # type: ignore[assignment]
        return called

    return taking


def _fault(
    name: str,
    signature: inspect.Signature,
    given: tuple[object, ...],
    named: dict[str, object],
    elsewhere: Mapping[str, str],
) -> CallError | None:
    parameters = [one for one in signature.parameters.values() if one.name not in ("self", "cls")]
    known = [one.name for one in parameters if one.kind not in (one.VAR_KEYWORD, one.VAR_POSITIONAL)]
    places = [one.name for one in parameters if one.kind in (one.POSITIONAL_ONLY, one.POSITIONAL_OR_KEYWORD)]
    needed = [one.name for one in parameters if one.name in known and one.default is one.empty]
    given = given[1:] if next(iter(signature.parameters), "") in ("self", "cls") else given
    open_ended = any(one.kind is one.VAR_KEYWORD for one in parameters)
    for key in named:
        if key not in known and not open_ended:
            hint = elsewhere.get(key) or did_you_mean(key, known)
            return CallError(f"unknown name '{key}'; {hint}", key=name)
    if len(given) > len(places):
        words = [*places, *(f"{key}=..." for key in (needed or known) if key not in places)]
        words += ["parameter=..."] * open_ended
        return CallError(f"takes names: write {name}({_some(words)})", key=name)
    for key in places[: len(given)]:
        if key in named:
            return CallError(f"'{key}' is given twice, with its name and without", key=name)
    missing = [key for key in needed if key not in named and key not in places[: len(given)]]
    if missing:
        return CallError(f"lacks {', '.join(missing)}; it needs {', '.join(needed)}", key=name)
    return None


def _some(words: list[str], most: int = 6) -> str:
    return ", ".join(words[:most]) + (", ..." if len(words) > most else "")


def must_be(key: str, value: object, kinds: type[T] | tuple[type[T], ...], hint: str = "") -> T:
    """Return `value`, or raise `InputError` if it is of none of the `kinds`; `hint` says where one comes from."""
    if isinstance(value, kinds):
        return value
    kinds = kinds if isinstance(kinds, tuple) else (kinds,)
    names = " or ".join("dict" if kind is Mapping else kind.__name__ for kind in kinds)
    article = "an" if names[:1] in "AEIO" else "a"
    tail = f"; {hint}" if hint else ""
    raise InputError(f"must be {article} {names}, not {_kind(value)}{tail}", key=key)


def _kind(value: object) -> str:
    return "None" if value is None else type(value).__name__


def listed(key: str, values: Iterable[T], what: str) -> list[T]:
    """Return a list of `values`, or raise `InputError` for what cannot be gone through; text is not a list here."""
    given: object = values
    if isinstance(given, (str, bytes)) or not isinstance(given, Iterable):
        raise InputError(f"must be a list of {what}, not {_kind(given)}", key=key)
    return list(values)


def texts(key: str, values: Iterable[str], what: str) -> tuple[str, ...]:
    """Return names as a tuple; a single one may stand alone."""
    if isinstance(values, tuple) and not values:
        return ()
    names: list[object] = [values] if isinstance(values, str) else [*listed(key, values, what)]
    for one in names:
        if not isinstance(one, str):
            raise InputError(f"must be a list of {what}, and {one!r} is none", key=key)
    return tuple(str(one) for one in names)


def vector(key: str, values: object, what: str) -> NDArray[np.float64]:
    """Return `values` as a vector of float64 (n,), or raise `InputError`: text, complex numbers, another shape."""
    if np.ma.is_masked(values):
        raise InputError("has masked entries, which are missing; fill them in or leave them out", key=key)
    try:
        array = np.asarray(values)
        if array.dtype.kind not in "iufO":
            raise TypeError
        if array.dtype.kind == "O" and array.ndim == 0:
            raise InputError(f"must be {what}, not {_kind(values)}", key=key)
        if array.ndim != 1:
            raise InputError(f"must be {what}, has shape {array.shape}", key=key)
        if array.dtype.kind == "O" and any(isinstance(one, (str, bytes, bool)) for one in array):
            raise TypeError
        if array.dtype == np.float64 and array.flags.c_contiguous:
            return array
        return np.ascontiguousarray(array, dtype=np.float64)
    except (TypeError, ValueError, OverflowError) as error:
        if isinstance(error, InputError):
            raise
        raise InputError(f"must be {what}, real numbers", key=key, value=values) from None


def whole_number(key: str, value: object, *, least: int = 1, most: int = 10**15) -> int:
    """Return a whole number within bounds."""
    if type(value) is int and least <= value <= most:
        return value
    if isinstance(value, (bool, np.bool_)):
        raise InputError("must be a whole number", key=key, value=value)
    size = number(key, value, least=least, most=most)  # type: ignore[arg-type]  # `number` looks
    if size != int(size):
        raise InputError("must be a whole number", key=key, value=value)
    return int(size)


def one_of(key: str, value: object, known: Sequence[str]) -> str:
    """Return `value`, or raise `InputError` if it is none of the `known` words."""
    if isinstance(value, str) and value in known:
        return value
    raise InputError(f"must be one of {', '.join(known)}", key=key, value=value)


def path(key: str, value: object) -> Path:
    """Return a path, or raise `InputError` for what is none."""
    if isinstance(value, (str, os.PathLike)) and isinstance(os.fspath(value), str):
        if value == "":  # an unset variable of a shell; Path would take it for the working folder
            raise InputError("is empty; give a path", key=key)
        try:
            os.stat(value)
        except OSError as error:
            if error.errno in (errno.ENAMETOOLONG, errno.ELOOP):  # others are said where the file is opened
                raise InputError((error.strerror or str(error)).lower(), key=key, value=value) from None
        except ValueError:
            raise InputError("holds a zero byte; no file has such a name", key=key, value=value) from None
        return Path(value)
    raise InputError(f"must be the path of a file, not {_kind(value)}", key=key)
