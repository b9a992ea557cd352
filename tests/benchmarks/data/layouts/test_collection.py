"""OTB, UAVDT and UAV123 as they are published, recognised and chosen, and what is wrong with a folder."""

from __future__ import annotations

import os
import re
import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from benchmarks.data.layouts.collection import read_collections
from benchmarks.data.layouts.layout import layouts
from benchmarks.data.pictures import read_picture
from tests.benchmarks.data.written_sequences import (
    HEIGHT_PX,
    WIDTH_PX,
    lines_of,
    true_boxes,
    write_lines,
    write_otb,
    write_pictures,
)

FEW = 6
NAMES = ", ".join(layouts())
BOXES = true_boxes(FEW, range(2, 4))


def write_uav123(root: Path) -> Path:
    write_pictures(root / "data_seq" / "UAV123" / "car1", list(BOXES), "{:06d}.jpg")
    write_lines(root / "anno" / "UAV123" / "car1.txt", lines_of(BOXES))
    write_pictures(root / "data_seq" / "UAV123" / "bird1", list(BOXES) * 2, "{:06d}.jpg")
    write_lines(root / "anno" / "UAV123" / "bird1_2.txt", lines_of(BOXES)[:5])
    part = r"struct('name','bird1_2','path','F:\UAV123\data_seq\UAV123\bird1\','startFrame',7,'endFrame',11,'nz',6,"
    write_lines(root / "configSeqs.m", ["seqs={struct('name','car1_x'),...", f"{part}'ext','jpg')}};"])
    return root


def write_uavdt(root: Path) -> Path:
    write_pictures(root / "S0101", list(BOXES), "img{:06d}.jpg")
    write_lines(root / "anno" / "S0101_gt.txt", lines_of(BOXES))
    write_lines(root / "anno" / "S0101_att.txt", ["0,1,0,0,1,0,0,0"])
    return root


def write_many(root: Path, ending: str = "_gt_whole.txt") -> Path:
    """Targets 3, which begins in the second picture and is missing from two, and 8, seen in two pictures."""
    write_pictures(root / "UAV-benchmark-M" / "M0101", list(BOXES), "img{:06d}.jpg")
    lines = [f"{k},3,{10 * k},5,20,10,1,1,1" for k in (2, 3, 6)] + [f"{k},8,1,1,4,4,3,4,2" for k in (1, 4)]
    write_lines(root / "UAV-benchmark-MOTD_v1.0" / "GT" / f"M0101{ending}", lines)
    return root


@pytest.mark.parametrize(
    ("write", "layout", "names"),
    [
        (lambda root: write_otb(root / "Car1", BOXES).parent, "otb", ["Car1"]),
        (write_uav123, "uav123", ["bird1_2", "car1"]),
        (write_uavdt, "uavdt", ["S0101"]),
    ],
)
@pytest.mark.parametrize("chosen", [True, False])
def test_boxes_and_pictures_are_those_that_were_written(
    tmp_path: Path, write: Callable[[Path], Path], layout: str, names: list[str], chosen: bool
) -> None:
    (collection,) = read_collections([write(tmp_path / "set")], layout if chosen else "")
    assert collection.name == ("set" if len(names) > 1 else names[0])
    assert [each.name for each in collection.sequences] == names
    last = collection.sequences[-1]
    np.testing.assert_allclose(last.box_xyxy, BOXES)
    assert len(last.pictures) == FEW


def test_a_part_of_a_folder_is_the_one_that_the_configuration_names(tmp_path: Path) -> None:
    bird, _ = read_collections([write_uav123(tmp_path / "set")])[0].sequences
    assert [picture.name for picture in bird.pictures] == [f"{k:06d}.jpg" for k in range(7, 12)]
    np.testing.assert_allclose(bird.box_xyxy, BOXES[:5])


@pytest.mark.parametrize(
    ("write", "place", "name"),
    [
        (write_uav123, "anno/UAV123/car1.txt", "car1"),
        (write_uav123, "data_seq/UAV123/car1", "car1"),
        (write_uavdt, "S0101", "S0101"),
        (write_uavdt, "anno/S0101_gt.txt", "S0101"),
    ],
)
def test_one_sequence_of_a_data_set_is_read_from_either_end(
    tmp_path: Path, write: Callable[[Path], Path], place: str, name: str
) -> None:
    (collection,) = read_collections([write(tmp_path / "set") / place])
    assert collection.name == collection.sequences[0].name == name
    np.testing.assert_allclose(collection.sequences[0].box_xyxy, BOXES)


def test_a_folder_of_pictures_has_all_sequences_that_share_it(tmp_path: Path) -> None:
    root = write_uav123(tmp_path / "set")
    part = r"struct('name','bird1_1','path','F:\UAV123\data_seq\UAV123\bird1\','startFrame',1,'endFrame',6,'nz',6,"
    write_lines(root / "configSeqs_more.m", [part])
    write_lines(root / "anno" / "UAV123" / "bird1_1.txt", lines_of(BOXES))
    (collection,) = read_collections([root / "data_seq" / "UAV123" / "bird1"])
    assert (collection.name, [each.name for each in collection.sequences]) == ("bird1", ["bird1_1", "bird1_2"])


def test_a_picture_s_number_is_the_last_one_in_its_name(tmp_path: Path) -> None:
    write_pictures(tmp_path / "Car1" / "img", list(BOXES), "clip2_{:04d}.png")
    write_lines(tmp_path / "Car1" / "groundtruth_rect.txt", lines_of(BOXES))
    (sequence,) = read_collections([tmp_path / "Car1"])[0].sequences
    assert [picture.name for picture in sequence.pictures] == [f"clip2_{k:04d}.png" for k in range(1, 7)]


def test_a_folder_of_annotations_is_read_alone(tmp_path: Path) -> None:
    """UAV20L shares the pictures of UAV123."""
    root = write_uav123(tmp_path / "set")
    write_lines(root / "anno" / "UAV20L" / "car1.txt", lines_of(BOXES))
    (collection,) = read_collections([root / "anno" / "UAV20L"])
    assert [each.name for each in collection.sequences] == ["car1"]


@pytest.mark.parametrize("ending", ["_gt_whole.txt", "_gt.txt"])
def test_one_target_of_many_is_followed_from_its_first_picture_on(tmp_path: Path, ending: str) -> None:
    root = write_many(tmp_path / "set", ending)
    (most,), (other,) = (read_collections([root], target=target)[0].sequences for target in (None, 8))
    assert (most.name, other.name) == ("M0101-3", "M0101-8")
    assert [picture.name for picture in most.pictures] == [f"img{k:06d}.jpg" for k in range(2, 7)]
    np.testing.assert_array_equal(np.isnan(most.box_xyxy[:, 0]), [False, False, True, True, False])
    np.testing.assert_allclose(most.box_xyxy[0], [19.0, 4.0, 39.0, 14.0])
    np.testing.assert_array_equal(np.isnan(other.box_xyxy[:, 0]), [False, True, True, False, True, True])
    assert read_collections([root / "UAV-benchmark-M" / "M0101"])[0].name == "M0101-3"


def test_two_targets_of_an_otb_folder_are_two_sequences(tmp_path: Path) -> None:
    folder = write_otb(tmp_path / "set" / "Jogging", BOXES)
    (folder / "groundtruth_rect.txt").rename(folder / "groundtruth_rect.1.txt")
    write_lines(folder / "groundtruth_rect.2.txt", lines_of(BOXES + 2.0))
    write_lines(folder / "groundtruth_rect.3.txt", [])
    found = read_collections([tmp_path / "set"])[0].sequences
    assert [each.name for each in found] == ["Jogging-1", "Jogging-2"]
    np.testing.assert_allclose(found[1].box_xyxy, BOXES + 2.0)


def test_a_sequence_of_otb_with_boxes_of_a_part_is_that_part(tmp_path: Path) -> None:
    boxes = np.tile(true_boxes(1), (81, 1))
    folder = write_otb(tmp_path / "Football1", boxes)
    write_lines(folder / "groundtruth_rect.txt", lines_of(boxes[:74]))
    (sequence,) = read_collections([folder])[0].sequences
    assert (len(sequence.pictures), sequence.pictures[-1].name) == (74, "0074.png")
    folder.rename(tmp_path / "Football2")
    with pytest.raises(ValueError, match=r"Football2/groundtruth_rect.txt: expected 81 boxes, one a picture, got 74"):
        read_collections([tmp_path / "Football2"])


@pytest.mark.parametrize(
    ("spoil", "message"),
    [
        (lambda img: (img / "0004.png").unlink(), "img: expected a picture of every number from 1 to 6, got none of 4"),
        (
            lambda img: (img / "0004.png").rename(img / "0003.jpg"),
            "Car1/img: expected one picture of number 3, got 0003.png too",
        ),
        (
            lambda img: (img / "0004.png").rename(img / "cover.png"),
            "img/cover.png: expected a picture whose name ends with its number, got 'cover.png'",
        ),
        (
            lambda img: (img / "0006.png").rename(img / "1403636579763555584.png"),
            "img: expected a picture of every number from 1 to 1403636579763555584, got none of 6, 7, 8, 9, 10",
        ),
        (
            lambda img: [file.unlink() for file in img.iterdir()],
            "Car1/img: expected pictures (.jpg, .jpeg, .png, .tif, .tiff, .webp, .bmp), got none",
        ),
        (lambda img: img.rename(img.with_name("images")), "Car1/groundtruth_rect.txt: expected pictures in "),
        (
            lambda img: (img / "0001.png").write_bytes(b""),
            "Car1/img/0001.png: expected a whole picture, got 0 bytes that are none",
        ),
    ],
    ids=["missing", "twice", "no number", "times", "no pictures", "no folder", "empty"],
)
def test_what_is_wrong_with_pictures_is_named(tmp_path: Path, spoil: Callable[[Path], object], message: str) -> None:
    folder = write_otb(tmp_path / "Car1", BOXES)
    spoil(folder / "img")
    with pytest.raises(ValueError, match=re.escape(message)):
        read_collections([folder])


@pytest.mark.parametrize(
    ("lines", "message"),
    [
        (lines_of(BOXES)[:-1], ": expected 6 boxes, one a picture, got 5"),
        (["NaN NaN NaN NaN"] * FEW, ": expected a box in at least one picture, got none"),
        (["0.1 0.2 0.3 0.1"] * FEW, ": expected boxes in pixels of the picture of 64 x 48, got numbers of at"),
        (["1000 20 30 10"] * FEW, ": expected a box that meets the picture of 64 x 48, got none"),
        ([*lines_of(BOXES)[:-1], "3,4,-5,6"], ", line 6: expected left,top,width,height with a width and height above"),
    ],
)
def test_what_is_wrong_with_boxes_is_named(tmp_path: Path, lines: list[str], message: str) -> None:
    folder = write_otb(tmp_path / "Car1", BOXES)
    write_lines(folder / "groundtruth_rect.txt", lines)
    with pytest.raises(ValueError, match=re.escape(f"Car1/groundtruth_rect.txt{message}")):
        read_collections([folder])


@pytest.mark.parametrize(
    ("path", "layout", "target", "message"),
    [
        ("nothing", "", None, "real: expected folders that exist, got "),
        ("empty", "", None, f"real: expected the layout of one of {NAMES} (see frameout bench --help), got "),
        ("empty", "otb", None, "real: expected groundtruth_rect.txt, or folders that hold one, got "),
        ("empty", "uavdt", None, "real: expected boxes in anno/NAME_gt.txt or GT/NAME_gt_whole.txt, got "),
        ("empty", "uav123", None, "real: expected anno/UAV123/NAME.txt, got "),
        ("empty", "tom", None, f"layout: expected one of {NAMES}, got 'tom'"),
        ("Car1", "", 3, "target: expected none but for files of several targets, got 3"),
        ("many", "", 5, "target: expected one in UAV-benchmark-MOTD_v1.0/GT/M0101_gt_whole.txt: 3, 8, got 5"),
        ("broken", "", None, "GT/M0101_gt_whole.txt, line 2: expected frames from 1 to 6, of which there are pictures"),
        ("doubled", "", None, "GT/M0101_gt_whole.txt: expected one label a frame of a target, got two of frame 1"),
    ],
)
def test_what_is_wrong_with_a_folder_is_named(
    tmp_path: Path, path: str, layout: str, target: int | None, message: str
) -> None:
    (tmp_path / "empty").mkdir()
    write_otb(tmp_path / "Car1", BOXES)
    write_many(tmp_path / "many")
    for name, frames in {"broken": (1, 9), "doubled": (1, 1)}.items():
        file = write_many(tmp_path / name) / "UAV-benchmark-MOTD_v1.0" / "GT" / "M0101_gt_whole.txt"
        write_lines(file, [f"{frame},3,1,1,2,2,1,1,1" for frame in frames])
    with pytest.raises(ValueError, match=re.escape(message)):
        read_collections([tmp_path / path], layout, target)


def test_a_sequence_that_cannot_be_read_is_named_and_keeps_its_number(tmp_path: Path) -> None:
    (write_uav123(tmp_path / "bird") / "configSeqs.m").unlink()
    (collection,) = read_collections([tmp_path / "bird"])
    assert [(each.name, each.number) for each in collection.sequences] == [("car1", 1)]
    (line,) = collection.unusable
    assert line.startswith("UAV123/bird1_2.txt: expected pictures in data_seq/UAV123/bird1_2, or where configSeqs.m")


def test_trackers_start_where_the_target_is_first_seen(tmp_path: Path) -> None:
    folder = write_otb(tmp_path / "Car1", BOXES)
    write_lines(folder / "groundtruth_rect.txt", ["", "5,5,0,0", *lines_of(BOXES[:4])])
    (sequence,) = read_collections([folder])[0].sequences
    assert [picture.name for picture in sequence.pictures] == [f"{k:04d}.png" for k in range(3, 7)]
    np.testing.assert_array_equal(sequence.box_xyxy, BOXES[:4])
    assert sequence.notes == ("Car1: the target is first seen in picture 3 of 6, where trackers start",)


def test_a_box_outside_the_picture_shows_nothing(tmp_path: Path) -> None:
    boxes = true_boxes(FEW)
    folder = write_otb(tmp_path / "Car1", boxes)
    boxes[3] += 5000
    write_lines(folder / "groundtruth_rect.txt", lines_of(boxes))
    (sequence,) = read_collections([folder])[0].sequences
    assert np.isnan(sequence.box_xyxy).all(axis=1).tolist() == [False, False, False, True, False, False]
    assert sequence.notes == (
        "Car1: 1 of 6 boxes lie wholly outside the picture of 64 x 48, the first of picture 4: not seen",
    )


def test_boxes_that_would_fit_as_corners_are_told(tmp_path: Path) -> None:
    boxes = np.array([[10.0 + 8 * k, 12, 20 + 8 * k, 30] for k in range(FEW)])
    folder = write_otb(tmp_path / "Car1", boxes)
    assert read_collections([folder])[0].sequences[0].notes == ()
    write_lines(folder / "groundtruth_rect.txt", [",".join(map(str, box)) for box in boxes])
    (note,) = read_collections([folder])[0].sequences[0].notes
    assert note.endswith("reach outside the picture as left,top,width,height, and would fit as left,top,right,bottom")


@pytest.mark.parametrize("ending", ["jpg", "JPEG", "png", "tif", "TIFF", "webp", "bmp"])
def test_usual_pictures_are_read_beside_what_systems_leave(tmp_path: Path, ending: str) -> None:
    write_pictures(tmp_path / "Car1" / "img", list(BOXES), f"{{:04d}}.{ending}")
    write_lines(tmp_path / "Car1" / "groundtruth_rect.txt", lines_of(BOXES))
    for name in ("._0001.jpg", ".DS_Store", "Thumbs.db", f"._0002.{ending}"):
        (tmp_path / "Car1" / "img" / name).write_bytes(b"\0\5\x16\7")
    (sequence,) = read_collections([tmp_path])[0].sequences
    assert [picture.name for picture in sequence.pictures] == [f"{k:04d}.{ending}" for k in range(1, 7)]
    red = (read_picture(sequence.pictures[0]).astype(int) - (220, 20, 20))[22:26, 6:12]
    assert np.abs(red).max() < 60


def test_what_systems_leave_is_no_annotation(tmp_path: Path) -> None:
    for root, place in (
        (write_uav123(tmp_path / "a"), "anno/UAV123/._car1.txt"),
        (write_uavdt(tmp_path / "b"), "anno/._S0101_gt.txt"),
    ):
        (root / place).write_bytes(b"\0\5\x16\7")
        assert not read_collections([root])[0].unusable


@pytest.mark.skipif(sys.platform != "linux", reason="names of files are UTF-8")
def test_a_name_that_is_not_utf_8_is_printable(tmp_path: Path) -> None:
    folder = write_otb(tmp_path / "set" / "Mann", BOXES).rename(tmp_path / "set" / os.fsdecode(b"M\xe4nn"))
    (collection,) = read_collections([tmp_path / "set"])
    assert [each.name for each in collection.sequences] == [r"M\xe4nn"]
    assert read_picture(collection.sequences[0].pictures[0]).shape == (HEIGHT_PX, WIDTH_PX, 3)
    (folder / "groundtruth_rect.txt").write_text("hello\n")
    with pytest.raises(ValueError, match=r"^M\\xe4nn/groundtruth_rect.txt, line 1: expected"):
        read_collections([tmp_path / "set"])


def test_two_folders_of_one_name_are_refused(tmp_path: Path) -> None:
    paths = [write_otb(tmp_path / each / "Car1", BOXES) for each in ("a", "b")]
    with pytest.raises(ValueError, match="real: expected recordings of different names, got two called Car1"):
        read_collections(paths)
