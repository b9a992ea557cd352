"""Files that are broken, dangerous or none of a tracking program's: each is refused by name."""

from __future__ import annotations

import gzip
import json
import pickle
import sys
from pathlib import Path

import numpy as np
import pandas as pd
import pyarrow as pa
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from benchmarks.data.tracks import read_each, read_tracks
from tests.benchmarks.data.test_tracks import one, written


@pytest.mark.parametrize(
    ("name", "text", "message"),
    [
        ("a.csv", "time,x1,z1\n0,1,2\n", r"a.csv: expected columns .* x1, y1, x2, y2 …, got time, x1, z1"),
        ("b.csv", "p,q\n1,2\n", r"b.csv: expected columns frame, pos_x, pos_y, id, or .*, got p, q"),
        ("c.csv", "", r"c.csv: expected a whole .csv file, got No columns to parse from file"),
        ("d.csv", "x1,y1\nleft,2\n", r"d.csv: expected numbers in x1, y1, frame, got others: .*'left'"),
        ("e.csv", "x1,y1\n1,2\n1,2,3,4\n", r"e.csv: expected a whole .csv file, got .* 2 fields in line 3, saw 4"),
        ("f.csv", ",frame,pos_x,pos_y,id\n0,1,1,1,A\n1,1,2,2,A\n", "each animal once on a frame, got one that is"),
        ("g.csv", ",frame,pos_x,pos_y,id\n0,1.5,1,1,A\n", r"g.csv: expected whole numbers >= 0 .*, got 1.5"),
        ("h.csv", "x1,y1\nNaN,NaN\n", "h: expected an animal that is tracked on a frame, got none"),
        ("i.npz", "no archive", r"i.npz: expected a whole .npz file"),
        ("j.txt.gz", "no archive", r"j.txt.gz: expected a whole .txt file"),
        ("k.mat", "", r"real: expected files ending in \.csv, .*, got 'k.mat'"),
        ("l.csv", ",frame,pos_x,pos_y,id\n0,1,1,1,A\n0,999999999,1,1,A\n", "l.csv: expected frames without endless"),
        (
            "n.csv",
            "x1,y1\n0,1,2\n1,3,4\n",
            r"n.csv: expected a whole .csv file, got Length of header .* length of data",
        ),
        ("o.csv", "x1,y1,x1,y1\n1,2,3,4\n", "o.csv: expected different heads, got x1, y1 twice"),
        (
            "p.csv",
            ",frame,pos_x,pos_y,id\n0,1,1,1,A\n1,1,2,2,B\n2,2,3,3\n",
            "p.csv: expected an animal on each row, in column id, got a row without one",
        ),
        ("m.csv", 'x1,y1\n"1,2\n', r"m.csv: expected a whole .csv file, got .* EOF inside string"),
        ("v_id2.csv", "frame,X,Y,time\n,,,\n", r"v_id2.csv: expected whole numbers >= 0 in column frame, got nan"),
        ("v_id4.csv", "frame,X,Y,time\n1e300,2,2,1\n", r"v_id4.csv: expected whole numbers .*, got 1e\+300"),
    ],
)
def test_what_is_broken_is_named(tmp_path: Path, name: str, text: str, message: str) -> None:
    with pytest.raises(ValueError, match=message):
        read_tracks([written(tmp_path, name, text)])


@pytest.mark.parametrize("rate", ["0", "-1", "NaN", "Infinity", "null"])
def test_a_rate_that_the_program_did_not_know_is_that_of_the_times(tmp_path: Path, rate: str) -> None:
    path = written(tmp_path, "trajectories.csv", "time,x1,y1\n0,1,2\n0.5,1,2\n")
    written(tmp_path, "attributes.json", f'{{"frames_per_second": {rate}}}')
    assert one(path).rate_hz == 2.0


def test_animals_of_one_video_have_one_unit(tmp_path: Path) -> None:
    paths = [written(tmp_path, f"v_id{k}.csv", f"frame,X ({unit}),Y\n1,2,3\n") for k, unit in enumerate(("cm", "px"))]
    with pytest.raises(ValueError, match="files: expected places in one unit, got cm and px"):
        read_tracks(paths)


def test_arrays_without_rows_are_named(tmp_path: Path) -> None:
    np.savez(tmp_path / "b_id0.npz", frame=[], X=[], Y=[], time=[])
    with pytest.raises(ValueError, match=r"b_id0\.npz: expected rows of tracks, got none"):
        read_tracks([tmp_path / "b_id0.npz"])


@settings(max_examples=60, deadline=None)
@given(st.sampled_from(["npz", "csv.gz"]), st.floats(0, 1, exclude_max=True), st.integers(1, 255), st.booleans())
def test_a_damaged_file_is_read_or_named(
    tmp_path_factory: pytest.TempPathFactory, ending: str, where: float, change: int, cut: bool
) -> None:
    path = tmp_path_factory.mktemp("damaged") / f"v_id0.{ending}"
    frame = np.arange(200.0)
    if ending == "npz":
        np.savez_compressed(path, frame=frame, X=np.sin(frame), Y=np.cos(frame))
    else:
        lines = [f"{k},{np.sin(k)},{np.cos(k)}" for k in range(200)]
        path.write_bytes(gzip.compress("\n".join(["frame,X,Y", *lines, ""]).encode()))
    whole = bytearray(path.read_bytes())
    place = int(where * len(whole))
    whole[place] ^= change
    path.write_bytes(whole[:place] if cut else whole)
    try:
        got: object = one(path).position.shape
    except ValueError as error:
        got = str(error)[:5]
    assert got in ("v_id0", (200, 1, 2))


def test_an_animal_without_a_row_is_left_out_and_told(tmp_path: Path) -> None:
    head = "frame,X,Y,time\n"
    paths = [
        written(tmp_path, f"pond_id{k}.csv", head + ("" if k == 2 else f"0,{k},1,0\n1,2,3,0.5\n")) for k in range(4)
    ]
    (table,), unusable = read_each(paths)
    assert (table.names, table.rate_hz, unusable) == (("0", "1", "3"), 2.0, [])
    assert table.notes == ("pond_id2.csv has no row: its animal is left out",)
    with pytest.raises(ValueError, match=r"^pond_id2.csv: expected rows of tracks, got none$"):
        read_tracks(paths[2:3])


def test_a_broken_recording_does_not_hide_the_others(tmp_path: Path) -> None:
    paths = [written(tmp_path, "a.csv", "x1,y1\n1,2\n"), written(tmp_path, "b.csv", "x1,y1\nleft,2\n")]
    tables, unusable = read_each(paths)
    assert [each.name for each in tables] == ["a"]
    assert [line.partition(":")[0] for line in unusable] == ["b.csv"]
    with pytest.raises(ValueError, match="real: expected files that exist, got"):
        read_tracks([tmp_path / "nothing.csv"])


class _Trap:
    """Leaves a trace where it is unpickled."""

    def __init__(self, trace: Path) -> None:
        self.trace = trace

    def __reduce__(self) -> object:
        return Path.touch, (self.trace,)


@pytest.mark.parametrize("name", ["trajectories.npy", "trajectories.pickle", "v_id0.npz"])
def test_pickled_objects_are_refused_and_never_loaded(tmp_path: Path, name: str) -> None:
    path, trace = tmp_path / name, tmp_path / "trace"
    if name.endswith("npz"):
        np.savez(path, frame=np.array([_Trap(trace)], dtype=object))
    else:
        path.write_bytes(pickle.dumps(_Trap(trace)))
    with pytest.raises(ValueError, match=r"without pickled|Object arrays cannot be loaded") as refused:
        read_tracks([path])
    assert not trace.exists()
    if name.endswith("npy"):
        assert "idtrackerai_format SESSION --formats csv" in str(refused.value)


@pytest.mark.parametrize(("name", "package"), [("t.h5", "h5py"), ("t.parquet", "pyarrow")])
def test_a_library_that_is_not_installed_is_named_with_its_command(
    tmp_path: Path, name: str, package: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, package, None)
    with pytest.raises(ValueError, match=rf"got no package {package} \(pip install {package}\)"):
        read_tracks([written(tmp_path, name, "")])


def test_what_is_broken_in_hdf5_or_parquet_is_named(tmp_path: Path) -> None:
    h5py, parquet = pytest.importorskip("h5py"), pytest.importorskip("pyarrow.parquet")
    with h5py.File(tmp_path / "t.h5", "w") as file:
        file["places"] = np.zeros((3, 2, 2))
    with pytest.raises(ValueError, match=r"t\.h5: expected a whole \.h5 file, got .*'trajectories' doesn't exist"):
        read_tracks([tmp_path / "t.h5"])
    table = pd.DataFrame({"frame": [0, 0.2], "individual": [0, 0], "x": [1.0, 3.0], "y": [2.0, 4.0]})
    for attributes, message in ({}, r"whole numbers >= 0 in column frame, got 0\.2"), ([25], r"a whole \.parquet file"):
        told = {"idtrackerai_attributes": json.dumps(attributes)}
        parquet.write_table(pa.Table.from_pandas(table).replace_schema_metadata(told), tmp_path / "t.parquet")
        with pytest.raises(ValueError, match=rf"t\.parquet: expected {message}"):
            read_tracks([tmp_path / "t.parquet"])
