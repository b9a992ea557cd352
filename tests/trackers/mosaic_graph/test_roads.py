"""The road graph drawn from the mosaic, and cars that drive on it."""

from __future__ import annotations

import itertools

import numpy as np
import pytest

from trackers.kernels.ground_camera import looking_down
from trackers.mosaic_graph.kernels import road_motion as rm
from trackers.mosaic_graph.kernels import road_position as rp
from trackers.mosaic_graph.kernels.road_position import RoadGraph, Roads
from trackers.mosaic_graph.motion_model import CarModel, Instant
from trackers.mosaic_graph.road_graph import build_graph
from trackers.mosaic_graph.road_network import NO_ROADS, roads_about
from trackers.types import CameraModel

HABITS = rm.Habits(
    lateral_acceleration=2.2,
    braking=3.0,
    acceleration=1.8,
    vigour_spread=0.0,
    cornering_spread=0.0,
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
    lane_spread_m=0.0,
    lane_rate=0.0,
    rethink_rate=0.0,
)


def nothing_unseen(points_m: np.ndarray) -> np.ndarray:
    return np.zeros(len(points_m), bool)


def crossing() -> RoadGraph:
    """Four streets, 60 m each, that meet at the origin."""
    ends = 60.0 * np.array([[1, 0], [-1, 0], [0, 1], [0, -1]])
    return build_graph([np.linspace(np.zeros(2), end, 121) for end in ends], nothing_unseen)


def roads_of(graph: RoadGraph) -> Roads:
    return roads_about(graph, np.zeros(2))


def cars(count: int, x_m: float, y_m: float, heading_rad: float, speed_mps: float) -> np.ndarray:
    states = np.zeros((count, rp.COLUMNS))
    states[:, [rp.X, rp.Y, rp.HEADING, rp.SPEED, rp.CRUISE]] = [x_m, y_m, heading_rad, speed_mps, 8.0]
    states[:, [rp.CHOICE, rp.BOUND, rp.LOOK]] = [-1.0, np.nan, 5.0]
    return states


def drive(states: np.ndarray, roads: Roads, frames: int, rng: np.random.Generator) -> None:
    for _ in range(frames):
        rm.drive(
            states, roads, HABITS, 1 / 15, rng.normal(size=(len(states), rm.NORMALS)), rng.random((len(states), 7))
        )


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
    graph = build_graph([*main, spur, beyond_gap], nothing_unseen)
    assert graph.points_m[:, 1].max() < 1.0
    assert ((graph.points_m[:, 0] > 64) & (graph.points_m[:, 0] < 76)).any()


def test_every_dead_end_is_extended_whatever_the_order_of_the_lines() -> None:
    """A street with a gap, and another that ends just before its middle: both gaps are closed."""
    across = np.linspace([0.0, -60.0], [0.0, 60.0], 241)
    side_street = np.linspace([-60.0, 20.0], [-15.0, 20.0], 91)
    beyond_gap = np.linspace([0.0, 80.0], [0.0, 140.0], 121)
    lengths = []
    for lines in itertools.permutations([across, side_street, beyond_gap]):
        graph = build_graph(list(lines), nothing_unseen)
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
    # Right-hand lanes: cars that turned left drive north on the east side.
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
    habits = HABITS._replace(urge_spread=1.0, cruise_spread_mps=2.0)
    for _ in range(150):
        rm.drive(states, NO_ROADS, habits, 1 / 15, rng.normal(size=(4000, rm.NORMALS)), rng.random((4000, 7)))
    assert states[:, rp.URGE].std() == pytest.approx(1.0, rel=0.06)
    assert states[:, rp.CRUISE].std() == pytest.approx(2.0, rel=0.06)
    assert states[:, rp.CRUISE].mean() == pytest.approx(8.0, abs=0.2)


def test_on_a_straight_road_a_car_reaches_its_desired_speed() -> None:
    long = build_graph([np.column_stack([np.linspace(-300.0, 300.0, 601), np.zeros(601)])], nothing_unseen)
    roads = roads_about(long, np.zeros(2))
    rng = np.random.default_rng(9)
    states = cars(50, -100.0, -1.75, 0.0, 9.0)
    states[:, rp.CRUISE] = 14.0
    states[:, rp.ON_ROAD] = 1
    rp.associate(states, roads, rng.random(50))
    for _ in range(150):
        states[:, rp.CRUISE] = 14.0
        rm.drive(
            states, roads, HABITS._replace(cruise_rate=0.0), 1 / 15, np.zeros((50, rm.NORMALS)), rng.random((50, 7))
        )
    np.testing.assert_allclose(states[:, rp.SPEED], 14.0, atol=0.3)


def test_far_from_a_crossing_a_car_has_no_decisions_for_it() -> None:
    rng = np.random.default_rng(10)
    roads = roads_of(crossing())
    states = cars(20, -50.0, -1.8, 0.0, 8.0)
    states[:, rp.ON_ROAD] = 1
    states[:, [rp.BOUND, rp.HALTS]] = [1.57, 1.0]
    rp.associate(states, roads, rng.random(20))
    drive(states, roads, 1, rng)
    assert np.isnan(states[:, rp.BOUND]).all()
    assert (states[:, rp.HALTS] == 0.0).all()


def test_redrawn_roads_do_not_end_the_turn_of_a_free_car() -> None:
    model = CarModel(
        np.zeros(2),
        0.0,
        HABITS,
        born_share=0.1,
        detection_probability=0.6,
        miss_counts=True,
        detection_deviation_m=0.25,
        border_m=2.0,
    )
    states = cars(400, -30.0, -2.0, 0.1, 4.0)
    states[:, [rp.TURN, rp.CURVE]] = [1.2, 0.1]
    none = np.empty(0)
    instant = Instant(
        dt_s=1 / 15,
        camera=looking_down(CameraModel(640, 480, 686.0), 0.1),
        roads=roads_of(crossing()),
        roads_are_new=True,
        candidates_m=np.empty((0, 2)),
        axes_rad=none,
        log_ratios=none,
        vague_m=none,
        births=(),
    )
    after = model.predict(states, instant, np.random.default_rng(11))
    assert (after[:, rp.ON_ROAD] == 0).all()
    goes_on = after[:, rp.TURN] != 0.0
    assert 0.75 < goes_on.mean() < 1.0
    # 4 m/s, and a little more, for 1/15 s on a curvature of 0.1 per m.
    np.testing.assert_allclose(after[goes_on, rp.TURN], 1.2 - 4.0 / 15 * 0.1, atol=0.01)
