"""Sets of particles: their kernels beside plain loops, and what a swarm does."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from tests.trackers.drawn_harbour import CAMERA, SURVEY, VIEW
from trackers.eigen_swarm.swarm import (
    Region,
    Swarm,
    SwarmParameters,
    cloud,
    count_inside,
    is_duplicate,
    likelihoods,
    move,
    region_of,
)
from trackers.eigen_swarm.tracker import blocks_from_metres
from trackers.site import place

VOLUME = place(SURVEY, CAMERA, VIEW.T_world_camera)


def test_motion_is_linear_with_gaussian_noise() -> None:
    rng = np.random.default_rng(0)
    states, noise = rng.normal(size=(50, 6)), rng.standard_normal((50, 6))
    F = np.eye(6) + 2.0 * np.eye(6, k=3)
    expected = states @ F.T + noise * [0.7, 0.7, 0.7, 0.2, 0.2, 0.2]
    move(states, noise, 2.0, 0.7, 0.2)
    np.testing.assert_allclose(states, expected)


def test_a_particle_has_the_likelihood_of_the_block_that_it_falls_in() -> None:
    rng = np.random.default_rng(1)
    f = rng.random((CAMERA.height_px // 4, CAMERA.width_px // 4))
    # Some lie outside the volume, some outside the picture, some behind the camera.
    places_m = np.concatenate([VOLUME.scatter(rng, 3000), rng.uniform(-130, 130, (3000, 3))])
    px, _ = VIEW.project(places_m)
    seen = VOLUME.contains(places_m) & (px >= 0).all(axis=1) & (px < [CAMERA.width_px, CAMERA.height_px]).all(axis=1)
    column, row = np.floor(px[seen] / 4.0).astype(int).T
    expected = np.zeros(len(places_m))
    expected[seen] = f[row, column]
    assert 500 < seen.sum() < 3100
    states = np.hstack([places_m, np.zeros_like(places_m)])
    got = likelihoods(states, blocks_from_metres(VIEW), f, VOLUME.centre_m, VOLUME.axes, 0.5 * VOLUME.size_m)
    np.testing.assert_array_equal(got, expected)


def test_nothing_is_seen_by_a_camera_without_blocks() -> None:
    states = np.hstack([VOLUME.scatter(np.random.default_rng(2), 9), np.zeros((9, 3))])
    f = np.empty((0, 0))
    got = likelihoods(states, blocks_from_metres(VIEW), f, VOLUME.centre_m, VOLUME.axes, 0.5 * VOLUME.size_m)
    np.testing.assert_array_equal(got, 0.0)


@pytest.mark.parametrize("turned_rad", [0.0, 0.3, 1.2, -0.8])
def test_the_cloud_is_the_pca_about_the_weighted_mean(turned_rad: float) -> None:
    rng = np.random.default_rng(3)
    c, s = np.cos(turned_rad), np.sin(turned_rad)
    states = rng.normal(size=(4000, 6)) * [9.0, 0.7, 1.1, 1, 1, 1] + [10, 20, 3, 0, 0, 0]
    states[:, :2] = states[:, :2] @ np.array([[c, s], [-s, c]])
    weights = rng.random(4000)
    centre, a1, spread = cloud(states, weights)
    expected = weights @ states[:, :3] / weights.sum()
    np.testing.assert_allclose(centre, expected)
    offsets = states[:, :3] - expected
    values, vectors = np.linalg.eigh(offsets[:, :2].T @ offsets[:, :2] / 4000)
    np.testing.assert_allclose(spread, np.sqrt([values[1], values[0], (offsets[:, 2] ** 2).mean()]))
    assert abs(a1 @ vectors[:, 1]) == pytest.approx(1.0)


def test_the_particles_inside_a_region_are_counted() -> None:
    rng = np.random.default_rng(4)
    states, a1, half_m = rng.normal(size=(2000, 6)), np.array([np.cos(0.5), np.sin(0.5)]), np.array([0.3, 0.9, 1.1])
    along, across = states[:, :2] @ a1, states[:, :2] @ np.array([-a1[1], a1[0]])
    expected = (np.abs(np.column_stack([along, across, states[:, 2]])) <= half_m).all(axis=1).sum()
    assert 100 < expected < 1900
    assert count_inside(states, np.zeros(3), a1, half_m) == expected


EMPTY_F = 2e-4
"""f of a block that is like the background: r = 1 below the threshold of 15."""
PARAMETERS = SwarmParameters()


def swarm(**changes: float) -> Swarm:
    parameters = replace(PARAMETERS, **changes)  # type: ignore[arg-type]
    return Swarm(parameters, VOLUME, blocks_from_metres(VIEW), np.random.default_rng(0))


def background() -> NDArray[np.float64]:
    return np.full((CAMERA.height_px // 4, CAMERA.width_px // 4), EMPTY_F)


def with_object(place_m: tuple[float, float, float]) -> NDArray[np.float64]:
    """Return f where a person stands: about three blocks."""
    f = background()
    [(u, v)] = VIEW.project(np.array([place_m]))[0]
    row, column = int(v / 4), int(u / 4)
    f[row - 1 : row + 2, column] = 1.0
    return f


def test_a_uniform_set_has_the_density_0_02() -> None:
    places_m = VOLUME.scatter(np.random.default_rng(0), 4000)
    region = region_of(np.hstack([places_m, np.zeros((4000, 3))]), np.ones(4000), 0.1)
    assert region.density == pytest.approx(0.02, abs=0.005)
    np.testing.assert_allclose(region.size_m, [0.1 * 90 / np.sqrt(3), 33 / np.sqrt(3), 6 / np.sqrt(3)], rtol=0.05)


def test_a_gaussian_cloud_has_the_density_of_its_region() -> None:
    rng = np.random.default_rng(1)
    spread_m = np.array([11.0, 0.4, 0.9])
    states = np.hstack([rng.normal(size=(200_000, 3)) * spread_m, np.zeros((200_000, 3))])
    region = region_of(states, np.ones(200_000), 0.1)
    # P(|n| < 0.1) P(|n| < 1)², over the volume without ε.
    expected = 200_000 * 0.0797 * 0.6827**2 / np.prod(2 * spread_m)
    assert region.density == pytest.approx(expected, rel=0.03)


def test_nothing_is_tracked_where_all_is_background() -> None:
    each = swarm()
    for _ in range(2 * PARAMETERS.patience_pictures):
        assert each.step(background(), 2.0) == []
    assert [one.tracks for one in each.stack] == [False]


def test_an_object_is_tracked_at_its_bearing_and_a_new_set_detects() -> None:
    each = swarm()
    for _ in range(3):
        tracking = each.step(with_object((5.0, 2.0, 0.8)), 2.0)
    first = tracking[0]
    assert first.number == 0
    assert first.region is not None
    # The bearing is known, the distance is not.
    bearing = np.array([105.0, 2.0]) / np.hypot(105.0, 2.0)
    away = first.region.centre_m[:2] - VIEW.place_m[:2]
    assert abs(away @ [-bearing[1], bearing[0]]) < 0.5
    assert abs(first.region.a1 @ bearing) > 0.999
    assert first.region.size_m[1] < 1.5
    assert not each.stack[-1].tracks
    assert each.stack[-1].number > first.number


def test_a_set_is_removed_when_its_object_is_gone() -> None:
    each = swarm(place_noise_m=2.0)
    for _ in range(3):
        each.step(with_object((5.0, 2.0, 0.8)), 2.0)
    assert 0 in [one.number for one in each.stack]
    for _ in range(30):
        each.step(background(), 2.0)
    assert 0 not in [one.number for one in each.stack]


def test_a_set_that_sees_nothing_at_all_is_removed() -> None:
    each = swarm()
    each.step(with_object((5.0, 2.0, 0.8)), 2.0)
    assert each.stack[0].tracks
    assert each.step(np.zeros_like(background()), 2.0) == []
    assert [one.tracks for one in each.stack] == [False]


def test_a_set_that_detects_for_long_is_scattered_anew() -> None:
    each = swarm(patience_pictures=3, density_in=np.inf)
    f = with_object((5.0, 2.0, 0.8))
    spreads_m = []
    for _ in range(7):
        each.step(f, 2.0)
        spreads_m.append(each.stack[0].states[:, 1].std())
    gathered = np.array(spreads_m) < 3.0
    np.testing.assert_array_equal(gathered, [True, True, False, True, True, False, True])


def test_the_stack_has_a_limit_and_its_oldest_sets_lie_lowest() -> None:
    each = swarm(uses_direction=False, uses_distance=False, most_sets=6)
    most = 0
    for _ in range(25):
        tracking = each.step(with_object((5.0, 2.0, 0.8)), 2.0)
        numbers = [one.number for one in each.stack]
        assert numbers == sorted(numbers)
        assert len(numbers) <= 6
        most = max(most, len(tracking))
    assert most == 6


def region(x_m: float, y_m: float, turned_rad: float = 0.0, width_m: float = 1.0) -> Region:
    a1, spread_m = np.array([np.cos(turned_rad), np.sin(turned_rad)]), np.array([9.0, 0.5 * width_m, 1.0])
    return Region(np.array([x_m, y_m, 0.5]), a1, spread_m, 2 * spread_m, 5.0)


@pytest.mark.parametrize(
    ("n", "both", "no_direction", "no_distance"),
    [
        (region(10.0, 0.3), True, True, True),
        # Another eigenvector of the same direction.
        (region(10.0, 0.3, np.pi), True, True, True),
        # A second object on the line of sight, farther than the half widths together.
        (region(15.0, 0.0), False, False, True),
        # Near, but 2 degrees apart as seen from the camera: cos 2° = 0.9994.
        (region(10.3, 0.3, np.radians(2.0)), False, True, False),
        # 1.5 degrees: cos = 0.99966.
        (region(10.3, 0.3, np.radians(1.5)), True, True, True),
        (region(10.0, 1.1), False, False, True),
        (region(10.0, 1.1, 0.0, 1.4), True, True, True),
    ],
)
def test_duplicates_have_the_direction_and_the_place_of_an_older_set(
    n: Region, both: bool, no_direction: bool, no_distance: bool
) -> None:
    m = region(10.0, 0.0)
    assert is_duplicate(n, m, PARAMETERS) == both
    assert is_duplicate(n, m, replace(PARAMETERS, uses_direction=False)) == no_direction
    assert is_duplicate(n, m, replace(PARAMETERS, uses_distance=False)) == no_distance
    assert not is_duplicate(n, m, replace(PARAMETERS, uses_direction=False, uses_distance=False))


def test_a_newer_duplicate_is_removed_and_the_older_set_stays() -> None:
    each = swarm()
    f = with_object((5.0, 2.0, 0.8))
    each.step(f, 2.0)
    copy = each.stack[0]
    each.stack.append(replace(copy, number=99, states=copy.states.copy()))
    each.step(f, 2.0)
    numbers = [one.number for one in each.stack]
    assert copy.number in numbers
    assert 99 not in numbers
