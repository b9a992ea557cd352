from __future__ import annotations

import ast
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from benchmarks.judges.frame_out import oracle_map, oracle_routes
from benchmarks.judges.frame_out.metrics.posterior import coverage, particle_calibration
from benchmarks.judges.frame_out.oracle_map import OracleMap, OracleParameters
from benchmarks.judges.frame_out.oracle_routes import RouteFan
from scenarios import road_town
from scenarios.road_town.pilot import OUT, picture_states
from scenarios.road_town.plan import TARGET, Plan, make_plan
from scenarios.road_town.presets import PRESETS
from scenarios.road_town.road_map import RoadMap
from scenarios.road_town.scenario import ROAD_TOWN
from sim.optics import intersect_plane
from sim.rng import episode_seed, generator
from trackers.types import CameraModel, Start

SEEDS = range(14)
CAR_HEIGHT_M = 1.5
LATE = 45
"""Frames after the exit at which it is compared with a straight line."""
TARGET_NAME = ROAD_TOWN.target
START = Start(CameraModel(1, 1, 1.0), np.zeros(4))


@pytest.fixture(scope="module")
def plans() -> list[Plan]:
    preset = PRESETS["standard"]
    return [make_plan(preset, episode_seed(seed, "road-town-v2", 0), closed_loop=False) for seed in SEEDS]


def assigned_in(path: Path) -> set[str]:
    """Return the constants of a module, without leading underscores."""
    nodes = [node for node in ast.parse(path.read_text()).body if isinstance(node, ast.Assign)]
    names = (name for node in nodes for target in node.targets for name in ast.walk(target))
    return {name.id.lstrip("_") for name in names if isinstance(name, ast.Name) and name.id.isupper()}


def test_the_drivers_numbers_stand_in_the_scenario_alone() -> None:
    folder = Path(road_town.__file__).parent
    scene = set().union(*(assigned_in(path) for path in folder.glob("*.py")))
    assert {"STANDSTILL_GAP_M", "BRAKING_MPS2", "POINT_SPACING_M"} <= scene
    for module in (oracle_map, oracle_routes):
        assert not assigned_in(Path(module.__file__)) & scene
    assert OracleParameters().cruise_mps == PRESETS["standard"].cruise_mps
    assert OracleParameters().stop_share == PRESETS["standard"].stop_share


def frame_of(plan: Plan, k: int, state: str, T_world_camera: NDArray[np.float64]) -> Any:
    """Return a frame with the truth that the reference reads, without a picture."""
    truth = SimpleNamespace(
        time_s=k / plan.preset.rate_hz,
        index_of=(TARGET_NAME,).index,
        state=np.array([state]),
        T_world_object=plan.motion.T_world_car[k, TARGET, None],
        T_world_camera=T_world_camera,
        speed_mps=plan.motion.speed_mps[k, [TARGET]],
        size_m=np.array([[4.5, 1.8, CAR_HEIGHT_M]]),
        position_px=np.array([[12.0, 34.0]]),
        box_xyxy=np.array([[2.0, 24.0, 22.0, 44.0]]),
        visible_fraction=np.ones(1),
    )
    return SimpleNamespace(truth=truth, camera=plan.camera)


def followed(plan: Plan, parameters: OracleParameters) -> dict[int, tuple[int, float, float]]:
    """Run it through an episode; return frame → frames since the exit, error in metres, credible level."""
    cameras = plan.camera_poses
    states = picture_states(plan.camera, cameras, plan.target_corners_m())
    oracle = OracleMap(parameters, RoadMap(plan.layout.graph), TARGET_NAME, generator(plan.seed, "tracker/oracle_map"))
    oracle.initialise(frame_of(plan, 0, "in", cameras[0]), START)
    found, since = {}, -1
    for k in range(1, plan.preset.frame_count):
        outside = states[k] == OUT
        since = since + 1 if outside else -1
        said = oracle.update(frame_of(plan, k, "out" if outside else "in", cameras[k]))
        if not outside:
            assert said.position_px.tolist() == [12.0, 34.0]
            continue
        assert said.particles_px is not None
        pixels = np.vstack([said.position_px, said.particles_px])
        points = intersect_plane(plan.camera, cameras[k], pixels, 0.5 * CAR_HEIGHT_M)
        truth_m = plan.motion.position_m[k, TARGET]
        count = len(points) - 1
        level = particle_calibration(points[1:], np.full(count, 1 / count), truth_m).credible_level
        found[k] = since, float(np.linalg.norm(points[0] - truth_m)), level
    return found


@pytest.mark.heavy
def test_it_starts_from_the_truth_and_stays_nearer_than_a_straight_line(plans: list[Plan]) -> None:
    at_exit, after_a_while, straight = [], [], []
    for plan in plans:
        position_m, rate_hz = plan.motion.position_m[:, TARGET], plan.preset.rate_hz
        for k, (since, error_m, _) in followed(plan, OracleParameters()).items():
            if since == 0:
                at_exit.append(error_m)
            if since == LATE:
                after_a_while.append(error_m)
                velocity = (position_m[k - LATE] - position_m[k - LATE - 1]) * rate_hz
                line = position_m[k - LATE] + velocity * LATE / rate_hz
                straight.append(float(np.linalg.norm(line - position_m[k])))
    assert np.max(at_exit) < 1.0
    assert len(after_a_while) >= 6
    assert np.mean(after_a_while) < 0.75 * np.mean(straight)


@pytest.mark.heavy
def test_knowing_the_drivers_is_worth_something(plans: list[Plan]) -> None:
    """Over all frames outside the reference with the driver model is nearer and holds the truth more often."""
    mean_error, held = {}, {}
    for knows in (False, True):
        found = [v for plan in plans[:8] for v in followed(plan, OracleParameters(slows_off_road=knows)).values()]
        mean_error[knows] = np.mean([error for _, error, _ in found])
        held[knows] = coverage(np.array([level for since, _, level in found if since >= 3]), 0.95)
    assert mean_error[True] < mean_error[False]
    assert held[True] > held[False]
    assert held[True] > 0.8


@pytest.mark.heavy
def test_a_fan_holds_the_route_that_is_driven(plans: list[Plan]) -> None:
    """On the road, the car's further way lies on one of the routes, from any start frame."""
    checked = 0
    for plan in plans:
        roads = RoadMap(plan.layout.graph)
        position_m = plan.motion.position_m[:, TARGET]
        on_road = roads.is_on_road(position_m)
        poses = plan.motion.T_world_car[: len(position_m), TARGET]
        for k in range(60, len(position_m) - 75, 45):
            # A way off the road begins on the road.
            if not on_road[: k + 75].all():
                continue
            fan = RouteFan(roads, poses[: k + 1])
            assert fan.prior.sum() == pytest.approx(1.0)
            ahead = position_m[k : k + 45]
            distance = np.linalg.norm(fan.points_m[:, None] - ahead[None, :, None], axis=-1).min(axis=2)
            assert distance.max(axis=1).min() < 1.0
            checked += 1
    assert checked > 10
