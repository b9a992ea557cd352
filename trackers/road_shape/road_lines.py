"""Detection and tracing of a road's white lines in a picture (paper A, section 3.1).

All positions are in pixels from the image centre.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numba import njit
from numpy.typing import NDArray

_ALONG = 0.08
"""Half the length along the road over which an edge is averaged, in lengths of the car."""


@dataclass(frozen=True)
class RoadSearch:
    """Settings of the search for lines; lengths are in lengths of the car, the only object of known size.

    Attributes:
        reach: largest distance of a line from the car. nearest: smallest distance; nearer edges are the car's own.
        nearby: largest distance of a line from its expected position at which an edge is its own.
        least_contrast: grey values by which a line is brighter than both its sides.
    """

    reach: float = 1.7
    nearest: float = 0.25
    nearby: float = 0.22
    least_contrast: float = 12.0


@dataclass(frozen=True)
class CrossSection:
    """Cross section of the road: centre (2,) between its edge lines, direction in radians, half width in pixels."""

    centre_px: NDArray[np.float64]
    direction_rad: float
    half_width_px: float
    contrast: float


class LineFinder:
    """Searches one picture for a road's white lines."""

    def __init__(self, grey: NDArray[np.uint8], car_px: float, search: RoadSearch) -> None:
        """Search in ``grey`` (H, W) with a car ``car_px`` long."""
        self._grey = grey
        self._centre_px = 0.5 * np.array([grey.shape[1], grey.shape[0]])
        self.car_px = car_px
        self.search = search
        self._thickness_px = max(2, round(0.07 * car_px))

    def inside(self, point_px: NDArray[np.float64]) -> bool:
        """Return whether a point (2,) lies in the picture."""
        return bool((np.abs(point_px) < self._centre_px).all())

    def room_px(self, centre_px: NDArray[np.float64], direction_rad: float, half_width_px: float) -> float:
        """Return how far a road at its centre (2,) goes on along a direction until both its lines are out of sight.

        An edge is seen up to a small distance from the border. 0 if neither line is seen here.
        """
        along = np.array([np.cos(direction_rad), np.sin(direction_rad)])
        lines_px = centre_px + np.array([[-1.0], [1.0]]) * half_width_px * np.array([-along[1], along[0]])
        reach_px = self._centre_px - self.search.nearby * self.car_px - self._thickness_px - 1.0
        seen = (np.abs(lines_px) < reach_px).all(axis=1)
        # Along an axis of the picture, the borders beside the road are far away.
        along = np.where(np.abs(along) < 1e-9, 1e-9, along)
        room_px = ((np.sign(along) * reach_px - lines_px) / along).min(axis=1)
        return float(room_px[seen].max(initial=0.0))

    def edges(self, centre_px: NDArray[np.float64], direction_rad: float, line_px: float) -> NDArray[np.float64]:
        """Return the offsets (K,) across a direction of the edges near a line at the offset ``line_px``."""
        reach = self.search.nearby * self.car_px
        profile = self.profile(centre_px, direction_rad, _ALONG)
        return line_positions(profile, line_px - reach, line_px + reach, self.search.least_contrast)

    def profile(self, centre_px: NDArray[np.float64], direction_rad: float, along: float) -> NDArray[np.float64]:
        """Return the line profile across a direction, averaged over ``along`` car lengths either way."""
        return line_profile(
            self._grey,
            centre_px + self._centre_px,
            direction_rad,
            round(self.search.reach * self.car_px),
            self._thickness_px,
            round(along * self.car_px),
        )

    def cross_section(self, car_px: NDArray[np.float64], directions_rad: NDArray[np.float64]) -> CrossSection | None:
        """Return the strongest pair of lines, one on each side of a car (2,), over the given directions.

        The search is at the car and one car length before and behind it. None if there is no pair.
        """
        best: CrossSection | None = None
        nearest = self.search.nearest * self.car_px
        for direction in directions_rad:
            ahead = self.car_px * np.array([np.cos(direction), np.sin(direction)])
            right = np.array([-np.sin(direction), np.cos(direction)])
            for shift in (-1.0, 0.0, 1.0):
                place = car_px + shift * ahead
                profile = self.profile(place, direction, 0.8)
                middle = profile.size // 2
                skip = round(nearest)
                to_left = int(np.argmax(profile[: middle - skip][::-1])) + skip + 1
                to_right = int(np.argmax(profile[middle + skip + 1 :])) + skip + 1
                contrast = float(min(profile[middle - to_left], profile[middle + to_right]))
                if contrast > self.search.least_contrast and (best is None or contrast > best.contrast):
                    centre = place + 0.5 * (to_right - to_left) * right
                    best = CrossSection(centre, float(direction), 0.5 * (to_left + to_right), contrast)
        return best


@njit(cache=True)
def line_profile(
    grey: NDArray[np.uint8],
    centre_px: NDArray[np.float64],
    direction_rad: float,
    reach_px: int,
    thickness_px: int,
    along_px: int,
) -> NDArray[np.float64]:
    """Return the contrast of a white line at offsets -reach ... reach across a direction.

    ``E(s) = I(s) - max(I(s - t), I(s + t))`` where positive: brighter than both sides. I(s) is the mean grey value of
    2 along + 1 points in a row along the direction, at offset s to its right (clockwise as seen).

    Args:
        grey: (H, W).
        centre_px: (2,) where s = 0, in pixels from the top left corner.
        thickness_px: t.

    Returns:
        (2 reach + 1,) grey values >= 0; zero where a needed point lies outside the picture.
    """
    rows, columns = grey.shape
    cosine, sine = np.cos(direction_rad), np.sin(direction_rad)
    count = 2 * (reach_px + thickness_px) + 1
    brightness = np.empty(count)
    for k in range(count):
        s = k - reach_px - thickness_px
        total = 0.0
        for a in range(-along_px, along_px + 1):
            x = centre_px[0] - sine * s + cosine * a - 0.5
            y = centre_px[1] + cosine * s + sine * a - 0.5
            j, i = int(np.floor(x)), int(np.floor(y))
            if i < 0 or j < 0 or i + 1 >= rows or j + 1 >= columns:
                total = np.nan
                break
            fx, fy = x - j, y - i
            upper = (1.0 - fx) * grey[i, j] + fx * grey[i, j + 1]
            lower = (1.0 - fx) * grey[i + 1, j] + fx * grey[i + 1, j + 1]
            total += (1.0 - fy) * upper + fy * lower
        brightness[k] = total / (2 * along_px + 1)
    profile = np.zeros(2 * reach_px + 1)
    for k in range(profile.size):
        contrast = brightness[k + thickness_px] - max(brightness[k], brightness[k + 2 * thickness_px])
        if contrast > 0.0:
            profile[k] = contrast
    return profile


@njit(cache=True)
def line_positions(
    profile: NDArray[np.float64], low_px: float, high_px: float, least_contrast: float
) -> NDArray[np.float64]:
    """Return the sub-pixel offsets (K,) within [low, high] of a profile's peaks above a contrast.

    A peak at s is moved to the vertex of the parabola through E(s - 1), E(s), E(s + 1).
    """
    reach = profile.size // 2
    found = np.empty(profile.size)
    count = 0
    first = max(int(np.ceil(low_px)) + reach, 1)
    last = min(int(np.floor(high_px)) + reach, profile.size - 2)
    for k in range(first, last + 1):
        before, here, after = profile[k - 1], profile[k], profile[k + 1]
        if here > least_contrast and here > before and here >= after:
            found[count] = k - reach + 0.5 * (before - after) / (before - 2.0 * here + after)
            count += 1
    return found[:count].copy()
