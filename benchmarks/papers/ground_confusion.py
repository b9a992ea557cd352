"""Confusion matrix of the pixel classes of paper A.3, on towns that they were not learnt from."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from benchmarks.papers.ground_colours import CLASSES, labelled_frames
from scenarios.road_town.scenario import RoadTownScenario
from scenarios.scenario import RendererName
from trackers.road_shape.existence import ClassStatistics, PixelClassifier


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
