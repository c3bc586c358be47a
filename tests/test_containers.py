"""Binary files made by their formats' own writers, real ones that packages ship, and damaged ones."""

from __future__ import annotations

import json
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
import scipy.io

import stickslip as ss
from stickslip.measured.inspection import inspect
from stickslip.measured.readers import process
from stickslip.measured.readers.tables import Source, open_table, read_columns

h5py = pytest.importorskip("h5py")
nptdms = pytest.importorskip("nptdms")
pa = pytest.importorskip("pyarrow")
pq = pytest.importorskip("pyarrow.parquet")

N = 200
T = 0.002 * np.arange(N)
F = 1.5 + 0.4 * np.sin(0.3 * np.arange(N))
RIG = ss.BlockOnBelt(mass=0.5, stiffness=500.0)
HOME = {name: Path(module.__file__).parent for name, module in (("tdms", nptdms), ("pa", pa), ("h5", h5py))}  # type: ignore[arg-type]


def hdf5(file: Path) -> None:
    with h5py.File(file, "w") as f:
        f["run/t"], f["run/F"] = T, F
        f["run/F"].attrs["units"] = "N"


def matlab73(file: Path) -> None:
    with h5py.File(file, "w", userblock_size=512) as f:
        for name, values in (("run/t", T), ("run/F", F)):
            f[name] = values[None]
            f[name].attrs["MATLAB_class"] = np.bytes_("double")
    with file.open("r+b") as stream:
        stream.write(b"MATLAB 7.3 MAT-file, Platform: GLNXA64".ljust(124) + b"\x00\x02IM")


def tdms(file: Path) -> None:
    properties = {"unit_string": "N", "wf_increment": 0.002, "wf_start_offset": 0.0}
    with nptdms.TdmsWriter(file) as writer:
        for part in np.array_split(F, 10):  # LabVIEW writes a segment a packet
            writer.write_segment([nptdms.ChannelObject("run", "F", part, properties=properties)])


def parquet(file: Path) -> None:
    fields = [pa.field("t", pa.float64()), pa.field("F", pa.float64(), metadata={"unit": "N"})]
    pq.write_table(pa.table({"t": T, "F": F}, schema=pa.schema(fields)), file, compression="snappy")


def wav(file: Path) -> None:
    scipy.io.wavfile.write(file, 500, F / 2)


WRITERS: dict[str, Callable[[Path], None]] = {
    "run.h5": hdf5,
    "run.mat": matlab73,
    "run.tdms": tdms,
    "run.parquet": parquet,
    "run.wav": wav,
}


@pytest.fixture(params=WRITERS)
def file(request: pytest.FixtureRequest, tmp_path: Path) -> Path:
    WRITERS[request.param](tmp_path / request.param)
    return tmp_path / str(request.param)


def force(file: Path) -> str:
    return "channel 1" if file.read_bytes()[:4] == b"RIFF" else "F"


def numbers(source: Source, names: list[str], units: dict[str, str] | None = None) -> dict[str, np.ndarray]:
    columns = source.read(names, units or {})
    return columns.values


def load(file: Path, unit: str = "N") -> ss.Recording:
    channels = {"t": ss.Channel("t", "s"), "spring_force": ss.Channel(force(file), unit)}
    return ss.load_recording(file, RIG, channels=channels, belt_speed="5 mm/s")


@pytest.mark.parametrize("other", [None, ".csv", ".dat"])
def test_a_file_is_known_by_its_content(file: Path, other: str | None) -> None:
    run = load(file if other is None else file.rename(file.with_suffix(other)), "N")
    np.testing.assert_allclose(run.t, T, atol=1e-12)
    scale = 2 if "channel 1" in open_table(run.source).contents.names else 1
    np.testing.assert_allclose(scale * run.x1 * 500, F, rtol=1e-12)


def test_the_files_own_unit_speaks_against_the_declared_one(file: Path) -> None:
    if file.suffix in (".wav", ".mat"):  # they say none
        return
    with pytest.raises(ss.InputError, match=r"in N', but its channel is declared in 'mN'"):
        load(file, "mN")


def test_a_column_that_is_not_there_has_its_neighbour_named(file: Path) -> None:
    with pytest.raises(ss.InputError, match=r"column 'Fx': missing; the file has"):
        read_columns(file, ["Fx"])


def test_a_library_that_is_not_there_is_named(tmp_path: Path) -> None:
    hdf5(tmp_path / "run.h5")
    program = tmp_path / "parser.py"
    program.write_text(
        f"import sys; sys.modules['h5py'] = None; sys.path.insert(0, {str(process.PROGRAM.parent)!r})\n"
        "import main; main.main()\n"
    )
    process.PROCESS.close()
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(process, "PROGRAM", program)
        with pytest.raises(
            ss.InputError, match=r"run.h5: a HDF5 file needs h5py: pip install 'stickslip\[files\]'"
        ):
            read_columns(tmp_path / "run.h5", ["F"])
    process.PROCESS.close()


# what each format has of its own


@pytest.mark.parametrize("status", ["unscaled", "scaled", None])
def test_tdms_is_scaled_once(tmp_path: Path, status: str | None) -> None:
    raw = np.arange(N, dtype=np.int16)
    properties = {
        "NI_Number_Of_Scales": 1,
        "NI_Scale[0]_Scale_Type": "Linear",
        "NI_Scale[0]_Linear_Slope": 0.5,
        "NI_Scale[0]_Linear_Y_Intercept": 10.0,
        "NI_Scale[0]_Linear_Input_Source": 0xFFFFFFFF,
    }
    properties |= {} if status is None else {"NI_Scaling_Status": status}
    with nptdms.TdmsWriter(tmp_path / "run.tdms") as writer:
        writer.write_segment([nptdms.ChannelObject("g", "F", raw, properties=properties)])
    values = numbers(open_table(tmp_path / "run.tdms"), ["F"])["F"]
    np.testing.assert_array_equal(values, raw if status == "scaled" else 0.5 * raw + 10)


def test_tdms_dates_and_rates(tmp_path: Path) -> None:
    when = np.datetime64("2024-03-05T10:11:12") + (T * 1e6).round().astype("m8[us]")
    step = {"wf_increment": 0.002}
    with nptdms.TdmsWriter(tmp_path / "run.tdms") as writer:
        writer.write_segment(
            [
                nptdms.ChannelObject("a", "when", when),
                nptdms.ChannelObject("a", "F", F, properties=step),
                nptdms.ChannelObject("a", "slow", F[::2], properties={"wf_increment": 0.004}),
                nptdms.ChannelObject("b", "F", F, properties={**step, "wf_start_offset": 1.0}),
                nptdms.ChannelObject("b", "label", ["x"] * 3),
            ]
        )
    source = open_table(tmp_path / "run.tdms")
    assert source.contents.names[:3] == ("a/t", "a/t of slow", "b/t")
    np.testing.assert_allclose(numbers(source, ["when"], {"when": "ms"})["when"], 1e3 * T, atol=1e-3)
    np.testing.assert_allclose(numbers(source, ["b/t"], {})["b/t"], 1 + T)
    for names, units, words in (
        (["when"], {"when": "mm"}, "dates or spans of time, but the channel is declared in 'mm'"),
        (["a/F", "slow"], {}, "a/F has 200 samples, slow has 100 samples"),
        (["F"], {}, "column 'F': missing"),  # there are two
        (["label"], {}, "a channel is numbers"),
    ):
        with pytest.raises(ss.InputError, match=words):
            source.read(names, units)


def test_two_tdms_channels_of_one_name_are_refused(tmp_path: Path) -> None:
    """Group a/b with c and group a with b/c: the second one was read for both."""
    step = {"wf_increment": 0.002}
    with nptdms.TdmsWriter(tmp_path / "run.tdms") as writer:
        writer.write_segment(
            [
                nptdms.ChannelObject("a/b", "c", F, properties=step),
                nptdms.ChannelObject("a", "b/c", -F, properties=step),
                nptdms.ChannelObject("a/t", "d", F, properties=step),
            ]
        )
    source = open_table(tmp_path / "run.tdms")
    with pytest.raises(ss.InputError, match="column 'a/b/c': there 2 times; which one is meant"):
        source.read(["a/b/c"], {})
    assert sorted(source.contents.names) == ["a/b/c", "a/b/c", "a/b/t", "a/t", "a/t/d", "a/t/t"]
    np.testing.assert_array_equal(numbers(source, ["a/t/d"])["a/t/d"], F)
    assert any("a/b/c: there 2 times" in one for one in inspect(tmp_path / "run.tdms").doubts)


def test_a_stale_index_of_tdms_is_not_read(tmp_path: Path) -> None:
    tdms(tmp_path / "run.tdms")
    (tmp_path / "run.tdms_index").write_bytes(b"TDSh" + bytes(24))
    np.testing.assert_allclose(numbers(open_table(tmp_path / "run.tdms"), ["F"])["F"], F)
    with pytest.raises(ss.InputError, match=r"the index of a TDMS file; give the .tdms file"):
        read_columns(tmp_path / "run.tdms_index", ["F"])


def test_hdf5_matrices_tables_and_packed_numbers(tmp_path: Path) -> None:
    with h5py.File(tmp_path / "run.h5", "w") as f:
        f["data"] = np.c_[T, F]
        f["table"] = np.rec.fromarrays([T, F], names="t,F")
        f["packed"] = np.arange(N, dtype=np.int16)
        f["packed"].attrs["scale_factor"], f["packed"].attrs["add_offset"] = 0.5, 10.0
        f["words"] = "text"
        f["cube"] = np.ones((2, 2, 2))
    source = open_table(tmp_path / "run.h5")
    read = source.read(["data[:,0]", "data[:,1]", "table/F", "t", "packed"], {}).values
    np.testing.assert_array_equal(read["data[:,1]"], F)
    np.testing.assert_array_equal(read["t"], T)
    np.testing.assert_array_equal(read["packed"], 0.5 * np.arange(N) + 10)
    with pytest.raises(
        ss.InputError, match=r"a float64 array of shape \(2, 2, 2\); a channel is a real vector"
    ):
        source.read(["cube"], {})


def test_matlab_73_has_the_names_of_matlab(tmp_path: Path) -> None:
    matlab73(tmp_path / "run.mat")
    with h5py.File(tmp_path / "run.mat", "r+") as f:
        f["data"] = np.stack([T, F])
        f["data"].attrs["MATLAB_class"] = np.bytes_("double")
    read = numbers(open_table(tmp_path / "run.mat"), ["run.t", "run.F", "data(:,2)"])
    np.testing.assert_array_equal(read["run.t"], T)
    np.testing.assert_array_equal(read["data(:,2)"], F)


def test_parquet_kinds(tmp_path: Path) -> None:
    import pandas as pd

    when = pd.Timestamp("2024-03-05 10:11:12", tz="Europe/Warsaw") + pd.to_timedelta(T, unit="s")
    frame = pd.DataFrame({"when": when, "span": pd.to_timedelta(T, unit="s"), "n": range(N), "word": "a"})
    frame["hole"] = [None, *F[1:]]
    frame.to_parquet(tmp_path / "run.parquet")
    source = open_table(tmp_path / "run.parquet")
    read = numbers(source, ["when", "span", "n"], {"when": "ms", "span": "s"})
    np.testing.assert_allclose(read["when"], 1e3 * T, atol=1e-3)
    np.testing.assert_allclose(read["span"], T, atol=1e-9)
    for name, words in (("word", "a channel is numbers"), ("hole", "no value at sample 0|nan at sample 0")):
        with pytest.raises(ss.InputError, match=words):
            source.read([name], {})


@pytest.mark.parametrize("kind", [np.uint8, np.int16, np.int32, np.float32])
def test_wav_is_a_share_of_full_scale(tmp_path: Path, kind: type) -> None:
    wave = np.sin(0.3 * np.arange(N)) * 0.9
    whole = np.issubdtype(kind, np.integer)
    half = 2.0 ** (8 * np.dtype(kind).itemsize - 1) if whole else 1.0
    stored = np.round(wave * half + (half if kind is np.uint8 else 0)) if whole else wave
    scipy.io.wavfile.write(tmp_path / "run.wav", 500, np.c_[stored, stored].astype(kind))
    read = numbers(open_table(tmp_path / "run.wav"), ["t", "channel 2"])
    np.testing.assert_allclose(read["channel 2"], wave, atol=0.51 / half if whole else 1e-7)
    np.testing.assert_allclose(read["t"], T)


REAL = [
    (HOME["tdms"] / "test/data/raw1.tdms", "First  Channel", 2000),
    (HOME["tdms"] / "test/data/big_endian.tdms", "Phase sweep", 3500),
    (HOME["pa"] / "tests/data/parquet/v0.7.1.parquet", "carat", 10),
    (Path(scipy.__file__).parent / "io/matlab/tests/data/testhdf5_7.4_GLNX86.mat", "testdouble", 9),
    (Path(scipy.__file__).parent / "io/tests/data/test-44100Hz-be-1ch-4bytes.wav", "channel 1", 4410),
]


@pytest.mark.parametrize(("real", "column", "size"), REAL, ids=lambda one: getattr(one, "name", ""))
def test_real_files_that_packages_ship(real: Path, column: str, size: int) -> None:
    if not real.exists():
        pytest.skip("the package came without its test data")
    assert numbers(open_table(real), [column])[column].size == size


# damaged files

DRAWN = 40
DRIVER = """
import json, os, sys, numpy as np
sys.path.insert(0, sys.argv[1])
import main
name, file, column, drawn, out = sys.argv[2:]
module = main.parser(name)
good = open(file, "rb").read()
rng = np.random.default_rng(7)
whole = main.answered(module, file, [column])[0]["sizes"]
report = {"fine": 0, "damaged": 0, "fault": 0, "memory": 0, "signal": 0, "bad": [], "silent": []}
for i in range(int(drawn)):
    data = bytearray(good)
    how = i % 4
    if how == 0:
        del data[rng.integers(len(data)):]
    elif how == 1:
        for at in rng.integers(len(data), size=rng.integers(1, 9)):
            data[at] ^= 1 << rng.integers(8)
    elif how == 2:
        at = rng.integers(len(data)); data[at:at + 64] = bytes(len(data[at:at + 64]))
    else:  # in the head, where the sizes are
        data[rng.integers(min(len(data), 400))] = rng.integers(256)
    open(out, "wb").write(data)
    sys.stdout.flush()
    child = os.fork()
    if not child:
        os.dup2(os.open(out + ".json", os.O_WRONLY | os.O_CREAT | os.O_TRUNC), 1)
        head, columns = main.answered_within(dict(parser=name, file=out, names=[column], seconds=60, memory=2**32))
        os.write(1, json.dumps(head).encode())
        os._exit(0)
    status = os.waitpid(child, 0)[1]
    if os.WIFSIGNALED(status):
        report["signal"] += 1
    elif status:
        report["bad"].append(i)
    else:
        head = json.load(open(out + ".json"))
        kind = next((k for k in ("damaged", "fault", "memory") if k in head), "fine")
        report[kind] += 1
        between = good[len(data):].startswith(b"TDSm")  # segments: nothing tells that there were more
        if how == 0 and kind == "fine" and not (head.get("doubts") or between or head["sizes"] == whole):
            report["silent"].append(len(data))
print(json.dumps(report))
"""


@pytest.mark.skipif(not hasattr(__import__("os"), "fork"), reason="the driver forks")
def test_a_damaged_file_always_gets_an_answer(file: Path) -> None:
    """The parser's process ends by itself or by a signal, never by a traceback; forty drawn for each format."""
    parser = {".mat": "hdf5"}.get(file.suffix, {".h5": "hdf5"}.get(file.suffix, file.suffix[1:]))
    column = {"hdf5": "run/F", "tdms": "run/F", "wav": "channel 1"}.get(parser, "F")
    arguments = [
        str(process.PROGRAM.parent),
        parser,
        str(file),
        column,
        str(DRAWN),
        str(file.with_name("damaged")),
    ]
    done = subprocess.run(
        [sys.executable, "-c", DRIVER, *arguments], capture_output=True, text=True, check=True
    )
    report = json.loads(done.stdout.splitlines()[-1])
    assert report["bad"] == []
    assert report["fine"] + report["damaged"] + report["fault"] + report["memory"] + report["signal"] == DRAWN
    assert report["silent"] == []  # what is cut off is missed
    assert report["damaged"] > 0


@pytest.mark.parametrize("how", ["cut", "zeros", "nothing", "magic", "text"])
def test_what_is_said_of_a_damaged_file(file: Path, how: str) -> None:
    content = file.read_bytes()
    if how == "magic" and file.suffix == ".mat":
        return  # its first bytes are words for people
    column = force(file)
    file.write_bytes(
        {
            "cut": content[: len(content) // 3],
            "zeros": bytes(len(content)),
            "nothing": b"",
            "magic": b"OTHERWISE" + content[9:],
            "text": b"t,F\n0,1\n",
        }[how]
    )
    refusal = ""
    try:
        read = numbers(open_table(file), ["t", column])
    except ss.InputError as error:
        refusal = str(error)
    assert refusal.isprintable()
    if how == "cut" and not refusal:  # what is left is there, and it is said that the rest is not
        assert read["t"].size < N
        assert "cut off" in " ".join(open_table(file).contents.doubts)
    else:
        assert refusal


@pytest.mark.parametrize(
    ("magic", "words"),
    [
        (b"PK\x03\x04", "Excel"),
        (b"\x1f\x8b\x08", "gzip"),
        (b"\xd0\xcf\x11\xe0", "Excel"),
        (b"\x89MCAP0\r\n", "MCAP"),
    ],
)
def test_files_of_other_kinds_are_named(tmp_path: Path, magic: bytes, words: str) -> None:
    (tmp_path / "run.csv").write_bytes(magic + bytes(100))
    with pytest.raises(ss.InputError, match=words):
        read_columns(tmp_path / "run.csv", ["t"])


def test_a_file_that_is_replaced_while_it_is_read_is_refused(tmp_path: Path) -> None:
    file = tmp_path / "run.h5"
    hdf5(file)
    looked = open_table(file)
    assert "run/F" in looked.contents.names
    with h5py.File(file, "w") as f:
        f["other"] = T
    with pytest.raises(ss.InputError, match="was changed while it was read"):
        looked.read(["run/F"], {})
