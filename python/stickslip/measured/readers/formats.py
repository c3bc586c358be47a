"""Which kind a file is: by its first bytes, or by its name where they say nothing."""

from __future__ import annotations

from pathlib import Path

from stickslip.errors import InputError, Place
from stickslip.measured.readers import matlab
from stickslip.measured.readers.container import Format
from stickslip.measured.readers.lvm import MAGIC as LVM_MAGIC

HDF5 = Format("HDF5", "hdf5", "h5py")
TDMS = Format("TDMS", "tdms", "npTDMS")
PARQUET = Format("Parquet", "parquet", "pyarrow")
WAV = Format("WAV", "wav")
MATLAB = Format("MATLAB", "matlab", outline=matlab.fault)
LVM = "LVM"
TEXT = "text"

_HDF5_MAGIC = b"\x89HDF\r\n\x1a\n"
_BY_NAME: dict[str, Format | str] = {
    ".tdms": TDMS,
    ".h5": HDF5,
    ".hdf5": HDF5,
    ".hdf": HDF5,
    ".parquet": PARQUET,
    ".pq": PARQUET,
    ".wav": WAV,
    ".mat": MATLAB,
    ".lvm": LVM,
}
_REFUSED = {
    b"TDSh": "the index of a TDMS file; give the .tdms file that it belongs to",
    b"PK\x03\x04": "an Excel workbook or another ZIP archive; save the sheet as CSV, or unpack it",
    b"\xd0\xcf\x11\xe0": "an old Excel workbook; save the sheet as CSV",
    b"\x1f\x8b": "compressed by gzip; unpack it",
    b"\x28\xb5\x2f\xfd": "compressed by zstd; unpack it",
    b"BZh": "compressed by bzip2; unpack it",
    b"\xfd7zXZ": "compressed by xz; unpack it",
    b"\x89MCAP": "an MCAP log; export its channels as CSV or Parquet",
    b"%PDF": "a PDF; the numbers are wanted, as CSV",
}


def kind_of(file: Path) -> Format | str:
    """Return the kind of a file.

    Raises
    ------
    InputError
        It cannot be read, or is of a known kind that is not read here.
    """
    try:
        with file.open("rb") as stream:
            first = stream.read(4096)
    except OSError as error:
        raise InputError(f"cannot be read ({error.strerror})", place=Place(str(file))) from None
    for magic, words in _REFUSED.items():
        if first.startswith(magic):
            raise InputError(words, place=Place(str(file)))
    found = _by_content(first)
    kind = _BY_NAME.get(file.suffix.lower(), TEXT) if found is None else found
    if not first and kind is not TEXT:
        raise InputError("empty: it has 0 bytes; was it ever written to?", place=Place(str(file)))
    return kind


def _by_content(first: bytes) -> Format | str | None:
    if any(
        first.startswith(_HDF5_MAGIC, at) for at in (0, 512, 1024, 2048)
    ):  # MATLAB 7.3 has 512 bytes before it
        return HDF5
    if first.startswith(b"TDSm"):
        return TDMS
    if first.startswith(b"PAR1"):
        return PARQUET
    if first[:4] in (b"RIFF", b"RIFX", b"RF64") and first[8:12] == b"WAVE":
        return WAV
    if first.startswith(b"MATLAB 5.0 MAT-file"):
        return MATLAB
    begin = first[: 4 * len(LVM_MAGIC)]
    if any(LVM_MAGIC.encode(one) in begin for one in ("utf-8", "utf-16-le", "utf-16-be")):
        return LVM
    return None
