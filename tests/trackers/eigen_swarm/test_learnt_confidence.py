"""``eigen_swarm_learnt_confidence`` answers as the method as written, and is sure of something else."""

from __future__ import annotations

import numpy as np
import pytest

from tests.trackers.drawn_harbour import CAMERA, SURVEY, DrawnHarbour
from trackers.estimate_check import check_tracks
from trackers.registry import entry
from trackers.types import Track


def answers(name: str) -> list[list[Track]]:
    harbour, tracker = DrawnHarbour(0), entry(name).create(np.random.default_rng(0))
    tracker.survey(SURVEY)
    tracker.start(harbour.pictures(60), CAMERA)
    return [tracker.update(harbour.picture([np.array([4.0 - 0.5 * k, 3.0 - 0.7 * k])])) for k in range(8)]


@pytest.mark.heavy
def test_only_the_confidences_differ() -> None:
    written, learnt = answers("eigen_swarm"), answers("eigen_swarm_learnt_confidence")
    assert sum(map(len, written)) > 5
    for ours, theirs in zip(learnt, written, strict=True):
        check_tracks(ours)
        assert [track.identity for track in ours] == [track.identity for track in theirs]
        for one, other in zip(ours, theirs, strict=True):
            np.testing.assert_array_equal(one.estimate.box_xyxy, other.estimate.box_xyxy)
            assert one.confidence != other.confidence
