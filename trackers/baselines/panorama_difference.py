"""``panorama_difference``: what differs from a picture of the surroundings that a camera on a head has put together.

A camera that only turns and zooms sees everything that rests always in the same direction. Its pictures are laid into a
panorama, by their measured pose and zoom alone::

    (x, y, z) = R_reference' R_camera ((p - centre) / focal, 1),     place in the panorama = (x / z, y / z) / step

A running mean of each place is the background (Azzari, Stefano, Bevilacqua, An effective real-time mosaicing algorithm
apt to detect motion through background subtraction using a PTZ camera, AVSS 2005). What differs from it is cut into
blobs, and the target is the blob nearest to where it is expected, of its size and contrast.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import cv2
import numpy as np
from numpy.typing import NDArray

from trackers.kernels.boxes import box_around, box_centre, box_size
from trackers.registry import register, tunable
from trackers.types import CameraModel, Estimate, Observation

_WIDTH, _HEIGHT = 3072, 1536
"""Places of the panorama, about the direction of the first picture."""
_ABSORBED_S, _LEARNT_S = 3.0, 1.0
"""Time constants of the background where something differs that is not the target, and where nothing does."""
_EDGE = 0.7
"""Error of the measured pose, in places of the panorama: by so many gradients a background may differ."""
_SIZE_SHARE, _LOOK_SHARE = 0.1, 0.05
"""How fast the target's size and its contrast follow those of its blobs."""
_MERGED = 1.8
"""A blob so many times as large as the target has something else in it."""


@dataclass(frozen=True)
class PanoramaParameters:
    """Settings.

    Attributes:
        length: of the target in places of the panorama, which sets their size.
        differs: by so many standard deviations of the picture's noise.
        reach_lengths: search radius about the expected place, in lengths of the target.
        reach_growth: growth of that radius in a second without the target, in lengths.
        velocity_share: gain of the filter of the velocity.
        patience_s: time constant of its decay while the target is not found.
        unlike: weight of differences of size and contrast against those of place.
    """

    length: float = tunable(32.0, 16.0, 48.0)
    differs: float = tunable(5.0, 2.5, 12.0, log=True)
    reach_lengths: float = tunable(0.8, 0.3, 2.0, log=True)
    reach_growth: float = tunable(1.0, 0.1, 4.0, log=True)
    velocity_share: float = tunable(0.3, 0.05, 0.8, log=True)
    patience_s: float = tunable(1.0, 0.1, 5.0, log=True)
    unlike: float = tunable(0.5, 0.05, 2.0, log=True)


class _Blob(NamedTuple):
    """What differs: its middle (2,), size (2,), number of places, and mean difference."""

    place: NDArray[np.float64]
    size: NDArray[np.float64]
    area: float
    contrast: float


class Panorama:
    """The background by direction, and the part of it that the latest picture shows."""

    def __init__(self, camera: CameraModel, R: NDArray[np.float64], step: float) -> None:
        """``R``: R_world_camera of the first picture. ``step``: tangent of the angle between places."""
        self._R, self._step = R, step
        self._middle = 0.5 * np.array([_WIDTH, _HEIGHT])
        self._mean = np.full((_HEIGHT, _WIDTH), np.nan, np.float32)
        self.show(camera, R)

    def show(self, camera: CameraModel, R: NDArray[np.float64]) -> None:
        """Set the view."""
        centre, focal = camera.centre_px, camera.focal_px
        to_rays = np.array([[1.0 / focal, 0.0, -centre[0] / focal], [0.0, 1.0 / focal, -centre[1] / focal], [0, 0, 1]])
        scale = np.array(
            [[1.0 / self._step, 0.0, self._middle[0]], [0.0, 1.0 / self._step, self._middle[1]], [0, 0, 1]]
        )
        self._H = scale @ self._R.T @ R @ to_rays
        self.px = 1.0 / (self._step * focal)
        """Places of the panorama for a pixel."""
        size = np.array([camera.width_px, camera.height_px], float)
        corners = self.places(np.array([[0.0, 0.0], [size[0], 0.0], size, [0.0, size[1]]]))
        low = np.clip(np.floor(corners.min(axis=0)), 0, (_WIDTH - 2, _HEIGHT - 2)).astype(int)
        high = np.clip(np.ceil(corners.max(axis=0)), low + 1, (_WIDTH, _HEIGHT)).astype(int)
        self.low, self.window = low, (slice(low[1], high[1]), slice(low[0], high[0]))

    def places(self, pixels: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the places (N, 2) of pixels (N, 2)."""
        return cv2.perspectiveTransform(pixels.reshape(-1, 1, 2), self._H).reshape(-1, 2)

    def pixels(self, places: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the pixels (N, 2) of places (N, 2), inside the picture or not."""
        return cv2.perspectiveTransform(places.reshape(-1, 1, 2), np.linalg.inv(self._H)).reshape(-1, 2)

    def laid(self, level: NDArray[np.float32]) -> NDArray[np.float32]:
        """Return a picture (H, W) as the window of the panorama shows it; NaN outside the picture."""
        shrink = max(int(1.0 / self.px), 1)
        height, width = level.shape
        small = cv2.resize(level, (width // shrink, height // shrink), interpolation=cv2.INTER_AREA)
        # A pixel's place is that of its middle, in both.
        ratio = np.array([width / small.shape[1], height / small.shape[0]])
        from_small = np.array([[ratio[0], 0.0, 0.5 * ratio[0]], [0.0, ratio[1], 0.5 * ratio[1]], [0, 0, 1]])
        into_window = np.array([[1.0, 0.0, -self.low[0] - 0.5], [0.0, 1.0, -self.low[1] - 0.5], [0, 0, 1]])
        rows, columns = self.window
        shape = (columns.stop - columns.start, rows.stop - rows.start)
        H = into_window @ self._H @ from_small
        return cv2.warpPerspective(small, H, shape, flags=cv2.INTER_LINEAR, borderValue=float("nan"))

    @property
    def background(self) -> NDArray[np.float32]:
        """The window of the background, to be written to; NaN where nothing is known."""
        return self._mean[self.window]


@register(
    "panorama_difference",
    role="baseline",
    summary="blob that differs from a panorama of the surroundings, for a camera that turns and zooms in one place",
    suites=("follow",),
)
class PanoramaDifference:
    """See the module. It needs the measured pose; without one the camera is taken to look in one direction."""

    Parameters = PanoramaParameters

    def __init__(self, parameters: PanoramaParameters, rng: np.random.Generator) -> None:
        self._parameters = parameters

    def initialise(self, observation: Observation, box_xyxy: NDArray[np.float64]) -> None:
        """Learn the background beside the box, and the target's size and contrast in it."""
        size_px, camera = box_size(box_xyxy), observation.camera
        self._panorama = Panorama(
            camera, _rotation(observation), float(size_px.max()) / camera.focal_px / self._parameters.length
        )
        self._size = size_px * self._panorama.px
        self._place = self._panorama.places(box_centre(box_xyxy)[None])[0]
        self._velocity = np.zeros(2)
        self._time_s = self._found_s = observation.time_s
        picture = self._panorama.laid(_level(observation))
        inside = self._near(picture.shape, 1.0)
        ring = picture[self._near(picture.shape, 2.0) & ~inside]
        around = float(np.nanmedian(ring)) if len(ring) else 0.0
        self._panorama.background[:] = np.where(inside, around, picture)
        blobs = self._blobs(picture - self._panorama.background)
        own = min(blobs, key=lambda blob: float(np.hypot(*(blob.place - self._place))), default=None)
        self._area = float(self._size.prod() / 3) if own is None else own.area
        self._contrast = 0.0 if own is None else own.contrast

    def update(self, observation: Observation) -> Estimate:
        """Return the place of the target's blob, or the expected one, with a low probability, without one."""
        p, panorama = self._parameters, self._panorama
        passed_s, self._time_s = observation.time_s - self._time_s, observation.time_s
        panorama.show(observation.camera, _rotation(observation))
        picture = panorama.laid(_level(observation))
        background = panorama.background
        difference = picture - background
        if np.isfinite(difference).any():
            difference -= np.nanmedian(difference)
        expected = self._place + passed_s * self._velocity
        blob = self._likeliest(self._blobs(difference), expected)
        if blob is None:
            self._place = expected
            self._velocity = self._velocity * np.exp(-passed_s / p.patience_s)
        else:
            self._follow(blob, expected)
        self._learn(picture, difference, background, passed_s)
        position_px = panorama.pixels(self._place[None])[0]
        return Estimate(
            position_px,
            box_around(position_px, self._size / panorama.px),
            in_view_probability=0.9 if blob is not None else 0.1,
        )

    def _blobs(self, difference: NDArray[np.float32]) -> list[_Blob]:
        """Return what differs in the window (H, W) of the panorama."""
        known = np.isfinite(difference)
        self._differs = np.zeros(difference.shape, np.uint8)
        if not known.any():
            return []
        clean = np.where(known, difference, np.float32(0.0))
        self._noise = 1.4826 * float(np.median(np.abs(clean[known]))) + 1e-6
        background = np.nan_to_num(self._panorama.background)
        slope = np.abs(cv2.Sobel(background, cv2.CV_32F, 1, 0, scale=0.125))
        slope += np.abs(cv2.Sobel(background, cv2.CV_32F, 0, 1, scale=0.125))
        self._differs = (np.abs(clean) - _EDGE * slope > self._parameters.differs * self._noise).astype(np.uint8)
        closed = cv2.morphologyEx(self._differs, cv2.MORPH_CLOSE, np.ones((3, 3), np.uint8))
        count, self._numbers, stats, _ = cv2.connectedComponentsWithStats(closed)
        areas = stats[:, cv2.CC_STAT_AREA]
        blobs = []
        for k in range(1, count):
            if areas[k] < 4:
                continue
            x, y, width, height = stats[k, :4]
            part = slice(y, y + height), slice(x, x + width)
            own = self._numbers[part] == k
            middle = np.array([x + 0.5 * width, y + 0.5 * height]) + self._panorama.low
            contrast = float(clean[part][own].mean())
            blobs.append(_Blob(middle, np.array([width, height], float), float(areas[k]), contrast))
        return blobs

    def _likeliest(self, blobs: list[_Blob], expected: NDArray[np.float64]) -> _Blob | None:
        """Return the blob of the target."""
        p, away_s = self._parameters, self._time_s - self._found_s
        reach = p.length * (p.reach_lengths + p.reach_growth * away_s)
        best, least = None, 1.0
        for blob in blobs:
            # The nearest place of the blob's box: of a merged one the middle says little.
            gap = np.maximum(np.abs(blob.place - expected) - 0.5 * np.maximum(blob.size - self._size, 0.0), 0.0)
            unlike = abs(np.log(min(blob.area, self._area) / self._area))
            if blob.area > self._area * _MERGED:
                unlike = np.log(blob.area / self._area) if away_s > 0.5 else 0.3
            if self._contrast != 0.0:
                same = blob.contrast / self._contrast
                unlike += 2.0 if same <= 0.0 else abs(np.log(same))
            cost = float(np.hypot(*gap)) / reach + 0.3 * p.unlike * unlike
            if cost < least:
                best, least = blob, cost
        return best

    def _follow(self, blob: _Blob, expected: NDArray[np.float64]) -> None:
        """Move to a blob."""
        p, passed_s = self._parameters, self._time_s - self._found_s
        merged = blob.area > self._area * _MERGED
        place = blob.place
        if merged:
            half = 0.5 * np.maximum(blob.size - self._size, 0.0)
            place = np.clip(expected, blob.place - half, blob.place + half)
        if passed_s > 0.0:
            share = p.velocity_share * (0.3 if merged else 1.0)
            self._velocity = self._velocity + share * (place - expected) / passed_s
        self._place, self._found_s = place, self._time_s
        if not merged:
            self._size = self._size + _SIZE_SHARE * (blob.size - self._size)
            self._area += _SIZE_SHARE * (blob.area - self._area)
            self._contrast += _LOOK_SHARE * (blob.contrast - self._contrast)

    def _learn(
        self,
        picture: NDArray[np.float32],
        difference: NDArray[np.float32],
        background: NDArray[np.float32],
        passed_s: float,
    ) -> None:
        """Let the background follow the picture, but for the target's places."""
        offset = np.nanmedian(picture - background) if np.isfinite(difference).any() else 0.0
        unknown = np.isnan(background)
        share = np.where(self._differs > 0, 1.0 - np.exp(-passed_s / _ABSORBED_S), 1.0 - np.exp(-passed_s / _LEARNT_S))
        share[self._near(picture.shape, 1.3)] = 0.0
        following = np.isfinite(picture) & ~unknown
        background[following] += (share * difference)[following]
        fresh = np.isfinite(picture) & unknown
        background[fresh] = picture[fresh] - (offset if np.isfinite(offset) else 0.0)

    def _near(self, shape: tuple[int, int], sides: float) -> NDArray[np.bool_]:
        """Return the places (H, W) of the window within a box, ``sides`` times the target's, about the target."""
        low, high = (self._place - self._panorama.low + sign * 0.5 * sides * self._size for sign in (-1.0, 1.0))
        x, y = np.arange(shape[1]) + 0.5, np.arange(shape[0]) + 0.5
        return ((y >= low[1]) & (y < high[1]))[:, None] & ((x >= low[0]) & (x < high[0]))


def _rotation(observation: Observation) -> NDArray[np.float64]:
    return np.eye(3) if observation.ego is None else observation.ego.T_world_camera[:3, :3]


def _level(observation: Observation) -> NDArray[np.float32]:
    """Return the brightness (H, W): a thermal camera's counts, which no gain control changes, or grey levels."""
    if observation.counts is not None:
        return observation.counts.astype(np.float32)
    return cv2.cvtColor(observation.image_rgb, cv2.COLOR_RGB2GRAY).astype(np.float32)
