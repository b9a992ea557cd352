"""Each layout as it is published: recognised, chosen, taken for no other, and read with all that it tells."""

from __future__ import annotations

import gzip
import json
import shutil
import subprocess
import sys
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from benchmarks.data.layouts.collection import read_collections
from benchmarks.data.layouts.layout import Source, layout, layouts
from benchmarks.data.sequences import BoxedSequence, Labelled
from tests.benchmarks.data.layouts import written_layouts as written
from tests.benchmarks.data.layouts.test_collection import write_uav123, write_uavdt
from tests.benchmarks.data.layouts.written_layouts import CLIPPED_XYXY, FRAMES, LAYOUTS, SEEN_XYXY, STATES
from tests.benchmarks.data.written_sequences import lines_of, write_lines, write_otb

OLDER: dict[str, Callable[[Path], Path]] = {
    "otb": lambda root: write_otb(root / "Car1").parent,
    "uavdt": write_uavdt,
    "uav123": write_uav123,
}
WRITERS = OLDER | {name: write for name, (write, _) in LAYOUTS.items()}


STATES_OF_VOT = tuple("in" if state == "partial" else state for state in STATES)
"""Whether boxes end at the border is not told, but by our export."""


def read_one(path: Path, **how: object) -> BoxedSequence:
    (sequence,) = read_collections([path], **how)[0].sequences  # type: ignore[arg-type]
    return sequence


def test_there_is_a_small_data_set_of_every_layout() -> None:
    assert WRITERS.keys() == layouts().keys()


@pytest.mark.parametrize("name", WRITERS)
def test_a_layout_is_taken_for_no_other(tmp_path: Path, name: str) -> None:
    root = WRITERS[name](tmp_path / "set")
    assert [each for each, found in layouts().items() if list(found.find(root))] == [name]


@pytest.mark.parametrize("name", LAYOUTS)
def test_a_layout_is_recognised_and_chosen(tmp_path: Path, name: str) -> None:
    write, sequence = LAYOUTS[name]
    root = write(tmp_path / "set")
    assert read_one(root).name == read_one(root, layout=name).name == sequence


@pytest.mark.parametrize("name", LAYOUTS)
def test_a_sequence_is_found_by_each_of_its_places(tmp_path: Path, name: str) -> None:
    write, sequence = LAYOUTS[name]
    (source,) = layouts()[name].find(write(tmp_path / "set"))
    for place in source.places:
        assert place.exists()
        assert read_one(place).name == sequence


@pytest.mark.parametrize(
    ("name", "boxes", "states", "rate_hz"),
    [
        ("lasot", CLIPPED_XYXY, ("in", "in", "occluded", "out", "out", "in", "in", "in"), 30.0),
        ("got10k", CLIPPED_XYXY, ("in", "in", "occluded", "unseen", "unseen", "partial", "occluded", "in"), 10.0),
        ("trackingnet", np.where(np.isnan(CLIPPED_XYXY), CLIPPED_XYXY[1], CLIPPED_XYXY), ("in",) * FRAMES, 30.0),
        ("vot", SEEN_XYXY, STATES_OF_VOT, 25.0),
        ("mot", SEEN_XYXY, ("in", "in", "occluded", "unseen", "unseen", "partial", "occluded", "in"), 14.0),
        ("tao_amodal", SEEN_XYXY, STATES, 7.5),
        ("webdataset", SEEN_XYXY, STATES, 12.5),
        ("mots", CLIPPED_XYXY, ("in", "in", "unseen", "unseen", "unseen", "in", "in", "in"), 10.0),
        ("coco", CLIPPED_XYXY, ("in", "in", "unseen", "unseen", "unseen", "in", "in", "in"), 30.0),
    ],
)
def test_boxes_and_states_are_what_files_tell(
    tmp_path: Path, name: str, boxes: np.ndarray, states: tuple[str, ...], rate_hz: float
) -> None:
    read = read_one(getattr(written, f"write_{name}")(tmp_path / "set"))
    np.testing.assert_allclose(read.box_xyxy, boxes, atol=1e-9)
    assert tuple(read.state) == states
    assert read.rate_hz == rate_hz
    assert len(read.pictures) == FRAMES
    assert not np.diff(read.place, n=2).any()


def test_a_target_of_yolo_is_known_by_its_name(tmp_path: Path) -> None:
    read = read_one(written.write_yolo(tmp_path / "set"), target="target")
    np.testing.assert_allclose(read.box_xyxy, CLIPPED_XYXY, atol=1e-9)
    assert tuple(read.state) == ("in", "in", "unseen", "unseen", "unseen", "in", "in", "in")


def test_a_picture_that_is_missing_leaves_a_gap_in_time(tmp_path: Path) -> None:
    read = read_one(written.write_kitti(tmp_path / "set"))
    left = [k for k in range(FRAMES) if k != 1]
    np.testing.assert_allclose(read.box_xyxy, CLIPPED_XYXY[left], atol=1e-6)
    assert tuple(read.state) == ("in", "unseen", "unseen", "unseen", "partial", "occluded", "in")
    assert (read.place.tolist(), read.rate_hz) == (left, 10.0)
    assert read.notes == ("training/label_02/0001.txt: 1 labels of frames without a picture are left out",)


@pytest.mark.parametrize("write", [written.write_oxuva, written.write_tao, written.write_davis])
def test_pictures_without_a_label_are_shown(tmp_path: Path, write: Callable[[Path], Path]) -> None:
    """From the first label to the last."""
    read = read_one(write(tmp_path / "set"))
    words = ("in", "unlabelled", "unseen", "unlabelled", "unseen", "unlabelled", "in")
    assert tuple(read.state) == words
    expected = np.where((np.arange(FRAMES - 1) % 2 == 0)[:, None], CLIPPED_XYXY[:7], np.nan)
    np.testing.assert_allclose(read.box_xyxy, expected, atol=1e-6)
    assert len(read.pictures) == FRAMES - 1


@pytest.mark.parametrize("inside", [False, True])
def test_masks_in_the_folders_of_kitti_are_masks(tmp_path: Path, inside: bool) -> None:
    root = written.write_mots(tmp_path / "set")
    (root / "instances_txt").rename(root / "training" / "label_02")
    assert read_one(root / "training" if inside else root).name == "0002-1007"


@pytest.mark.parametrize(
    ("mask", "message"),
    [
        (np.zeros((24, 32), np.uint8), "480p/car: expected masks of 64 x 48 pixels, .*, got one of 32 x 24"),
        (np.full((48, 64), 700, np.uint16), "car/00002.png: expected a PNG with a palette, or of 8 bits"),
    ],
)
def test_masks_of_davis_of_another_size_or_kind_are_named(tmp_path: Path, mask: np.ndarray, message: str) -> None:
    root = written.write_davis(tmp_path / "set")
    Image.fromarray(mask).save(root / "Annotations" / "480p" / "car" / "00002.png")
    with pytest.raises(ValueError, match=message):
        read_one(root)


@pytest.mark.parametrize("folder", ["{}/images/town-000003/", "town-000003\\\\"])
def test_pictures_of_coco_may_be_named_in_other_ways(tmp_path: Path, folder: str) -> None:
    root = written.write_coco(tmp_path / "set")
    before, file = read_one(root).fingerprint, root / "annotations" / "instances.json"
    file.write_text(file.read_text().replace("town-000003/", folder.format(root)))
    read = read_one(root)
    assert replace(read, name="town-000003-target").fingerprint == before


def test_pictures_of_coco_may_lie_in_no_folder(tmp_path: Path) -> None:
    root = written.write_coco(tmp_path / "set")
    for picture in (root / "images" / "town-000003").iterdir():
        picture.rename(root / "images" / picture.name)
    file = root / "annotations" / "instances.json"
    file.write_text(file.read_text().replace("town-000003/", ""))
    assert read_one(root).name == "set-target"


@pytest.mark.parametrize("metadata", [None, ["a"], {"fps": None}, {"fps": "x"}])
def test_a_video_of_tao_need_not_tell_its_rate(tmp_path: Path, metadata: object) -> None:
    file = written.write_tao_amodal(tmp_path / "set") / "amodal_annotations" / "validation.json"
    content = json.loads(file.read_text())
    content["videos"][0]["metadata"] = metadata
    file.write_text(json.dumps(content))
    assert read_one(tmp_path / "set").rate_hz == 30.0


@pytest.mark.parametrize("name", ["lasot", "got10k", "trackingnet", "vot", "mot", "kitti", "oxuva", "mots", "yolo"])
def test_text_may_have_lines_of_windows_a_mark_and_a_blank_end(tmp_path: Path, name: str) -> None:
    write, _ = LAYOUTS[name]
    before = read_one(write(tmp_path / "set"))
    for file in (tmp_path / "set").rglob("*"):
        if file.is_file() and file.suffix in ("", ".txt", ".label", ".tag", ".ini", ".csv"):
            file.write_bytes(b"\xef\xbb\xbf" + file.read_bytes().replace(b"\n", b"\r\n") + b"\r\n")
    (collection,) = read_collections([tmp_path / "set"])
    assert not collection.unusable
    assert collection.sequences[0].fingerprint == before.fingerprint


def test_a_box_without_area_shows_nothing(tmp_path: Path) -> None:
    file = written.write_mot(tmp_path / "set") / "train" / "MOT17-02-FRCNN" / "gt" / "gt.txt"
    file.write_text(file.read_text().replace("8,7,35,21,12,8", "8,7,35,21,0,8"))
    read = read_one(tmp_path / "set")
    assert read.state[-1] == "unseen"
    assert np.isnan(read.box_xyxy[-1]).all()


def test_mots_challenge_lies_as_mot(tmp_path: Path) -> None:
    root = written.write_mots(tmp_path / "set")
    folder = root / "train" / "MOTS20-02"
    (folder / "gt").mkdir(parents=True)
    (root / "training" / "image_02" / "0002").rename(folder / "img1")
    (root / "instances_txt" / "0002.txt").rename(folder / "gt" / "gt.txt")
    write_lines(folder / "seqinfo.ini", ["[Sequence]", "imDir=img1", "frameRate=30"])
    read = read_one(root)
    assert (read.name, read.rate_hz) == ("MOTS20-02-1007", 30.0)
    np.testing.assert_allclose(read.box_xyxy, CLIPPED_XYXY)


def test_masks_of_davis_2016_have_one_object(tmp_path: Path) -> None:
    root = written.write_davis(tmp_path / "set")
    for file in (root / "Annotations" / "480p" / "car").iterdir():
        mask = np.where(written.number_map(int(file.stem), 1), 255, 0).astype(np.uint8)
        Image.fromarray(mask).save(file)
    read = read_one(root)
    assert read.name == "car-255"
    np.testing.assert_allclose(read.box_xyxy[::2], CLIPPED_XYXY[:7:2])


def test_rows_of_kitti_may_have_a_score(tmp_path: Path) -> None:
    file = written.write_kitti(tmp_path / "set") / "training" / "label_02" / "0001.txt"
    before = read_one(tmp_path / "set").fingerprint
    first, *others = file.read_text().splitlines()
    write_lines(file, [f"{first} 0.9", *others])
    assert read_one(tmp_path / "set").fingerprint == before


def test_each_target_of_vots_is_a_sequence(tmp_path: Path) -> None:
    folder = written.write_vot(tmp_path / "set") / "car1"
    one = (folder / "groundtruth.txt").read_text()
    (folder / "groundtruth.txt").unlink()
    for name in ("car", "zebra"):
        (folder / f"groundtruth_{name}.txt").write_text(one)
    found = read_collections([tmp_path / "set"])[0].sequences
    assert [each.name for each in found] == ["car1-car", "car1-zebra"]


def test_vot_of_before_2018_has_pictures_beside_its_polygons(tmp_path: Path) -> None:
    folder = written.write_vot(tmp_path / "set") / "car1"
    for picture in (folder / "color").iterdir():
        picture.rename(folder / picture.name)
    (folder / "color").rmdir()
    (folder / "sequence").unlink()
    (folder / "occlusion.tag").rename(folder / "occlusion.label")
    read = read_one(tmp_path / "set")
    assert (tuple(read.state), read.rate_hz) == (STATES_OF_VOT, 30.0)


def test_boxes_of_vot_that_are_whole_tell_where_the_border_cuts(tmp_path: Path) -> None:
    file = written.write_vot(tmp_path / "set") / "car1" / "sequence"
    write_lines(file, [*file.read_text().splitlines(), "boxes=whole"])
    assert tuple(read_one(tmp_path / "set").state) == STATES


def test_regions_of_vot_that_are_missing_at_the_end_are_unknown(tmp_path: Path) -> None:
    file = written.write_vot(tmp_path / "set") / "car1" / "groundtruth.txt"
    write_lines(file, file.read_text().splitlines()[:2])
    assert tuple(read_one(tmp_path / "set").state) == ("in", "in")
    write_lines(file, file.read_text().splitlines()[:1])
    with pytest.raises(ValueError, match=r"^car1/groundtruth.txt: expected labels of at least two pictures, got 1$"):
        read_one(tmp_path / "set")


def test_a_target_is_chosen_by_id_or_name(tmp_path: Path) -> None:
    root = written.write_mot(tmp_path / "mot")
    assert read_one(root, target=2).name == read_one(root, target="2").name == "MOT17-02-FRCNN-2"
    root = written.write_tao_amodal(tmp_path / "tao")
    assert [read_one(root, target=each).name for each in (None, 7, "target")] == ["town-7", "town-7", "town-target"]


def test_a_rate_that_is_given_goes_before_the_file_s(tmp_path: Path) -> None:
    assert read_one(written.write_vot(tmp_path / "set"), rate_hz=30.0).rate_hz == 30.0


OXUVA = "vid0042,obj0001,2,car,false,false"
BROKEN = {
    "lasot, no number": ("lasot", "car/car-7/groundtruth.txt", 2, "1,2,x,4"),
    "lasot, no flag": ("lasot", "car/car-7/out_of_view.txt", 1, "0,1,2"),
    "got10k, no level": ("got10k", "val/GOT-10k_Val_000001/cover.label", 3, "9"),
    "got10k, no box": ("got10k", "val/GOT-10k_Val_000001/groundtruth.txt", 2, "1,2,-3,4"),
    "trackingnet": ("trackingnet", "TRAIN_3/anno/abc_0.txt", 4, "1,2,3"),
    "vot, no region": ("vot", "car1/groundtruth.txt", 6, "1,2,3"),
    "vot, no property": ("vot", "car1/sequence", 2, "hello"),
    "mot": ("mot", "train/MOT17-02-FRCNN/gt/gt.txt", 3, "1,2,3"),
    "mot, no picture": ("mot", "train/MOT17-02-FRCNN/gt/gt.txt", 14, "99,7,1,1,2,2,1,1,1"),
    "kitti": ("kitti", "training/label_02/0001.txt", 1, "0 7 Car 0 0"),
    "kitti, no frame": ("kitti", "training/label_02/0001.txt", 1, f"1e300 7 Car{' 1' * 14}"),
    "oxuva": ("oxuva", "annotations/dev.csv", 2, "vid0042,obj0001,2"),
    "oxuva, no frame": ("oxuva", "annotations/dev.csv", 1, f"{OXUVA},{'1' * 400},absent,-1,-1,-1,-1"),
    "oxuva, pixels": ("oxuva", "annotations/dev.csv", 1, f"{OXUVA},90,present,10,22,20,28"),
    "tao": ("tao", "annotations/validation.json", 1, '{"images": [}'),
    "mots": ("mots", "instances_txt/0002.txt", 2, "0 1007 1 48"),
    "yolo, no line": ("yolo", "labels/val/town_000002.txt", 1, "0 0.5 0.5"),
}
"""Layout, file, number of a line, and what it becomes."""


@pytest.mark.parametrize(("name", "place", "number", "text"), BROKEN.values(), ids=BROKEN)
def test_what_is_broken_is_named_with_file_and_line(
    tmp_path: Path, name: str, place: str, number: int, text: str
) -> None:
    file = spoilt(tmp_path, name, place, number, text)
    with pytest.raises(ValueError, match="expected") as raised:
        read_collections([tmp_path / "set"])
    assert f"{'/'.join(file.parts[-2:])}, line {number}" in str(raised.value)
    assert "\n" not in str(raised.value)


def spoilt(folder: Path, name: str, place: str, number: int, text: str) -> Path:
    """Write a data set in a layout, with another line in a file, which is returned."""
    file = LAYOUTS[name][0](folder / "set") / place
    lines = file.read_text(errors="replace").splitlines()
    lines[number - 1] = text
    return write_lines(file, lines)


SMALL = f"0 1007 1 24 32 {written.counts(np.ones((24, 32)))}"
NO_BOX = '{"images": [{"id": 1, "file_name": "town-000003/0.png"}], "annotations": [{"image_id": 1}]}'
ODD = {
    "vot, no length": ("vot", "car1/sequence", 3, f"length={10**12}", "car1/sequence: expected as length"),
    "tao, no picture": (
        "tao",
        "annotations/validation.json",
        1,
        '{"images": [{"id": 1}]}',
        "images, entry 1: expected",
    ),
    "coco, no box": ("coco", "annotations/instances.json", 1, NO_BOX, "annotations, entry 1"),
    "mots, size": (
        "mots",
        "instances_txt/0002.txt",
        1,
        SMALL,
        "expected masks of 64 x 48 pixels, .*, got one of 32 x 24",
    ),
    "davis": ("davis", "Annotations/480p/car/00002.png", 1, "no mask", "480p/car/00002.png: expected a PNG"),
    "yolo, no table": ("yolo", "objects.csv", 1, "file,class", "set/objects.csv: expected columns file"),
}


@pytest.mark.parametrize(("name", "place", "number", "text", "message"), ODD.values(), ids=ODD)
def test_what_is_odd_is_named(tmp_path: Path, name: str, place: str, number: int, text: str, message: str) -> None:
    spoilt(tmp_path, name, place, number, text)
    with pytest.raises(ValueError, match=message):
        read_collections([tmp_path / "set"])


@pytest.mark.parametrize(("name", "place"), [("vot", "car1/sequence"), ("mot", "train/MOT17-02-FRCNN/seqinfo.ini")])
def test_a_broken_sequence_costs_itself_alone(tmp_path: Path, name: str, place: str) -> None:
    root = LAYOUTS[name][0](tmp_path / "set")
    file = root / place
    shutil.copytree(file.parent, file.parent.with_name("another"))
    write_lines(file, ["hello"])
    (collection,) = read_collections([root])
    assert [each.name.split("-")[0] for each in collection.sequences] == ["another"]
    assert [f"{file.name}, line 1" in line for line in collection.unusable] == [True]


def test_labels_that_are_no_text_cost_their_sequence_alone(tmp_path: Path) -> None:
    root = written.write_mot(tmp_path / "set")
    shutil.copytree(root / "train" / "MOT17-02-FRCNN", root / "train" / "another")
    (root / "train" / "another" / "gt" / "gt.txt").write_bytes(b"\xff\xfe1\0")
    (collection,) = read_collections([root])
    assert [each.name for each in collection.sequences] == ["MOT17-02-FRCNN-7"]
    assert collection.unusable == ("another/gt/gt.txt: expected text with numbers, got bytes that are none",)


def test_folders_above_are_searched_up_to_those_of_a_person(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    root = written.write_trackingnet(tmp_path / "home" / "set")
    place = root / "TRAIN_3" / "anno" / "abc_0.txt"
    assert read_one(place).name == "abc_0"
    monkeypatch.setattr(Path, "home", lambda: root / "TRAIN_3")
    with pytest.raises(ValueError, match=r"abc_0.txt', which has none$"):
        read_one(place)


def test_what_is_broken_in_a_tar_file_is_named(tmp_path: Path) -> None:
    file = written.write_webdataset(tmp_path / "set") / "town-train-00001.tar"
    whole = file.read_bytes()
    file.write_bytes(whole.replace(b'"time_s"', b'"time_x"'))
    with pytest.raises(ValueError, match=r"^town-train-00001.tar/town-000003_000005.json: expected truth as "):
        read_collections([tmp_path / "set"])
    file.write_bytes(whole.replace(b'"box_xyxy": [', b'"box_xyxy": ["'))
    with pytest.raises(ValueError, match=r"^set/town-train-00001.tar/town-000003_000005.json, line 1: expected JSON"):
        read_collections([tmp_path / "set"])
    file.write_bytes(gzip.compress(whole))
    with pytest.raises(ValueError, match=r"^set/town-train-00001.tar: expected a tar file, got "):
        read_collections([tmp_path / "set"])
    file.write_bytes(b"no tar file, but long enough" * 40)
    with pytest.raises(ValueError, match=r"^set/town-train-00001.tar: expected a tar file, got "):
        read_collections([tmp_path / "set"])


_WITHOUT_EXTRAS = """
import sys
from pathlib import Path

sys.modules |= dict.fromkeys(("blosc2", "fsspec", "h5py", "pyarrow", "pycocotools"))
import benchmarks.cli.score_function
import benchmarks.data.real
from benchmarks.data.layouts.collection import read_collections

for root in sys.argv[1:]:
    try:
        print(read_collections([Path(root)])[0].name)
    except ValueError as error:
        print(error)
"""


def test_layouts_without_masks_need_no_extra(tmp_path: Path) -> None:
    roots = [
        written.write_lasot(tmp_path / "lasot"),
        written.write_mot(tmp_path / "mot"),
        written.write_mots(tmp_path / "mots"),
    ]
    done = subprocess.run(
        [sys.executable, "-c", _WITHOUT_EXTRAS, *map(str, roots)], capture_output=True, text=True, check=False
    )
    assert done.stderr == ""
    lasot, mot, mots = done.stdout.splitlines()
    assert (lasot, mot) == ("car-7", "MOT17-02-FRCNN-7")
    assert mots.endswith("expected pyarrow, pycocotools to be installed (pip install 'frameout[data]'), got none")


def test_a_layout_of_a_user_s_own_is_recognised(tmp_path: Path) -> None:
    from benchmarks.data.layouts import layout as registry

    def find(path: Path):  # type: ignore[no-untyped-def]
        for file in path.glob("*/mine.txt"):
            yield Source("mine", (file,), partial(read, file))

    def read(file: Path, target: object) -> Labelled:
        return Labelled("mine", file, sorted((file.parent / "img").iterdir()), SEEN_XYXY)

    write_pictures_of(tmp_path / "set" / "a")
    layout("mine", "NAME/mine.txt")(find)
    try:
        assert read_one(tmp_path / "set").name == "mine"
        with pytest.raises(ValueError, match=r"^layout: expected a name that no layout has, got 'otb'$"):
            layout("otb", "again")(find)
    finally:
        del registry._LAYOUTS["mine"]


def write_pictures_of(folder: Path) -> None:
    write_otb(folder, SEEN_XYXY)
    (folder / "groundtruth_rect.txt").rename(folder / "mine.txt")
    write_lines(folder / "mine.txt", lines_of(SEEN_XYXY))
