"""Tide, moored boats, ropes and gulls."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from scenarios.harbour.clutter import birds
from scenarios.harbour.conditions import Tide, draw_tide, float_poses, rocking, sway
from scenarios.harbour.layout import FIXED, MEAN_SEA_M
from scenarios.harbour.moorings import SEGMENTS, Moored, Ride, draw_moored, mesh_of, ride, rope_lengths_m
from scenarios.objects import AWAY_M

TIME_S = 2.0 * np.arange(2100)
CALM = np.full(len(TIME_S), 0.05), np.full(len(TIME_S), 2.0), np.full(len(TIME_S), 0.7)


def rng_of(seed: int) -> np.random.Generator:
    return np.random.Generator(np.random.PCG64(seed))


def test_the_tide_moves_while_an_episode_lasts_and_keeps_its_range() -> None:
    for seed in range(50):
        tide = draw_tide(rng_of(seed))
        episode = tide.level_m(TIME_S)
        assert np.ptp(episode) > 0.15
        assert (episode < 0.0).all()
        days = tide.above_mean_m(np.arange(-3 * 86400.0, 0.0, 600.0))
        assert np.abs(days).max() <= 0.91
        assert np.ptp(days) > 0.9
        # Two high waters a day, mostly.
        rises = np.diff(np.sign(np.diff(days))) < 0
        assert 5 <= rises.sum() <= 7
    np.testing.assert_allclose(tide.level_m(TIME_S) - tide.above_mean_m(TIME_S), MEAN_SEA_M)


def test_a_smooth_motion_has_unit_spread_and_its_periods() -> None:
    time_s = np.arange(0.0, 20000.0, 0.5)
    motion = sway(time_s, (20.0, 40.0), rng_of(1))
    assert motion.std() == pytest.approx(1.0, abs=0.06)
    power = np.abs(np.fft.rfft(motion)) ** 2
    frequency = np.fft.rfftfreq(len(time_s), 0.5)
    within = (frequency > 1 / 42.0) & (frequency < 1 / 19.0)
    assert power[within].sum() / power.sum() > 0.99


def test_poses_turn_about_z_then_y_then_x() -> None:
    heading, roll, pitch = (np.array([each]) for each in (0.4, 0.2, -0.1))
    T = float_poses(np.array([[1.0, 2.0, 3.0]]), heading, roll, pitch)[0]
    np.testing.assert_allclose(T[:3, :3], Rotation.from_euler("ZYX", [0.4, -0.1, 0.2]).as_matrix(), atol=1e-12)
    np.testing.assert_array_equal(T[:3, 3], (1.0, 2.0, 3.0))


def test_a_small_boat_follows_the_waves_more_than_a_large_one() -> None:
    height = np.full(4000, 0.4)
    time_s = 0.7 * np.arange(4000)
    small, large = (rocking(time_s, height, length, rng_of(2)) for length in (4.0, 12.0))
    assert 0.06 < small.heave_m.std() < 0.1
    assert large.heave_m.std() < 0.7 * small.heave_m.std()
    assert np.degrees(large.roll_rad.std()) < np.degrees(small.roll_rad.std()) < 12.0


@pytest.fixture(scope="module")
def moored() -> list[Moored]:
    return draw_moored(2, rng_of(4))


@pytest.fixture(scope="module")
def rides(moored: list[Moored]) -> list[Ride]:
    tide = draw_tide(rng_of(5))
    return [ride(each, TIME_S, tide, *CALM) for each in moored]


def test_moored_boats_rise_with_the_tide_swing_and_stay_off_the_wall(moored: list[Moored], rides: list[Ride]) -> None:
    level_m = draw_tide(rng_of(5)).level_m(TIME_S)
    for boat, moving in zip(moored, rides, strict=True):
        place = moving.T_world_boat[:, :3, 3]
        assert np.abs(place[:, 2] - level_m).max() < 0.1
        assert np.ptp(place[:, :2], axis=0).max() > 0.15
        corners = mesh_of(boat).vertices_m.astype(float)
        for T in moving.T_world_boat[::100]:
            assert (corners @ T[:3, :3].T + T[:3, 3])[:, 0].max() < FIXED.wall_x_m
        if boat.swings:
            away = np.hypot(*(place[:, :2] - boat.anchor_m).T)
            np.testing.assert_allclose(away, away[0], rtol=1e-9)


@pytest.mark.parametrize("wind_mps", [0.5, 7.0])
def test_boats_at_buoys_lie_downwind_of_them_with_the_bow_to_the_wind(moored: list[Moored], wind_mps: float) -> None:
    still, tide = np.zeros(len(TIME_S)), draw_tide(rng_of(5))
    # It turns once from day to day, half way.
    blows_to = np.where(TIME_S < 2100.0, 0.4, 2.6)
    for boat in moored:
        moving = ride(boat, TIME_S, tide, still, still + wind_mps, blows_to).T_world_boat
        for part in (TIME_S < 2100.0, TIME_S >= 2100.0):
            # At a quay the wind's direction changes nothing.
            other = ride(boat, TIME_S, tide, still, still + wind_mps, blows_to + 1.0).T_world_boat
            assert np.array_equal(moving, other) == (not boat.swings)
            if boat.swings:
                away = (moving[part, :2, 3] - boat.anchor_m).mean(axis=0)
                off = np.angle(np.exp(1j * (np.arctan2(away[1], away[0]) - blows_to[part][0])))
                assert abs(off) < 0.75
                bow = moving[part, :2, 0].mean(axis=0)
                assert bow @ away < -0.98 * np.linalg.norm(bow) * np.linalg.norm(away)


def rope_points(moving: Ride, k: int) -> tuple[np.ndarray, np.ndarray]:
    """Return starts and directions (F, SEGMENTS, 3) of the segments of a boat's k-th rope."""
    T = moving.T_world_rope[:, k * SEGMENTS : (k + 1) * SEGMENTS]
    return T[..., :3, 3], T[..., :3, 0]


def test_ropes_hang_together_from_boat_to_shore(moored: list[Moored], rides: list[Ride]) -> None:
    for boat, moving in zip(moored, rides, strict=True):
        assert moving.T_world_rope.shape[1] == len(rope_lengths_m(boat)) * SEGMENTS
        for k, length_m in enumerate(rope_lengths_m(boat)):
            start, ahead = rope_points(moving, k)
            gap = np.diff(start, axis=1)
            span = np.linalg.norm(gap, axis=2)
            np.testing.assert_allclose(gap, span[..., None] * ahead[:, :-1], atol=1e-9)
            # The rope keeps its length, but where the boat pulls at it.
            total = span.sum(axis=1) * SEGMENTS / (SEGMENTS - 1)
            assert (total < 1.12 * length_m).all()
            # Each segment is as long as its share, and as far as the next one begins.
            assert span.max() < 1.6 * length_m / SEGMENTS


def test_ropes_slacken_as_the_water_rises() -> None:
    boat = next(each for each in draw_moored(2, rng_of(4)) if not each.swings)
    tide = Tide(np.array([np.pi, np.pi, np.pi, np.pi]))
    time_s = np.array([0.0, 6.2 * 3600.0])
    assert tide.level_m(time_s)[0] < tide.level_m(time_s)[1] - 1.0
    still = np.zeros(2)
    sags = []
    for k in range(len(rope_lengths_m(boat))):
        start, _ = rope_points(ride(boat, time_s, tide, still, still, still), k)
        middle, ends = start[:, SEGMENTS // 2], 0.5 * (start[:, 0] + 2 * start[:, -1] - start[:, -2])
        sags.append(ends[:, 2] - middle[:, 2])
    low, high = np.mean(sags, axis=0)
    assert high > low + 0.15


def test_gulls_fly_at_their_speed_and_rest_on_water_quay_and_roofs() -> None:
    tide = draw_tide(rng_of(5))
    time_s = 0.5 * np.arange(8000)
    flying, resting = birds(time_s, tide, rng_of(6))
    level_m = tide.level_m(time_s)
    heights, speeds, rests = [], [], []
    for k in range(flying.shape[1]):
        place = flying[:, k, :3, 3]
        here = place[:, 2] > AWAY_M
        both = here[1:] & here[:-1]
        step = np.linalg.norm(np.diff(place, axis=0), axis=1)[both] / 0.5
        speeds.append(step[step < 15.0])
        heights.append(place[here, 2])
    assert np.concatenate(speeds).min() > 6.5
    assert np.concatenate(speeds).max() < 11.5
    assert np.concatenate(heights).min() > -1.8
    for k in range(resting.shape[1]):
        place = resting[:, k, :3, 3]
        here = place[:, 2] > AWAY_M
        on_water = np.abs(place[:, 2] - level_m + 0.05) < 1e-9
        on_land = (place[:, 2] >= 0.0) & (place[:, 0] > FIXED.wall_x_m)
        assert (on_water | on_land | ~here).all()
        rests.append((on_water & here).mean() - (on_land & here).mean() * 1j)
    assert sum(each.real for each in rests) > 0.2
    assert sum(-each.imag for each in rests) > 0.2
