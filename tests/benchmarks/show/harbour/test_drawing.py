"""Videos of a harbour: colours by what a track lies on, words by cause, the plan view's scale."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import pytest

from benchmarks.show.video import marks
from benchmarks.show.video.drawing import ESTIMATE_SIGN, Instant
from benchmarks.show.video.harbour import _ALARM, _NEITHER, HarbourDrawing, PlanView
from scenarios.harbour.truth import HarbourMap
from tests.benchmarks.judges.harbour.hand_made import CLUTTER, frame_of, standing, track, truth_of
from trackers.types import Estimate, Track

SITE = HarbourMap(
    volume_m=np.array([90.0, 33.0, 6.0]),
    volume_centre_m=np.zeros(3),
    clutter=CLUTTER,
    land_m=np.array([[-15.0, 90.0], [-15.0, -90.0], [200.0, -90.0], [200.0, 90.0]]),
    wall_m=np.array([[-15.0, 90.0], [-15.0, -90.0]]),
)


@dataclass
class Drawn:
    """What a drawing asks of an episode."""

    def map_of(self) -> HarbourMap:
        return SITE


def drawn(
    tracks: list[Track] | Estimate, frames: int = 4, *, steps: tuple[int, ...] = (), decides_at: float = 0.0
) -> np.ndarray:
    """Return the last picture of a few frames with a person on the quay."""
    episode: Any = Drawn()
    drawing = HarbourDrawing(episode)
    for k in range(frames):
        frame = frame_of(truth_of([standing("person", (10.0, 3.0), range(frames))], k, agc_step=k in steps))
        picture = drawing.picture(Instant(frame, (0,), tracks, frame.observation.image_rgb, decides_at))
    return picture


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


def test_an_alarm_says_why_from_the_fourth_frame_on() -> None:
    tracks = [track(1, (-30.0, -6.0))]
    words = [of_colour(drawn(tracks, frames), _ALARM) for frames in (3, 4)]
    assert words[1] > words[0] + 20
    stepped = drawn(tracks, 4, steps=(0,))
    assert (stepped != drawn(tracks, 4)).any()
    assert (drawn(tracks, 4, steps=(1,)) == drawn(tracks, 4)).all()


def test_what_a_tracker_does_not_decide_for_is_left_out() -> None:
    unlikely = [track(1, (-30.0, -6.0), confidence=0.2)]
    assert of_colour(drawn(unlikely, decides_at=0.2), _ALARM) > 10
    assert of_colour(drawn(unlikely, decides_at=0.3), _ALARM) == 0


def test_a_plan_looks_along_the_line_of_sight() -> None:
    plan = PlanView(SITE, 720)
    far, near, left = (plan.at(place) for place in ((45.0, 0.0), (-45.0, 0.0), (0.0, 16.5)))
    assert far[0] == near[0]
    assert near[1] > far[1]
    assert left[0] < far[0]
    px_per_m = (near[1] - far[1]) / 90.0
    assert (far[0] - left[0]) / 16.5 == pytest.approx(px_per_m)
    ground = plan.ground
    assert ground.shape[0] == 720
    sea, land = (ground[int(y), int(x)] for x, y in (plan.at((-40.0, 8.0)), plan.at((20.0, 8.0))))
    assert (sea != land).any()


def test_the_legend_is_of_what_is_drawn() -> None:
    episode: Any = Drawn()
    drawing = HarbourDrawing(episode)
    frame = frame_of(truth_of([standing("person", (10.0, 3.0), range(1))], 0))
    for answer, told in (([track(1, (12.5, 3.0))], True), (Estimate(np.array([120.0, 90.0])), False)):
        drawing.picture(Instant(frame, (0,), answer, frame.observation.image_rgb))
        assert any("track" in sign.words for sign in drawing.signs) == told
        assert (ESTIMATE_SIGN in drawing.signs) != told


def test_a_follower_of_one_is_drawn_too() -> None:
    one = Estimate(np.array([120.0, 90.0]), np.array([110.0, 80.0, 130.0, 100.0]))
    picture = drawn(one, 1)
    assert of_colour(picture, marks.ESTIMATE) > of_colour(drawn(Estimate(np.full(2, np.nan)), 1), marks.ESTIMATE) + 10
