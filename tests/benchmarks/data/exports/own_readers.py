"""Exports of a set, each read by its own reader or by its rules and compared with the stored truth.

``READERS`` has a function for each format: it takes a data set and the folder of its export, and fails where what is
read is not the truth. Boxes are compared with those around the pixels of instance maps, as average precision.
"""

from __future__ import annotations

import csv
from collections.abc import Callable
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray

from benchmarks.data.exports.exporter import sequence_name
from benchmarks.data.exports.rerun import RECORDING
from benchmarks.data.layouts.collection import read_collections
from benchmarks.data.mots_text import read_mots
from benchmarks.data.sets.data_set import DataSet
from benchmarks.data.sets.forward_flow import forward_flow
from scenarios import catalog
from tests.benchmarks.data.exports.scoring import Box, average_precision, evaluated
from tests.benchmarks.data.exports.test_coco import average_precision as coco_precision
from tests.benchmarks.data.exports.test_coco import opened
from tests.benchmarks.data.exports.test_hub import rows_of
from tests.benchmarks.data.exports.test_kitti import read_distance, read_flow, samples
from tests.benchmarks.data.exports.test_kitti_object import read_label
from tests.benchmarks.data.exports.test_mot import scored_against_itself
from tests.benchmarks.data.exports.test_outlines import filled
from tests.benchmarks.data.exports.test_rerun import values_of
from tests.benchmarks.data.exports.test_web_dataset import read as samples_of_shards
from tests.benchmarks.data.exports.test_yolo import labels_of, read_like_ultralytics

Seen = tuple[str, int, NDArray[np.float64], NDArray[np.bool_]]
"""Picture, class, box (4,), and pixels (H, W)."""


def classes_of(data: DataSet) -> list[str]:
    return list(dict.fromkeys(catalog.scenario(data.request.scenario).classes.values()))


def stem_of(data: DataSet, seed: int, frame: int) -> str:
    return f"{sequence_name(data, seed)}_{frame:06d}"


def size_of(data: DataSet) -> tuple[int, int]:
    camera = data.episode(data.seeds[0]).camera
    return camera.width_px, camera.height_px


def seen_in(data: DataSet, amodal: bool = False) -> list[Seen]:
    """Return each object that a pixel of an instance map shows.

    Args:
        amodal: with the boxes of whole objects, cut at the border, in place of those around the pixels.
    """
    kinds, numbers, found = catalog.scenario(data.request.scenario).classes, classes_of(data), list[Seen]()
    for seed in data.seeds:
        for k, frame in enumerate(data.episode(seed)):
            truth = frame.truth
            objects = zip(truth.kinds, truth.instance_id, truth.box_xyxy, strict=True)
            standing = zip(truth.standing_kinds, truth.standing_id, truth.standing_box_xyxy, strict=True)
            for kind, identity, whole_xyxy in (*objects, *standing):
                mask = truth.instance_map == identity
                if mask.any():
                    y, x = np.nonzero(mask)
                    box = np.array([x.min(), y.min(), x.max() + 1, y.max() + 1], float)
                    if amodal and np.isfinite(whole_xyxy).all():
                        box = np.clip(whole_xyxy, 0, [*size_of(data)] * 2)
                    found.append((stem_of(data, seed, k), numbers.index(kinds[kind]), box, mask))
    return found


def assert_perfect(data: DataSet, found: list[Box], amodal: bool = False) -> None:
    truth = [each[:3] for each in seen_in(data, amodal)]
    assert len(found) == len(truth) > 0
    assert average_precision(truth, found) == pytest.approx(1.0)


def corners(xywh: list[float]) -> NDArray[np.float64]:
    return np.array([*xywh[:2], xywh[0] + xywh[2], xywh[1] + xywh[3]])


def files_of(data: DataSet, out: Path, name: str) -> list[Any]:
    """Return what pycocotools reads of each split, with the pictures of its episodes and no others."""
    read = {split: opened(out / "annotations" / f"{name}_{split}.json") for split in data.splits}
    for split, seeds in data.splits.items():
        shown = {each["file_name"].rpartition("/")[0] for each in read[split].dataset["images"]}
        assert shown == {sequence_name(data, seed) for seed in seeds}
    return list(read.values())


def coco_boxes(data: DataSet, out: Path) -> None:
    found = list[Box]()
    for read in files_of(data, out, "instances"):
        assert coco_precision(read, "bbox", 0.0) == pytest.approx(1.0)
        assert coco_precision(read, "segm", 0.0) == pytest.approx(1.0)
        names = {each["id"]: each["file_name"].replace("/", "_").partition(".")[0] for each in read.dataset["images"]}
        notes = read.dataset["annotations"]
        found += [(names[each["image_id"]], each["category_id"] - 1, corners(each["bbox"])) for each in notes]
    assert_perfect(data, found)


def coco_keypoints(data: DataSet, out: Path) -> None:
    keys, count = ("image_id", "category_id", "keypoints"), 0
    for read in files_of(data, out, "person_keypoints"):
        (category,) = read.dataset["categories"]
        found = [{key: each[key] for key in keys} | {"score": 1.0} for each in read.dataset["annotations"]]
        assert evaluated(read, found, "keypoints", category["sigmas"]) == pytest.approx(1.0)
        count += len(found)
    assert count == len(seen_in(data))


def tao_amodal(data: DataSet, out: Path) -> None:
    read = opened(out / "amodal_annotations" / "validation_lvis_v1.json")
    assert coco_precision(read, "bbox", 0.0) == pytest.approx(1.0)
    seen = [each for each in read.dataset["annotations"] if each["visibility"] > 0]
    assert len(seen) == len(seen_in(data))
    followed(data, out)


def yolo(data: DataSet, out: Path) -> None:
    counts = {split: len(files) for split, files in read_like_ultralytics(out).items()}
    assert counts == {split: sum(len(data.episode(seed)) for seed in seeds) for split, seeds in data.splits.items()}
    lines = lines_of(out)
    scaled = [(stem, int(row[0]), row[1:].reshape(-1, 2) * size_of(data)) for stem, row in lines]
    if len(scaled[0][2]) == 2:
        assert_perfect(data, [(s, k, np.concatenate([c - 0.5 * size, c + 0.5 * size])) for s, k, (c, size) in scaled])
    else:
        assert_around(data, scaled)


def lines_of(out: Path) -> list[tuple[str, NDArray[np.float64]]]:
    return [(stem, row) for stem, rows in sorted(labels_of(out, 99).items()) for row in rows]


def yolo_seg(data: DataSet, out: Path) -> None:
    lines = lines_of(out)
    truth = sorted(seen_in(data), key=lambda each: each[0])
    assert [(stem, int(row[0])) for stem, row in lines] == [each[:2] for each in truth]
    for (_, row), (*_, mask) in zip(lines, truth, strict=True):
        told = filled(row[1:].reshape(-1, 2) * size_of(data), *mask.shape)
        assert told[mask].all()
        # Ways between parts are a pixel wide in the format; there is no other difference.
        parts = cv2.connectedComponents(mask.astype(np.uint8))[0] - 1
        assert (told == mask).all() or (parts > 1 and told.sum() - mask.sum() < sum(mask.shape))


def dota(data: DataSet, out: Path) -> None:
    found = list[Box]()
    for file in sorted(out.glob("*/labelTxt/*.txt"), key=lambda file: file.stem):
        for *numbers, kind, _ in map(str.split, file.read_text().splitlines()[2:]):
            found.append((file.stem, classes_of(data).index(kind), np.array(numbers, float).reshape(4, 2)))
    assert_around(data, found)


def assert_around(data: DataSet, found: list[Box]) -> None:
    """Fail unless rectangles (4, 2) are around the pixels, with the upright ones' area at most."""
    truth = sorted(seen_in(data), key=lambda each: each[0])
    assert [each[:2] for each in found] == [each[:2] for each in truth]
    for (*_, points), (_, _, box, mask) in zip(found, truth, strict=True):
        outline, inside = points.astype(np.float32), np.argwhere(mask)[:, ::-1] + 0.5
        assert cv2.contourArea(outline) <= np.prod(box[2:] - box[:2]) + 0.1
        assert all(cv2.pointPolygonTest(outline, each, True) > 0.4 for each in inside.tolist())


def hub(data: DataSet, out: Path) -> None:
    found, names = list[Box](), classes_of(data)
    for split, rows in rows_of(out).items():
        assert {row["seed"] for row in rows} == {*data.splits[split]}
        for row in rows:
            objects, stem = row["objects"], stem_of(data, row["seed"], row["frame"])
            for kind, box in zip(objects["category"], objects["bbox"], strict=True):
                found.append((stem, names.index(kind), corners(box)))
    assert_perfect(data, found)


def kitti_object(data: DataSet, out: Path) -> None:
    found = list[Box]()
    for number, seed, frame in samples(out):
        for line in (out / "training" / "label_2" / f"{number}.txt").read_text().splitlines():
            label = read_label(line)
            found.append((stem_of(data, seed, frame), classes_of(data).index(label.type), label.box))
    # KITTI's boxes end in the middle of pixels, and so at most half a pixel inside of the border.
    truth = [
        (s, k, np.clip(box - 0.5, 0, np.tile(size_of(data), 2) - 1)) for s, k, box, _ in seen_in(data, amodal=True)
    ]
    assert average_precision(truth, found) == pytest.approx(1.0)


def kitti_maps(data: DataSet, out: Path) -> None:
    """Depth, disparity and flow are the truth, to half a step of the files."""
    folder = next(
        each.name for each in (out / "training").iterdir() if each.name in ("depth", "disp_occ_0", "flow_occ")
    )
    is_forward = (out / "training" / "flow_noc").exists()
    assert samples(out)
    for number, seed, frame in samples(out):
        episode, path = data.episode(seed), out / "training" / folder / f"{number}_10.png"
        truth, camera = episode.frame(frame).truth, episode.camera
        if folder == "flow_occ":
            told, known = read_flow(path)
            wanted, step = forward_flow(episode, frame)[0] if is_forward else truth.flow_px, 1 / 64
        else:
            told, known = read_distance(path)
            scale = camera.focal_px * (camera.baseline_m or 0.0)
            wanted, step = truth.depth_m if folder == "depth" else scale / truth.depth_m, 1 / 256
        assert known.mean() > 0.5
        assert np.abs(told - wanted.astype(float))[known].max() <= 0.5 * step + 1e-9


def sintel_flow(data: DataSet, out: Path) -> None:
    for seed in data.seeds:
        files = sorted((out / "training" / "flow" / sequence_name(data, seed)).iterdir())
        assert len(files) == len(data.episode(seed)) - 1
        for frame, file in enumerate(files):
            wanted = forward_flow(data.episode(seed), frame)[0]
            known = np.isfinite(wanted)
            np.testing.assert_array_equal(cv2.readOpticalFlow(str(file))[known], wanted[known])


def mot(data: DataSet, out: Path) -> None:
    scored = scored_against_itself(out / "gt" / "mot_challenge" / "frameout-train", out.parent / f"answers-{out.name}")
    np.testing.assert_allclose(scored["HOTA"]["HOTA"], 1.0)
    assert scored["HOTA"]["LocA"].min() == pytest.approx(1.0)


def mots(data: DataSet, out: Path) -> None:
    wanted, found = list[tuple[str, bytes]](), list[tuple[str, bytes]]()
    for number, seed in enumerate(data.seeds):
        read = read_mots(out / "label_02" / f"{number:04d}.txt")
        stems = [stem_of(data, seed, int(frame)) for frame in read.frame]
        found += [(stem, read.mask(k).tobytes()) for k, stem in enumerate(stems)]
    wanted = [(stem, mask.tobytes()) for stem, *_, mask in seen_in(data)]
    assert sorted(found) == sorted(wanted)


def davis(data: DataSet, out: Path) -> None:
    image = pytest.importorskip("PIL.Image")
    objects = list(csv.DictReader((out / "objects.csv").read_text().splitlines()))
    assert objects
    for seed in data.seeds:
        name = sequence_name(data, seed)
        own = {each["name"]: int(each["number"]) for each in objects if each["sequence"] == name}
        for k, frame in enumerate(data.episode(seed) if own else ()):
            truth = frame.truth
            wanted = np.zeros(truth.instance_map.shape, np.uint8)
            for each, number in own.items():
                wanted[truth.instance_map == truth.instance_id[truth.index_of(each)]] = number
            with image.open(out / "Annotations" / "480p" / name / f"{k:05d}.png") as mask:
                np.testing.assert_array_equal(np.array(mask), wanted)


def followed(data: DataSet, out: Path) -> None:
    """What ``--real`` reads has the pictures of all episodes and a box of one target in some of them."""
    target = catalog.scenario(data.request.scenario).target
    (collection,) = read_collections([out], target=target if (out / "frames").exists() else None, rate_hz=10.0)
    assert collection.unusable == ()
    assert len(collection.sequences) == len(data.seeds)
    for each, seed in zip(collection.sequences, data.seeds, strict=True):
        assert len(each.pictures) == len(data.episode(seed))
        for frame, box in zip(data.episode(seed), each.box_xyxy, strict=True):
            whole_xyxy = frame.truth.box_xyxy[frame.truth.index_of(target)]
            assert np.isnan(box).any() or np.allclose(box, whole_xyxy)
        assert np.isfinite(each.box_xyxy).any()


def web_dataset(data: DataSet, out: Path) -> None:
    read = {each["__key__"]: each for split in data.splits for each in samples_of_shards(out, split)}
    assert len(read) == len(data)
    for seed in data.seeds:
        for k, frame in enumerate(data.episode(seed)):
            sample = read[stem_of(data, seed, k)]
            np.testing.assert_array_equal(sample["png"], frame.observation.image_rgb)
            np.testing.assert_array_equal(sample["instance_map.npy"], frame.truth.instance_map)
            names = [each["names"] for each in sample["json"]["objects"]]
            assert tuple(names[: len(frame.truth.names)]) == frame.truth.names


def rerun(data: DataSet, out: Path) -> None:
    values = values_of(out / RECORDING)
    assert {entity.split("/")[1] for entity, _, _ in values} == {f"seed-{seed:06d}" for seed in data.seeds}
    assert {frame for *_, frame in values} == {-1, *range(max(len(data.episode(seed)) for seed in data.seeds))}


READERS: dict[str, Callable[[DataSet, Path], Any]] = {
    "coco": coco_boxes,
    "coco-keypoints": coco_keypoints,
    "davis": davis,
    "dota": dota,
    "hub": hub,
    "kitti-depth": kitti_maps,
    "kitti-flow": kitti_maps,
    "kitti-forward-flow": kitti_maps,
    "kitti-object": kitti_object,
    "kitti-stereo": kitti_maps,
    "mot": mot,
    "mots": mots,
    "otb": followed,
    "rerun": rerun,
    "sintel-flow": sintel_flow,
    "tao-amodal": tao_amodal,
    "vot": followed,
    "webdataset": web_dataset,
    "yolo": yolo,
    "yolo-obb": yolo,
    "yolo-seg": yolo_seg,
}
