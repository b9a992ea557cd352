from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from benchmarks.run.records import append_block, block_key, read_blocks, read_rows, rewrite, rounded


def block(tracker: str, seed: int, values: tuple[float, ...] = (1.0, 2.0)) -> list[dict[str, Any]]:
    """Return a whole block: some metrics, then ``frames``."""
    heading = {
        "suite": "frame-out",
        "scenario": "s-v1",
        "preset": "p",
        "renderer": "raster",
        "controller": None,
        "tracker": tracker,
        "seed": seed,
    }
    rows = [{**heading, "metric": f"m{k}", "value": value} for k, value in enumerate(values)]
    return [*rows, {**heading, "metric": "frames", "value": 300.0}]


def test_what_is_appended_is_read_in_canonical_order(tmp_path: Path) -> None:
    for tracker, seed in (("b", 2), ("a", 10), ("a", 9)):
        append_block(tmp_path, block(tracker, seed))
    rows = read_rows(tmp_path)
    assert [(row["tracker"], row["seed"]) for row in rows[::3]] == [("a", 9), ("a", 10), ("b", 2)]


@pytest.mark.parametrize("cut", [2, 20, 150])
def test_a_torn_block_is_dropped_and_does_not_swallow_the_next(tmp_path: Path, cut: int) -> None:
    append_block(tmp_path, block("a", 1))
    append_block(tmp_path, block("a", 2))
    file = tmp_path / "records.jsonl"
    file.write_bytes(file.read_bytes()[:-cut])
    assert [key.seed for key in read_blocks(tmp_path)] == [1]
    append_block(tmp_path, block("a", 3))
    append_block(tmp_path, block("a", 2))
    assert [key.seed for key in read_blocks(tmp_path)] == [1, 2, 3]
    assert len(read_rows(tmp_path)) == 9


def test_a_block_without_its_last_row_is_refused_and_not_read(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match="ends with the metric 'frames'"):
        append_block(tmp_path, block("a", 1)[:-1])
    append_block(tmp_path, block("a", 1))
    lines = (tmp_path / "records.jsonl").read_text().splitlines(keepends=True)
    (tmp_path / "records.jsonl").write_text("".join(lines[:-1]))
    assert read_blocks(tmp_path) == {}


def test_the_later_making_counts(tmp_path: Path) -> None:
    append_block(tmp_path, block("a", 1, (1.0,)))
    append_block(tmp_path, block("a", 1, (5.0,)))
    assert [row["value"] for row in read_rows(tmp_path)] == [5.0, 300.0]


def test_rewriting_leaves_one_whole_file(tmp_path: Path) -> None:
    append_block(tmp_path, block("b", 1))
    append_block(tmp_path, block("a", 1))
    rewrite(tmp_path, read_blocks(tmp_path).values())
    assert [path.name for path in tmp_path.iterdir()] == ["records.jsonl"]
    assert [row["tracker"] for row in read_rows(tmp_path)] == ["a"] * 3 + ["b"] * 3


def test_a_folder_without_records_is_named(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match=r"directory: expected one that holds records.jsonl, got"):
        read_rows(tmp_path)


def test_a_set_path_is_not_a_controller() -> None:
    assert block_key(block("a", 1)[0]).controller == ""


def test_values_are_short_and_finite() -> None:
    assert rounded(1 / 3) == 0.333333
    assert rounded(float("nan")) is None
    assert rounded([1e-9 / 3, float("inf")]) == [3.33333e-10, None]
    assert rounded(None) is None
