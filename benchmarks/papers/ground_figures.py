"""Figures 2 to 5 of paper A: a picture, the classes of its pixels, the road in it, and the classes corrected by it."""

from __future__ import annotations

from contextlib import closing

import cv2
import numpy as np
from numpy.typing import NDArray

from benchmarks.show.video import marks
from scenarios.road_town.scenario import RoadTownScenario
from scenarios.scenario import RendererName
from trackers.kernels.boxes import box_centre
from trackers.kernels.histogram import ColourTemplate
from trackers.road_shape.background_motion import STILL
from trackers.road_shape.colour_pf import image_centre
from trackers.road_shape.existence import (
    OTHER_EXISTENCE,
    ROAD_EXISTENCE,
    ClassStatistics,
    ExistenceMap,
    PixelClassifier,
)
from trackers.road_shape.road_lines import RoadSearch
from trackers.road_shape.road_model import RoadCurve, RoadModel, evaluate_spline
from trackers.types import Observation

_CLASS_RGB = np.array([(0, 0, 255), (0, 255, 0), (255, 0, 0)], np.uint8)
"""The paper's colours of road, other and building (4.7-4.9)."""
_ONE_PIXEL = np.ones(2)
_ENLARGED = 2


def figures_of_town(
    scenario: RoadTownScenario, preset: str, seed: int, statistics: ClassStatistics, renderer: RendererName
) -> list[tuple[str, NDArray[np.uint8]]]:
    """Return the four figures (H, W, 3) of an episode's first picture, as ``background_pf`` begins, with words."""
    with closing(scenario.episode(preset, seed, renderer=renderer, closed_loop=False)) as episode:
        frame = episode.step()
    box_xyxy = frame.truth.box_xyxy[frame.truth.index_of(scenario.target)]
    return figures_of(frame.observation, box_xyxy, statistics, seed)


def figures_of(
    observation: Observation, box_xyxy: NDArray[np.float64], statistics: ClassStatistics, seed: int = 0
) -> list[tuple[str, NDArray[np.uint8]]]:
    """Return the same of an observation and the box (4,) of the car in it; ``seed`` is that of the road's particles."""
    image_rgb, centre_px = observation.image_rgb, image_centre(observation.camera)
    classifier = PixelClassifier(statistics.mean_rgb, statistics.variance_rgb, statistics.of_road)
    car_px = ColourTemplate.from_box(image_rgb, box_xyxy).car_px
    roads = RoadModel(RoadSearch(), car_px, np.random.default_rng(seed))
    grey = cv2.cvtColor(image_rgb, cv2.COLOR_RGB2GRAY)
    road = roads.update(grey, STILL, box_centre(box_xyxy) - centre_px, None)
    existence = ExistenceMap(image_rgb, classifier, road, centre_px)
    return [
        (f"2: the picture, seed {seed}", _enlarged(image_rgb)),
        ("3: classes of pixels", _enlarged(_CLASS_RGB[classifier.classify(image_rgb)])),
        ("4: the road" if road else "4: no road found", _with_road(image_rgb, road, centre_px)),
        ("5: corrected by the road", _enlarged(_CLASS_RGB[corrected_classes(existence, image_rgb.shape[:2])])),
    ]


def corrected_classes(existence: ExistenceMap, shape: tuple[int, ...]) -> NDArray[np.int64]:
    """Return the class (H, W) whose existence probability the method uses at each pixel."""
    rows, columns = np.mgrid[: shape[0], : shape[1]] + 0.5
    probability = existence.mean_over(np.column_stack([columns.ravel(), rows.ravel()]), _ONE_PIXEL).reshape(shape)
    return np.digitize(-probability, (-ROAD_EXISTENCE, -OTHER_EXISTENCE), right=True)


def _with_road(image_rgb: NDArray[np.uint8], road: RoadCurve | None, centre_px: NDArray[np.float64]) -> marks.Image:
    """Return the enlarged picture with the road's centre line and edges; dots are the points that the spline joins."""
    drawn = _enlarged(image_rgb)
    if road is None:
        return drawn
    along = np.arange(road.knots[0], road.knots[-1] + 1.0)
    values, slopes = evaluate_spline(road.knots, road.pieces, along)
    half_px = road.half_width_px * np.hypot(1.0, slopes)
    for offset_px, colour in ((-half_px, marks.ESTIMATE), (half_px, marks.ESTIMATE), (0.0 * half_px, marks.TRUTH)):
        marks.draw_lines(drawn, _ENLARGED * _in_picture(road, along, values + offset_px, centre_px)[None], colour)
    at_knots, _ = evaluate_spline(road.knots, road.pieces, road.knots)
    for place in marks.fixed_point(_ENLARGED * _in_picture(road, road.knots, at_knots, centre_px)):
        cv2.circle(drawn, place.tolist(), 4 << 4, marks.TRUTH, cv2.FILLED, cv2.LINE_AA, 4)
    return drawn


def _in_picture(
    road: RoadCurve, along: NDArray[np.float64], across: NDArray[np.float64], centre_px: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Return pixels (n, 2) of places along and across the road's axis."""
    places = np.column_stack([along, across])
    return (places if road.axis == 0 else places[:, ::-1]) + centre_px


def _enlarged(image_rgb: NDArray[np.uint8]) -> marks.Image:
    return np.repeat(np.repeat(image_rgb, _ENLARGED, axis=0), _ENLARGED, axis=1)
