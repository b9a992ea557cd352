"""Tracklets made by hand."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from trackers.fish_chain.detection import Detection
from trackers.fish_chain.posture import STATIONS
from trackers.fish_chain.tracklets import Tracklet

LENGTH_PX, WIDTH_PX = 30.0, 6.0


def seen(
    place_px: Sequence[float] | NDArray[np.float64], heading_rad: float, *, shade: float = 0.4, merged: bool = False
) -> Detection:
    """Return the detection of a straight fish; its mask is a bar along x or y, whichever it is nearer to."""
    place = np.asarray(place_px, dtype=float)
    ahead = np.array([np.cos(heading_rad), np.sin(heading_rad)])
    line = place + np.linspace(0.5, -0.5, STATIONS)[:, None] * LENGTH_PX * ahead
    half = 0.5 * np.abs(ahead) * LENGTH_PX + 0.5 * WIDTH_PX
    corner = np.floor(place - half).astype(int)
    size = np.ceil(2 * half).astype(int)
    return Detection(
        position_px=place,
        box_xyxy=np.concatenate([corner, corner + size]).astype(float),
        heading_rad=heading_rad,
        centre_line_px=line,
        area_px=LENGTH_PX * WIDTH_PX * (2 if merged else 1),
        score=1.0,
        merged=merged,
        covered=False,
        widths_px=WIDTH_PX * np.linspace(1.2, 0.5, STATIONS),
        shades=np.full(STATIONS, shade),
        colour=np.zeros(2),
        mask=np.ones(size[::-1], np.uint8),
        corner_px=corner,
    )


def swum(
    first_frame: int,
    *,
    frames: int,
    velocity_px: tuple[float, float],
    first_px: tuple[float, float] = (100.0, 100.0),
    turns_rad: NDArray[np.float64] | None = None,
    number: int = 0,
) -> Tracklet:
    """Return the tracklet of a fish that swims at a constant speed, turning by ``turns_rad`` (frames,)."""
    heading, place = float(np.arctan2(*velocity_px[::-1])), np.array(first_px)
    tracklet = Tracklet(number, first_frame, seen(place, heading))
    for k in range(1, frames):
        heading += 0.0 if turns_rad is None else float(turns_rad[k])
        place = place + np.hypot(*velocity_px) * np.array([np.cos(heading), np.sin(heading)])
        tracklet.append(seen(place, heading))
    return tracklet
