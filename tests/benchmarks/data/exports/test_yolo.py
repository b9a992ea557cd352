"""YOLO exports: labels against the instance map, and the split."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from benchmarks.data.exports.yolo import parts_of
from tests.benchmarks.data.exports.painted_scene import FRAMES, HEIGHT_PX, IDS, KINDS, WIDTH_PX, truths

yaml = pytest.importorskip("yaml")


def test_labels_are_boxes_around_what_is_seen(exported: Callable[[str], Path]) -> None:
    out = exported("yolo")
    described = yaml.safe_load((out / "data.yaml").read_text())
    assert described["names"] == {0: "bus", 1: "car", 2: "kite"}
    for part, seed in (("train", 3), ("val", 4)):
        pictures = sorted((out / described[part]).iterdir())
        assert [path.stem for path in pictures] == [
            f"painted-v1-quick-{seed:06d}_{frame:06d}" for frame in range(FRAMES)
        ]
        for picture, truth in zip(pictures, truths(), strict=True):
            # Readers exchange the last folder called images for labels.
            label = out / "labels" / part / f"{picture.stem}.txt"
            rows = [line.split() for line in label.read_text().splitlines()]
            shown = [k for k in range(3) if (truth.instance_map == IDS[k]).any()]
            assert sorted(described["names"][int(row[0])] for row in rows) == sorted(KINDS[k] for k in shown)
            for row in rows:
                mask = truth.instance_map == IDS[KINDS.index(described["names"][int(row[0])])]
                x, y, width, height = scaled(row)
                y_in, x_in = np.nonzero(mask)
                np.testing.assert_allclose([x - width / 2, x + width / 2], [x_in.min(), x_in.max() + 1], atol=1e-5)
                np.testing.assert_allclose([y - height / 2, y + height / 2], [y_in.min(), y_in.max() + 1], atol=1e-5)


def scaled(row: list[str]) -> np.ndarray:
    """Return x and y of the centre, width and height in pixels."""
    return np.array(row[1:], float) * [WIDTH_PX, HEIGHT_PX, WIDTH_PX, HEIGHT_PX]


def test_whole_episodes_are_validated_on() -> None:
    assert parts_of((3, 4)) == {3: "train", 4: "val"}
    assert list(parts_of(tuple(range(10))).values()) == ["train"] * 8 + ["val"] * 2
    with pytest.raises(ValueError, match=r"data: expected at least 2 episodes, .*, got 1"):
        parts_of((3,))
