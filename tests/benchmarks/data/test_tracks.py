"""Files of tracking programs: what they hold is read."""

from __future__ import annotations

import gzip
import json
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from numpy.typing import NDArray

from benchmarks.contract.track_table import TrackTable
from benchmarks.data.tracks import read_tracks
from tests.benchmarks.data.written_tracks import write_tracks

IDTRACKER = "X1\tY1\tProbId1\tX2\tY2\tProbId2\t\n1\t2\tNaN\t3.5\t4\t0.9\nNaN\tNaN\tNaN\t5\t6\t1\n"
"""As the program writes it: a tab at the end of the head alone."""


def written(folder: Path, name: str, text: str) -> Path:
    path = folder / name
    path.write_text(text)
    return path


def one(*paths: Path) -> TrackTable:
    (table,) = read_tracks(paths)
    return table


def same(first: NDArray[np.float64], second: list[object]) -> None:
    np.testing.assert_allclose(first, np.array(second, float))


def test_idtracker_s_text(tmp_path: Path) -> None:
    table = one(written(tmp_path, "swim.txt", IDTRACKER))
    same(table.position, [[[1, 2], [3.5, 4]], [[np.nan, np.nan], [5, 6]]])
    assert (table.name, table.names, table.rate_hz, table.unit, table.first_frame) == (
        "swim",
        ("1", "2"),
        None,
        "px",
        0,
    )
    path = tmp_path / "swim.txt.gz"
    path.write_bytes(gzip.compress(IDTRACKER.encode()))
    same(one(path).position, table.position.tolist())


@pytest.mark.parametrize(("name", "separator"), [("a.txt", ","), ("a.txt", "\t"), ("a.tsv", "\t"), ("a.csv", "\t")])
def test_text_is_separated_as_its_head_is(tmp_path: Path, name: str, separator: str) -> None:
    table = one(written(tmp_path, name, IDTRACKER.replace("\t", separator)))
    same(table.position, [[[1, 2], [3.5, 4]], [[np.nan, np.nan], [5, 6]]])


def test_tracktor_s_csv_begins_on_any_frame_in_any_order(tmp_path: Path) -> None:
    text = ",frame,pos_x,pos_y,id\n0,5.0,3,4,B\n1,3.0,1,2,A\n2,5.0,5,6,A\n"
    table = one(written(tmp_path, "t.csv", text))
    nan = [np.nan, np.nan]
    same(table.position, [[[1, 2], nan], [nan, nan], [[5, 6], [3, 4]]])
    assert (table.names, table.first_frame) == (("A", "B"), 3)


def test_tracktor_s_csv_of_one_animal_has_no_id(tmp_path: Path) -> None:
    table = one(written(tmp_path, "t.csv", ",frame,pos_x,pos_y\n0,3,1,2\n1,4,3,4\n2,6,5,6\n"))
    same(table.position, [[[1, 2]], [[3, 4]], [[np.nan, np.nan]], [[5, 6]]])
    assert (table.names, table.first_frame, table.rate_hz) == (("1",), 3, None)


@pytest.mark.parametrize(
    ("folders", "names"),
    [
        (["a", "b"], ["a-trajectories", "b-trajectories"]),
        (["a/trajectories", "b/trajectories"], ["a-trajectories", "b-trajectories"]),
        (["a/x", "a/y", "b/x"], ["a-x-trajectories", "a-y-trajectories", "b-x-trajectories"]),
    ],
)
def test_sessions_of_one_name_are_called_by_their_folders(tmp_path: Path, folders: list[str], names: list[str]) -> None:
    paths = []
    for folder in folders:
        (tmp_path / folder).mkdir(parents=True)
        paths.append(written(tmp_path / folder, "trajectories.csv", "x1,y1\n1,2\n"))
    assert [table.name for table in read_tracks(paths)] == names
    assert one(paths[0]).name == "trajectories"


def test_the_rate_is_that_of_the_times_where_nothing_else_tells(tmp_path: Path) -> None:
    head = "frame,time,individual,x,y,probability\n"
    rows = [f"{frame},{frame / 60:.5f},{k},1,2,1\n" for frame in (3, 0, 2, 8) for k in "ab"]
    assert one(written(tmp_path, "tidy.csv", head + "".join(rows))).rate_hz == pytest.approx(60.0, rel=1e-3)
    assert one(written(tmp_path, "still.csv", head + "0,0,a,1,2,1\n")).rate_hz is None


def test_idtracker_ai_s_csv_with_and_without_attributes(tmp_path: Path) -> None:
    path = written(tmp_path, "trajectories.csv", "time,x1,y1,x2,y2\n0.0,1,2,3,4\n0.04,,,5,6\n")
    table = one(path)
    same(table.position, [[[1, 2], [3, 4]], [[np.nan, np.nan], [5, 6]]])
    assert table.rate_hz == pytest.approx(25.0)
    written(tmp_path, "attributes.json", json.dumps({"frames_per_second": 24}))
    assert one(path).rate_hz == 24.0
    old = written(tmp_path, "old.csv", "seconds,x1,y1\n0,1,2\n0.5,2,3\n")
    assert one(old).rate_hz == 24.0


def test_idtracker_ai_s_tidy_csv(tmp_path: Path) -> None:
    text = "frame,time,individual,x,y,probability\n0,0,0,1,2,1\n0,0,1,,,\n1,0.1,0,3,4,1\n1,0.1,1,5,6,1\n"
    path = written(tmp_path, "trajectories_tidy.csv", text)
    written(tmp_path, "attributes_tidy.json", json.dumps({"frames_per_second": 10}))
    table = one(path)
    same(table.position, [[[1, 2], [np.nan, np.nan]], [[3, 4], [5, 6]]])
    assert (table.names, table.rate_hz) == (("0", "1"), 10.0)


def test_trex_s_files_of_one_video_are_one_recording(tmp_path: Path) -> None:
    """The second animal appears later; where one is missing its place is infinite or made up."""
    names = ("frame", "missing", "X#wcentroid", "Y#wcentroid", "time", "X")
    first = ([2, 3, 4], [0, 1, 0], [1, 9, 3], [1, 9, 3], [0.1, 0.15, 0.2], [7, 7, 7])
    second = ([4, 6], [0, 1], [5, np.inf], [6, np.inf], [0.2, 0.3], [7, 7])
    paths = [tmp_path / "two.part_id0.npz", tmp_path / "two.part_id1.npz"]
    for path, values in zip(paths, (first, second), strict=True):
        np.savez(path, **{name: np.array(value, float) for name, value in zip(names, values, strict=True)})  # type: ignore[arg-type]
    table = one(*paths)
    nan = [np.nan, np.nan]
    same(table.position, [[[1, 1], nan], [nan, nan], [[3, 3], [5, 6]], [nan, nan], [nan, nan]])
    assert (table.name, table.names, table.unit, table.first_frame) == ("two.part", ("0", "1"), "cm", 2)
    assert table.rate_hz == pytest.approx(20.0)


def test_the_unit_is_that_of_the_places_that_are_read(tmp_path: Path) -> None:
    text = "frame,X (cm),Y (cm),X#wcentroid (px),Y#wcentroid (px)\n0,1,2,30,60\n"
    table = one(written(tmp_path, "v_id0.csv", text))
    same(table.position, [[[30, 60]]])
    assert table.unit == "px"


def test_trex_s_csv_names_units_in_its_head(tmp_path: Path) -> None:
    text = "frame,X (cm),Y (cm),X#pcentroid (cm),Y#pcentroid (cm),SPEED (cm/s)\n0,9,9,1,2,0\n1,inf,inf,inf,inf,inf\n"
    text += "2,9,9,3,4,0\n"
    table = one(written(tmp_path, "v_fish7.csv", text))
    same(table.position, [[[1, 2]], [[np.nan, np.nan]], [[3, 4]]])
    assert (table.names, table.unit, table.rate_hz) == (("7",), "cm", None)


def test_a_byte_order_mark_belongs_to_no_head(tmp_path: Path) -> None:
    path = tmp_path / "marked.csv"
    path.write_bytes("\ufeffx1,y1,x2,y2\n1,2,3,4\n".encode())
    assert one(path).names == ("1", "2")
    path.with_name("attributes.json").write_bytes('\ufeff{"frames_per_second": 7}'.encode())
    path.write_text("time,x1,y1\n0,1,2\n")
    assert one(path).rate_hz == 7.0


def test_idtracker_ai_s_hdf5(tmp_path: Path) -> None:
    h5py = pytest.importorskip("h5py")
    with h5py.File(tmp_path / "trajectories.h5", "w") as file:
        file["trajectories"] = np.arange(12.0).reshape(3, 2, 2)
        file.attrs["frames_per_second"] = 50
    table = one(tmp_path / "trajectories.h5")
    same(table.position, np.arange(12.0).reshape(3, 2, 2).tolist())
    assert (table.names, table.rate_hz) == (("1", "2"), 50.0)


def test_idtracker_ai_s_parquet(tmp_path: Path) -> None:
    pyarrow = pytest.importorskip("pyarrow")
    parquet = pytest.importorskip("pyarrow.parquet")
    columns = {"frame": [0, 0, 1], "individual": [0, 1, 1], "x": [1.0, 3.0, 5.0], "y": [2.0, 4.0, 6.0]}
    said = {"idtrackerai_attributes": json.dumps({"frames_per_second": 40})}
    parquet.write_table(pyarrow.table(columns).replace_schema_metadata(said), tmp_path / "trajectories.parquet")
    table = one(tmp_path / "trajectories.parquet")
    same(table.position, [[[1, 2], [3, 4]], [[np.nan, np.nan], [5, 6]]])
    assert table.rate_hz == 40.0


places = arrays(np.float64, st.tuples(st.integers(2, 6), st.integers(1, 3), st.just(2)), elements=st.floats(-1e3, 1e3))


@settings(max_examples=25, deadline=None)
@given(places, st.integers(0, 5), st.sampled_from([None, 25.0, 30.0]), st.data())
def test_what_is_written_is_read_again(
    tmp_path_factory: pytest.TempPathFactory,
    position: NDArray[np.float64],
    first: int,
    rate_hz: float | None,
    data: st.DataObject,
) -> None:
    lost = data.draw(arrays(bool, position.shape[:2]))
    # Each animal is tracked at both ends: files hold no more frames.
    lost[[0, -1]] = False
    position = np.where(lost[..., None], np.nan, position)
    names = tuple(str(number) for number in range(position.shape[1]))
    table = TrackTable("swim", position, names, rate_hz, "cm", first)
    folder = tmp_path_factory.mktemp("written")
    for program in ("trex", "trex-csv"):
        again = one(*write_tracks(table, folder, program))
        np.testing.assert_allclose(again.position, position, rtol=1e-6)
        assert (again.names, again.unit, again.first_frame) == (names, "cm", first)
        assert again.rate_hz == (rate_hz if rate_hz is None else pytest.approx(rate_hz))
    (path,) = write_tracks(table, folder, "idtracker")
    for text in (one(path), one(write_tracks(table, folder, "idtracker.ai")[0])):
        np.testing.assert_allclose(text.position[first:], position, rtol=1e-6)
        assert np.isnan(text.position[:first]).all()
    assert one(folder / "trajectories.csv").rate_hz == rate_hz
