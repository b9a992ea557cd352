"""Stereo pairs of people in front of a wall, drawn by hand: every surface is a textured plane at a known position.

The frame is the robot's: x ahead, y to the left, z up, metres, the level left camera above the origin.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import lru_cache

import cv2
import numpy as np
from numpy.typing import NDArray

from trackers.light_adaptive_stereo.robot_frame import Mounting
from trackers.types import CameraModel, CameraRegisters, CameraSettings, EgoPose, Estimate, Observation

CAMERA = CameraModel(width_px=640, height_px=480, focal_px=493.0, baseline_m=0.12)
CAMERA_HEIGHT_M = 1.2
LEVEL = Mounting.level(CAMERA_HEIGHT_M)
CALM = CameraRegisters(red=500, blue=600, shutter=400, gain=0)
RED, BLUE, GREEN, GREY = (190, 60, 50), (50, 80, 190), (60, 160, 70), (150, 145, 140)
RATE_HZ = 15.0
_TEXEL_M = 0.012
_TEXELS = 512


@dataclass(frozen=True)
class Board:
    """An upright textured board that faces the camera; a person has a head.

    Attributes:
        ahead_m, left_m: of its middle.
        width_m, height_m: of it; it stands on the ground.
        head: whether the topmost 0.25 m are only 0.2 m wide.
    """

    ahead_m: float
    left_m: float
    rgb: tuple[int, int, int] = RED
    width_m: float = 0.5
    height_m: float = 1.7
    head: bool = True


def place_of(estimate: Estimate) -> NDArray[np.float64]:
    """Return the place (2,) of an answer in the robot's frame."""
    assert estimate.depth_m is not None
    return LEVEL.place_at(estimate.position_px, estimate.depth_m, CAMERA)[:2]


def person_box(person: Board) -> NDArray[np.float64]:
    """Return the box (4,) in the left picture of a board."""
    scale = CAMERA.focal_px / person.ahead_m
    x, y = 320.0 - scale * person.left_m, 240.0 + scale * CAMERA_HEIGHT_M
    half = 0.5 * scale * person.width_m
    return np.array([x - half, y - scale * person.height_m, x + half, y])


def draw_pair(
    boards: Sequence[Board], wall_m: float = 9.0, noise: float = 2.0, seed: int = 0
) -> tuple[NDArray[np.uint8], NDArray[np.uint8]]:
    """Return the left and right picture (480, 640, 3) of boards on textured ground in front of a wide wall."""
    pair = []
    for eye in (0, 1):
        picture = _background(wall_m, eye).copy()
        for index, board in enumerate(sorted(boards, key=lambda board: -board.ahead_m)):
            _draw(picture, board, eye, 3 + index)
        # The same noise, shifted.
        picture += noise * np.roll(_noise(), (2 * seed + eye) * 7919)
        pair.append(np.clip(picture + 0.5, 0, 255).astype(np.uint8))
    return pair[0], pair[1]


def observation(
    boards: Sequence[Board], frame: int = 0, registers: CameraRegisters = CALM, right: bool = True, **drawn: float
) -> Observation:
    """Return the observation of a drawn frame."""
    left_rgb, right_rgb = draw_pair(boards, seed=frame, **drawn)
    settings = CameraSettings(exposure_s=0.01, gain=1.0, registers=registers)
    return Observation(left_rgb, frame / RATE_HZ, CAMERA, settings, None, right_rgb if right else None)


def posed(of: Observation, heading_rad: float) -> Observation:
    """Return an observation with the pose of a level camera that is turned to the left."""
    cosine, sine = np.cos(heading_rad), np.sin(heading_rad)
    pose = np.eye(4)
    pose[:3, :3] = np.array([[cosine, -sine, 0], [sine, cosine, 0], [0, 0, 1]]) @ LEVEL.R_robot_camera
    pose[2, 3] = CAMERA_HEIGHT_M
    return replace(of, ego=EgoPose(pose))


@lru_cache
def _rays() -> NDArray[np.float64]:
    """Return rays (2, H, W): right and down for 1 ahead."""
    return np.stack(np.meshgrid(np.arange(640) + 0.5 - 320, np.arange(480) + 0.5 - 240)) / CAMERA.focal_px


@lru_cache
def _background(wall_m: float, eye: int) -> NDArray[np.float64]:
    """Return ground and a wall without ends."""
    right, down = _rays()
    ground_m = np.minimum(CAMERA_HEIGHT_M / np.maximum(down, 1e-3), 50.0)
    picture = _shade(GREY, right * ground_m + eye * CAMERA.baseline_m, ground_m, 1)
    _draw(picture, Board(wall_m, 0.0, (170, 165, 150), 60.0, 20.0, head=False), eye, 2)
    return picture


def _draw(picture: NDArray[np.float64], board: Board, eye: int, seed: int) -> None:
    right, down = _rays() * board.ahead_m
    right, up = right + eye * CAMERA.baseline_m + board.left_m, CAMERA_HEIGHT_M - down
    half = np.where(board.head & (up > board.height_m - 0.25), 0.1, 0.5 * board.width_m)
    covered = (np.abs(right) < half) & (up > 0.0) & (up < board.height_m)
    picture[covered] = _shade(board.rgb, right[covered], up[covered], seed)


@lru_cache
def _noise() -> NDArray[np.float64]:
    return np.random.default_rng(0).normal(0.0, 1.0, (480, 640, 3))


def _shade(
    rgb: tuple[int, int, int], x_m: NDArray[np.float64], y_m: NDArray[np.float64], seed: int
) -> NDArray[np.float64]:
    """Return a colour times a texture that is fixed to the surface and repeats every 6 m."""
    x, y = (np.floor(values / _TEXEL_M) for values in (x_m, y_m))
    right, down = x_m / _TEXEL_M - x, y_m / _TEXEL_M - y
    columns, rows = (texel.astype(np.intp) % _TEXELS for texel in (x, y))
    grain, next_column, next_row = _grain(seed), (columns + 1) % _TEXELS, (rows + 1) % _TEXELS
    upper = (1.0 - right) * grain[rows, columns] + right * grain[rows, next_column]
    lower = (1.0 - right) * grain[next_row, columns] + right * grain[next_row, next_column]
    return ((1.0 - down) * upper + down * lower)[..., None] * np.array(rgb, dtype=float)


@lru_cache
def _grain(seed: int) -> NDArray[np.float64]:
    grain = np.random.default_rng(seed).normal(0.0, 1.0, (_TEXELS, _TEXELS)).astype(np.float32)
    grain = cv2.GaussianBlur(grain, (0, 0), 1.0, borderType=cv2.BORDER_REFLECT)
    return 0.8 + 0.15 * (grain / grain.std()).astype(np.float64)
