"""The pan-tilt-zoom head beside the overview camera, which carries the steered thermal camera."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from scenarios.harbour.layout import AIM_M, CAMERA_M
from sim.optics import PinholeCamera
from trackers.types import CameraCommand, Carrier, CommandAxis

HEAD = Carrier(
    "harbour-head",
    (CommandAxis("pan_rad_s", 1.0, 4.0), CommandAxis("tilt_rad_s", 0.6, 3.0), CommandAxis("zoom_per_s", 0.7, 3.0)),
    "around",
)
"""Limits are those of a surveillance head with a motor zoom."""
LENS = PinholeCamera.from_field_of_view(384, 288, float(np.deg2rad(5.0)))
"""Of its camera at zoom 1: at 100 m it sees 9 m, and a person 75 pixels tall."""
PLACE_M = (CAMERA_M[0], CAMERA_M[1] - 0.8, CAMERA_M[2] - 0.5)
_LOWEST_RAD, _HIGHEST_RAD, _WIDEST_PAN_RAD, _ZOOM = -0.9, 0.1, 0.9, (0.5, 3.0)


class Head:
    """Turns and zooms as commanded, within its limits of angle, rate and change of rate. It begins at the middle.

    Attributes:
        pan_rad: counter-clockwise from world +x. tilt_rad: negative below the horizon. zoom: times the focal length.
    """

    def __init__(self, rate_hz: float) -> None:
        self._interval_s = 1.0 / rate_hz
        self._rates = np.zeros(len(HEAD.axes))
        x, y, z = np.subtract(AIM_M, PLACE_M)
        self.pan_rad, self.tilt_rad, self.zoom = float(np.arctan2(y, x)), float(np.arctan2(z, np.hypot(x, y))), 1.0

    def obey(self, command: CameraCommand) -> None:
        """Obey ``pan_rad_s``, ``tilt_rad_s`` and ``zoom_per_s`` of a command for one frame."""
        for k, axis in enumerate(HEAD.axes):
            wanted = np.clip(getattr(command, axis.name), -axis.limit, axis.limit)
            step = axis.slew_per_s * self._interval_s
            self._rates[k] += np.clip(wanted - self._rates[k], -step, step)
        pan, tilt, zoom = self._rates * self._interval_s
        self.pan_rad = float(np.clip(self.pan_rad + pan, -_WIDEST_PAN_RAD, _WIDEST_PAN_RAD))
        self.tilt_rad = float(np.clip(self.tilt_rad + tilt, _LOWEST_RAD, _HIGHEST_RAD))
        self.zoom = float(np.clip(self.zoom * np.exp(zoom), *_ZOOM))

    @property
    def camera(self) -> PinholeCamera:
        """The camera at the present zoom."""
        return replace(LENS, focal_px=LENS.focal_px * self.zoom)

    @property
    def T_world_camera(self) -> NDArray[np.float64]:
        """Pose (4, 4)."""
        c, s, ct, st = np.cos(self.pan_rad), np.sin(self.pan_rad), np.cos(self.tilt_rad), np.sin(self.tilt_rad)
        ahead, right = np.array([c * ct, s * ct, st]), np.array([s, -c, 0.0])
        T = np.eye(4)
        T[:3, :3] = np.stack([right, np.cross(ahead, right), ahead], axis=1)
        T[:3, 3] = PLACE_M
        return T
