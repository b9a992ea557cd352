"""Objects that stand about: of the kinds that a scene asks about, but of no question themselves, e.g. parked cars."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sim.labels import SeenSurfaces, amodal_box, seen_ids, visible_fraction
from sim.mesh import TexturedMesh
from sim.optics import PinholeCamera
from sim.world import Body, World


@dataclass(frozen=True, eq=False)
class Standing:
    """A body that stands about.

    Attributes:
        name, kind: see ``Truth.standing_names`` and ``standing_kinds``.
        mesh: its shape in pictures: of a boat, what is above the water.
    """

    body: Body
    name: str
    kind: str
    mesh: TexturedMesh


class StandingObjects:
    """All bodies of a world that stand about."""

    def __init__(self, world: World, all_of_them: Sequence[Standing]) -> None:
        self._world, self._all = world, all_of_them
        self._id = np.array([each.body.index for each in all_of_them], np.int64)

    def seen(self, capture: SeenSurfaces, camera: PinholeCamera, T_world_camera: NDArray[np.float64]) -> dict[str, Any]:
        """Return the fields of ``Truth`` about those that a picture shows at least one pixel of, by name."""
        if not self._all:
            return {}
        is_shown = seen_ids(capture.instance_id, len(self._world.bodies))[self._id]
        shown = [one for one, is_here in zip(self._all, is_shown.tolist(), strict=True) if is_here]
        if not shown:
            return {}
        ids = self._id[is_shown]
        poses = self._world.poses[ids]
        boxes = np.array([amodal_box(camera, T_world_camera, one.mesh, T) for one, T in zip(shown, poses, strict=True)])
        fractions = [
            visible_fraction(capture, camera, T_world_camera, one.mesh, T, one.body.index, box)
            for one, T, box in zip(shown, poses, boxes, strict=True)
        ]
        return {
            "standing_names": tuple(one.name for one in shown),
            "standing_kinds": tuple(one.kind for one in shown),
            "standing_id": ids,
            "T_world_standing": poses,
            "standing_bounds_m": np.array([one.body.mesh.bounds_m for one in shown]),
            "standing_box_xyxy": boxes,
            "standing_visible_fraction": np.array(fractions),
        }
