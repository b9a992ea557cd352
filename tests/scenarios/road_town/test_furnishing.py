"""Hedges, signs, overpasses and passers-by: off by default, overlapping nothing, in nobody's way."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
import shapely

from scenarios.road_town.canvas import rectangle
from scenarios.road_town.ground import place_pools
from scenarios.road_town.layout import Layout, Overpass
from scenarios.road_town.line_of_sight import LineOfSight
from scenarios.road_town.overpasses import CLEAR_M
from scenarios.road_town.passers_by import CAR_CLEAR_M
from scenarios.road_town.plan import Plan, draw_kept_layout, draw_layout, make_plan
from scenarios.road_town.presets import NEXT_PRESETS, PRESETS, STANDARD, RoadTown
from scenarios.road_town.road_map import RoadMap, road_area
from scenarios.road_town.scenario import ROAD_TOWN, kind_of_town
from sim.meshes.vehicle import OWN, SHIPPED
from sim.rng import generator

NEW = ("buildings", "gardens", "signs", "overpasses", "people", "cyclists")
CHANGED = {"buildings": "varied", "gardens": "grown", "signs": (5, 5), "overpasses": (2, 2), "people": (3, 3)}


@cache
def plan_of(name: str, seed: int) -> Plan:
    return make_plan(NEXT_PRESETS[name], seed, closed_loop=False)


def _areas(layout: Layout) -> dict[str, list[shapely.Polygon]]:
    return {
        "building": [shapely.Polygon(rectangle(b.centre_m, b.size_m[:2], b.yaw_rad)) for b in layout.buildings],
        "car park": [shapely.Polygon(rectangle(p.centre_m, p.size_m, p.yaw_rad)) for p in layout.car_parks],
        "trunk": [shapely.Point(t.centre_m).buffer(0.25) for t in layout.trees],
        "prop": [shapely.Polygon(rectangle(*p.rectangle)) for p in layout.props],
        "solid": [shapely.Polygon(rectangle(*s)) for o in layout.overpasses for s in o.solids],
    }


@pytest.mark.parametrize("seed", [0, 2])
@pytest.mark.parametrize("name", ["standard", "bridges"])
def test_nothing_stands_in_anything_else_or_on_a_street(name: str, seed: int) -> None:
    plan = plan_of(name, seed)
    areas = _areas(plan.layout)
    assert len(areas["prop"]) > 400
    everything = [(kind, area) for kind, some in areas.items() for area in some]
    tree = shapely.STRtree([area for _, area in everything])
    touching = tree.query([area for _, area in everything], predicate="intersects").T
    for a, b in touching[touching[:, 0] < touching[:, 1]]:
        kinds = everything[a][0], everything[b][0]
        # Pieces of a hedge touch each other.
        assert kinds == ("prop", "prop"), kinds
    streets, pavements = road_area(plan.layout.graph), road_area(plan.layout.graph).buffer(1.9)
    for kind, area in everything:
        assert not area.intersects(streets), kind
    on_pavements = [prop.kind for prop in plan.layout.props if pavements.contains(shapely.Point(prop.centre_m))]
    assert set(on_pavements) <= {"sign"}
    for pool in place_pools(plan.layout, generator(seed, "pools")):
        assert not tree.query(pool, predicate="intersects").size


def test_what_is_new_changes_nothing_when_it_is_off() -> None:
    """Each kind is drawn from a generator of its own: the rest of the town and the traffic stay the same."""
    preset = replace(NEXT_PRESETS["standard"], traffic_keeps_apart=False)
    plain, furnished = (make_plan(each, 4, closed_loop=False) for each in (STANDARD, preset))
    assert plain.layout.props == plain.layout.overpasses == plain.layout.zebras == ()
    assert plain.passers_by is None
    assert furnished.layout.trees == plain.layout.trees
    assert [replace(each, style=None) for each in furnished.layout.buildings] == list(plain.layout.buildings)
    np.testing.assert_array_equal(furnished.motion.position_m, plain.motion.position_m)
    np.testing.assert_array_equal(furnished.camera_poses, plain.camera_poses)
    default = RoadTown("x")
    assert all(getattr(preset, name) == getattr(default, name) for preset in PRESETS.values() for name in NEW)


@pytest.mark.parametrize("field", CHANGED)
def test_a_kept_town_knows_what_it_was_furnished_with(field: str) -> None:
    assert kind_of_town(replace(STANDARD, **{field: CHANGED[field]})) != kind_of_town(STANDARD)


@pytest.mark.parametrize("seed", [0, 1, 2])
def test_people_keep_off_cars_and_cross_streets_at_crossings(seed: int) -> None:
    plan = plan_of("bridges", seed)
    people, motion = plan.passers_by, plan.motion
    assert people is not None
    assert set(people.kinds) == {"person", "cyclist"}
    places = people.T_world[:, :, :2, 3]
    for car in range(len(plan.looks)):
        heading = motion.heading_rad[:, car, None]
        offset = places - motion.position_m[:, car, None]
        along = np.abs(np.cos(heading) * offset[..., 0] + np.sin(heading) * offset[..., 1])
        across = np.abs(np.cos(heading) * offset[..., 1] - np.sin(heading) * offset[..., 0])
        free_m = np.maximum(along - 0.5 * plan.sizes_m[car, 0], across - 0.5 * plan.sizes_m[car, 1])
        assert free_m.min() > 0.6 * CAR_CLEAR_M
    roads = RoadMap(plan.layout.graph)
    zebras = np.array([roads.pose_at(street, arc)[0] for street, arc in plan.layout.zebras])
    on_road = places[roads.is_on_road(places)]
    if len(on_road):
        assert np.linalg.norm(on_road[:, None] - zebras, axis=2).min(axis=1).max() < 8.0
    speed = np.linalg.norm(np.diff(places, axis=0), axis=2) * plan.preset.rate_hz
    assert speed.max() < 6.0
    solid = shapely.union_all([area for kind, some in _areas(plan.layout).items() if kind != "prop" for area in some])
    assert not shapely.contains_xy(solid, places[::10, :, 0].ravel(), places[::10, :, 1].ravel()).any()
    apart = np.linalg.norm(places[:, :, None] - places[:, None], axis=-1) + 9.0 * np.eye(places.shape[1])
    assert (apart < 0.3).mean() < 1e-3


def test_people_are_the_same_for_the_same_seed() -> None:
    again = make_plan(NEXT_PRESETS["bridges"], 1, closed_loop=False)
    np.testing.assert_array_equal(again.passers_by.T_world, plan_of("bridges", 1).passers_by.T_world)
    assert again.layout.overpasses == plan_of("bridges", 1).layout.overpasses


def test_overpasses_stand_where_the_target_drives() -> None:
    passed = total = 0
    for seed in range(4):
        plan = plan_of("bridges", seed)
        total += len(plan.layout.overpasses)
        for each in plan.layout.overpasses:
            under = shapely.Polygon(rectangle(*each.rectangle))
            passed += bool(shapely.contains_xy(under, *plan.motion.position_m[:, 0].T).any())
    assert total >= 6
    assert passed >= 0.5 * total


def test_towns_that_are_kept_have_overpasses_too_and_no_excursion_hits_them() -> None:
    preset = replace(NEXT_PRESETS["bridges"], excursions=(1, 1))
    kept = draw_kept_layout(preset, 3)
    assert kept.overpasses
    plan = make_plan(preset, 5, closed_loop=False, kept=kept)
    assert plan.layout is kept
    solids = shapely.union_all(_areas(kept)["solid"])
    assert shapely.distance(solids, shapely.points(plan.motion.position_m[:, 0])).min() > 1.0


def test_a_car_under_a_deck_is_out_of_sight_and_one_beside_it_is_not() -> None:
    bare = replace(draw_layout(STANDARD, 0), buildings=(), trees=())
    deck = Overpass("road", (0.0, 0.0), 0.0, -30.0, 30.0, 10.0, CLEAR_M, CLEAR_M + 1.0, ())
    sight, size_m = LineOfSight(replace(bare, overpasses=(deck,))), np.array([4.5, 1.8, 1.5])
    camera_m = np.array([0.0, 0.0, 60.0])
    assert sight.is_hidden(camera_m, np.array([0.0, 0.0]), 0.5 * np.pi, size_m)
    assert not sight.is_hidden(camera_m, np.array([0.0, 12.0]), 0.5 * np.pi, size_m)
    # From low and far away one looks under it.
    assert not sight.is_hidden(np.array([0.0, 60.0, 3.0]), np.array([0.0, 0.0]), 0.5 * np.pi, size_m)


def test_kinds_have_their_classes_and_new_ones_come_last() -> None:
    kinds = list(ROAD_TOWN.classes)
    assert kinds[: len(SHIPPED) + 3] == [*SHIPPED, "person", "cyclist", OWN]
    assert [ROAD_TOWN.classes[kind] for kind in ("person", "cyclist")] == ["person", "cyclist"]


@pytest.mark.heavy
def test_a_car_under_a_bridge_is_occluded_and_people_are_labelled() -> None:
    """The state is that of truth's rules; nothing is outside the picture, so no frame-out begins."""
    changes = "overpasses=3,frame_outs.count=0,width_px=320,height_px=240,frame_count=150"
    seen: set[str] = set()
    states: set[str] = set()
    for seed in (0, 2):
        episode = ROAD_TOWN.episode(f"bridges[{changes}]", seed)
        decks = [shapely.Polygon(rectangle(*each.rectangle)) for each in episode.plan.layout.overpasses]
        for _ in range(150):
            truth = episode.step().truth
            seen |= set(truth.standing_kinds)
            here = shapely.Point(truth.T_world_object[0, :2, 3])
            if any(deck.buffer(-3.2).contains(here) for deck in decks) and truth.state[0] != "partial":
                states.add(str(truth.state[0]))
            for name, fraction in zip(truth.standing_names, truth.standing_visible_fraction, strict=True):
                assert 0.0 <= fraction <= 1.0, name
            parts = {limb.body.index for limb in episode._passing.standing}
            ids = {i for standing in episode._passing.standing for i in standing.ids}
            shown = set(np.unique(truth.instance_map).tolist()) & ids
            assert shown <= parts
    assert states == {"occluded"}
    assert "person" in seen


def test_play_without_pictures_names_what_it_refuses() -> None:
    with pytest.raises(ValueError, match=r"overpasses: expected \(0, 0\)"):
        ROAD_TOWN.pictureless.check_playable(NEXT_PRESETS["bridges"])
    with pytest.raises(ValueError, match="instruments"):
        ROAD_TOWN.pictureless.check_playable(replace(NEXT_PRESETS["standard"], ego=None))
    ROAD_TOWN.pictureless.check_playable(NEXT_PRESETS["standard"])
