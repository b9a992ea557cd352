"""Short random sequences of hostile pictures: a camera that tips over, cuts, noise, lost data.

Each begins with frames that a tracker can follow, so that its state is in use when the faults begin.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import cv2
import numpy as np
from numpy.typing import NDArray

from trackers.types import CameraModel, CameraRegisters, CameraSettings, EgoPose, Observation

Picture = NDArray[np.uint8]

_SIZES = ((160, 120), (160, 120), (128, 96), (96, 128), (64, 48), (320, 240))
_ODD_SIZES = ((1, 1), (2, 2), (3, 5), (9, 7), (16, 12), (37, 23), (200, 4), (3840, 2160))
_CAR_M = (4.5, 1.9)
_TEXEL_M = 0.25
_DOWN = np.diag([1.0, -1.0, -1.0])
"""Columns: right, down and forward of a camera that looks straight down, in the world."""
_AHEAD = np.array([[0.0, 0.0, 1.0], [-1.0, 0.0, 0.0], [0.0, -1.0, 0.0]])


@dataclass(frozen=True)
class Sequence:
    """Inputs of one tracker.

    Attributes:
        observations: of all frames. box_xyxy: (4,) box in the first one.
    """

    observations: list[Observation]
    box_xyxy: NDArray[np.float64]

    @property
    def box_is_outside(self) -> bool:
        """Whether the box is outside the first picture: a tracker may refuse it."""
        camera = self.observations[0].camera
        low, high = self.box_xyxy[:2], self.box_xyxy[2:]
        return bool((high <= 0).any() or (low >= [camera.width_px, camera.height_px]).any())


def hostile_sequence(seed: int, *, stereo: bool, frames: int) -> Sequence:
    """Return a sequence; every seventh has an odd size, a very large one is short."""
    rng = np.random.default_rng([seed, stereo])
    sizes = _ODD_SIZES if seed % 7 == 6 else _SIZES
    width, height = sizes[rng.integers(len(sizes))]
    frames = min(frames, 3) if width > 1000 else frames
    film = _Film(rng, width, height, stereo)
    observations = [film.next() for _ in range(frames)]
    return Sequence(observations, _box(rng, film.first_box, width, height))


def tipping_sequence(ego: str, *, frames: int = 90) -> Sequence:
    """Return a flight without faults whose camera tips over the horizon and returns half-way through.

    Args:
        ego: ``measured`` or ``never``.
    """
    film = _Film(np.random.default_rng(5), 160, 120, stereo=False)
    film.calm(ego)
    observations = []
    for k in range(frames):
        film.tip(0.04 if 5 <= k < frames // 2 else -0.04 if k >= frames // 2 and k < frames - 5 else 0.0)
        observations.append(film.next())
    assert film.first_box is not None
    return Sequence(observations, film.first_box)


def _box(rng: np.random.Generator, target: NDArray[np.float64] | None, width: int, height: int) -> NDArray[np.float64]:
    """Return the target's own box most often; otherwise one that is tiny, huge, cut by the border, or outside."""
    size, kind = np.array([width, height], dtype=float), rng.random()
    if target is not None and kind < 0.6:
        return target
    middle, half = rng.uniform(0.0, 1.0, 2) * size, rng.uniform(0.02, 0.15, 2) * size
    if kind > 0.95:
        middle, half = size * rng.choice([-3.0, 4.0], 2), half + 1.0
    elif kind > 0.85:
        half = np.full(2, rng.choice([1e-3, 0.3, 1.0]))
    elif kind > 0.75:
        half = rng.choice([0.5, 2.0, 20.0]) * size
    elif kind > 0.65:
        middle = rng.choice([-0.02, 1.02], 2) * size
    return np.concatenate([middle - half, middle + half])


class _Film:
    """One camera over one ground, with faults."""

    def __init__(self, rng: np.random.Generator, width: int, height: int, stereo: bool) -> None:
        self._rng, self._stereo = rng, stereo
        self._size = width, height
        focal_px = width * rng.choice([0.5, 1.1, 3.0])
        self._camera = CameraModel(width, height, focal_px, 0.12 if stereo else None)
        self._trouble = rng.choice([0.02, 0.1, 0.4])
        self._calm_frames = int(rng.integers(1, 15))
        self._ego = str(rng.choice(["measured", "never", "hostile"]))
        self._ground = int(rng.choice([0, 0, 1, 2]))
        self._time_s, self._frame = 0.0, 0
        self._last: Picture = np.zeros((height, width, 3), np.uint8)
        self.first_box: NDArray[np.float64] | None = None
        self._cut()
        # At first straight down or tilted, and often tipping on over the horizon.
        self._tilt_rad, self._tilting_rad = rng.choice([0.05, 0.05, 0.9]), rng.choice([0.0, 0.01, 0.05, 0.12])

    def calm(self, ego: str) -> None:
        """Switch all faults off and fly over a town."""
        self._trouble, self._ego, self._ground = 0.0, ego, 0
        self._height_m, self._climb_m, self._tilt_rad, self._turning_rad = 40.0, 0.0, 0.05, 0.0
        self._camera = CameraModel(*self._size, 1.1 * self._size[0])

    def tip(self, tilting_rad: float) -> None:
        """Set how far the camera turns up in each picture."""
        self._tilting_rad = tilting_rad

    def _cut(self) -> None:
        """Draw a new position, motion and scene."""
        rng = self._rng
        self._place_m, self._speed_m = rng.uniform(-100, 100, 2), rng.normal(0, 0.6, 2)
        self._height_m, self._climb_m = rng.choice([8.0, 40.0, 120.0]), rng.choice([0.0, 0.0, 1.0, -2.0])
        self._heading_rad, self._turning_rad = rng.uniform(-3, 3), rng.normal(0, 0.03)
        self._tilt_rad, self._tilting_rad = rng.uniform(0.0, 2.0), 0.0
        self._car_m, self._zoom = self._place_m.copy(), 1.0
        self._people = [(rng.uniform(0.4, 8.0), rng.uniform(-2, 2), int(rng.integers(3))) for _ in range(3)]
        self._disparity = rng.uniform(0.0, 0.1)

    def next(self) -> Observation:
        """Return the next observation."""
        rng = self._rng
        calm = self._frame < self._calm_frames

        def goes_wrong() -> bool:
            return not calm and rng.random() < self._trouble

        if goes_wrong() and rng.random() < 0.3:
            self._cut()
        self._move()
        self._time_s += float(rng.choice([0.0, -3.0, 1e-9, 20.0, 1e6])) if goes_wrong() else 1 / 15
        picture, right = self._pair() if self._stereo else (self._view(), None)
        if goes_wrong():
            picture = self._spoilt(picture)
        if right is not None and goes_wrong():
            right = None if rng.random() < 0.5 else self._spoilt(right)
        self._last, self._frame = picture, self._frame + 1
        settings = None if goes_wrong() and self._frame > 1 else CameraSettings(0.01, 1.0, self._registers(calm))
        return Observation(picture, self._time_s, self._camera, settings, self._measured(calm), right)

    def _move(self) -> None:
        self._place_m = self._place_m + self._speed_m
        self._car_m = self._car_m + self._speed_m + self._rng.normal(0, 0.1, 2)
        self._height_m = max(self._height_m + self._climb_m, 0.3)
        self._heading_rad += self._turning_rad
        self._tilt_rad += self._tilting_rad
        if self._rng.random() < 0.02:
            self._zoom *= self._rng.choice([0.3, 3.0])

    def _registers(self, calm: bool) -> CameraRegisters:
        if calm or self._rng.random() > self._trouble:
            return CameraRegisters(500, 600, 400, 0)
        return CameraRegisters(*(int(self._rng.choice([0, full])) for full in (1023, 1023, 707, 683)))

    def _rotation(self, tilt_rad: float) -> NDArray[np.float64]:
        """Return R_world_camera at a tilt from straight down (a robot's: from level)."""
        (c, s), (ct, st) = ((np.cos(a), np.sin(a)) for a in (self._heading_rad, tilt_rad))
        turned = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
        return turned @ (_AHEAD if self._stereo else _DOWN) @ np.array([[1, 0, 0], [0, ct, -st], [0, st, ct]])

    def _measured(self, calm: bool) -> EgoPose | None:
        rng, T = self._rng, np.eye(4)
        T[:3, :3] = self._rotation(0.0 if self._stereo else self._tilt_rad)
        T[:3, 3] = *self._place_m, 1.2 if self._stereo else self._height_m
        wrong = self._ego == "hostile" and not calm and rng.random() < 0.3
        if self._ego == "never" or (wrong and rng.random() < 0.4):
            return None
        if wrong:
            T[:3, :3] = self._rotation(rng.choice([0.5, 1.0, 1.5, 2.0]) * np.pi / 2)
            T[:3, 3] += rng.normal(0, 1, 3) * rng.choice([0.1, 1e3, 1e7])
            T[2, 3] = rng.choice([T[2, 3], 0.0, -5.0, 1e-9])
        return EgoPose(T)

    def _view(self) -> Picture:
        """Return the picture of the ground with a red car on it; grey above the horizon."""
        width, height = (min(side, limit) for side, limit in zip(self._size, (640, 360), strict=True))
        focal_px = self._zoom * self._camera.focal_px * width / self._size[0]
        column, row = np.meshgrid(np.arange(width) + 0.5 - width / 2, np.arange(height) + 0.5 - height / 2)
        rays = np.stack([column, row, np.full_like(row, focal_px)], axis=-1) @ self._rotation(self._tilt_rad).T
        away = self._height_m / np.maximum(-rays[..., 2], 1e-3 * focal_px)
        ground_m = self._place_m + rays[..., :2] * away[..., None]
        texels = (ground_m / _TEXEL_M % 512).astype(np.float32)
        picture = cv2.remap(_ground(self._ground), texels, None, cv2.INTER_LINEAR, borderMode=cv2.BORDER_WRAP)
        car = (np.abs(ground_m - self._car_m) < 0.5 * np.array(_CAR_M)).all(axis=-1)
        picture[car] = 190, 40, 30
        picture[rays[..., 2] >= 0] = 150
        if self.first_box is None and car.any():
            rows, columns = np.nonzero(car)
            box = np.array([columns.min(), rows.min(), columns.max() + 1.0, rows.max() + 1.0])
            self.first_box = box * np.tile(np.array(self._size) / [width, height], 2)
        grain = self._rng.normal(0, 2, picture.shape)
        return cv2.resize(np.clip(picture + grain, 0, 255).astype(np.uint8), self._size)

    def _pair(self) -> tuple[Picture, Picture]:
        """Return the stereo pair of a robot: a wall and moving people."""
        width, height = self._size
        focal_px = self._zoom * self._camera.focal_px
        wall = cv2.resize(_ground(0), (2 * width, height))
        pair = [wall[:, width // 4 :][:, :width].copy(), np.roll(wall, -int(self._disparity * width), axis=1)]
        pair[1] = pair[1][:, width // 4 :][:, :width].copy()
        for away_m, left_m, look in sorted(self._people, reverse=True):
            for picture, baseline_m in zip(pair, (0.0, 0.12), strict=True):
                middle = width / 2 - focal_px * (left_m + baseline_m) / away_m
                top, bottom = height / 2 - focal_px * 0.5 / away_m, height / 2 + focal_px * 1.2 / away_m
                half = focal_px * 0.25 / away_m
                box = np.array([middle - half, top, middle + half, bottom])
                left, upper, right, lower = np.clip(np.round(box), 0, [width, height] * 2).astype(int)
                if right > left and lower > upper:
                    clothes = cv2.resize(_ground(look)[:64, :32], (right - left, lower - upper))
                    picture[upper:lower, left:right] = clothes
                    self.first_box = box if self.first_box is None else self.first_box
        steps = zip(self._people, (-0.05, 0.0, 0.05), strict=True)
        self._people = [(max(away_m + step, 0.3), left_m + step, look) for (away_m, left_m, look), step in steps]
        return pair[0], pair[1]

    def _spoilt(self, picture: Picture) -> Picture:
        """Return a faulty picture in place of a picture."""
        kind = self._rng.integers(7)
        if kind < 2:
            return np.full_like(picture, (0, 255)[kind])
        if kind == 2:
            return self._rng.integers(0, 256, picture.shape, dtype=np.uint8)
        if kind == 3:
            return self._last
        if kind == 4:
            return np.ascontiguousarray(picture[::-1, ::-1])
        if kind == 5:
            return (picture // 128) * 255
        half = picture.copy()
        half[: len(half) // 2] = 0
        return half


@lru_cache
def _ground(kind: int) -> Picture:
    """Return a texture (512, 512, 3): streets and houses, noise, or one colour."""
    rng = np.random.default_rng(kind)
    texture = np.full((512, 512, 3), (80, 110, 60), np.uint8)
    if kind == 1:
        return rng.integers(0, 256, texture.shape, dtype=np.uint8)
    if kind == 2:
        return texture
    for _ in range(150):
        low = rng.integers(0, 490, 2)
        high, rgb = low + rng.integers(8, 40, 2), rng.integers(0, 255, 3)
        cv2.rectangle(texture, low.tolist(), high.tolist(), rgb.tolist(), -1)
    for place in range(64, 512, 128):
        for ends in (((place, 0), (place, 511)), ((0, place), (511, place))):
            cv2.line(texture, *ends, (95, 95, 98), 30)
            for side in (-13, 13):
                shifted = [(x + side * (ends[0][0] == place), y + side * (ends[0][1] == place)) for x, y in ends]
                cv2.line(texture, *shifted, (225, 225, 225), 2)
    return texture
