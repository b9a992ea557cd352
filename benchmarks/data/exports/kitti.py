"""KITTI: stereo, optical flow and depth as 16-bit PNG (Menze and Geiger 2015, https://www.cvlibs.net/datasets/kitti).

Flow of ``kitti-flow`` is BACKWARD: ``flow_px`` holds each pixel's surface point in the previous frame minus its place
in the present one. KITTI's flow goes from the picture ``NNNNNN_10`` to ``NNNNNN_11``; so here ``_10`` is the present
frame and ``_11`` the previous one, and a reader of KITTI gets matching pictures and flow with time reversed.
"""

from __future__ import annotations

from pathlib import Path
from typing import ClassVar

import cv2
import numpy as np
from numpy.typing import NDArray

from benchmarks.data.exports.exporter import Exporter, export_format
from benchmarks.data.exports.labels import StoredFrame
from benchmarks.data.sets.forward_flow import forward_flow
from benchmarks.data.sets.stored_episode import StoredEpisode
from sim.checks import check
from trackers.types import CameraModel

_FRACTIONS, _FLOW_FRACTIONS, _FLOW_ZERO, _LARGEST = 256.0, 64.0, 2**15, 2**16 - 1

_FOLDER, _FLOW = "training", "flow_px"
_PRESENT = ("image_2", "image_rgb", 0, "10")


class Kitti(Exporter):
    """Samples of pictures and maps of 16 bits.

    Attributes:
        pictures: (folder, channel, frames back, suffix) of the pictures of a sample.
    """

    pictures: ClassVar[tuple[tuple[str, str, int, str], ...]] = (_PRESENT,)

    def maps_of(self, stored: StoredFrame) -> dict[str, NDArray[np.uint16]]:
        """Return the maps of a frame by their folders."""
        raise NotImplementedError

    def begin(self) -> None:
        """Begin the list of samples."""
        self._samples = ["number,seed,frame"]

    def write_episode(self, episode: StoredEpisode) -> None:
        """Write the samples of which all pictures exist."""
        for stored in self.frames(episode):
            number = f"{len(self._samples) - 1:06d}"
            found = {
                f"{folder}/{number}_{suffix}": self.picture(episode, stored.index - back, channel)
                for folder, channel, back, suffix in self.pictures
                if 0 <= stored.index - back < len(episode)
            }
            if len(found) < len(self.pictures) or None in found.values():
                continue
            for name, content in found.items():
                self.place(f"{_FOLDER}/{name}{self.ending}").write_bytes(content or b"")
            for folder, values in self.maps_of(stored).items():
                write_png16(values, self.place(f"{_FOLDER}/{folder}/{number}_10.png"))
            self.write_lines(f"{_FOLDER}/calib_cam_to_cam/{number}.txt", _calibration(stored.camera))
            self._samples.append(f"{number},{episode.seed},{stored.index}")

    def end(self) -> None:
        """Write the list of samples."""
        check("data", len(self._samples) > 1, "a frame with all pictures of a sample", "none")
        self.write_lines("frames.csv", self._samples)


@export_format("kitti-stereo")
class KittiStereo(Kitti):
    """Pairs of pictures with disparity.

    Format: KITTI 2015, https://www.cvlibs.net/datasets/kitti. Files of one sample share a number; `frames.csv` gives
    its episode (seed) and frame. `calib_cam_to_cam/NNNNNN.txt` holds the projections P_rect_02 (this camera) and, of a
    stereo pair, P_rect_03, in pixels and metres; pixel centres have whole coordinates.

    `image_2/NNNNNN_10` is the left picture, `image_3/NNNNNN_10` the right one. `disp_occ_0/NNNNNN_10.png` is the
    disparity of the left picture in pixels, times 256, as 16 bits; 0 means none. It is focal length times baseline over
    the true depth, also of points that the right picture does not show. A frame whose right picture was lost is left
    out.
    """

    channels = ("image_rgb", "right_rgb", "depth_m")
    pictures = (_PRESENT, ("image_3", "right_rgb", 0, "10"))

    def maps_of(self, stored: StoredFrame) -> dict[str, NDArray[np.uint16]]:
        """See ``Kitti``: focal length times baseline over depth."""
        camera = stored.camera
        assert camera.baseline_m is not None
        return {"disp_occ_0": distance_map(camera.focal_px * camera.baseline_m / stored.frame.truth.depth_m)}


@export_format("kitti-flow")
class KittiFlow(Kitti):
    """Pictures with backward optical flow.

    Format: KITTI 2015, https://www.cvlibs.net/datasets/kitti. Files of one sample share a number; `frames.csv` gives
    its episode (seed) and frame. `calib_cam_to_cam/NNNNNN.txt` holds the projections P_rect_02 (this camera) and, of a
    stereo pair, P_rect_03, in pixels and metres; pixel centres have whole coordinates.

    The flow is BACKWARD: of each pixel, the place of its surface point in the previous frame minus its present place.
    KITTI's flow leads from `NNNNNN_10` to `NNNNNN_11`: so `image_2/NNNNNN_10` is the present frame here,
    `image_2/NNNNNN_11` the previous one, and time runs backwards within a pair. The first frame of an episode has no
    pair.

    `flow_occ/NNNNNN_10.png` has 16 bits a channel: red is 64 times the flow to the right, in pixels, plus 2^15; green
    likewise downwards; blue is 1 where there is flow, else all three are 0. Points that the previous frame does not
    show have flow, too.
    """

    channels = ("image_rgb", _FLOW)
    pictures = (_PRESENT, ("image_2", "image_rgb", 1, "11"))

    def maps_of(self, stored: StoredFrame) -> dict[str, NDArray[np.uint16]]:
        """See ``Kitti``."""
        return {"flow_occ": flow_map(getattr(stored.frame.truth, _FLOW))}


@export_format("kitti-forward-flow")
class KittiForwardFlow(Kitti):
    """Pictures with forward optical flow.

    Format: KITTI 2015, https://www.cvlibs.net/datasets/kitti. Files of one sample share a number; `frames.csv` gives
    its episode (seed) and frame. `calib_cam_to_cam/NNNNNN.txt` holds the projections P_rect_02 (this camera) and, of a
    stereo pair, P_rect_03, in pixels and metres; pixel centres have whole coordinates.

    The flow is forward, as in KITTI: of each pixel of `image_2/NNNNNN_10`, the place of its surface point in the next
    frame, `image_2/NNNNNN_11`, minus its present place. It is exact, computed from depth and poses; people and
    cyclists who pass by have none. The last frame of an episode has no pair.

    `flow_occ/NNNNNN_10.png` has 16 bits a channel: red is 64 times the flow to the right, in pixels, plus 2^15; green
    likewise downwards; blue is 1 where there is flow, else all three are 0. Points that the next frame does not show
    have flow, too; `flow_noc/` leaves those out. Shown is what one of the four pixels about its place in the next frame
    shows: the same body at a depth within 1 %.
    """

    channels = ("image_rgb", "depth_m", "instance_map")
    pictures = (_PRESENT, ("image_2", "image_rgb", -1, "11"))

    def maps_of(self, stored: StoredFrame) -> dict[str, NDArray[np.uint16]]:
        """See ``Kitti``."""
        flow_px, seen_next = forward_flow(stored.episode, stored.index)
        shown_px = np.where(seen_next[..., None], flow_px, np.nan)
        return {"flow_occ": flow_map(flow_px), "flow_noc": flow_map(shown_px)}


@export_format("kitti-depth")
class KittiDepth(Kitti):
    """Pictures with depth.

    Format: KITTI 2015, https://www.cvlibs.net/datasets/kitti. Files of one sample share a number; `frames.csv` gives
    its episode (seed) and frame. `calib_cam_to_cam/NNNNNN.txt` holds the projections P_rect_02 (this camera) and, of a
    stereo pair, P_rect_03, in pixels and metres; pixel centres have whole coordinates.

    `image_2/NNNNNN_10` is the picture, `depth/NNNNNN_10.png` its depth along the optical axis in metres, times 256, as
    16 bits; 0 means none, or more than 255.996 m.
    """

    channels = ("image_rgb", "depth_m")

    def maps_of(self, stored: StoredFrame) -> dict[str, NDArray[np.uint16]]:
        """See ``Kitti``."""
        return {"depth": distance_map(stored.frame.truth.depth_m)}


def _calibration(camera: CameraModel) -> list[str]:
    """Return the projections (3, 4) of the cameras, in KITTI's words."""
    # KITTI's pixel (0, 0) is the middle of the first pixel, ours its corner.
    x_px, y_px = 0.5 * camera.width_px - 0.5, 0.5 * camera.height_px - 0.5
    f, lines = camera.focal_px, []
    for name, shift_m in (("02", 0.0), ("03", camera.baseline_m)):
        if shift_m is not None:
            rows = (f, 0.0, x_px, -f * shift_m, 0.0, f, y_px, 0.0, 0.0, 0.0, 1.0, 0.0)
            lines.append(f"P_rect_{name}: " + " ".join(f"{value:.6e}" for value in rows))
    return lines


def distance_map(values: NDArray[np.floating]) -> NDArray[np.uint16]:
    """Return a map (H, W) of depths in metres or disparities in pixels as KITTI stores it: 256 steps a unit.

    0 means "no value": where none is finite and > 0, or it is beyond the largest, 255.996. A value that rounds to 0
    becomes 1, as in KITTI's own writer.
    """
    stored = np.maximum(np.rint(np.nan_to_num(values, nan=np.inf, posinf=np.inf) * _FRACTIONS), 1.0)
    good = (values > 0) & (stored <= _LARGEST)
    return np.where(good, stored, 0.0).astype(np.uint16)


def flow_map(flow_px: NDArray[np.floating]) -> NDArray[np.uint16]:
    """Return a flow (H, W, 2), x right and y down in pixels, as (H, W, 3): 64 x + 2^15, 64 y + 2^15, 1 where valid.

    All three are 0 where the flow is not finite or beyond the range of 16 bits.
    """
    steps = np.nan_to_num(flow_px, nan=np.inf, posinf=np.inf, neginf=-np.inf) * _FLOW_FRACTIONS
    # Rounded first: 32 bits lose a 256th of a step beside 2^15.
    stored = np.rint(steps) + _FLOW_ZERO
    good = ((stored >= 0) & (stored <= _LARGEST)).all(axis=2, keepdims=True)
    return np.where(good, np.concatenate([stored, np.ones_like(good)], axis=2), 0.0).astype(np.uint16)


def write_png16(values: NDArray[np.uint16], path: Path) -> None:
    """Write a map (H, W) or (H, W, 3), its channels in the order red, green, blue, as a PNG file."""
    swapped = values if values.ndim == 2 else np.ascontiguousarray(values[..., ::-1])
    path.write_bytes(cv2.imencode(".png", swapped)[1].tobytes())
