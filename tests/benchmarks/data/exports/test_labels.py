"""What exports say of objects: the same classes in all, what stands about, what shows too little."""

from __future__ import annotations

import csv
import json
import re
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from benchmarks.data.exports.exporter import export, formats
from benchmarks.data.exports.labels import Instance, Labels
from benchmarks.data.exports.web_dataset import NO_NUMBER
from benchmarks.data.mots_text import read_mots
from benchmarks.data.sets.card import table_configs
from benchmarks.data.sets.data_set import DataSet
from scenarios import catalog
from tests.benchmarks.data.exports.painted_scene import FRAMES, IDS, PARKED_ID, PARKED_XYXY, painted_data_set, truths
from tests.benchmarks.data.exports.test_web_dataset import read

# webdataset leaves closing shards to the garbage collector.
pytestmark = pytest.mark.filterwarnings("ignore:unclosed file:ResourceWarning")

PARKED_XYWH = [4.0, 26.0, 8.0, 4.0]


@pytest.fixture(scope="module")
def parked(tmp_path_factory: pytest.TempPathFactory) -> DataSet:
    """A van is parked in every picture."""
    return painted_data_set(tmp_path_factory.mktemp("parked") / "set", "parked")


def written(data: DataSet, name: str, folder: Path, **options: Any) -> Path:
    export(data, name, folder / "out", **options)
    return folder / "out"


def coco_of(folder: Path) -> dict[str, Any]:
    return json.loads((folder / "annotations" / "instances.json").read_text())


def test_coco_has_what_stands_about_and_the_visibilities_of_the_truth(parked: DataSet, tmp_path: Path) -> None:
    pytest.importorskip("pycocotools")
    found = coco_of(written(parked, "coco", tmp_path))
    names = {each["id"]: each["name"] for each in found["categories"]}
    frame_of = {each["id"]: int(Path(each["file_name"]).stem) for each in found["images"]}
    vans = [each for each in found["annotations"] if each["attributes"]["role"] == "parked"]
    assert len(vans) == 2 * FRAMES
    whole = {"visible_fraction": 1.0, "glare_fraction": 0.0, "occluded": False, "truncated": False}
    for each in vans:
        assert (names[each["category_id"]], each["bbox"], each["area"]) == ("car", PARKED_XYWH, 32)
        assert each["attributes"] == {"name": "parked-0", "kind": "van", "role": "parked"} | whole
    expected = {}
    for frame, truth in enumerate(truths("parked")):
        k = truth.index_of("target")
        share = float(truth.visible_fraction[k])
        if share > 0:
            expected[frame] = (round(share, 5), share < 0.5, truth.state[k] == "partial")
    assert len({each[1:] for each in expected.values()}) > 2
    of_target = [each for each in found["annotations"] if each["attributes"]["name"] == "target"]
    assert len(of_target) == 2 * len(expected)
    for each in of_target:
        told = tuple(each["attributes"][name] for name in ("visible_fraction", "occluded", "truncated"))
        assert told == expected[frame_of[each["image_id"]]]


def test_what_stands_about_is_in_the_text_files_and_their_sidecar_in_yolo(parked: DataSet, tmp_path: Path) -> None:
    out = written(parked, "yolo", tmp_path)
    with (out / "objects.csv").open(newline="") as file:
        rows = list(csv.DictReader(file))
    lines = {str(path.relative_to(out)): path.read_text().splitlines() for path in out.rglob("labels/*/*.txt")}
    assert len(rows) == sum(map(len, lines.values()))
    of_vans = [row for row in rows if row["role"] == "parked"]
    assert len(of_vans) == 2 * FRAMES
    for row in of_vans:
        number, *shares = lines[row["file"]][int(row["line"]) - 1].split()
        assert (row["class"], int(number)) == ("car", 1)
        np.testing.assert_allclose(np.array(shares, float) * (40, 32, 40, 32), [8, 28, 8, 4], atol=1e-5)


def test_what_stands_about_has_rows_in_mot_and_tracks_in_tao(parked: DataSet, tmp_path: Path) -> None:
    (objects,) = written(parked, "mot", tmp_path / "mot").rglob("painted-v1-parked-000003/gt/objects.txt")
    (van,) = [line.split(",") for line in objects.read_text().splitlines() if "parked-0" in line]
    assert van[1:] == ["parked-0", "van", "car", "parked"]
    rows = [row.split(",") for row in objects.with_name("gt.txt").read_text().splitlines()]
    boxes = [[float(cell) for cell in row[2:6]] for row in rows if row[1] == van[0]]
    assert boxes == [[5.0, 27.0, 8.0, 4.0]] * FRAMES
    out = written(parked, "tao-amodal", tmp_path / "tao")
    found = json.loads((out / "amodal_annotations" / "validation.json").read_text())
    mine = [each for each in found["annotations"] if each["attributes"]["role"] == "parked"]
    assert len({each["track_id"] for each in mine}) == 2
    assert all(each["amodal_bbox"] == each["bbox"] == PARKED_XYWH for each in mine)
    assert len(mine) == 2 * FRAMES


def test_webdataset_lists_what_stands_about(parked: DataSet, tmp_path: Path) -> None:
    for sample in read(written(parked, "webdataset", tmp_path)):
        *asked, van = sample["json"]["objects"]
        assert (van["names"], van["kinds"], van["class"], van["class_number"]) == ("parked-0", "van", "car", 1)
        assert van["visible_box_xyxy"] == PARKED_XYXY.tolist()
        assert (sample["instance_map.npy"] == van["instance_id"]).sum() == 32
        assert van["instance_id"] == PARKED_ID
        assert (van["side"], van["frames_since_exit"], van["speed_mps"]) == ("", -1, NO_NUMBER)
        assert [(each["class_number"], each["stands"]) for each in asked] == [(0, False), (1, False), (2, False)]
        assert van["stands"]


def test_rerun_draws_what_stands_about_with_its_bounds(parked: DataSet, tmp_path: Path) -> None:
    pytest.importorskip("rerun", reason="rerun-sdk is not installed")
    from tests.benchmarks.data.exports.test_rerun import RECORDING, values_of

    found = values_of(written(parked, "rerun", tmp_path) / RECORDING)
    labels = found["/seed-000003/objects", "Boxes3D:labels", 4]
    k = labels.index("parked-0")
    np.testing.assert_allclose(found["/seed-000003/objects", "Boxes3D:centers", 4][k], [1, 0, 1])
    np.testing.assert_allclose(found["/seed-000003/objects", "Boxes3D:half_sizes", 4][k], [2, 1, 1])


def test_numbers_are_those_of_the_scenes_list_whatever_occurs(data: DataSet, parked: DataSet, tmp_path: Path) -> None:
    """A van stands in one of the sets alone."""
    pytest.importorskip("pycocotools")
    for level, expected in (("class", ["bus", "car", "kite"]), ("kind", ["bus", "van", "car", "kite"])):
        for each in (data, parked):
            found = coco_of(written(each, "coco", tmp_path / level / each.request.preset, classes=level))
            assert [(c["id"], c["name"]) for c in found["categories"]] == list(enumerate(expected, start=1))


@pytest.mark.parametrize("name", [each.id for each in catalog.entries() if each.place.startswith("scenarios.")])
def test_every_scene_lists_its_classes(name: str) -> None:
    expected = {
        "road-town-v2": {"car", "lorry", "bus", "motorbike", "person", "cyclist"},
        "road-town-v3": {"car", "lorry", "bus", "motorbike", "person", "cyclist"},
        "stereo-follow-v2": {"person"},
        "fish-tank-v1": {"fish"},
        "fish-tank-ptz-v1": {"fish"},
        "harbour-v1": {"person", "car", "boat"},
        "harbour-ptz-v1": {"person", "car", "boat"},
        "paper-sheet-v1": {"sheet"},
    }
    assert set(catalog.scenario(name).classes.values()) == expected[name]


def test_a_kind_that_the_scene_does_not_list_is_refused(data: DataSet) -> None:
    with pytest.raises(ValueError, match="kind: expected one that painted-v1 lists in its classes, got 'tram'"):
        Labels(data).class_of("tram")


def instance(share: float, visible_xyxy: tuple[float, ...], glare: float = 0.0) -> Instance:
    box = np.array(visible_xyxy)
    return Instance("target", "car", 1, 2, "in", box, box, share, glare, np.eye(4), np.zeros((2, 3)))


def test_least_values_are_inclusive(data: DataSet) -> None:
    labels = Labels(data, min_visible=0.25, min_size_px=4)
    assert labels.takes(instance(0.25, (0, 0, 9, 4)))
    assert not labels.takes(instance(0.24, (0, 0, 9, 4)))
    assert not labels.takes(instance(0.25, (0, 0, 9, 3)))
    assert not labels.takes(instance(0.5, (0, 0, 9, 4), glare=0.6))
    hidden = instance(0.0, (np.nan,) * 4)
    assert Labels(data).takes(hidden)
    assert not Labels(data, min_size_px=1).takes(hidden)
    parked = replace(instance(1.0, (0, 0, 9, 4)), stands=True)
    assert Labels(data).takes(parked)
    assert not Labels(data, ignore_standing=True).takes(parked)


def test_what_shows_too_little_is_left_out_or_ignored_and_counted(data: DataSet, tmp_path: Path) -> None:
    pytest.importorskip("pycocotools")
    shares = [share for truth in truths() for share in truth.visible_fraction if share > 0]
    few = 2 * sum(share < 0.6 for share in shares)
    assert 0 < few < 2 * len(shares)
    assert export(data, "coco", tmp_path / "coco", min_visible=0.6) == few
    annotations = coco_of(tmp_path / "coco")["annotations"]
    assert len(annotations) == 2 * len(shares)
    assert all(each["iscrowd"] == (each["attributes"]["visible_fraction"] < 0.6) for each in annotations)
    assert export(data, "yolo", tmp_path / "yolo", min_visible=0.6) == few
    told = f"Made with `--classes class`. {few} objects of single pictures below `--min-visible 0.6 --min-size 0`.\n"
    assert all(told in (tmp_path / name / "README.md").read_text() for name in ("coco", "yolo"))
    lines = [line for path in (tmp_path / "yolo").rglob("labels/*/*.txt") for line in path.read_text().splitlines()]
    assert len(lines) == 2 * len(shares) - few


def test_what_stands_about_can_be_ignored_in_every_format_that_has_a_word_for_it(
    parked: DataSet, tmp_path: Path
) -> None:
    pytest.importorskip("pycocotools")
    for name in ("coco", "mot", "mots", "yolo", "dota"):
        assert export(parked, name, tmp_path / name, ignore_standing=True) == 2 * FRAMES
        assert "--min-size 0` or standing about (`--ignore-standing`)." in (tmp_path / name / "README.md").read_text()
    crowds = [each for each in coco_of(tmp_path / "coco")["annotations"] if each["iscrowd"]]
    assert {each["attributes"]["role"] for each in crowds} == {"parked"}
    rows = [line.split(",") for path in (tmp_path / "mot").rglob("gt.txt") for line in path.read_text().splitlines()]
    assert sorted({tuple(row[6:8]) for row in rows}) == [("0", "8"), ("1", "1")]
    ignored = read_mots(tmp_path / "mots" / "label_02" / "0000.txt")
    regions = np.flatnonzero(ignored.kind == 10)
    assert len(regions) == FRAMES
    x_min, y_min, x_max, y_max = PARKED_XYXY.astype(int)
    for k in regions:
        assert ignored.identity[k] == 10_000
        mask = ignored.mask(int(k))
        assert mask[y_min:y_max, x_min:x_max].all()
        assert mask.sum() == 32


def test_classes_that_a_set_keeps_are_labelled_alone_with_their_own_numbers(tmp_path: Path) -> None:
    """The order is that of the request, also of classes that only other scenes have."""
    data = painted_data_set(tmp_path / "set", "parked")
    data.request = replace(data.request, classes=("boat", "kite", "car"))
    labels = Labels(data)
    assert labels.names == ("boat", "kite", "car")
    assert Labels(data, "kind").names == ("van", "car", "kite")
    out = written(data, "yolo", tmp_path)
    numbers = {line.split()[0] for path in out.rglob("labels/*/*.txt") for line in path.read_text().splitlines()}
    assert numbers == {"1", "2"}
    assert {row["class"] for row in csv.DictReader((out / "objects.csv").open())} == {"kite", "car"}
    assert data.table("objects").num_rows == 3 * len(data), "truth is whole"


@pytest.mark.parametrize(("share", "left"), [(0.0, 0), (0.2, 3), (0.3, 5), (0.5, 6), (1.0, 6)])
def test_of_pictures_without_a_label_the_share_that_is_asked_for_is_written(
    tmp_path: Path, share: float, left: int
) -> None:
    """The car is in six pictures of nine, then out of the picture: twelve of two episodes show it, six do not."""
    data = painted_data_set(tmp_path / "set")
    data.request = replace(data.request, classes=("car",), negatives=share, splits={"test": 1.0})
    shown = sum(bool((truth.instance_map == IDS[1]).any()) for truth in truths())
    out = written(data, "yolo", tmp_path)
    texts = [path.read_text() for path in out.rglob("labels/*/*.txt")]
    assert (sum(map(bool, texts)), len(texts) - sum(map(bool, texts))) == (2 * shown, left)
    assert len(list(out.rglob("images/*/*.*"))) == len(texts)
    export(data, "mot", tmp_path / "mot")
    assert len(list((tmp_path / "mot").rglob("img1/*"))) == len(data), "sequences are whole"


@pytest.mark.parametrize(
    ("name", "options", "message"),
    [
        ("yolo", {"min_visible": 1.5}, "min_visible: expected a share of 0 to 1, got 1.5"),
        ("yolo", {"min_size_px": -1.0}, "min_size: expected a number of pixels >= 0, got -1.0"),
        (
            "tao-amodal",
            {"min_visible": 0.5},
            "min_visible min_size ignore_standing: expected none, since tao-amodal holds all, got (0.5, 0.0, False)",
        ),
        ("otb", {"classes": "kind"}, "classes: expected class, since otb has none, got 'kind'"),
    ],
)
def test_options_that_are_not_possible_are_refused(
    data: DataSet, tmp_path: Path, name: str, options: dict[str, Any], message: str
) -> None:
    with pytest.raises(ValueError, match=f"^{re.escape(message)}$"):
        export(data, name, tmp_path / "out", **options)
    assert not (tmp_path / "out").exists()


def test_a_set_without_what_stands_about_has_single_targets_alone(tmp_path: Path) -> None:
    """The episodes that canaries watch are of format 2."""
    old = DataSet(str(Path(__file__).parents[3] / "canaries/episodes/road-town"))
    told = r"^data: expected a set of format 4, with what only stands about \(`frameout generate` .*, got format 2$"
    old.request = replace(old.request, channels=("image_rgb", "instance_map"))
    for name in ("coco", "mot", "tao-amodal", "webdataset", "yolo"):
        with pytest.raises(ValueError, match=told):
            export(old, name, tmp_path / "out", allow_incomplete=True)
    assert list(table_configs(old)) == ["frames", "objects"]


def test_glare_has_a_field_of_its_own(data: DataSet, tmp_path: Path) -> None:
    exporter = formats()["otb"](data, tmp_path, Labels(data))
    stored = next(exporter.frames(data.episode(3)))
    truth = stored.frame.truth
    covered = replace(truth, glare_fraction=np.array([0.0, 0.75, 1.0]))
    now = list(Labels(data).instances(replace(stored, frame=replace(stored.frame, truth=covered))))
    for k, each in enumerate(now):
        assert each.visible_fraction == truth.visible_fraction[k]
        assert each.attributes()["glare_fraction"] == covered.glare_fraction[k]
        assert each.attributes()["occluded"] == (truth.visible_fraction[k] < 0.5)
