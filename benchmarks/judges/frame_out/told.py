"""Ours, told what no picture says: where it lies on its own map. See ``told_rows``."""

from __future__ import annotations

from dataclasses import replace

import cv2
import numpy as np
from numpy.typing import NDArray

from scenarios.loop import first_box, given
from scenarios.road_town.layout import RoadGraph
from scenarios.road_town.road_map import road_area
from scenarios.scenario import Frame
from sim.optics import intersect_plane
from trackers import registry
from trackers.kernels.ground_camera import CENTRE_HEIGHT_M, GroundCamera
from trackers.mosaic_graph.kernels.road_position import Roads
from trackers.mosaic_graph.map_tracker import MapTracker
from trackers.mosaic_graph.mosaic import Mosaic
from trackers.mosaic_graph.road_graph import RoadSketch, even
from trackers.mosaic_graph.road_network import GRID_M, ColourRoads, RoadFinder, SeenGround, roads_about
from trackers.types import Estimate, Start

_OURS = "mosaic_graph_pf"
_GRID = 5
"""Pixels along each side of a picture by which the world is laid on the tracker's map."""


class Laid:
    """The world on the tracker's map, which differs from it by the errors of the measured pose."""

    def __init__(self) -> None:
        self._R, self._t = np.eye(2), np.zeros(2)

    def lay(self, frame: Frame, camera: GroundCamera) -> None:
        """Fit world to map, turned and shifted, at what a picture shows of the ground. ``camera``: the tracker's."""
        size_px = np.array([camera.model.width_px, camera.model.height_px])
        shares = np.stack(np.meshgrid(*[np.linspace(0.0, 1.0, _GRID)] * 2), axis=-1).reshape(-1, 2)
        pixels = shares * size_px
        world_m = intersect_plane(frame.camera, frame.truth.T_world_camera, pixels, 0.0)
        map_m = camera.to_map(pixels)
        both = np.isfinite(world_m).all(axis=1) & np.isfinite(map_m).all(axis=1)
        if np.count_nonzero(both) >= 2:
            self._R, self._t = rigid(world_m[both], map_m[both])

    def turned(self, vectors: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return vectors (N, 2) of the world as they are on the map."""
        return vectors @ self._R.T

    def placed(self, points_m: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return points (N, 2) of the world as they are on the map."""
        return self.turned(points_m) + self._t


class TrueGraph:
    """Draws the true streets; see ``RoadSource``."""

    has_learnt = True

    def __init__(self, graph: RoadGraph, laid: Laid) -> None:
        nodes_m, lines = graph.nodes_m, []
        for street in graph.streets:
            inner_m = street.centre_m[1:-1]
            lines.append(even(np.vstack([nodes_m[street.start], inner_m, nodes_m[street.end]])))
        self._graph, self._laid = RoadSketch(lines).finished(), laid

    def learn(self, driven_m: NDArray[np.float64]) -> None:
        """See ``RoadSource``. There is nothing to learn."""

    def draw(self, mosaic: Mosaic, centre_m: NDArray[np.float64]) -> Roads:
        """See ``RoadSource``."""
        points_m, tangents = self._laid.placed(self._graph.points_m), self._laid.turned(self._graph.tangents)
        return roads_about(self._graph._replace(points_m=points_m, tangents=tangents), centre_m)


class TrueGround(RoadFinder):
    """Knows which of the ground in the mosaic is road."""

    def __init__(self, graph: RoadGraph, laid: Laid) -> None:
        area = road_area(graph)
        parts = list(getattr(area, "geoms", [area]))
        self._outlines = [np.array(part.exterior.coords) for part in parts]
        self._holes = [np.array(hole.coords) for part in parts for hole in part.interiors]
        self._laid = laid

    def probability(self, ground: SeenGround) -> NDArray[np.float32]:
        """See ``RoadFinder``."""
        road = np.zeros(ground.seen.shape, np.float32)
        for rings, value in ((self._outlines, 1.0), (self._holes, 0.0)):
            cells = [(self._laid.placed(ring) - ground.origin_m) / GRID_M - 0.5 for ring in rings]
            cv2.fillPoly(road, [np.round(each).astype(np.int32) for each in cells], value)
        return road


def rigid(before: NDArray[np.float64], after: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return rotation (2, 2) and shift (2,) that take points (N, 2) to others with the least sum of squares."""
    a, b = before - before.mean(axis=0), after - after.mean(axis=0)
    angle = np.arctan2(np.sum(a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]), np.sum(a * b))
    R = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    return R, after.mean(axis=0) - R @ before.mean(axis=0)


class ToldTracker:
    """Runs ours on the pictures of an episode, and tells it what it is to know; see ``LoopTracker``."""

    def __init__(self, graph: RoadGraph, target: str, rng: np.random.Generator, *, state: bool, roads: str) -> None:
        """Args:
        target: name of the car.
        state, roads: see ``told_rows.Told``.
        """
        self._target, self._rng, self._knows_state = target, rng, state
        self._laid = Laid()
        kinds: dict[str, type[TrueGraph] | type[TrueGround]] = {"graph": TrueGraph, "seen": TrueGround}
        self._roads = kinds[roads](graph, self._laid) if roads else ColourRoads()

    def initialise(self, frame: Frame, start: Start) -> Estimate:
        """See ``LoopTracker``."""
        parameters = registry.entry(_OURS).parameters()
        self._tracker = MapTracker(parameters, self._rng, frame.observation, first_box(start), self._roads)
        self._laid.lay(frame, self._tracker.camera)
        return given(start)

    def update(self, frame: Frame) -> Estimate:
        """See ``LoopTracker``. On the first frame outside the answer is the true place, if the state is told."""
        estimate = self._tracker.update(frame.observation)
        self._laid.lay(frame, self._tracker.camera)
        truth, target = frame.truth, frame.truth.index_of(self._target)
        if not self._knows_state or truth.frames_since_exit[target] != 0:
            return estimate
        T = truth.T_world_object[target]
        # By way of the picture, in which answers are scored: the tracker's map differs from the world.
        places_px = self._pixels_of(frame, np.array([[0.0, 0.0], [1.0, 0.0]]) @ T[:2, :2].T + T[:2, 3])
        here_m, ahead_m = self._tracker.camera.to_map(places_px, CENTRE_HEIGHT_M)
        heading_rad = float(np.arctan2(*(ahead_m - here_m)[::-1]))
        if np.isfinite(heading_rad):
            self._tracker.correct(here_m, heading_rad, float(truth.speed_mps[target]))
        return replace(estimate, position_px=places_px[0])

    def _pixels_of(self, frame: Frame, places_m: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the pixels (N, 2) of places (N, 2) in the world, at half the height of a car."""
        camera = GroundCamera(self._tracker.camera.model, frame.truth.T_world_camera, np.zeros(2))
        return camera.to_picture(places_m, CENTRE_HEIGHT_M)
