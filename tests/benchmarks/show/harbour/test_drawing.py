"""Videos of a harbour: colours by what a track lies on, words by cause, the plan view's scale."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import pytest

from benchmarks.show.video import marks
from benchmarks.show.video.drawing import Drawing, Instant
from benchmarks.show.video.harbour import _ALARM, _NEITHER, HarbourDrawing, plan_of
from scenarios.harbour.truth import HarbourMap
from tests.benchmarks.judges.harbour.hand_made import CLUTTER, frame_of, standing, track, truth_of
from trackers.types import Estimate, Track

SITE = HarbourMap(
    volume_m=np.array([90.0, 33.0, 6.0]),
    volume_centre_m=np.zeros(3),
    volume_axes=np.eye(2),
    clutter=CLUTTER,
    land_m=np.array([[-15.0, 90.0], [-15.0, -90.0], [200.0, -90.0], [200.0, 90.0]]),
    wall_m=np.array([[-15.0, 90.0], [-15.0, -90.0]]),
)


@dataclass
class Drawn:
    """What a drawing asks of an episode."""

    def map_of(self) -> HarbourMap:
        return SITE


def drawn(tracks: list[Track] | Estimate, *, decides_at: float = 0.0) -> np.ndarray:
    """Return the picture of a frame with a person on the quay."""
    episode: Any = Drawn()
    frame = frame_of(truth_of([standing("person", (10.0, 3.0), range(1))], 0))
    return HarbourDrawing(episode).picture(Instant(frame, (0,), tracks, frame.observation.image_rgb, decides_at))


def of_colour(picture: np.ndarray, colour: marks.Rgb) -> int:
    """Return the number of pixels of about this colour in the thermal picture."""
    return int((np.abs(picture[:, :960].astype(int) - colour).max(axis=2) < 45).sum())


@pytest.mark.parametrize(
    ("at_m", "colour"), [((12.5, 3.0), marks.ESTIMATE), ((-30.0, -6.0), _ALARM), ((15.0, 3.4), _NEITHER)]
)
def test_colours_say_what_a_track_lies_on(at_m: tuple[float, float], colour: marks.Rgb) -> None:
    picture = drawn([track(1, at_m)])
    counts = {each: of_colour(picture, each) for each in (marks.ESTIMATE, _ALARM, _NEITHER)}
    # Lines are smoothed, and mix with what they lie on.
    assert counts[colour] > 10
    assert max(counts, key=lambda each: counts[each]) == colour
    assert of_colour(picture, marks.TRUTH) > 10


def test_a_track_on_nothing_says_what_lies_there() -> None:
    told = [of_colour(drawn([track(k, (-30.0, -6.0)) for k in range(count)]), _ALARM) for count in (20, 21)]
    # The words of more would hide the picture.
    assert told[0] > told[1] + 20


def test_what_a_tracker_does_not_decide_for_is_left_out() -> None:
    unlikely = [track(1, (-30.0, -6.0), confidence=0.2)]
    assert of_colour(drawn(unlikely, decides_at=0.2), _ALARM) > 10
    assert of_colour(drawn(unlikely, decides_at=0.3), _ALARM) == 0


@pytest.mark.parametrize("bearing_rad", [0.0, 1.5, -2.1])
def test_a_plan_looks_along_the_line_of_sight(bearing_rad: float) -> None:
    c, s = np.cos(bearing_rad), np.sin(bearing_rad)
    axes = np.array([[c, s], [-s, c]])
    plan = plan_of(replace(SITE, volume_axes=axes), 720)
    far, near, left = (plan.at(np.array(place) @ axes) for place in ((45.0, 0.0), (-45.0, 0.0), (0.0, 16.5)))
    assert far[0] == pytest.approx(near[0])
    assert near[1] > far[1]
    assert left[0] < far[0]
    px_per_m = (near[1] - far[1]) / 90.0
    assert (far[0] - left[0]) / 16.5 == pytest.approx(px_per_m)
    ground = plan.image
    assert ground.shape[0] == 720
    if bearing_rad != 0.0:
        return
    sea, land = (ground[int(y), int(x)] for x, y in (plan.at((-40.0, 8.0)), plan.at((20.0, 8.0))))
    assert (sea != land).any()


def test_the_legend_is_of_what_is_drawn() -> None:
    episode: Any = Drawn()
    drawing = HarbourDrawing(episode)
    frame = frame_of(truth_of([standing("person", (10.0, 3.0), range(1))], 0))
    for answer, told in (([track(1, (12.5, 3.0))], True), (Estimate(np.array([120.0, 90.0])), False)):
        drawing.picture(Instant(frame, (0,), answer, frame.observation.image_rgb))
        assert any("track" in words for words in drawing.answers) == told
        assert (drawing.answers == Drawing.answers) != told


def test_a_follower_of_one_is_drawn_too() -> None:
    one = Estimate(np.array([120.0, 90.0]), np.array([110.0, 80.0, 130.0, 100.0]))
    picture = drawn(one)
    assert of_colour(picture, marks.ESTIMATE) > of_colour(drawn(Estimate(np.full(2, np.nan))), marks.ESTIMATE) + 10
