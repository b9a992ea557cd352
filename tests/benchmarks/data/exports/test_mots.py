"""MOTS exports, read by pycocotools and by our reader."""

from __future__ import annotations

import csv
from collections.abc import Callable
from pathlib import Path

import cv2
import numpy as np
import pytest

from benchmarks.data.exports.exporter import export
from benchmarks.data.mots_text import read_mots
from tests.benchmarks.data.exports.painted_scene import (
    FRAMES,
    IDS,
    KINDS,
    PARKED_XYXY,
    painted_data_set,
    picture,
    truths,
)

coco = pytest.importorskip("pycocotools.mask")
NUMBERS = {"bus": 11, "car": 1, "kite": 13}
"""Classes: the scene lists bus, van and car as bus, car, car, and the kite."""


@pytest.mark.filterwarnings("ignore:__array__ implementation doesn't accept:DeprecationWarning")
@pytest.mark.parametrize("number", ["0000", "0001"])
def test_masks_are_the_pixels_of_the_instance_map(exported: Callable[[str], Path], number: str) -> None:
    rows = [line.split(" ") for line in (exported("mots") / "label_02" / f"{number}.txt").read_text().splitlines()]
    wanted = {
        (frame, NUMBERS[kind]): truth.instance_map == identity
        for frame, truth in enumerate(truths())
        for identity, kind in zip(IDS, KINDS, strict=True)
        if (truth.instance_map == identity).any()
    }
    found = {(int(row[0]), int(row[2])): row for row in rows}
    assert found.keys() == wanted.keys()
    for key, (_, identity, kind, height, width, counts) in found.items():
        assert int(identity) == 1000 * int(kind)
        mask = coco.decode({"size": [int(height), int(width)], "counts": counts.encode()})
        np.testing.assert_array_equal(mask, wanted[key])


def test_our_reader_reads_what_is_written(exported: Callable[[str], Path]) -> None:
    read = read_mots(exported("mots") / "label_02" / "0001.txt")
    for k, (frame, kind) in enumerate(zip(read.frame, read.kind, strict=True)):
        identity = IDS[KINDS.index(next(name for name, number in NUMBERS.items() if number == kind))]
        np.testing.assert_array_equal(read.mask(k), truths()[frame].instance_map == identity)
    assert len(read.frame) == sum(int((each.instance_map == identity).any()) for each in truths() for identity in IDS)


def test_sequences_and_pictures_are_where_kitti_has_them(exported: Callable[[str], Path]) -> None:
    folder = exported("mots")
    last = f"{FRAMES - 1:06d}"
    lines = (folder / "evaluate_mots.seqmap.training").read_text().splitlines()
    assert lines == [f"000{k} empty 000000 {last}" for k in (0, 1)]
    listed = list(csv.DictReader((folder / "sequences.csv").read_text().splitlines()))
    assert [(each["number"], each["seed"]) for each in listed] == [("0000", "3"), ("0001", "4")]
    for each in listed:
        for frame in range(FRAMES):
            shown = cv2.imread(str(folder / "training" / "image_02" / each["number"] / f"{frame:06d}.png"))
            assert shown is not None
            np.testing.assert_array_equal(shown[..., ::-1], picture(int(each["seed"]), frame))


def test_what_stands_about_has_rows(tmp_path: Path) -> None:
    export(painted_data_set(tmp_path / "set", preset="parked"), "mots", tmp_path / "out")
    read = read_mots(tmp_path / "out" / "label_02" / "0000.txt")
    x_min, y_min, x_max, y_max = PARKED_XYXY.astype(int)
    of_parked = [k for k in range(len(read.frame)) if read.mask(k)[y_min, x_min]]
    assert read.frame[of_parked].tolist() == list(range(FRAMES))
    assert len(set(read.identity[of_parked])) == 1
    assert {int(read.mask(k).sum()) for k in of_parked} == {(x_max - x_min) * (y_max - y_min)}
    moving = {int(identity) for identity in read.identity[read.kind == 1]} - {int(read.identity[of_parked[0]])}
    assert moving == {1000}
