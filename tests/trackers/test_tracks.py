"""Answers of trackers of many targets: their contract, and their reduction to one track."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import pytest

from trackers.estimate_check import check_estimate, check_tracks
from trackers.follow_one import FollowOne
from trackers.types import CameraModel, Estimate, Observation, Track

CAMERA = CameraModel(64, 48, 50.0)
BOX = np.array([10.0, 10.0, 20.0, 20.0])
NOWHERE = np.full(2, np.nan)


def at(identity: int, x: float, y: float) -> Track:
    return Track(identity, Estimate(np.array([x, y])))


def observation(k: int = 0) -> Observation:
    return Observation(np.zeros((48, 64, 3), np.uint8), k / 15, CAMERA)


class Scripted:
    """Returns the given answers, picture by picture."""

    def __init__(self, *answers: Sequence[Track]) -> None:
        self.answers = list(answers)
        self.started: list[Any] = []

    def start(self, background: Sequence[Observation], camera: CameraModel) -> None:
        self.started.append((tuple(background), camera))

    def update(self, observation: Observation) -> Sequence[Track]:
        return self.answers.pop(0)


@pytest.mark.parametrize(
    "tracks",
    [
        [],
        (at(0, 1.0, 2.0), at(7, -50.0, 900.0)),
        [Track(np.int64(3), Estimate(NOWHERE), "person", np.ones(3), 0.0)],  # type: ignore[arg-type]
        [at(identity, 0.0, 0.0) for identity in range(1000)],
    ],
)
def test_tracks_that_the_contract_allows(tracks: Sequence[Track]) -> None:
    check_tracks(tracks)


@pytest.mark.parametrize("identity", [3.0, np.float32(3), np.int16(3), np.array(3)])
def test_whole_numbers_of_any_kind_are_identities_also_from_a_generator(identity: Any) -> None:
    (track,) = check_tracks(at(each, 1.0, 2.0) for each in [identity])
    assert (track.identity, type(track.identity)) == (3, int)


def test_the_largest_identity_is_kept() -> None:
    assert check_tracks([at(2**63 - 1, 1.0, 2.0)])[0].identity == 2**63 - 1


@pytest.mark.parametrize(
    ("tracks", "message"),
    [
        (None, r"update: expected a sequence of Tracks, \(\) without any, got None"),
        ([Estimate(np.zeros(2))], "update: expected a sequence of Tracks, .*, got one of Estimate"),
        ([at(4, 0.0, 0.0), at(5, 0.0, 0.0), at(4, 1.0, 1.0)], "identity: expected each once in an answer, got 4 twice"),
        ([at(-1, 0.0, 0.0)], r"identity: expected .* \(a track that .* is left out\), got -1"),
        ([Track(True, Estimate(np.zeros(2)))], "identity: expected a whole number from 0 to .*, got True"),
        ([at(2**63, 0.0, 0.0)], r"identity: expected a whole number from 0 to 2\^63 - 1, got 9223372036854775808"),
        ([at(2.5, 0.0, 0.0)], "identity: expected a whole number .*, got 2.5"),  # type: ignore[arg-type]
        ([at("3", 0.0, 0.0)], "identity: expected a whole number .*, got '3'"),  # type: ignore[arg-type]
        ([at(np.nan, 0.0, 0.0)], "identity: expected a whole number .*, got nan"),  # type: ignore[arg-type]
        (np.zeros((2, 7)), r"update: expected a sequence of Tracks, .*, got ndarray of shape \(2, 7\)"),
        ([(3, 4, 5, 6, 1)], "update: expected a sequence of Tracks, .*, got one of tuple"),
        ({1: Estimate(np.zeros(2))}, "update: expected a sequence of Tracks, .*, got dict"),
        ([at(0, np.inf, 0.0)], "position_px: expected finite numbers"),
        ([Track(0, Estimate(np.zeros(2)), kind=3)], "kind: expected a name or None, got 3"),  # type: ignore[arg-type]
        ([Track(0, Estimate(np.zeros(2)), size_m=np.array([1.0, 0.0, 1.0]))], "size_m: expected numbers > 0"),
        ([Track(0, Estimate(np.zeros(2)), size_m=np.ones(2))], r"size_m: expected the shape \(3,\), got \(2,\)"),
        ([Track(0, Estimate(np.zeros(2)), confidence=1.5)], "confidence: expected a number from 0 to 1, got 1.5"),
    ],
)
def test_tracks_that_it_forbids(tracks: Any, message: str) -> None:
    with pytest.raises(ValueError, match=message):
        check_tracks(tracks)


def followed(*answers: Sequence[Track]) -> list[Estimate]:
    """Return the estimates of one track from the second picture on; the first one has the first answer."""
    one = FollowOne(Scripted(*answers))
    one.initialise(observation(), BOX)
    return [one.update(observation(k)) for k in range(1, len(answers))]


def test_the_track_nearest_to_the_middle_of_the_box_is_followed() -> None:
    first = [at(1, 11.0, 11.0), at(2, 14.0, 15.0), at(3, 21.0, 15.0)]
    estimates = followed(first, [at(1, 15.0, 15.0), at(2, 40.0, 41.0)])
    np.testing.assert_array_equal(estimates[0].position_px, [40.0, 41.0])


def test_a_track_that_ends_gives_nan_and_continues_when_it_returns() -> None:
    estimates = followed([at(2, 15.0, 15.0)], [], [at(9, 15.0, 15.0)], [at(9, 0.0, 0.0), at(2, 30.0, 31.0)])
    assert np.isnan(estimates[0].position_px).all()
    assert np.isnan(estimates[1].position_px).all()
    np.testing.assert_array_equal(estimates[2].position_px, [30.0, 31.0])
    for estimate in estimates:
        check_estimate(estimate)


def test_a_target_that_is_found_late_is_looked_for_in_its_first_box() -> None:
    nothing_there = [at(1, 40.0, 40.0), Track(5, Estimate(NOWHERE))]
    estimates = followed(nothing_there, nothing_there, [at(6, 12.0, 12.0)], [at(6, 50.0, 12.0)])
    assert np.isnan(estimates[0].position_px).all()
    np.testing.assert_array_equal(estimates[2].position_px, [50.0, 12.0])


def test_background_and_calibration_reach_the_tracker_once() -> None:
    tracker, background = Scripted([], []), (observation(), observation(1))
    one = FollowOne(tracker, background)
    one.initialise(observation(), BOX)
    one.update(observation(1))
    assert tracker.started == [(background, CAMERA)]


def test_a_thousand_tracks_are_gone_through() -> None:
    many = [at(identity, float(identity), 15.0) for identity in range(1000)]
    [estimate] = followed(many, many)
    np.testing.assert_array_equal(estimate.position_px, [15.0, 15.0])
