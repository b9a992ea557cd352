"""People in a world: bodies of jointed parts, posed on each frame."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from scenarios.stereo_follow.plan import TARGET, Plan
from sim.jointed_labels import SeenBody, enclosing_bounds, joined, merge_parts, seen_body
from sim.meshes.person import person_parts, person_size_m
from sim.motion.gait import part_poses
from sim.motion.skeleton import PART_NAMES, skeleton
from sim.optics import PinholeCamera
from sim.pose import pose_on_ground
from sim.rng import generator
from sim.world import World

_NO_PICTURE = np.empty((0, 0), np.int32)
CHEST = 0.72
"""Height of the chest, share of stature."""


class People:
    """N people as bodies of a world.

    Attributes:
        names: ``target``, ``crosser-1`` …
        size_m: (N, 3) length, width, height of standing people.
        instance_id: (N,) id of all parts of a person in maps, see ``merge``.
        T_world_person: (N, 4, 4) on the ground, x ahead.
        part_poses: (N, P, 4, 4).
    """

    def __init__(self, world: World, plan: Plan) -> None:
        self._plan, self._world = plan, world
        self._bones = [skeleton(look.stature_m, look.build) for look in plan.looks]
        self.names = tuple(kind if k == TARGET else f"{kind}-{k}" for k, kind in enumerate(plan.crowd.kinds))
        rng = generator(plan.seed, "clothes")
        parts = [person_parts(look, rng) for look in plan.looks]
        self._shapes = [joined(list(meshes.values())) for meshes in parts]
        self._bodies = [
            [
                world.add(mesh, np.eye(4), name=f"{name} {part}", category="person", movable=True)
                for part, mesh in meshes.items()
            ]
            for name, meshes in zip(self.names, parts, strict=True)
        ]
        self.size_m = np.array([person_size_m(look) for look in plan.looks])
        self.instance_id = np.array([bodies[0].index for bodies in self._bodies])
        self._merged_id = np.arange(len(world.bodies), dtype=np.int32)
        for bodies in self._bodies:
            self._merged_id[[body.index for body in bodies]] = bodies[0].index
        self.T_world_person = np.tile(np.eye(4), (len(parts), 1, 1))
        self._postures: list[tuple[float, ...]] = [()] * len(parts)
        self.part_poses = np.tile(np.eye(4), (len(parts), len(PART_NAMES), 1, 1))

    def move_to(self, frame: int) -> None:
        """Move all people to their poses on a frame."""
        for k, walk in enumerate(self._plan.crowd.walks):
            (x_m, y_m), heading_rad = walk.place_m[frame], walk.heading_rad[frame]
            phase_rad, speed_mps = self._plan.phase_rad[frame, k], walk.speed_mps[frame]
            posture = (x_m, y_m, heading_rad, phase_rad if speed_mps > 0 else 0.0, speed_mps)
            if posture == self._postures[k]:
                continue
            self._postures[k] = posture
            pose = pose_on_ground(x_m, y_m, heading_rad)
            self.T_world_person[k] = pose
            self.part_poses[k] = part_poses(self._bones[k], pose, phase_rad, speed_mps)
            for body, part_pose in zip(self._bodies[k], self.part_poses[k], strict=True):
                self._world.move(body, part_pose)

    def merge(self, instance_map: NDArray[np.int32]) -> None:
        """Replace the ids of parts in a map (H, W) by one id per person."""
        merge_parts(instance_map, self._merged_id, int(self.instance_id[0]))

    def seen(
        self,
        camera: PinholeCamera,
        T_world_camera: NDArray[np.float64],
        merged: NDArray[np.int32],
        in_full: NDArray[np.bool_],
    ) -> list[SeenBody]:
        """Return the visible part of each person in a merged map; only the box of people not ``in_full`` (N,)."""
        return [
            seen_body(
                shape,
                poses,
                camera,
                T_world_camera,
                merged if is_full else _NO_PICTURE,
                int(own),
                hiders=self.instance_id[self.instance_id != own],
            )
            for shape, poses, own, is_full in zip(self._shapes, self.part_poses, self.instance_id, in_full, strict=True)
        ]

    def bounds_m(self) -> NDArray[np.float64]:
        """Return the bounds (N, 2, 3) of all as they are posed, see ``Truth``."""
        posed = zip(self._shapes, self.part_poses, self.T_world_person, strict=True)
        return np.array([enclosing_bounds(*one) for one in posed])

    def chests_m(self) -> NDArray[np.float64]:
        """Return the centres of all chests (N, 3)."""
        places_m = self.T_world_person[:, :3, 3].copy()
        places_m[:, 2] = CHEST * self.size_m[:, 2]
        return places_m
