"""WebDataset exports, read by webdataset."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from pathlib import Path
from types import UnionType
from typing import Any, Literal, Union, get_args, get_origin, get_type_hints

import numpy as np
import pyarrow as pa
import pytest

from benchmarks.data.exports import web_dataset
from benchmarks.data.exports.exporter import export
from benchmarks.data.exports.labels import Labels
from benchmarks.data.exports.web_dataset import NO_NUMBER
from benchmarks.data.sets.data_set import DataSet
from scenarios import catalog
from tests.benchmarks.data.exports.painted_scene import FRAMES, NAMES, painted_data_set, picture, truths
from tests.benchmarks.data.sets.hand_made import write_set
from tests.benchmarks.data.sets.hub_head import head_of
from trackers.types import Observation

# It leaves closing shards to the garbage collector.
pytestmark = pytest.mark.filterwarnings("ignore:unclosed file:ResourceWarning")
wds = pytest.importorskip("webdataset")


def read(out: Path, split: str = "train") -> list[dict[str, Any]]:
    """Return all samples of a split."""
    shards = sorted(str(path) for path in out.glob(f"*-{split}-*.tar"))
    return list(wds.WebDataset(shards, shardshuffle=False, empty_check=False).decode("rgb8"))


def test_samples_are_the_frames(exported: Callable[[str], Path]) -> None:
    samples = read(exported("webdataset"))
    keys = [f"painted-v1-quick-{seed:06d}_{frame:06d}" for seed in (3, 4) for frame in range(FRAMES)]
    assert [each["__key__"] for each in samples] == keys
    for each in samples:
        seed, frame = map(int, each["__key__"].rpartition("-")[2].split("_"))
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
            box = [np.nan if number == NO_NUMBER else number for number in entry["box_xyxy"]]
            np.testing.assert_array_equal(box, truth.box_xyxy[k])
            np.testing.assert_array_equal(entry["T_world_object"], truth.T_world_object[k])
            assert entry["state"] == truth.state[k]
            assert (entry["visible_box_xyxy"][0] == NO_NUMBER) == (truth.visible_fraction[k] == 0)


def test_no_sample_is_cut_by_the_end_of_a_shard(data: DataSet, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(web_dataset, "SHARD_BYTES", 60_000)
    web_dataset.WebDataset(data, tmp_path, Labels(data)).write()
    assert len(list(tmp_path.iterdir())) > 2
    samples = read(tmp_path)
    assert len(samples) == 2 * FRAMES
    assert all({"json", "png", "flow_px.npy"} <= set(each) for each in samples)


def types_of(sample: dict[str, Any]) -> dict[str, Any]:
    """Return what a reader that infers types takes each file of a sample for, as the library ``datasets`` does it."""
    maps = {name: (value.dtype, value.ndim) for name, value in sample.items() if isinstance(value, np.ndarray)}
    return maps | {"json": schema_of(sample["json"])}


@pytest.mark.parametrize("preset", ["quick", "single", "late", "lossy", "parked"])
def test_each_field_has_one_type_in_all_samples(tmp_path: Path, preset: str) -> None:
    """A field that was null in the first samples and text later ended ``load_dataset`` on pairs of pictures."""
    export(painted_data_set(tmp_path / "set", preset), "webdataset", tmp_path / "out")
    first, *others = (types_of(each) for each in read(tmp_path / "out"))
    assert "null" not in str(first["json"])
    assert all(each == first for each in others)


@pytest.mark.parametrize("name", [e.id for e in catalog.entries() if e.place.startswith("scenarios.")])
def test_nothing_is_null_in_any_scene(name: str) -> None:
    """What may be missing in a scene's frames has the type that it has where it is given."""
    optional = {
        field: hint
        for field, hint in (get_type_hints(catalog.scenario(name).truth) | get_type_hints(Observation)).items()
        if type(None) in get_args(hint) and field not in ("image_rgb", "right_rgb", "counts", "steered")
    }
    assert {"settings", "ego"} <= set(optional)
    for field, hint in optional.items():
        (of_what,) = (each for each in get_args(hint) if each is not type(None))
        missing, given = (web_dataset._typed(value, hint) for value in (None, example(of_what)))
        assert schema_of({field: missing}) == schema_of({field: given})


def schema_of(row: dict[str, Any]) -> pa.Schema:
    """Return what a reader that infers types takes a row for."""
    return pa.Table.from_pylist([row]).schema


def example(hint: Any, name: str = "") -> Any:
    """Return a value of a type; all numbers are 1."""
    if get_origin(hint) is Literal:
        return get_args(hint)[0]
    if dataclasses.is_dataclass(hint):
        return hint(**{field: example(each, field) for field, each in get_type_hints(hint).items()})
    if get_origin(hint) is np.ndarray:
        return np.ones((4, 4) if name.startswith("T_") else 1)
    if get_origin(hint) in (Union, UnionType):
        return example(get_args(hint)[0], name)
    return hint(1)


def test_counts_and_lost_pictures_are_read_as_they_are(tmp_path: Path) -> None:
    """As PNG of 16 bits, counts became 255 all over in the usual decoders of pictures."""
    export(write_set(tmp_path / "set", frames=4), "webdataset", tmp_path / "out", allow_incomplete=True)
    shards = sorted(str(path) for path in (tmp_path / "out").glob("*.tar"))
    for decoder in ("rgb8", "pil", "torchrgb"):
        if decoder == "torchrgb":
            pytest.importorskip("torch")
        samples = list(wds.WebDataset(shards, shardshuffle=False, empty_check=False).decode(decoder))
        for each in samples:
            frame = each["json"]["frame"]
            assert each["counts.npy"].dtype == np.uint16
            assert (each["counts.npy"] == 3000 + frame).all()
            assert each["json"]["lost"] == {"image_rgb": False, "right_rgb": frame % 3 == 0}
            assert np.asarray(each["right.png"]).any() == (frame % 3 != 0)
    first, *others = (types_of(each) for each in read(tmp_path / "out"))
    assert all(each == first for each in others)


def test_shards_of_both_splits_are_apart(tmp_path: Path) -> None:
    export(painted_data_set(tmp_path / "set", "single", (9_999, 10_001)), "webdataset", tmp_path / "out")
    names = {path.name for path in (tmp_path / "out").glob("*.tar")}
    assert names == {"painted-v1-single-train-00000.tar", "painted-v1-single-test-00000.tar"}
    (config,) = head_of(tmp_path / "out" / "README.md")["configs"]
    for each in config["data_files"]:
        (pattern,) = each["path"]
        (shard,) = (tmp_path / "out").glob(pattern)
        assert shard.name == f"painted-v1-single-{each['split']}-00000.tar"
