"""Hostile pictures before trackers of a site, with a background and poses as hostile as they."""

from __future__ import annotations

from dataclasses import replace

import cv2
import numpy as np
import pytest

from tests.trackers.drawn_harbour import CAMERA, SURVEY, VIEW, DrawnHarbour
from tests.trackers.hostile import hostile_sequence
from trackers.estimate_check import check_tracks
from trackers.registry import entry
from trackers.types import EgoPose, Observation

FRAMES = 24
NAMES = (
    "harbour_watch",
    "eigen_swarm",
    "eigen_swarm_learnt_confidence",
    "harbour_mog2",
    "harbour_knn",
    "harbour_median",
    "harbour_blind",
    "harbour_posts",
)


def sequence(seed: int, posed: bool) -> list[Observation]:
    """Return observations, each with the pose of a camera over a harbour if ``posed``."""
    made = hostile_sequence(seed, stereo=False, frames=2 * FRAMES).observations
    return [replace(each, ego=EgoPose(VIEW.T_world_camera)) for each in made] if posed else made


@pytest.mark.heavy
@pytest.mark.parametrize("posed", [True, False])
@pytest.mark.parametrize("seed", [1, 11])
@pytest.mark.parametrize("name", NAMES)
def test_no_picture_and_no_background_makes_a_tracker_raise(name: str, seed: int, posed: bool) -> None:
    observations = sequence(seed, posed)
    tracker = entry(name).create(np.random.default_rng(seed))
    tracker.survey(SURVEY)
    tracker.start(observations[:FRAMES], observations[0].camera)
    for observation in observations[FRAMES:]:
        check_tracks(tracker.update(observation))


@pytest.mark.parametrize("name", NAMES)
def test_a_tracker_of_a_site_without_its_survey_says_so(name: str) -> None:
    with pytest.raises(ValueError, match="site: expected a survey of the site before the start, got none"):
        entry(name).create(np.random.default_rng(0)).start(DrawnHarbour(0).pictures(2), CAMERA)


def resized(observation: Observation, factor: float, camera_too: bool) -> Observation:
    """Return a picture at another size, and with the camera of that size if ``camera_too``."""
    image_rgb = cv2.resize(observation.image_rgb, None, fx=factor, fy=factor)
    height_px, width_px = image_rgb.shape[:2]
    camera = replace(CAMERA, width_px=width_px, height_px=height_px) if camera_too else CAMERA
    return replace(observation, image_rgb=image_rgb, camera=camera)


@pytest.mark.heavy
@pytest.mark.parametrize("camera_too", [True, False])
@pytest.mark.parametrize("name", NAMES)
def test_pictures_of_another_size_make_no_tracker_raise(name: str, camera_too: bool) -> None:
    harbour, tracker = DrawnHarbour(0), entry(name).create(np.random.default_rng(0))
    tracker.survey(SURVEY)
    tracker.start(harbour.pictures(20), CAMERA)
    for factor in (1.0, 2.0, 0.5, 1.0, 0.51, 3.0, 1.0):
        for picture in harbour.pictures(2):
            check_tracks(tracker.update(resized(picture, factor, camera_too)))
