"""The fish of a tank as bodies of a world, bent on each frame, and where they are seen through the water."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from scenarios.fish_tank.shoal import Swims
from sim.jointed_labels import enclosing_bounds, joined, merge_parts, seen_body
from sim.meshes.fish import FishLook, fish_segments, half_size
from sim.motion.swim import CENTRE_LINE_POINTS, SEGMENT_ENDS, swim_pose
from sim.optics import PinholeCamera, project
from sim.render.refraction import project_through
from sim.water_surface import RippledSurface
from sim.world import World

_NO_PICTURE = np.empty((0, 0), np.int32)
_LINE_TO_SEGMENTS = np.stack(
    [
        np.interp(np.convolve(SEGMENT_ENDS, (0.5, 0.5), "valid"), np.linspace(0.0, 1.0, CENTRE_LINE_POINTS), row)
        for row in np.eye(CENTRE_LINE_POINTS)
    ],
    axis=1,
)
"""Weights (S, K) that interpolate values at the points of a centre line at the middles of the segments."""
_AWAY_M = -1000.0
"""Height to which fish are moved for pictures without them."""


@dataclass(frozen=True, slots=True)
class Sighted:
    """N fish in a picture, after refraction.

    Attributes:
        position_px: (N, 2) middle of the body. box_xyxy: (N, 4) amodal.
        centre_line_px: (N, K, 2). heading_rad: (N,) see ``FishTruth``.
        visible_fraction: (N,) and hidden_by: (N,) index of a fish; NaN and -1 where not asked.
    """

    position_px: NDArray[np.float64]
    box_xyxy: NDArray[np.float64]
    centre_line_px: NDArray[np.float64]
    heading_rad: NDArray[np.float64]
    visible_fraction: NDArray[np.float64]
    hidden_by: NDArray[np.int64]

    def postures(self) -> dict[str, Any]:
        """Return the fields of ``FishTruth`` about single bodies, by name."""
        return {name: getattr(self, name) for name in ("centre_line_px", "heading_rad", "hidden_by")}


class Fish:
    """N fish as bodies of a world.

    Attributes:
        names: ``fish-0`` …
        size_m: (N, 3) length, width, height of straight bodies.
        instance_id: (N,) id of all parts of a fish in maps, see ``merge``.
        T_world_fish: (N, 4, 4) under the middle of the body, x ahead.
        centre_line_m: (N, K, 3).
    """

    def __init__(self, world: World, swims: Swims, looks: Sequence[FishLook], rng: np.random.Generator) -> None:
        self._world, self._swims = world, swims
        self.names = tuple(f"fish-{k}" for k in range(len(looks)))
        parts = [fish_segments(look, rng) for look in looks]
        self._shapes = [joined(meshes) for meshes in parts]
        bodies = [
            [
                world.add(mesh, np.eye(4), name=f"{name} {k}", category="fish", movable=True)
                for k, mesh in enumerate(meshes)
            ]
            for name, meshes in zip(self.names, parts, strict=True)
        ]
        self._bodies = [body for each in bodies for body in each]
        self.size_m = np.array([_size_m(look) for look in looks])
        self.instance_id = np.array([each[0].index for each in bodies])
        self._merged_id = np.arange(len(world.bodies), dtype=np.int32)
        for each in bodies:
            self._merged_id[[body.index for body in each]] = each[0].index

    def move_to(self, frame: int) -> None:
        """Bend and move all fish to their poses on a frame."""
        swims = self._swims
        place = swims.position_m[frame], swims.yaw_rad[frame], swims.pitch_rad[frame]
        pose = swim_pose(self.size_m[:, 0], *place, swims.joints_rad[frame])
        self._part_poses, self.centre_line_m = pose.T_world_segment, pose.centre_line_m
        self.T_world_fish = _poses(*place)
        self.T_world_fish[:, :3, 3] -= 0.5 * self.size_m[:, 2:] * self.T_world_fish[:, :3, 2]
        self._world.move_all(self._bodies, self._part_poses.reshape(-1, 4, 4))

    def take_out(self) -> None:
        """Move all fish out of sight, until the next ``move_to``."""
        away = self._part_poses.reshape(-1, 4, 4).copy()
        away[:, 2, 3] = _AWAY_M
        self._world.move_all(self._bodies, away)

    def merge(self, instance_map: NDArray[np.int32]) -> None:
        """Replace the ids of parts in a map (H, W) by one id per fish."""
        merge_parts(instance_map, self._merged_id, int(self.instance_id[0]))

    def bounds_m(self) -> NDArray[np.float64]:
        """Return the bounds (N, 2, 3) of all as they are bent, see ``Truth``."""
        posed = zip(self._shapes, self._part_poses, self.T_world_fish, strict=True)
        return np.array([enclosing_bounds(*one) for one in posed])

    def seen(
        self,
        camera: PinholeCamera,
        T_world_camera: NDArray[np.float64],
        surface: RippledSurface,
        merged: NDArray[np.int32] | None,
        *,
        in_full: bool,
    ) -> Sighted:
        """Return where all fish are seen; visible shares in a ``merged`` map, only the first one's unless ``in_full``.

        Each segment is shifted as a whole from where a camera without water sees it, by what the centre
        line is shifted at its middle: ripples are longer than a segment.
        """
        count, points = self.centre_line_m.shape[:2]
        points_m = self.centre_line_m.reshape(-1, 3)
        line_px = project_through(surface, camera, T_world_camera, points_m).reshape(count, points, 2)
        line_shift_px = line_px - project(camera, T_world_camera, points_m)[0].reshape(count, points, 2)
        shift_px = np.einsum("sk,nkp->nsp", _LINE_TO_SEGMENTS, line_shift_px)
        box_xyxy, fraction = np.empty((count, 4)), np.full(count, np.nan)
        hidden_by = np.full(count, -1)
        for k in range(count):
            is_asked = merged is not None and (in_full or k == 0)
            own = int(self.instance_id[k])
            one = seen_body(
                self._shapes[k],
                self._part_poses[k],
                camera,
                T_world_camera,
                merged if merged is not None and is_asked else _NO_PICTURE,
                own,
                hiders=self.instance_id[self.instance_id != own],
                shift_px=shift_px[k],
            )
            box_xyxy[k] = one.box_xyxy
            if is_asked:
                # Only fish hide fish; at the rim of a thin body the bent samples miss it at times.
                fraction[k] = 1.0 - one.hidden_fraction if np.isfinite(one.box_xyxy).all() else 0.0
                if one.hidden_by >= 0:
                    hidden_by[k] = np.searchsorted(self.instance_id, one.hidden_by)
        middle = points // 2
        ahead_px = line_px[:, 0] - line_px[:, middle]
        heading_rad = np.arctan2(ahead_px[:, 1], ahead_px[:, 0])
        return Sighted(line_px[:, middle], box_xyxy, line_px, heading_rad, fraction, hidden_by)


def _size_m(look: FishLook) -> NDArray[np.float64]:
    """Return length, width and height (3,) of a straight fish."""
    half_width, reach = half_size(np.linspace(0.0, 1.0, 101)).max(axis=1)
    return look.length_m * np.array([1.0, 2.0 * look.width * half_width, 2.0 * reach])


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
