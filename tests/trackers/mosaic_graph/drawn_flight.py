"""Hand-drawn film of a target before a background that has no scale: a camera that moves, turns and leaves it."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from trackers.types import CameraModel, Observation

WIDTH_PX, HEIGHT_PX, SIDE_PX = 192, 144, 24
RATE_HZ = 20.0
_WORLD_PX = 900


@dataclass(frozen=True)
class FlownFrame:
    """One picture and its truth: the target's box (4,), and whether all of it is inside."""

    observation: Observation
    box_xyxy: NDArray[np.float64]
    inside: bool

    @property
    def centre_px(self) -> NDArray[np.float64]:
        """Middle (2,) of the box."""
        return 0.5 * (self.box_xyxy[:2] + self.box_xyxy[2:])


def texture(side_px: int, rng: np.random.Generator, contrast: float) -> NDArray[np.float32]:
    """Return a colour picture (S, S, 3) whose contrasts are the same at every scale, as those of photographs are."""
    picture = np.full((side_px, side_px, 3), 128.0, np.float32)
    cells = 3
    while cells < side_px:
        coarse = rng.normal(0, contrast, (cells, cells, 1)) + rng.normal(0, 0.4 * contrast, (cells, cells, 3))
        picture += cv2.resize(coarse.astype(np.float32), (side_px, side_px), interpolation=cv2.INTER_CUBIC)
        cells *= 2
    return picture


def flight(
    frames: int = 60,
    *,
    seed: int = 0,
    out: tuple[int, int] = (1000, 1000),
    shift_px: tuple[int, int] = (0, 0),
    growth: float = 1.0,
    jump_px: float = 0.0,
) -> list[FlownFrame]:
    """Return a film of a target that moves to the right while the camera follows it and turns.

    Args:
        out: first and last frame in which the camera has swung aside, so that the target is outside.
        shift_px: by which the whole film lies elsewhere in the picture.
        growth: of the target's size from the first to the last frame.
        jump_px: by which the target is further on after the middle of ``out``.
    """
    rng = np.random.default_rng(seed)
    world, target = texture(_WORLD_PX, rng, 14.0), texture(SIDE_PX, rng, 30.0)
    camera = CameraModel(WIDTH_PX, HEIGHT_PX, 1.2 * WIDTH_PX)
    result = []
    for k in range(frames):
        jumped = jump_px if k > sum(out) // 2 else 0.0
        at = np.array([300.0 + 1.6 * k + jumped, 450.0])
        side = SIDE_PX * growth ** (k / max(frames - 1, 1))
        drawn = world.copy()
        small = cv2.resize(target, (round(side), round(side)), interpolation=cv2.INTER_AREA)
        left, top = np.round(at - 0.5 * round(side)).astype(int)
        drawn[top : top + round(side), left : left + round(side)] = small
        away = np.clip(min(k - out[0] + 6, out[1] + 6 - k) / 6.0, 0.0, 1.0)
        look = np.array([300.0 + 1.6 * k + 6 * np.sin(k / 7), 450.0 + 5 * np.cos(k / 5) + 150.0 * away])
        turn = 0.1 * np.sin(k / 15)
        c, s = np.cos(turn), np.sin(turn)
        A = np.array([[c, -s], [s, c]])
        b = 0.5 * np.array([WIDTH_PX, HEIGHT_PX]) + np.array(shift_px) - A @ look
        # Pixel centres lie at half numbers of ours, at whole ones of OpenCV.
        matrix = np.column_stack([A, b + A @ np.array([0.5, 0.5]) - 0.5])
        picture = cv2.warpAffine(drawn, matrix, (WIDTH_PX, HEIGHT_PX), flags=cv2.INTER_LINEAR)
        picture = picture + np.random.default_rng([seed, k]).normal(0, 2.0, picture.shape)
        centre = A @ (np.array([left, top]) + 0.5 * round(side)) + b
        box = np.concatenate([centre - 0.5 * round(side), centre + 0.5 * round(side)])
        inside = bool((box[:2] >= 0).all() and (box[2:] <= [WIDTH_PX, HEIGHT_PX]).all())
        image = np.clip(picture, 0, 255).astype(np.uint8)
        result.append(FlownFrame(Observation(image, k / RATE_HZ, camera), box, inside))
    return result
