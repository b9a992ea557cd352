"""Distances, candidates and occlusion from stereo pairs drawn by hand."""

from __future__ import annotations

from dataclasses import replace

import cv2
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from tests.trackers.drawn_people import BLUE, CAMERA, GREY, LEVEL, Board, observation, person_box
from trackers.light_adaptive_stereo.candidates import CandidateParameters, below_head_top
from trackers.light_adaptive_stereo.matching import StereoMatcher
from trackers.light_adaptive_stereo.occlusion import (
    Occlusion,
    OcclusionParameters,
    OcclusionState,
    OtherPeople,
    assign,
    share_before,
)
from trackers.light_adaptive_stereo.person_kalman import PersonKalman
from trackers.light_adaptive_stereo.robot_frame import Mounting, points_m
from trackers.light_adaptive_stereo.stereo_view import StereoView, see
from trackers.types import CameraModel, Observation


def view_of(frame: Observation) -> StereoView:
    view, _ = see(frame, StereoMatcher(), LEVEL, CandidateParameters())
    assert view is not None
    return view


def view_boards(*boards: Board, **drawn: float) -> StereoView:
    return view_of(observation(boards, **drawn))


@pytest.mark.parametrize("ahead_m", [1.2, 2.0, 3.1, 4.6, 6.0])
def test_distances_are_right_within_three_per_cent(ahead_m):
    depth_m = view_boards(Board(ahead_m, 0.0, BLUE, 20.0, 10.0, head=False)).depth_m
    assert depth_m.shape == (240, 320)
    assert np.isfinite(depth_m).mean() > 0.9
    assert np.nanmedian(depth_m[:120]) == pytest.approx(ahead_m, rel=0.03)


def test_points_lie_on_the_ground_and_on_the_wall():
    points = view_boards(wall_m=5.0).points_m
    assert np.nanmedian(points[220:, 100:, 2]) == pytest.approx(0.0, abs=0.03)
    assert np.nanmedian(points[:60, 60:, 0]) == pytest.approx(5.0, rel=0.02)
    assert np.nanmedian(points[100:120, 60:160, 1]) > 0.3


@pytest.mark.parametrize("gain", [0.9, 1.1])
@pytest.mark.parametrize("lower_px", [0.0, 0.7])
def test_cameras_may_differ_a_little(gain, lower_px):
    frame = observation([Board(3.0, 0.0)], wall_m=7.0)
    moved = cv2.warpAffine(frame.right_rgb, np.array([[1.0, 0, 0], [0, 1.0, lower_px]]), (640, 480), borderMode=2)
    view = view_of(replace(frame, right_rgb=np.clip(gain * moved, 0, 255).astype(np.uint8)))
    assert [candidate.depth_m for candidate in view.candidates] == pytest.approx([3.0], rel=0.03)


@pytest.mark.parametrize("person", [Board(1.6, 0.2), Board(3.0, 0.0), Board(4.5, -0.8, BLUE, 0.55, 1.85)])
def test_a_person_is_found_with_the_right_size(person):
    (found,) = view_boards(person).candidates
    assert found.place_m == pytest.approx([person.ahead_m, person.left_m], abs=0.04 * person.ahead_m)
    assert found.width_m == pytest.approx(person.width_m, abs=0.12)
    assert found.height_m == pytest.approx(person.height_m, abs=0.1)
    assert found.depth_m == pytest.approx(person.ahead_m, rel=0.03)
    assert found.box_xyxy == pytest.approx(person_box(person), abs=50.0 / person.ahead_m)
    assert found.centre_px == pytest.approx(0.5 * (person_box(person)[:2] + person_box(person)[2:]), abs=12)
    assert not found.cut
    rows, columns = np.divmod(found.pixels, 320)
    x_min, y_min, x_max, y_max = person_box(person) / 2
    inside = (columns > x_min - 5) & (columns < x_max + 5) & (rows > y_min - 5) & (rows < y_max + 1)
    assert inside.mean() > 0.97


def test_borders_cut_people_off():
    at_the_side = view_boards(Board(3.0, 1.85)).candidates
    assert [candidate.cut for candidate in at_the_side] == [True]
    (near,) = view_boards(Board(1.0, -0.1, BLUE, 0.5, 1.8)).candidates
    assert near.top_cut
    assert near.height_m >= CandidateParameters().usual_height_m


@pytest.mark.parametrize(
    "board",
    [
        Board(3.0, 0.0, GREY, 60.0, 20.0, head=False),
        Board(3.0, 0.0, GREY, 1.6, 1.8, head=False),
        Board(3.0, 0.2, GREY, 0.5, 0.8, head=False),
        Board(3.0, 0.0, GREY, 0.1, 1.8, head=False),
    ],
    ids=["wall", "cupboard", "box", "post"],
)
def test_what_is_no_person(board):
    assert view_boards(board).candidates == []


def test_a_person_before_a_wall_is_apart_from_it():
    (found,) = view_boards(Board(3.0, 0.0), wall_m=3.5).candidates
    assert found.width_m == pytest.approx(0.5, abs=0.12)


@pytest.mark.parametrize(("over_the_head", "top_m"), [("nothing", 1.7), ("even sky", 1.7), ("a pillar", 2.15)])
def test_what_is_wide_again_over_the_head_is_no_part_of_a_person(over_the_head, top_m):
    height_m, left_m = np.meshgrid(np.arange(0.2, 2.15, 0.01), np.arange(-0.3, 0.3, 0.01), indexing="ij")
    head = (height_m > 1.45) & (height_m < 1.7)
    half_m = np.where(head & (over_the_head != "a pillar"), 0.1, 0.25)
    shown = (np.abs(left_m) <= half_m) & ((height_m < 1.7) | (over_the_head != "nothing"))
    points = np.stack([np.full_like(left_m, 2.5), left_m, height_m], axis=-1).astype(np.float32)
    # A pixel is a centimetre.
    kept = below_head_top(np.flatnonzero(shown), points, 250.0, CandidateParameters())
    assert points.reshape(-1, 3)[kept, 2].max() == pytest.approx(top_m, abs=0.06)
    assert points.reshape(-1, 3)[kept, 2].min() == pytest.approx(0.2, abs=0.01)


def test_small_pictures_are_not_made_smaller():
    frame, person = observation([Board(2.5, 0.2)]), Board(2.5, 0.2)
    left, right = (
        cv2.resize(each, (320, 240), interpolation=cv2.INTER_AREA) for each in (frame.image_rgb, frame.right_rgb)
    )
    camera = CameraModel(320, 240, 0.5 * CAMERA.focal_px, CAMERA.baseline_m)
    view = view_of(replace(frame, image_rgb=left, right_rgb=right, camera=camera))
    assert view.depth_m.shape == (240, 320)
    (found,) = view.candidates
    assert found.depth_m == pytest.approx(2.5, rel=0.03)
    assert found.box_xyxy == pytest.approx(0.5 * person_box(person), abs=10)


@pytest.mark.parametrize("apart_m", [0.9, 0.56])
def test_two_people_side_by_side_are_two(apart_m):
    found = view_boards(Board(3.0, 0.5 * apart_m), Board(3.0, -0.5 * apart_m, BLUE)).candidates
    assert sorted(candidate.place_m[1] for candidate in found) == pytest.approx(
        [-0.5 * apart_m, 0.5 * apart_m], abs=0.1
    )


def test_the_nearer_one_comes_first_and_hides():
    near, far = Board(2.0, 0.1), Board(3.5, -0.3, BLUE)
    view = view_boards(near, far)
    assert [candidate.depth_m for candidate in view.candidates] == pytest.approx([2.0, 3.5], rel=0.04)

    def hidden(place_m, width_m=0.5):
        return share_before(view.depth_m, np.array(place_m), 1.7, width_m, LEVEL, CAMERA, OcclusionParameters())

    assert hidden([2.0, 0.1]) < 0.05
    assert 0.15 < hidden([3.5, -0.3]) < 0.6
    assert hidden([4.0, 0.2]) > 0.9
    assert hidden([4.0, -2.4]) < 0.05
    assert hidden([4.0, 30.0]) == 0.0
    assert hidden([-3.0, 0.0]) == 0.0


def test_without_texture_or_right_picture_there_is_nothing():
    even = np.full((480, 640, 3), 90, np.uint8)
    blank = replace(observation([]), image_rgb=even, right_rgb=even)
    assert view_of(blank).candidates == []
    assert see(replace(blank, right_rgb=None), StereoMatcher(), LEVEL, CandidateParameters()) == (None, 0.0)


def test_errors_say_what_was_expected():
    frame = observation([])
    with pytest.raises(ValueError, match=r"right_rgb: expected .* \(480, 640, 3\), got \(240, 640, 3\)"):
        view_of(replace(frame, right_rgb=frame.right_rgb[:240]))
    with pytest.raises(ValueError, match=r"camera\.baseline_m: expected"):
        view_of(replace(frame, camera=replace(CAMERA, baseline_m=None)))


def test_mounting_by_a_measured_pose():
    T_world_camera = np.eye(4)
    T_world_camera[:3, :3] = Rotation.from_euler("z", 130, degrees=True).as_matrix() @ LEVEL.R_robot_camera
    T_world_camera[:3, 3] = 7.0, -4.0, 1.3
    mounting = Mounting.from_pose(T_world_camera)
    assert mounting.height_m == 1.3
    np.testing.assert_allclose(mounting.R_robot_camera, LEVEL.R_robot_camera, atol=1e-12)


def test_pixels_and_points_go_both_ways():
    rng = np.random.default_rng(3)
    tilted = Mounting(1.1, Rotation.from_rotvec([0.05, -0.1, 0.02]).as_matrix() @ LEVEL.R_robot_camera)
    depth_m = rng.uniform(1.0, 5.0, (240, 320)).astype(np.float32)
    points = points_m(depth_m, CAMERA, tilted).astype(float)
    for row, column in rng.integers(0, 240, (20, 2)):
        pixel_px = 2.0 * np.array([column + 0.5, row + 0.5])
        assert tilted.pixels(points[row, column], CAMERA) == pytest.approx(pixel_px, abs=1e-2)
        assert tilted.depth_m(points[row, column]) == pytest.approx(depth_m[row, column], abs=1e-4)
        assert tilted.place_at(pixel_px, depth_m[row, column], CAMERA) == pytest.approx(points[row, column], abs=1e-4)


def test_kalman_filter_learns_a_walk():
    rng = np.random.default_rng(5)
    walker = PersonKalman(np.array([3.0, 0.0]), acceleration_mps2=0.5, place_noise_m=0.05)
    for frame in range(1, 60):
        walker.predict(1 / 15)
        walker.correct(np.array([3.0 + frame / 15, -0.5 * frame / 15]) + rng.normal(0, 0.05, 2))
    assert walker.velocity_mps == pytest.approx([1.0, -0.5], abs=0.2)
    spread_m2 = walker.P[0, 0]
    walker.predict(1.0)
    assert walker.place_m == pytest.approx([3.0 + 59 / 15 + 1.0, -0.5 * (59 / 15 + 1.0)], abs=0.25)
    assert walker.P[0, 0] > spread_m2


def test_states_of_an_occlusion_in_their_order():
    state = OcclusionState(OcclusionParameters())
    steps = [
        (0.0, 0.0, True, Occlusion.NONE),
        (0.0, 0.2, True, Occlusion.STARTING),
        (0.3, 0.5, True, Occlusion.STARTING),
        (0.8, 0.7, True, Occlusion.OCCLUDED),
        (0.2, 0.4, False, Occlusion.ENDING),
        (0.0, 0.0, False, Occlusion.ENDING),
        (0.0, 0.2, True, Occlusion.ENDING),
        (0.0, 0.0, True, Occlusion.NONE),
        (0.0, 0.2, True, Occlusion.STARTING),
        (0.0, 0.0, True, Occlusion.NONE),
    ]
    for hidden, beside, found_last, expected in steps:
        assert state.update(hidden, beside, found_last) is expected
        assert state.template_may_change == (expected is Occlusion.NONE)


def test_assignment_is_the_least_sum_within_limits():
    assert assign(np.array([[0.3, 0.2]]), np.array([0.4])) == [1]
    assert assign(np.array([[0.5, 0.6]]), np.array([0.4])) == [None]
    assert assign(np.empty((2, 0)), np.array([0.4, 0.4])) == [None, None]
    # The candidate fits the other person better than the target.
    assert assign(np.array([[0.3], [0.05]]), np.array([0.4, 0.6])) == [None, 0]
    assert assign(np.array([[0.2, 0.3], [0.05, 2.0]]), np.array([0.4, 0.6])) == [1, 0]


def test_other_people_are_tracked_and_dropped():
    candidates = view_boards(Board(2.0, 0.5), Board(3.0, -0.5, BLUE)).candidates
    others = OtherPeople(OcclusionParameters(), acceleration_mps2=1.0, place_noise_m=0.1)
    none = np.full(2, 9.0)
    others.correct(candidates, 1, [], np.array([3.0, -0.5]))
    np.testing.assert_allclose(others.places_m, [candidates[0].place_m])
    target, associated = others.associate(candidates, none, 0.4, 1.0)
    assert (target, associated) == (None, [0])
    # While the target is not found, no new person is tracked at its expected position.
    others.correct(candidates, None, associated, np.array([3.0, -0.4]))
    assert len(others.places_m) == 1
    for _ in range(20):
        others.predict(0.1)
        others.correct([], None, [None] * len(others.places_m), np.array([3.0, 0.0]))
    assert len(others.places_m) == 0
