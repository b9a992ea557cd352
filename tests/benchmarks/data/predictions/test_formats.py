"""Files of predictions: what each format says, and what is refused."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from benchmarks.data.predictions.formats import SequenceFile, format_of, read_predictions, sequences_in
from benchmarks.data.predictions.predicted import Recalled
from tests.benchmarks.data.layouts.written_layouts import counts
from trackers.regions import Mask, Polygon, Rectangle, Special


def _file(path: Path, text: str, format: str = "", frames: int = 3, **more: Any) -> SequenceFile:
    path.write_text(text)
    return SequenceFile("a", frames, path=path, format=format or format_of(path), **more)


@pytest.mark.parametrize("between", [",", "\t", " ", ", "])
@pytest.mark.parametrize(("format", "first"), [("vot", 0), ("otb", 1)])
def test_lines_are_boxes_from_the_corner_of_the_picture(tmp_path: Path, between: str, format: str, first: int) -> None:
    text = f"1\n{between.join(['3.5', '4', '10', '20'])}\n{between.join(['NaN'] * 4)}\n"
    read = read_predictions(_file(tmp_path / "a.txt", text, format))
    assert read.regions is not None
    start, box, none = read.regions
    assert isinstance(start, Special)
    assert isinstance(none, Special)
    assert isinstance(box, Rectangle)
    np.testing.assert_allclose(box.box_xyxy, np.array([3.5, 4, 13.5, 24]) - first)
    assert np.isnan(read.confidence).all()


def test_vot_has_polygons_masks_and_numbers_alone(tmp_path: Path) -> None:
    text = "1\n0,0,4,0,4,4,0,4\nm2,1,2,2,0,3\n0\n2\n-1,-1,-1,-1\n\n"
    read = read_predictions(_file(tmp_path / "a.txt", text, frames=7))
    assert read.regions is not None
    kinds = [type(region) for region in read.regions]
    assert kinds == [Special, Polygon, Mask, Special, Special, Special, Special]


def test_polygons_are_no_rows_of_mot(tmp_path: Path) -> None:
    assert _file(tmp_path / "a.txt", "0.5,0,4,0,4,4,0,4\n").format == "vot"
    assert _file(tmp_path / "a.txt", "1.0,7,4,0,4,4.5,0.4,4\n").format == "mot"


def test_confidences_stand_beside_lines(tmp_path: Path) -> None:
    (tmp_path / "a_confidence.value").write_text("\n0.25\nnan\n")
    read = read_predictions(_file(tmp_path / "a.txt", "1\n1,1,2,2\n1,1,2,2\n"))
    np.testing.assert_array_equal(read.confidence, [np.nan, 0.25, np.nan])


def test_files_may_have_the_pictures_before_the_first_and_after_the_last_frame(tmp_path: Path) -> None:
    lines = "".join(f"{k},0,2,2\n" for k in range(7))
    whole = read_predictions(_file(tmp_path / "a.txt", lines, skipped=3, after=1))
    own = read_predictions(_file(tmp_path / "b.txt", "".join(lines.splitlines(True)[3:6]), skipped=3, after=1))
    assert whole.regions is not None
    assert [str(region) for region in whole.regions] == [f"{k}.0,0.0,2.0,2.0" for k in (3, 4, 5)]
    assert own.digest == whole.digest
    rows = read_predictions(_file(tmp_path / "c.txt", "5,1,1,1,2,2\n1,1,1,1,2,2\n7,1,1,1,2,2\n", skipped=3, after=1))
    assert rows.tracks is not None
    assert list(rows.tracks) == [1]


def test_mot_rows_are_tracks_counted_from_one(tmp_path: Path) -> None:
    read = read_predictions(_file(tmp_path / "a.txt", "1,7,1,1,10,20,0.5,-1,-1,-1\n1,8,5,5,0,0,-1\n3,7,2,2,10,20\n"))
    assert read.tracks is not None
    assert {frame: [each.identity for each in tracks] for frame, tracks in read.tracks.items()} == {0: [7, 8], 2: [7]}
    first, point = read.tracks[0]
    np.testing.assert_array_equal(first.estimate.position_px, [5, 10])
    assert (first.confidence, first.estimate.in_view_probability, point.confidence) == (0.5, 0.5, None)
    np.testing.assert_array_equal(point.estimate.position_px, [4, 4])
    assert point.estimate.box_xyxy is None


def test_rows_of_mots_are_tracks_with_masks_counted_from_zero(tmp_path: Path) -> None:
    first, second = np.zeros((2, 12, 16), bool)
    first[2:5, 3:9], second[6:9, 0:2] = True, True
    rows = [(0, 1000, first), (0, 2001, second), (2, 1000, second), (1, 1000, ~(first | ~first))]
    text = "".join(f"{frame} {identity} 1 12 16 {counts(mask)}\n" for frame, identity, mask in rows)
    file = _file(tmp_path / "a.txt", text)
    assert file.format == "mots"
    read = read_predictions(file)
    assert read.tracks is not None
    recalled = Recalled(read.tracks, read.masks)
    said = [recalled.update(None) for _ in range(3)]  # type: ignore[arg-type]
    assert [[each.identity for each in tracks] for tracks in said] == [[1000, 2001], [], [1000]]
    np.testing.assert_array_equal(said[0][0].estimate.mask, first)  # type: ignore[arg-type]
    np.testing.assert_array_equal(said[0][0].estimate.box_xyxy, [3, 2, 9, 5])  # type: ignore[arg-type]
    np.testing.assert_array_equal(said[2][0].estimate.mask, second)  # type: ignore[arg-type]
    assert said[2][0].estimate.position_px.tolist() == [1, 7.5]
    challenge = tuple(f"img1/{k:06d}.jpg" for k in (2, 3, 4))
    shifted = read_predictions(
        _file(tmp_path / "a.txt", f"3 1000 1 12 16 {counts(first)}\n", skipped=1, pictures=challenge)
    )
    assert list(shifted.tracks or {}) == [1]
    with pytest.raises(ValueError, match=r"a\.txt, line 1: expected a frame of 0 to 2, got 3"):
        read_predictions(_file(tmp_path / "a.txt", f"3 1000 1 12 16 {counts(first)}\n"))


def _coco(folder: Path, results: list[dict[str, Any]], name: str = "{}/{:06d}.png") -> SequenceFile:
    images = [
        {"id": 10 * k + frame + 1, "file_name": name.format(sequence, frame)}
        for k, sequence in enumerate("ab")
        for frame in range(3)
    ]
    (folder / "instances.json").write_text(
        json.dumps({"images": images, "categories": [{"id": 4, "name": "car"}], "annotations": []})
    )
    (folder / "r.json").write_text(json.dumps([{"category_id": 4, "bbox": [1, 2, 3, 4]} | each for each in results]))
    return SequenceFile("a", 3, path=folder / "r.json", format="coco", annotations=folder / "instances.json")


@pytest.mark.parametrize("name", ["{}/{:06d}.png", "validation/{}/frame{:06d}.jpg"])
def test_results_of_coco_are_detections_and_of_tao_tracks(tmp_path: Path, name: str) -> None:
    found = read_predictions(_coco(tmp_path, [{"image_id": 2, "score": 0.5}, {"image_id": 12, "score": 1}], name))
    assert found.detections is not None
    assert list(found.detections) == [1]
    (only,) = found.detections[1]
    assert (only.kind, only.confidence) == ("car", 0.5)
    np.testing.assert_array_equal(only.estimate.box_xyxy, [1, 2, 4, 6])
    tao = _coco(tmp_path, [{"image_id": 3, "score": 0.5, "track_id": 6}], name)
    assert [each.identity for each in (read_predictions(tao).tracks or {})[2]] == [6]
    assert sequences_in(tmp_path / "r.json", tmp_path / "instances.json") == ["a"]


def test_the_digest_is_of_the_own_sequence(tmp_path: Path) -> None:
    first, other = {"image_id": 2, "score": 0.5}, {"image_id": 12, "score": 1}
    digests = [read_predictions(_coco(tmp_path, some)).digest for some in ([first], [first, other], [other])]
    assert digests[0] == digests[1] != digests[2]
    moved = read_predictions(_coco(tmp_path, [first | {"image_id": 3}])).digest
    assert moved != digests[0]


@pytest.mark.parametrize(
    ("text", "format", "message"),
    [
        ("1,1,2,2\n", "vot", r"a\.txt: expected 3 lines, one a frame of a, got 1"),
        ("1,1,2,2\n" * 4, "vot", "expected 3 lines, one a frame of a, got 4"),
        ("1\n1,1,-2,2\n0\n", "vot", r"a\.txt, line 2: expected a code, or x,y"),
        ("1\nx\n0\n", "vot", r"a\.txt, line 2: expected a code, or x,y"),
        ("1\n0,0,4,0,4,4,0,4\n0\n", "otb", r"a\.txt, line 2: expected left,top,width,height, as OTB has them"),
        ("4,1,1,1,2,2\n", "mot", r"a\.txt, line 1: expected a frame of 1 to 3, got 4"),
        ("1,1,1,1,2,2,54\n", "mot", r"line 1: expected a confidence from 0 to 1, or -1 for none, got 54"),
        ("1,1,2,2\n" * 3, "mot", r"line 1: expected frame,id,left"),
    ],
)
def test_what_is_wrong_is_named(tmp_path: Path, text: str, format: str, message: str) -> None:
    with pytest.raises(ValueError, match=message):
        read_predictions(_file(tmp_path / "a.txt", text, format))


@pytest.mark.parametrize(
    ("lines", "message"),
    [
        ("0.5\n", "expected 3 lines, as a.txt has, got 1"),
        ("0.5\n1.5\n0\n", r"a_confidence\.value, line 2: expected a number from 0 to 1, or nothing, got '1.5'"),
    ],
)
def test_wrong_confidences_are_named(tmp_path: Path, lines: str, message: str) -> None:
    (tmp_path / "a_confidence.value").write_text(lines)
    with pytest.raises(ValueError, match=message):
        read_predictions(_file(tmp_path / "a.txt", "1\n0\n0\n"))


@pytest.mark.parametrize(
    ("results", "message"),
    [
        ([{"image_id": 1, "score": 2}], r"r\.json, entry 1: expected a score from 0 to 1, got 2"),
        ([{"image_id": 1, "score": 1, "track_id": 1}] * 2, "entry 2: expected each track_id once in a picture"),
        (
            [{"image_id": 1, "score": 1, "track_id": 1}, {"image_id": 1, "score": 1}],
            "expected a track_id in each result",
        ),
    ],
)
def test_wrong_results_are_named(tmp_path: Path, results: list[dict[str, Any]], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        read_predictions(_coco(tmp_path, results))


def test_pictures_of_results_must_be_known(tmp_path: Path) -> None:
    file = _coco(tmp_path, [])
    with pytest.raises(ValueError, match="annotations: expected the file of annotations"):
        sequences_in(tmp_path / "r.json", None)
    with pytest.raises(ValueError, match=r"r\.json: expected 5 pictures of a in its annotations, got 3"):
        read_predictions(SequenceFile("a", 5, path=file.path, format="coco", annotations=file.annotations))


def test_a_file_without_a_line_has_no_track(tmp_path: Path) -> None:
    read = read_predictions(_file(tmp_path / "a.txt", "\n"))
    assert read.tracks == {}
