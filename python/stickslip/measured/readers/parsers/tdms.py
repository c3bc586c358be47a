"""TDMS files of LabVIEW: channels scaled as their properties say, once, and the times of their waveforms."""

from __future__ import annotations

import os
import struct
from collections.abc import Container
from typing import IO, Any

import numpy as np
from nptdms import TdmsFile

LEAD = 28  # bytes of a segment's lead-in; its length from there is a number of 8 bytes at byte 12
BIG_ENDIAN = 1 << 6  # in the flags at byte 4


_LOOKED_INTO: list[tuple[str, int, int, IO[bytes], TdmsFile, bool]] = []  # one, until its columns are read


def opened(file: str, again: bool) -> tuple[IO[bytes], TdmsFile, bool]:
    """Return a file, its segments, and whether it is cut off; `again`: as it was looked into just before.

    A file of many segments takes seconds to look through. The index beside it, which may be stale, is not read.
    """
    status = os.stat(file)
    key = (file, status.st_size, status.st_mtime_ns)
    if _LOOKED_INTO:
        *before, stream, tdms, is_cut = _LOOKED_INTO.pop()
        if again and tuple(before) == key:
            return stream, tdms, is_cut
        stream.close()
    stream = open(file, "rb")  # noqa: SIM115  # closed by who reads columns, or before the next file
    try:
        found = stream, TdmsFile.open(stream), _is_cut(file)
    except BaseException:
        stream.close()
        raise
    if not again:
        _LOOKED_INTO.append((*key, *found))
    return found


def answer(file: str, names: list[str]) -> tuple[dict[str, Any], list[np.ndarray]]:
    """Return what the file holds, and the columns asked for."""
    stream, tdms, is_cut = opened(file, again=bool(names))
    if not names:
        return _answer(tdms, is_cut, names)
    with stream:
        return _answer(tdms, is_cut, names)


def _answer(tdms: TdmsFile, is_cut: bool, names: list[str]) -> tuple[dict[str, Any], list[np.ndarray]]:
    every = [(group.name, one) for group in tdms.groups() for one in group.channels()]
    channels = {f"{group}/{one.name}": one for group, one in every}
    grids = _grids(every, channels)
    known = [*grids, *(f"{group}/{one.name}" for group, one in every)]  # twice: no column has such a name
    head: dict[str, Any] = {
        "known": known,
        "units": {name: str(one.properties.get("unit_string", "")) for name, one in channels.items()}
        | dict.fromkeys(grids, "s"),
        "also": _also(known),
        "facts": [f"{len(tdms.groups())} groups, {len(channels)} channels"],
        "doubts": ["its last segment is incomplete; was the file cut off?"] if is_cut else [],
        "paths": True,
        "times": [],
    }
    if any(known.count(name) != 1 for name in names):
        return head, []
    columns = []
    for name in names:
        values = _times(*grids[name]) if name in grids else channels[name][:]
        if values.dtype.kind == "M":
            head["times"].append(name)
            values = (values - values[:1]).astype("timedelta64[ns]").astype(np.float64) * 1e-9
        if values.dtype.kind not in "iufb":
            return {
                **head,
                "fault": f"holds {values.dtype.name}; a channel is numbers",
                "column": name,
            }, []
        columns.append(values.astype(np.float64))
    return head, columns


def _is_cut(file: str) -> bool:
    """Whether the file ends within a segment; npTDMS passes over a header that is not whole."""
    size, at = os.path.getsize(file), 0
    with open(file, "rb") as stream:
        while at < size:
            stream.seek(at)
            lead = stream.read(LEAD)
            if len(lead) < LEAD:
                return True
            order = ">" if lead[4] & BIG_ENDIAN else "<"
            length = struct.unpack(f"{order}Q", lead[12:20])[0]
            at += LEAD + length
    return at != size


def _grids(every: list[tuple[str, Any]], names: Container[str]) -> dict[str, tuple[float, float, int]]:
    """Start, step and number of the times of each group's waveforms; a further grid is named after its channel."""
    grids: dict[str, tuple[float, float, int]] = {}
    of: dict[str, list[tuple[float, float, int]]] = {group: [] for group, _ in every}
    for group, channel in every:
        said = channel.properties
        step = said.get("wf_increment")
        if not isinstance(step, float) or not step > 0 or said.get("wf_xunit_string", "s") not in ("", "s"):
            continue
        grid = (float(said.get("wf_start_offset", 0.0)), step, len(channel))
        if grid in of[group]:
            continue
        alone = not of[group] and f"{group}/t" not in names
        grids[f"{group}/t" if alone else f"{group}/t of {channel.name}"] = grid
        of[group].append(grid)
    return grids


def _times(first: float, step: float, count: int) -> np.ndarray:
    return first + step * np.arange(count)


def _also(known: list[str]) -> dict[str, str]:
    """Channels by their bare names, where only one has it."""
    bare = [name.rpartition("/")[2] for name in known]
    return {short: name for short, name in zip(bare, known, strict=True) if bare.count(short) == 1}
