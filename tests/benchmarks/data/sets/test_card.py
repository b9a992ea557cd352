"""What the card tells of a set, what it says to catalogues, and that all READMEs say where axes and pixels begin."""

from __future__ import annotations

import shutil
from dataclasses import replace
from pathlib import Path

import numpy as np
import pyarrow.parquet as pq
import pytest

from benchmarks.data.exports.exporter import sequence_name
from benchmarks.data.sets.card import axes_text, card_text, hub_head, table_configs
from benchmarks.data.sets.data_set import DataSet
from sim.optics import look_down_pose, project
from tests.benchmarks.data.exports.painted_scene import IDS, KINDS, painted_data_set, truths
from tests.benchmarks.data.sets.hand_made import write_set
from tests.benchmarks.data.sets.hub_head import head_of
from tests.benchmarks.data.sets.small import made, tiny
from trackers.types import CameraModel


def test_the_card_begins_with_what_the_hub_reads(data: DataSet) -> None:
    head = head_of(Path(data.root) / "README.md")
    assert head["license"] == "mit"
    assert head["task_categories"] == ["object-detection", "image-segmentation", "depth-estimation"]
    assert {"synthetic", "fake-town-v1"} <= set(head["tags"])
    assert head["size_categories"] == ["n<1K"]
    assert [config["config_name"] for config in head["configs"]] == ["frames", "objects", "standing"]
    assert [config.get("default", False) for config in head["configs"]] == [True, False, False]
    for config in head["configs"]:
        (split,) = config["data_files"]
        assert split["split"] == "train"
        found = [path for pattern in split["path"] for path in Path(data.root).glob(pattern)]
        assert len(found) == len(data.seeds)
        rows = sum(pq.read_table(path).num_rows for path in found)
        assert rows == data.table(config["config_name"]).num_rows


@pytest.mark.parametrize("splits", [{}, {"train": 0.5, "val": 0.5}])
def test_the_tables_of_each_split_are_found(tmp_path: Path, splits: dict[str, float]) -> None:
    asked = tiny(seeds=(9_996, 10_001), frame_count=2, channels=("image_rgb",), splits=splits)
    data = made(asked, tmp_path / "set")
    assert set(data.splits) == {*(splits or ["train"]), "test"}
    for table, patterns_of in table_configs(data).items():
        assert set(patterns_of) == set(data.splits), table
        for split, patterns in patterns_of.items():
            found = {path.parent.name for pattern in patterns for path in tmp_path.glob(f"set/{pattern}")}
            assert found == {f"{seed:06d}" for seed in data.splits[split]}, table


@pytest.mark.parametrize(
    ("frames", "words"),
    [(999, "n<1K"), (1000, "n<1K"), (1001, "1K<n<10K"), (70_000, "10K<n<100K"), (10**7, "1M<n<10M")],
)
def test_sizes_are_powers_of_ten(data: DataSet, monkeypatch: pytest.MonkeyPatch, frames: int, words: str) -> None:
    monkeypatch.setattr(type(data), "__len__", lambda self: frames)
    assert f'size_categories:\n- "{words}"\n' in hub_head(data, {}, ())


def test_the_card_says_where_axes_and_pixels_begin(data: DataSet) -> None:
    assert axes_text(data.request.channels) in (Path(data.root) / "README.md").read_text()
    # A point straight below a camera that looks down is in the middle, and one to its right is to the right.
    camera = CameraModel(10, 8, 10.0)
    pose = look_down_pose(np.array([0.0, 0.0, 20.0]), 0.0, 0.0, 0.0)
    middle, right, below = (pose @ [*point, 1.0] for point in ((0, 0, 20), (2, 0, 20), (0, 2, 20)))
    np.testing.assert_allclose(middle, [0, 0, 0, 1], atol=1e-9)
    pixels, _ = project(camera, pose, np.array([middle[:3], right[:3], below[:3]]))
    np.testing.assert_allclose(pixels, [[5, 4], [6, 4], [5, 5]], atol=1e-9)


def test_states_and_frame_outs_are_told_by_group_and_no_pixel_is_read(tmp_path: Path) -> None:
    """The other car is first absent, then out: it has not left the picture until frame 20."""
    data = write_set(tmp_path)
    for shard in tmp_path.glob("episodes/*/pixels-*.tar"):
        shard.unlink()
    text = card_text(data)
    assert "2 episodes (seeds 0–1), 60 frames of 160 x 120 pixels at 15 a second" in text
    assert "\n\nMissing: seeds 2.\n\n" in text
    assert "| target | 83.3 | 0.0 | 0.0 | 16.7 | 0.0 | 2 | 0 | 5, 5 |" in text
    assert "| other objects | 33.3 | 0.0 | 0.0 | 50.0 | 16.7 | 2 | 2 | 10, 10 |" in text
    with pytest.raises(ValueError, match=r"pixels-00000\.tar"):
        data[0]


def test_what_is_seen_is_counted_by_kind_and_group(tmp_path: Path) -> None:
    data = painted_data_set(tmp_path / "set", "parked", without="flow_px")
    bus, car, kite = (
        2 * sum(bool((truth.instance_map == number).any()) for truth in truths("parked"))
        for _, number in sorted(zip(KINDS, IDS, strict=True))
    )
    lines = (f"bus | 0 | {bus} | 0", f"car | {car} | 0 | 0", f"kite | 0 | {kite} | 0", f"van | 0 | 0 | {len(data)}")
    assert "".join(f"| {line} |\n" for line in lines) in card_text(data)
    assert "| `standing_box_xyxy` | standing | px |" in card_text(data)


def test_no_two_data_sets_have_a_sequence_of_one_name(tmp_path: Path) -> None:
    presets = ("tiny", "tiny[frame_count=2]", "tiny[rate_hz=7.5]", "tiny[rate_hz=75]")
    changes = (*({"preset": preset} for preset in presets), {"preset": "tiny", "renderer": "pybullet"})
    names = []
    for k, change in enumerate(changes):
        (tmp_path / str(k)).mkdir()
        (tmp_path / str(k) / "dataset.json").write_text(replace(tiny(), **change).as_json())
        names.append(sequence_name(DataSet(str(tmp_path / str(k))), 3))
        shutil.rmtree(tmp_path / str(k))
    assert names[0] == "fake-town-v1-tiny-000003"
    assert len(set(names)) == len(names)
    assert not any("." in name for name in names)
