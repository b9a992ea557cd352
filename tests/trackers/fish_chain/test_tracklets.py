"""Tracklets of fish made by hand: extended, broken and begun."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pytest

from tests.trackers.fish_chain.swum import LENGTH_PX, seen, swum
from trackers.fish_chain.detection import Detection
from trackers.fish_chain.tracklets import TrackletBuilder, TrackletParameters


def built(frames: Sequence[Sequence[Detection]], **changes: float | bool) -> TrackletBuilder:
    builder = TrackletBuilder(TrackletParameters(**changes))
    for frame, detections in enumerate(frames):
        builder.step(frame, detections, LENGTH_PX)
    return builder


def test_fish_apart_are_one_tracklet_each_in_any_order_of_detections() -> None:
    rng = np.random.default_rng(0)
    frames = []
    for k in range(30):
        two = [seen((50.0 + 3 * k, 60.0), 0.0), seen((200.0 - 2 * k, 120.0), np.pi)]
        frames.append([two[i] for i in rng.permutation(2)])
    builder = built(frames)
    assert [len(each) for each in builder.active] == [30, 30]
    assert not builder.ended
    for each in builder.active:
        places = each.lines_px()[:, 4]
        assert np.ptp(places[:, 1]) == 0


def test_a_fish_that_vanishes_ends_and_returns_as_another_tracklet() -> None:
    fish = [[seen((50.0 + 3 * k, 60.0), 0.0)] for k in range(20)]
    fish[10:13] = [[], [], []]
    builder = built(fish)
    assert [(each.first_frame, each.end_frame) for each in builder.ended] == [(0, 10)]
    assert [(each.first_frame, each.end_frame) for each in builder.active] == [(13, 20)]


def test_fish_that_could_be_exchanged_both_break() -> None:
    frames = [[seen((60.0 + k, 60.0), 0.0), seen((60.0 + k, 90.0 - 2 * k), 0.0)] for k in range(8)]
    frames.append([seen((69.0, 66.5), 0.0), seen((68.0, 67.5), 0.0)])
    assert len(built(frames).ended) == 2
    assert not built(frames, margin=0.0).ended


def test_the_head_is_the_end_that_swims_ahead() -> None:
    """The heavier end, which each detection takes for the head, is behind on all frames."""
    tracklet = swum(0, frames=2, velocity_px=(3.0, 0.0))
    for k in range(2, 20):
        tracklet.append(seen((100.0 - 3 * k, 100.0), 0.0))
    assert not tracklet.head_first
    assert np.cos(tracklet.piece(1 / 30).heading_rad).max() < 0


def test_a_detection_that_is_turned_round_does_not_turn_the_fish() -> None:
    tracklet = swum(0, frames=15, velocity_px=(3.0, 0.0))
    for k in range(15, 20):
        tracklet.append(seen((100.0 + 3 * k, 100.0), np.pi))
    assert np.cos(tracklet.piece(1 / 30).heading_rad).min() > 0
    assert tracklet.looks().shape == (2, 22)


def test_two_fish_go_into_a_blob_and_are_followed_inside() -> None:
    frames: list[list[Detection]] = []
    for k in range(10):
        frames.append([seen((60.0 + 3 * k, 100.0), 0.0), seen((150.0 - 3 * k, 104.0), np.pi)])
    blob = seen((105.0, 102.0), 0.0, merged=True)
    frames += [[blob]] * 5
    builder = built(frames)
    assert not builder.active
    assert len(builder.ended) == len(builder.ghosts) == 2
    assert all(sorted(each.ghosts) == [10, 11, 12, 13, 14] for each in builder.ghosts)
    for each, other in zip(builder.ghosts, (70.0, 140.0), strict=True):
        each.haunt(14, np.array([other, 102.0, 0.0, 0.0]))
    apart = [seen((70.0, 102.0), 0.0), seen((140.0, 102.0), np.pi)]
    builder.step(15, apart, LENGTH_PX)
    assert len(builder.active) == 2
    assert not builder.ghosts


def test_without_posture_nothing_is_followed_inside() -> None:
    frames = [[seen((60.0, 100.0), 0.0)]] * 5 + [[seen((60.0, 100.0), 0.0, merged=True)]] * 3
    assert built(frames, use_posture=False).ghosts[0].ghosts == {}
    assert len(built(frames).ghosts[0].ghosts) == 3


@pytest.mark.parametrize("count", [0, 1, 5])
def test_frames_without_fish_are_no_error(count: int) -> None:
    builder = built([[]] * count)
    assert builder.active == builder.ended == builder.ghosts == []
