"""Detection of fish from above: what differs from the floor, cut into blobs, with the posture of each."""

from __future__ import annotations

from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from trackers.fish_chain.background import Background, Grey, grey_of
from trackers.fish_chain.posture import STATIONS, posture
from trackers.registry import tunable
from trackers.types import Observation

_VOTING_FRAMES = 60
_REMEMBERED = 1500
_SOME = 30
_WIDER = 0.9
"""Fish side by side overlap."""
"""Blobs from which on their median is trusted."""
_ONE_BODY_QUANTILE = 0.4
"""Below the median, as some blobs are of several fish."""


@dataclass(frozen=True)
class DetectorParameters:
    """Parameters of ``Detector``.

    Attributes:
        surely, hardly: contrast to the floor in standard deviations of its brightness; a blob has a pixel above the
            first and ends where the contrast falls below the second.
        surely_share, hardly_share: the same as shares of the usual contrast of a fish; the higher limit counts.
        least_area: area of the smallest blob, as a share of one fish's.
        merged_area: area from which on a blob may be of several fish, as a multiple of one fish's; it is if it is as
            much longer, or nearly as much wider.
        least_px: area of the smallest blob before the area of a fish is known.
    """

    surely: float = tunable(6.0, 3.0, 12.0)
    hardly: float = tunable(3.0, 1.5, 6.0)
    surely_share: float = tunable(0.5, 0.2, 0.8)
    hardly_share: float = tunable(0.3, 0.1, 0.5)
    least_area: float = tunable(0.3, 0.1, 0.6)
    merged_area: float = tunable(1.5, 1.2, 2.0)
    least_px: int = 12


@dataclass(frozen=True, slots=True)
class Detection:
    """One blob: a fish, or several that touch.

    Attributes:
        position_px: (2,) middle of the centre line.
        box_xyxy: (4,) of the outline.
        heading_rad: from the middle to the head, from +x towards +y.
        centre_line_px: (K, 2) at equal distances from the head, the heavier end, to the tail.
        area_px: pixels.
        score: in [0, 1]; how far area and contrast reach those of the usual fish.
        merged: more than one fish by its area and shape.
        widths_px: (K,) across the centre line. shades: (K,) brightness along it as a share of the floor's.
        colour: (2,) logarithms of red and blue over green, relative to the floor's about the blob.
        mask: (h, w) 1 on the blob; its top left corner is at ``corner_px`` (x, y).
    """

    position_px: NDArray[np.float64]
    box_xyxy: NDArray[np.float64]
    heading_rad: float
    centre_line_px: NDArray[np.float64]
    area_px: float
    score: float
    merged: bool
    widths_px: NDArray[np.float64]
    shades: NDArray[np.float64]
    colour: NDArray[np.float64]
    mask: NDArray[np.uint8]
    corner_px: NDArray[np.int64]

    @property
    def length_px(self) -> float:
        """Length of the centre line."""
        return float(np.linalg.norm(np.diff(self.centre_line_px, axis=0), axis=1).sum())


class Detector:
    """Detects the fish of a tank; learns floor, contrast and size of a fish as pictures come.

    Attributes:
        fish_area_px, fish_length_px: usual area and length of one fish; 0 until they are known.
    """

    def __init__(self, parameters: DetectorParameters) -> None:
        self._parameters = parameters
        self.start(())

    def start(self, background: Sequence[Observation]) -> None:
        """Begin anew with pictures without fish, possibly none."""
        self._pictures = tuple(background)
        self._background: Background | None = None
        self._votes = np.zeros(2)
        self._voted = 0
        self._areas: deque[float] = deque(maxlen=_REMEMBERED)
        self._contrasts: deque[float] = deque(maxlen=_REMEMBERED)
        self._lengths: deque[float] = deque(maxlen=_REMEMBERED)
        self._contrast = 0.0
        self.fish_area_px = 0.0
        self.fish_length_px = 0.0

    def detect(self, observation: Observation) -> list[Detection]:
        """Return the blobs of the next picture, and learn from it."""
        grey = grey_of(observation.image_rgb)
        if self._background is None or self._background.mean.shape != grey.shape:
            self._background = Background(self._pictures, grey)
        difference = self._background.difference(grey)
        sign = self._sign(difference)
        contrast = difference if sign > 0 else -difference
        p = self._parameters
        above = (contrast > np.maximum(p.hardly * self._background.spread, p.hardly_share * self._contrast)).view(
            np.uint8
        )
        count, labels, stats, _ = cv2.connectedComponentsWithStats(above, connectivity=8)
        least_px = max(p.least_area * self.fish_area_px, p.least_px)
        found, occupied = [], np.zeros_like(above)
        for label in np.flatnonzero(stats[1:count, cv2.CC_STAT_AREA] >= least_px) + 1:
            x, y, width, height = stats[label, :4]
            window = np.s_[y : y + height, x : x + width]
            mask = (labels[window] == label).view(np.uint8)
            peak = np.where(mask, contrast[window], 0.0)
            surely = np.maximum(p.surely * self._background.spread[window], p.surely_share * self._contrast)
            if (peak > surely).any():
                occupied[window] |= mask
                found.append(self._detection(observation.image_rgb, window, mask, peak, grey))
        self._background.learn(grey, difference, occupied, sign)
        self._learn_size()
        return found

    def _sign(self, difference: Grey) -> int:
        """Return -1 for fish darker than the floor, +1 for brighter ones, as the first pictures show it."""
        assert self._background is not None
        if self._voted < _VOTING_FRAMES:
            beyond = np.where(np.abs(difference) > self._parameters.surely * self._background.spread, difference, 0.0)
            self._votes += -float(beyond[beyond < 0].sum()), float(beyond[beyond > 0].sum())
            self._voted += 1
        return 1 if self._votes[1] > self._votes[0] else -1

    def _detection(
        self,
        image_rgb: NDArray[np.uint8],
        window: tuple[slice, slice],
        mask: NDArray[np.uint8],
        contrast: Grey,
        grey: Grey,
    ) -> Detection:
        assert self._background is not None
        corner = np.array([window[1].start, window[0].start])
        floor = self._background.mean[window]
        body = posture(mask, np.maximum(contrast, 1e-3), (grey[window] + 1.0) / (floor + 1.0), STATIONS)
        line = body[:, :2] + corner
        area = float(np.count_nonzero(mask))
        usual = float(contrast.sum()) / area
        length = float(np.linalg.norm(np.diff(line, axis=0), axis=1).sum())
        self._areas.append(area)
        self._contrasts.append(usual)
        self._lengths.append(length)
        ahead = line[0] - line[STATIONS // 2]
        return Detection(
            position_px=line[STATIONS // 2],
            box_xyxy=np.concatenate([corner, corner + mask.shape[::-1]]).astype(float),
            heading_rad=float(np.arctan2(ahead[1], ahead[0])),
            centre_line_px=line,
            area_px=area,
            score=min(1.0, area / max(self.fish_area_px, 1.0)) * min(1.0, usual / max(self._contrast, 1.0)),
            merged=self._is_merged(area, length),
            widths_px=body[:, 2],
            shades=body[:, 3],
            colour=_colour(image_rgb[window], mask),
            mask=mask,
            corner_px=corner,
        )

    def _learn_size(self) -> None:
        if len(self._areas) >= _SOME and (len(self._areas) < _REMEMBERED or self._voted % _SOME == 0):
            self.fish_area_px = float(np.quantile(self._areas, _ONE_BODY_QUANTILE))
            self.fish_length_px = float(np.quantile(self._lengths, _ONE_BODY_QUANTILE))
            self._contrast = float(np.quantile(self._contrasts, _ONE_BODY_QUANTILE))

    def _is_merged(self, area_px: float, length_px: float) -> bool:
        if self.fish_area_px == 0:
            return False
        larger, longer = area_px / self.fish_area_px, length_px / self.fish_length_px
        limit = self._parameters.merged_area
        return larger > limit and (longer > limit or larger / longer > _WIDER * limit)


def _colour(image_rgb: NDArray[np.uint8], mask: NDArray[np.uint8]) -> NDArray[np.float64]:
    on, off = (np.array(cv2.mean(image_rgb, each)[:3]) + 1.0 for each in (mask, mask ^ 1))
    relative = np.log(on / off) if mask.all() == 0 else np.log(on)
    return relative[[0, 2]] - relative[1]  # type: ignore[no-any-return]
