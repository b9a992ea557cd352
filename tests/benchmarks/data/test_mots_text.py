"""Text of MOTS: what is written by its rules is read, and what is wrong with a row is said."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import array_shapes, arrays

from benchmarks.data.mots_text import read_mots, runs_fill
from tests.benchmarks.data.layouts.written_layouts import counts

MASK = np.zeros((6, 5), np.uint8)
MASK[1:4, 2:4] = 1
COUNTS = counts(MASK)


def written(folder: Path, *lines: str) -> Path:
    path = folder / "0000.txt"
    path.write_text("\n".join(lines) + "\n")
    return path


def test_rows_are_read(tmp_path: Path) -> None:
    path = written(tmp_path, f"0 1000 1 6 5 {COUNTS}", "", f"0 2000 2 6 5 {COUNTS}", f"3 1000 1 6 5 {counts(0 * MASK)}")
    rows = read_mots(path)
    assert rows.frame.tolist() == [0, 0, 3]
    assert rows.identity.tolist() == [1000, 2000, 1000]
    assert rows.kind.tolist() == [1, 2, 1]
    assert rows.line.tolist() == [1, 3, 4]
    np.testing.assert_array_equal(rows.mask(1), MASK)
    assert not rows.mask(2).any()


def test_an_empty_file_has_no_rows(tmp_path: Path) -> None:
    assert len(read_mots(written(tmp_path)).frame) == 0


@given(arrays(bool, array_shapes(min_dims=2, max_dims=2, max_side=40)), st.data())
def test_counts_are_known_to_fill_their_picture_and_no_other(mask: Any, data: st.DataObject) -> None:
    runs = counts(mask)
    assert runs_fill(runs, mask.size)
    assert not runs_fill(runs, mask.size + 1)
    assert not runs_fill(runs[:-1], mask.size)
    place = data.draw(st.integers(0, len(runs) - 1))
    assert not runs_fill(runs[:place] + "\x7f" + runs[place + 1 :], mask.size)


@pytest.mark.parametrize(
    "row",
    [
        f"0 1 1 6 4 {COUNTS}",
        f"0 1 1 7 5 {COUNTS}",
        "0 1 1 6 5 hello",
        "0 1 1 6 5 0000",
        "0 1 1 6 5",
        f"0 -1 1 6 5 {COUNTS}",
        f"0 1.5 1 6 5 {COUNTS}",
        f"0 1 1 999999999 999999999 {COUNTS}",
        f"0,1,1,6,5,{COUNTS}",
    ],
)
def test_a_row_that_is_none_is_named(tmp_path: Path, row: str) -> None:
    path = written(tmp_path, f"0 7 1 6 5 {COUNTS}", row)
    with pytest.raises(ValueError, match=r"0000.txt, line 2: expected frame identity class .*, got"):
        read_mots(path)


def test_an_identity_twice_in_a_frame_and_bytes_are_named(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match="line 2: expected each identity once in a frame, got 7 in frame 0 again"):
        read_mots(written(tmp_path, *[f"0 7 1 6 5 {COUNTS}"] * 2))
    (tmp_path / "0000.txt").write_bytes(b"\xff\xfe\x00")
    with pytest.raises(ValueError, match="expected text with numbers"):
        read_mots(tmp_path / "0000.txt")
