"""The Hub's layout, read by the rules of ``datasets``: the README's files of each split, features in their schema."""

from __future__ import annotations

import io
import json
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from benchmarks.data.exports import hub
from benchmarks.data.exports.exporter import export
from benchmarks.data.sets.data_set import DataSet
from tests.benchmarks.data.exports.painted_scene import FRAMES, cars_in_some, picture
from tests.benchmarks.data.exports.scoring import average_precision
from tests.benchmarks.data.exports.test_yolo import true_boxes
from tests.benchmarks.data.sets.hub_head import head_of

image = pytest.importorskip("PIL.Image")


def rows_of(out: Path) -> dict[str, list[dict[str, Any]]]:
    """Return the rows of each split, decoded by the features that the files tell."""
    (config,) = head_of(out / "README.md")["configs"]
    rows: dict[str, list[dict[str, Any]]] = {}
    for split in config["data_files"]:
        files = sorted(file for pattern in split["path"] for file in out.glob(pattern))
        for file in files:
            table = pq.read_table(file)
            features = json.loads(table.schema.metadata[b"huggingface"])["info"]["features"]
            assert list(features) == table.schema.names
            for name, feature in features.items():
                assert table.schema.field(name).type == arrow_type(feature), name
            found = [decoded(row, features) for row in table.to_pylist()]
            rows.setdefault(split["split"], []).extend(found)
    return rows


def arrow_type(feature: Any) -> pa.DataType:
    """Return the type that ``datasets`` has a feature stored as, ``get_nested_type`` there."""
    if "_type" not in feature:
        return pa.struct({name: arrow_type(each) for name, each in feature.items()})
    return {
        "Value": lambda: pa.type_for_alias(feature["dtype"]),
        "ClassLabel": pa.int64,
        "Sequence": lambda: pa.list_(arrow_type(feature["feature"])),
        "Image": lambda: pa.struct({"bytes": pa.binary(), "path": pa.string()}),
    }[feature["_type"]]()


def decoded(value: Any, feature: Any) -> Any:
    """Return a value with pictures opened and class numbers as names."""
    kind = feature.get("_type")
    if kind == "Image":
        return np.asarray(image.open(io.BytesIO(value["bytes"])))
    if kind == "ClassLabel":
        return feature["names"][value]
    if kind == "Sequence":
        return [decoded(each, feature["feature"]) for each in value]
    return value if kind else {name: decoded(value[name], each) for name, each in feature.items()}


def test_rows_are_the_pictures_and_their_objects(exported: Callable[[str], Path]) -> None:
    rows = rows_of(exported("hub"))["train"]
    assert [(row["seed"], row["frame"]) for row in rows] == [(seed, k) for seed in (3, 4) for k in range(FRAMES)]
    assert [row["image_id"] for row in rows] == [*range(1, 2 * FRAMES + 1)]
    found = []
    for row in rows:
        np.testing.assert_array_equal(row["image"], picture(row["seed"], row["frame"]))
        assert row["image"].shape[:2] == (row["height"], row["width"])
        objects = row["objects"]
        assert len({len(values) for values in objects.values()}) == 1
        for kind, (x, y, width, height), name in zip(
            objects["category"], objects["bbox"], objects["name"], strict=True
        ):
            assert name == {"bus": "bus-1", "car": "target", "kite": "kite-1"}[kind]
            box = np.array([x, y, x + width, y + height])
            name = f"painted-v1-quick-{row['seed']:06d}_{row['frame']:06d}"
            found.append((name, ("bus", "car", "kite").index(kind), box))
        assert objects["iscrowd"] == [0] * len(objects["id"])
    assert average_precision(true_boxes(), found) == pytest.approx(1.0)


def test_files_end_at_a_size_and_what_is_ignored_is_a_crowd(
    data: DataSet, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(hub, "SHARD_BYTES", 9_000)
    monkeypatch.setattr(hub, "ROWS_AT_ONCE", 2)
    few = export(data, "hub", tmp_path / "out", min_size_px=4)
    assert len(list((tmp_path / "out" / "data").iterdir())) > 3
    rows = rows_of(tmp_path / "out")["train"]
    assert len(rows) == 2 * FRAMES
    assert sum(sum(row["objects"]["iscrowd"]) for row in rows) == few > 0


def test_a_split_without_pictures_is_not_named(tmp_path: Path) -> None:
    """``load_dataset`` refuses a pattern without files; a set without any picture is no data set."""
    data = cars_in_some(tmp_path / "set")
    export(data, "hub", tmp_path / "out")
    (config,) = head_of(tmp_path / "out" / "README.md")["configs"]
    assert [each["split"] for each in config["data_files"]] == ["val"]
    assert list(rows_of(tmp_path / "out")) == ["val"]
    data.request = replace(data.request, classes=("person",))
    for name in ("hub", "coco", "kitti-object"):
        with pytest.raises(ValueError, match="data: expected pictures to write, got none, with classes person and neg"):
            export(data, name, tmp_path / "none")
    assert not (tmp_path / "none").exists()
