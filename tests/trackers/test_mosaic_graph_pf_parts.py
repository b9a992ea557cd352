"""Parts of our tracker: poses, mosaic, road graph, driving, likeness, sightings."""

from __future__ import annotations

import itertools

import numpy as np
import pytest

from sim.optics import PinholeCamera, look_down_pose, project
from tests.trackers.drawn_town import film
from trackers.kernels import oriented_box as ob
from trackers.kernels import road_motion as rm
from trackers.kernels import road_position as rp
from trackers.kernels.roads import NO_ROADS, RoadGraph, Roads
from trackers.mosaic_graph_pf.detector import Candidate
from trackers.mosaic_graph_pf.first_look import WIDTH_TO_LENGTH, apparent_length_px
from trackers.mosaic_graph_pf.ground_camera import GroundCamera, fit_pose, looking_down
from trackers.mosaic_graph_pf.likeness import Likeness
from trackers.mosaic_graph_pf.mosaic import Mosaic, standing_ground
from trackers.mosaic_graph_pf.registration import Registration
from trackers.mosaic_graph_pf.road_graph import build_graph
from trackers.mosaic_graph_pf.road_map import RoadFinder, roads_about
from trackers.mosaic_graph_pf.sightings import Sightings
from trackers.types import CameraModel

_MODEL = CameraModel(640, 480, 686.0)
_ALL_GROUND = np.full((240, 320), 255, np.uint8)
_HABITS = rm.Habits(
    lateral_acceleration=2.2,
    braking=3.0,
    acceleration=1.8,
    cruise_mps=8.0,
    cruise_spread_mps=0.0,
    cruise_rate=0.3,
    urge_spread=0.0,
    urge_rate=0.7,
    curve_spread_per_m=0.0,
    curve_rate=0.5,
    unseen_turns_per_m=0.0,
    speed_noise=0.0,
    heading_noise=0.0,
    position_noise=0.0,
    leave_rate=0.0,
    return_rate=0.0,
    halt_share=0.0,
    halt_s=1.5,
    turn_weight=0.5,
    lane_m=1.75,
    lane_rate=0.0,
    rethink_rate=0.0,
)


def tilted(roll_rad: float = 0.1, pitch_rad: float = -0.15) -> GroundCamera:
    pose = look_down_pose(np.array([3.0, -5.0, 60.0]), 0.7, pitch_rad, roll_rad)
    return GroundCamera(_MODEL, pose, np.array([2e-4, -1e-4]))


def test_without_a_bend_a_camera_projects_as_the_simulators() -> None:
    camera = GroundCamera(_MODEL, tilted().T_world_camera, np.zeros(2))
    points = np.random.default_rng(0).uniform(-30, 30, (10, 2))
    pinhole = PinholeCamera(640, 480, 686.0)
    for height_m in (0.0, 0.7):
        world = np.column_stack([points, np.full(10, height_m)])
        expected = project(pinhole, camera.T_world_camera, world)[0]
        np.testing.assert_allclose(camera.to_picture(points, height_m), expected, atol=1e-8)


def test_picture_and_map_are_each_others_inverse() -> None:
    pixels = np.random.default_rng(1).uniform(-200, 800, (20, 2))
    camera = tilted()
    np.testing.assert_allclose(camera.to_picture(camera.to_map(pixels, 0.7), 0.7), pixels, atol=1e-6)


def test_derivatives_are_the_numerical_ones() -> None:
    camera = tilted()
    for k, derivative in enumerate(camera.derivatives()):
        step = np.zeros(8)
        step[k] = 1e-6
        numerical = (camera.moved(step).H_picture_map() - camera.moved(-step).H_picture_map()) / 2e-6
        np.testing.assert_allclose(derivative, numerical, rtol=1e-4, atol=1e-3)


def test_a_pose_is_found_again_in_spite_of_houses() -> None:
    rng = np.random.default_rng(2)
    camera = tilted()
    map_m = rng.uniform(-25, 25, (150, 2))
    pixels = camera.to_picture(map_m) + rng.normal(0, 0.2, (150, 2))
    pixels[:45] = camera.to_picture(map_m[:45], 8.0)
    start = camera.moved(np.array([0.02, -0.02, 0.03, 1.0, -1.0, 0.5, 0, 0]))
    weak = np.diag([25.0] * 3 + [0.04] * 3 + [1e8] * 2)
    fit = fit_pose(start, map_m, pixels, weak, (16.0, 8.0, 4.0, 3.0, 2.0))
    far = np.array([[60.0, 0.0], [0.0, -60.0], [10.0, 10.0]])
    assert np.linalg.norm(fit.camera.to_picture(far) - camera.to_picture(far), axis=1).max() < 4.0


def test_pictures_are_placed_on_the_mosaic_to_a_pixel() -> None:
    frames = film(3, 30, out=(12, 20), decoys=0)
    first = frames[0]
    metres_per_pixel = first.T_world_camera[2, 3] / first.observation.camera.focal_px
    registration = Registration(first.observation, metres_per_pixel, use_ego=False, use_mosaic=True)
    mosaic = Mosaic(2 * metres_per_pixel)
    mosaic.add(registration.first.small_rgb, registration.camera, _ALL_GROUND)
    marks_px = np.array([[150.0, 120.0], [500.0, 100.0], [320.0, 400.0]])
    on_map = registration.camera.to_map(marks_px)
    pinhole = PinholeCamera(640, 480, first.observation.camera.focal_px)
    from_first = np.linalg.inv(GroundCamera(_MODEL, first.T_world_camera, np.zeros(2)).H_picture_map())
    world = np.column_stack([marks_px, np.ones(3)]) @ from_first.T
    world = world[:, :2] / world[:, 2:]
    for frame in frames[1:]:
        registered = registration.register(frame.observation, mosaic)
        mosaic.add(registered.small_rgb, registered.camera, _ALL_GROUND)
        expected = project(pinhole, frame.T_world_camera, np.column_stack([world, np.zeros(3)]))[0]
        assert np.linalg.norm(registered.camera.to_picture(on_map) - expected, axis=1).max() < 2.5


def test_the_mosaic_shows_what_was_laid_down_and_grows() -> None:
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
def test_a_pose_that_sees_to_the_horizon_lays_nothing_down(pitch_rad: float) -> None:
    picture = np.full((240, 320, 3), 90, np.uint8)
    camera = looking_down(_MODEL, 0.1)
    mosaic = Mosaic(0.2)
    mosaic.add(picture, camera, _ALL_GROUND)
    before = mosaic.count.copy()
    mosaic.add(picture, camera.moved(np.array([pitch_rad, 0, 0, 0, 0, 0, 0, 0])), _ALL_GROUND)
    np.testing.assert_array_equal(mosaic.count, before)


def test_far_from_all_that_was_seen_no_roads_are_drawn() -> None:
    mosaic = Mosaic(0.2)
    mosaic.add(np.full((240, 320, 3), 90, np.uint8), looking_down(_MODEL, 0.1), _ALL_GROUND)
    finder = RoadFinder()
    finder.learn(np.zeros(2))
    assert finder.draw(mosaic, np.array([1000.0, 0.0])).graph.edge_count == 0


def test_the_target_is_hardly_taken_for_ground() -> None:
    camera = looking_down(_MODEL, 0.1)
    weight = standing_ground(camera, None, np.zeros(2), 4.5)
    assert weight[120, 160] == 1
    assert weight[5, 5] == 255


def crossing() -> RoadGraph:
    """Four streets, 60 m each, that meet at the origin."""
    ends = 60.0 * np.array([[1, 0], [-1, 0], [0, 1], [0, -1]])
    return build_graph([np.linspace(np.zeros(2), end, 121) for end in ends])


def roads_of(graph: RoadGraph) -> Roads:
    return roads_about(graph, np.zeros(2))


def cars(count: int, x_m: float, y_m: float, heading_rad: float, speed_mps: float) -> np.ndarray:
    states = np.zeros((count, rp.COLUMNS))
    states[:, [rp.X, rp.Y, rp.HEADING, rp.SPEED, rp.CRUISE]] = [x_m, y_m, heading_rad, speed_mps, 8.0]
    states[:, [rp.CHOICE, rp.LOOK]] = [-1.0, 5.0]
    return states


def drive(states: np.ndarray, roads: Roads, frames: int, rng: np.random.Generator) -> None:
    for _ in range(frames):
        rm.drive(states, roads, _HABITS, 1 / 15, rng.normal(size=(len(states), 7)), rng.random((len(states), 7)))


def test_a_crossing_of_raw_lines_becomes_one_node() -> None:
    graph = crossing()
    degrees = np.bincount(graph.ends.ravel())
    assert sorted(degrees) == [1, 1, 1, 1, 4]
    assert graph.edge_count == 4
    np.testing.assert_allclose(np.linalg.norm(graph.tangents, axis=1), 1.0, atol=1e-6)


def test_short_spurs_are_cut_and_gaps_in_line_bridged() -> None:
    main = [np.linspace([-60.0, 0.0], [0.0, 0.0], 121), np.linspace([0.0, 0.0], [60.0, 0.0], 121)]
    spur = np.linspace([0.0, 0.0], [0.0, 5.0], 11)
    beyond_gap = np.linspace([80.0, 0.0], [140.0, 0.0], 121)
    graph = build_graph([*main, spur, beyond_gap])
    assert graph.points_m[:, 1].max() < 1.0
    assert ((graph.points_m[:, 0] > 64) & (graph.points_m[:, 0] < 76)).any()


def test_every_dead_end_is_drawn_on_whatever_the_order_of_the_lines() -> None:
    """A street with a gap, and another that ends just before its middle: both gaps are closed."""
    across = np.linspace([0.0, -60.0], [0.0, 60.0], 241)
    side_street = np.linspace([-60.0, 20.0], [-15.0, 20.0], 91)
    beyond_gap = np.linspace([0.0, 80.0], [0.0, 140.0], 121)
    lengths = []
    for lines in itertools.permutations([across, side_street, beyond_gap]):
        graph = build_graph(list(lines))
        assert ((np.abs(graph.points_m[:, 0] + 8) < 4) & (np.abs(graph.points_m[:, 1] - 20) < 1)).any()
        assert ((graph.points_m[:, 1] > 64) & (graph.points_m[:, 1] < 76)).any()
        lengths.append(len(graph.points_m))
    assert max(lengths) - min(lengths) <= 4


def test_cars_keep_their_lane_and_take_every_way_at_a_crossing() -> None:
    rng = np.random.default_rng(5)
    roads = roads_of(crossing())
    states = cars(2000, -50.0, -1.8, 0.0, 8.0)
    rp.associate(states, roads, rng.random(2000))
    assert (states[:, rp.ON_ROAD] == 1).mean() == pytest.approx(
        np.exp(-0.5 * 1.8) / (np.exp(-0.5 * 1.8) + rp.FREE_WEIGHT), abs=0.05
    )
    states[:, rp.ON_ROAD] = 1
    rp.associate(states, roads, rng.random(2000))
    assert (states[:, rp.ON_ROAD] == 1).all()
    drive(states, roads, 30, rng)
    np.testing.assert_allclose(states[:, rp.Y], -1.8, atol=0.4)
    drive(states, roads, 125, rng)
    straight = states[:, rp.X] > 15
    left, right = states[:, rp.Y] > 10, states[:, rp.Y] < -10
    assert np.mean(straight) == pytest.approx(0.5, abs=0.06)
    assert np.mean(left) == pytest.approx(0.25, abs=0.06)
    assert np.mean(right) == pytest.approx(0.25, abs=0.06)
    # Right-hand lanes: those who turned left drive north on the east side.
    assert np.median(states[left, rp.X]) == pytest.approx(1.8, abs=1.0)


def test_cars_slow_down_for_a_turn_and_not_for_going_straight() -> None:
    rng = np.random.default_rng(6)
    roads = roads_of(crossing())
    states = cars(500, -40.0, -1.8, 0.0, 8.0)
    states[:, rp.ON_ROAD] = 1
    rp.associate(states, roads, rng.random(500))
    slowest = np.full(500, np.inf)
    for _ in range(120):
        drive(states, roads, 1, rng)
        slowest = np.minimum(slowest, states[:, rp.SPEED])
    straight = states[:, rp.X] > 15
    assert slowest[straight].min() > 6.5
    assert slowest[~straight].max() < 5.0


def test_without_roads_a_car_goes_straight_on() -> None:
    states = cars(3, 0.0, 0.0, 0.5, 8.0)
    drive(states, NO_ROADS, 30, np.random.default_rng(7))
    np.testing.assert_allclose(states[:, :2], 16.0 * np.array([[np.cos(0.5), np.sin(0.5)]] * 3), atol=1e-9)


def test_a_free_cars_urge_has_the_spread_it_should() -> None:
    rng = np.random.default_rng(8)
    states = cars(4000, 0.0, 0.0, 0.0, 30.0)
    habits = _HABITS._replace(urge_spread=1.0, cruise_spread_mps=2.0)
    for _ in range(150):
        rm.drive(states, NO_ROADS, habits, 1 / 15, rng.normal(size=(4000, 7)), rng.random((4000, 7)))
    assert states[:, rp.URGE].std() == pytest.approx(1.0, rel=0.06)
    assert states[:, rp.CRUISE].std() == pytest.approx(2.0, rel=0.06)
    assert states[:, rp.CRUISE].mean() == pytest.approx(8.0, abs=0.2)


@pytest.mark.parametrize("heading_rad", [0.0, 0.4, 0.9, 1.5])
def test_the_length_of_a_car_is_read_off_its_upright_box(heading_rad: float) -> None:
    c, s = np.cos(heading_rad), np.sin(heading_rad)
    width, height = 40 * (c + WIDTH_TO_LENGTH * s), 40 * (s + WIDTH_TO_LENGTH * c)
    assert apparent_length_px(np.array([10, 20, 10 + width, 20 + height])) == pytest.approx(40.0, rel=1e-6)


def measures(inside: float, mismatch: float, moved: float) -> np.ndarray:
    result = np.zeros(ob.MEASURES)
    result[[ob.INSIDE, ob.AROUND, ob.MISMATCH, ob.MOVED, ob.KNOWN]] = [inside, -2.0, mismatch, moved, 1.0]
    return result


def test_likeness_learns_what_this_target_is_like() -> None:
    likeness = Likeness()
    grey = measures(1.5, 12.0, 25.0)
    before = likeness.log_ratio(grey)
    for _ in range(30):
        likeness.learn_target(grey)
        likeness.learn_rest(measures(0.0, 35.0, 8.0))
    assert likeness.log_ratio(grey) > max(before, 2.0)
    assert likeness.log_ratio(measures(-3.0, 45.0, 5.0)) < -4.0


def candidate(x_m: float, log_ratio: float) -> Candidate:
    return Candidate(np.array([x_m, 0.0]), 0.0, log_ratio, np.zeros(ob.MEASURES))


def test_a_sighting_is_followed_and_its_evidence_is_bounded() -> None:
    sightings = Sightings()
    for k in range(40):
        sightings.update([candidate(0.5 * k, 3.0), candidate(200.0, -5.0)], 1 / 15)
    assert len(sightings.current) == 1
    followed = sightings.current[0]
    assert followed.velocity_mps[0] == pytest.approx(7.5, rel=0.05)
    assert followed.evidence == pytest.approx(12.0, rel=0.01)
    for _ in range(6):
        sightings.update([], 1 / 15)
    assert sightings.current == []


def test_what_is_seen_beside_the_target_is_ruled_out() -> None:
    sightings = Sightings()
    for _ in range(10):
        sightings.update([candidate(0.0, 4.0), candidate(30.0, 4.0)], 1 / 15)
        target, other = sightings.current
        sightings.rule_out_others(target)
    assert target.log_ratio == pytest.approx(4.0)
    assert other.log_ratio < 1.0
