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
        ahead, left: (3,) unit vectors, normal to each other: where the camera looks at pan and tilt 0, and to the left
            of it. The head pans about their cross product: upright, or as it hangs from a ceiling.
        widest_pan_rad: to either side. tilt_rad: lowest and highest. zoom: least and most.
        watches: whether trackers get the pictures of this camera; False: those of another one.
        step_rad: of the encoders that measure pan and tilt: angles are known to half a step; 0: exactly.
    """

    carrier: Carrier
    lens: CameraModel
    place_m: tuple[float, float, float]
    aim_m: tuple[float, float, float]
    ahead: tuple[float, float, float]
    left: tuple[float, float, float]
    widest_pan_rad: float
    tilt_rad: tuple[float, float]
    zoom: tuple[float, float]
    watches: bool = False
    step_rad: float = 0.0

    def zoom_for(self, width_m: float) -> float:
        """Return the zoom at which a picture shows so much of what is at ``aim_m``."""
        distance_m = float(np.linalg.norm(np.subtract(self.aim_m, self.place_m)))
        return distance_m * self.lens.width_px / (width_m * self.lens.focal_px)


class Head:
    """Turns and zooms as commanded, within its limits of angle, rate and change of rate.

    Attributes:
        pan_rad: counter-clockwise from straight ahead. tilt_rad: upwards. zoom: times the focal length.
        mount: as it is installed. axes: (3, 3) unit vectors ahead at pan and tilt 0, left and up.
    """

    def __init__(self, mount: Mount, rate_hz: float, zoom: float = 1.0) -> None:
        """Look at the mount's ``aim_m`` with a zoom."""
        self.mount, self._interval_s = mount, 1.0 / rate_hz
        self.axes = np.array([mount.ahead, mount.left, np.cross(mount.ahead, mount.left)])
        self._rates = np.zeros(len(mount.carrier.axes))
        ahead_m, left_m, up_m = self.axes @ np.subtract(mount.aim_m, mount.place_m)
        self.pan_rad = float(np.arctan2(left_m, ahead_m))
        self.tilt_rad = float(np.arctan2(up_m, np.hypot(ahead_m, left_m)))
        self.zoom = float(np.clip(zoom, *mount.zoom))

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
        return self._pose(self.pan_rad, self.tilt_rad)

    @property
    def T_world_measured(self) -> NDArray[np.float64]:
        """Pose (4, 4) by the encoders' angles."""
        step_rad = self.mount.step_rad
        if step_rad == 0.0:
            return self.T_world_camera
        return self._pose(*(step_rad * np.round(np.array([self.pan_rad, self.tilt_rad]) / step_rad)))

    def _pose(self, pan_rad: float, tilt_rad: float) -> NDArray[np.float64]:
        c, s, ct, st = np.cos(pan_rad), np.sin(pan_rad), np.cos(tilt_rad), np.sin(tilt_rad)
        ahead_0, left_0, up = self.axes
        ahead = (c * ahead_0 + s * left_0) * ct + st * up
        # 0 has no sign here.
        right = s * ahead_0 - c * left_0 + 0.0
        T = np.eye(4)
        T[:3, :3] = np.stack([right, np.cross(ahead, right), ahead], axis=1)
        T[:3, 3] = self.mount.place_m
        return T
