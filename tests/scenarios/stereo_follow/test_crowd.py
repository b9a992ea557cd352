"""Paths without pictures: people keep their distances from each other and from walls, the robot obeys its limits."""

from __future__ import annotations

from functools import lru_cache
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from scenarios.stereo_follow.crowd import Crowd, draw_crowd
from scenarios.stereo_follow.floor_plan import FloorPlan, draw_floor_plan
from scenarios.stereo_follow.presets import PRESETS
from scenarios.stereo_follow.rig import Odometry
from scenarios.stereo_follow.robot import FASTEST_MPS, FASTEST_TURN_RAD_S, Robot
from scenarios.stereo_follow.sight import seen_frames
from scenarios.stereo_follow.walks import STEP_M, at_distance, rounded_way, sideways, walk_of
from trackers.types import CameraCommand

RATE_HZ = 15.0
SEEDS = st.integers(0, 10_000)
SOME = settings(max_examples=12, deadline=None)


@lru_cache(maxsize=64)
def crowd_of(seed: int, preset: str = "standard") -> tuple[FloorPlan, Crowd]:
    plan = draw_floor_plan(np.random.default_rng(seed))
    return plan, draw_crowd(PRESETS[preset], plan, np.random.default_rng(seed + 1))


def _off_walls_m(plan: FloorPlan, place_m: NDArray[np.float64]) -> float:
    """Return the distance of a place from the walls of its room, or from the jambs in an opening."""
    x, y = place_m
    off = [min(x - room.x0, room.x1 - x, y - room.y0, room.y1 - y) for room in plan.rooms.values()]
    for opening in (plan.passage, plan.door):
        if opening.x0 - 0.3 <= x <= opening.x1 + 0.3:
            off.append(min(y - opening.y0, opening.y1 - y))
    return max(off)


@pytest.mark.heavy
@SOME
@given(seed=SEEDS, preset=st.sampled_from(["standard", "hard", "quick"]))
@example(seed=548, preset="standard")
def test_people_keep_off_each_other_walls_and_robot(seed, preset):
    plan, crowd = crowd_of(seed, preset)
    places_m = np.array([walk.place_m for walk in crowd.walks])
    assert crowd.kinds[0] == "target"
    assert len(crowd.kinds) == len(crowd.walks) >= 3
    # The target's path is drawn until it keeps off the robot; there may be no such path.
    for k, place_m in enumerate(places_m[1:], 1):
        assert plan.is_free(place_m).all()
        assert np.linalg.norm(place_m - places_m[0], axis=1).min() > 0.55
        assert np.linalg.norm(place_m - crowd.robot_m, axis=1).min() > 0.6
        for other_m in places_m[k + 1 :]:
            assert np.linalg.norm(place_m - other_m, axis=1).min() > 0.5
    assert plan.is_free(crowd.robot_m).all()
    # The target cuts corners, since its path is rounded, but walks into no wall.
    assert min(_off_walls_m(plan, place_m) for place_m in places_m[0]) > 0.25


@pytest.mark.heavy
@SOME
@given(seed=SEEDS)
def test_nobody_hides_the_target_when_a_tracker_is_told_of_him(seed):
    _, crowd = crowd_of(seed)
    for walk in crowd.walks[1:]:
        for frame in range(10):
            sight_m = crowd.walks[0].place_m[frame] - crowd.robot_m[frame]
            along = np.linspace(0.0, 1.0, 60)[:, None]
            line_m = crowd.robot_m[frame] + along * sight_m
            assert np.linalg.norm(line_m - walk.place_m[frame], axis=1).min() > 0.69


@pytest.mark.heavy
@SOME
@given(seed=SEEDS)
def test_people_walk_as_people_do(seed):
    _, crowd = crowd_of(seed)
    for walk in crowd.walks:
        step_mps = np.linalg.norm(np.diff(walk.place_m, axis=0), axis=1) * RATE_HZ
        assert step_mps.max(initial=0.0) < 2.0
        assert 0 <= walk.speed_mps.min() <= walk.speed_mps.max() < 2.0
        # The person turns round within some frames.
        assert np.abs(np.diff(walk.heading_rad)).max() < 0.85
    target = crowd.walks[0]
    assert 0.5 < np.median(target.speed_mps) < 1.5
    assert np.linalg.norm(np.ptp(target.place_m, axis=0)) > 5.0


@pytest.mark.heavy
def test_the_target_is_in_sight_among_people_most_of_the_time():
    shares = []
    for seed in range(16):
        plan, crowd = crowd_of(seed)
        target_m, *others_m = (walk.place_m for walk in crowd.walks)
        shares.append(
            seen_frames(crowd.robot_m, crowd.robot_heading_rad, target_m, np.array(others_m), plan.openings_m).mean()
        )
    assert 0.7 < np.mean(shares) < 0.95


@pytest.mark.heavy
def test_targets_change_speed_and_stop():
    speeds_mps = np.concatenate([crowd_of(seed)[1].walks[0].speed_mps for seed in range(16)])
    slow_mps, fast_mps = np.percentile(speeds_mps, [10, 95])
    assert slow_mps < 0.7
    assert 1.35 < fast_mps < 1.7
    assert 0.02 < (speeds_mps < 0.1).mean() < 0.2


@pytest.mark.parametrize("kind", ["crosser", "oncomer", "follower", "walker", "stander"])
def test_every_kind_of_people_comes_in_many_episodes(kind):
    there = [kind in crowd_of(seed)[1].kinds for seed in range(16)]
    assert np.mean(there) >= 0.6


def test_crossers_come_between_robot_and_target_and_followers_are_close_behind_him():
    crossed, followed = [], []
    for seed in range(16):
        _, crowd = crowd_of(seed)
        target_m, robot_m = crowd.walks[0].place_m, crowd.robot_m
        for walk, kind in zip(crowd.walks, crowd.kinds, strict=True):
            if kind == "crosser":
                sight_m, to_m = target_m - robot_m, walk.place_m - robot_m
                share = np.einsum("fk,fk->f", to_m, sight_m) / np.einsum("fk,fk->f", sight_m, sight_m)
                off_m = np.linalg.norm(to_m - share[:, None] * sight_m, axis=1)
                crossed.append(((share > 0.2) & (share < 0.9) & (off_m < 0.15)).any())
            if kind == "follower":
                followed.append((np.linalg.norm(walk.place_m - target_m, axis=1) < 1.4).mean())
    assert np.mean(crossed) > 0.9
    assert np.median(followed) > 0.3


def test_places_and_ways_lead_through_openings():
    plan, _ = crowd_of(3)
    rng = np.random.default_rng(0)
    for _ in range(20):
        stops_m = np.array([plan.free_area(room).draw(rng) for room in ("corridor", "yard", "hall")])
        way_m = rounded_way(plan.way(stops_m, rng))
        # Points are a step apart along the path, a little less at sharp turns.
        step_m = np.linalg.norm(np.diff(way_m, axis=0), axis=1)
        assert step_m.max() < 1.001 * STEP_M
        assert np.median(step_m) > 0.99 * STEP_M
        for before_m, after_m in pairwise(way_m):
            for wall_x, opening in ((0.0, plan.passage), (plan.door.x0, plan.door), (plan.door.x1, plan.door)):
                if (before_m[0] - wall_x) * (after_m[0] - wall_x) < 0:
                    assert opening.y0 + 0.3 < after_m[1] < opening.y1 - 0.3
        visited = {plan.place_of(point_m) for point_m in way_m}
        assert visited == {"corridor", "hall", "door", "yard"}


def test_ways_are_walked_as_told():
    way_m = rounded_way(np.array([(0.0, 0.0), (4.0, 0.0), (4.0, 3.0)]))
    assert way_m[[0, -1]] == pytest.approx(np.array([(0.0, 0.0), (4.0, 3.0)]), abs=0.15)
    assert at_distance(way_m, np.array([-1.0, 2.0, 99.0])) == pytest.approx(
        np.array([way_m[0], (2.1, 0.0), way_m[-1]]), abs=0.1
    )
    assert sideways(way_m)[10] == pytest.approx([0.0, 1.0], abs=1e-6)


def test_who_stands_looks_where_he_is_told_or_where_he_will_go():
    standing = np.zeros((30, 2))
    assert walk_of(standing, RATE_HZ, 1.2).heading_rad == pytest.approx(np.full(30, 1.2))
    assert walk_of(standing, RATE_HZ).heading_rad == pytest.approx(np.zeros(30))
    later = np.column_stack([np.zeros(30), np.maximum(np.arange(30) - 15, 0) * 0.08])
    assert walk_of(later, RATE_HZ).heading_rad[0] == pytest.approx(np.pi / 2, abs=1e-6)
    assert walk_of(later, RATE_HZ).speed_mps[-5] == pytest.approx(1.2, rel=1e-3)


COMMANDS = st.lists(st.tuples(st.floats(-9, 9), st.floats(-9, 9)), min_size=20, max_size=120)


@settings(max_examples=30, deadline=None)
@given(commands=COMMANDS, seed=st.integers(0, 50))
def test_robot_obeys_its_limits_and_stays_off_walls(commands, seed):
    plan = draw_floor_plan(np.random.default_rng(seed))
    room = ("corridor", "hall", "yard")[seed % 3]
    robot = Robot(plan, plan.free_area(room).draw(np.random.default_rng(seed)), 0.3 * seed, RATE_HZ)
    states = [(*robot.place_m, robot.heading_rad)]
    for forward_mps, yaw_rad_s in commands:
        robot.drive(CameraCommand(forward_mps=forward_mps, yaw_rate_rad_s=yaw_rad_s))
        assert plan.is_free(robot.place_m)
        states.append((*robot.place_m, robot.heading_rad))
    step = np.diff(np.array(states), axis=0) * RATE_HZ
    assert np.hypot(step[:, 0], step[:, 1]).max() <= FASTEST_MPS + 1e-9
    assert np.abs(step[:, 2]).max() <= FASTEST_TURN_RAD_S + 1e-9
    assert np.abs(np.diff(step[:, 2])).max() * RATE_HZ <= 4.0 + 1e-6


def test_robot_stops_at_walls_and_goes_nowhere_sideways():
    plan = draw_floor_plan(np.random.default_rng(1))
    end_m = plan.free_area("corridor")
    middle_m = np.array([end_m.x0 + 2.0, 0.5 * (end_m.y0 + end_m.y1)])
    robot = Robot(plan, middle_m, np.pi, RATE_HZ)
    for _ in range(60):
        robot.drive(CameraCommand(forward_mps=1.0, right_mps=3.0, climb_mps=3.0))
    assert robot.place_m == pytest.approx([end_m.x0, middle_m[1]], abs=0.1)
    before_m = robot.place_m
    robot.drive(CameraCommand(forward_mps=1.0))
    assert np.array_equal(robot.place_m, before_m)


@SOME
@given(seed=SEEDS)
def test_odometry_begins_at_the_origin_and_drifts_a_little(seed):
    _, crowd = crowd_of(seed % 16)
    odometry = Odometry(np.random.default_rng(seed))
    measured = np.array(
        [odometry.measure(*state) for state in zip(crowd.robot_m, crowd.robot_heading_rad.tolist(), strict=True)]
    )
    assert measured[0, :3, 3] == pytest.approx([0.0, 0.0, 1.2])
    assert measured[0, :3, 2] == pytest.approx([1.0, 0.0, 0.0], abs=1e-12)
    assert measured[:, 2, 2] == pytest.approx(np.zeros(len(measured)), abs=1e-12)
    cosine, sine = np.cos(crowd.robot_heading_rad[0]), np.sin(crowd.robot_heading_rad[0])
    true_m = (crowd.robot_m - crowd.robot_m[0]) @ np.array([[cosine, -sine], [sine, cosine]])
    walked_m = np.linalg.norm(np.diff(crowd.robot_m, axis=0), axis=1).sum()
    drift_m = np.linalg.norm(measured[:, :2, 3] - true_m, axis=1)
    assert 1e-3 < drift_m.max() < 0.2 * walked_m + 0.1
    # The error per frame is millimetres, except where the robot slides along a wall.
    steps_m = [np.linalg.norm(np.diff(way_m, axis=0), axis=1) for way_m in (measured[:, :2, 3], true_m)]
    assert np.median(np.abs(steps_m[0] - steps_m[1])) < 0.005


def test_odometry_of_one_who_stands_does_not_move():
    odometry = Odometry(np.random.default_rng(0))
    poses = [odometry.measure(np.array([3.0, 2.0]), 1.0) for _ in range(20)]
    assert all(np.array_equal(pose, poses[0]) for pose in poses)
