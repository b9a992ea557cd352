"""Learns mean and variance of the colours of ground classes (paper A.3, supervised)."""

from __future__ import annotations

import json
from collections.abc import Sequence
from contextlib import closing
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from scenarios.road_town.layout import Building, Layout
from scenarios.road_town.road_map import RoadMap
from scenarios.road_town.scenario import ROAD_TOWN
from scenarios.scenario import Frame
from sim.optics import rays
from trackers.atomic_file import write_atomic

MODEL_PATH = Path(__file__).resolve().parents[2] / "trackers" / "paper_a" / "road_town_classes.json"
CLASSES = ("road", "other", "building")
_GROUND_BELOW_M = 0.3
_BUILDING_ABOVE_M = 2.0
_EAVES_M = 0.8
_PIXEL_STEP = 3


def learn_colours(presets: Sequence[str], seeds: range, every: int) -> dict[str, Any]:
    """Return mean and variance of the sRGB values (0-255) of each class, over every ``every``-th frame of all towns."""
    sums = {name: np.zeros((3, 3)) for name in CLASSES}
    for preset in presets:
        for seed in seeds:
            with closing(ROAD_TOWN.episode(preset, seed, closed_loop=False)) as episode:
                roads = RoadMap(episode.map_of().graph)
                last = (episode.frame_count - 1) // every * every
                for k in range(last + 1):
                    frame = episode.step()
                    if k % every == 0:
                        _add(sums, frame, roads, episode.map_of())
    return {name: _moments(sums[name]) for name in CLASSES}


def write_model(model: dict[str, Any], command: str) -> Path:
    """Write a learnt model to the file that trackers load; return its path."""
    write_atomic(MODEL_PATH, json.dumps({"classes": model, "command": command}, indent=1) + "\n")
    return MODEL_PATH


def _add(sums: dict[str, NDArray[np.float64]], frame: Frame, roads: RoadMap, layout: Layout) -> None:
    """Add count, sum and sum of squares (rows) of each band (columns)."""
    colours = frame.observation.image_rgb[::_PIXEL_STEP, ::_PIXEL_STEP].reshape(-1, 3).astype(float)
    for name, mask in label_pixels(frame, roads, layout).items():
        chosen = colours[mask[::_PIXEL_STEP, ::_PIXEL_STEP].ravel()]
        sums[name] += np.stack([np.full(3, float(len(chosen))), chosen.sum(axis=0), (chosen**2).sum(axis=0)])


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


def _moments(sums: NDArray[np.float64]) -> dict[str, Any]:
    count = max(float(sums[0, 0]), 1.0)
    mean = sums[1] / count
    variance = sums[2] / count - mean**2
    return {
        "mean_rgb": [round(float(value), 3) for value in mean],
        "variance_rgb": [round(float(value), 3) for value in variance],
        "pixels": int(sums[0, 0]),
    }
