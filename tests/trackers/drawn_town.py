"""Hand-drawn town seen by a swinging camera: quick pictures with known truth, without the simulator's renderer."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from sim.optics import intersect_plane, look_down_pose, project
from trackers.types import CameraModel, EgoPose, Observation

METRES_PER_TEXEL = 0.125
EXTENT_M = 320.0
CAR_M = (4.5, 1.8)
STREETS_M = (-80.0, 0.0, 80.0)
ROAD_WIDTH_M = 7.0
_SPEED_MPS = 8.0


@dataclass(frozen=True)
class DrawnFrame:
    """One picture and its truth; ``along_px`` (2,) points from the car's centre to its nose."""

    observation: Observation
    T_world_camera: NDArray[np.float64]
    car_px: NDArray[np.float64]
    along_px: NDArray[np.float64]
    box_xyxy: NDArray[np.float64]
    inside: bool


def ground_texture(rng: np.random.Generator) -> NDArray[np.uint8]:
    """Return the ground (S, S, 3) uint8: grass, a lattice of streets with lines, houses between them."""
    size = int(EXTENT_M / METRES_PER_TEXEL)
    coarse = rng.normal(0, 1, (size // 16, size // 16)).astype(np.float32)
    patches = cv2.resize(coarse, (size, size), interpolation=cv2.INTER_CUBIC)
    texture = np.array([80, 110, 60], np.float32) + 10 * patches[..., None]
    for _ in range(260):
        corner = rng.uniform(-EXTENT_M / 2, EXTENT_M / 2 - 12, 2)
        low, high = _texel(corner), _texel(corner + rng.uniform(4, 12, 2))
        cv2.rectangle(texture, low, high, rng.uniform(40, 220, 3).tolist(), -1)
    for centre in STREETS_M:
        for axis in (0, 1):
            _street(texture, centre, axis)
    texture += rng.normal(0, 6, (size, size, 1))
    return np.clip(texture, 0, 255).astype(np.uint8)


def _texel(xy_m: NDArray[np.float64]) -> tuple[int, int]:
    return tuple(np.round((np.asarray(xy_m) + EXTENT_M / 2) / METRES_PER_TEXEL).astype(int).tolist())


def _street(texture: NDArray[np.float32], centre_m: float, axis: int) -> None:
    ends = np.array([[-EXTENT_M / 2, centre_m], [EXTENT_M / 2, centre_m]])
    ends = ends if axis == 0 else ends[:, ::-1]
    width = int(ROAD_WIDTH_M / METRES_PER_TEXEL)
    cv2.line(texture, _texel(ends[0]), _texel(ends[1]), (170, 168, 160), width + 32)
    cv2.line(texture, _texel(ends[0]), _texel(ends[1]), (95, 95, 98), width)
    along, across = (ends[1] - ends[0]) / EXTENT_M, np.array([0.0, 1.0]) if axis == 0 else np.array([1.0, 0.0])
    for start in np.arange(0, EXTENT_M, 6.0):
        dash = [_texel(ends[0] + along * (start + d)) for d in (0.0, 3.0)]
        cv2.line(texture, *dash, (225, 225, 225), 2)
    for side in (-1, 1):
        edge = [_texel(end + side * across * (ROAD_WIDTH_M / 2 - 0.3)) for end in ends]
        cv2.line(texture, *edge, (225, 225, 225), 2)


def draw_car(
    picture: NDArray[np.uint8],
    camera: CameraModel,
    T_world_camera: NDArray[np.float64],
    xy_m: NDArray[np.float64],
    heading_rad: float,
    rgb: tuple[int, int, int],
) -> None:
    """Draw body and windows of a car into ``picture``."""
    parts = (((-1, 1, -1, 1), rgb), ((0.1, 0.4, -0.8, 0.8), (35, 40, 45)), ((-0.8, -0.6, -0.8, 0.8), (35, 40, 45)))
    for (rear, front, right, left), colour in parts:
        local = np.array([[front, left], [front, right], [rear, right], [rear, left]]) * np.array(CAR_M) / 2
        pixels = _project_local(camera, T_world_camera, xy_m, heading_rad, local)
        cv2.fillConvexPoly(picture, np.round((pixels - 0.5) * 16).astype(np.int32), colour, cv2.LINE_AA, 4)


def _project_local(
    camera: CameraModel,
    T_world_camera: NDArray[np.float64],
    xy_m: NDArray[np.float64],
    heading_rad: float,
    local_m: NDArray[np.float64],
) -> NDArray[np.float64]:
    c, s = np.cos(heading_rad), np.sin(heading_rad)
    world = np.column_stack([local_m @ np.array([[c, s], [-s, c]]) + xy_m, np.zeros(len(local_m))])
    return project(camera, T_world_camera, world)[0]


def drive(frames: int, rate_hz: float, lane_y_m: float) -> NDArray[np.float64]:
    """Return x, y, heading (F, 3) of a car that drives east on a lane of the street along y = 0."""
    x = -60.0 + _SPEED_MPS / rate_hz * np.arange(frames)
    return np.column_stack([x, np.full(frames, lane_y_m), np.zeros(frames)])


def film(
    seed: int,
    frames: int = 120,
    *,
    out: tuple[int, int] = (50, 80),
    with_ego: bool = False,
    decoys: int = 3,
    jump_m: float = 0.0,
    lane_y_m: float = -ROAD_WIDTH_M / 4,
) -> list[DrawnFrame]:
    """Return a short film: the car drives, and in ``out`` (first, last frame) a gust swings the view off it.

    Half-way through ``out`` the car jumps ``jump_m`` ahead (or back); the camera does not follow the jump.
    It drives east on the lane at ``lane_y_m``, by default on the right.
    """
    rng = np.random.default_rng(seed)
    camera = CameraModel.from_field_of_view(640, 480, np.deg2rad(50))
    texture = ground_texture(rng)
    path = drive(frames, 15.0, lane_y_m)
    jump = np.where(np.arange(frames) < sum(out) // 2, 0.0, jump_m)
    noise = np.zeros(5)
    result = []
    decoy_y_m, decoy_rgb = rng.uniform(-90, 90, decoys), rng.uniform(20, 240, (decoys, 3))
    for k in range(frames):
        noise = 0.95 * noise + rng.normal(0, 1, 5) * [0.006, 0.006, 0.006, 0.15, 0.15]
        ramp = np.clip(min(k - out[0] + 8, out[1] + 8 - k) / 12.0, 0, 1)
        position = np.array([*(path[max(0, k - 10), :2] + noise[3:] + [2, 4]), 65.0 + 3 * np.sin(k / 40)])
        pose = look_down_pose(position, 0.3 + noise[2] + 0.004 * k, noise[0], noise[1] + 0.62 * ramp)
        picture = _picture(texture, camera, pose, rng)
        for y_m, rgb in zip(decoy_y_m, decoy_rgb, strict=True):
            xy = np.array([ROAD_WIDTH_M / 4, (y_m + 6 * k / 15 + 100) % 200 - 100])
            draw_car(picture, camera, pose, xy, np.pi / 2, tuple(rgb.tolist()))
        xy, heading = path[k, :2] + [jump[k], 0.0], float(path[k, 2])
        draw_car(picture, camera, pose, xy, heading, (190, 40, 30))
        picture = np.clip(picture + rng.normal(0, 3, picture.shape), 0, 255).astype(np.uint8)
        local = np.array([[1, 1], [1, -1], [-1, -1], [-1, 1]]) * np.array(CAR_M) / 2
        corners = _project_local(camera, pose, xy, heading, local)
        centre, nose = _project_local(camera, pose, xy, heading, np.array([[0, 0], [CAR_M[0] / 2, 0]]))
        measured = pose.copy()
        measured[:3, 3] += rng.normal(0, 0.3, 3) + 2.0
        observation = Observation(
            picture, k / 15.0, CameraModel(640, 480, camera.focal_px), ego=EgoPose(measured) if with_ego else None
        )
        box = np.array([*corners.min(0), *corners.max(0)])
        inside = bool((centre >= 0).all() and (centre < [640, 480]).all())
        result.append(DrawnFrame(observation, pose, centre, nose - centre, box, inside))
    return result


def _picture(
    texture: NDArray[np.uint8], camera: CameraModel, pose: NDArray[np.float64], rng: np.random.Generator
) -> NDArray[np.uint8]:
    corners_px = np.array([[0, 0], [640, 0], [640, 480], [0, 480]], float)
    ground = intersect_plane(camera, pose, corners_px, 0.0)
    texels = (ground + EXTENT_M / 2) / METRES_PER_TEXEL
    warp = cv2.getPerspectiveTransform((texels - 0.5).astype(np.float32), (corners_px - 0.5).astype(np.float32))
    return cv2.warpPerspective(texture, warp, (640, 480), flags=cv2.INTER_LINEAR, borderMode=cv2.BORDER_REFLECT)
