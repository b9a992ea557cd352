"""The fish of a tank as bodies of a world, bent on each frame, and where they are seen through the water."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from scenarios.fish_tank.shoal import Swims
from scenarios.objects import JointedObjects, Labels, add_parts
from sim.labels import SeenSurfaces
from sim.meshes.fish import FishLook, fish_segments, half_size
from sim.motion.swim import CENTRE_LINE_POINTS, SEGMENT_ENDS, swim_pose
from sim.optics import project
from sim.render.refraction import project_through
from sim.water_surface import RippledSurface
from sim.world import World
from trackers.types import CameraModel

_LINE_TO_SEGMENTS = np.stack(
    [
        np.interp(np.convolve(SEGMENT_ENDS, (0.5, 0.5), "valid"), np.linspace(0.0, 1.0, CENTRE_LINE_POINTS), row)
        for row in np.eye(CENTRE_LINE_POINTS)
    ],
    axis=1,
)
"""Weights (S, K) that interpolate values at the points of a centre line at the middles of the segments."""


@dataclass(frozen=True, slots=True)
class FishLabels(Labels):
    """N fish in a picture, after refraction.

    Attributes:
        centre_line_px: (N, K, 2) and heading_rad: (N,), see ``FishTruth``.
    """

    centre_line_px: NDArray[np.float64]
    heading_rad: NDArray[np.float64]


class Fish(JointedObjects):
    """N fish, ``fish-0`` and so on; sizes are those of straight bodies, origins under the middle of the body, x ahead.

    Attributes:
        centre_line_m: (N, K, 3). below_surface_m: (N,). Both at present, see ``FishTruth``.
    """

    def __init__(
        self, world: World, swims: Swims, looks: Sequence[FishLook], surface: RippledSurface, rng: np.random.Generator
    ) -> None:
        self._swims, self._surface = swims, surface
        names = [f"fish-{k}" for k in range(len(looks))]
        parts = [
            add_parts(world, name, "fish", dict(enumerate(fish_segments(look, rng))))
            for name, look in zip(names, looks, strict=True)
        ]
        super().__init__(world, names, ["fish"] * len(names), parts, np.array([_size_m(look) for look in looks]))

    def move_to(self, frame: int) -> None:
        """Bend and move all fish to their poses on a frame."""
        swims = self._swims
        place = swims.position_m[frame], swims.yaw_rad[frame], swims.pitch_rad[frame]
        pose = swim_pose(self.size_m[:, 0], *place, swims.joints_rad[frame])
        self.centre_line_m, self.speed_mps = pose.centre_line_m, swims.speed_mps[frame]
        self.below_surface_m = self._surface.depth_m - place[0][:, 2]
        self.T_world_object = _poses(*place)
        self.T_world_object[:, :3, 3] -= 0.5 * self.size_m[:, 2:] * self.T_world_object[:, :3, 2]
        for k, part_poses in enumerate(pose.T_world_segment):
            self.move_parts(k, part_poses)

    def labels(
        self,
        camera: CameraModel,
        T_world_camera: NDArray[np.float64],
        seen: SeenSurfaces | None = None,
        in_full: NDArray[np.bool_] | None = None,
    ) -> FishLabels:
        """See ``SceneObjects``.

        Each segment is shifted as a whole from where a camera without water sees it, by what the centre
        line is shifted at its middle: ripples are longer than a segment.
        """
        count, points = self.centre_line_m.shape[:2]
        points_m = self.centre_line_m.reshape(-1, 3)
        line_px = project_through(self._surface, camera, T_world_camera, points_m).reshape(count, points, 2)
        line_shift_px = line_px - project(camera, T_world_camera, points_m)[0].reshape(count, points, 2)
        shift_px = np.einsum("sk,nkp->nsp", _LINE_TO_SEGMENTS, line_shift_px)
        plain = self._labels(camera, T_world_camera, seen, in_full, shift_px)
        # Only fish and leaves hide fish; at the rim of a thin body the bent samples miss it at times.
        share = np.where(np.isfinite(plain.box_xyxy).all(axis=1), 1.0 - plain.hidden_fraction, 0.0)
        fraction = np.where(np.isnan(plain.visible_fraction), np.nan, share)
        middle = points // 2
        ahead_px = line_px[:, 0] - line_px[:, middle]
        heading_rad = np.arctan2(ahead_px[:, 1], ahead_px[:, 0])
        return FishLabels(
            line_px[:, middle], plain.box_xyxy, fraction, plain.hidden_by, plain.hidden_fraction, line_px, heading_rad
        )


def _size_m(look: FishLook) -> NDArray[np.float64]:
    """Return length, width and height (3,) of a straight fish."""
    half_width, reach = half_size(np.linspace(0.0, 1.0, 101)).max(axis=1)
    return look.length_m * np.array([1.0, 2.0 * look.width * half_width, 2.0 * look.height * reach])


def _poses(
    position_m: NDArray[np.float64], yaw_rad: NDArray[np.float64], pitch_rad: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Return poses (N, 4, 4): x ahead and up by the pitch, y left."""
    cy, sy, cp, sp = np.cos(yaw_rad), np.sin(yaw_rad), np.cos(pitch_rad), np.sin(pitch_rad)
    zero = np.zeros_like(cy)
    T = np.tile(np.eye(4), (len(position_m), 1, 1))
    T[:, :3, :3] = np.stack(
        [np.stack([cy * cp, sy * cp, sp], 1), np.stack([-sy, cy, zero], 1), np.stack([-cy * sp, -sy * sp, cp], 1)], 2
    )
    T[:, :3, 3] = position_m
    return T
