"""Where everything of a harbour lies: quay, sheds, parking, berths, camera; metres.

The world frame has z up from the quay's surface, and its origin where the overview camera's axis meets that surface.
The quay's main edge runs along y, which grows to the left as seen from the sea; from there x grows over the apron,
parked cars, a lane and sheds to the town.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from trackers.types import CameraModel, SiteSurvey

MEAN_SEA_M = -1.8
VOLUME_BOTTOM_M = -2.5
COPING_M = 0.6
"""Width of the stones along the edge of the quay."""
PARKING_Y_M = tuple(float(y) for y in np.arange(-24.0, 25.0, 3.0))
"""Middles of the bays, whose cars stand along x."""
OPEN_BAYS_Y_M = (0.0, 12.0)
"""Bays that stay empty: through them cars drive onto the apron."""
GAP_Y_M = 0.0
"""Middle of the road between the sheds, through which people and cars come from behind."""
_BEHIND_M = 8.0
"""How far behind the front of what closes an end of the quay a way begins."""
_SEEN_INSIDE_PX = 6.0

Place = tuple[float, float]


class Shed(NamedTuple):
    """A shed: middle of its front along y, length, depth, height of eaves, rise of the ridge, doors along y."""

    y_m: float
    length_m: float
    depth_m: float
    eaves_m: float
    rise_m: float
    doors_y_m: tuple[float, ...]


class Berth(NamedTuple):
    """Where a boat lies along a wall.

    Attributes:
        y_m: of its middle. heading_rad: of the boat.
        is_free: no boat lies there; visitors may.
        off: (2,) unit vector from the wall to the water.
        wall_x_m: x of the place on the wall; None: on the main edge.
    """

    y_m: float
    heading_rad: float
    is_free: bool
    off: Place = (-1.0, 0.0)
    wall_x_m: float | None = None


class Wing(NamedTuple):
    """A part of the quay that reaches out into the water from its main edge: a rectangle along x and y."""

    tip_x_m: float
    low_y_m: float
    high_y_m: float


class Goods(NamedTuple):
    """What stands or lies on the quay, within a radius, that people walk around: pallets, drums, nets."""

    x_m: float
    y_m: float
    radius_m: float


_SHEDS = (
    Shed(-22.0, 28.0, 13.0, 4.6, 2.2, (-30.0, -19.0, -12.0)),
    Shed(21.5, 29.0, 12.0, 4.2, 2.6, (12.0, 22.0, 31.0)),
)
_BERTHS = (
    Berth(-15.5, 0.5 * np.pi, False),
    Berth(-3.0, 0.5 * np.pi, True),
    Berth(8.5, -0.5 * np.pi, False),
    Berth(20.0, 0.5 * np.pi, False),
)
_CAMERA = CameraModel(384, 288, 770.0, band="thermal")


@dataclass(frozen=True)
class Site:
    """A harbour. The defaults are those of the one site of the standing presets.

    Attributes:
        camera: the overview camera, which stands at ``camera_m`` and looks at the origin.
        volume_m: sides of the watched volume: along the line of sight, across it, and upright.
        wall_x_m: of the main edge. apron_end_m: where the yard begins, on which cars park.
        shed_x_m: front of the sheds.
        sheds, berths, buoys_m, lamp_posts_m, wings, goods: see there; boats swing about the buoys.
        bollards_y_m: along the main edge.
        fairway_x_m: boats that pass keep between these.
        walks_y_m: people go about up to so far to either side of the middle.
        span_m: the quay reaches so far to either side.
        shut_y_m: side, 1 or -1 -> where a building closes the quay, and a mole the water, at an end that the picture
            shows. All others are open.
        is_drawn: with a far shore all round.
    """

    camera: CameraModel = _CAMERA
    camera_m: tuple[float, float, float] = (-100.0, 0.0, 20.0)
    volume_m: tuple[float, float, float] = (90.0, 33.0, 6.0)
    wall_x_m: float = -15.0
    apron_end_m: float = 12.0
    shed_x_m: float = 46.0
    sheds: tuple[Shed, ...] = _SHEDS
    berths: tuple[Berth, ...] = _BERTHS
    buoys_m: tuple[Place, ...] = ((-37.5, 6.0), (-41.0, -8.0))
    lamp_posts_m: tuple[Place, ...] = ((11.0, -17.0), (11.0, 14.0), (38.0, 3.5))
    wings: tuple[Wing, ...] = ()
    goods: tuple[Goods, ...] = ()
    bollards_y_m: tuple[float, ...] = tuple(float(y) for y in np.arange(-38.0, 39.0, 6.0))
    fairway_x_m: tuple[float, float] = (-26.0, -22.5)
    walks_y_m: float = 14.5
    span_m: float = 90.0
    shut_y_m: dict[int, float] = field(default_factory=dict)
    is_drawn: bool = False

    @property
    def parking_x_m(self) -> float:
        """Middle of the row of bays."""
        return self.apron_end_m + 4.5

    @property
    def lane_x_m(self) -> float:
        """Middle of the lane behind them."""
        return self.apron_end_m + 15.0

    @property
    def bollard_x_m(self) -> float:
        """Of the bollards along the main edge."""
        return self.wall_x_m + 1.0

    @property
    def bearing_rad(self) -> float:
        """Direction in which the camera looks, from +x towards +y."""
        return float(np.arctan2(0.0 - self.camera_m[1], 0.0 - self.camera_m[0]))

    @cached_property
    def edge_m(self) -> tuple[Place, ...]:
        """The quay's whole edge, the water on the left."""
        x, span = self.wall_x_m, self.span_m
        corners: list[Place] = [(x, -span)]
        for wing in sorted(self.wings, key=lambda each: each.low_y_m):
            corners += [
                (x, wing.low_y_m),
                (wing.tip_x_m, wing.low_y_m),
                (wing.tip_x_m, wing.high_y_m),
                (x, wing.high_y_m),
            ]
        return (*corners, (x, span))

    @property
    def bollards_m(self) -> tuple[Place, ...]:
        """Places of all bollards: along the main edge, where no wing is, and along the sides of wings."""
        wings = self.wings
        posts = [
            (self.bollard_x_m, y) for y in self.bollards_y_m if not any(w.low_y_m <= y <= w.high_y_m for w in wings)
        ]
        for wing in wings:
            steps = np.arange(wing.tip_x_m + 1.0, self.wall_x_m - 1.0, 6.0).tolist()
            posts += [(x, y) for x in steps for y in (wing.low_y_m + 1.0, wing.high_y_m - 1.0)]
        return tuple(posts)

    @property
    def survey(self) -> SiteSurvey:
        """Survey of the site, an input of trackers."""
        outline = self.edge_m if self.wings else ()
        return SiteSurvey((self.wall_x_m, 0.0), (-1.0, 0.0), MEAN_SEA_M, self.volume_m, VOLUME_BOTTOM_M, outline)

    @property
    def gate_sheds(self) -> tuple[Shed, ...]:
        """Those with a door near the middle."""
        return tuple(each for each in self.sheds if any(abs(y) < 20.0 for y in each.doors_y_m))

    def border_y_m(self, x_m: float, side: float = 1.0, beyond_m: float = 6.0) -> float:
        """Return how far to a side (1 or -1) something at x is ``beyond_m`` outside the picture's border.

        Where a building closes the end, this is inside it.
        """
        if int(side) in self.shut_y_m:
            return self.shut_y_m[int(side)] + _BEHIND_M
        half, (cx, cy, _) = 0.5 * self.camera.width_px / self.camera.focal_px, self.camera_m
        if self.bearing_rad == 0.0:
            return (x_m - cx) * 0.5 * self.camera.width_px / self.camera.focal_px + beyond_m
        # |v| = u half + beyond, u ahead of the camera and v to its left.
        c, s = np.cos(self.bearing_rad), np.sin(self.bearing_rad)
        away = ((x_m - cx) * (half * c + side * s) + beyond_m) / (side * c - half * s) + cy
        # Looking along the quay, it shows nothing behind its mast.
        along, behind_m = abs(s) > 0.9 and side * s < 0.0, -side * cy - 12.0
        farthest = abs(behind_m) if along else self.span_m - 5.0
        return float(np.clip(side * away if side * away > 0.0 else np.inf, 25.0, farthest))

    def sees(self, place: Place) -> bool:
        """Return whether the picture shows a place on the ground."""
        T, f = self._pose, self.camera.focal_px
        x, y, z = (np.array([*place, 0.0]) - self.camera_m) @ T[:3, :3]
        inside = abs(f * x / z) < 0.5 * self.camera.width_px - _SEEN_INSIDE_PX
        return bool(z > 1.0 and inside and abs(f * y / z) < 0.5 * self.camera.height_px - _SEEN_INSIDE_PX)

    def at_sea(self, x_m: float, side: float) -> list[Place]:
        """Return the last points of a way along the fairway to a side, where the picture does not show it."""
        # Rounding cuts a quarter of each side off: a near point keeps a way clear of the wings.
        first = [(x_m, side * 21.0)] if self.is_drawn else []
        if int(side) not in self.shut_y_m:
            return [*first, (x_m, side * self.border_y_m(x_m, side, beyond_m=9.0))]
        mole_m = self.mole_y_m
        behind = ((x_m, mole_m - 25.0), (x_m - 22.0, mole_m - 4.0), (x_m - 60.0, mole_m + 9.0))
        return [*first, *((x, side * y) for x, y in behind)]

    @property
    def mole_y_m(self) -> float:
        """How far away the mole is that closes the water at an end."""
        return max(self.shut_y_m.values(), default=0.0) + 70.0

    def overview_pose(self) -> NDArray[np.float64]:
        """Return T_world_camera (4, 4) of the overview camera."""
        return self._pose.copy()

    @cached_property
    def _pose(self) -> NDArray[np.float64]:
        towards = np.subtract((0.0, 0.0, 0.0), self.camera_m)
        ahead = towards / np.linalg.norm(towards)
        right = np.cross(ahead, (0.0, 0.0, 1.0))
        right /= np.linalg.norm(right)
        T = np.eye(4)
        T[:3, :3] = np.stack([right, np.cross(ahead, right), ahead], axis=1)
        T[:3, 3] = self.camera_m
        return T

    @property
    def volume_axes(self) -> NDArray[np.float64]:
        """Return the unit vectors (2, 2) along the level line of sight, and to its left."""
        if self.bearing_rad == 0.0:
            return np.eye(2)
        c, s = np.cos(self.bearing_rad), np.sin(self.bearing_rad)
        return np.array([[c, s], [-s, c]])

    def is_watched(self, points_m: NDArray[np.float64]) -> NDArray[np.bool_]:
        """Return whether points (..., 3) lie in the watched volume."""
        half, points = 0.5 * np.array(self.volume_m), np.array(points_m, dtype=float)
        points[..., :2] = points[..., :2] @ self.volume_axes.T
        return np.asarray((np.abs(points - (0.0, 0.0, VOLUME_BOTTOM_M + half[2])) <= half).all(axis=-1))

    def is_clear(self, place: Place) -> bool:
        """Return whether one can stand at a place, and turn there, without touching goods."""
        return all(np.hypot(place[0] - x, place[1] - y) > radius + 0.95 for x, y, radius in self.goods)

    def is_land(self, points_m: NDArray[np.float64], margin_m: float = 0.0) -> NDArray[np.bool_]:
        """Return whether points (..., 2) lie on the quay, or within a margin of it."""
        x, y = np.moveaxis(np.asarray(points_m, dtype=float), -1, 0)
        land = x > self.wall_x_m - margin_m
        for wing in self.wings:
            land |= (x > wing.tip_x_m - margin_m) & (y > wing.low_y_m - margin_m) & (y < wing.high_y_m + margin_m)
        return np.asarray(land)


FIXED = Site()
"""The one harbour of the standing presets."""
