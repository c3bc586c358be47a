"""Which of a sweep's coordinates a figure draws along its axes, and what it refuses to draw."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from stickslip.arguments import must_be
from stickslip.errors import InputError, did_you_mean

if TYPE_CHECKING:
    import xarray as xr


def observed(ds: xr.Dataset, name: str) -> xr.DataArray:
    """Return a result of the sweep; refuse one that was not observed."""
    import xarray as xr

    must_be("dataset", ds, xr.Dataset, "sweep gives one")
    if not isinstance(name, str):
        raise InputError("must be a name", key="variable", value=name)
    if name not in ds:
        raise InputError(f"not in the dataset; sweep with observe=('{name}', ...)", key=name)
    return ds[name]


def two(ds: xr.Dataset, dims: list[str]) -> tuple[str, str]:
    """Names of the ordinate and the abscissa of cells; refuse values that would have the same place."""
    if len(dims) != 2:
        rest = _choose(ds, dims) if len(dims) == 3 else ""
        raise InputError(f"needs two dimensions, has {_listed(dims)}{rest}", key="dataset")
    found = coordinate(ds, None, dims[0]), coordinate(ds, None, dims[1])
    for name in found:
        if (value := repeated(ds, name)) is not None:
            raise InputError(
                f"{name} has the value {value:g} more than once; its cells would hide each other",
                key="dataset",
            )
    return found


def second(ds: xr.Dataset, dims: list[str], along: str, most: int) -> str | None:
    """Name of the parameter that varies beside the abscissa and takes a colour a value; None if only starts do.

    Raises
    ------
    InputError
        There are several, or one of more than `most` values.
    """
    others = [dim for dim in dims if not _is_start(ds, dim)]
    if not others:
        return None
    if len(others) > 1 or ds.sizes[others[0]] > most:
        sizes = ", ".join(f"{dim} ({ds.sizes[dim]} values)" for dim in others)
        raise InputError(
            f"a diagram over {along} cannot tell {sizes} apart{_choose(ds, others)}", key="dataset"
        )
    return coordinate(ds, None, others[0])


def starts(ds: xr.Dataset, dims: list[str]) -> tuple[str, str]:
    """Names of the two initial values of a basin, ordinate and abscissa."""
    others = [dim for dim in dims if not _is_start(ds, dim)]
    if others:
        rest = _choose(ds, others) if len(dims) - len(others) == 2 else ""
        raise InputError(
            f"a basin is drawn over two initial values, such as initial.x1 and initial.x2; {_listed(others)} "
            f"{'is' if len(others) == 1 else 'are'} not{rest}",
            key="dataset",
        )
    return two(ds, dims)


def _is_start(ds: xr.Dataset, dim: str) -> bool:
    """Whether nothing but initial values varies along a dimension."""
    names = [str(one) for one, values in ds.coords.items() if values.dims == (dim,)]
    return bool(names) and all(one.startswith("initial.") for one in names)


def _listed(dims: list[str]) -> str:
    return " and ".join(dims) if dims else "none"


def _choose(ds: xr.Dataset, dims: list[str]) -> str:
    """What to write to be left with one value of a dimension, with a value that it has."""
    if not dims:
        return ""
    dim = dims[-1]
    if dim in ds.coords:
        example = f"ds.sel({{'{dim}': {float(ds[dim].values[0]):.4g}}}, method='nearest')"
    else:
        example = f"ds.isel({{'{dim}': 0}})"
    return f"; choose one value, as in {example}"


def coordinate(ds: xr.Dataset, name: str | None, dim: str) -> str:
    """Name of a coordinate along `dim`; of a shared dimension the first that has no value twice, if any.

    Raises
    ------
    InputError
        There is none of that name, or none along the dimension.
    """
    names = [str(one) for one, values in ds.coords.items() if values.ndim == 1 and one != "state"]
    if name is None:
        along = [one for one in names if ds[one].dims == (dim,)]
        if not along:
            hint = (
                _choose(ds, [dim])
                if dim == "point"
                else f"; ds.assign_coords({{'{dim}': ...}}) gives it some"
            )
            raise InputError(f"has no values along {dim}{hint}", key="dataset")
        return next((one for one in along if repeated(ds, one) is None), along[0])
    if name not in names:
        raise InputError(f"unknown parameter; {did_you_mean(name, names)}", key="parameter", value=name)
    return name


def repeated(ds: xr.Dataset, name: str) -> float | None:
    """Return the first value that a coordinate has more than once."""
    values, counts = np.unique(ds[name].values, return_counts=True)
    return float(values[counts > 1][0]) if (counts > 1).any() else None
