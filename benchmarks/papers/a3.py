"""Paper experiment A.3: a model of the background during frame-outs, with unknown helicopter motion.

Beside the table stand the confusion matrix of the pixel classes, and the paper's figures 2 to 5: a picture, the classes
of its pixels, the road in it, and the classes corrected by it.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from benchmarks.contract.rows import Row
from benchmarks.contract.text import number_text
from benchmarks.papers.experiment import TextTable
from benchmarks.papers.tracker_experiment import TrackerExperiment
from benchmarks.show.video import marks
from benchmarks.show.video.contact_sheet import picture_sheet
from scenarios.road_town.layout import Building, Layout
from scenarios.road_town.road_map import RoadMap
from scenarios.road_town.scenario import ROAD_TOWN, RoadTownScenario
from scenarios.scenario import Frame, RendererName
from sim.optics import rays
from trackers.kernels.boxes import box_centre
from trackers.kernels.colour_template import ColourTemplate
from trackers.road_shape.background_motion import STILL
from trackers.road_shape.background_pf import BackgroundParameters
from trackers.road_shape.car_state import image_centre
from trackers.road_shape.existence import ExistenceMap
from trackers.road_shape.ground_classes import ClassStatistics, load_class_statistics
from trackers.road_shape.pixel_classes import OTHER_EXISTENCE, ROAD_EXISTENCE, PixelClassifier
from trackers.road_shape.road_lines import RoadSearch
from trackers.road_shape.road_model import RoadCurve, RoadModel
from trackers.road_shape.spline import evaluate_spline
from trackers.types import Observation

CLASSES = ("road", "other", "building")
_CLASS_RGB = np.array([(0, 0, 255), (0, 255, 0), (255, 0, 0)], np.uint8)
"""The paper's colours of road, other and building (4.7-4.9)."""
_GROUND_BELOW_M = 0.3
_BUILDING_ABOVE_M = 2.0
_EAVES_M = 0.8
_ONE_PIXEL = np.ones(2)
_ENLARGED = 2
_FIRST_ONLY = 1_000_000
_SHOWN_TOWNS = 3
_TOWNS = 12
"""Largest number of towns of which the pixels are counted, each in its first picture."""


@dataclass(frozen=True, slots=True, kw_only=True)
class BackgroundExperiment(TrackerExperiment):
    """See ``TrackerExperiment``. Also shows how well the method tells road, other ground and buildings apart."""

    def show(self, out: Path, rows: Sequence[Row], seeds: range, renderer: RendererName) -> None:
        """See ``PaperExperiment``: the paper's frames, and its figures of classes and road in some towns."""
        TrackerExperiment.show(self, out, rows, seeds, renderer)
        statistics = load_class_statistics(BackgroundParameters().class_model)
        shown = seeds[:_SHOWN_TOWNS]
        cells = [figures_of_town(ROAD_TOWN, self.preset, seed, statistics, renderer) for seed in shown]
        caption = (
            "The first picture of a town, a row for each. Blue: road; green: other; red: building, also what is within "
            "both of road and other or within neither. In the third column the road's centre line and edges, as the "
            "method found them from the lines beside the car; dots are the points that its spline joins. In the fourth "
            "the classes by which it weighs places: within the edges road, and beside them no building."
        )
        self.write_figure(out, picture_sheet(cells, 320), shown[0], renderer, "figures 2 to 5", caption, "classes")

    def matrix(self, seeds: range, renderer: RendererName) -> TextTable:
        """See ``PaperExperiment``: the confusion matrix of the pixel classes in the experiment's own towns."""
        model = BackgroundParameters().class_model
        towns = seeds[:_TOWNS]
        shares = confusion(ROAD_TOWN, self.preset, towns, _FIRST_ONLY, load_class_statistics(model), renderer)
        words = (
            f"Rows: what a pixel is; columns: what the method takes it for, before the road's shape corrects it. First "
            f"pictures of {len(towns)} towns; the colours were learnt in others. By the paper's rule a pixel within "
            "both road and other, or within neither, is building."
        )
        rows = (
            (name, *(f"{number_text(share, 'fraction')} %" for share in row))
            for name, row in zip(CLASSES, shares, strict=True)
        )
        return TextTable("Pixel classes", words, ("", *CLASSES), tuple(rows))


def labelled_frames(
    scenario: RoadTownScenario, preset: str, seeds: range, every: int, renderer: RendererName = "raster"
) -> Iterator[tuple[NDArray[np.uint8], dict[str, NDArray[np.bool_]]]]:
    """Yield every ``every``-th picture (H, W, 3) of each episode, with its ``label_pixels``."""
    for seed in seeds:
        with closing(scenario.episode(preset, seed, renderer=renderer, closed_loop=False)) as episode:
            layout = episode.map_of()
            roads = RoadMap(layout.graph)
            for k in range((episode.frame_count - 1) // every * every + 1):
                frame = episode.step()
                if k % every == 0:
                    yield frame.observation.image_rgb, label_pixels(frame, roads, layout)


def label_pixels(frame: Frame, roads: RoadMap, layout: Layout) -> dict[str, NDArray[np.bool_]]:
    """Return a mask (H, W) for each class, from depth and map; cars, trees and kerbs' faces belong to none.

    Ground (below 0.3 m) is road or other; points above 2 m over a building's plan, eaves included, are building.
    """
    truth, camera = frame.truth, frame.camera
    rows, columns = np.mgrid[0 : camera.height_px, 0 : camera.width_px]
    directions = rays(camera, truth.T_world_camera, np.stack([columns, rows], axis=-1) + 0.5)
    depth_m = np.where(np.isfinite(truth.depth_m), truth.depth_m, np.nan)
    points_m = truth.T_world_camera[:3, 3] + directions * depth_m[..., None]
    cars = np.isin(truth.instance_map, truth.instance_id)
    with np.errstate(invalid="ignore"):
        ground = (points_m[..., 2] < _GROUND_BELOW_M) & ~cars
        high = (points_m[..., 2] > _BUILDING_ABOVE_M) & ~cars
    on_road = np.zeros_like(ground)
    on_road[ground] = roads.is_on_road(points_m[ground][:, :2])
    over = np.zeros_like(high)
    over[high] = _over_buildings(points_m[high][:, :2], layout.buildings)
    return {"road": ground & on_road, "other": ground & ~on_road, "building": over}


def _over_buildings(points_m: NDArray[np.float64], buildings: Sequence[Building]) -> NDArray[np.bool_]:
    over = np.zeros(len(points_m), dtype=bool)
    for building in buildings:
        offset = points_m - np.array(building.centre_m)
        c, s = np.cos(building.yaw_rad), np.sin(building.yaw_rad)
        along, across = offset @ [c, s], offset @ [-s, c]
        half = 0.5 * np.array(building.size_m[:2]) + _EAVES_M
        over |= (np.abs(along) < half[0]) & (np.abs(across) < half[1])
    return over


def confusion(
    scenario: RoadTownScenario,
    preset: str,
    seeds: range,
    every: int,
    statistics: ClassStatistics,
    renderer: RendererName = "raster",
) -> NDArray[np.float64]:
    """Return the share (3, 3) of the pixels of each true class (row) that are given each class (column).

    Classes are in the order of ``CLASSES``: road, other, building. Pixels of cars and trees do not count, nor does the
    road's shape, which corrects the classes afterwards. NaN for a class without pixels.

    Args:
        seeds: towns, of which every ``every``-th frame counts.
    """
    classifier = PixelClassifier(statistics.mean_rgb, statistics.variance_rgb, statistics.of_road)
    counts = np.zeros((3, 3))
    for image_rgb, labels in labelled_frames(scenario, preset, seeds, every, renderer):
        given = classifier.classify(image_rgb)
        for row, name in enumerate(CLASSES):
            counts[row] += np.bincount(given[labels[name]], minlength=3)
    with np.errstate(invalid="ignore"):
        return counts / counts.sum(axis=1, keepdims=True)


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
