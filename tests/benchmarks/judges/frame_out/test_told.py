"""What ours is told lies on its own map, and is all that it is told."""

from __future__ import annotations

from dataclasses import asdict
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
import shapely
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from benchmarks.contract.suite import suite
from benchmarks.data.sets.data_set import stored_episode
from benchmarks.judges.frame_out.judge import FrameOutJudge
from benchmarks.judges.frame_out.told import Laid, ToldTracker, TrueGraph, TrueGround, rigid
from benchmarks.judges.frame_out.told_rows import TOLD, Told
from benchmarks.run.selection import trackers_of
from scenarios.loop import Loop
from scenarios.road_town.layout import RoadGraph, Street
from scenarios.road_town.road_map import RoadMap
from sim.optics import look_down_pose
from sim.rng import generator
from trackers.kernels.ground_camera import GroundCamera
from trackers.mosaic_graph.mosaic import Mosaic
from trackers.mosaic_graph.road_network import GRID_M, seen_ground
from trackers.types import CameraModel

CAMERA = CameraModel(160, 120, 150.0)
EPISODES = Path(__file__).parents[3] / "canaries" / "episodes"
EXIT = 31
"""Frame of the stored episode on which the car is first outside."""


def a_crossing() -> RoadGraph:
    """Return two straight streets and a bend that meet in the origin."""
    ways = [np.array([-60.0, 0.0]), np.array([60.0, 5.0]), np.array([0.0, 60.0])]
    lines = [np.linspace(0.0, 1.0, 81)[:, None] * way for way in ways]
    return RoadGraph(np.array([[0.0, 0.0], *ways]), tuple(Street(0, k + 1, line, 7.0) for k, line in enumerate(lines)))


def moved(points_m: NDArray[np.float64], turn_rad: float, shift_m: NDArray[np.float64]) -> NDArray[np.float64]:
    c, s = np.cos(turn_rad), np.sin(turn_rad)
    return points_m @ np.array([[c, s], [-s, c]]) + shift_m


def laid(turn_rad: float, shift_m: NDArray[np.float64]) -> tuple[Laid, GroundCamera]:
    """Return the world laid on the map of a tracker whose pose is turned and shifted, and its camera."""
    true = look_down_pose(np.array([3.0, -4.0, 60.0]), 0.4, 0.05, -0.03)
    own = true.copy()
    own[:2, :] = moved(true[:2].T, turn_rad, np.zeros(2)).T
    own[:2, 3] += shift_m
    camera, result = GroundCamera(CAMERA, own, np.zeros(2)), Laid()
    frame: Any = SimpleNamespace(camera=CAMERA, truth=SimpleNamespace(T_world_camera=true))
    result.lay(frame, camera)
    return result, camera


@given(st.floats(-3.0, 3.0), st.tuples(st.floats(-99, 99), st.floats(-99, 99)), st.integers(0, 9))
def test_a_turn_and_a_shift_are_found_again(turn_rad: float, shift_m: tuple[float, float], seed: int) -> None:
    points_m = generator(seed, "points").normal(0.0, 30.0, (6, 2))
    R, t = rigid(points_m, moved(points_m, turn_rad, np.array(shift_m)))
    assert np.allclose(points_m @ R.T + t, moved(points_m, turn_rad, np.array(shift_m)), atol=1e-8)


@pytest.mark.parametrize(("turn_rad", "shift_m"), [(0.0, (0.0, 0.0)), (0.02, (2.0, -1.0)), (-0.7, (-30.0, 8.0))])
def test_the_true_streets_lie_on_the_trackers_map(turn_rad: float, shift_m: tuple[float, float]) -> None:
    shift = np.array(shift_m)
    place, _ = laid(turn_rad, shift)
    roads = TrueGraph(a_crossing(), place).draw(Mosaic(0.5), np.zeros(2))
    streets = shapely.union_all([shapely.LineString(moved(s.centre_m, turn_rad, shift)) for s in a_crossing().streets])
    away_m = shapely.distance(streets, shapely.points(roads.graph.points_m))
    assert roads.graph.edge_count == 3
    assert away_m.max() < 0.05
    assert sorted(np.diff(roads.graph.node_first)) == [1, 1, 1, 3]
    along = np.diff(roads.graph.points_m[:2], axis=0)[0]
    assert np.allclose(along / np.linalg.norm(along), roads.graph.tangents[0], atol=1e-6)


def test_the_true_ground_is_road_where_a_picture_has_shown_it() -> None:
    turn_rad, shift = 0.3, np.array([5.0, -2.0])
    place, camera = laid(turn_rad, shift)
    mosaic = Mosaic(0.25)
    grey = np.full((60, 80, 3), 90, np.uint8)
    mosaic.add(grey, camera, np.full((60, 80), 255, np.uint8))
    ground = TrueGround(a_crossing(), place)
    ground.learn(shift)
    seen = seen_ground(mosaic, shift)
    road = ground.probability(seen)
    rows, columns = np.nonzero(seen.seen)
    centres_m = seen.origin_m + GRID_M * (np.column_stack([columns, rows]) + 0.5)
    in_world_m = moved(centres_m - shift, -turn_rad, np.zeros(2))
    true = RoadMap(a_crossing()).is_on_road(in_world_m)
    assert 0 < np.count_nonzero(seen.seen) < seen.seen.size
    assert 0.05 < true.mean() < 0.95
    assert np.mean(true == (road[rows, columns] > 0.5)) > 0.96


def told(name: str) -> list[Any]:
    """Return the answers of a reference on the stored episode, up to some frames after the exit, and the truths."""
    episode = stored_episode(str(EPISODES / "road-town"), 0)
    spec = next(each for each in TOLD if each.name == name)
    what = asdict(spec.parameters)
    tracker = ToldTracker(episode.map_of().graph, "target", generator(0, name), **what)
    loop = Loop(episode, [tracker])
    return [(frame.truth, loop.answers[0]) for frame in loop.frames(count=EXIT + 6)]


@pytest.mark.heavy
def test_the_state_is_told_at_the_exit_and_not_before() -> None:
    alone, knows = told("told_graph"), told("told_state_and_graph")
    truth, answer = knows[EXIT]
    target = truth.index_of("target")
    assert truth.frames_since_exit[target] == 0
    assert np.allclose(answer.position_px, truth.position_px[target], atol=0.5)
    errors = [[np.linalg.norm(a.position_px - t.position_px[target]) for t, a in run] for run in (alone, knows)]
    assert errors[0][EXIT] > 0.5
    assert errors[1][EXIT + 1] < 6.0
    assert np.mean(errors[1][EXIT:]) < np.mean(errors[0][EXIT:])


def test_they_take_part_as_oracles_of_this_suite_alone() -> None:
    known = trackers_of("frame-out")
    assert {each.name for each in TOLD} <= set(known)
    assert {each.role for each in TOLD} == {"oracle"}
    assert len({each.parameters for each in TOLD}) == len(TOLD)
    assert Told() not in {each.parameters for each in TOLD}
    assert suite("frame-out").judge is FrameOutJudge
