"""Detection of fish from above: what differs from the floor, cut into blobs, with the posture of each."""

from __future__ import annotations

from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from trackers.fish_chain.background import Background, Grey, glare_of, grey_of
from trackers.fish_chain.posture import STATIONS, posture
from trackers.registry import tunable
from trackers.types import Observation

_REMEMBERED = 1500
_SOME, _MANY = 30, 300
"""Blobs from which on they are trusted."""
_ONE_BODY_QUANTILE = 0.4
"""Below the median, as some blobs are of several fish."""
_EVERY = 15
"""Calls of ``learn`` that share one lesson, once there are many blobs."""
_PARTED, _MINORITY, _FAINTER = 0.8, 0.1, 0.65
"""Least share of the scatter between two classes (0.75 for a uniform distribution), least share of either, and
greatest contrast of the fainter as a share of the other's."""
_REACH, _NOISE = 2.5, 0.02
"""Standard deviations of the shadows' contrast, and that of a pixel."""


class Norms:
    """Quantiles over the latest blobs; all values are 0 until enough are known.

    Contrasts are shares of the floor's brightness.

    Attributes:
        area_px, length_px: of one fish. contrast: mean over the dark part of one fish. shadow: contrast up to which a
            pixel may be of a shadow; 0 without shadows. centre: where one fish's contrast has its centre, as a share of
            its length behind the head.
    """

    def __init__(self) -> None:
        self._areas: deque[float] = deque(maxlen=_REMEMBERED)
        self._lengths: deque[float] = deque(maxlen=_REMEMBERED)
        self._contrasts: deque[float] = deque(maxlen=_REMEMBERED)
        self._centres: deque[float] = deque(maxlen=_REMEMBERED)
        self._cores: deque[float] = deque(maxlen=_REMEMBERED)
        self._calls = 0
        self.area_px = self.length_px = self.contrast = self.centre = self.shadow = 0.0

    def see_blob(self, core: float) -> None:
        """Take in a blob, fish or shadow, by the contrast of its core."""
        self._cores.append(core)

    def see_fish(self, area_px: float, length_px: float, contrast: float, centre: float) -> None:
        """Take in a blob that is no shadow."""
        self._areas.append(area_px)
        self._lengths.append(length_px)
        self._contrasts.append(contrast)
        self._centres.append(centre)

    def learn(self) -> None:
        """Update the values; call it once a picture."""
        self._calls += 1
        if self._calls % _EVERY and len(self._cores) > _MANY:
            return
        if len(self._cores) >= _SOME:
            shadow = shadow_limit(np.array(self._cores))
            if shadow > 0 and self.shadow == 0:
                # What was learnt so far was learnt from shadows too.
                self._forget()
                self.contrast = 0.0
            self.shadow = shadow
        if len(self._areas) >= _SOME and self.contrast == 0:
            # With a contrast to cut them by, blobs are smaller from now on.
            self.contrast = float(np.quantile(self._contrasts, _ONE_BODY_QUANTILE))
            self._forget()
        if len(self._areas) >= _SOME:
            self.area_px, self.length_px, self.contrast = (
                float(np.quantile(values, _ONE_BODY_QUANTILE))
                for values in (self._areas, self._lengths, self._contrasts)
            )
            self.centre = float(np.median(self._centres))

    def _forget(self) -> None:
        for values in (self._areas, self._lengths, self._contrasts, self._centres):
            values.clear()
        self.area_px = self.length_px = self.centre = 0.0


def shadow_limit(cores: NDArray[np.float64]) -> float:
    """Return the contrast up to which blobs are shadows, 0 if there are none.

    Fish throw shadows of one contrast, which is fainter than theirs. The contrasts (N,) of all blobs are cut in two
    where the scatter between the parts is greatest (Otsu 1979); there are shadows if the parts are far enough apart.
    """
    ordered = np.sort(cores)
    count = np.arange(1, len(ordered))
    sums = np.cumsum(ordered)
    low, high = sums[:-1] / count, (sums[-1] - sums[:-1]) / (len(ordered) - count)
    share = count / len(ordered)
    between = share * (1 - share) * (high - low) ** 2
    best = int(np.argmax(between))
    parted = between[best] > _PARTED * max(float(np.var(ordered)), 1e-12)
    if not parted or not _MINORITY < share[best] < 1 - _MINORITY or low[best] > _FAINTER * high[best]:
        return 0.0
    faint = ordered[: best + 1]
    middle = float(np.median(faint))
    # Shadows that touch a fish are darker than others, so the scatter is that of the middle half.
    scatter = float(np.subtract(*np.quantile(faint, [0.75, 0.25]))) / 1.35
    return float(min(middle + _REACH * scatter + _NOISE, 0.5 * (low[best] + high[best])))


_VOTING_FRAMES = 60
_CORE_QUANTILE, _DARK = 0.8, 0.5
"""Of the dark part of a blob, which is half as far from the floor as its darkest pixel."""
_CROSS = cv2.getStructuringElement(cv2.MORPH_CROSS, (3, 3))
_PALE_SHARE, _DARK_SHARE = 0.35, 0.6
"""Most pale pixels of a fish alone, over its dark ones and their rim; least dark ones, as a share of a least blob."""
_WIDER = 0.9
"""Fish side by side overlap."""


@dataclass(frozen=True)
class DetectorParameters:
    """Parameters of ``Detector``.

    Attributes:
        surely, hardly: contrast to the floor in standard deviations of its brightness; a blob has a pixel above the
            first and ends where the contrast falls below the second.
        surely_share, hardly_share: the same as shares of the usual contrast of a fish; the higher limit counts.
        pale_share: what is paler than this share of a blob's core may be a blurred shadow.
        least_area: area of the smallest blob, as a share of one fish's.
        merged_area: area from which on a blob may be of several fish, as a multiple of one fish's; it is if it is as
            much longer, or nearly as much wider.
        least_px: area of the smallest blob before the area of a fish is known.
    """

    surely: float = tunable(6.0, 3.0, 12.0)
    hardly: float = tunable(3.0, 1.5, 6.0)
    surely_share: float = tunable(0.5, 0.2, 0.8)
    hardly_share: float = tunable(0.3, 0.1, 0.5)
    pale_share: float = tunable(0.6, 0.1, 0.7)
    least_area: float = tunable(0.3, 0.1, 0.6)
    merged_area: float = tunable(1.5, 1.2, 2.0)
    least_px: int = 12


@dataclass(frozen=True, slots=True)
class Detection:
    """One blob: a fish, or several that touch.

    Attributes:
        position_px: (2,) middle of the body: as far behind the centre of its contrast as with the usual fish. The
            middle of the centre line is less steady, as the pale end of a tail comes and goes.
        box_xyxy: (4,) of the outline.
        heading_rad: from the middle to the head, from +x towards +y.
        centre_line_px: (K, 2) at equal distances from the head, the heavier end, to the tail.
        area_px: pixels.
        score: in [0, 1]; how far area and contrast reach those of the usual fish.
        merged: more than one fish by its area and shape.
        covered: a part of it may be hidden by the reflection of a lamp, or cut by the border.
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
    covered: bool
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
    """Detects the fish of a tank; learns floor, shadows, contrast and size of a fish as pictures come.

    Attributes:
        norms: what is known of one fish.
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
        self.norms = Norms()

    def detect(self, observation: Observation) -> list[Detection]:
        """Return the blobs of the next picture, and learn from it."""
        grey = grey_of(observation.image_rgb)
        if self._background is None or self._background.mean.shape != grey.shape:
            self._background = Background(self._pictures, grey)
        difference = self._background.difference(grey)
        glare = glare_of(observation.image_rgb)
        sign = self._sign(np.where(glare, np.float32(0.0), difference))
        contrast = difference if sign > 0 else -difference
        p, norms = self._parameters, self.norms
        limit = self._limit(p.hardly, p.hardly_share)
        above = (contrast > limit).view(np.uint8)
        count, labels, stats, _ = cv2.connectedComponentsWithStats(above, connectivity=8)
        least_px = max(p.least_area * norms.area_px, p.least_px)
        found, occupied = [], np.zeros_like(above)
        for label in np.flatnonzero(stats[1:count, cv2.CC_STAT_AREA] >= least_px) + 1:
            x, y, width, height = (int(value) for value in stats[label, :4])
            window = np.s_[y : y + height, x : x + width]
            mask = (labels[window] == label).view(np.uint8)
            relative = np.where(mask, contrast[window] / (self._background.mean[window] + 1.0), 0.0)
            dark = _dark(relative)
            core = float(np.quantile(dark, _CORE_QUANTILE))
            norms.see_blob(core)
            pale = max(norms.shadow, p.pale_share * core)
            surely = mask & (contrast[window] > self._limit(p.surely, p.surely_share, window))
            if surely.any():
                occupied[window] |= mask
                for body, corner in _without_shadow(mask, surely, relative, pale, least_px):
                    found.append(
                        self._detection(observation.image_rgb, body, corner + np.array([x, y]), contrast, grey, glare)
                    )
        self._background.learn(grey, glare, difference, occupied, sign)
        norms.learn()
        return found

    @property
    def body_px(self) -> float:
        """Length of the usual fish; before it is known, a fifteenth of the longer side of the picture."""
        if self.norms.length_px == 0 and self._background is not None:
            return max(max(self._background.mean.shape) / 15, 1.0)
        return max(self.norms.length_px, 1.0)

    def _limit(self, spreads: float, share: float, window: tuple[slice, slice] = np.s_[:, :]) -> Grey:
        """Return the contrast in grey levels that so many standard deviations, and such a share of a fish's, make."""
        assert self._background is not None
        spread, mean = self._background.spread[window], self._background.mean[window]
        limit: Grey = np.maximum(spreads * spread, np.float32(share * self.norms.contrast) * mean)
        return limit

    def _sign(self, difference: Grey) -> int:
        """Return -1 for fish darker than the floor, +1 for brighter ones, as the first pictures show it.

        Each pixel has one vote: about lamps there are few that are far brighter.

        ``difference``: to the floor, 0 where lamps are reflected.
        """
        assert self._background is not None
        if self._voted < _VOTING_FRAMES:
            limit = self._parameters.surely * self._background.spread
            self._votes += np.count_nonzero(difference < -limit), np.count_nonzero(difference > limit)
            self._voted += 1
        return 1 if self._votes[1] > self._votes[0] else -1

    def _detection(
        self,
        image_rgb: NDArray[np.uint8],
        mask: NDArray[np.uint8],
        corner: NDArray[np.int64],
        contrast: Grey,
        grey: Grey,
        glare: NDArray[np.uint8],
    ) -> Detection:
        assert self._background is not None
        (x, y), (height, width) = corner, mask.shape
        window = np.s_[y : y + height, x : x + width]
        floor = self._background.mean[window] + 1.0
        weight = np.where(mask, np.maximum(contrast[window], 1e-3), 0.0).astype(np.float32)
        body, centre = posture(mask, weight, (grey[window] + 1.0) / floor, STATIONS)
        line = body[:, :2] + corner
        area = float(np.count_nonzero(mask))
        usual = float(_dark(weight / floor).mean())
        length = float(np.linalg.norm(np.diff(line, axis=0), axis=1).sum())
        self.norms.see_fish(area, length, usual, centre)
        ahead = line[0] - line[STATIONS // 2]
        merged = self._is_merged(area, length)
        known = self.norms.centre > 0 and not merged
        return Detection(
            position_px=_point_at(line, 0.5 + (centre - self.norms.centre if known else 0.0)),
            box_xyxy=np.concatenate([corner, corner + np.array([width, height])]).astype(float),
            heading_rad=float(np.arctan2(ahead[1], ahead[0])),
            centre_line_px=line,
            area_px=area,
            score=min(1.0, area / max(self.norms.area_px, 1.0)) * min(1.0, usual / max(self.norms.contrast, 1e-3)),
            merged=merged,
            covered=_touches(glare, corner, mask.shape),
            widths_px=body[:, 2],
            shades=body[:, 3],
            colour=_colour(image_rgb[window], mask),
            mask=mask,
            corner_px=corner,
        )

    def _is_merged(self, area_px: float, length_px: float) -> bool:
        if self.norms.area_px == 0:
            return False
        larger, longer = area_px / self.norms.area_px, length_px / self.norms.length_px
        limit = self._parameters.merged_area
        return larger > limit and (longer > limit or larger / longer > _WIDER * limit)


def _point_at(line_px: NDArray[np.float64], share: float) -> NDArray[np.float64]:
    """Return the point (2,) of a line (K, 2) of equal steps, a share of its length behind its first one."""
    at = share * (len(line_px) - 1)
    return np.array([np.interp(at, np.arange(len(line_px)), line_px[:, axis]) for axis in (0, 1)])


def _dark(relative: NDArray[np.float32]) -> NDArray[np.float32]:
    """Return the contrasts (D,) of the dark part of a blob, which a soft shadow about it does not dilute."""
    dark: NDArray[np.float32] = relative[relative >= _DARK * relative.max()]
    return dark


def _without_shadow(
    mask: NDArray[np.uint8], surely: NDArray[np.uint8], relative: NDArray[np.float32], shadow: float, least_px: float
) -> list[tuple[NDArray[np.uint8], NDArray[np.int64]]]:
    """Return the parts of a blob that are no shadow, each cut out, with its top left corner (x, y) in the blob.

    A blob without room for a shadow beside its dark part is returned whole, since tails are as pale as shadows.
    """
    whole = [(mask, np.zeros(2, dtype=np.int64))]
    count, labels, stats, _ = cv2.connectedComponentsWithStats((relative > shadow).view(np.uint8), connectivity=8)
    parts, covered = [], np.zeros_like(mask)
    for label in range(1, count):
        dark = (labels == label).view(np.uint8)
        if stats[label, cv2.CC_STAT_AREA] >= _DARK_SHARE * least_px and (dark & surely).any():
            part = cv2.dilate(dark, _CROSS) & mask
            covered |= part
            x, y, width, height = cv2.boundingRect(part)
            parts.append((part[y : y + height, x : x + width], np.array([x, y])))
    pale = np.count_nonzero(mask) - np.count_nonzero(covered)
    return whole if len(parts) == 1 and pale < _PALE_SHARE * np.count_nonzero(covered) else parts


def _touches(glare: NDArray[np.uint8], corner: NDArray[np.int64], shape: tuple[int, ...]) -> bool:
    """Whether there is glare in a box or beside it, or the box reaches the border."""
    low, high = corner - 1, corner + np.array(shape[::-1]) + 1
    inside = (low >= 0).all() and (high <= glare.shape[::-1]).all()
    return not inside or bool(glare[low[1] : high[1], low[0] : high[0]].any())


def _colour(image_rgb: NDArray[np.uint8], mask: NDArray[np.uint8]) -> NDArray[np.float64]:
    on, off = (np.array(cv2.mean(image_rgb, each)[:3]) + 1.0 for each in (mask, mask ^ 1))
    relative = np.log(on / off) if mask.all() == 0 else np.log(on)
    return relative[[0, 2]] - relative[1]  # type: ignore[no-any-return]
