"""VOT and OTB exports: boxes, and tags where there are none."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from benchmarks.data.exports.exporter import export
from tests.benchmarks.data.exports.painted_scene import FRAMES, painted_data_set, truths


def tags(path: Path) -> list[bool]:
    """Return a tag file as the VOT toolkit reads it."""
    return [line.strip() == "1" for line in path.read_text().splitlines()]


@pytest.mark.parametrize(
    ("name", "boxes", "tag", "first"),
    [("vot", "groundtruth.txt", "{}.tag", 0.0), ("otb", "groundtruth_rect.txt", "{}.txt", 1.0)],
)
def test_rows_are_the_target(exported: Callable[[str], Path], name: str, boxes: str, tag: str, first: float) -> None:
    names = (exported(name) / "list.txt").read_text().split()
    assert names == ["painted-v1-quick-000003", "painted-v1-quick-000004"]
    sequence = exported(name) / names[0]
    read = np.loadtxt(sequence / boxes, delimiter=",")
    out, occluded = (tags(sequence / tag.format(each)) for each in ("out_of_view", "occlusion"))
    assert len(read) == len(out) == len(occluded) == FRAMES
    for k, truth in enumerate(truths()):
        target = truth.index_of("target")
        x_min, y_min, x_max, y_max = truth.box_xyxy[target]
        if truth.visible_fraction[target] > 0:
            np.testing.assert_allclose(read[k], [x_min + first, y_min + first, x_max - x_min, y_max - y_min])
        else:
            assert np.isnan(read[k]).all()
        assert out[k] == (truth.state[target] == "out")
        assert occluded[k] == (truth.state[target] == "occluded")
    assert any(out)
    assert any(occluded)
    # Hidden wholly, but inside: no box, yet not out of view.
    assert any(np.isnan(row[0]) and hidden for row, hidden in zip(read, occluded, strict=True))


def test_vot_pictures_lie_where_the_properties_say(exported: Callable[[str], Path]) -> None:
    sequence = exported("vot") / "painted-v1-quick-000004"
    properties = dict(line.split("=") for line in (sequence / "sequence").read_text().splitlines())
    assert (int(properties["width"]), int(properties["height"]), int(properties["length"])) == (40, 32, FRAMES)
    assert (int(properties["fps"]), float(properties["exact_fps"])) == (8, 7.5)
    assert all((sequence / (properties["channels.color"] % k)).is_file() for k in range(1, FRAMES + 1))


def test_otb_pictures_are_counted_from_one(exported: Callable[[str], Path]) -> None:
    pictures = sorted(path.name for path in (exported("otb") / "painted-v1-quick-000004" / "img").iterdir())
    assert pictures == [f"{k:04d}.png" for k in range(1, FRAMES + 1)]


@pytest.mark.parametrize("name", ["vot", "otb"])
def test_a_sequence_cannot_begin_without_its_target(tmp_path: Path, name: str) -> None:
    data = painted_data_set(tmp_path / "set", "late", (3, 4))
    with pytest.raises(ValueError, match="data: expected a target 'target' in the first picture of seed 3, got none"):
        export(data, name, tmp_path / "out")
    assert [path.name for path in tmp_path.iterdir()] == ["set"]
