"""DAVIS exports: numbers and colours of masks, pictures, lists; read by OpenCV and by Pillow."""

from __future__ import annotations

import csv
from collections.abc import Callable
from pathlib import Path

import cv2
import numpy as np
import pytest

from benchmarks.data.exports.davis import palette
from benchmarks.data.exports.exporter import export
from tests.benchmarks.data.exports.painted_scene import FRAMES, IDS, NAMES, painted_data_set, truths

Image = pytest.importorskip("PIL.Image")
SHOWN = {"target": 1, "bus-1": 2}
"""The kite comes later."""


def masks_of(folder: Path) -> list[Path]:
    return sorted((folder / "Annotations" / "480p").rglob("*.png"))


def test_masks_have_the_numbers_of_objects_of_the_first_picture(exported: Callable[[str], Path]) -> None:
    folder = exported("davis")
    files = masks_of(folder)
    assert len(files) == 2 * FRAMES
    for file in files:
        truth = truths()[int(file.stem)]
        wanted = np.zeros(truth.instance_map.shape, np.uint8)
        for name, number in SHOWN.items():
            wanted[truth.instance_map == IDS[NAMES.index(name)]] = number
        with Image.open(file) as image:
            assert image.mode == "P"
            np.testing.assert_array_equal(np.array(image), wanted)
        coloured = cv2.cvtColor(cv2.imread(str(file), cv2.IMREAD_COLOR), cv2.COLOR_BGR2RGB)
        np.testing.assert_array_equal(coloured, palette()[wanted])


def test_the_palette_is_that_of_pascal_voc() -> None:
    assert palette()[:9].tolist() == [
        [0, 0, 0],
        [128, 0, 0],
        [0, 128, 0],
        [128, 128, 0],
        [0, 0, 128],
        [128, 0, 128],
        [0, 128, 128],
        [128, 128, 128],
        [64, 0, 0],
    ]
    assert palette()[255].tolist() == [224, 224, 192]
    assert len(np.unique(palette(), axis=0)) == 256


def test_lists_name_sequences_and_objects(exported: Callable[[str], Path]) -> None:
    folder = exported("davis")
    names = (folder / "ImageSets" / "2017" / "train.txt").read_text().split()
    assert len(names) == 2
    assert (folder / "ImageSets" / "2017" / "val.txt").read_text() == ""
    for name in names:
        assert len(list((folder / "JPEGImages" / "480p" / name).glob("*.jpg"))) == FRAMES
        shown = cv2.imread(str(folder / "JPEGImages" / "480p" / name / "00004.jpg"))
        assert shown is not None
        assert shown.shape[:2] == truths()[0].instance_map.shape
    listed = list(csv.DictReader((folder / "objects.csv").read_text().splitlines()))
    assert [(each["sequence"], each["number"], each["name"], each["class"]) for each in listed] == [
        (name, str(number), which, {"target": "car", "bus-1": "bus"}[which])
        for name in names
        for which, number in SHOWN.items()
    ]


def test_stored_jpegs_are_copied(tmp_path: Path) -> None:
    data = painted_data_set(tmp_path / "set", pictures="jpeg", seeds=(3, 5))
    export(data, "davis", tmp_path / "out")
    for seed, file in zip((3, 4), sorted((tmp_path / "out" / "JPEGImages").rglob("00002.jpg")), strict=True):
        stored = data.episode(seed).coded(2, "image_rgb")
        assert stored is not None
        assert file.read_bytes() == stored[1]
