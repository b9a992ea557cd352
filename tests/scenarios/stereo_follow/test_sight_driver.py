"""A driver who sees: he knows nothing of a target that is hidden, searches it, and drives like a hand."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from scenarios.stereo_follow.floor_plan import FloorPlan, draw_floor_plan
from scenarios.stereo_follow.presets import PRESETS
from scenarios.stereo_follow.pursuit import Drive, draw_pursuit, drive_by_sight
from scenarios.stereo_follow.robot import Robot
from scenarios.stereo_follow.sight import seen_frames
from scenarios.stereo_follow.sight_driver import SightDriver
from scenarios.stereo_follow.walks import draw_whims
from tests.scenarios.stereo_follow.blind_guess import RINGED, ring_around

RATE_HZ, FRAMES = 15.0, 300
NOBODY = np.empty((0, FRAMES, 2))


def _yard(seed: int) -> tuple[FloorPlan, NDArray[np.float64]]:
    plan = draw_floor_plan(np.random.default_rng(seed))
    return plan, np.array([plan.yard.x0 + 4.0, 0.5 * (plan.yard.y0 + plan.yard.y1)])


def _drive(plan: FloorPlan, start_m: NDArray[np.float64], target_m: NDArray[np.float64], others_m, seed: int) -> Drive:
    driver = SightDriver(plan, draw_whims(FRAMES, RATE_HZ, np.random.default_rng(seed)), RATE_HZ)
    return drive_by_sight(plan, Robot(plan, start_m, 0.0, RATE_HZ), driver, target_m, others_m)


def _ahead(start_m: NDArray[np.float64], ahead_m: NDArray[np.float64]) -> NDArray[np.float64]:
    return start_m + np.column_stack([ahead_m, np.zeros(FRAMES)])


@pytest.mark.parametrize("seed", range(6))
def test_the_drive_is_the_same_whatever_a_hidden_target_does(seed: int) -> None:
    plan, start_m = _yard(seed)
    walks_m = _ahead(start_m, np.minimum(2.5 + 0.06 * np.arange(FRAMES), 12.0))
    hidden = RINGED[0]
    elsewhere_m = walks_m.copy()
    # From the second frame behind the ring on, the other target walks off sideways.
    aside_m = 0.08 * np.arange(hidden.stop - hidden.start - 1)
    elsewhere_m[hidden.start + 1 : hidden.stop, 1] += aside_m
    both_m = np.concatenate([ring_around(walks_m), ring_around(elsewhere_m)])
    drives = [_drive(plan, start_m, target_m, both_m, seed) for target_m in (walks_m, elsewhere_m)]
    for first, second in zip(*drives, strict=True):
        np.testing.assert_array_equal(first[: hidden.stop + 1], second[: hidden.stop + 1])
    # Whoever sees the target turns after it.
    (walks_rad, elsewhere_rad) = (
        _drive(plan, start_m, target_m, NOBODY, seed)[1] for target_m in (walks_m, elsewhere_m)
    )
    assert np.abs(walks_rad - elsewhere_rad)[: hidden.stop + 1].max() > 0.1


@pytest.mark.parametrize("seed", range(4))
def test_who_has_lost_the_target_goes_there_and_looks_all_around(seed: int) -> None:
    plan, start_m = _yard(seed)
    target_m = _ahead(start_m, np.full(FRAMES, 4.0))
    # It vanishes: it is behind a wall from frame 30 on.
    target_m[30:] = [plan.corridor.x0, plan.hall.y0 - 50.0]
    driven_m, heading_rad = _drive(plan, start_m, target_m, NOBODY, seed)
    assert np.linalg.norm(driven_m - target_m[0], axis=1).min() < 2.5
    assert np.ptp(heading_rad) > 2.0 * np.pi
    assert plan.is_free(driven_m).all()


@pytest.mark.parametrize("seed", range(4))
def test_the_driver_reacts_late(seed: int) -> None:
    plan, start_m = _yard(seed)
    stays_m = _ahead(start_m, np.full(FRAMES, 3.0))
    jumps_m = stays_m.copy()
    jumps_m[100:] += [1.5, 1.0]
    drives = [_drive(plan, start_m, target_m, NOBODY, seed) for target_m in (stays_m, jumps_m)]
    differ = np.flatnonzero((drives[0][0] != drives[1][0]).any(axis=1) | (drives[0][1] != drives[1][1]))
    assert 0.2 * RATE_HZ < differ[0] - 100 < 2.5 * RATE_HZ


def test_he_drives_in_bursts_and_leaves_the_target_at_many_distances_and_bearings() -> None:
    distances_m, bearings, speeds_mps, spans_m = [], [], [], []
    for seed in range(24):
        plan = draw_floor_plan(np.random.default_rng(seed))
        pursuit = draw_pursuit(PRESETS["standard"], plan, np.random.default_rng(seed + 1))
        seen = seen_frames(pursuit.robot_m, pursuit.robot_heading_rad, pursuit.target_m, NOBODY, plan.openings_m)
        sight_m = pursuit.target_m - pursuit.robot_m
        distance_m = np.linalg.norm(sight_m, axis=1)
        bearing = np.arctan2(sight_m[:, 1], sight_m[:, 0]) - pursuit.robot_heading_rad
        distances_m.append(distance_m[seen])
        bearings.append(np.rad2deg((bearing[seen] + np.pi) % (2.0 * np.pi) - np.pi))
        spans_m.append(np.ptp(distance_m))
        speeds_mps.append(np.linalg.norm(np.diff(pursuit.robot_m, axis=0), axis=1) * RATE_HZ)
        assert seen[:10].all()
        assert distance_m.min() > 0.5
    low_m, high_m = np.percentile(np.concatenate(distances_m), [5, 95])
    assert 1.4 < low_m < 2.3
    assert 4.3 < high_m < 6.5
    assert np.median(spans_m) > 2.0
    left, right = np.percentile(np.concatenate(bearings), [5, 95])
    assert left < -15.0
    assert right > 15.0
    speed_mps = np.concatenate(speeds_mps)
    assert (speed_mps < 0.1).mean() > 0.1
    assert (speed_mps > 1.3).mean() > 0.2


def test_targets_are_in_sight_most_of_the_time_and_out_of_it_at_times() -> None:
    shares = []
    for seed in range(24):
        plan = draw_floor_plan(np.random.default_rng(seed))
        pursuit = draw_pursuit(PRESETS["standard"], plan, np.random.default_rng(seed + 1))
        shares.append(
            seen_frames(pursuit.robot_m, pursuit.robot_heading_rad, pursuit.target_m, NOBODY, plan.openings_m).mean()
        )
    assert 0.8 < np.mean(shares) < 0.99
    assert np.percentile(shares, 10) > 0.5
