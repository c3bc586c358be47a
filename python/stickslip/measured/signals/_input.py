"""What every function of this package asks of the arrays it is given."""

import numpy as np
from numpy.typing import ArrayLike, NDArray

from stickslip.errors import InputError

Floats = NDArray[np.float64]
Booleans = NDArray[np.bool_]


def real_array(values: ArrayLike, name: str) -> Floats:
    """`values` as a C-contiguous float64 array; text, complex numbers, objects and masked samples are refused."""
    refuse_masked(values, name)
    array = np.asarray(values)
    if array.dtype.kind not in "fiub" and not (array.dtype.kind == "O" and _all_real(array)):
        raise InputError(f"{name} must hold real numbers, not {array.dtype}")
    return np.asarray(array, dtype=np.float64, order="C")


def refuse_masked(values: object, name: str) -> None:
    """Raise `InputError` for a masked array with masked samples, which would be used as if they were good."""
    if not np.ma.isMaskedArray(values) or not np.ma.is_masked(values):
        return
    mask = np.ma.getmaskarray(values)
    where = np.unravel_index(int(np.argmax(mask)), mask.shape)
    at = ", ".join(str(int(i)) for i in where)
    count = int(mask.sum())
    words = f"{name} has {count} masked sample{'' if count == 1 else 's'}, the first {name}[{at}]"
    raise InputError(f"{words}; masked samples are missing: cut the signal there or fill them in")


def _all_real(array: NDArray[np.object_]) -> bool:
    return all(isinstance(v, (int, float, np.floating, np.integer)) for v in array.flat)


def first_bad(array: Floats, name: str) -> str:
    """Say where the first NaN or infinity of `array` is."""
    where = np.unravel_index(int(np.argmin(np.isfinite(array))), array.shape)
    at = ", ".join(str(int(i)) for i in where)
    return f"{name}[{at}] is {array[where]}; every sample must be a finite number"


def finite_vector(values: ArrayLike, name: str, *, at_least: int = 0) -> Floats:
    """`values` as an (n,) float64 array of finite numbers with n >= `at_least`."""
    array = real_array(values, name)
    if array.ndim != 1:
        raise InputError(f"{name} must be one channel, shape (n,), not {array.shape}")
    if not np.isfinite(array).all():
        raise InputError(first_bad(array, name))
    if array.size < at_least:
        raise InputError(f"{name} has {array.size} samples; at least {at_least} are needed")
    return array


def positive(value: object, name: str) -> float:
    """`value` as a finite float > 0."""
    if not isinstance(value, (int, float, np.integer, np.floating)) or not (np.isfinite(value) and value > 0):
        raise InputError(f"{name} must be a positive number, not {value!r}")
    return float(value)


def finite(value: object, name: str) -> float:
    """`value` as a finite float."""
    if not isinstance(value, (int, float, np.integer, np.floating)) or not np.isfinite(value):
        raise InputError(f"{name} must be a finite number, not {value!r}")
    return float(value)
