"""Paths and earlier pictures follow the camera; where it rests, they rest."""

from __future__ import annotations

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray

from benchmarks.show.video.surroundings import CameraMotion, Mosaic, Paths
from trackers.types import Estimate

WIDTH, HEIGHT = 320, 240
_NOISE = np.random.default_rng(3)
GROUND = cv2.resize(_NOISE.integers(0, 255, (90, 130, 3), np.uint8), (1040, 720), interpolation=cv2.INTER_CUBIC)


def view_of(turn_rad: float, zoom: float, x: float, y: float) -> NDArray[np.float64]:
    """Return the similarity (3, 3) from the ground to the picture of a camera over (x, y)."""
    c, s = zoom * np.cos(turn_rad), zoom * np.sin(turn_rad)
    return np.array([[c, -s, WIDTH / 2 - c * x + s * y], [s, c, HEIGHT / 2 - s * x - c * y], [0.0, 0.0, 1.0]])


def picture(view: NDArray[np.float64], noise: float = 0.0) -> NDArray[np.uint8]:
    to_centres = np.array([[1.0, 0.0, -0.5], [0.0, 1.0, -0.5], [0.0, 0.0, 1.0]])
    H = to_centres @ view @ np.linalg.inv(to_centres)
    shown = cv2.warpPerspective(GROUND, H, (WIDTH, HEIGHT)).astype(float)
    return np.clip(shown + _NOISE.normal(0.0, noise, shown.shape), 0, 255).astype(np.uint8)


def at(view: NDArray[np.float64], place: tuple[float, float]) -> NDArray[np.float64]:
    return (view @ [*place, 1.0])[:2]


@pytest.mark.parametrize(
    "step", [(0.0, 1.0, 4.0, 0.0), (0.01, 1.0, 2.0, -3.0), (0.0, 1.01, 0.0, 2.0), (0.0, 1.0, 0.1, 0.0)]
)
def test_a_path_stays_where_it_was_on_the_ground(step: tuple[float, float, float, float]) -> None:
    """What was passed once is found where the true camera sees it now, inside the picture or not."""
    turn, zoom, dx, dy = step
    motion, paths, places = CameraMotion(), Paths(30.0), []
    for k in range(40):
        view = view_of(turn * k, zoom**k, 500 + dx * k, 360 + dy * k)
        places.append((480.0 + 3 * k, 350.0 + k))
        estimates = [("", Estimate(at(view, places[-1])))]
        path = paths.extended(motion.until(picture(view, 2.0)), estimates)[""]
    expected = np.array([at(view, place) for place in places])
    assert path.shape == expected.shape
    assert np.abs(path - expected).max() < 3.0


def test_before_a_camera_at_rest_nothing_moves_but_things() -> None:
    """A large thing goes by, noise is in all pictures."""
    motion = CameraMotion()
    for k in range(40):
        shown = picture(view_of(0.0, 1.0, 500, 360), 3.0)
        cv2.circle(shown, (8 * k, 120), 60, (250, 240, 10), -1)
        cv2.circle(shown, (8 * k, 120), 30, (10, 40, 200), 9)
        np.testing.assert_array_equal(motion.until(shown), np.eye(3))


def test_a_path_breaks_where_there_is_no_answer_and_ends_after_four_seconds() -> None:
    paths = Paths(5.0)
    for k in range(30):
        place = np.full(2, np.nan) if k == 25 else np.array([float(k), 0.0])
        path = paths.extended(np.eye(3), [("", Estimate(place))])[""]
    assert path[:, 0].tolist()[:15] == list(range(10, 25))
    assert np.isnan(path[15]).all()
    assert len(path) == 20
    for _ in range(20):
        kept = paths.extended(np.eye(3), [])
    assert kept == {}


def test_the_picture_lies_in_the_middle_of_what_was_seen_before() -> None:
    motion = CameraMotion()
    views = [view_of(0.0, 1.0, 400 + 5 * k, 360) for k in range(30)]
    mosaic = Mosaic(picture(views[0]), 2.0)
    for view in views:
        latest = picture(view)
        shown = mosaic.with_picture(latest, motion.until(latest))
    np.testing.assert_array_equal(shown[120:360, 160:480], latest)
    before = views[0][0, 2] - views[-1][0, 2]
    left = shown[120:360, 160 - round(before) + 8 : 160 - 8].astype(float)
    true = picture(view_of(0.0, 1.0, 400 + 145 - WIDTH / 2, 360))
    expected = true[:, WIDTH // 2 - round(before) + 8 : WIDTH // 2 - 8]
    assert np.abs(left - expected).mean() < 12
    assert (shown[:, -100:] == shown[0, -1]).all(), "to the right nothing was seen"


def test_a_view_is_the_same_where_others_before_it_were_not_wanted() -> None:
    motion = CameraMotion()
    shown = [picture(view_of(0.002 * k, 1.0, 400 + 5 * k, 360)) for k in range(40)]
    motions = [motion.until(each) for each in shown]
    whole, sparse = Mosaic(shown[0], 1.5), Mosaic(shown[0], 1.5)
    views = [whole.with_picture(*each) for each in zip(shown, motions, strict=True)]
    for k, each in enumerate(zip(shown, motions, strict=True)):
        if k % 13:
            sparse.with_picture(*each, is_wanted=False)
        else:
            np.testing.assert_array_equal(sparse.with_picture(*each), views[k])


@pytest.mark.parametrize(("width", "height"), [(3840, 2160), (1080, 1920), (1080, 2520), (640, 480)])
def test_views_fit_a_screen_and_a_caption(width: int, height: int) -> None:
    image = np.zeros((height, width, 3), np.uint8)
    mosaic = Mosaic(image, 1.5)
    shown = mosaic.with_picture(image, np.eye(3))
    assert max(shown.shape[:2]) <= 1920
    assert shown.shape[1] >= min(960, 1.5 * width)
    assert mosaic.zoom <= 1.0
