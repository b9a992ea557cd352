"""KITTI: stereo, optical flow and depth as 16-bit PNG (Menze and Geiger 2015, https://www.cvlibs.net/datasets/kitti).

Flow is BACKWARD: ``flow_px`` holds each pixel's surface point in the previous frame minus its place in the present one.
KITTI's flow goes from the picture ``NNNNNN_10`` to ``NNNNNN_11``; so here ``_10`` is the present frame and ``_11`` the
previous one, and a reader of KITTI gets matching pictures and flow with time reversed.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from benchmarks.data.exports.export_format import ExportFormat
from benchmarks.data.exports.frames import StoredFrame, episodes, frames, picture_bytes
from benchmarks.data.exports.kitti_coding import distance_map, flow_map, write_png16
from benchmarks.data.exports.objects import Labels
from benchmarks.data.sets.data_set import DataSet
from sim.checks import check
from trackers.types import CameraModel

FLOW_FIELD = "flow_px"
"""The channel of backward flow, in scenarios that have it."""
_FOLDER = "training"
_LAYOUT = """
Format: KITTI 2015, https://www.cvlibs.net/datasets/kitti. Files of one sample share a number; `frames.csv` gives its
episode (seed) and frame. `calib_cam_to_cam/NNNNNN.txt` holds the projections P_rect_02 (this camera) and, of a stereo
pair, P_rect_03, in pixels and metres; pixel centres have whole coordinates.
"""
STEREO_NOTE = f"""{_LAYOUT}
`image_2/NNNNNN_10` is the left picture, `image_3/NNNNNN_10` the right one. `disp_occ_0/NNNNNN_10.png` is the disparity
of the left picture in pixels, times 256, as 16 bits; 0 means none. It is focal length times baseline over the true
depth, also of points that the right picture does not show. A frame whose right picture was lost is left out.
"""
FLOW_NOTE = f"""{_LAYOUT}
The flow is BACKWARD: of each pixel, the place of its surface point in the previous frame minus its present place.
KITTI's flow leads from `NNNNNN_10` to `NNNNNN_11`: so `image_2/NNNNNN_10` is the present frame here,
`image_2/NNNNNN_11` the previous one, and time runs backwards within a pair. The first frame of an episode has no pair.

`flow_occ/NNNNNN_10.png` has 16 bits a channel: red is 64 times the flow to the right, in pixels, plus 2^15; green
likewise downwards; blue is 1 where there is flow, else all three are 0. Points that the previous frame does not show
have flow, too.
"""
DEPTH_NOTE = f"""{_LAYOUT}
`image_2/NNNNNN_10` is the picture, `depth/NNNNNN_10.png` its depth along the optical axis in metres, times 256, as 16
bits; 0 means none, or more than 255.996 m.
"""


@dataclass(frozen=True)
class _Map:
    """One of the three formats.

    Attributes:
        folder: of the maps. channels: that they are made from. of: returns the map of a frame.
        pictures: (folder, channel, frames back, suffix) of the pictures of a sample.
        is_stereo: whether the camera needs a second one.
    """

    folder: str
    channels: tuple[str, ...]
    of: Callable[[StoredFrame], NDArray[np.uint16]]
    pictures: tuple[tuple[str, str, int, str], ...]
    is_stereo: bool = False


def disparity_px(depth_m: NDArray[np.floating], camera: CameraModel) -> NDArray[np.floating]:
    """Return the disparity (H, W) of a rectified pair: focal length times baseline over depth; 0 where it is infinite.

    Raises:
        ValueError: if the camera has no baseline.
    """
    baseline_m = camera.baseline_m
    check("data", baseline_m is not None, "a camera with a baseline, one of a stereo pair", "a single camera")
    assert baseline_m is not None
    return camera.focal_px * baseline_m / depth_m


_PRESENT = ("image_2", "image_rgb", 0, "10")
_STEREO = _Map(
    "disp_occ_0",
    ("depth_m",),
    lambda stored: distance_map(disparity_px(stored.frame.truth.depth_m, stored.camera)),
    (_PRESENT, ("image_3", "right_rgb", 0, "10")),
    is_stereo=True,
)
_FLOW = _Map(
    "flow_occ",
    (FLOW_FIELD,),
    lambda stored: flow_map(getattr(stored.frame.truth, FLOW_FIELD)),
    (_PRESENT, ("image_2", "image_rgb", 1, "11")),
)
_DEPTH = _Map("depth", ("depth_m",), lambda stored: distance_map(stored.frame.truth.depth_m), (_PRESENT,))


def _writer(kind: _Map) -> Callable[[DataSet, Path, Labels], None]:
    def write(data: DataSet, folder: Path, _: Labels) -> None:
        root = folder / _FOLDER
        for name in {kind.folder, "calib_cam_to_cam", *(each[0] for each in kind.pictures)}:
            (root / name).mkdir(parents=True)
        number = 0
        with (folder / "frames.csv").open("w", encoding="utf-8") as table:
            table.write("number,seed,frame\n")
            for episode in episodes(data):
                for stored in frames(episode, kind.channels):
                    if _write_sample(kind, stored, root, f"{number:06d}"):
                        table.write(f"{number:06d},{episode.seed},{stored.index}\n")
                        number += 1
        check("data", number > 0, "a frame with all pictures of a sample", "none")

    return write


def _write_sample(kind: _Map, stored: StoredFrame, root: Path, number: str) -> bool:
    """Write a sample; return False, with nothing written, if one of its pictures does not exist."""
    if kind.is_stereo:
        # Before pictures are missed: a single camera has no right ones.
        disparity_px(np.ones((1, 1)), stored.camera)
    if stored.index < max(back for _, _, back, _ in kind.pictures):
        return False
    found = {
        f"{folder}/{number}_{suffix}": picture_bytes(stored.episode, stored.index - back, channel)
        for folder, channel, back, suffix in kind.pictures
    }
    if None in found.values():
        return False
    for name, picture in found.items():
        assert picture is not None
        (root / f"{name}.{picture[0]}").write_bytes(picture[1])
    write_png16(kind.of(stored), root / kind.folder / f"{number}_10.png")
    (root / "calib_cam_to_cam" / f"{number}.txt").write_text(_calibration(stored.camera), encoding="utf-8")
    return True


def _calibration(camera: CameraModel) -> str:
    """Return the projections (3, 4) of the cameras, in KITTI's words."""
    # KITTI's pixel (0, 0) is the middle of the first pixel, ours its corner.
    x_px, y_px = 0.5 * camera.width_px - 0.5, 0.5 * camera.height_px - 0.5
    lines = []
    for name, shift_m in (("02", 0.0), ("03", camera.baseline_m)):
        if shift_m is not None:
            f = camera.focal_px
            rows = (f, 0.0, x_px, -f * shift_m, 0.0, f, y_px, 0.0, 0.0, 0.0, 1.0, 0.0)
            lines.append(f"P_rect_{name}: " + " ".join(f"{value:.6e}" for value in rows))
    return "\n".join(lines) + "\n"


STEREO = ExportFormat(
    summary="pairs of pictures with disparity, as 16-bit PNG",
    needs="a stereo camera, depth_m, pictures",
    channels=("image_rgb", "right_rgb", *_STEREO.channels),
    packages=(),
    note=STEREO_NOTE,
    write=_writer(_STEREO),
)
FLOW = ExportFormat(
    summary="pictures with backward optical flow, as 16-bit PNG",
    needs="flow_px, pictures",
    channels=("image_rgb", *_FLOW.channels),
    packages=(),
    note=FLOW_NOTE,
    write=_writer(_FLOW),
)
DEPTH = ExportFormat(
    summary="pictures with depth, as 16-bit PNG",
    needs="depth_m, pictures",
    channels=("image_rgb", *_DEPTH.channels),
    packages=(),
    note=DEPTH_NOTE,
    write=_writer(_DEPTH),
)
