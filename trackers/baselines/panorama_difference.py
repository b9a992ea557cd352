"""``panorama_difference``: what differs from a picture of the surroundings that a camera on a head has put together.

A camera that only turns and zooms sees everything that rests always in the same direction. Its pictures are laid into a
panorama, by their measured pose and zoom alone::

    (x, y, z) = R_reference' R_camera ((p - centre) / focal, 1),     place in the panorama = (x / z, y / z) / step

A running mean of each place is the background (Azzari, Stefano, Bevilacqua, An effective real-time mosaicing algorithm
apt to detect motion through background subtraction using a PTZ camera, AVSS 2005). What differs from it is cut into
blobs. Whose a place is goes from picture to picture with the optical flow of what differs, so that those who touch each
other are told apart; a target that was lost is the blob nearest to where it is expected, of its size and contrast.
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
_ABSORBED_S, _LEARNT_S = 8.0, 1.0
"""Time constants of the background where something differs that is not the target, and where nothing does."""
_EDGE = 0.7
"""Error of the measured pose, in places of the panorama: by so many gradients a background may differ."""
_SIZE_S, _LOOK_S = 0.5, 5.0
"""Time constants of the target's box, and of what it is known by: area and contrast."""
_STEP = 0.25
"""Way of anything from picture to picture, at most, in lengths of the target."""
_SHARED, _LEAST_PART, _FOUND = 0.25, 0.15, 0.3
"""A blob is another one's if so much of it was before. The target's part of a blob is so much of its area at least, and
of one that it shares the last.
"""
_LARGER = 1.4
"""A blob so many times as large as the target is the target and something else."""
_PALE, _SHADOW = 0.4, 0.3
"""A blob with less than the first share of the target's contrast is not the target, and what differs by less than the
second one is a shadow. A thermal camera sees no shadows.
"""
_FLOW_LENGTHS, _FLOW_LEVELS, _FLOW_LEAST = 2.0, 60.0, 16
"""The flow is calculated up to so many lengths from the target, of pictures whose levels are so many for the target's
contrast, and that are at least so many places wide and high.
"""
_SURE_S = 1.5
"""For so long after the target was lost, a blob that was another one's is not taken for it."""
_TARGET, _OTHER = 1, 2
_SQUARE = np.ones((3, 3), np.uint8)
_LEAST_DEPTH = 1e-6


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
        unlike: weight of differences of area, length and contrast against those of place.
    """

    length: float = tunable(32.0, 16.0, 48.0)
    differs: float = tunable(5.0, 2.5, 12.0, log=True)
    reach_lengths: float = tunable(0.8, 0.3, 2.0, log=True)
    reach_growth: float = tunable(1.0, 0.1, 6.0, log=True)
    velocity_share: float = tunable(0.3, 0.05, 0.8, log=True)
    patience_s: float = tunable(1.0, 0.1, 5.0, log=True)
    unlike: float = tunable(0.5, 0.05, 2.0, log=True)


class _Blobs(NamedTuple):
    """What differs from the background, in K + 1 parts of the window of the panorama; part 0 is what does not.

    Attributes:
        numbers: (H, W) of the parts. area: (K + 1,) places. box: (K + 1, 4), x, y, width and height in the window.
        contrast: (K + 1,) mean difference.
        is_ghost: (K + 1,) whether its edges are in the background and not in the picture: something that rested there
            when the background was learnt has left.
    """

    numbers: NDArray[np.int32]
    area: NDArray[np.float64]
    box: NDArray[np.int32]
    contrast: NDArray[np.float64]
    is_ghost: NDArray[np.bool_]


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
        self._centre_px = centre = camera.centre_px
        focal = camera.focal_px
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
        return _mapped(self._H, pixels, self._middle)

    def pixels(self, places: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the pixels (N, 2) of places (N, 2), inside the picture or not."""
        return _mapped(np.linalg.inv(self._H), places, self._centre_px)

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
        laid = cv2.warpPerspective(small, H, shape, flags=cv2.INTER_LINEAR, borderValue=float("nan"))
        # A place behind the camera has a pixel too, the one that lies opposite.
        across, down, ahead = np.linalg.inv(H)[2]
        laid[across * np.arange(shape[0]) + down * np.arange(shape[1])[:, None] + ahead <= 0.0] = np.nan
        return laid

    @property
    def background(self) -> NDArray[np.float32]:
        """The window of the background, to be written to; NaN where nothing is known."""
        return self._mean[self.window]


@register(
    "panorama_difference",
    role="baseline",
    summary="blob that differs from a panorama of the surroundings, for a camera that turns and zooms in one place",
    suites=("follow",),
    edition=2,
)
class PanoramaDifference:
    """See the module. It needs the measured pose; without one the camera is taken to look in one direction."""

    Parameters = PanoramaParameters

    def __init__(self, parameters: PanoramaParameters, rng: np.random.Generator) -> None:
        self._parameters = parameters
        # Of the latest picture, by places: whose they are, and how they differed from the background.
        self._owners = np.zeros((_HEIGHT, _WIDTH), np.uint8)
        self._differed = np.zeros((_HEIGHT, _WIDTH), np.float32)

    def initialise(self, observation: Observation, box_xyxy: NDArray[np.float64]) -> None:
        """Learn the background beside the box, and the target's size and contrast in it."""
        size_px, camera = box_size(box_xyxy), observation.camera
        step = float(size_px.max()) / camera.focal_px / self._parameters.length
        self._panorama = panorama = Panorama(camera, _rotation(observation), step)
        self._size = size_px * panorama.px
        self._place = panorama.places(box_centre(box_xyxy)[None])[0]
        self._velocity = np.zeros(2)
        self._contrast, self._shadow = 0.0, _SHADOW if observation.counts is None else 0.0
        self._time_s = self._found_s = observation.time_s
        picture = panorama.laid(_level(observation))
        inside = self._near(picture.shape, 1.1)
        # First without all that is in the box, then without what differs from that.
        panorama.background[:] = _without(picture, inside)
        difference = np.nan_to_num(picture - panorama.background)
        blobs = self._blobs(difference, np.isfinite(picture), picture)
        panorama.background[:] = _without(picture, cv2.dilate(np.sign(blobs.numbers).astype(np.uint8), _SQUARE) > 0)
        best = int(np.argmax(blobs.area * np.abs(blobs.contrast)))
        own = blobs.numbers == best if best > 0 else inside
        self._area, self._contrast = max(float(blobs.area[best]), 4.0), float(blobs.contrast[best])
        self._span = float(np.hypot(*self._size))
        self._differed[panorama.window] = difference
        self._owners[panorama.window][own] = _TARGET

    def update(self, observation: Observation) -> Estimate:
        """Return the place of the target's blob, or the expected one, with a low probability, without one."""
        p, panorama = self._parameters, self._panorama
        passed_s, self._time_s = observation.time_s - self._time_s, observation.time_s
        panorama.show(observation.camera, _rotation(observation))
        picture, background = panorama.laid(_level(observation)), panorama.background
        difference = picture - background
        known = np.isfinite(difference)
        difference = np.where(known, difference, np.float32(0.0))
        if known.any():
            difference[known] -= np.median(difference[known])
        blobs = self._blobs(difference, known, picture)
        expected = self._place + passed_s * self._velocity
        own = self._own(blobs, difference, expected - self._place)
        self._differed[panorama.window] = difference
        if own is None:
            self._place = expected
            self._velocity = self._velocity * np.exp(-passed_s / p.patience_s)
        owners = np.where(self._is_other(blobs, own)[blobs.numbers], np.uint8(_OTHER), np.uint8(0))
        if own is not None:
            owners[own] = _TARGET
        self._owners[panorama.window] = owners
        self._learn(picture, difference, known, owners, passed_s)
        ghosts = blobs.is_ghost[blobs.numbers]
        background[ghosts] = picture[ghosts]
        position_px = panorama.pixels(self._place[None])[0]
        return Estimate(
            position_px,
            box_around(position_px, self._size / panorama.px),
            in_view_probability=0.9 if own is not None else 0.1,
        )

    def _blobs(self, difference: NDArray[np.float32], known: NDArray[np.bool_], picture: NDArray[np.float32]) -> _Blobs:
        """Return what differs (H, W) by more than noise and errors of the pose make it."""
        noise = 1.4826 * float(np.median(np.abs(difference[known]))) + 1e-6 if known.any() else 1.0
        seen = np.nan_to_num(picture)
        ground = np.where(known, self._panorama.background, seen)
        least = np.maximum(
            self._parameters.differs * noise + _EDGE * _edges(ground), self._shadow * abs(self._contrast)
        )
        # Brighter and darker parts are apart: what was learnt as background shows the other way once it has left.
        numbers, boxes = np.zeros(difference.shape, np.int32), [np.zeros((1, 4), np.int32)]
        for sign in (1.0, -1.0):
            closed = cv2.morphologyEx((sign * difference > least).astype(np.uint8), cv2.MORPH_CLOSE, _SQUARE)
            _, own, stats, _ = cv2.connectedComponentsWithStats(closed)
            is_new = (own > 0) & (numbers == 0)
            numbers[is_new] = own[is_new] + sum(map(len, boxes)) - 1
            boxes.append(stats[1:, :4])
        box = np.concatenate(boxes)

        def sums(values: NDArray[np.float32]) -> NDArray[np.float64]:
            return np.asarray(np.bincount(numbers.ravel(), values.ravel(), len(box)), float)

        # Of one that lies within another nothing is left.
        area = np.bincount(numbers.ravel(), minlength=len(box)).astype(float)
        area[0] = 0.0
        is_in = (numbers > 0).astype(np.uint8)
        rim = is_in - cv2.erode(is_in, _SQUARE)
        is_ghost = sums(rim * _edges(seen)) < sums(rim * _edges(ground))
        is_ghost[0] = False
        return _Blobs(numbers, area, box, sums(difference) / np.maximum(area, 1.0), is_ghost)

    def _own(
        self, blobs: _Blobs, difference: NDArray[np.float32], moved: NDArray[np.float64]
    ) -> NDArray[np.bool_] | None:
        """Move to the target's blob, or its part of one, and return it (H, W); None without one.

        Whose a place was on the picture before goes with the flow of what differs. Now it belongs to whom the nearest
        place belongs to.
        """
        numbers, count, expected = blobs.numbers, len(blobs.area), self._place + moved
        before = self._owners[self._panorama.window]
        carried = self._carried(before, difference)
        to_target, to_other = (_distance((carried == owner).astype(np.uint8)) for owner in (_TARGET, _OTHER))
        reach = _STEP * self._parameters.length
        is_targets, is_others = (
            (to_target <= to_other) & (to_target <= reach),
            (to_other < to_target) & (to_other <= reach),
        )
        targets, others = (np.bincount(numbers.ravel(), each.ravel(), count) for each in (is_targets, is_others))
        targets[~self._may_be(blobs)] = 0.0
        best = int(np.argmax(targets))
        if targets[best] < _LEAST_PART * self._area:
            best = self._found_again(blobs, others / np.maximum(blobs.area, 1.0), expected)
            if best == 0:
                return None
        elif blobs.area[best] > _LARGER * self._area and others[best] >= _SHARED * blobs.area[best]:
            # What belongs to each is what is nearer to it than to others: neither wears the other away.
            own, was = (numbers == best) & is_targets, before == _TARGET
            if not was.any() or own.sum() < _FOUND * self._area:
                return None
            self._move(self._place + _centroid(own) - _centroid(was), expected)
            return own
        own = numbers == best
        self._follow(own, blobs.contrast[best], expected)
        return own

    def _carried(self, owners: NDArray[np.uint8], difference: NDArray[np.float32]) -> NDArray[np.uint8]:
        """Return whose the places (H, W) are if their owners on the picture before went with the flow since then.

        The flow is Farnebäck's (Two-frame motion estimation based on polynomial expansion, SCIA 2003).
        """
        reach, size = _FLOW_LENGTHS * self._parameters.length, np.array(owners.shape[::-1])
        middle = self._place - self._panorama.low
        low, high = (np.clip(np.round(middle + sign * reach), 0, size).astype(int) for sign in (-1.0, 1.0))
        if self._contrast == 0.0 or (high - low < _FLOW_LEAST).any():
            return owners
        part = slice(low[1], high[1]), slice(low[0], high[0])
        scale = _FLOW_LEVELS / abs(self._contrast)
        now, was = (
            np.clip(128.0 + scale * each[part], 0.0, 255.0).astype(np.uint8)
            for each in (difference, self._differed[self._panorama.window])
        )
        flow = cv2.calcOpticalFlowFarneback(now, was, None, 0.5, 3, 11, 3, 5, 1.1, 0)
        y, x = np.mgrid[part].astype(np.float32)
        carried = owners.copy()
        carried[part] = cv2.remap(owners, x + flow[..., 0], y + flow[..., 1], cv2.INTER_NEAREST)
        return carried

    def _may_be(self, blobs: _Blobs) -> NDArray[np.bool_]:
        """Return which parts (K + 1,) may be the target, or have it in them, by their contrast."""
        may_be = (blobs.contrast * np.sign(self._contrast) >= _PALE * abs(self._contrast)) & ~blobs.is_ghost
        may_be[0] = False
        return may_be

    def _is_other(self, blobs: _Blobs, own: NDArray[np.bool_] | None) -> NDArray[np.bool_]:
        """Return which parts (K + 1,) belong to others: all while the target is found; else those that did before."""
        if own is not None:
            return np.arange(len(blobs.area)) > 0
        before = (self._owners[self._panorama.window] == _OTHER).ravel()
        others = np.bincount(blobs.numbers.ravel(), before, len(blobs.area))
        return (others > _SHARED * blobs.area) & (np.arange(len(others)) > 0)

    def _found_again(self, blobs: _Blobs, others: NDArray[np.float64], expected: NDArray[np.float64]) -> int:
        """Return the number of the blob that is most likely the target's again; 0 without one.

        Args:
            others: (K + 1,) share of each that belonged to others before.
        """
        p, away_s = self._parameters, self._time_s - self._found_s
        place = blobs.box[:, :2] + 0.5 * blobs.box[:, 2:] + self._panorama.low
        reach = p.length * (p.reach_lengths + p.reach_growth * away_s)
        span = np.hypot(*blobs.box[:, 2:].T)
        unlike = np.abs(np.log(np.maximum(blobs.area, 1.0) / self._area))
        unlike += np.abs(np.log(np.maximum(span, 1.0) / self._span))
        if self._contrast != 0.0:
            unlike += np.abs(np.log(np.maximum(blobs.contrast / self._contrast, 1e-3)))
        cost = np.hypot(*(place - expected).T) / reach + p.unlike * unlike
        cost[(others > _SHARED) & (away_s < _SURE_S)] = np.inf
        cost[(blobs.area < _LEAST_PART * self._area) | ~self._may_be(blobs)] = np.inf
        best = int(np.argmin(cost))
        return best if cost[best] < 1.0 else 0

    def _follow(self, own: NDArray[np.bool_], contrast: float, expected: NDArray[np.float64]) -> None:
        """Move to the target's places (H, W), and learn its size and contrast."""
        passed_s = self._time_s - self._found_s
        x, y, width, height = cv2.boundingRect(own.astype(np.uint8))
        size = np.array([width, height], float)
        self._move(self._panorama.low + (x, y) + 0.5 * size, expected)
        share, learnt = 1.0 - np.exp(-passed_s / _SIZE_S), 1.0 - np.exp(-passed_s / _LOOK_S)
        self._size = self._size + share * (size - self._size)
        self._area += learnt * (float(own.sum()) - self._area)
        self._span += learnt * (float(np.hypot(*size)) - self._span)
        self._contrast += learnt * (contrast - self._contrast)

    def _move(self, place: NDArray[np.float64], expected: NDArray[np.float64]) -> None:
        """Move to a place where the target was found."""
        passed_s, self._found_s = self._time_s - self._found_s, self._time_s
        if passed_s > 0.0:
            self._velocity = self._velocity + self._parameters.velocity_share * (place - expected) / passed_s
        self._place = place

    def _learn(
        self,
        picture: NDArray[np.float32],
        difference: NDArray[np.float32],
        known: NDArray[np.bool_],
        owners: NDArray[np.uint8],
        passed_s: float,
    ) -> None:
        """Let the background follow the picture, but for the target's places."""
        background = self._panorama.background
        time_s = np.where(owners == 0, np.float32(_LEARNT_S), np.float32(_ABSORBED_S))
        share = np.where(self._near(picture.shape, 1.3), np.float32(0.0), 1.0 - np.exp(-passed_s / time_s))
        fresh = np.isfinite(picture) & ~known
        background[known] += (share * difference)[known]
        background[fresh] = picture[fresh]

    def _near(self, shape: tuple[int, int], sides: float) -> NDArray[np.bool_]:
        """Return the places (H, W) of the window within a box, ``sides`` times the target's, about the target."""
        low, high = (self._place - self._panorama.low + sign * 0.5 * sides * self._size for sign in (-1.0, 1.0))
        x, y = np.arange(shape[1]) + 0.5, np.arange(shape[0]) + 0.5
        return ((y >= low[1]) & (y < high[1]))[:, None] & ((x >= low[0]) & (x < high[0]))


def _mapped(H: NDArray[np.float64], points: NDArray[np.float64], middle: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return points (N, 2) by a homography; those that do not lie ahead far out on their side of the middle (2,)."""
    mapped = np.c_[points, np.ones(len(points))] @ H.T
    aside = mapped[:, :2] - mapped[:, 2:] * middle
    return middle + aside / np.maximum(mapped[:, 2:], _LEAST_DEPTH)


def _without(picture: NDArray[np.float32], places: NDArray[np.bool_]) -> NDArray[np.float32]:
    """Return a picture (H, W), NaN where it is unknown, as it would be without what lies at some places (H, W)."""
    known = np.isfinite(picture)
    around = np.where(known, picture, np.float32(0.0))
    filled = cv2.inpaint(around, (places | ~known).astype(np.uint8), 3.0, cv2.INPAINT_TELEA)
    return np.where(known, filled, picture)


def _centroid(places: NDArray[np.bool_]) -> NDArray[np.float64]:
    """Return the mean (x, y) of some places (H, W)."""
    rows, columns = np.nonzero(places)
    return np.array([columns.mean(), rows.mean()])


def _edges(level: NDArray[np.float32]) -> NDArray[np.float32]:
    """Return the sum of the absolute slopes (H, W) across and down of a picture (H, W), in levels for a place."""
    across, down = (np.abs(cv2.Sobel(level, cv2.CV_32F, dx, 1 - dx, scale=0.125)) for dx in (1, 0))
    return across + down


def _distance(places: NDArray[np.uint8]) -> NDArray[np.float32]:
    """Return the distance (H, W) to the nearest of the places (H, W); infinite without any."""
    if not places.any():
        return np.full(places.shape, np.inf, np.float32)
    return cv2.distanceTransform(1 - places, cv2.DIST_L2, 3)


def _rotation(observation: Observation) -> NDArray[np.float64]:
    return np.eye(3) if observation.ego is None else observation.ego.T_world_camera[:3, :3]


def _level(observation: Observation) -> NDArray[np.float32]:
    """Return the brightness (H, W): a thermal camera's counts, which no gain control changes, or grey levels."""
    if observation.counts is not None:
        return observation.counts.astype(np.float32)
    return cv2.cvtColor(observation.image_rgb, cv2.COLOR_RGB2GRAY).astype(np.float32)
