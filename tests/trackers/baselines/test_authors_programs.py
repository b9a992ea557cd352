"""SORT and ByteTrack give the authors' tracks, as recorded by ``record_box_trackers.py``."""

from __future__ import annotations

import dataclasses
import json
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from tests.trackers.baselines.record_box_trackers import BYTETRACK, FILE, OVERLAPS, SORT, Names, renamed, sequences
from tests.trackers.fish_chain.swum import seen
from trackers.baselines import bytetrack
from trackers.baselines.bytetrack import ByteTrack, ByteTrackParameters
from trackers.baselines.sort import Sort, SortParameters
from trackers.kernels.boxes import intersections_over_union

RECORDED = json.loads(FILE.read_text())["sequences"]
FIXED = {"low": 0.1, "second_cost": 0.5, "new_cost": 0.7, "duplicate_cost": 0.15}
"""ByteTrack's thresholds that the authors wrote in the code."""


def followed(tracker: Sort | ByteTrack, boxes: Any) -> Names:
    """Return our identity of each detection on each frame."""
    told = []
    for frame in boxes:
        detections = [
            dataclasses.replace(seen((0.0, 0.0), 0.0), box_xyxy=np.array(each[:4]), score=each[4]) for each in frame
        ]
        names = {id(each.estimate.box_xyxy): each.identity for each in tracker.follow(detections)}
        told.append([names.get(id(each.box_xyxy), -1) for each in detections])
    return renamed(told)


def overlaps_in_pixels(first_xyxy: NDArray[np.float64], second_xyxy: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the overlaps of boxes given by their first and last pixels."""
    wider = np.array([0.0, 0.0, 1.0, 1.0])
    return intersections_over_union(first_xyxy + wider, second_xyxy + wider)


def test_the_recorded_sequences_are_those_of_the_recording_script() -> None:
    assert {name: entry["boxes"] for name, entry in RECORDED.items()} == sequences()


@pytest.mark.parametrize("sequence", RECORDED)
@pytest.mark.parametrize("setting", SORT)
def test_sort_gives_the_authors_tracks(sequence: str, setting: str) -> None:
    entry = RECORDED[sequence]
    ours = followed(Sort(SortParameters(**SORT[setting]), np.random.default_rng(0)), entry["boxes"])  # type: ignore[arg-type]
    assert ours == entry["sort"][setting]


@pytest.mark.heavy
@pytest.mark.parametrize("sequence", RECORDED)
@pytest.mark.parametrize("setting", BYTETRACK)
@pytest.mark.parametrize("overlaps", OVERLAPS)
def test_bytetrack_gives_the_authors_tracks(
    sequence: str, setting: str, overlaps: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    if overlaps == "pixels":
        monkeypatch.setattr(bytetrack, "intersections_over_union", overlaps_in_pixels)
    entry = RECORDED[sequence]
    parameters = ByteTrackParameters(**FIXED, **BYTETRACK[setting])  # type: ignore[arg-type]
    ours = followed(ByteTrack(parameters, np.random.default_rng(0)), entry["boxes"])
    assert ours == entry[f"bytetrack, {overlaps}"][setting]


def test_the_recording_can_tell_trackers_apart() -> None:
    for entry in RECORDED.values():
        runs = [run for kind, settings in entry.items() if kind != "boxes" for run in settings.values()]
        assert min(max(map(max, filter(None, run))) for run in runs) > 5
        assert len({json.dumps(run) for run in runs}) >= 7
