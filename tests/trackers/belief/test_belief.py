"""Beliefs from sightings, checked against a camera and a target with known motion."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from sim.optics import PinholeCamera, look_down_pose, project
from trackers.belief.features import FEATURES, FeatureFilter
from trackers.belief.kernel import BELIEF, SECTORS, SIGHTING, TRAIL, TRAIL_STEP_M, densest_window, update_beliefs
from trackers.belief.sighting import BeliefFilter, sighting_of
from trackers.types import (
    CameraCommand,
    CameraModel,
    Carrier,
    CommandAxis,
    EgoPose,
    Estimate,
    Observation,
    SteeredCamera,
)

HELICOPTER = Carrier("helicopter", (CommandAxis("forward_mps", 25.0, 40.0),), "down")
CAMERA = PinholeCamera(640, 480, 700.0)
MODEL = CameraModel(640, 480, 700.0)
RATE_HZ = 15.0
NOTHING = np.zeros((480, 640, 3), np.uint8)


def seen_from(T_world_camera: NDArray[np.float64], frame: int = 0) -> Observation:
    return Observation(NOTHING, frame / RATE_HZ, MODEL, ego=EgoPose(T_world_camera))


def estimate_of(T_world_camera: NDArray[np.float64], place_m: NDArray[np.float64], probability: float) -> Estimate:
    pixel = project(CAMERA, T_world_camera, np.append(place_m, 0.0)[None])[0][0]
    return Estimate(pixel, in_view_probability=probability)


@settings(deadline=None)  # the first call compiles
@given(st.floats(-3, 3), st.floats(-0.4, 0.4), st.floats(-0.4, 0.4), st.floats(-30, 30), st.floats(-30, 30))
def test_a_place_is_found_whatever_the_attitude(yaw: float, pitch: float, roll: float, x: float, y: float) -> None:
    pose = look_down_pose(np.array([5.0, -3.0, 60.0]), yaw, pitch, roll)
    place = np.array([x, y])
    sighting = sighting_of("down", seen_from(pose), estimate_of(pose, place, 1.0))[0]
    np.testing.assert_allclose([sighting["x_m"], sighting["y_m"]], place, atol=1e-6)
    assert sighting["half_right_m"] == pytest.approx(60.0 * 320 / 700)


def test_the_robot_measures_by_depth() -> None:
    heading = 0.7
    R = np.column_stack([[np.sin(heading), -np.cos(heading), 0], [0, 0, -1], [np.cos(heading), np.sin(heading), 0]])
    T = np.eye(4)
    T[:3, :3], T[:3, 3] = R, [1.0, 2.0, 1.2]
    place = np.array([1.0, 2.0]) + 3.0 * np.array([np.cos(heading), np.sin(heading)])
    # To the right by 70 pixels at 3 m: 0.3 m.
    place += 0.3 * np.array([np.sin(heading), -np.cos(heading)])
    sighting = sighting_of("ahead", seen_from(T), Estimate(np.array([390.0, 240.0]), depth_m=3.0))
    np.testing.assert_allclose([sighting["x_m"][0], sighting["y_m"][0]], place, atol=1e-9)
    belief_filter = BeliefFilter("ahead")
    belief = belief_filter.update(seen_from(T), Estimate(np.array([390.0, 240.0]), depth_m=3.0))[0]
    assert belief["ahead_m"] == pytest.approx(3.0)
    assert belief["right_m"] == pytest.approx(0.3)


def test_motion_of_target_and_carrier_is_followed() -> None:
    belief_filter = BeliefFilter("down")
    velocity, own = np.array([6.0, -4.0]), np.array([0.0, 8.0])
    for frame in range(60):
        carrier = own * frame / RATE_HZ
        pose = look_down_pose(np.array([*carrier, 60.0]), np.pi / 2, 0.0, 0.0)
        place = np.array([10.0, 5.0]) + velocity * frame / RATE_HZ
        belief = belief_filter.update(seen_from(pose, frame), estimate_of(pose, place, 1.0))[0]
    # The helicopter heads along world y: ahead is y, right is x.
    assert belief["velocity_ahead_mps"] == pytest.approx(-4.0, abs=0.05)
    assert belief["velocity_right_mps"] == pytest.approx(6.0, abs=0.05)
    assert belief["own_ahead_mps"] == pytest.approx(8.0, abs=0.05)
    assert belief["own_right_mps"] == pytest.approx(0.0, abs=0.05)
    assert belief["seconds_since_seen"] == 0.0


def test_what_is_lost_is_timed_and_searched_for() -> None:
    belief_filter = BeliefFilter("down")
    pose = look_down_pose(np.array([0.0, 0.0, 60.0]), 0.0, 0.0, 0.0)
    belief_filter.update(seen_from(pose), estimate_of(pose, np.zeros(2), 1.0))
    for frame in range(1, 16):
        # The camera goes east, where nothing is.
        pose = look_down_pose(np.array([2.0 * frame, 0.0, 60.0]), 0.0, 0.0, 0.0)
        belief = belief_filter.update(seen_from(pose, frame), estimate_of(pose, np.zeros(2), 0.1))[0]
    assert belief["seconds_since_seen"] == pytest.approx(1.0)
    assert belief["searched"].argmax() == 0
    assert belief["searched"][0] == 1.0
    assert (belief["searched"][1:] == 0.0).all()
    pose = look_down_pose(np.array([0.0, 0.0, 60.0]), 0.0, 0.0, 0.0)
    belief = belief_filter.update(seen_from(pose, 16), estimate_of(pose, np.zeros(2), 1.0))[0]
    assert belief["seconds_since_seen"] == 0.0
    assert (belief["searched"] == 0.0).all()


def test_without_an_estimate_the_belief_stays() -> None:
    belief_filter = BeliefFilter("down")
    pose = look_down_pose(np.array([0.0, 0.0, 60.0]), 0.0, 0.0, 0.0)
    belief_filter.update(seen_from(pose), estimate_of(pose, np.array([3.0, 4.0]), 1.0))
    belief = belief_filter.update(seen_from(pose, 1), Estimate(np.full(2, np.nan)))[0]
    assert belief["known"] == 0.0
    assert belief["in_view_probability"] == 0.0
    np.testing.assert_allclose([belief["x_m"], belief["y_m"]], [3.0, 4.0], atol=1e-6)


def test_the_densest_window_holds_most() -> None:
    rng = np.random.Generator(np.random.PCG64(0))
    few, many = rng.normal([30.0, 0.0], 1.0, (300, 2)), rng.normal([-20.0, 10.0], 1.0, (700, 2))
    places = np.concatenate([few, many])
    x, y, share = densest_window(places, np.full(1000, 1e-3), 6.0, 40)
    assert np.hypot(x + 20.0, y - 10.0) < 0.5
    assert share == pytest.approx(0.7, abs=0.01)
    weights = np.concatenate([np.full(300, 0.9 / 300), np.full(700, 0.1 / 700)])
    x, y, share = densest_window(places, weights, 6.0, 40)
    assert np.hypot(x - 30.0, y) < 0.5
    assert share == pytest.approx(0.9, abs=0.01)


def test_the_posterior_is_summarised_on_the_ground() -> None:
    rng = np.random.Generator(np.random.PCG64(1))
    pose = look_down_pose(np.array([0.0, 0.0, 70.0]), 0.3, 0.1, -0.1)
    places = rng.normal([8.0, -5.0], 2.0, (800, 2))
    pixels = project(CAMERA, pose, np.column_stack([places, np.zeros(800)]))[0]
    sighting = sighting_of("down", seen_from(pose), Estimate(pixels.mean(axis=0), particles_px=pixels))[0]
    assert sighting["spread_m"] == pytest.approx(np.sqrt(0.5 * places.var(axis=0).sum()), rel=1e-6)
    np.testing.assert_allclose([sighting["densest_x_m"], sighting["densest_y_m"]], places.mean(axis=0), atol=0.3)
    assert sighting["densest_share"] > 0.99


@settings(deadline=None)  # the first call compiles
@given(
    st.lists(
        st.tuples(st.floats(-1e4, 1e4), st.floats(-1e4, 1e4), st.floats(0, 1), st.floats(-1.2, 1.2), st.booleans()),
        min_size=1,
        max_size=12,
    )
)
def test_features_are_finite_and_within_their_range(looks: list[tuple[float, float, float, float, bool]]) -> None:
    feature_filter = FeatureFilter(HELICOPTER)
    for frame, (x, y, probability, pitch, silent) in enumerate(looks):
        pose = look_down_pose(np.array([0.0, 0.0, 60.0]), 0.1 * frame, pitch, 0.0)
        position = np.full(2, np.nan) if silent else np.array([x, y])
        estimate = Estimate(position, in_view_probability=probability)
        features = feature_filter.update(seen_from(pose, frame), estimate, CameraCommand(forward_mps=99.0))
        assert features.shape == (len(FEATURES),)
        assert np.isfinite(features).all()
        assert (np.abs(features) <= 1.0).all()


def test_features_are_where_their_names_say() -> None:
    feature_filter = FeatureFilter(HELICOPTER)
    pose = look_down_pose(np.array([0.0, 0.0, 70.0]), 0.0, 0.0, 0.0)
    # World x is ahead; half the picture is 24 m high and 32 m wide.
    estimate = estimate_of(pose, np.array([12.0, -16.0]), 0.75)
    features = dict(zip(FEATURES, feature_filter.update(seen_from(pose), estimate, CameraCommand(12.5)), strict=True))
    assert features["ahead"] == pytest.approx(0.5 / 1.5, abs=1e-5)
    assert features["right"] == pytest.approx(0.5 / 1.5, abs=1e-5)
    assert features["in_view_probability"] == pytest.approx(0.75)
    assert features["height"] == pytest.approx((70 / 60) / (1 + 70 / 60), abs=1e-5)
    assert features["command_forward"] == pytest.approx(0.5)
    assert features["known"] == 1.0
    assert sum(name.startswith("searched_") for name in FEATURES) == SECTORS


def turned_to(place_m: NDArray[np.float64], aim_m: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return T_world_camera of a camera on a head at a place (3,), without roll, that looks at a point (3,)."""
    ahead = (aim_m - place_m) / np.linalg.norm(aim_m - place_m)
    right = np.array([ahead[1], -ahead[0], 0.0]) / np.hypot(*ahead[:2])
    T = np.eye(4)
    T[:3, :3], T[:3, 3] = np.column_stack([right, np.cross(ahead, right), ahead]), place_m
    return T


@settings(deadline=None)
@given(st.floats(-3, 3), st.floats(2, 80), st.floats(1, 40), st.floats(-3, 3), st.floats(-3, 3))
def test_a_camera_that_looks_around_finds_places_on_the_ground(
    bearing: float, distance: float, height: float, x: float, y: float
) -> None:
    mast = np.array([5.0, -3.0, height])
    ahead = np.array([np.cos(bearing), np.sin(bearing), 0.0])
    pose = turned_to(mast, mast + distance * ahead - [0, 0, height])
    place = (mast + distance * ahead)[:2] + 0.1 * distance * np.array([x, y]) / 3
    sighting = sighting_of("around", seen_from(pose), estimate_of(pose, place, 1.0))[0]
    np.testing.assert_allclose([sighting["x_m"], sighting["y_m"]], place, rtol=1e-6, atol=1e-6)
    assert np.cos(sighting["heading_rad"] - bearing) == pytest.approx(1.0)
    assert sighting["axis_ahead_m"] == pytest.approx(distance)
    assert sighting["axis_right_m"] == pytest.approx(0.0, abs=1e-6 * distance)
    assert sighting["half_right_m"] == pytest.approx(np.hypot(distance, height) * 320 / 700)


def test_a_head_that_looks_straight_down_measures_as_a_camera_below_a_helicopter() -> None:
    pose = look_down_pose(np.array([5.0, -3.0, 60.0]), 0.8, 0.0, 0.0)
    seen, estimate = seen_from(pose), estimate_of(pose, np.array([9.0, 2.0]), 1.0)
    around, down = (sighting_of(looks, seen, estimate)[0] for looks in ("around", "down"))
    for name in down.dtype.names:
        np.testing.assert_allclose(around[name], down[name], atol=1e-9, err_msg=name)


STEERED = CameraModel(320, 240, 500.0)
OVERVIEW = look_down_pose(np.array([0.0, 0.0, 40.0]), 0.0, 0.0, 0.0)


def two_cameras(head: NDArray[np.float64] | None, overview: NDArray[np.float64] | None = OVERVIEW) -> Observation:
    poses = [None if pose is None else EgoPose(pose) for pose in (overview, head)]
    return Observation(NOTHING, 0.0, MODEL, ego=poses[0], steered=SteeredCamera(STEERED, poses[1]))


@settings(deadline=None)
@given(st.floats(-15, 15), st.floats(-10, 10), st.floats(-15, 15), st.floats(-10, 10))
def test_what_one_camera_sees_is_placed_in_the_picture_of_the_steered_one(
    x: float, y: float, aim_x: float, aim_y: float
) -> None:
    head = turned_to(np.array([-30.0, -20.0, 6.0]), np.array([aim_x, aim_y, 0.0]))
    sighting = sighting_of("around", two_cameras(head), estimate_of(OVERVIEW, np.array([x, y]), 0.8))[0]
    np.testing.assert_allclose([sighting["x_m"], sighting["y_m"]], [x, y], atol=1e-6)
    np.testing.assert_allclose([sighting["carrier_x_m"], sighting["carrier_y_m"]], [-30.0, -20.0])
    assert sighting["height_m"] == 6.0
    pixel = project(PinholeCamera(320, 240, 500.0), head, np.array([[x, y, 0.0]]))[0][0]
    np.testing.assert_allclose([sighting["picture_x"], sighting["picture_y"]], pixel / [160, 120] - 1, atol=1e-6)
    assert sighting["in_view_probability"] == 0.8
    box = np.array([300.0, 220.0, 317.5, 230.0])
    with_box = sighting_of("around", two_cameras(head), Estimate(box.reshape(2, 2).mean(axis=0), box_xyxy=box))[0]
    # One metre long as the overview has it, some 17.5 pixels at a height of 40 m.
    there = np.array([with_box["x_m"], with_box["y_m"], 0.0])
    depth = (there - head[:3, 3]) @ head[:3, 2]
    slant = np.linalg.norm(there - OVERVIEW[:3, 3])
    assert with_box["length_share"] == pytest.approx(17.5 * slant / 700 / depth * 500 / 320)


def test_a_target_behind_the_head_is_on_the_side_to_turn_to_and_features_stay_finite() -> None:
    head = turned_to(np.array([-30.0, -20.0, 6.0]), np.array([-60.0, -20.0, 0.0]))
    for y, side in ((-30.0, -1), (-10.0, 1)):
        sighting = sighting_of("around", two_cameras(head), estimate_of(OVERVIEW, np.array([0.0, y]), 1.0))[0]
        assert sighting["picture_x"] * side > 10.0
    carrier = Carrier("head", (CommandAxis("pan_rad_s", 1.0, 4.0),), "around")
    sky = turned_to(np.array([0.0, 0.0, 0.0]), np.array([5.0, 0.0, 9.0]))
    level = turned_to(np.array([0.0, 0.0, -2.0]), np.array([5.0, 0.0, -2.0]))
    for pose in (head, sky, level):
        for observation in (two_cameras(pose), seen_from(pose), two_cameras(head, pose)):
            for position in (np.array([320.0, 240.0]), np.array([-1e7, 1e7]), np.full(2, np.nan)):
                features = FeatureFilter(carrier).update(observation, Estimate(position), CameraCommand())
                assert np.isfinite(features).all()


def test_without_both_poses_nothing_is_known_of_the_steered_picture() -> None:
    head = turned_to(np.array([-30.0, -20.0, 6.0]), np.array([0.0, 0.0, 0.0]))
    for observation in (two_cameras(None), two_cameras(head, None)):
        assert sighting_of("around", observation, Estimate(np.array([300.0, 200.0])))[0]["known"] == 0.0
    alone = Observation(NOTHING, 0.0, MODEL)
    assert sighting_of("around", alone, Estimate(np.array([320.0, 240.0]), depth_m=4.0))[0]["x_m"] == 4.0


def _seen(x_m, y_m, known=1.0):
    sighting = np.zeros(1, SIGHTING)
    for name, value in (("known", known), ("in_view_probability", known), ("x_m", x_m), ("y_m", y_m)):
        sighting[name] = value
    return sighting


def test_the_trail_holds_the_latest_places_a_step_apart():
    belief = np.zeros(1, BELIEF)
    for step in range(400):
        update_beliefs(belief, _seen(0.05 * step, 1.0), 0.1)
    trail_m = np.column_stack([belief["trail_x_m"][0], belief["trail_y_m"][0]])
    assert belief["trail_places"][0] == TRAIL
    assert abs(trail_m[0, 0] - 0.05 * 399) < TRAIL_STEP_M
    steps_m = np.linalg.norm(np.diff(trail_m, axis=0), axis=1)
    assert ((steps_m > TRAIL_STEP_M - 1e-9) & (steps_m < TRAIL_STEP_M + 0.06)).all()
    assert (np.diff(trail_m[:, 0]) < 0).all()


def test_a_target_found_again_elsewhere_keeps_its_velocity():
    belief = np.zeros(1, BELIEF)
    for step in range(60):
        update_beliefs(belief, _seen(0.1 * step, 0.0), 0.1)
    before_mps = float(belief["velocity_x_mps"][0])
    for _ in range(20):
        update_beliefs(belief, _seen(0.0, 0.0, known=0.0), 0.1)
    update_beliefs(belief, _seen(8.0, 2.0), 0.1)
    assert abs(before_mps - 1.0) < 0.05
    assert belief["velocity_x_mps"][0] == before_mps
    assert belief["velocity_y_mps"][0] == 0.0
