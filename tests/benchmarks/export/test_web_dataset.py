"""WebDataset exports, read by webdataset."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from benchmarks.data_sets.data_set import DataSet
from benchmarks.export import web_dataset
from benchmarks.export.objects import Labels
from tests.benchmarks.export.painted_scene import FRAMES, NAMES, picture, truths

# It leaves closing shards to the garbage collector.
pytestmark = pytest.mark.filterwarnings("ignore:unclosed file:ResourceWarning")
wds = pytest.importorskip("webdataset")


def read(out: Path) -> list[dict[str, Any]]:
    """Return all samples."""
    shards = sorted(str(path) for path in out.glob("frames-*.tar"))
    return list(wds.WebDataset(shards, shardshuffle=False, empty_check=False).decode("rgb8"))


def test_samples_are_the_frames(exported: Callable[[str], Path]) -> None:
    samples = read(exported("webdataset"))
    assert [each["__key__"] for each in samples] == [f"{s:06d}_{k:06d}" for s in (3, 4) for k in range(FRAMES)]
    for each in samples:
        seed, frame = map(int, each["__key__"].split("_"))
        truth = truths()[frame]
        np.testing.assert_array_equal(each["png"], picture(seed, frame))
        assert each["right.png"].shape == each["png"].shape
        for name in ("instance_map", "depth_m", "flow_px"):
            np.testing.assert_array_equal(each[f"{name}.npy"], getattr(truth, name))
        known = each["json"]
        assert (known["seed"], known["frame"], known["gain"]) == (seed, frame, 1.0)
        assert known["observed"]["camera"]["baseline_m"] == 0.5
        assert [each["names"] for each in known["objects"]] == list(NAMES)
        for k, entry in enumerate(known["objects"]):
            box = [np.nan if number is None else number for number in entry["box_xyxy"]]
            np.testing.assert_array_equal(box, truth.box_xyxy[k])
            np.testing.assert_array_equal(entry["T_world_object"], truth.T_world_object[k])
            assert entry["state"] == truth.state[k]
            assert (entry["visible_box_xyxy"][0] is None) == (truth.visible_fraction[k] == 0)


def test_no_sample_is_cut_by_the_end_of_a_shard(data: DataSet, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(web_dataset, "SHARD_BYTES", 60_000)
    web_dataset.WEB_DATASET.write(data, tmp_path, Labels(data))
    assert len(list(tmp_path.iterdir())) > 2
    samples = read(tmp_path)
    assert len(samples) == 2 * FRAMES
    assert all({"json", "png", "flow_px.npy"} <= set(each) for each in samples)
