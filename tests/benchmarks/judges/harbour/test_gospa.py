"""GOSPA is Stone Soup's, as recorded by ``record_stone_soup.py``."""

from __future__ import annotations

import json

import numpy as np
import pytest

from benchmarks.judges.harbour.identity_scores import gospa
from tests.benchmarks.judges.record_stone_soup import FILE, distances, frames

RECORDED = json.loads(FILE.read_text())


def test_the_recorded_frames_are_those_of_the_recording_script() -> None:
    assert [{k: v for k, v in each.items() if k != "gospa"} for each in RECORDED["frames"]] == frames()


def test_it_is_that_of_stone_soup() -> None:
    found = [gospa(distances(each), each["cutoff"], each["order"]) for each in RECORDED["frames"]]
    assert found == pytest.approx([each["gospa"] for each in RECORDED["frames"]], abs=1e-9)


def test_the_recording_has_misses_false_tracks_and_empty_frames() -> None:
    counts = {(min(len(each["targets"]), 1), min(len(each["tracks"]), 1)) for each in RECORDED["frames"]}
    assert counts == {(0, 1), (1, 0), (1, 1)}
    assert RECORDED["stonesoup"] == "1.9.1"


def test_nothing_without_tracks_is_right() -> None:
    assert gospa(np.zeros((0, 0)), 3.0) == 0.0


def test_a_pair_beyond_the_cut_off_is_a_miss_and_a_false_track() -> None:
    assert gospa(np.array([[2.0]]), 3.0) == pytest.approx(2.0)
    assert gospa(np.array([[3.5]]), 3.0) == gospa(np.array([[np.inf]]), 3.0) == pytest.approx(3.0)
