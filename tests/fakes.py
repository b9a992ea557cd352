"""Hand-drawn observations: a painted ground under a pinhole camera. No simulator, so trackers can be tried alone."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from trackers.types import CameraModel, EgoPose, Observation

CAMERA = CameraModel(width_px=640, height_px=480, focal_px=640.0)
CAR_M = (4.5, 2.0)
ROAD_WIDTH_M = 8.0
_SCALE = 10.0  # pixels of the painted ground per metre


@dataclass(frozen=True)
class DrawnFrame:
    """A picture and where its car really is: centre (2,) in pixels, heading in the picture, box (4,)."""

    observation: Observation
    position_px: NDArray[np.float64]
    heading_rad: float
    box_xyxy: NDArray[np.float64]


def straight_road(length_m: float = 240.0) -> NDArray[np.float64]:
    """Return the centre line (M, 2) in metres of a road along world x, through the origin."""
    return np.column_stack([np.linspace(-length_m / 2, length_m / 2, 400), np.zeros(400)])


def bent_road(radius_m: float, straight_m: float = 60.0) -> NDArray[np.float64]:
    """Return the centre line of a road along world x that turns left by a quarter circle at the origin."""
    quarter = np.linspace(0, np.pi / 2, 200)
    arc = radius_m * np.column_stack([np.sin(quarter), 1 - np.cos(quarter)])
    before = np.column_stack([np.linspace(-straight_m, -0.5, 200), np.zeros(200)])
    after = arc[-1] + np.column_stack([np.zeros(200), np.linspace(0.5, straight_m, 200)])
    return np.concatenate([before, arc, after])


def along(line_m: NDArray[np.float64], distance_m: float) -> tuple[NDArray[np.float64], float]:
    """Return the point (2,) and the direction in radians at a distance from a line's start."""
    steps = np.hypot(*np.diff(line_m, axis=0).T)
    lengths = np.concatenate([[0.0], np.cumsum(steps)])
    point = np.array([np.interp(distance_m, lengths, line_m[:, i]) for i in (0, 1)])
    ahead = np.array([np.interp(distance_m + 0.5, lengths, line_m[:, i]) for i in (0, 1)])
    return point, float(np.arctan2(*(ahead - point)[::-1]))


def look_down(x_m: float, y_m: float, height_m: float, yaw_rad: float) -> NDArray[np.float64]:
    """Return T_world_camera (4, 4) of a camera that looks straight down, the top of its picture along ``yaw_rad``."""
    c, s = np.cos(yaw_rad), np.sin(yaw_rad)
    T = np.eye(4)
    T[:3, :3] = [[s, -c, 0], [-c, -s, 0], [0, 0, -1]]
    T[:3, 3] = x_m, y_m, height_m
    return T


class DrawnTown:
    """A ground of grass with one road on it: grey, with white edge lines, a dashed centre line and pavements.

    Args:
        road_m: (M, 2) centre line.
        extent_m: side of the painted square about the origin.
        rng: paints the grain.
        car_rgb: colour of the car.
        bare: True leaves the road out.
    """

    def __init__(
        self,
        road_m: NDArray[np.float64],
        extent_m: float,
        rng: np.random.Generator,
        car_rgb: tuple[int, int, int] = (200, 30, 40),
        bare: bool = False,
    ) -> None:
        self._extent_m = extent_m
        self._car_rgb = car_rgb
        side = round(extent_m * _SCALE)
        ground = np.empty((side, side, 3), np.uint8)
        ground[:] = (88, 118, 62)
        if not bare:
            self._paint_road(ground, road_m)
        blotches = cv2.resize(rng.normal(0, 1, (side // 16, side // 16)).astype(np.float32), (side, side))
        grain = rng.normal(0, 5, (side, side)).astype(np.float32) + 9 * blotches
        self.ground_rgb = np.clip(ground + grain[..., None], 0, 255).astype(np.uint8)

    def _paint_road(self, ground: NDArray[np.uint8], road_m: NDArray[np.float64]) -> None:
        line = np.round(self._to_ground(road_m) * 16).astype(np.int32).reshape(-1, 1, 2)

        def stroke(width_m: float, colour: tuple[int, int, int]) -> None:
            cv2.polylines(ground, [line], False, colour, round(width_m * _SCALE), cv2.LINE_8, shift=4)

        stroke(ROAD_WIDTH_M + 4.0, (150, 145, 138))
        stroke(ROAD_WIDTH_M, (82, 82, 86))
        stroke(ROAD_WIDTH_M - 0.6, (225, 225, 225))
        stroke(ROAD_WIDTH_M - 1.0, (82, 82, 86))
        for i in range(0, len(road_m) - 8, 16):
            cv2.polylines(ground, [line[i : i + 8]], False, (225, 225, 225), 2, cv2.LINE_8, shift=4)

    def _to_ground(self, points_m: NDArray[np.float64]) -> NDArray[np.float64]:
        return (points_m + 0.5 * self._extent_m) * _SCALE

    def frame(
        self,
        T_world_camera: NDArray[np.float64],
        car_m: NDArray[np.float64],
        car_yaw_rad: float,
        time_s: float,
        measured: bool = True,
    ) -> DrawnFrame:
        """Draw what a camera sees, with the car at a place (2,) of the ground."""
        c, s = np.cos(car_yaw_rad), np.sin(car_yaw_rad)
        corners = np.array([[1, 1], [1, -1], [-1, -1], [-1, 1]]) * 0.5 * np.array(CAR_M)
        corners = corners @ np.array([[c, s], [-s, c]]) + car_m
        H_pixel_world = _ground_homography(T_world_camera)
        H_world_ground = np.array([[1 / _SCALE, 0, -0.5 * self._extent_m], [0, 1 / _SCALE, -0.5 * self._extent_m]])
        H = H_pixel_world @ np.vstack([H_world_ground, [0, 0, 1]])
        half = np.array([[1, 0, 0.5], [0, 1, 0.5], [0, 0, 1]])
        image = cv2.warpPerspective(
            self.ground_rgb, np.linalg.inv(half) @ H @ half, (CAMERA.width_px, CAMERA.height_px),
            flags=cv2.INTER_AREA, borderMode=cv2.BORDER_REFLECT,
        )  # fmt: skip
        corners_px = _apply(H_pixel_world, corners)
        cv2.fillConvexPoly(image, np.round((corners_px - 0.5) * 16).astype(np.int32), self._car_rgb, cv2.LINE_AA, 4)
        position_px = _apply(H_pixel_world, np.asarray(car_m, float)[None])[0]
        ahead = _apply(H_pixel_world, np.asarray(car_m, float)[None] + 0.1 * np.array([[c, s]]))[0]
        ego = EgoPose(T_world_camera) if measured else None
        return DrawnFrame(
            Observation(image, time_s, CAMERA, ego=ego),
            position_px,
            float(np.arctan2(*(ahead - position_px)[::-1])),
            np.concatenate([corners_px.min(axis=0), corners_px.max(axis=0)]),
        )


def drive(
    town: DrawnTown,
    road_m: NDArray[np.float64],
    start_m: float,
    step_m: float,
    poses: list[NDArray[np.float64]],
    measured: bool = True,
    lane_m: float = -2.0,
) -> Iterator[DrawnFrame]:
    """Yield one frame for each camera pose while the car drives on along a road, ``lane_m`` left of its centre."""
    for k, T_world_camera in enumerate(poses):
        centre, yaw = along(road_m, start_m + k * step_m)
        car_m = centre + lane_m * np.array([-np.sin(yaw), np.cos(yaw)])
        yield town.frame(T_world_camera, car_m, yaw, k / 15.0, measured)


def _ground_homography(T_world_camera: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return H (3, 3): metres on the ground to pixels."""
    K = np.array([[CAMERA.focal_px, 0, CAMERA.width_px / 2], [0, CAMERA.focal_px, CAMERA.height_px / 2], [0, 0, 1]])
    R = T_world_camera[:3, :3].T
    return K @ np.column_stack([R[:, 0], R[:, 1], -R @ T_world_camera[:3, 3]])


def _apply(H: NDArray[np.float64], points: NDArray[np.float64]) -> NDArray[np.float64]:
    projected = np.column_stack([points, np.ones(len(points))]) @ H.T
    return projected[:, :2] / projected[:, 2:]
