"""Shoals: fish stay in the water and out of each other, swim as their parameters say, the same for the same seed."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from scenarios.fish_tank.presets import AYU, CROWD, ZEBRAFISH, Character
from scenarios.fish_tank.scenario import FISH_TANK
from scenarios.fish_tank.shoal import Kind, Swims, kind_of, swim
from sim.meshes.fish import FishLook, fish_segments, half_size
from sim.motion.swim import SEGMENT_ENDS, swim_pose
from sim.rng import episode_seed, generator

TANK_M = (0.60, 0.42, 0.12)
LONG_M = 0.035
IN_WALL = np.array([0.025, 0.07, 0.01, 0.01, 0.01, 0.01, 0.01, 0.01])
"""How far each segment may reach into a wall, in lengths. Paired fins are soft: their tips stand out by 0.067 from the
trunk, whose width is what keeps clear. Snout and eyes were seen to reach 0.016 into it, trunk and tail not at all."""


def rng(seed: int = 0) -> np.random.Generator:
    return np.random.default_rng(seed)


def shoal(character: Character, count: int, frames: int, seed: int = 0, rate_hz: float = 30.0) -> Swims:
    return swim(TANK_M, np.full(count, LONG_M), frames, rate_hz, character, rng(seed))


def axes_m(swims: Swims, frame: int, shares: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return points (N, K, 3) on the fish's axes at shares of their length."""
    T = swim_pose(
        np.full(swims.yaw_rad.shape[1], LONG_M),
        swims.position_m[frame],
        swims.yaw_rad[frame],
        swims.pitch_rad[frame],
        swims.joints_rad[frame],
    ).T_world_segment
    segment = np.minimum(np.searchsorted(SEGMENT_ENDS, shares, side="right") - 1, T.shape[1] - 1)
    back_m = (shares - np.array(SEGMENT_ENDS)[segment]) * LONG_M
    own = T[:, segment]
    return own[..., :3, 3] - own[..., :3, 0] * back_m[:, None]


@pytest.mark.heavy
@pytest.mark.parametrize(("character", "count", "frames"), [(ZEBRAFISH, 10, 300), (CROWD, 100, 60)])
def test_bodies_never_penetrate_each_other(character, count, frames):
    """Elliptic cross sections, 49 along each body: an independent reading of what the kernels bound by segments."""
    swims = shoal(character, count, frames)
    shares = np.linspace(0.0, 1.0, 49)
    width, height = half_size(shares) * LONG_M
    passed_over = 0
    for frame in range(frames):
        points_m = axes_m(swims, frame, shares)
        apart_m = np.linalg.norm(swims.position_m[frame, :, None, :2] - swims.position_m[frame, None, :, :2], axis=2)
        for i, j in zip(*np.nonzero(np.triu(apart_m < 1.1 * LONG_M, 1)), strict=True):
            off_m = points_m[i][:, None] - points_m[j][None]
            across = np.hypot(off_m[..., 0], off_m[..., 1]) / (width[:, None] + width)
            upright = off_m[..., 2] / (height[:, None] + height)
            assert np.hypot(across, upright).min() > 1.0, (frame, i, j)
            passed_over += bool((across < 1.0).any())
    assert passed_over > 0


@pytest.mark.parametrize(("character", "count"), [(ZEBRAFISH, 5), (CROWD, 40), (AYU, 1)])
def test_bodies_stay_between_walls_floor_and_surface(character, count):
    swims = shoal(character, count, 120, seed=5)
    meshes = fish_segments(FishLook(length_m=LONG_M), rng())
    for frame in range(0, 120, 3):
        poses = swim_pose(
            np.full(count, LONG_M),
            swims.position_m[frame],
            swims.yaw_rad[frame],
            swims.pitch_rad[frame],
            swims.joints_rad[frame],
        ).T_world_segment
        for k, (mesh, slack) in enumerate(zip(meshes, IN_WALL, strict=True)):
            corners_m = mesh.vertices_m @ poses[:, k, :3, :3].transpose(0, 2, 1) + poses[:, k, None, :3, 3]
            assert corners_m[..., 2].min() > 0.0
            assert corners_m[..., 2].max() < TANK_M[2]
            for axis in range(2):
                assert np.abs(corners_m[..., axis]).max() < 0.5 * TANK_M[axis] + slack * LONG_M, (frame, k)


@given(st.integers(0, 9_999), st.integers(1, 12))
@settings(max_examples=6, deadline=None)
def test_the_same_generator_gives_the_same_shoal(seed, count):
    one, other = shoal(ZEBRAFISH, count, 5, seed), shoal(ZEBRAFISH, count, 5, seed)
    for name in vars(one):
        np.testing.assert_array_equal(getattr(one, name), getattr(other, name))
    assert not np.array_equal(one.position_m, shoal(ZEBRAFISH, count, 5, seed + 1).position_m)


def test_fish_swim_where_they_look_and_as_fast_as_they_say():
    swims = shoal(ZEBRAFISH, 4, 300)
    step_m = np.diff(swims.position_m[..., :2], axis=0)
    middle = 0.5 * (swims.yaw_rad[1:] + swims.yaw_rad[:-1])
    ahead = (step_m * np.stack([np.cos(middle), np.sin(middle)], axis=-1)).sum(axis=-1)
    speed = 0.5 * (swims.speed_mps[1:] + swims.speed_mps[:-1]) / 30.0
    inside = (np.abs(swims.position_m[1:, :, :2]) < 0.5 * np.array(TANK_M[:2]) - 0.03).all(axis=-1)
    assert np.median(np.abs(ahead - speed)[inside] / speed[inside]) < 0.05
    assert np.corrcoef(ahead[inside], speed[inside])[0, 1] > 0.95


def test_speed_decays_exponentially_between_bursts():
    still = ZEBRAFISH._replace(
        mood_spread=0.0,
        burst_interval_s=3.0,
        burst_spread=0.0,
        turn_rad=0.0,
        cruise_mps=0.01,
        wall_reach_m=0.01,
        veer_radps=0.0,
    )
    swims = shoal(still, 6, 400, seed=2)
    speed = swims.speed_mps - 0.01
    gliding = (speed[1:] < speed[:-1]) & (speed[1:] > 0.01)
    clear = (np.abs(swims.position_m[1:, :, :2]) < 0.5 * np.array(TANK_M[:2]) - 0.08).all(axis=-1)
    ratio = speed[1:][gliding & clear] / speed[:-1][gliding & clear]
    assert len(ratio) > 30
    assert np.median(ratio) == pytest.approx(np.exp(-1.0 / (30.0 * still.glide_s)), rel=0.005)


def test_tail_beats_belong_to_bursts_and_travel_to_the_tail():
    quiet = ZEBRAFISH._replace(burst_interval_s=float("inf"), cruise_mps=1e-4, veer_radps=0.0, glide_beat=0.0)
    # Thirty fish for half a minute, so that even rare bursts would be seen.
    assert np.abs(shoal(quiet, 30, 300, rate_hz=10.0).joints_rad).max() < 0.02
    swims = shoal(ZEBRAFISH, 10, 300)
    spread = swims.joints_rad.std(axis=(0, 1))
    assert spread[-1] > spread[0]
    # The bend of the last joints is that of the first ones some frames before.
    first, last = swims.joints_rad[..., 1], swims.joints_rad[..., 4]
    later = [np.corrcoef(first[: len(first) - lag].ravel(), last[lag:].ravel())[0, 1] for lag in (0, 1, 2)]
    assert max(later[1:]) > later[0]


@pytest.mark.heavy
def test_fish_without_bursts_never_dart():
    """The generators are those of the preset's episodes; one burst in half a minute of any of them would be seen."""
    assert np.isinf(AYU.burst_interval_s)
    for seed in range(64):
        draws = generator(episode_seed(seed, FISH_TANK.id, 0), "shoal")
        swims = swim(TANK_M, np.array([LONG_M]), 300, 10.0, AYU, draws)
        assert swims.speed_mps.max() < 2.0 * AYU.cruise_mps, seed


def test_motion_is_smooth():
    swims = shoal(ZEBRAFISH, 10, 1200, seed=3, rate_hz=120.0)
    assert np.linalg.norm(np.diff(swims.position_m, axis=0), axis=-1).max() < 0.008
    assert np.abs(np.diff(swims.position_m[..., 2], axis=0)).max() < 0.003
    assert np.abs(np.diff(swims.joints_rad, axis=0)).max() < 0.25
    assert np.abs(np.diff(swims.yaw_rad, axis=0)).max() < 0.4


def test_fish_change_their_depth():
    swims = shoal(ZEBRAFISH, 10, 900, seed=4)
    assert np.ptp(swims.position_m[..., 2], axis=0).mean() > 0.02
    assert swims.position_m[..., 2].std() > 0.015


def test_mates_attract_each_other_if_they_shall():
    far = ZEBRAFISH._replace(school=0.0)
    near = ZEBRAFISH._replace(school=0.8, school_reach_m=0.4, align=0.0)

    def mean_distance_m(character: Character) -> float:
        place_m = np.concatenate([shoal(character, 6, 600, seed).position_m[..., :2] for seed in range(3)])
        return float(np.linalg.norm(place_m[:, :, None] - place_m[:, None], axis=-1).mean())

    assert mean_distance_m(near) < 0.8 * mean_distance_m(far)


def speeds_and_turns(rate_hz: float, seed: int) -> NDArray[np.float64]:
    """Return mean, 10th, 50th and 90th percentile of speed, and mean turn over 0.2 s, of 360 fish-seconds."""
    swims = shoal(ZEBRAFISH, 12, int(30 * rate_hz), seed, rate_hz)
    lag = round(0.2 * rate_hz)
    turn_rad = np.abs(swims.yaw_rad[lag:] - swims.yaw_rad[:-lag])
    return np.array([swims.speed_mps.mean(), *np.percentile(swims.speed_mps, (10, 50, 90)), turn_rad.mean()])


@pytest.mark.heavy
def test_the_rate_of_frames_does_not_change_how_they_swim():
    """Steps of 1/120 and 1/240 s, so that the draws differ too: only statistics can agree."""
    slow, fast = (np.array([speeds_and_turns(rate, seed) for seed in range(10)]) for rate in (30.0, 240.0))
    error = np.hypot(*(each.std(axis=0, ddof=1) for each in (slow, fast))) / np.sqrt(len(slow)) / slow.mean(axis=0)
    # A tenth is at least four standard errors of such a ratio, so that chance does not fail this.
    np.testing.assert_allclose(fast.mean(axis=0) / slow.mean(axis=0), 1.0, atol=0.1)
    assert (4.0 * error < 0.1).all()


@pytest.mark.parametrize(
    ("arguments", "name"),
    [
        (((0.1, 0.42, 0.12), np.full(2, LONG_M), 10, 30.0), "volume_m"),
        ((TANK_M, np.full(400, LONG_M), 10, 30.0), "length_m"),
        ((TANK_M, np.full(2, LONG_M), 0, 30.0), "frame_count"),
        ((TANK_M, np.full(2, LONG_M), 10, 0.0), "rate_hz"),
    ],
)
def test_impossible_shoals_are_named(arguments, name):
    with pytest.raises(ValueError, match=f"^{name}: expected"):
        swim(*arguments, ZEBRAFISH, rng())


def test_fish_of_a_round_tank_stay_in_it_and_follow_its_wall():
    radius_m, count, frames = 0.25, 12, 200
    swims = swim((0.5, 0.5, 0.15), np.full(count, LONG_M), frames, 30.0, ZEBRAFISH, rng(1), is_round=True)
    width = half_size(np.array(SEGMENT_ENDS))[0] * LONG_M
    for frame in range(0, frames, 5):
        from_middle_m = np.linalg.norm(axes_m(swims, frame, np.array(SEGMENT_ENDS))[..., :2], axis=2) + width
        assert from_middle_m.max() < radius_m + 1e-3
    away_m = np.linalg.norm(swims.position_m[..., :2], axis=2)
    ahead = np.stack([np.cos(swims.yaw_rad), np.sin(swims.yaw_rad)], axis=2)
    out = swims.position_m[..., :2] / away_m[..., None]
    at_wall = away_m > radius_m - 0.03
    # Where a fish heads makes no difference in the middle: there the mean of |cos| is 2 / pi.
    assert np.abs((ahead * out).sum(axis=2))[at_wall].mean() < 0.5


def test_zebrafish_among_their_own_kind_swim_as_without_kinds():
    plain = shoal(ZEBRAFISH, 6, 20)
    named = swim(TANK_M, np.full(6, LONG_M), 20, 30.0, ZEBRAFISH, rng(), [kind_of("zebrafish")] * 6)
    np.testing.assert_array_equal(plain.position_m, named.position_m)
    np.testing.assert_array_equal(plain.joints_rad, named.joints_rad)


def test_high_bodies_keep_off_floor_and_surface_and_larger_fish_swim_faster():
    length_m = np.repeat([0.027, 0.048], 8)
    kinds = [kind_of("tetra")] * 8 + [kind_of("barb")] * 8
    swims = swim(TANK_M, length_m, 240, 30.0, ZEBRAFISH, rng(), kinds)
    reach_m = half_size(np.array(SEGMENT_ENDS))[1].max() * length_m * [kind.height for kind in kinds]
    assert (swims.position_m[..., 2] > reach_m - 1e-9).all()
    assert (swims.position_m[..., 2] < TANK_M[2] - reach_m + 1e-9).all()
    speed_mps = swims.speed_mps.mean(axis=0)
    assert speed_mps[8:].mean() > 1.15 * speed_mps[:8].mean()
    with pytest.raises(ValueError, match=r"kinds: expected one for each of 16 fish, or none, got 1"):
        swim(TANK_M, length_m, 2, 30.0, ZEBRAFISH, rng(), [Kind(0, 1.0, 1.0, 1.0)])
