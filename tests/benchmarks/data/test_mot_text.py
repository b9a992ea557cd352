"""Rows of MOT Challenge: what is written is read, and TrackEval reads the same."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from benchmarks.data.mot_text import read_mot

_ROW = "1,4,11,21,5,6,1,-1,-1,-1\n"
_NUMBER = st.floats(-1e4, 1e4)


@settings(deadline=None)
@given(
    rows=st.dictionaries(
        st.tuples(st.integers(1, 50), st.integers(0, 9)),
        st.tuples(_NUMBER, _NUMBER, st.floats(0, 1e4), st.floats(0, 1e4)),
        max_size=20,
    ),
    between=st.sampled_from([",", ", ", "\t", " ", ";"]),
    ends=st.sampled_from(["\n", "\r\n", "\n\n"]),
)
def test_what_is_written_is_read(tmp_path_factory: pytest.TempPathFactory, rows: dict, between: str, ends: str) -> None:
    path = tmp_path_factory.mktemp("mot") / "a.txt"
    path.write_bytes("".join(between.join(map(repr, (*key, *box))) + ends for key, box in rows.items()).encode())
    read = read_mot(path)
    assert list(zip(read.frame.tolist(), read.identity.tolist(), strict=True)) == list(rows)
    boxes = np.array(list(rows.values())).reshape(-1, 4)
    np.testing.assert_allclose(read.box_xyxy[:, :2], boxes[:, :2] - 1)
    np.testing.assert_allclose(read.box_xyxy[:, 2:], boxes[:, :2] - 1 + boxes[:, 2:])
    assert np.isnan(read.confidence).all()


def test_columns_of_truth(tmp_path: Path) -> None:
    (tmp_path / "gt.txt").write_text("2,7,1,1,10,20,0,3,0.25\n")
    read = read_mot(tmp_path / "gt.txt")
    assert (read.frame[0], read.identity[0], read.confidence[0], read.line[0]) == (2, 7, 0, 1)
    np.testing.assert_array_equal(read.box_xyxy, [[0, 0, 10, 20]])
    np.testing.assert_array_equal(read.further, [[3, 0.25, np.nan]])


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (f"{_ROW}1,2,3\n", "line 2: expected frame,id,left,top,width,height"),
        (f"{_ROW}frame,id,a,b,c,d\n", "line 2: expected frame,id"),
        (f"\n\n{_ROW}{_ROW}", "line 4: expected each id once in a frame, got frame,id 1,4 again"),
        ("0,4,11,21,5,6\n", "line 1: expected a whole number >= 1 as frame, got 0"),
        ("1.5,4,11,21,5,6\n", "line 1: expected a whole number >= 1 as frame, got 1.5"),
        ("1,-1,11,21,5,6\n", "line 1: expected a whole number >= 0 as id, got -1"),
        ("1,1,11,21,-5,6\n", "width and height >= 0, got 11,21,-5,6"),
        ("1,1,nan,21,5,6\n", "expected finite left,top"),
        ("1,1,1,1,1,1,1,1,1,1,1\n", "up to four more numbers"),
    ],
)
def test_a_wrong_row_is_named(tmp_path: Path, text: str, message: str) -> None:
    (tmp_path / "a.txt").write_text(text)
    with pytest.raises(ValueError, match=r"a\.txt, line") as error:
        read_mot(tmp_path / "a.txt")
    assert message in str(error.value)


def test_bytes_that_are_no_text(tmp_path: Path) -> None:
    (tmp_path / "a.txt").write_bytes(b"\xff\xfe\x00\x80")
    with pytest.raises(ValueError, match=r"a\.txt: expected text with numbers"):
        read_mot(tmp_path / "a.txt")
