"""What answers look like as files of predictions, and which are refused."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from benchmarks.data.mot_text import mot_rows
from benchmarks.data.predictions.writing import _first_numbers, _regions, write_predictions
from tests.benchmarks.data.layouts.written_layouts import write_mot
from tests.benchmarks.data.written_sequences import write_lines
from trackers.regions import Mask, Rectangle, Special, estimate_of, read_region
from trackers.types import Estimate, Track

NONE = Estimate(np.full(2, np.nan))


def test_regions_are_masks_boxes_places_and_silence() -> None:
    first = Estimate(np.array([5.0, 5.0]), np.array([3.0, 1.0, 7.0, 9.0]), in_view_probability=1.0)
    pixels = np.zeros((12, 16), bool)
    pixels[2:5, 3:9] = True
    masked = estimate_of(Mask(pixels), 12, 16)
    lines = list(_regions([first, masked, NONE, Estimate(np.array([20.0, 30.0])), first]))
    start, mask, none, place, box = map(read_region, lines)
    assert (start, none) == (Special(1), Special(0))
    assert isinstance(mask, Mask)
    np.testing.assert_array_equal(mask.mask(12, 16), pixels)
    assert isinstance(place, Rectangle)
    np.testing.assert_array_equal(place.box_xyxy, [18, 26, 22, 34])
    assert isinstance(box, Rectangle)
    np.testing.assert_array_equal(box.box_xyxy, first.box_xyxy)


def test_rows_of_one_target_and_of_many() -> None:
    box = Estimate(np.array([5.0, 5.0]), np.array([3.0, 1.0, 7.0, 9.0]), in_view_probability=0.25)
    assert list(mot_rows([box, NONE])) == ["1,1,4.0,2.0,4.0,8.0,0.25,-1,-1,-1"]
    tracks = [Track(7, box, confidence=0.5), Track(8, Estimate(np.array([2.0, 3.0]))), Track(9, NONE)]
    assert list(mot_rows([[], tracks])) == ["2,7,4.0,2.0,4.0,8.0,0.5,-1,-1,-1", "2,8,3.0,4.0,0.0,0.0,-1,-1,-1,-1"]


def test_what_is_not_written_leaves_nothing(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match=r"format: expected one of mot, vot; got 'otb'"):
        write_predictions(tmp_path, "otb", str(tmp_path / "out"))
    with pytest.raises(ValueError, match=r"estimates: expected files of `frameout bench --keep-estimates`"):
        write_predictions(tmp_path, "mot", str(tmp_path / "out"))
    assert not (tmp_path / "out").exists()


def test_frames_of_one_target_begin_where_it_is_seen_and_those_of_many_with_the_first_picture(tmp_path: Path) -> None:
    root = write_mot(tmp_path / "set")
    file = root / "train" / "MOT17-02-FRCNN" / "gt" / "gt.txt"
    write_lines(file, [line for line in file.read_text().splitlines() if not line.startswith("1,7,")])
    numbers = [_first_numbers(suite, ("--real", str(root))) for suite in ("frame-out", "many")]
    assert [list(each.values()) for each in numbers] == [[2], [1]]
