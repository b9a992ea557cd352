from __future__ import annotations

import errno
import json
import os
import resource
import signal
from pathlib import Path
from typing import Any

import pytest

from benchmarks.contract.rows import read, read_blocks, read_rows, rounded
from benchmarks.run.result_folder import append_block, tidy


def block(tracker: str, seed: int, values: tuple[float, ...] = (1.0, 2.0)) -> list[dict[str, Any]]:
    """Return a whole block: some metrics, then ``frames``."""
    heading: dict[str, Any] = {
        "suite": "frame-out",
        "scenario": "s-v1",
        "preset": "p",
        "renderer": "raster",
        "controller": None,
    }
    heading |= {"tracker": tracker, "seed": seed}
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
    assert tidy(tmp_path) is None
    assert [path.name for path in tmp_path.iterdir()] == ["records.jsonl"]
    assert [row["tracker"] for row in read_rows(tmp_path)] == ["a"] * 3 + ["b"] * 3


def test_what_is_replaced_is_moved_beside_and_said(tmp_path: Path) -> None:
    """An earlier version, an outdated block and a torn line are kept in other files, none twice."""
    append_block(tmp_path, block("a", 1, (1.0,)))
    append_block(tmp_path, block("a", 1, (5.0,)))
    append_block(tmp_path, block("b", 1, (7.0,)))
    with (tmp_path / "records.jsonl").open("a") as file:
        file.write('{"suite": "fra')
    (outdated,) = [key for key in read_blocks(tmp_path) if key.tracker == "b"]
    told = tidy(tmp_path, {outdated})
    aside = tmp_path / "records.outdated-1.jsonl"
    assert told == f"5 rows that are outdated, cut off or broken were moved to {aside}"
    assert [row["value"] for row in read_rows(tmp_path)] == [5.0, 300.0]
    lines = aside.read_text().splitlines()
    assert lines[2] == '{"suite": "fra'
    assert [json.loads(line)["value"] for line in lines[:2] + lines[3:]] == [1.0, 300.0, 7.0, 300.0]
    append_block(tmp_path, block("a", 1, (6.0,)))
    assert str(tmp_path / "records.outdated-2.jsonl") in str(tidy(tmp_path))
    assert aside.read_text().splitlines() == lines


@pytest.mark.parametrize("broken", [b"\xff\xfe{}", b'{"metric": "frames"}', b'{"metric": "m0", "seed": "1"}', b"[]"])
def test_lines_that_are_no_rows_are_counted(tmp_path: Path, broken: bytes) -> None:
    append_block(tmp_path, block("a", 1))
    with (tmp_path / "records.jsonl").open("ab") as file:
        file.write(broken + b"\n")
    append_block(tmp_path, block("a", 2))
    contents = read(tmp_path)
    assert [key.seed for key in contents.blocks] == [1, 2]
    assert (contents.broken, contents.replaced) == ([broken], [])


def test_a_block_that_does_not_fit_leaves_what_was_there(tmp_path: Path) -> None:
    """The system itself stops the write half way, as on a full disk."""
    append_block(tmp_path, block("a", 1))
    file = tmp_path / "records.jsonl"
    before = file.read_bytes()
    limits, handler = resource.getrlimit(resource.RLIMIT_FSIZE), signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
    resource.setrlimit(resource.RLIMIT_FSIZE, (len(before) + 50, limits[1]))
    try:
        with pytest.raises(OSError, match=r"records\.jsonl") as caught:
            append_block(tmp_path, block("a", 2))
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, limits)
        signal.signal(signal.SIGXFSZ, handler)
    assert caught.value.errno == errno.EFBIG
    assert file.read_bytes() == before
    append_block(tmp_path, block("a", 2))
    assert [key.seed for key in read_blocks(tmp_path)] == [1, 2]


def test_a_full_disk_leaves_the_tidied_file_as_it_was(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    append_block(tmp_path, block("b", 1))
    append_block(tmp_path, block("a", 1))
    before = (tmp_path / "records.jsonl").read_bytes()

    def full(descriptor: int) -> None:
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr(os, "fsync", full)
    with pytest.raises(OSError, match=r"No space left on device: .*records\.jsonl"):
        tidy(tmp_path)
    assert [path.name for path in tmp_path.iterdir()] == ["records.jsonl"]
    assert (tmp_path / "records.jsonl").read_bytes() == before


def test_a_folder_without_records_is_named(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match=r"directory: expected one that holds records.jsonl, got"):
        read_rows(tmp_path)


def test_values_are_short_and_finite() -> None:
    assert rounded(1 / 3) == 0.333333
    assert rounded(float("nan")) is None
    assert rounded([1e-9 / 3, float("inf")]) == [3.33333e-10, None]
    assert rounded(None) is None
