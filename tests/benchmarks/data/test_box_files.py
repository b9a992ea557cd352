"""Files of boxes: what is read whatever the separators and line ends, and what is refused."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from benchmarks.cli.main import main
from benchmarks.data.box_files import read_boxes
from tests.benchmarks.data.written_sequences import write_otb

PLACE = st.floats(-1e5, 1e5, allow_nan=False).map(lambda number: round(number, 3))
LENGTH = st.floats(0.5, 1e4).map(lambda number: round(number, 3))
BOX = st.tuples(PLACE, PLACE, LENGTH, LENGTH)
LINE = st.tuples(
    st.none() | BOX, st.sampled_from([",", "\t", " ", ", ", "   ", " ,\t", ";"]), st.sampled_from(["", " "])
)


@given(
    st.lists(LINE, min_size=1, max_size=8),
    st.sampled_from(["\n", "\r\n"]),
    st.booleans(),
    st.sampled_from(["", "\n", "\r\n\r\n", "\n  \n"]),
    st.sampled_from(["NaN", "nan", "NAN"]),
)
def test_boxes_are_read_whatever_lies_between_them(
    tmp_path_factory: pytest.TempPathFactory,
    lines: list[tuple[tuple[float, ...] | None, str, str]],
    line_end: str,
    marked: bool,
    tail: str,
    nan: str,
) -> None:
    text = [pad + between.join([nan] * 4 if box is None else map(repr, box)) + pad for box, between, pad in lines]
    path = tmp_path_factory.mktemp("boxes") / "boxes.txt"
    path.write_bytes((b"\xef\xbb\xbf" if marked else b"") + (line_end.join(text) + tail).encode())
    expected = [[math.nan] * 4 if box is None else list(box) for box, _, _ in lines]
    np.testing.assert_array_equal(read_boxes(path)[1], np.array(expected))


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (b"\n \n", r"x/boxes.txt: expected lines of left,top,width,height .*, got an empty file"),
        (b"1,2,3,4\n1,2,3\n", r"x/boxes.txt, line 2: expected left,top,width,height .*, got '1,2,3'"),
        (b"1,2,3,4,5\n", r"line 1: expected left,top,width,height .*, got '1,2,3,4,5'"),
        (b"1,,3,4\n", r"line 1: expected left,top,width,height .*, got '1,,3,4'"),
        (b"1,2,3,car\n", r"line 1: expected left,top,width,height .*, got '1,2,3,car'"),
        (b"1,2,3,4\n1,2,-3,4\n", r"line 2: expected .* a width and height above 0, .* got 1,2,-3,4"),
        (b"-1,-1,-1,3\n", r"line 1: expected .* a width and height above 0, .* got -1,-1,-1,3"),
        (b"1,2,3,4\n5,6,7,8\nNaN,2,3,4\n", r"line 3: expected .* NaN,NaN,NaN,NaN, got nan,2,3,4"),
        (b"1,2,3,1e999\n", r"line 1: expected .* above 0, .* got 1,2,3,inf"),
        (b"1,7,5,5,9,9,1,1,1\n1.5,7,5,5,9,9,1,1,1\n", r"line 2: expected left,top,width,height .*, got '1.5,7,5,5"),
        (b"\xff\xfe1\x00", r"x/boxes.txt: expected text with numbers, got bytes that are none"),
    ],
)
def test_what_is_wrong_is_named_with_its_line(tmp_path: Path, content: bytes, message: str) -> None:
    path = tmp_path / "x" / "boxes.txt"
    path.parent.mkdir()
    path.write_bytes(content)
    with pytest.raises(ValueError, match=message):
        read_boxes(path)[1]


def test_lines_with_frame_and_id_are_refused_where_there_are_none(tmp_path: Path) -> None:
    path = tmp_path / "boxes.txt"
    path.write_text("1,7,5,5,9,9,1,1,1\n")
    assert read_boxes(path)[0].tolist() == [[1, 7]]
    with pytest.raises(ValueError, match=r"line 1: expected left,top,width,height, got '1,7,5,5,9,9,1,1,1'$"):
        read_boxes(path, keyed=False)


GONE = ["0,0,0,0", "5,5,0,0", "5,5,3,0", "-1,-1,-1,-1", "NaN,NaN,NaN,NaN", "inf inf inf inf", "-inf,Infinity,nan,inf"]


@pytest.mark.parametrize("line", [*GONE, "nan,nan,0,0", "", "  "])
def test_every_way_to_say_gone_is_no_box(tmp_path: Path, line: str) -> None:
    path = tmp_path / "boxes.txt"
    path.write_text(f"1 1 2 2\n{line}\n3 3 2 2\n")
    np.testing.assert_array_equal(read_boxes(path)[1], [[1, 1, 2, 2], [math.nan] * 4, [3, 3, 2, 2]])


@pytest.mark.parametrize(("tail", "frames", "count"), [("\n\n", 4, 4), ("\n\n\n\n", 4, 4), ("\n\n", 5, 2), ("", 2, 2)])
def test_empty_lines_at_the_end_are_frames_if_the_sequence_has_so_many(
    tmp_path: Path, tail: str, frames: int, count: int
) -> None:
    path = tmp_path / "boxes.txt"
    path.write_text(f"1 1 2 2\n3 3 2 2\n{tail}")
    boxes = read_boxes(path, frames)[1]
    assert np.isnan(boxes).all(axis=1).tolist() == [False, False, True, True][:count]


def test_a_broken_box_ends_a_bench_with_its_line(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    boxes = write_otb(tmp_path / "Car(1), again") / "groundtruth_rect.txt"
    lines = boxes.read_text().splitlines()
    boxes.write_text("\n".join([*lines[:2], "hello", *lines[3:]]))
    words = ["bench", "frame-out", "--real", str(boxes.parent), "--trackers", "hold", "--out", str(tmp_path / "out")]
    assert main(words) == 2
    told = capsys.readouterr().err
    assert told.splitlines()[-1].startswith("error: Car(1), again/groundtruth_rect.txt, line 3: expected left,top")
    assert told.endswith(", got 'hello'\n")
