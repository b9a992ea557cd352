"""Equal figures have equal hashes, whatever the order, the clock and the code; any other figure has another."""

from __future__ import annotations

import copy
import random
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from benchmarks.contract.rows import BlockKey, Row, block_key, read_blocks
from benchmarks.run.result_folder import append_block
from tests.benchmarks.fake_rows import rows_of
from tools.publishing import figures_hash
from tools.publishing.figures_hash import unrepeatable

Blocks = dict[BlockKey, list[Row]]


def hash_of_figures(blocks: Blocks) -> str:
    return figures_hash.hash_of_figures(blocks, ())


def differing(first: Blocks, second: Blocks) -> list[BlockKey]:
    return figures_hash.differing(first, second, ())


@pytest.fixture
def blocks() -> Blocks:
    made = [rows_of(tracker, seed) for tracker in ("sharp", "hold") for seed in (1, 2, 10)]
    return {block_key(rows[0]): rows for rows in made}


def changed(blocks: Blocks, metric: str, **columns: Any) -> Blocks:
    """Return the blocks with other columns in the first row of a metric."""
    copied = copy.deepcopy(blocks)
    row = next(row for rows in copied.values() for row in rows if row["metric"] == metric)
    row.update(columns)
    return copied


def test_the_order_of_workers_and_the_folder_do_not_count(blocks: Blocks, tmp_path: Path) -> None:
    shuffled = list(blocks.values())
    random.Random(1).shuffle(shuffled)
    for name, some in (("a", list(blocks.values())), ("b/c", shuffled)):
        (tmp_path / name).mkdir(parents=True)
        for rows in some:
            append_block(tmp_path / name, rows)
    first, second = (read_blocks(tmp_path / name) for name in ("a", "b/c"))
    assert hash_of_figures(first) == hash_of_figures(second) == hash_of_figures(dict(reversed(blocks.items())))


@pytest.mark.parametrize(
    "change",
    [
        lambda blocks: changed(blocks, "frames", seconds=99.0),
        lambda blocks: changed(blocks, "frames", editions={"numpy": "1"}),
        lambda blocks: changed(blocks, "frames_per_s", value=1.0),
    ],
)
def test_clock_and_code_do_not_count(blocks: Blocks, change: Callable[[Blocks], Blocks]) -> None:
    assert hash_of_figures(change(blocks)) == hash_of_figures(blocks)
    assert differing(change(blocks), blocks) == []


@pytest.mark.parametrize(
    "columns", [{"value": 0.123456}, {"value": None}, {"weight": 2.0}, {"frame_out": None}, {"role": "oracle"}]
)
def test_every_figure_counts(blocks: Blocks, columns: dict[str, Any]) -> None:
    other = changed(blocks, "recovered", **columns)
    assert hash_of_figures(other) != hash_of_figures(blocks)
    assert len(differing(other, blocks)) == 1


def test_a_block_or_a_row_that_is_missing_counts(blocks: Blocks) -> None:
    key = next(iter(blocks))
    without = {each: rows for each, rows in blocks.items() if each != key}
    assert hash_of_figures(without) != hash_of_figures(blocks)
    assert differing(without, blocks) == differing(blocks, without) == [key]
    assert differing({**blocks, key: blocks[key][1:]}, blocks) == [key]


def test_trackers_that_no_seed_makes_reproducible_are_left_out(blocks: Blocks) -> None:
    random_rows = {replace(key, tracker="opencv_mil"): rows for key, rows in blocks.items() if key.tracker == "hold"}
    more = {**blocks, **random_rows}
    assert unrepeatable(more) == {"opencv_mil"}
    assert figures_hash.hash_of_figures(more, ["opencv_mil"]) == hash_of_figures(blocks)
    assert figures_hash.differing(more, blocks, ["opencv_mil"]) == []
    # Only the list counts, not what is registered today.
    assert hash_of_figures(more) != hash_of_figures(blocks)
    assert differing(more, blocks) == sorted(random_rows)
