"""Detection of candidates by colour, motion, shape and size, at expected places and over the whole picture."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from trackers.kernels.boxes import length_parts_px
from trackers.kernels.ground_camera import CENTRE_HEIGHT_M, GroundCamera
from trackers.mosaic_graph.colour_model import ColourModel
from trackers.mosaic_graph.kernels import oriented_box as ob
from trackers.mosaic_graph.mosaic import SHRINK, draw_disc, to_full, to_small
from trackers.mosaic_graph.registration import Registered

_FEATURES = (ob.INSIDE, ob.AROUND, ob.MISMATCH, ob.MOVED, ob.MOVED_AROUND)
# Means and deviations of the measures, and the number of pictures this prior is worth: medians over development
# episodes. Below: least deviations.
_TARGET = (np.array([3.2, -2.6, 14.0, 58.0, 10.0]), np.array([0.8, 1.0, 8.0, 18.0, 8.0]), 6.0)
_REST = (np.array([0.4, -2.4, 30.0, 25.0, 15.0]), np.array([1.3, 1.1, 14.0, 20.0, 12.0]), 40.0)
_TARGET_FLOOR = np.array([0.6, 0.8, 8.0, 15.0, 10.0])
_REST_FLOOR = np.array([0.8, 0.8, 10.0, 15.0, 8.0])
_LONGEST_MEMORY = 150.0
# Greatest squared deviations: with the tails of a normal distribution one outlier would decide. Colour may.
_TAILS = np.array([14.0, 6.0, 8.0, 6.0, 3.0])
_LEAST, _MOST = -6.0, 6.0
# Weight of each measure: logistic regression of "is the target, just back in view" on the differences of
# log-densities, over development episodes. The surroundings change with the place: their weight is 0.
_WORTH = np.array([1.2, 0.0, 1.0, 2.0, 0.3])
_MOSTLY_KNOWN = 0.5


class _Class:
    """Running mean and deviation of the features of one class, starting from a prior."""

    def __init__(
        self, prior: tuple[NDArray[np.float64], NDArray[np.float64], float], floor: NDArray[np.float64]
    ) -> None:
        self._mean = prior[0].copy()
        self._square = prior[1] ** 2
        self._count = np.full(len(_FEATURES), prior[2])
        self._floor = floor

    def learn(self, features: NDArray[np.float64]) -> None:
        """Update the class with features (F,); NaN = not measured."""
        given = np.isfinite(features)
        self._count[given] = np.minimum(self._count[given] + 1, _LONGEST_MEMORY)
        surprise = np.where(given, features - self._mean, 0.0)
        rate = 1.0 / self._count
        self._mean += rate * surprise
        self._square += rate * np.where(given, surprise**2 - self._square, 0.0)

    def recentre(self, features: NDArray[np.float64]) -> None:
        """Set the means to features (F,), where these are given."""
        self._mean = np.where(np.isfinite(features), features, self._mean)

    def log_density(self, features: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the log of a heavy-tailed normal density at each feature (F,)."""
        deviation = np.maximum(np.sqrt(self._square), self._floor)
        return -0.5 * np.minimum(((features - self._mean) / deviation) ** 2, _TAILS) - np.log(deviation)


class Likeness:
    """Naive Bayes classifier of the measures of ``kernels.oriented_box``, with the classes target and rest."""

    def __init__(self) -> None:
        self._target = _Class(_TARGET, _TARGET_FLOOR)
        self._rest = _Class(_REST, _REST_FLOOR)

    def log_ratio(self, measures: NDArray[np.float64]) -> float:
        """Return ``log p(measures | target) - log p(measures | rest)`` of measures (MEASURES,), in [-6, 6]."""
        features = _features(measures)
        difference = self._target.log_density(features) - self._rest.log_density(features)
        return float(np.clip(np.nansum(_WORTH * difference), _LEAST, _MOST))

    def start(self, measures: NDArray[np.float64]) -> None:
        """Replace the target's prior means by the measures (MEASURES,) of the first picture.

        There the background is the ground around the target.
        """
        features = _features(measures)
        # The frame around the box lies on that ground: its difference is no measurement.
        features[_FEATURES.index(ob.MOVED_AROUND)] = np.nan
        self._target.recentre(features)

    def learn_target(self, measures: NDArray[np.float64]) -> None:
        """Update the target's class with measures (MEASURES,)."""
        self._target.learn(_features(measures))

    def learn_rest(self, measures: NDArray[np.float64]) -> None:
        """Update the class of the rest with measures (MEASURES,) of another candidate."""
        self._rest.learn(_features(measures))


def _features(measures: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the features (F,), with NaN where the template or the background is unknown."""
    features = measures[list(_FEATURES)]
    if measures[ob.MISMATCH] == 0.0:
        features[_FEATURES.index(ob.MISMATCH)] = np.nan
    if measures[ob.KNOWN] < _MOSTLY_KNOWN:
        features[[_FEATURES.index(ob.MOVED), _FEATURES.index(ob.MOVED_AROUND)]] = np.nan
    return features


_OFTEN_SEEN = 4
_WHOLE = 0.85
_ALIGN = np.array([1.0, -0.7, -0.08, 0.03, -0.03, 0.0, 0.0])
_TURNS_RAD = np.array([-0.3, -0.15, 0.0, 0.15, 0.3])
_SPOT_TURNS_RAD = np.array([-0.5, -0.2, 0.0, 0.2, 0.5, 0.5 * np.pi])
_REACH_PX, _SPOT_REACH_PX = 6, 2
_DIFFERENCE_WORTH = 0.03
_LEAST_EXTENT = 1e-12
_SURROUNDINGS = 0.7
_COLOUR_STANDS_OUT, _MOTION_STANDS_OUT, _MOVED_CAP = 0.3, 8.0, 50


@dataclass(frozen=True, eq=False)
class Candidate:
    """A box in the picture that may be the target.

    Attributes:
        position_m: (2,) centre on the map.
        axis_rad: axis on the map, up to half a turn.
        log_ratio: log p(measures | target) / p(measures | something else).
        measures: (MEASURES,) of ``trackers.mosaic_graph.kernels.oriented_box``.
    """

    position_m: NDArray[np.float64]
    axis_rad: float
    log_ratio: float
    measures: NDArray[np.float64]

    @property
    def covered(self) -> float:
        """Share of the box inside the picture."""
        return float(self.measures[ob.COVERED])

    @property
    def is_whole(self) -> bool:
        """Whether nearly all of it is inside: a box cut by the border is measured too far inside, and turned."""
        return self.covered > _WHOLE


@dataclass(frozen=True, eq=False)
class Cues:
    """Maps of one picture, shrunk by ``SHRINK``.

    Attributes:
        log_ratio: (H, W) of colour.
        difference: (H, W) uint8, largest difference from the mosaic over the colours, ``UNKNOWN`` where the mosaic has
            seen too few pictures.
    """

    log_ratio: NDArray[np.float32]
    difference: NDArray[np.uint8]


class Detector:
    """Finds candidates; learns the target's colours and its template."""

    def __init__(self, size_m: tuple[float, float], candidates: int) -> None:
        """Begin for a target of ``size_m`` (length, width) with up to ``candidates`` beside the expected ones."""
        self._size_m = size_m
        self._half_size_m = 0.5 * np.array(size_m)
        self._candidates = candidates
        self.colours = ColourModel()
        self.likeness = Likeness()
        self._template = np.zeros((ob.ALONG, ob.ACROSS, 3), np.float32)

    def cues(self, registered: Registered) -> Cues:
        """Return the maps of a picture."""
        red, green, blue = cv2.split(cv2.absdiff(registered.small_rgb, registered.background_rgb))
        difference = cv2.max(cv2.max(red, green), blue)
        np.minimum(difference, ob.UNKNOWN - 1, out=difference)
        difference[registered.seen < _OFTEN_SEEN] = ob.UNKNOWN
        return Cues(self.colours.log_ratio(registered.small_rgb), difference)

    def search(
        self, registered: Registered, cues: Cues, expected_m: list[tuple[NDArray[np.float64], float]]
    ) -> list[Candidate]:
        """Return distinct candidates: near expected places (2,) and headings, then over the whole picture."""
        boxes = [
            self.measure(registered, cues, position_m, heading_rad + _TURNS_RAD, _REACH_PX)
            for position_m, heading_rad in expected_m
        ]
        boxes += [self._measure_spot(registered, cues, pixel) for pixel in self._peaks(cues, registered.camera)]
        found: list[Candidate] = []
        for box in boxes:
            if box is not None and _is_new(box, found, self._half_size_m[0]):
                found.append(box)
        return found

    def learn(
        self, registered: Registered, position_m: NDArray[np.float64], axis_rad: float, shape_rate: float
    ) -> None:
        """Learn the target's colours at a place (2,) on the map, and its template by ``shape_rate`` (1 replaces it)."""
        centre, jacobian = place(registered.camera, position_m)
        if not np.isfinite(jacobian).all():
            return
        along, across = ob.half_axes(jacobian, self._half_size_m, axis_rad)
        patch = ob.sample_template(registered.small_rgb, centre, along, across)
        if np.isnan(patch).any():
            return
        # The outermost samples may show the road.
        core = np.ascontiguousarray(np.clip(patch[1:-1, 1:-1] + 0.5, 0, 255).astype(np.uint8))
        self.colours.learn_target(core, np.ones(core.shape[:2], np.float32))
        turned = np.ascontiguousarray(patch[::-1, ::-1])
        if np.abs(turned - self._template).sum() < np.abs(patch - self._template).sum():
            patch = turned
        self._template += shape_rate * (patch - self._template)

    def measure(
        self,
        registered: Registered,
        cues: Cues,
        position_m: NDArray[np.float64],
        headings_rad: NDArray[np.float64],
        reach_px: int,
    ) -> Candidate | None:
        """Return the best box near a place on the map, or None if it lies outside the picture.

        Args:
            headings_rad: (K,) on the map, to try.
            reach_px: greatest distance from the place along each axis, in pixels of the small picture.
        """
        centre, jacobian = place(registered.camera, position_m)
        height, width = cues.difference.shape
        inside = -4 < centre[0] < width + 4 and -4 < centre[1] < height + 4
        if not (inside and np.isfinite(jacobian).all()):
            return None
        pictures = (registered.small_rgb, cues.log_ratio, cues.difference, self._template)
        search = (self._half_size_m, headings_rad, reach_px, _ALIGN)
        centre, heading, measures = ob.fit_box(*pictures, centre, jacobian, *search)
        if measures[ob.COVERED] < 0.4:
            return None
        place_m = registered.camera.to_map(to_full(centre)[None], CENTRE_HEIGHT_M)[0]
        if not np.isfinite(place_m).all():
            return None
        return Candidate(place_m, heading, self.likeness.log_ratio(measures), measures)

    def measure_at(
        self, registered: Registered, cues: Cues, position_m: NDArray[np.float64], axis_rad: float
    ) -> Candidate:
        """Return the box at exactly this place and axis."""
        centre, jacobian = place(registered.camera, position_m)
        along, across = ob.half_axes(jacobian, self._half_size_m, axis_rad)
        pictures = (registered.small_rgb, cues.log_ratio, cues.difference, self._template)
        measures = ob.measure_box(*pictures, centre, along, across)
        return Candidate(position_m, float(axis_rad), self.likeness.log_ratio(measures), measures)

    @staticmethod
    def merit(candidate: Candidate) -> float:
        """Return how well a box is aligned with the car: the value that ``measure`` maximises."""
        return float(_ALIGN @ candidate.measures)

    def learn_rest(self, registered: Registered, target_m: NDArray[np.float64] | None) -> None:
        """Learn the background's colours from the whole picture, except around the target (2,) if it is visible."""
        weight = np.ones(registered.small_rgb.shape[:2], np.float32)
        if target_m is not None:
            centre, jacobian = place(registered.camera, target_m)
            if np.isfinite(jacobian).all():
                radius_px = 1.1 * self._half_size_m[0] * float(np.sqrt(abs(np.linalg.det(jacobian))))
                draw_disc(weight, centre, radius_px, 0.0)
        self.colours.learn_rest(registered.small_rgb, weight)
        self.colours.refresh()

    def _measure_spot(self, registered: Registered, cues: Cues, pixel: NDArray[np.float64]) -> Candidate | None:
        """Return the best box at a spot of the shrunk picture, starting along and across the spot's axis."""
        radius_px = 0.65 * self._size_m[0] / (SHRINK * registered.camera.metres_per_pixel())
        centre, angle = ob.spot_axis(cues.log_ratio, cues.difference, pixel, radius_px, _DIFFERENCE_WORTH)
        position_m = registered.camera.to_map(to_full(centre)[None], CENTRE_HEIGHT_M)[0]
        _, jacobian = place(registered.camera, position_m)
        # At the horizon the Jacobian is undefined or singular.
        if not (np.isfinite(jacobian).all() and abs(np.linalg.det(jacobian)) > _LEAST_EXTENT):
            return None
        along = np.linalg.inv(jacobian) @ np.array([np.cos(angle), np.sin(angle)])
        axis_rad = float(np.arctan2(along[1], along[0]))
        return self.measure(registered, cues, position_m, axis_rad + _SPOT_TURNS_RAD, _SPOT_REACH_PX)

    def _peaks(self, cues: Cues, camera: GroundCamera) -> NDArray[np.float64]:
        """Return the pixels (K, 2) of the shrunk picture where a car-sized spot stands out, in colour or motion."""
        pixels_per_metre = 0.5 / (SHRINK * camera.metres_per_pixel())
        narrow_px = 2 * max(1, int(0.5 * self._size_m[1] * pixels_per_metre)) + 1
        wide_px = 2 * int(0.8 * self._size_m[0] * pixels_per_metre) + 1
        radius_px = max(1, int(0.4 * self._size_m[0] * pixels_per_metre))
        moved = np.where(cues.difference == ob.UNKNOWN, 0, np.minimum(cues.difference, _MOVED_CAP)).astype(np.float32)
        found = [
            _spots(cues.log_ratio, narrow_px, wide_px, radius_px, _COLOUR_STANDS_OUT, self._candidates),
            _spots(moved, narrow_px, wide_px, radius_px, _MOTION_STANDS_OUT, self._candidates // 2),
        ]
        return 2.0 * np.vstack(found) + 0.5


def _spots(
    cue: NDArray[np.float32], narrow_px: int, wide_px: int, radius_px: int, threshold: float, most: int
) -> NDArray[np.float64]:
    """Return the places (K, 2), (column, row) at half the size of ``cue``, of its highest local contrasts."""
    if min(cue.shape) < 2:
        return np.empty((0, 2))
    half = cv2.resize(cue, None, fx=0.5, fy=0.5, interpolation=cv2.INTER_AREA)
    spot = cv2.blur(half, (narrow_px, narrow_px)) - _SURROUNDINGS * cv2.blur(half, (wide_px, wide_px))
    highest = cv2.dilate(spot, np.ones((2 * radius_px + 1, 2 * radius_px + 1), np.uint8))
    row, column = np.nonzero((spot >= highest) & (spot > threshold))
    order = np.argsort(spot[row, column])[::-1][:most]
    return np.column_stack([column, row])[order].astype(np.float64)


def _is_new(candidate: Candidate, found: list[Candidate], radius_m: float) -> bool:
    return all(np.linalg.norm(candidate.position_m - other.position_m) > radius_m for other in found)


def place(camera: GroundCamera, position_m: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return the index (2,) of a car's middle in the shrunk picture, and its derivative (2, 2) by map position."""
    around = position_m + np.array([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]])
    pixels = to_small(camera.to_picture(around, CENTRE_HEIGHT_M))
    return pixels[0], np.column_stack([pixels[1] - pixels[0], pixels[2] - pixels[0]])


_SPREAD_RAD = np.array([-0.2, -0.1, 0.0, 0.1, 0.2])
_RING = (0.6, 0.85)


def look_first(detector: Detector, registered: Registered, box_xyxy: NDArray[np.float64], length_m: float) -> Candidate:
    """Train ``detector`` on the target inside a box (4,) of the first picture; return the target as a candidate."""
    camera = registered.camera
    start_m = camera.to_map(0.5 * (box_xyxy[None, :2] + box_xyxy[None, 2:]), CENTRE_HEIGHT_M)[0]
    axes_rad = _axes_rad(registered, start_m, box_xyxy)
    for axis_rad in axes_rad:
        detector.learn(registered, start_m, axis_rad, shape_rate=0.0)
    detector.learn_rest(registered, start_m)
    contrast = _contrast(registered, start_m, length_m)
    cues = Cues(detector.colours.log_ratio(registered.small_rgb), contrast)
    # The place is known from the box: a fit of it would include the car's shadow.
    trials = (axes_rad[:, None] + _SPREAD_RAD).ravel()
    found = max((detector.measure_at(registered, cues, start_m, axis) for axis in trials), key=detector.merit)
    detector.learn(registered, start_m, found.axis_rad, shape_rate=1.0)
    detector.likeness.start(found.measures)
    return found


def _axes_rad(
    registered: Registered, start_m: NDArray[np.float64], box_xyxy: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Return the two axes (2,) on the map along which the car may lie: an upright box has a mirrored solution."""
    across_px, down_px = length_parts_px(box_xyxy)
    map_from_picture = np.linalg.inv(place(registered.camera, start_m)[1])
    directions = map_from_picture @ np.array([[across_px, across_px], [down_px, -down_px]])
    return np.arctan2(directions[1], directions[0])


def _contrast(registered: Registered, start_m: NDArray[np.float64], length_m: float) -> NDArray[np.uint8]:
    """Return the largest difference over the colours of each pixel (H, W) from the ground around the car."""
    centre, jacobian = place(registered.camera, start_m)
    length_px = length_m * float(np.sqrt(abs(np.linalg.det(jacobian))))
    rows, columns = np.indices(registered.small_rgb.shape[:2])
    distance = np.hypot(columns - centre[0], rows - centre[1]) / length_px
    around = registered.small_rgb[(distance > _RING[0]) & (distance < _RING[1])]
    if len(around) == 0:
        return np.zeros(registered.small_rgb.shape[:2], np.uint8)
    difference = np.abs(registered.small_rgb - np.median(around, axis=0)).max(axis=2)
    return np.minimum(difference, ob.UNKNOWN - 1).astype(np.uint8)
