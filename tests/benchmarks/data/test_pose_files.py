"""Files of SLEAP and DeepLabCut, written as sleap-io 0.9.5 and pandas 3.1 with PyTables 3.11 write them."""

from __future__ import annotations

import json
import pickle
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pandas as pd
import pytest

from benchmarks.contract.track_table import TrackTable
from benchmarks.data.tracks import read_tracks

NAN = np.nan


def one(path: Path) -> TrackTable:
    (table,) = read_tracks([path])
    return table


def deeplabcut(folder: Path, animals: tuple[str, ...], parts: tuple[str, ...], values: list[list[float]]) -> list[Path]:
    """Write a table of DeepLabCut as CSV and as HDF5; without animals it has no head for them."""
    levels = [("net",), *([animals] if animals else []), parts, ("x", "y", "likelihood")]
    names = ["scorer", *(["individuals"] if animals else []), "bodyparts", "coords"]
    heads = pd.MultiIndex.from_product(levels, names=names)
    table = pd.DataFrame(np.array(values), columns=heads)
    table.to_csv(folder / "dlc.csv")
    with h5py.File(folder / "dlc.h5", "w") as file:
        kind = [("index", "<i8"), ("values_block_0", "<f8", (len(heads),))]
        rows = np.array([(k, row) for k, row in enumerate(table.to_numpy())], dtype=kind)
        stored = file.create_dataset("df_with_missing/table", data=rows)
        stored.attrs["values_block_0_kind"] = np.bytes_(pickle.dumps(heads.tolist(), 0))
    return [folder / "dlc.csv", folder / "dlc.h5"]


def test_deeplabcut_of_one_animal_without_unlikely_parts(tmp_path: Path) -> None:
    values = [
        [1, 2, 0.9, 3, 4, 0.9, 8, 9, 0.7],
        [1, 2, 0.9, 3, 4, 0.9, 8, 9, 0.5],
        [1, 2, 0.9, 3, 4, 0.1, 8, 9, 0.5],
        [NAN, NAN, NAN, 3, 4, 0.9, 8, 10, 0.9],
    ]
    for path in deeplabcut(tmp_path, (), ("nose", "mid", "tail"), values):
        table = one(path)
        np.testing.assert_allclose(table.position[:, 0], [[4, 5], [2, 3], [NAN, NAN], [5.5, 7]])
        assert (table.names, table.rate_hz, table.unit, table.name) == (("1",), None, "px", "dlc")


def test_deeplabcut_of_several_animals(tmp_path: Path) -> None:
    values = [[1, 2, 1, 3, 4, 1, 10, 20, 1, 30, 40, 1], [1, 2, 1, 3, 4, 1, *[NAN] * 6]]
    for path in deeplabcut(tmp_path, ("ada", "bob"), ("nose", "tail"), values):
        table = one(path)
        assert table.names == ("ada", "bob")
        np.testing.assert_allclose(table.position, [[[2, 3], [20, 30]], [[2, 3], [NAN, NAN]]])


def test_no_pickle_of_a_file_is_run(tmp_path: Path) -> None:
    class Evil:
        def __reduce__(self) -> Any:
            return (Path.touch, (tmp_path / "run",))

    *_, path = deeplabcut(tmp_path, (), ("nose",), [[1, 2, 0.9]])
    with h5py.File(path, "a") as file:
        file["df_with_missing/table"].attrs["values_block_0_kind"] = np.bytes_(pickle.dumps([Evil()], 0))
    with pytest.raises(ValueError, match=r"dlc\.h5: expected a whole \.h5 file"):
        one(path)
    assert not (tmp_path / "run").exists()


HEAD = "track,frame_idx,instance.score,nose.x,nose.y,nose.score,tail.x,tail.y,tail.score\n"


def test_sleap_s_analysis_csv(tmp_path: Path) -> None:
    path = tmp_path / "swim.csv"
    path.write_text(f"{HEAD}a,4,0.9,1,2,0.9,3,4,0.9\nb,4,0.9,1,2,0.9,,,0\na,6,,5,6,,7,8,\n,6,0.2,90,90,0.1,91,91,0.1\n")
    table = one(path)
    assert (table.names, table.first_frame) == (("a", "b"), 4)
    np.testing.assert_allclose(table.position, [[[2, 3], [NAN] * 2], [[NAN] * 2] * 2, [[6, 7], [NAN] * 2]])


def test_sleap_without_tracks_is_one_animal_or_none(tmp_path: Path) -> None:
    path = tmp_path / "swim.csv"
    path.write_text(f"{HEAD},0,0.9,1,2,1,3,4,1\n,1,0.9,2,2,1,4,4,1\n")
    np.testing.assert_allclose(one(path).position[:, 0], [[2, 3], [3, 3]])
    path.write_text(f"{HEAD},0,0.9,1,2,1,3,4,1\n,0,0.9,2,2,1,4,4,1\n")
    with pytest.raises(ValueError, match=r"swim\.csv: expected tracks, as several animals are in one frame"):
        one(path)


@pytest.mark.parametrize("dims", [None, ("track", "xy", "node", "frame"), ("frame", "track", "node", "xy")])
def test_sleap_s_analysis_hdf5(tmp_path: Path, dims: tuple[str, ...] | None) -> None:
    usual = ("track", "xy", "node", "frame")
    tracks = np.arange(2 * 2 * 3 * 4, dtype=float).reshape(2, 2, 3, 4)
    tracks[1, :, 1:, 2] = NAN
    with h5py.File(tmp_path / "a.h5", "w") as file:
        stored = file.create_dataset("tracks", data=tracks.transpose([usual.index(each) for each in dims or usual]))
        if dims is not None:
            stored.attrs["dims"] = json.dumps(dims)
            file.attrs["video_backend_metadata"] = json.dumps({"fps": 12.5})
        file["track_names"] = np.array([b"a", b"b"])
    table = one(tmp_path / "a.h5")
    expected = tracks.mean(axis=2).transpose(2, 0, 1)
    np.testing.assert_allclose(table.position, expected)
    assert np.isnan(table.position[2, 1]).all()
    assert table.rate_hz == (None if dims is None else 12.5)


def test_a_track_of_sleap_without_a_name_is_named(tmp_path: Path) -> None:
    with h5py.File(tmp_path / "a.h5", "w") as file:
        file["tracks"], file["track_names"] = np.ones((2, 2, 3, 4)), np.array([b"a"])
    with pytest.raises(ValueError, match=r"a\.h5: expected a whole \.h5 file, got index 1 is out of bounds"):
        one(tmp_path / "a.h5")


def test_a_project_of_sleap_takes_what_a_person_placed(tmp_path: Path) -> None:
    point = [("x", "<f8"), ("y", "<f8"), ("visible", "?"), ("complete", "?")]
    points = np.array([(1, 2, True, False), (3, 4, True, False)], point)
    rows = [
        (10, 20, True, False, 0.9),
        (30, 40, True, False, 0.9),
        (5, 5, True, False, 0.9),
        (NAN, NAN, False, False, 0),
    ]
    predicted = np.array(rows, [*point, ("score", "<f8")])
    names = ("instance_type", "frame_id", "track", "point_id_start", "point_id_end")
    instances = [(0, 1, 0, 0, 2), (1, 0, 0, 0, 2), (1, 1, 0, 0, 2), (1, 1, 1, 2, 4)]
    with h5py.File(tmp_path / "a.slp", "w") as file:
        file["points"], file["pred_points"] = points, predicted
        file["frames"] = np.array(
            [(0, 0, 7), (1, 0, 9)], [(each, "<i8") for each in ("frame_id", "video", "frame_idx")]
        )
        file["instances"] = np.array(instances, [(each, "<i8") for each in names])
        file["tracks_json"] = np.array([b'[0,"a"]', b'[0,"b"]'])
        file["videos_json"] = np.array([b'{"filename": "x.mp4", "backend": {"fps": 25.0}}'])
    table = one(tmp_path / "a.slp")
    assert (table.names, table.first_frame, table.rate_hz) == (("a", "b"), 7, 25.0)
    np.testing.assert_allclose(table.position[:, 0], [[20, 30], [NAN, NAN], [2, 3]])
    assert np.isnan(table.position[:, 1]).all()


def test_rows_of_mot_are_middles_of_boxes_that_count(tmp_path: Path) -> None:
    path = tmp_path / "MOT-1" / "gt" / "gt.txt"
    path.parent.mkdir(parents=True)
    path.write_text("2,5,1,1,10,20,1,1,1\n3,5,3,1,10,20,1,1,1\n3,6,1,1,2,2,0,1,1\n")
    (tmp_path / "MOT-1" / "seqinfo.ini").write_text("[Sequence]\nframeRate=1\nexactFrameRate=0.5\n")
    table = one(path)
    assert (table.name, table.names, table.rate_hz, table.first_frame) == ("MOT-1", ("5",), 0.5, 1)
    np.testing.assert_allclose(table.position[:, 0], [[5, 10], [7, 10]])


def test_rows_of_mot_may_have_exponents(tmp_path: Path) -> None:
    path = tmp_path / "a.txt"
    np.savetxt(path, [[1, 5, 1, 1, 10, 20, 1], [2, 5, 3, 1, 10, 20, 1]], delimiter=",")
    (tmp_path / "seqinfo.ini").write_text("frameRate = 25\r\n")
    table = one(path)
    assert (table.names, table.rate_hz) == (("5",), 25.0)
    np.testing.assert_allclose(table.position[:, 0], [[5, 10], [7, 10]])


def test_rows_of_mot_that_are_wrong_are_named(tmp_path: Path) -> None:
    path = tmp_path / "a.txt"
    path.write_text("1,5,1,1,10,20,1,1,1\n1,5,3,1,10,20,1,1,1\n")
    with pytest.raises(ValueError, match=r"a\.txt, line 2: expected each id once in a frame"):
        one(path)
