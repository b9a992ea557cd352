"""Truth of fish made by hand: straight bodies in a small picture, and tracks on them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import fields
from typing import Any

import numpy as np
from numpy.typing import NDArray

from scenarios.fish_tank.truth import FishTruth
from scenarios.scenario import Frame
from trackers.types import CameraModel, Estimate, Observation, Track

WIDTH_PX, HEIGHT_PX = 120, 80
LENGTH_PX = 16.0
_POINTS = 9


def truth_of(
    places: Sequence[Sequence[float]],
    headings_rad: Sequence[float],
    *,
    frame: int = 0,
    visible: Sequence[float] | None = None,
) -> FishTruth:
    """Return truth of fish with their middles at ``places`` (x, y); later ones lie over earlier ones."""
    count = len(places)
    along = np.linspace(0.5, -0.5, _POINTS) * LENGTH_PX
    ahead = np.stack([np.cos(headings_rad), np.sin(headings_rad)], axis=1)
    middle = np.array(places, float).reshape(count, 2)
    line_px = middle[:, None] + along[None, :, None] * ahead[:, None]
    drawn = np.full((HEIGHT_PX, WIDTH_PX), -1, np.int32)
    for fish in range(count):
        for x, y in np.linspace(line_px[fish, 0], line_px[fish, -1], 40):
            drawn[int(y) - 1 : int(y) + 2, int(x) - 1 : int(x) + 2] = 10 + fish
    given: dict[str, Any] = {
        "frame": frame,
        "time_s": frame / 30.0,
        "T_world_camera": np.eye(4),
        "names": tuple(f"fish-{k}" for k in range(count)),
        "kinds": ("fish",) * count,
        "state": np.where(_whole(line_px), "in", "partial"),
        "side": np.array([""] * count),
        "position_px": middle,
        "instance_id": 10 + np.arange(count),
        "visible_fraction": np.ones(count) if visible is None else np.array(visible, float),
        "instance_map": drawn,
        "depth_m": np.ones((HEIGHT_PX, WIDTH_PX), np.float32),
        "centre_line_px": line_px,
        "heading_rad": np.array(headings_rad, float),
        "hidden_by": np.full(count, -1),
        "exposure_s": 0.01,
        "gain": 1.0,
    }
    shapes = {"T_world_object": (count, 4, 4), "size_m": (count, 3), "box_xyxy": (count, 4)}
    shapes |= {"centre_line_m": (count, _POINTS, 3)}
    for field in fields(FishTruth):
        if field.name not in given:
            given[field.name] = np.zeros(shapes.get(field.name, (count,)))
    return FishTruth(**given)


def _whole(line_px: NDArray[np.float64]) -> NDArray[np.bool_]:
    """Return (N,) whether bodies lie inside the picture."""
    inside = (line_px > 1) & (line_px < np.array([WIDTH_PX - 1, HEIGHT_PX - 1]))
    return np.asarray(inside.all(axis=(1, 2)))


def picture_of(truth: FishTruth) -> NDArray[np.uint8]:
    """Return a picture (H, W, 3) of dark fish on a bright floor."""
    grey = np.where(truth.instance_map >= 0, 60, 200).astype(np.uint8)
    return np.repeat(grey[..., None], 3, axis=2)


CAMERA = CameraModel(WIDTH_PX, HEIGHT_PX, 100.0)


def observation_of(truth: FishTruth) -> Observation:
    """Return the picture as an observation."""
    return Observation(picture_of(truth), truth.time_s, CAMERA)


def empty_pictures(count: int) -> tuple[Observation, ...]:
    """Return pictures without fish, with a little noise."""
    rng = np.random.default_rng(0)
    pictures = (np.clip(rng.normal(200, 2, (HEIGHT_PX, WIDTH_PX, 3)), 0, 255).astype(np.uint8) for _ in range(count))
    return tuple(Observation(picture, -1.0 + k / 30.0, CAMERA) for k, picture in enumerate(pictures))


def frame_of(truth: FishTruth) -> Frame:
    """Return the truth with its picture."""
    camera = CameraModel(WIDTH_PX, HEIGHT_PX, CAMERA.focal_px)
    return Frame(observation_of(truth), truth, camera)


def track(identity: int, place: Sequence[float] | NDArray[np.float64], confidence: float | None = None) -> Track:
    """Return a track at a place (x, y)."""
    return Track(identity, Estimate(np.array(place, float)), confidence=confidence)
