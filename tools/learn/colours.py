"""``python -m tools learn-colours``: learn mean and variance of the colours of road and other ground, light by light
(paper A.3, supervised).

The paper's town has one light, and one mean and variance for each class. In our towns sun and shade, the sun's height
and the exposure move the brightness of road and of other ground by twice the distance of their means, so that one set
of statistics puts nearly every pixel within both, and so building. So a class's labelled pixels are grouped by
brightness into a few lights (k-means), each with a mean and a variance; the paper's rule stays (``PixelClassifier``).
Other ground is of more kinds than road (lawn, crops, pavements, yards) and has more of them. The numbers of lights are
fitted, by two-fold cross-validation over 14 development towns: recalls of road, other and building were 0.05, 0.04 and
0.91 with one light each, 0.68, 0.64 and 0.68 with these. Dividing by the picture's own brightness first did not
help: the camera's exposure does it.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import closing
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from benchmarks.cli.arguments import DevelopmentSeeds, Names, seeds_text
from scenarios.road_town.road_map import RoadMap
from scenarios.road_town.scenario import ROAD_TOWN
from scenarios.scenario import Frame
from sim.checks import check
from sim.optics import rays
from tools.learn.swims import TRACKERS, write

MODEL_PATH = TRACKERS / "road_shape" / "road_town_classes.json"
LIGHTS = {"road": 3, "other": 12}
"""Class → number of lights. The paper has no statistics of buildings."""
_GROUND_BELOW_M = 0.3
_PIXEL_STEP = 2
_BRIGHTNESSES = 3 * 255 + 1
"""Brightness is the sum of the bands."""
_LEAST_VARIANCE = 1.0


@dataclass(frozen=True)
class LearnColours:
    """Learn mean and variance of the colours of road and other ground in each light; write them to the trackers' file.

    Pictures come from development towns only, labels from their truth.

    Attributes:
        preset: one or more of the town's presets to take towns from.
        seeds: towns A to B - 1, or A alone, below 10,000.
        every: use one frame in this number.
    """

    preset: Names = ("quick",)
    seeds: DevelopmentSeeds = range(16)
    every: int = 60
    resumes = False

    def run(self) -> int:
        """Learn; return the exit status."""
        check("every", self.every >= 1, "a whole number >= 1", self.every)
        chosen = f"--preset {' '.join(self.preset)} --seeds {seeds_text(self.seeds)} --every {self.every}"
        command = f"python -m tools learn-colours {chosen}"
        print(write(MODEL_PATH, {"classes": learn_colours(self.preset, self.seeds, self.every)}, command))
        return 0


def learn_colours(presets: Sequence[str], seeds: range, every: int) -> dict[str, Any]:
    """Return mean and variance of the sRGB values (0-255) of each light of each class, from dark to bright."""
    sums = {name: np.zeros((_BRIGHTNESSES, 7)) for name in LIGHTS}
    for preset in presets:
        for image_rgb, labels in labelled_frames(preset, seeds, every):
            thinned = image_rgb[::_PIXEL_STEP, ::_PIXEL_STEP]
            for name in LIGHTS:
                sums[name] += brightness_sums(thinned[labels[name][::_PIXEL_STEP, ::_PIXEL_STEP]])
    return {name: _lights(sums[name], count) for name, count in LIGHTS.items()}


def labelled_frames(
    preset: str, seeds: range, every: int
) -> Iterator[tuple[NDArray[np.uint8], dict[str, NDArray[np.bool_]]]]:
    """Yield every ``every``-th picture (H, W, 3) of each episode, with its ``label_pixels``."""
    for seed in seeds:
        with closing(ROAD_TOWN.episode(preset, seed, closed_loop=False)) as episode:
            roads = RoadMap(episode.map_of().graph)
            for k in range((episode.frame_count - 1) // every * every + 1):
                frame = episode.step()
                if k % every == 0:
                    yield frame.observation.image_rgb, label_pixels(frame, roads)


def label_pixels(frame: Frame, roads: RoadMap) -> dict[str, NDArray[np.bool_]]:
    """Return a mask (H, W) of road and one of other ground (below 0.3 m), from depth and map; neither has cars."""
    truth, camera = frame.truth, frame.camera
    rows, columns = np.mgrid[0 : camera.height_px, 0 : camera.width_px]
    directions = rays(camera, truth.T_world_camera, np.stack([columns, rows], axis=-1) + 0.5)
    depth_m = np.where(np.isfinite(truth.depth_m), truth.depth_m, np.nan)
    points_m = truth.T_world_camera[:3, 3] + directions * depth_m[..., None]
    with np.errstate(invalid="ignore"):
        ground = (points_m[..., 2] < _GROUND_BELOW_M) & ~np.isin(truth.instance_map, truth.instance_id)
    on_road = np.zeros_like(ground)
    on_road[ground] = roads.is_on_road(points_m[ground][:, :2])
    return {"road": on_road, "other": ground & ~on_road}


def brightness_sums(colours_rgb: NDArray[np.uint8]) -> NDArray[np.float64]:
    """Return for each brightness (766, 7) the count of pixels (N, 3), and each band's sum and sum of squares."""
    colours = colours_rgb.astype(float)
    terms = np.column_stack([np.ones(len(colours)), colours, colours**2])
    brightness = colours_rgb.sum(axis=1, dtype=np.int64)
    return np.column_stack([np.bincount(brightness, term, _BRIGHTNESSES) for term in terms.T])


def lights_of_brightness(counts: NDArray[np.float64], lights: int) -> NDArray[np.int64]:
    """Return the light of each brightness (766,), 0 the darkest: k-means of the brightness of ``counts`` pixels."""
    brightness = np.arange(counts.size)
    share = np.cumsum(counts) / counts.sum()
    centres = np.interp(np.linspace(0.1, 0.9, lights), share, brightness)
    for _ in range(100):
        light = np.abs(brightness[:, None] - centres).argmin(axis=1)
        number = np.bincount(light, counts, lights)
        total = np.bincount(light, counts * brightness, lights)
        centres = np.where(number > 0, total / np.maximum(number, 1.0), centres)
    return light


def _lights(sums: NDArray[np.float64], lights: int) -> list[dict[str, Any]]:
    light = lights_of_brightness(sums[:, 0], lights)
    grouped = [sums[light == each].sum(axis=0) for each in range(lights)]
    return [_moments(each) for each in grouped if each[0] > 0]


def _moments(sums: NDArray[np.float64]) -> dict[str, Any]:
    mean = sums[1:4] / sums[0]
    variance = np.maximum(sums[4:] / sums[0] - mean**2, _LEAST_VARIANCE)
    return {"mean_rgb": mean.round(3).tolist(), "variance_rgb": variance.round(3).tolist(), "pixels": int(sums[0])}
