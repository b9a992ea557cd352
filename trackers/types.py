"""Inputs and outputs of trackers and controllers, independent of the source of the pictures.

Pixels: pixel (row i, column j) covers ``[j, j+1) x [i, i+1)``; coordinates are (x right, y down) from the top left
corner of the picture and are not limited to it. Boxes are ``(x_min, y_min, x_max, y_max)``.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

Band = Literal["colour", "thermal"]
"""Spectral band of a camera: visible light in three channels, or thermal radiation (8 to 14 µm) in one."""


@dataclass(frozen=True, slots=True)
class CameraModel:
    """Pinhole camera with square pixels and the principal point in the middle of the picture.

    Attributes:
        width_px, height_px: size of the picture.
        focal_px: focal length in pixels.
        baseline_m: distance of a rectified stereo pair's second camera to the right of this one; None for a single
            camera.
        band: its spectral band.
    """

    width_px: int
    height_px: int
    focal_px: float
    baseline_m: float | None = None
    band: Band = "colour"

    @classmethod
    def from_field_of_view(cls, width_px: int, height_px: int, horizontal_rad: float, **others: Any) -> CameraModel:
        """Return the camera whose picture is ``horizontal_rad`` wide; ``others`` are the other attributes."""
        return cls(width_px, height_px, 0.5 * width_px / float(np.tan(0.5 * horizontal_rad)), **others)

    @property
    def centre_px(self) -> NDArray[np.float64]:
        """Principal point (2,), pixels."""
        return np.array([0.5 * self.width_px, 0.5 * self.height_px])


@dataclass(frozen=True, slots=True)
class CameraRegisters:
    """Automatic settings as the numbers of a stereo camera (paper B, Table 1).

    Attributes:
        red, blue: white balance, 0 to 1023.
        shutter: 0 to 707.
        gain: 0 to 683.
    """

    red: int
    blue: int
    shutter: int
    gain: int


@dataclass(frozen=True, slots=True)
class CameraSettings:
    """Automatic settings as the camera reports them.

    Attributes:
        exposure_s: exposure time in seconds.
        gain: analogue gain, 1 = none.
        registers: the same and the white balance as register values; None if the camera has none.
    """

    exposure_s: float
    gain: float
    registers: CameraRegisters | None = None


@dataclass(frozen=True, slots=True)
class EgoPose:
    """Pose of the camera as *measured* on board, with the errors of its instruments.

    Attributes:
        T_world_camera: (4, 4), camera frame (x right, y down, z forward) to the carrier's navigation frame (metres,
            z up, ground at about z = 0).
    """

    T_world_camera: NDArray[np.float64]

    def __post_init__(self) -> None:
        object.__setattr__(self, "T_world_camera", _read_only(self.T_world_camera))


@dataclass(frozen=True, slots=True)
class SteeredCamera:
    """The steered carrier's camera, where the tracker receives the pictures of another camera.

    Attributes:
        camera: its geometry.
        ego: its measured pose, in the navigation frame of the watched camera; None without instruments.
    """

    camera: CameraModel
    ego: EgoPose | None = None


@dataclass(frozen=True, slots=True)
class Observation:
    """All inputs of a tracker at one time. The arrays are read-only, since they are shared.

    Attributes:
        image_rgb: (H, W, 3) uint8; the left picture of a stereo pair. A thermal picture after automatic gain control
            is the same in all three channels.
        time_s: seconds since the first picture.
        camera: geometry of the camera.
        settings: automatic settings in use; None if the camera does not report them.
        ego: measured pose of the camera; None without instruments.
        right_rgb: (H, W, 3) uint8, the right picture of a stereo pair; None from a single camera, or if the picture was
            lost in transmission.
        counts: (H, W) uint16, the raw counts of a thermal camera (14 bit); None if there are none.
        steered: the camera that a controller steers, if another one took the picture.
    """

    image_rgb: NDArray[np.uint8]
    time_s: float
    camera: CameraModel
    settings: CameraSettings | None = None
    ego: EgoPose | None = None
    right_rgb: NDArray[np.uint8] | None = None
    counts: NDArray[np.uint16] | None = None
    steered: SteeredCamera | None = None

    def __post_init__(self) -> None:
        for name in ("image_rgb", "right_rgb", "counts"):
            picture = getattr(self, name)
            if picture is not None:
                object.__setattr__(self, name, _read_only(picture))


@dataclass(frozen=True, slots=True)
class SiteSurvey:
    """What an engineer measures of a quay once, when the camera is installed over it, and what its operator watches.

    Metres in the navigation frame of ``EgoPose``, whose heights count from the quay's surface. The watched volume is an
    upright box: its middle lies where the camera's axis meets the quay, its depth along the horizontal line of sight.

    Attributes:
        edge_m: (2,) a point of the quay's main edge. seaward: (2,) horizontal unit vector from there to the water.
        mean_water_m: mean sea level, < 0. How high the tide is at a time is not surveyed.
        watched_m: (3,) depth, width and height of the watched volume, > 0. watched_bottom_m: height of its lower side.
        outline_m: (K, 2) the whole edge where it is not straight, K >= 2 corners, with the water on the left of the way
            from the first to the last; behind these it goes on through ``edge_m``. () for a straight edge.
    """

    edge_m: tuple[float, float]
    seaward: tuple[float, float]
    mean_water_m: float
    watched_m: tuple[float, float, float]
    watched_bottom_m: float
    outline_m: tuple[tuple[float, float], ...] = ()

    def __post_init__(self) -> None:
        """Raise ValueError for water that is not below the quay, a direction that is not one long, or no volume."""
        if not -np.inf < self.mean_water_m < 0.0:
            raise ValueError(f"mean_water_m: expected a finite number of metres < 0, got {self.mean_water_m}")
        if not abs(float(np.hypot(*self.seaward)) - 1.0) < 1e-6:
            raise ValueError(f"seaward: expected a vector of length 1, got {self.seaward}")
        if not np.isfinite(self.edge_m).all():
            raise ValueError(f"edge_m: expected finite numbers of metres, got {self.edge_m}")
        if len(self.watched_m) != 3 or not all(0.0 < each < np.inf for each in self.watched_m):
            raise ValueError(f"watched_m: expected three numbers of metres > 0, got {self.watched_m}")
        if not np.isfinite(self.watched_bottom_m):
            raise ValueError(f"watched_bottom_m: expected a finite number of metres, got {self.watched_bottom_m}")
        pairs = all(len(each) == 2 and np.isfinite(each).all() for each in self.outline_m)
        if len(self.outline_m) == 1 or not pairs:
            raise ValueError(f"outline_m: expected none or at least two corners in metres, got {self.outline_m}")


@dataclass(frozen=True, slots=True)
class Start:
    """A tracker's inputs before the first picture.

    Attributes:
        camera: calibration of the camera.
        box_xyxy: (4,) box of the one target in the first picture; None for a tracker of many targets.
        background: pictures without targets, in order of time, to learn the background from; possibly none.
        site: survey of the site that a camera at rest watches; None where there is none.
    """

    camera: CameraModel
    box_xyxy: NDArray[np.float64] | None = None
    background: tuple[Observation, ...] = ()
    site: SiteSurvey | None = None


@dataclass(frozen=True, slots=True)
class Estimate:
    """A tracker's estimate of its target, in pixels of the current picture, inside it or not.

    The posterior of the position is ``particles_px`` with ``weights``, or a Gaussian ``covariance_px`` about
    ``position_px``, or absent.

    Attributes:
        position_px: (2,) centre of the target; NaN if there is no estimate.
        box_xyxy: (4,) or None; of an estimate that has a mask alone, the mask's box is taken.
        depth_m: distance of the target along the camera's axis, > 0; None if it is not measured.
        heading_rad: direction of travel in the picture, from +x towards +y (clockwise as seen), or None.
        in_view_probability: probability in [0, 1] that the target's centre is inside the picture and not
            hidden, or None.
        particles_px: (N, 2) or None.
        weights: (N,) non-negative, sum 1; with particles None means equal weights.
        covariance_px: (2, 2) or None.
        centre_line_px: (K, 2) middle line of a slender body, from head to tail, or None.
        mask: (H, W) bool, the target's pixels that the picture shows, none of them while it is outside; or None.
    """

    position_px: NDArray[np.float64]
    box_xyxy: NDArray[np.float64] | None = None
    heading_rad: float | None = None
    in_view_probability: float | None = None
    particles_px: NDArray[np.float64] | None = None
    weights: NDArray[np.float64] | None = None
    covariance_px: NDArray[np.float64] | None = None
    depth_m: float | None = None
    centre_line_px: NDArray[np.float64] | None = None
    mask: NDArray[np.bool_] | None = None


@dataclass(frozen=True, slots=True)
class Track:
    """One target of a tracker that follows many.

    Attributes:
        identity: number of the target, >= 0; never given to another target.
        estimate: its position.
        kind: its class, e.g. ``person``; None if the tracker does not classify.
        size_m: (3,) length, width and height; None if they are not measured.
        confidence: probability in [0, 1] that the target exists and is the one of this identity, or None.
    """

    identity: int
    estimate: Estimate
    kind: str | None = None
    size_m: NDArray[np.float64] | None = None
    confidence: float | None = None


Answer = Estimate | Sequence[Track]
"""The answer on one picture of a tracker of one target, or of many."""


@dataclass(frozen=True, slots=True)
class CameraCommand:
    """A controller's command to the camera's carrier, in the carrier's frame (heading = top of the picture).

    Attributes:
        forward_mps, right_mps, climb_mps: velocity.
        yaw_rate_rad_s: turn rate, positive counter-clockwise seen from above.
        pan_rad_s, tilt_rad_s: turn rates of a pan-tilt head, positive to the left and up.
        zoom_per_s: rate of the logarithm of the focal length, positive towards a narrower view.
    """

    forward_mps: float = 0.0
    right_mps: float = 0.0
    climb_mps: float = 0.0
    yaw_rate_rad_s: float = 0.0
    pan_rad_s: float = 0.0
    tilt_rad_s: float = 0.0
    zoom_per_s: float = 0.0


Looks = Literal["down", "ahead", "around"]
CommandName = Literal[
    "forward_mps", "right_mps", "climb_mps", "yaw_rate_rad_s", "pan_rad_s", "tilt_rad_s", "zoom_per_s"
]


BODY_COMMANDS: tuple[CommandName, ...] = ("forward_mps", "right_mps", "climb_mps", "yaw_rate_rad_s")
"""Command axes of a carrier that moves as a whole; the others belong to a pan-tilt-zoom head."""
HEAD_COMMANDS: tuple[CommandName, ...] = ("zoom_per_s", "right_mps", "tilt_rad_s", "pan_rad_s")
"""Command axes of a head in the order of the body's that they stand for: ahead, right, up, and the turn to the left."""


@dataclass(frozen=True, slots=True)
class CommandAxis:
    """One axis of a ``CameraCommand`` that a carrier obeys.

    Attributes:
        name: field of ``CameraCommand``.
        limit: largest magnitude, in the field's unit.
        slew_per_s: largest change per second.
    """

    name: CommandName
    limit: float
    slew_per_s: float


@dataclass(frozen=True, slots=True)
class Carrier:
    """The carrier of a camera, as far as steering needs it.

    Attributes:
        name: e.g. ``helicopter``; a controller is written for one carrier.
        axes: the command axes that it obeys; the others have no effect. () for a camera at rest.
        looks: direction of the camera: ``down`` onto the ground; ``ahead`` along it, where only the tracker measures a
            target's distance; or ``around``, in any direction obliquely onto the ground.
    """

    name: str
    axes: tuple[CommandAxis, ...]
    looks: Looks

    @property
    def commands(self) -> tuple[CommandName, ...]:
        """Names (4,) of the numbers of its commands in kernels: ``BODY_COMMANDS`` or ``HEAD_COMMANDS``."""
        return BODY_COMMANDS if all(axis.name in BODY_COMMANDS for axis in self.axes) else HEAD_COMMANDS


def _read_only(array: NDArray[Any]) -> NDArray[Any]:
    """Return a read-only view of an array, without a copy."""
    view = array.view()
    view.flags.writeable = False
    return view
