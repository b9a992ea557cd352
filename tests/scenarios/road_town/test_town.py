"""The world matches the layout, also as seen from above."""

from __future__ import annotations

from collections import Counter
from contextlib import closing
from dataclasses import replace

import cv2
import numpy as np
import pytest
import shapely
from hypothesis import given
from hypothesis import strategies as st

from scenarios.road_town import town
from scenarios.road_town.blocks import fill_blocks
from scenarios.road_town.canvas import KERB
from scenarios.road_town.ground import class_map
from scenarios.road_town.layout import BUILDING, ROAD, Layout
from scenarios.road_town.patterns import make_streets
from scenarios.road_town.plan import draw_layout
from scenarios.road_town.presets import ALTITUDE_RANGE_M, PRESETS
from scenarios.road_town.road_map import RoadMap, road_area
from scenarios.road_town.scenario import ROAD_TOWN, Detail, KeptTown, detail_for, kind_of_town
from scenarios.road_town.town import add_kerbs, add_vehicle, build_town
from scenarios.scenario import KeptWorld
from sim.mesh import Texture
from sim.meshes.ground import ground
from sim.optics import intersect_plane, look_down_pose
from sim.pose import pose_on_ground
from sim.render.raster import Raster
from sim.rng import generator
from sim.shaders.daylight import DaylightShader, Sun
from sim.world import World
from trackers.types import CameraModel

PLAIN = Texture(np.full((4, 4, 3), KERB, np.uint8))


@pytest.fixture(scope="module")
def layout() -> Layout:
    return fill_blocks(make_streets("organic", generator(3, "streets")), generator(3, "blocks"), 420.0)


@pytest.fixture(scope="module")
def world(layout):
    return build_town(layout, generator(3, "town"))


def _corners_world_m(world: World, index: int) -> np.ndarray:
    T = world.poses[index]
    return world.bodies[index].mesh.vertices_m @ T[:3, :3].T + T[:3, 3]


@pytest.mark.heavy
def test_there_is_one_body_a_thing(world, layout):
    count = Counter(body.category for body in world.bodies)
    assert count["building"] == len(layout.buildings)
    assert count["tree"] == len(layout.trees)
    assert count["vehicle"] == sum(sum(park.taken) for park in layout.car_parks)
    assert count["ground"] == 2
    assert set(count) == {"ground", "kerb", "building", "tree", "vehicle", "wood", "hedge"}
    assert len({body.name for body in world.bodies}) == len(world.bodies)
    assert not any(body.movable for body in world.bodies)


@pytest.mark.heavy
def test_houses_stand_on_their_footprints(world, layout):
    houses = [body for body in world.bodies if body.category == "building"]
    for building, body in zip(layout.buildings, houses, strict=True):
        corners = _corners_world_m(world, body.index)
        c, s = np.cos(building.yaw_rad), np.sin(building.yaw_rad)
        local = (corners[:, :2] - building.centre_m) @ np.array([[c, -s], [s, c]])
        # Roofs overhang by less than a metre on each side.
        beyond = np.ptp(local, axis=0) - building.size_m[:2]
        assert ((beyond > -0.01) & (beyond < 2.0)).all()
        assert abs(corners[:, 2].min()) < 1e-4
        assert building.size_m[2] <= corners[:, 2].max() < building.size_m[2] + 8.0


def test_only_cars_and_kerbs_touch_paved_ground(world, layout):
    roads = road_area(layout.graph)
    for body in world.bodies:
        if body.category == "building":
            hull = shapely.MultiPoint(_corners_world_m(world, body.index)[:, :2]).convex_hull
            assert not hull.intersects(roads), body.name


def test_kerbs_run_along_the_edge_of_the_road(world, layout):
    edge = road_area(layout.graph).boundary
    corners = np.concatenate([_corners_world_m(world, b.index) for b in world.bodies if b.category == "kerb"])
    assert shapely.distance(edge, shapely.points(corners[:, :2])).max() < 0.3
    assert corners[:, 2].max() == pytest.approx(0.04)
    # The whole edge has a kerb: the joined outlines of its pieces reach each point.
    outlines = [
        shapely.LineString(_corners_world_m(world, b.index)[face][[0, 1, 2, 0], :2])
        for b in world.bodies
        if b.category == "kerb"
        for face in b.mesh.faces
    ]
    tree = shapely.STRtree(outlines)
    along = shapely.points(shapely.get_coordinates(shapely.segmentize(edge, 3.0)))
    _, distance = tree.query_nearest(along, return_distance=True, all_matches=False)
    assert distance.max() < 0.3


def test_no_dark_dots_along_kerbs(layout, monkeypatch):
    """Kerbs in the sun and the ground beside them are nowhere as dark as the sides of a high, upright kerb."""
    darkest = {}
    for name, changes in (("shipped", {}), ("upright", {"_KERB_SIZE_M": (0.2, 0.12), "_KERB_BEVEL_M": 0.001})):
        world = World()
        with monkeypatch.context() as patch:
            for constant, value in changes.items():
                patch.setattr(town, constant, value)
            world.add(ground(layout.extent_m, PLAIN), np.eye(4), name="ground", category="ground")
            add_kerbs(world, layout)
            shader = DaylightShader(world, Sun((0.7, 0.2, 0.6), 90_000.0), 18_000.0)
            middles_m = [street.centre_m[len(street.centre_m) // 2] for street in layout.graph.streets[:8]]
            darkest[name] = min(_darkest(world, shader, middle_m) for middle_m in middles_m)
    assert darkest["shipped"] > 0.4
    assert darkest["upright"] < 0.25


def _darkest(world: World, shader: DaylightShader, middle_m: np.ndarray) -> float:
    """Return the darkest pixel of a picture from 60 m above, as a share of the median."""
    camera = CameraModel.from_field_of_view(320, 240, np.deg2rad(25))
    T_world_camera = look_down_pose(np.array([*middle_m, 60.0]), 0.4, 0.15, 0.1)
    seen = Raster(world).gbuffer(camera, T_world_camera)
    kerbs = [body.index for body in world.bodies if body.category == "kerb"]
    assert np.isin(seen.instance_id, kerbs).sum() > 300
    lux = shader.shade(seen, camera, T_world_camera)[:, 1]
    return float(lux.min() / np.median(lux))


def test_parked_cars_stand_in_their_bays(world, layout):
    cars = [body for body in world.bodies if body.category == "vehicle"]
    parks = [shapely.Polygon(_park_corners(park)).buffer(0.2) for park in layout.car_parks]
    for car in cars:
        hull = shapely.MultiPoint(_corners_world_m(world, car.index)[:, :2]).convex_hull
        assert any(park.contains(hull.centroid) for park in parks)
        assert max(park.intersection(hull).area for park in parks) > 0.9 * hull.area


def _park_corners(park) -> np.ndarray:
    c, s = np.cos(park.yaw_rad), np.sin(park.yaw_rad)
    return park.centre_m + 0.5 * np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]]) * park.size_m @ [[c, s], [-s, c]]


def test_seen_from_above_classes_and_pictures_agree(world, layout):
    """A view straight down shows houses where the class map has buildings, and asphalt where it has road."""
    camera = CameraModel.from_field_of_view(320, 240, np.deg2rad(50))
    classes = class_map(layout, 0.25)
    inside = cv2.erode((classes == BUILDING).astype(np.uint8), np.ones((5, 5), np.uint8)) > 0
    low_ids = [body.index for body in world.bodies if body.category in ("ground", "kerb", "vehicle")]
    renderer = Raster(world)
    asphalt, houses_seen = [], 0
    for street in layout.graph.streets[:6]:
        middle = street.centre_m[len(street.centre_m) // 2]
        T_world_camera = look_down_pose(np.array([*middle, 60.0]), 0.4, 0.0, 0.0)
        seen = renderer.gbuffer(camera, T_world_camera)
        rows, columns = np.mgrid[0:240, 0:320]
        ground_m = intersect_plane(camera, T_world_camera, np.stack([columns + 0.5, rows + 0.5], axis=-1), 0.0)
        cells = np.floor(np.stack([210 - ground_m[..., 1], ground_m[..., 0] + 210], axis=-1) / 0.25).astype(int)
        expected = classes[cells[..., 0], cells[..., 1]]
        # Walls lean outwards in perspective, so no ground is seen where a house stands.
        standing = seen.instance_id[inside[cells[..., 0], cells[..., 1]]]
        assert not np.isin(standing, low_ids).any()
        houses_seen += len(standing)
        open_road = (expected == ROAD) & (seen.instance_id == 0)
        assert open_road.sum() > 500
        asphalt.append(seen.base_colour_rgb[open_road].astype(float))
    assert houses_seen > 2000
    colours = np.concatenate(asphalt)
    # Asphalt, lines and kerbs are grey.
    assert np.median(np.ptp(colours, axis=1)) < 12
    assert 60 < np.median(colours) < 120


def test_every_lane_is_free_for_driving(world, layout):
    """Only kerbs and ground are below 2 m over a lane's centre; trees may hang over."""
    roads = RoadMap(layout.graph)
    lanes = []
    for street, length_m in enumerate(roads.length_m):
        for side in (-0.25, 0.25):
            arc = np.arange(0.0, length_m, 1.0)
            lanes.append(roads.pose_at(np.full(len(arc), street), arc, side * roads.width_m[street])[0])
    free = shapely.union_all([shapely.LineString(lane).buffer(1.2) for lane in lanes])
    shapely.prepare(free)
    for body in world.bodies:
        if body.category in ("building", "tree", "vehicle"):
            corners = _corners_world_m(world, body.index)
            low = corners[corners[:, 2] < 2.0]
            assert not shapely.contains_xy(free, low[:, 0], low[:, 1]).any(), body.name


@pytest.mark.heavy
def test_same_generator_same_world(world, layout):
    again = build_town(layout, generator(3, "town"))
    assert len(again.bodies) == len(world.bodies)
    np.testing.assert_array_equal(again.poses, world.poses)
    for first, second in zip(world.bodies, again.bodies, strict=True):
        assert (first.name, first.category) == (second.name, second.category)
        np.testing.assert_array_equal(first.mesh.vertices_m, second.mesh.vertices_m)
        np.testing.assert_array_equal(first.mesh.uv, second.mesh.uv)
        np.testing.assert_array_equal(first.mesh.texture.rgb, second.mesh.texture.rgb)


def test_a_car_that_moves(layout):
    world = World()
    body = add_vehicle(world, "target", "sedan", (176, 24, 26))
    world.move(body, pose_on_ground(3.0, -4.0, 0.5))
    assert body.category == "vehicle"
    np.testing.assert_allclose(world.poses[body.index] @ [1, 0, 0, 1], [3 + np.cos(0.5), -4 + np.sin(0.5), 0, 1])


def test_a_town_that_another_thread_forgets_meanwhile_is_whole(world, monkeypatch):
    class Interrupted:
        def copy(self) -> World:
            town.forget_town()
            return world.copy()

    monkeypatch.setattr(town, "build_town", lambda layout, rng, **others: Interrupted())
    for _ in range(2):
        again = town.town_of(3, "streets")
        assert [body.name for body in again.bodies] == [body.name for body in world.bodies]
        np.testing.assert_array_equal(again.poses, world.poses)
    town.forget_town()


@given(
    side_px=st.integers(32, 1024),
    field_of_view_deg=st.floats(15.0, 100.0),
    extent_m=st.floats(300.0, 900.0),
)
def test_a_kept_town_is_as_sharp_as_pictures_from_the_lowest_height(side_px, field_of_view_deg, extent_m):
    preset = replace(
        PRESETS["standard"],
        width_px=side_px,
        height_px=side_px,
        field_of_view_deg=field_of_view_deg,
        extent_m=extent_m,
    )
    detail = detail_for(preset)
    pixel_m = ALTITUDE_RANGE_M[0] * 2.0 * np.tan(np.radians(field_of_view_deg / 2.0)) / side_px
    texel_m = extent_m / detail.ground_px
    assert texel_m <= pixel_m or detail.ground_px == Detail().ground_px
    assert texel_m > 0.5 * pixel_m or detail.ground_px == 64
    assert 3 * side_px <= detail.shadow_texels or detail.shadow_texels == Detail().shadow_texels


def test_a_kept_town_has_the_catalogue_s_detail_where_pictures_show_it():
    assert detail_for(PRESETS["standard"]) == Detail()
    assert kind_of_town(PRESETS["standard"]) != kind_of_town(replace(PRESETS["standard"], width_px=84, height_px=84))


@pytest.mark.heavy
def test_a_small_picture_of_a_kept_town_is_that_of_a_fine_one():
    small = replace(PRESETS["quick"], width_px=84, height_px=84)
    layout, pictures = draw_layout(small, 3), []
    for detail in (Detail(), detail_for(small)):
        world = build_town(layout, generator(3, "town"), detail.ground_px)
        kept = KeptWorld(world, KeptTown(layout, detail))
        with closing(ROAD_TOWN.episode(small, 3, closed_loop=True, kept=kept)) as episode:
            pictures.append(episode.step().observation.image_rgb.astype(float))
    fine, coarse = pictures
    # The paint's grain differs, houses, streets and shadows do not.
    smooth = [cv2.GaussianBlur(picture, (0, 0), 2.0).ravel() for picture in (fine, coarse)]
    assert np.corrcoef(*smooth)[0, 1] > 0.9
    assert abs(fine.mean() - coarse.mean()) < 6.0
