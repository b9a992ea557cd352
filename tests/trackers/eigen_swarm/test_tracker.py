"""``eigen_swarm`` before a hand-drawn harbour."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from tests.trackers.drawn_harbour import CAMERA, INTERVAL_S, SURVEY, VIEW, DrawnHarbour, checked_answers
from trackers.eigen_swarm.tracker import EigenSwarm
from trackers.registry import entry
from trackers.site_model_file import save_model
from trackers.types import Observation

WALK = [np.array([4.0 - 0.5 * k, 3.0 - 0.7 * k]) for k in range(14)]
QUIET = 5


def a_swarm() -> EigenSwarm:
    tracker: EigenSwarm = entry("eigen_swarm").create(np.random.default_rng(0))
    tracker.survey(SURVEY)
    return tracker


@pytest.fixture(scope="module")
def harbour() -> tuple[EigenSwarm, list[Observation]]:
    """Return a tracker that was started, and the pictures of a walk."""
    drawn, tracker = DrawnHarbour(0), a_swarm()
    tracker.start(drawn.pictures(120), CAMERA)
    return tracker, [*drawn.pictures(QUIET), *(drawn.picture([place_m]) for place_m in WALK)]


@pytest.fixture(scope="module")
def saved(harbour: tuple[EigenSwarm, list[Observation]], tmp_path_factory: pytest.TempPathFactory) -> Path:
    return harbour[0].save_background(tmp_path_factory.mktemp("models") / "quay")


def restarted(saved: Path) -> EigenSwarm:
    tracker = a_swarm()
    tracker.start_from(saved, CAMERA, VIEW.T_world_camera)
    return tracker


def test_a_person_who_walks_is_found_and_followed(harbour: tuple[EigenSwarm, list[Observation]], saved: Path) -> None:
    made = checked_answers(restarted(saved), harbour[1])
    assert made[:QUIET] == [[]] * QUIET
    for k, place_m in enumerate(WALK[8:], 8):
        oldest = made[QUIET + k][0]
        bearing = (place_m - VIEW.place_m[:2]) / np.linalg.norm(place_m - VIEW.place_m[:2])
        away_m = VIEW.place_of(oldest.estimate)[:2] - place_m
        # Across the line of sight it is at the person; along it, anywhere in the watched volume.
        assert abs(away_m @ [-bearing[1], bearing[0]]) < 1.0
        assert abs(away_m @ bearing) < 20.0
        assert oldest.size_m is not None
        assert 0.2 < oldest.size_m[1] < 2.0
        assert 0.7 < oldest.size_m[2] < 4.0
    ages = np.unique([track.identity for tracks in made[-5:] for track in tracks], return_counts=True)[1]
    assert ages.max() == 5


def test_a_saved_background_answers_as_the_learnt_one(
    harbour: tuple[EigenSwarm, list[Observation]], saved: Path
) -> None:
    learnt, loaded = harbour[0], restarted(saved)
    for mine, other in zip(checked_answers(learnt, harbour[1]), checked_answers(loaded, harbour[1]), strict=True):
        assert [track.identity for track in mine] == [track.identity for track in other]
        for one, two in zip(mine, other, strict=True):
            np.testing.assert_array_equal(one.estimate.box_xyxy, two.estimate.box_xyxy)
            assert one.confidence == two.confidence


def test_the_background_of_another_camera_is_refused(saved: Path) -> None:
    turned = VIEW.T_world_camera.copy()
    turned[0, 3] += 5.0
    with pytest.raises(ValueError, match=r"model: expected one of this camera, .* place_m 5\.00 m away"):
        a_swarm().start_from(saved, CAMERA, turned)
    with pytest.raises(ValueError, match="background: expected pictures and a pose to have been learnt from"):
        a_swarm().save_background(saved.with_name("none"))


def test_a_file_whose_axes_are_those_of_no_blocks_is_refused(
    harbour: tuple[EigenSwarm, list[Observation]], tmp_path: Path
) -> None:
    mine = harbour[0]._spaces
    assert mine is not None
    first = mine.first.copy()
    first[3] = first[4] + 1
    arrays: dict[str, NDArray[Any]] = {"mean": mine.mean, "axes": mine.axes, "first": first}
    path = save_model(tmp_path / "quay", "eigen_swarm-2", VIEW, arrays)
    with pytest.raises(ValueError, match=r"model: expected axes for each block, got .*quay.* with others"):
        a_swarm().start_from(path, CAMERA, VIEW.T_world_camera)
    save_model(path, "eigen_swarm-2", VIEW, {"mean": mine.mean, "axes": mine.axes})
    with pytest.raises(ValueError, match=r"model: expected the arrays \['axes', 'first', 'mean'\]"):
        a_swarm().start_from(path, CAMERA, VIEW.T_world_camera)


def test_without_background_or_pose_nothing_is_answered(harbour: tuple[EigenSwarm, list[Observation]]) -> None:
    tracker = a_swarm()
    tracker.start((), CAMERA)
    assert checked_answers(tracker, harbour[1][-2:]) == [[], []]
    drawn = DrawnHarbour(1)
    unposed = [Observation(each.image_rgb, INTERVAL_S * k, CAMERA) for k, each in enumerate(drawn.pictures(4))]
    tracker.start(unposed[:3], CAMERA)
    assert checked_answers(tracker, unposed[3:]) == [[]]


def test_the_ablations_leave_out_one_condition_each() -> None:
    used = {
        name: (each.uses_direction, each.uses_distance)
        for name in ("eigen_swarm", "eigen_swarm_no_direction", "eigen_swarm_no_distance", "eigen_swarm_duplicates")
        for each in [entry(name).parameters()]
    }
    assert used == {
        "eigen_swarm": (True, True),
        "eigen_swarm_no_direction": (False, True),
        "eigen_swarm_no_distance": (True, False),
        "eigen_swarm_duplicates": (False, False),
    }
