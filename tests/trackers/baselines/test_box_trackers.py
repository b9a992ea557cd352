"""SORT and ByteTrack against small cases worked out independently."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray
from shapely.geometry import box

from tests.trackers.fish_chain.swum import seen
from trackers.baselines.bytetrack import ByteTrack, ByteTrackParameters, HeightFilter
from trackers.baselines.sort import BoxFilter, Sort, SortParameters
from trackers.fish_chain.detection import Detection
from trackers.kernels.boxes import intersections_over_union

RNG = np.random.default_rng(0)


def scored(detection: Detection, score: float) -> Detection:
    object.__setattr__(detection, "score", score)
    return detection


@given(st.integers(0, 10_000))
def test_overlaps_are_those_of_polygons(seed: int) -> None:
    rng = np.random.default_rng(seed)
    first, second = (np.sort(rng.uniform(0, 10, (3, 2, 2)), axis=1).reshape(3, 4) for _ in range(2))
    expected = [
        [box(*a).intersection(box(*b)).area / box(*a).union(box(*b)).area for b in second.tolist()]
        for a in first.tolist()
    ]
    np.testing.assert_allclose(intersections_over_union(first, second), expected, atol=1e-9)


def _steps(kind: type[BoxFilter] | type[HeightFilter]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return the box that a filter expects after six boxes that move steadily, and the true one."""
    truth = [np.array([10.0 + 3 * k, 20.0 + k, 40.0 + 3 * k, 32.0 + k]) for k in range(40)]
    tracked = kind(truth[0])
    for each in truth[1:39]:
        _predicted(tracked)
        tracked.correct(each)
    return _predicted(tracked), truth[39]


def _predicted(tracked: BoxFilter | HeightFilter) -> NDArray[np.float64]:
    if isinstance(tracked, BoxFilter):
        return tracked.predict()
    tracked.predict(lost=False)
    return tracked.box_xyxy


@pytest.mark.parametrize("kind", [BoxFilter, HeightFilter])
def test_a_steady_box_is_expected_where_it_goes(kind: type[BoxFilter] | type[HeightFilter]) -> None:
    expected, truth = _steps(kind)
    np.testing.assert_allclose(expected, truth, atol=0.5)


def test_sort_answers_after_its_hits_and_forgets_after_its_age() -> None:
    tracker = Sort(SortParameters(max_age=2, min_hits=3), RNG)
    fish = [seen((50.0 + 2 * k, 50.0), 0.0) for k in range(30)]
    for _ in range(10):
        tracker.follow([])
    answered = [len(tracker.follow([each])) for each in fish[:6]]
    assert answered == [0, 0, 0, 1, 1, 1]
    name = tracker.follow([fish[6]])[0].identity
    for _ in range(2):
        assert tracker.follow([]) == []
    assert tracker.follow([fish[9]]) == []
    later = [tracker.follow([each]) for each in fish[10:14]]
    assert later[-1][0].identity == name
    for _ in range(3):
        tracker.follow([])
    assert [tracker.follow([each]) for each in fish[17:22]][-1][0].identity != name


def test_sort_takes_the_assignment_with_most_overlap() -> None:
    tracker = Sort(SortParameters(min_hits=1), RNG)
    left, right = seen((50.0, 50.0), 0.0), seen((62.0, 50.0), 0.0)
    names = [each.identity for each in tracker.follow([left, right])]
    swapped = tracker.follow([seen((61.0, 50.0), 0.0), seen((49.0, 50.0), 0.0)])
    where = {each.identity: each.estimate.position_px[0] for each in swapped}
    assert where == {names[0]: 49.0, names[1]: 61.0}


def test_bytetrack_continues_tracks_by_weak_detections_but_begins_none() -> None:
    tracker = ByteTrack(ByteTrackParameters(), RNG)
    fish = [seen((50.0 + k, 50.0), 0.0) for k in range(12)]
    names = {tracker.follow([each])[0].identity for each in fish[:4]}
    assert len(names) == 1
    for each in fish[4:8]:
        answered = tracker.follow([scored(each, 0.3), scored(seen((200.0, 200.0), 0.0), 0.3)])
        assert {track.identity for track in answered} == names
    assert tracker.follow([scored(fish[8], 0.05)]) == []


def test_bytetrack_finds_a_lost_track_within_its_buffer() -> None:
    for gap, kept in ((5, True), (40, False)):
        tracker = ByteTrack(ByteTrackParameters(buffer_frames=10), RNG)
        name = [tracker.follow([seen((50.0, 50.0), 0.0)]) for _ in range(4)][-1][0].identity
        for _ in range(gap):
            assert tracker.follow([]) == []
        again = [tracker.follow([seen((50.0, 50.0), 0.0)]) for _ in range(3)][-1][0].identity
        assert (again == name) == kept


def test_a_track_is_confirmed_by_its_second_detection() -> None:
    tracker = ByteTrack(ByteTrackParameters(), RNG)
    tracker.follow([])
    assert tracker.follow([seen((50.0, 50.0), 0.0)]) == []
    assert len(tracker.follow([seen((51.0, 50.0), 0.0)])) == 1
