"""People in a world: bodies of jointed parts, posed on each frame."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from scenarios.objects import JointedObjects, add_parts
from scenarios.stereo_follow.plan import TARGET, Plan
from sim.meshes.person import person_parts, person_size_m
from sim.motion.gait import part_poses
from sim.motion.skeleton import skeleton
from sim.pose import pose_on_ground
from sim.rng import generator
from sim.world import World

CHEST = 0.72
"""Height of the chest, share of stature."""


class People(JointedObjects):
    """N people, ``target``, ``crosser-1`` and so on; sizes are those of standing people, origins on the ground."""

    def __init__(self, world: World, plan: Plan) -> None:
        self._plan = plan
        self._bones = [skeleton(look.stature_m, look.build) for look in plan.looks]
        kinds = plan.crowd.kinds
        names = [kind if k == TARGET else f"{kind}-{k}" for k, kind in enumerate(kinds)]
        rng = generator(plan.seed, "clothes")
        parts = [
            add_parts(world, name, "person", person_parts(look, rng))
            for name, look in zip(names, plan.looks, strict=True)
        ]
        super().__init__(world, names, kinds, parts, np.array([person_size_m(look) for look in plan.looks]))
        self._postures: list[tuple[float, ...]] = [()] * len(parts)

    def move_to(self, frame: int) -> None:
        """Move all people to their poses on a frame."""
        self.speed_mps = np.array([walk.speed_mps[frame] for walk in self._plan.crowd.walks])
        for k, walk in enumerate(self._plan.crowd.walks):
            (x_m, y_m), heading_rad = walk.place_m[frame], walk.heading_rad[frame]
            phase_rad, speed_mps = self._plan.phase_rad[frame, k], walk.speed_mps[frame]
            posture = (x_m, y_m, heading_rad, phase_rad if speed_mps > 0 else 0.0, speed_mps)
            if posture == self._postures[k]:
                continue
            self._postures[k] = posture
            pose = pose_on_ground(x_m, y_m, heading_rad)
            self.T_world_object[k] = pose
            self.move_parts(k, part_poses(self._bones[k], pose, phase_rad, speed_mps))

    def chests_m(self) -> NDArray[np.float64]:
        """Return the centres of all chests (N, 3)."""
        places_m = self.T_world_object[:, :3, 3].copy()
        places_m[:, 2] = CHEST * self.size_m[:, 2]
        return places_m
