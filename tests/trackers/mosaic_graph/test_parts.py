"""Parts of our tracker: poses, mosaic, likeness."""

from __future__ import annotations

import numpy as np
import pytest

from sim.optics import project
from tests.trackers.drawn_town import film
from trackers.kernels.ground_camera import GroundCamera, looking_down
from trackers.mosaic_graph.detector import Likeness
from trackers.mosaic_graph.kernels import oriented_box as ob
from trackers.mosaic_graph.mosaic import Mosaic, standing_ground
from trackers.mosaic_graph.registration import Registration
from trackers.mosaic_graph.road_network import ColourRoads
from trackers.types import CameraModel

_MODEL = CameraModel(640, 480, 686.0)
_ALL_GROUND = np.full((240, 320), 255, np.uint8)


def mark_errors_px(use_mosaic: bool) -> list[float]:
    """Return the largest error of three ground marks in each picture of a film."""
    frames = film(3, 30, out=(12, 20), decoys=0)
    first = frames[0]
    metres_per_pixel = first.T_world_camera[2, 3] / first.observation.camera.focal_px
    registration = Registration(first.observation, first.car_px, metres_per_pixel, use_ego=False, use_mosaic=use_mosaic)
    mosaic = Mosaic(2 * metres_per_pixel)
    mosaic.add(registration.first.small_rgb, registration.camera, _ALL_GROUND)
    marks_px = np.array([[150.0, 120.0], [500.0, 100.0], [320.0, 400.0]])
    on_map = registration.camera.to_map(marks_px)
    pinhole = CameraModel(640, 480, first.observation.camera.focal_px)
    from_first = np.linalg.inv(GroundCamera(_MODEL, first.T_world_camera, np.zeros(2)).H_picture_map())
    world = np.column_stack([marks_px, np.ones(3)]) @ from_first.T
    world = world[:, :2] / world[:, 2:]
    errors = []
    for frame in frames[1:]:
        registered = registration.register(frame.observation, mosaic)
        mosaic.add(registered.small_rgb, registered.camera, _ALL_GROUND)
        expected = project(pinhole, frame.T_world_camera, np.column_stack([world, np.zeros(3)]))[0]
        errors.append(float(np.linalg.norm(registered.camera.to_picture(on_map) - expected, axis=1).max()))
    return errors


@pytest.mark.heavy
def test_pictures_are_registered_to_a_pixel_and_drift_without_the_mosaic() -> None:
    placed, chained = mark_errors_px(use_mosaic=True), mark_errors_px(use_mosaic=False)
    assert max(placed) < 1.5
    assert placed[-1] < 0.5
    assert chained[-1] > 2.0


def test_the_mosaic_shows_the_added_pictures_and_grows() -> None:
    rng = np.random.default_rng(4)
    picture = np.repeat(np.repeat(rng.integers(0, 256, (24, 32, 3)), 10, axis=0), 10, axis=1).astype(np.uint8)
    camera = looking_down(_MODEL, 0.1)
    mosaic = Mosaic(0.2)
    mosaic.add(picture, camera, _ALL_GROUND)
    shape = mosaic.count.shape
    shown, seen = mosaic.render(camera)
    middle = np.s_[20:-20, 20:-20]
    assert seen[middle].min() == 1
    assert np.abs(shown[middle].astype(int) - picture[middle]).mean() < 6
    far = camera.moved(np.array([0, 0, 0, 200.0, 0, 0, 0, 0]))
    mosaic.add(picture, far, _ALL_GROUND)
    assert mosaic.count.shape > shape
    np.testing.assert_array_equal(mosaic.render(camera)[0][middle], shown[middle])


@pytest.mark.parametrize("pitch_rad", [1.15, 1.3, 1.6])
def test_a_picture_with_the_horizon_is_not_added(pitch_rad: float) -> None:
    picture = np.full((240, 320, 3), 90, np.uint8)
    camera = looking_down(_MODEL, 0.1)
    mosaic = Mosaic(0.2)
    mosaic.add(picture, camera, _ALL_GROUND)
    before = mosaic.count.copy()
    mosaic.add(picture, camera.moved(np.array([pitch_rad, 0, 0, 0, 0, 0, 0, 0])), _ALL_GROUND)
    np.testing.assert_array_equal(mosaic.count, before)


def test_far_from_the_seen_ground_no_roads_are_drawn() -> None:
    mosaic = Mosaic(0.2)
    mosaic.add(np.full((240, 320, 3), 90, np.uint8), looking_down(_MODEL, 0.1), _ALL_GROUND)
    finder = ColourRoads()
    finder.learn(np.zeros(2))
    assert finder.draw(mosaic, np.array([1000.0, 0.0])).graph.edge_count == 0


def test_the_target_has_little_weight_as_ground() -> None:
    camera = looking_down(_MODEL, 0.1)
    weight = standing_ground(camera, None, np.zeros(2), 4.5)
    assert weight[120, 160] == 1
    assert weight[5, 5] == 255


def measures(inside: float, mismatch: float, moved: float) -> np.ndarray:
    result = np.zeros(ob.MEASURES)
    result[[ob.INSIDE, ob.AROUND, ob.MISMATCH, ob.MOVED, ob.KNOWN]] = [inside, -2.0, mismatch, moved, 1.0]
    return result


def test_likeness_learns_the_targets_measures() -> None:
    likeness = Likeness()
    grey = measures(1.5, 12.0, 25.0)
    before = likeness.log_ratio(grey)
    for _ in range(30):
        likeness.learn_target(grey)
        likeness.learn_rest(measures(0.0, 35.0, 8.0))
    assert likeness.log_ratio(grey) > max(before, 2.0)
    assert likeness.log_ratio(measures(-3.0, 45.0, 5.0)) < -4.0
