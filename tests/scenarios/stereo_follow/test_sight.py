from __future__ import annotations

import numpy as np
import pytest

from scenarios.stereo_follow.sight import covered_share, is_in_sight, seen_frames

NOBODY = np.empty((0, 2))
OPENING = np.array([[0.0, 0.0, 0.0, 2.0]])
HERE, THERE = np.array([-2.0, 1.0]), np.array([2.0, 1.0])


def test_walls_and_people_hide() -> None:
    assert covered_share(HERE, THERE, NOBODY, OPENING) == 0.0
    # The opening is elsewhere.
    assert covered_share(HERE, THERE, NOBODY, np.array([[0.0, 3.0, 0.0, 5.0]])) == 1.0
    # On the line, the person's shadow is wider than the target; at the sum of both half widths it misses the target.
    assert covered_share(HERE, THERE, np.array([[0.0, 1.0]]), OPENING) == 1.0
    assert covered_share(HERE, THERE, np.array([[0.0, 1.0 + 0.5 * 0.5]]), OPENING) == pytest.approx(0.5)
    assert covered_share(HERE, THERE, np.array([[0.0, 1.0 + 0.5 * 0.76]]), OPENING) == 0.0
    assert covered_share(HERE, THERE, np.array([[3.0, 1.0]]), OPENING) == 0.0, "the person stands behind the target"


@pytest.mark.parametrize("turned_deg", [0.0, 180.0, 350.0])
def test_a_person_beyond_the_border_of_the_picture_is_out_of_sight(turned_deg: float) -> None:
    turned = np.deg2rad(turned_deg)
    for bearing_deg, is_seen in (
        (0.0, True),
        (32.5, True),
        (-32.5, True),
        (33.5, False),
        (-33.5, False),
        (180.0, False),
    ):
        bearing = turned + np.deg2rad(bearing_deg)
        place_m = 3.0 * np.array([np.cos(bearing), np.sin(bearing)])
        assert is_in_sight(np.zeros(2), turned, place_m, NOBODY, np.empty((0, 4))) == is_seen


def test_frames_in_sight_are_those_of_the_frame_by_frame_test() -> None:
    target_m = np.tile(THERE, (3, 1))
    others_m = np.array([[[9.0, 9.0], [0.0, 1.0], [0.0, 1.3]]])
    heading = np.array([0.0, 0.0, 0.0])
    seen = seen_frames(np.tile(HERE, (3, 1)), heading, target_m, others_m, OPENING)
    assert seen.tolist() == [True, False, True]
