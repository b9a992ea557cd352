"""A tracker of many warm bodies: what is warmer than the empty scene, joined to tracks by the nearest neighbour."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.optimize import linear_sum_assignment

from trackers.registry import register, register_variant, tunable
from trackers.types import CameraModel, Estimate, Observation, Track


@dataclass(frozen=True)
class WarmParameters:
    """Settings.

    Attributes:
        deviations: noise's standard deviations above the background from which a pixel is warm.
        least_px: pixels that a body has at least.
        gate_px: how far a body may be from where its track expects it.
        remembered_s: for so long a track that is not seen may come back.
    """

    deviations: float = tunable(25.0, 5.0, 100.0, log=True)
    least_px: int = 4
    gate_px: float = tunable(8.0, 2.0, 30.0, log=True)
    remembered_s: float = tunable(1.0, 0.2, 3.0)


@dataclass(frozen=True)
class _Known:
    """A track: where it was at ``time_s`` and how fast (2,), in pixels."""

    identity: int
    place_px: NDArray[np.float64]
    velocity_px_s: NDArray[np.float64]
    time_s: float

    def at(self, time_s: float) -> NDArray[np.float64]:
        """Return where it is expected (2,)."""
        return self.place_px + self.velocity_px_s * (time_s - self.time_s)


@register("warm_bodies", role="ours", summary="what is warmer than the empty scene, by tracks", suites=("toy-many",))
class WarmBodies:
    """See ``trackers.protocols.MultiTracker``. Reads a thermal camera's counts, its 8 bits where there are none."""

    Parameters = WarmParameters

    def __init__(self, parameters: WarmParameters, rng: np.random.Generator) -> None:
        self._parameters = parameters

    def start(self, background: Sequence[Observation], camera: CameraModel) -> None:
        """See ``MultiTracker``. Without a background picture all of the scene is as warm as its median."""
        self._known: list[_Known] = []
        self._next = 0
        pictures = np.array([_reading(each) for each in background])
        self._ground = np.median(pictures, axis=0) if len(pictures) else None
        self._noise = max(float(np.std(pictures - self._ground)), 1.0) if len(pictures) else None

    def update(self, observation: Observation) -> list[Track]:
        """See ``MultiTracker``."""
        p, now_s = self._parameters, observation.time_s
        places, boxes = self._bodies(observation)
        self._known = [track for track in self._known if now_s - track.time_s <= p.remembered_s]
        expected = np.array([track.at(now_s) for track in self._known]).reshape(-1, 2)
        away_px = np.linalg.norm(places[:, None] - expected[None], axis=2)
        pairs = dict(zip(*linear_sum_assignment(np.minimum(away_px, p.gate_px)), strict=True))
        seen = []
        for k, (place, box) in enumerate(zip(places, boxes, strict=True)):
            j = pairs.get(k)
            if j is not None and away_px[k, j] < p.gate_px:
                track = _moved(self._known[j], place, now_s)
                self._known[j] = track
            else:
                track = _Known(self._next, place, np.zeros(2), now_s)
                self._next += 1
                self._known.append(track)
            seen.append(Track(track.identity, Estimate(place, box, in_view_probability=1.0), kind="crate"))
        return seen

    def _bodies(self, observation: Observation) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Return the middles (N, 2) and boxes (N, 4) of what is warm."""
        reading = _reading(observation)
        ground = float(np.median(reading)) if self._ground is None else self._ground
        noise = max(float(np.median(np.abs(reading - ground))) * 1.5, 1.0) if self._noise is None else self._noise
        warm = (reading - ground > self._parameters.deviations * noise).astype(np.uint8)
        _, _, found, _ = cv2.connectedComponentsWithStats(warm)
        left, top, width, height, _ = found[1:][found[1:, cv2.CC_STAT_AREA] >= self._parameters.least_px].T
        boxes = np.stack([left, top, left + width, top + height], axis=1).astype(float)
        return 0.5 * (boxes[:, :2] + boxes[:, 2:]), boxes


def _reading(observation: Observation) -> NDArray[np.float64]:
    return (observation.image_rgb[..., 0] if observation.counts is None else observation.counts).astype(float)


def _moved(track: _Known, place_px: NDArray[np.float64], now_s: float) -> _Known:
    passed_s = now_s - track.time_s
    velocity = (place_px - track.place_px) / passed_s if passed_s > 0 else track.velocity_px_s
    return replace(track, place_px=place_px, velocity_px_s=0.5 * (velocity + track.velocity_px_s), time_s=now_s)


register_variant(
    "warm_bodies_no_motion", "warm_bodies", summary="a track is expected where it was, and only nearby", gate_px=1.0
)
