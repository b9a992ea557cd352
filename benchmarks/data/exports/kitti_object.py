"""KITTI's 3-D object labels (Geiger, Lenz, Urtasun 2012, https://www.cvlibs.net/datasets/kitti/eval_object.php)."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from benchmarks.data.exports.exporter import Exporter, export_format
from benchmarks.data.exports.labels import Instance
from benchmarks.data.exports.sidecar import Sidecar
from benchmarks.data.sets.stored_episode import StoredEpisode
from scenarios import catalog
from scenarios.visibility import MOSTLY_SEEN
from sim.checks import check
from sim.optics import intrinsic_matrix, invert_pose
from trackers.types import CameraModel

_ROOT = "training"
_FULLY_SEEN = 0.95
IGNORED = "DontCare"
_NO_OBJECT = "-1 -1 -10 {} -1 -1 -1 -1000 -1000 -1000 -10"
"""What KITTI writes of a region that does not count, around its box."""
_MATRICES = ("T_camera_object", "bounds_m")
_CORNERS = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)])


@export_format("kitti-object")
class KittiObject(Exporter):
    """Pictures with 3-D boxes, as KITTI's object benchmark has them.

    Format: https://www.cvlibs.net/datasets/kitti/eval_object.php (Geiger et al., CVPR 2012). Files of one sample share
    a number: `training/image_2/NNNNNN`, `label_2/NNNNNN.txt`, `calib/NNNNNN.txt`; `frames.csv` gives its episode (seed)
    and frame, `ImageSets/` the numbers of each split. Objects of which at least one pixel is seen have a line, parked
    cars and moored boats too.

    A line is type (the class, or `DontCare`), truncated, occluded, alpha, box (left, top, right, bottom), height,
    width, length, x, y, z, rotation_y.

    - Frame: KITTI's boxes stand upright on the y axis of the rectified camera. So that this holds for a camera that
      looks down, the rectified frame here is level: its origin is the camera's, y points straight down in the world,
      and it is turned from the camera by the least angle that makes it so (a camera that looks straight down has the
      picture's upper edge ahead). `R0_rect` is this turn, and `P2` (`P3` of a stereo pair) contains its inverse: P2
      times a place in the level frame is its pixel, as in KITTI, but P2 has more than a focal length and a middle. Of a
      level camera both frames are the same. `Tr_velo_to_cam` leads from x ahead, y left, z up of the level frame.
    - x, y, z: middle of the lower side of the box, metres. rotation_y: of the object's x axis (forward) about y, 0
      along the camera's x axis, -pi to pi. alpha: rotation_y less the azimuth of x, z. The box is turned by rotation_y
      alone and encloses the object: of what rolls or pitches, a boat, it is larger than the object's own.
    - box: of the whole object, hidden parts too, cut at the border; of one that reaches behind the camera, around what
      is seen. Pixel centres have whole coordinates: the picture goes from -0.5 on, boxes from 0 to width - 1.
    - truncated: share of the area of the whole box outside of the picture. occluded: 0 where at least 95 % of the
      object's own pixels inside the picture are seen, 1 at least half, 2 less, 3 unknown, as it reaches behind the
      camera. (Of one that the border cuts, that share is seen pixels over all, over 1 - truncated.)
    - `DontCare`: what is to be ignored (`--min-visible`, without what glare covers, `--min-size`, `--ignore-standing`).

    `objects.csv` says more, a row for each line of the label files: file, line (from 1), class, `T_camera_object` (the
    rotation in full: three rows of four, of the camera as it is, not levelled), `bounds_m` (least x, y, z, greatest x,
    y, z in the object's frame), and:
    """

    channels = ("image_rgb",)
    has_attributes = True
    has_classes = True
    leaves_out = True
    of_stills = True

    def begin(self) -> None:
        """Begin the lists."""
        pinhole = catalog.scenario(self.data.request.scenario).truth.pinhole
        check("data", pinhole, "a scene before a pinhole camera for kitti-object", "one that is seen through water")
        self._samples, self._sidecar = ["number,seed,frame"], Sidecar(self.labels, *_MATRICES)
        self._splits: dict[str, list[str]] = {}

    def write_episode(self, episode: StoredEpisode) -> None:
        """Write pictures, labels and calibrations."""
        for stored in self.frames(episode):
            number = f"{len(self._samples) - 1:06d}"
            level = level_turn(stored.frame.truth.T_world_camera)
            self.write_picture(stored, f"{_ROOT}/image_2/{number}")
            file, lines = f"{_ROOT}/label_2/{number}.txt", list[str]()
            for each, taken in self.labels.seen(stored):
                T_camera_object = invert_pose(stored.frame.truth.T_world_camera) @ each.T_world_object
                kind = self.labels.names[each.class_number].replace(" ", "_") if taken else IGNORED
                lines.append(label_line(kind, stored.camera, each, level, T_camera_object))
                matrices = (T_camera_object[:3], each.bounds_m)
                texts = (" ".join(repr(float(value)) for value in matrix.ravel()) for matrix in matrices)
                self._sidecar.add(file, len(lines), each, dict(zip(_MATRICES, texts, strict=True)))
            self.write_lines(file, lines)
            self.write_lines(f"{_ROOT}/calib/{number}.txt", calibration_lines(stored.camera, level))
            self._samples.append(f"{number},{episode.seed},{stored.index}")
            self._splits.setdefault(self.data.request.split_of(episode.seed), []).append(number)

    def end(self) -> None:
        """Write the lists and the sidecar."""
        self.write_lines("frames.csv", self._samples)
        for split, numbers in self._splits.items():
            self.write_lines(f"ImageSets/{split}.txt", numbers)
        self._sidecar.write(self.folder)


def level_turn(T_world_camera: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return R_level_camera (3, 3), the least turn that brings the y axis straight down in the world.

    With d the direction down in the camera's frame and v = d x y: ``R = I + [v] + [v]² / (1 + d_y)`` (Rodrigues).
    """
    x, y, z = -T_world_camera[2, :3]
    if y < -1.0 + 1e-9:
        return np.diag([-1.0, -1.0, 1.0])
    v = np.array([[0.0, -x, 0.0], [x, 0.0, z], [0.0, -z, 0.0]])
    return np.eye(3) + v + v @ v / (1.0 + y)


def label_line(
    kind: str,
    camera: CameraModel,
    instance: Instance,
    R_level_camera: NDArray[np.float64],
    T_camera_object: NDArray[np.float64],
) -> str:
    """Return the line of an object, or of a region that does not count."""
    has_box, size = bool(np.isfinite(instance.box_xyxy).all()), np.array([camera.width_px, camera.height_px], float)
    whole = instance.box_xyxy if has_box else instance.visible_xyxy
    cut = np.concatenate([np.clip(whole[:2], 0, size), np.clip(whole[2:], 0, size)])
    box = " ".join(f"{pixel:.4f}" for pixel in np.clip(cut - 0.5, 0, np.tile(size - 1, 2)))
    if kind == IGNORED:
        return f"{kind} {_NO_OBJECT.format(box)}"
    inside = float(np.prod(cut[2:] - cut[:2]) / np.prod(whole[2:] - whole[:2]))
    truncated = 1.0 - inside if has_box else 1.0 - instance.visible_fraction
    seen = min(instance.visible_fraction / max(inside, 1e-9), 1.0)
    occluded = 3 if not has_box else 0 if seen >= _FULLY_SEEN else 1 if seen >= MOSTLY_SEEN else 2
    place, size_m, rotation_y = upright_box(R_level_camera, T_camera_object, instance.bounds_m)
    alpha = np.angle(np.exp(1j * (rotation_y - np.arctan2(place[0], place[2]))))
    numbers = " ".join(f"{number:.6f}" for number in (*size_m, *place, rotation_y))
    return f"{kind} {truncated:.4f} {occluded} {alpha:.6f} {box} {numbers}"


def upright_box(
    R_level_camera: NDArray[np.float64], T_camera_object: NDArray[np.float64], bounds_m: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64], float]:
    """Return the least box that is turned by rotation_y alone about the corners of ``bounds_m`` (2, 3).

    Returns:
        middle of its lower side (3,) in the level frame; height, width, length (3,); rotation_y in radians.
    """
    ahead = R_level_camera @ T_camera_object[:3, 0]
    rotation_y = float(np.arctan2(-ahead[2], ahead[0]))
    c, s = np.cos(rotation_y), np.sin(rotation_y)
    R_level_box = np.array([[c, 0.0, s], [0.0, 1.0, 0.0], [-s, 0.0, c]])
    corners_m = np.take_along_axis(bounds_m, _CORNERS, axis=0)
    corners_m = (corners_m @ T_camera_object[:3, :3].T + T_camera_object[:3, 3]) @ R_level_camera.T @ R_level_box
    low_m, high_m = corners_m.min(axis=0), corners_m.max(axis=0)
    length, height, width = high_m - low_m
    lower = np.array([0.5 * (low_m + high_m)[0], high_m[1], 0.5 * (low_m + high_m)[2]])
    return R_level_box @ lower, np.array([height, width, length]), rotation_y


def calibration_lines(camera: CameraModel, R_level_camera: NDArray[np.float64]) -> list[str]:
    """Return the projections (3, 4) of the level frame's places, the turn to it, and that from x ahead, z up."""
    K = intrinsic_matrix(camera)
    # KITTI's pixel (0, 0) is the middle of the first pixel, ours its corner.
    K[:2, 2] -= 0.5
    left, right = (
        K @ np.column_stack([R_level_camera.T, [-shift_m, 0.0, 0.0]]) for shift_m in (0.0, camera.baseline_m or 0.0)
    )
    ahead_up = np.array([[0.0, -1.0, 0.0], [0.0, 0.0, -1.0], [1.0, 0.0, 0.0]])
    entries = {"P0": left, "P1": left, "P2": left, "P3": right, "R0_rect": R_level_camera}
    entries["Tr_velo_to_cam"] = np.column_stack([R_level_camera.T @ ahead_up, np.zeros(3)])
    entries["Tr_imu_to_velo"] = np.eye(4)[:3]
    return [f"{name}: " + " ".join(f"{value:.12e}" for value in matrix.ravel()) for name, matrix in entries.items()]
