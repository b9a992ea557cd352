"""A quick drawn tank: bent bodies that swim in bursts over a pale floor whose brightness wanders."""

from __future__ import annotations

from dataclasses import dataclass, field

import cv2
import numpy as np
from numpy.typing import NDArray

from trackers.types import CameraModel, Observation

STATIONS = 9
_WIDTHS = np.array([0.35, 0.85, 1.0, 0.95, 0.8, 0.6, 0.42, 0.28, 0.15])
"""Width along the body from head to tail, as shares of the greatest."""
_SUBPIXEL_BITS = 4


@dataclass
class Tank:
    """A drawn shoal; ``draw`` moves it on by one frame.

    Attributes:
        count: fish. size: (width, height) of the picture. seed: of motion, looks and floor.
        paler: the fish are bright on a dark floor if true.
        speed_px: typical speed, pixels a frame.
        alike: all fish look the same.
    """

    count: int = 5
    size: tuple[int, int] = (320, 240)
    seed: int = 0
    paler: bool = False
    speed_px: float = 2.5
    alike: bool = False
    length_px: float = 35.0
    positions_px: NDArray[np.float64] = field(init=False)
    lines_px: NDArray[np.float64] = field(init=False)

    def __post_init__(self) -> None:
        self._rng = rng = np.random.default_rng(self.seed)
        self.camera = CameraModel(*self.size, float(self.size[0]))
        self.positions_px = rng.uniform(0.15, 0.85, (self.count, 2)) * self.size
        self.headings_rad = rng.uniform(-np.pi, np.pi, self.count)
        self._speeds = rng.uniform(0.3, 1.0, self.count) * self.speed_px
        self._turns = np.zeros(self.count)
        self._phases = rng.uniform(0, 2 * np.pi, self.count)
        spread = 0.0 if self.alike else 1.0
        self.lengths_px = self.length_px * (1 + 0.12 * spread * rng.uniform(-1, 1, self.count))
        self.widths_px = 0.22 * self.lengths_px * (1 + 0.15 * spread * rng.uniform(-1, 1, self.count))
        self._darkness = 90 + 25 * spread * rng.uniform(-1, 1, self.count)
        self._pattern = spread * rng.uniform(-0.3, 0.3, (self.count, STATIONS))
        self._frame = 0
        small = (max(self.size[1] // 20, 2), max(self.size[0] // 20, 2))
        self._waves = rng.normal(0, 1, (3, *small)).astype(np.float32)
        self._bend()

    def background(self, count: int = 20) -> list[Observation]:
        """Return pictures of the floor without fish."""
        return [self._observe(self._floor()) for _ in range(count)]

    def draw(self) -> Observation:
        """Move all fish by a frame and return the picture."""
        self._swim()
        self._bend()
        picture = self._floor()
        for fish in range(self.count):
            self._paint(picture, fish)
        return self._observe(picture)

    def _observe(self, grey: NDArray[np.float32]) -> Observation:
        self._frame += 1
        noisy = grey + self._rng.normal(0, 2.0, grey.shape)
        if self.paler:
            noisy = 255 - noisy
        levels = np.clip(noisy, 0, 255).astype(np.uint8)
        return Observation(np.repeat(levels[..., None], 3, axis=-1), self._frame / 30, self.camera)

    def _floor(self) -> NDArray[np.float32]:
        phase = 0.02 * self._frame
        wave = np.sin(phase) * self._waves[0] + np.cos(phase) * self._waves[1] + np.sin(2.3 * phase) * self._waves[2]
        smooth = cv2.resize(cv2.GaussianBlur(wave, (0, 0), 1.0), self.size, interpolation=cv2.INTER_CUBIC)
        return (190 + 12 * smooth).astype(np.float32)

    def _swim(self) -> None:
        rng = self._rng
        bursts = rng.random(self.count) < 0.06
        self._speeds = np.where(bursts, rng.uniform(0.6, 1.8, self.count) * self.speed_px, self._speeds * 0.97)
        self._turns = np.where(bursts, rng.normal(0, 0.12, self.count), 0.9 * self._turns)
        ahead_px = self.positions_px + 40 * self._directions()
        outside = ((ahead_px < 0) | (ahead_px > self.size)).any(axis=1)
        to_middle = 0.5 * np.array(self.size) - self.positions_px
        wanted = np.arctan2(to_middle[:, 1], to_middle[:, 0]) - self.headings_rad
        wanted = (wanted + np.pi) % (2 * np.pi) - np.pi
        self._turns = np.where(outside, np.clip(wanted, -0.12, 0.12), self._turns)
        self.headings_rad = self.headings_rad + self._turns
        self._phases = self._phases + 0.25 * self._speeds
        margin = 12.0
        moved = self.positions_px + self._speeds[:, None] * self._directions()
        self.positions_px = np.clip(moved, margin, np.array(self.size) - margin)

    def _directions(self) -> NDArray[np.float64]:
        return np.stack([np.cos(self.headings_rad), np.sin(self.headings_rad)], axis=-1)

    def _bend(self) -> None:
        """Set the centre lines (N, K, 2), head to tail, with the middle at the position."""
        along = np.linspace(-0.5, 0.5, STATIONS)
        beat = 0.35 * np.clip(self._speeds / self.speed_px, 0, 1)
        angle = self.headings_rad[:, None] - 3.0 * self._turns[:, None] * along
        angle = angle + beat[:, None] * np.sin(self._phases[:, None] - 3 * along) * (along + 0.5) ** 2
        steps = -np.stack([np.cos(angle), np.sin(angle)], axis=-1) * (self.lengths_px / (STATIONS - 1))[:, None, None]
        line = np.cumsum(steps, axis=1)
        self.lines_px = line - line[:, STATIONS // 2 : STATIONS // 2 + 1] + self.positions_px[:, None]

    def _paint(self, picture: NDArray[np.float32], fish: int) -> None:
        line = self.lines_px[fish]
        tangent = np.gradient(line, axis=0)
        tangent /= np.linalg.norm(tangent, axis=1, keepdims=True)
        half = 0.5 * self.widths_px[fish] * _WIDTHS[:, None] * np.stack([-tangent[:, 1], tangent[:, 0]], axis=-1)
        for k in range(STATIONS - 1):
            corners = np.stack(
                [line[k] + half[k], line[k + 1] + half[k + 1], line[k + 1] - half[k + 1], line[k] - half[k]]
            )
            level = 190 - self._darkness[fish] * (1 + self._pattern[fish, k])
            points = np.round((corners - 0.5) * 2**_SUBPIXEL_BITS).astype(np.int32)
            cv2.fillConvexPoly(picture, points, float(level), cv2.LINE_8, _SUBPIXEL_BITS)
