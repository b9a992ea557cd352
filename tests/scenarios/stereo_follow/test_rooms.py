"""Furnished rooms and the square: nobody walks through furniture, ways lead around it, the square is closed."""

from __future__ import annotations

from dataclasses import replace
from itertools import combinations, pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from scenarios.stereo_follow.floor_plan import draw_floor_plan
from scenarios.stereo_follow.plan import Plan, building_of, make_plan
from scenarios.stereo_follow.presets import PRESETS

SEEDS = st.integers(0, 10_000)
_BODY_M = 0.2
"""Half depth of a person's trunk."""


def plan_of(preset: str, seed: int) -> Plan:
    return make_plan(replace(PRESETS[preset], frame_count=120), seed, closed_loop=False)


def distances_m(
    points_m: NDArray[np.float64], low: NDArray[np.float64], high: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Return the distances (N,) of points (N, 2) from a rectangle."""
    return np.linalg.norm(np.maximum(np.maximum(low - points_m, points_m - high), 0.0), axis=1)


@given(seed=SEEDS)
@settings(max_examples=5, deadline=None)
def test_nobody_walks_through_furniture(seed):
    plan = plan_of("varied", seed)
    places_m = np.concatenate([*(walk.place_m for walk in plan.crowd.walks), plan.crowd.robot_m])
    kinds = {name for name, _, _ in plan.building.furniture}
    # A desk may have no chair.
    assert "desk" in kinds
    assert len(kinds) > 3
    for name, mesh, T in plan.building.furniture:
        if T[2, 3] > 1.0:
            continue
        own_m = (places_m - T[:2, 3]) @ T[:2, :2]
        # The pot alone of what has leaves.
        points_m = mesh.vertices_m[mesh.vertices_m[:, 2] < 0.5, :2]
        gap_m = distances_m(own_m, points_m.min(axis=0), points_m.max(axis=0)).min()
        assert gap_m > _BODY_M, name


@given(seed=SEEDS, shares=st.tuples(*[st.floats(0.0, 1.0)] * 4))
@settings(max_examples=40, deadline=None)
def test_ways_lead_around_the_desks_and_are_short(seed, shares):
    plan = building_of(seed % 7, "building", "furnished").plan
    hall = plan.free_area("hall")
    ends_m = np.array(
        [[hall.x0 + u * (hall.x1 - hall.x0), hall.y0 + v * (hall.y1 - hall.y0)] for u, v in pairwise(shares)]
    )
    ends_m = ends_m[[plan.is_clear(end_m, end_m) for end_m in ends_m]]
    for start_m, end_m in pairwise(ends_m):
        corners_m = [start_m, *plan.around(start_m, end_m)]
        line_m = np.concatenate([np.linspace(a, b, 60) for a, b in pairwise(corners_m)])
        assert plan.is_free(line_m).all()
        length_m = sum(np.linalg.norm(b - a) for a, b in pairwise(corners_m))
        island = plan.island
        around_m = island.x1 - island.x0 + island.y1 - island.y0
        assert length_m <= np.linalg.norm(end_m - start_m) + around_m + 2.0
        np.testing.assert_array_equal(corners_m[-1], end_m)


def test_pieces_stand_apart_and_leave_openings_free():
    for seed in range(4):
        building = building_of(seed, "building", "furnished")
        boxes = {}
        for k, (name, mesh, T) in enumerate(building.furniture):
            points_m = mesh.vertices_m @ T[:3, :3].T + T[:3, 3]
            boxes[name, k] = points_m.min(axis=0), points_m.max(axis=0)
            for opening in building.plan.openings:
                centre_m = np.array([0.5 * (opening.x0 + opening.x1), 0.5 * (opening.y0 + opening.y1)])
                assert distances_m(centre_m[None], *(bound[:2] for bound in boxes[name, k]))[0] > 0.6
        for (one, first), (other, second) in combinations(boxes.items(), 2):
            # Chairs reach under the desks; branches of neighbouring plants may touch.
            if not {"chair", "plant", "planter"} & {one[0], other[0]}:
                shared_m = np.minimum(first[1], second[1]) - np.maximum(first[0], second[0])
                assert shared_m.min() < 0.02, (seed, one, other)


def test_without_furniture_a_plan_draws_as_ever():
    plan = draw_floor_plan(np.random.default_rng(3))
    assert len(plan.free_parts) == 5
    area = plan.free_area("hall")
    np.testing.assert_array_equal(
        plan.draw_place("hall", np.random.default_rng(1)), area.draw(np.random.default_rng(1))
    )
    assert len(building_of(3, "building", "furnished").plan.free_parts) == 8


def test_on_the_square_all_stay_outdoors_and_houses_stand_around():
    plan = plan_of("outdoors", 5)
    assert set(plan.places) == {"yard"}
    area = plan.building.plan.free_area("yard")
    for walk in plan.crowd.walks:
        assert area.shrunk(-1e-9).holds(walk.place_m).all()
    middle_m = np.array([0.5 * (area.x0 + area.x1), 0.5 * (area.y0 + area.y1), 1.2])
    houses = [piece for piece in plan.building.panels if piece.name == "house"]
    assert len(houses) >= 8
    for piece in houses:
        towards = middle_m - piece.corner_m
        assert towards @ np.cross(piece.side_a_m, piece.side_b_m) > 0
    cars_m = [T[:2, 3] for name, _, T in plan.building.furniture if name == "car"]
    places_m = np.concatenate([*(walk.place_m for walk in plan.crowd.walks), plan.crowd.robot_m])
    assert all(np.linalg.norm(places_m - car_m, axis=1).min() > 1.0 for car_m in cars_m)


@pytest.mark.parametrize("field", ["rooms", "place", "people_builds"])
def test_unknown_words_are_named(field):
    with pytest.raises(ValueError, match=rf"{field}: expected one of .*; got 'other'"):
        replace(PRESETS["quick"], **{field: "other"})
