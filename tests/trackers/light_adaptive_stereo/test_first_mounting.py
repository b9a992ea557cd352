"""Without a measured pose the first box shows how high the camera is."""

from __future__ import annotations

import numpy as np
import pytest

from tests.trackers import drawn_people
from tests.trackers.drawn_people import RED, Board, observation, person_box
from trackers.light_adaptive_stereo.matching import StereoMatcher
from trackers.light_adaptive_stereo.stereo_view import first_mounting
from trackers.registry import entry

NAMES = ("stereo_wb", "stereo_wb_shutter_gain", "stereo_nearest", "stereo_colour_gate", "stereo_people")
PERSON = Board(3.0, 0.2, RED)


@pytest.fixture(autouse=True)
def _undo_the_kept_background(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(drawn_people, "_background", drawn_people._background.__wrapped__)


@pytest.mark.parametrize("right", [True, False])
@pytest.mark.parametrize("height_m", [0.6, 1.2, 1.6])
def test_the_height_is_found(height_m: float, right: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(drawn_people, "CAMERA_HEIGHT_M", height_m)
    found = first_mounting(observation([PERSON], right=right), person_box(PERSON), StereoMatcher(), 1.7)
    assert found.height_m == pytest.approx(height_m, rel=0.1)


@pytest.mark.heavy
@pytest.mark.parametrize("name", NAMES)
def test_trackers_follow_from_a_low_camera_whose_height_nobody_tells(
    name: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(drawn_people, "CAMERA_HEIGHT_M", 0.6)
    tracker = entry(name).create(np.random.default_rng(0))
    tracker.initialise(observation([PERSON]), person_box(PERSON))
    estimate = tracker.update(observation([PERSON], 1))
    assert estimate.in_view_probability >= 0.5
    assert estimate.box_xyxy == pytest.approx(person_box(PERSON), abs=25)
