"""Where the chunks of a sweep go: arrays in memory, or a Zarr store that a later call can go on with.

In a store the status of a chunk is written last and appears whole (Zarr writes beside and renames), so that it
marks the chunk complete: killed at any moment, the store holds whole chunks and ones to be computed again.
"""

from __future__ import annotations

import errno
import hashlib
import json
import shutil
import tempfile
import warnings
from collections.abc import Iterable, Mapping
from functools import lru_cache
from importlib.metadata import version
from pathlib import Path
from types import ModuleType
from typing import TYPE_CHECKING, Any, Protocol, cast

import numpy as np

from stickslip import _core
from stickslip.declared.model import Model
from stickslip.declared.rig import Rig
from stickslip.errors import InputError
from stickslip.files import whole
from stickslip.simulated.sweep.observables import NOT_COMPUTED, OBSERVABLES, STATUS_FLAGS, Arrays
from stickslip.simulated.sweep.request import GridBlock, Request
from stickslip.simulated.sweep.units import in_si, unit_of

if TYPE_CHECKING:
    import xarray as xr
    import zarr
    from zarr.core.common import JSON

    JSONTable = dict[str, JSON]

KIND = "stickslip sweep"
OF_SI = {"time": "s", "energy": "J"}


class Sink(Protocol):
    """Takes chunks."""

    def missing(self, blocks: Iterable[GridBlock]) -> Iterable[GridBlock]:
        """Those of the chunks that are not there yet."""

    def put(self, block: GridBlock, arrays: Arrays) -> None:
        """Keep a chunk."""

    def dataset(self) -> xr.Dataset:
        """What is there."""


def dims(request: Request, name: str) -> tuple[str, ...]:
    """Dimensions of a result."""
    return (*request.grid.sizes, *OBSERVABLES[name].dims)


def coordinates(request: Request) -> dict[str, tuple[str, object, dict[str, str]]]:
    """Coordinates: every varied name along its dimension, and the names of the states."""
    coords: dict[str, tuple[str, object, dict[str, str]]] = {
        column.name: (column.dim, column.values, {"units": unit_of(request.model, column.name)})
        for column in request.grid.columns
    }
    if any("state" in OBSERVABLES[name].dims for name in request.observe):
        names = request.model.rig.state_names
        units = ", ".join(unit_of(request.model, f"initial.{name}") for name in names)
        coords["state"] = ("state", np.array(names, dtype=str), {"units": units})
    return coords


def variable_attrs(request: Request, name: str) -> dict[str, object]:
    """Meaning and unit of a result."""
    one = OBSERVABLES[name]
    attrs: dict[str, object] = {"long_name": one.meaning, "units": _unit(request, one.unit)}
    if name == "status":
        attrs["flag_values"] = list(range(NOT_COMPUTED, len(STATUS_FLAGS) - 1))
        attrs["flag_meanings"] = " ".join(STATUS_FLAGS)
    return attrs


def _unit(request: Request, unit: str) -> str:
    """All is nondimensional in (2.1); a rig whose units nobody has said is in whatever its numbers are in."""
    if unit in OF_SI and in_si(request.model):
        return OF_SI[unit]
    return "1" if unit == "1" or isinstance(request.model.rig, Rig) else f"{unit}, in the rig's units"


def attributes(request: Request) -> dict[str, object]:
    """Provenance: what was asked, of what model, by which build."""
    rig = request.model.rig
    scales = getattr(rig, "scales", None)
    named = {f"initial.{n}": v for n, v in zip(rig.state_names, request.initial, strict=False)}
    varied = {column.name for column in request.grid.columns}
    fixed = {**request.fixed_speeds, **named}
    return {
        "title": KIND,
        "version": version("stickslip"),
        "build_config": json.dumps(_core.build_config()),
        "model": _toml(request.model),
        "fixed": json.dumps({name: value for name, value in fixed.items() if name not in varied}),
        "scales": "" if scales is None else repr(scales),
        "t_end": request.t_end,
        "after": request.after,
        "rtol": request.rtol,
        "atol": request.atol,
        "lanes": int(request.lanes),
    }


@lru_cache(maxsize=16)
def _toml(model: Model) -> str:
    """The model's text; small sweeps are often repeated."""
    return model.toml()


class MemorySink:
    """Arrays of the whole grid."""

    def __init__(self, request: Request) -> None:
        self.request = request
        self.arrays: Arrays = {}
        for name in request.observe:
            one = OBSERVABLES[name]
            shape = (*request.grid.shape, *request.extra(name))
            self.arrays[name] = np.full(shape, one.fill, dtype=one.dtype)

    def missing(self, blocks: Iterable[GridBlock]) -> Iterable[GridBlock]:
        """All."""
        return blocks

    def put(self, block: GridBlock, arrays: Arrays) -> None:
        """Keep a chunk."""
        for name, values in arrays.items():
            self.arrays[name][block.index] = values.reshape(*block.shape, *self.request.extra(name))

    def dataset(self) -> xr.Dataset:
        """What is there; status -1 where nothing is."""
        import xarray as xr

        r = self.request
        data = {
            name: (dims(r, name), values, variable_attrs(r, name)) for name, values in self.arrays.items()
        }
        return xr.Dataset(data, coords=coordinates(r), attrs=attributes(r))


class ZarrSink:
    """A Zarr store, made here or gone on with.

    Raises
    ------
    InputError
        zarr is not installed, the path is something else, or the store is of a sweep with other settings.
    """

    def __init__(self, request: Request, path: Path) -> None:
        self.request, self.path = request, path
        module = _zarr()
        if there_is(path) or not _made(module, request, path):
            _same_sweep(module, request, path)
        self.group = module.open_group(str(path), mode="r+")
        _mended(self.group, request)

    def missing(self, blocks: Iterable[GridBlock]) -> Iterable[GridBlock]:
        """Those whose status was not written, or that have lost a chunk of another result since.

        Raises
        ------
        InputError
            A chunk cannot be read.
        """
        for block in blocks:
            there = all(self._is_there(name, block) for name in self.request.observe)
            there = there and self._sums(block).is_file()
            if not there or np.any(self._read("status", block) == NOT_COMPUTED):
                yield block
            else:
                self._check(block)

    def _check(self, block: GridBlock) -> None:
        """Read every result of a chunk, and see that it is the one that was written in this place."""
        sums = self._sums(block).read_text(encoding="utf-8").split()
        for name, there in zip(sorted(self.request.observe), sums, strict=False):
            if _sum(self._read(name, block)) != there:
                words = f"the chunk {self._file(name, block)} is not the one written there; remove that file"
                raise InputError(f"{words} to have it computed again", key="out", value=str(self.path))

    def _sums(self, block: GridBlock) -> Path:
        """The file of a chunk's checksums, in the order of the results' names; within an array Zarr passes over it."""
        place = self._file("status", block).removeprefix("status/").replace("/", ".")
        return self.path / "status" / "sums" / place

    def _read(self, name: str, block: GridBlock) -> np.ndarray[Any, Any]:
        """A chunk, which reading proves whole: that takes far less than computing it."""
        try:
            return np.asarray(self._array(name)[block.index])
        except (RuntimeError, ValueError, OSError) as error:
            at = self._file(name, block)
            words = f"the chunk {at} is damaged ({error}); remove that file to have it computed again"
            raise InputError(words, key="out", value=str(self.path)) from None

    def _is_there(self, name: str, block: GridBlock) -> bool:
        return (self.path / self._file(name, block)).is_file()

    def _file(self, name: str, block: GridBlock) -> str:
        """Of a chunk, in the store."""
        array = self._array(name)
        place = [one.start // size for one, size in zip(block.index, array.chunks, strict=False)]
        place += [0] * (array.ndim - len(place))
        return f"{name}/{array.metadata.encode_chunk_key(tuple(place))}"

    def put(self, block: GridBlock, arrays: Arrays) -> None:
        """Write a chunk, its status last; also one of fill values alone, which is not one that was lost."""
        sums = [
            _sum(np.asarray(arrays[name], self._array(name).dtype)) for name in sorted(self.request.observe)
        ]
        with whole(self._sums(block)) as beside:
            beside.write_text("\n".join(sums), encoding="utf-8")
        with _zarr().config.set({"array.write_empty_chunks": True}):
            for name in sorted(arrays, key=lambda name: name == "status"):
                values = arrays[name].reshape(*block.shape, *self.request.extra(name))
                every = tuple(slice(None) for _ in self.request.extra(name))
                self._array(name)[(*block.index, *every)] = values

    def dataset(self) -> xr.Dataset:
        """The store, opened lazily."""
        import xarray as xr

        ds = xr.open_dataset(str(self.path), engine="zarr", chunks=None, consolidated=False)
        states = np.array(self.request.model.rig.state_names, dtype=str)
        return ds.assign_coords(state=states) if "state" in ds.coords else ds

    def _array(self, name: str) -> zarr.Array[Any]:
        return cast("zarr.Array[Any]", self.group[name])


def _sum(values: np.ndarray[Any, Any]) -> str:
    return hashlib.sha256(np.ascontiguousarray(values).tobytes()).hexdigest()


def there_is(path: Path) -> bool:
    """
    Return whether there is something at a path.

    Raises
    ------
    InputError
        No file can be called that.
    """
    try:
        return path.exists()
    except (OSError, ValueError) as error:  # a name too long, or none that a file can have
        words = getattr(error, "strerror", None) or error
        raise InputError(f"cannot be a path ({words})", key="out", value=str(path)) from None


def _zarr() -> ModuleType:
    try:
        import zarr
    except ImportError:
        raise InputError("needs zarr; pip install 'stickslip[sweep]'", key="out") from None
    return zarr


def _settings(request: Request) -> dict[str, object]:
    return cast("dict[str, object]", json.loads(json.dumps(request.settings())))


def _same_sweep(module: ModuleType, request: Request, path: Path) -> None:
    try:
        attrs: Mapping[str, object] = module.open_group(str(path), mode="r").attrs.asdict()
    except (FileNotFoundError, NotADirectoryError, ValueError):
        attrs = {}
    if attrs.get("title") != KIND:
        raise InputError(
            "exists and is not a store of a sweep; give another path", key="out", value=str(path)
        )
    there, now = cast("dict[str, object]", attrs.get("settings", {})), _settings(request)
    differing = [name for name in now if there.get(name) != now[name]]
    if not differing:
        for name in (*coordinates(request), *request.observe):
            _array_is_there(module, path, name)
        group = module.open_group(str(path), mode="r")
        _same_order(group, request, path)
        _same_chunks(group, request, path)
        return
    name = differing[0]
    detail = "" if name in ("model", "over") else f": there {there.get(name, 'unknown')}, here {now[name]}"
    raise InputError(
        f"holds a sweep with another {' and another '.join(differing)}{detail}; give the same or another path",
        key="out",
        value=path.name,
    )


def _array_is_there(module: ModuleType, path: Path, name: str) -> None:
    if not (path / name / "zarr.json").is_file():
        words = f"has no array '{name}': it is damaged; give another path"
        raise InputError(words, key="out", value=str(path))
    try:
        module.open_array(str(path / name), mode="r")
    except (ValueError, KeyError, TypeError) as error:
        words = f"has an array '{name}' that cannot be read ({error}): it is damaged; give another path"
        raise InputError(words, key="out", value=str(path)) from None


def _same_chunks(group: zarr.Group, request: Request, path: Path) -> None:
    for name in request.observe:
        array, extra = cast("Any", group[name]), request.extra(name)
        if array.shape != (*request.grid.shape, *extra) or array.chunks != (*request.block_shape, *extra):
            words = f"has an array '{name}' of another shape: it is damaged; give another path"
            raise InputError(words, key="out", value=str(path))


def _mended(group: zarr.Group, request: Request) -> None:
    """Write coordinates anew that have been lost or damaged since: that the sweep is the same is known."""
    for name, (_, values, _) in coordinates(request).items():
        array, data = cast("Any", group[name]), _stored(np.asarray(values))
        try:
            if np.array_equal(array[:], data):
                continue
        except (RuntimeError, ValueError, OSError):
            pass
        array[:] = data


def _stored(values: np.ndarray[Any, Any]) -> np.ndarray[Any, Any]:
    return values.astype(object) if values.dtype.kind == "U" else values


def _same_order(group: zarr.Group, request: Request, path: Path) -> None:
    """The chunks of a store lie in the order of its dimensions, and another order is not the same sweep."""
    there = [str(dim) for dim in cast("Any", group["status"]).metadata.dimension_names]
    if there != list(request.grid.sizes):
        said = f"holds this sweep with its dimensions in the order {', '.join(there)}"
        raise InputError(f"{said}; give them in that order, or another path", key="out", value=path.name)


def _made(module: ModuleType, request: Request, path: Path) -> bool:
    """Make an empty store beside and rename it, so that there is never half of one; False if another was quicker."""
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        beside = Path(tempfile.mkdtemp(dir=path.parent, prefix=f".{path.name}."))
    except (OSError, ValueError) as error:
        words = getattr(error, "strerror", None) or error
        raise InputError(f"cannot be written ({words})", key="out", value=str(path)) from None
    try:
        _fill(module.open_group(str(beside), mode="w", zarr_format=3), request)
        with warnings.catch_warnings():
            warnings.simplefilter(
                "ignore"
            )  # that the format does not settle it yet; readers look for it and warn
            module.consolidate_metadata(str(beside))
        beside.chmod(0o755)
        beside.rename(path)
    except OSError as error:
        if error.errno not in (errno.ENOTEMPTY, errno.EEXIST):
            raise
        return False
    finally:
        shutil.rmtree(beside, ignore_errors=True)
    return True


def _fill(group: zarr.Group, request: Request) -> None:
    from zarr.codecs import ZstdCodec

    coords = coordinates(request)
    group.attrs.update(cast("JSONTable", {**attributes(request), "settings": _settings(request)}))
    outer = [name for name in coords if name not in (*request.grid.sizes, "state")]
    for name, (dim, values, attrs) in coords.items():
        data = np.asarray(values)
        kind = "string" if data.dtype.kind == "U" else data.dtype.name
        array = group.create_array(
            name, shape=data.shape, dtype=kind, dimension_names=(dim,), attributes=cast("JSONTable", attrs)
        )
        array[:] = _stored(data)
    for name in request.observe:
        one, extra = OBSERVABLES[name], request.extra(name)
        about = variable_attrs(request, name) | ({"coordinates": " ".join(outer)} if outer else {})
        group.create_array(
            name,
            shape=(*request.grid.shape, *extra),
            chunks=(*request.block_shape, *extra),
            dtype=one.dtype,
            fill_value=one.fill,
            dimension_names=dims(request, name),
            attributes=cast("JSONTable", about),
            compressors=ZstdCodec(checksum=True),  # so that reading a chunk proves it whole
        )
