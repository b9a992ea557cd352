"""States and exits of objects, compared with a reference that treats one object at a time."""

from __future__ import annotations

from typing import get_args

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from scenarios.truth import VisibilityState
from scenarios.visibility import MOSTLY_SEEN, Exits, centres_px, states_of
from sim.optics import look_down_pose, project
from sim.pose import pose_on_ground
from trackers.types import CameraModel

WIDTH, HEIGHT = 40, 30
CAMERA = CameraModel(WIDTH, HEIGHT, 35.0)
# Whole numbers, so that boxes often touch a border exactly.
X, Y = st.integers(-12, WIDTH + 12), st.integers(-12, HEIGHT + 12)
SHARES = st.sampled_from([0.0, np.nextafter(MOSTLY_SEEN, 0), MOSTLY_SEEN, 1.0, np.nan])


@st.composite
def boxes(draw: st.DrawFn) -> tuple[float, float, float, float]:
    """Draw a box; for one partly or wholly behind the camera some or all numbers are NaN."""
    (left, right), (top, bottom) = sorted((draw(X), draw(X))), sorted((draw(Y), draw(Y)))
    unknown = draw(st.sampled_from([(0.0, 0.0, 0.0, 0.0)] * 6 + [(np.nan,) * 4, (np.nan, 0, 0, 0), (0, 0, 0, np.nan)]))
    return left + unknown[0], top + unknown[1], right + unknown[2], bottom + unknown[3]


def state_by_hand(box: tuple[float, float, float, float], share: float) -> str:
    """Return the state of one object."""
    left, top, right, bottom = box
    if any(np.isnan(value) for value in box):
        return "out"
    if right <= 0 or bottom <= 0 or left >= WIDTH or top >= HEIGHT:
        return "out"
    if left < 0 or top < 0 or right > WIDTH or bottom > HEIGHT:
        return "partial"
    return "occluded" if share < 0.5 else "in"


def side_by_hand(box: tuple[float, float, float, float]) -> str:
    """Return the side of the border that one object is furthest beyond; the first of equal ones."""
    if any(np.isnan(value) for value in box):
        return "bottom"
    left, top, right, bottom = box
    furthest, side = -np.inf, ""
    for name, beyond in (("left", -right), ("right", left - WIDTH), ("top", -bottom), ("bottom", top - HEIGHT)):
        if beyond > furthest:
            furthest, side = beyond, name
    return side


@given(st.lists(st.tuples(boxes(), SHARES), max_size=6))
def test_states_are_those_of_each_object_alone(objects: list[tuple[tuple[float, float, float, float], float]]) -> None:
    box_xyxy = np.array([box for box, _ in objects], dtype=float).reshape(-1, 4)
    states = states_of(CAMERA, box_xyxy, np.array([share for _, share in objects], dtype=float))
    assert states.tolist() == [state_by_hand(*each) for each in objects]


@st.composite
def histories(draw: st.DrawFn) -> list[list[tuple[str, tuple[float, float, float, float]]]]:
    """Draw state and box of each object on each frame: (F, N)."""
    count = draw(st.integers(0, 3))
    state = st.sampled_from([*get_args(VisibilityState), "out", "out"])
    frame = st.lists(st.tuples(state, boxes()), min_size=count, max_size=count)
    return draw(st.lists(frame, min_size=1, max_size=12))


@given(histories())
def test_exits_are_those_of_each_object_alone(
    frames: list[list[tuple[str, tuple[float, float, float, float]]]],
) -> None:
    count = len(frames[0])
    exits = Exits(CAMERA, count)
    followed = [
        exits.follow(
            np.array([state for state, _ in frame], dtype="<U8"),
            np.array([box for _, box in frame], dtype=float).reshape(-1, 4),
        )
        for frame in frames
    ]
    for k in range(count):
        side, since = "", -1
        # Compared at the end: results of earlier frames must not change.
        for frame, (sides, counts) in zip(frames, followed, strict=True):
            state, box = frame[k]
            since = since + 1 if state == "out" else -1
            if since == 0:
                side = side_by_hand(box)
            assert (sides[k], counts[k]) == (side, since)


def test_objects_leave_and_come_back_each_at_its_time() -> None:
    inside, left, above = (5.0, 5.0, 9.0, 9.0), (-9.0, 5.0, -5.0, 9.0), (5.0, -9.0, 9.0, -5.0)
    exits, followed = Exits(CAMERA, 2), []
    for frame in ((inside, inside), (left, inside), (left, above), (inside, above), (above, inside)):
        box_xyxy = np.array(frame)
        followed.append(exits.follow(states_of(CAMERA, box_xyxy, np.ones(2)), box_xyxy))
    assert [side.tolist() for side, _ in followed] == [
        ["", ""],
        ["left", ""],
        ["left", "top"],
        ["left", "top"],
        ["top", "top"],
    ]
    assert [since.tolist() for _, since in followed] == [[-1, -1], [0, -1], [1, 0], [-1, 1], [0, -1]]


def test_centres_are_half_their_height_up_and_none_behind_the_camera() -> None:
    T_world_camera = look_down_pose(np.array([0.0, 0.0, 20.0]), 0.3, 0.1, -0.2)
    poses = np.array([pose_on_ground(1.0, 2.0, 0.4), pose_on_ground(-3.0, 0.0, 2.0), pose_on_ground(0.0, 0.0, 0.0)])
    poses[2, 2, 3] = 30.0
    sizes_m = np.array([[4.0, 2.0, 1.5], [0.5, 0.5, 1.8], [1.0, 1.0, 1.0]])
    pixels = centres_px(CAMERA, T_world_camera, poses, sizes_m)
    for k in range(2):
        centre_m = poses[k] @ [0.0, 0.0, 0.5 * sizes_m[k, 2], 1.0]
        np.testing.assert_allclose(pixels[k], project(CAMERA, T_world_camera, centre_m[:3])[0])
    assert np.isnan(pixels[2]).all()
