"""A pan-tilt-zoom head that carries a steered camera; its place, limits and lens are the scene's."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from trackers.types import CameraCommand, CameraModel, Carrier


@dataclass(frozen=True, slots=True)
class Mount:
    """A head as it is installed.

    Attributes:
        carrier: with its command axes ``pan_rad_s``, ``tilt_rad_s`` and ``zoom_per_s``, in this order.
        lens: the camera at zoom 1.
        place_m: (3,) in the world. aim_m: (3,) where it looks at first.
        ahead, left: (2,) unit vectors over the ground: where the camera looks at pan 0, and to the left of it.
        widest_pan_rad: to either side. tilt_rad: lowest and highest, negative below the horizon. zoom: least and most.
    """

    carrier: Carrier
    lens: CameraModel
    place_m: tuple[float, float, float]
    aim_m: tuple[float, float, float]
    ahead: tuple[float, float]
    left: tuple[float, float]
    widest_pan_rad: float
    tilt_rad: tuple[float, float]
    zoom: tuple[float, float]


class Head:
    """Turns and zooms as commanded, within its limits of angle, rate and change of rate.

    Attributes:
        pan_rad: counter-clockwise from straight ahead. tilt_rad: negative below the horizon. zoom: times the focal
            length.
        mount: as it is installed. axes: (3, 3) unit vectors ahead at pan and tilt 0, left and up.
    """

    def __init__(self, mount: Mount, rate_hz: float) -> None:
        self.mount, self._interval_s = mount, 1.0 / rate_hz
        self.axes = np.array([(*mount.ahead, 0.0), (*mount.left, 0.0), (0.0, 0.0, 1.0)])
        self._rates = np.zeros(len(mount.carrier.axes))
        away_m = np.subtract(mount.aim_m, mount.place_m)
        self.pan_rad = float(np.arctan2(away_m[:2] @ mount.left, away_m[:2] @ mount.ahead))
        self.tilt_rad = float(np.arctan2(away_m[2], np.hypot(*away_m[:2])))
        self.zoom = 1.0

    def obey(self, command: CameraCommand) -> None:
        """Obey ``pan_rad_s``, ``tilt_rad_s`` and ``zoom_per_s`` of a command for one frame."""
        mount = self.mount
        for k, axis in enumerate(mount.carrier.axes):
            wanted = np.clip(getattr(command, axis.name), -axis.limit, axis.limit)
            step = axis.slew_per_s * self._interval_s
            self._rates[k] += np.clip(wanted - self._rates[k], -step, step)
        pan, tilt, zoom = self._rates * self._interval_s
        self.pan_rad = float(np.clip(self.pan_rad + pan, -mount.widest_pan_rad, mount.widest_pan_rad))
        self.tilt_rad = float(np.clip(self.tilt_rad + tilt, *mount.tilt_rad))
        self.zoom = float(np.clip(self.zoom * np.exp(zoom), *mount.zoom))

    @property
    def camera(self) -> CameraModel:
        """The camera at the present zoom."""
        lens = self.mount.lens
        return replace(lens, focal_px=lens.focal_px * self.zoom)

    @property
    def T_world_camera(self) -> NDArray[np.float64]:
        """Pose (4, 4)."""
        c, s, ct, st = np.cos(self.pan_rad), np.sin(self.pan_rad), np.cos(self.tilt_rad), np.sin(self.tilt_rad)
        ahead_xy, left_xy = np.array(self.mount.ahead), np.array(self.mount.left)
        ahead = np.append((c * ahead_xy + s * left_xy) * ct, st)
        right = np.append(s * ahead_xy - c * left_xy, 0.0)
        T = np.eye(4)
        T[:3, :3] = np.stack([right, np.cross(ahead, right), ahead], axis=1)
        T[:3, 3] = self.mount.place_m
        return T
