"""Objects that stand about: of the kinds that a scene asks about, but of no question themselves, e.g. parked cars."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sim.jointed_labels import JointedShape, joined, seen_body
from sim.labels import SeenSurfaces, seen_ids
from sim.mesh import TexturedMesh
from sim.optics import PinholeCamera
from sim.world import Body, World

_NO_IDS = np.empty(0, np.int64)


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

    @cached_property
    def bounds_m(self) -> NDArray[np.float64]:
        """Bounds (2, 3) of the whole body, of a boat with the hull in the water."""
        return self.body.mesh.bounds_m


class StandingObjects:
    """All bodies of a world that stand about."""

    def __init__(self, world: World, all_of_them: Sequence[Standing]) -> None:
        self._world, self._all = world, all_of_them
        self._id = np.array([each.body.index for each in all_of_them], np.int64)
        # A town parks thousands, of which few come into view.
        self._shapes: dict[int, JointedShape] = {}

    def seen(self, capture: SeenSurfaces, camera: PinholeCamera, T_world_camera: NDArray[np.float64]) -> dict[str, Any]:
        """Return the fields of ``Truth`` about those that a picture shows at least one pixel of, by name."""
        if not self._all:
            return {}
        which = np.flatnonzero(seen_ids(capture.instance_id, len(self._world.bodies))[self._id]).tolist()
        if not which:
            return {}
        shown = [self._all[k] for k in which]
        poses = self._world.poses[self._id[which]]
        labels = [
            seen_body(
                self._shape(k),
                poses[n : n + 1],
                camera,
                T_world_camera,
                capture.instance_id,
                self._all[k].body.index,
                hiders=_NO_IDS,
            )
            for n, k in enumerate(which)
        ]
        return {
            "standing_names": tuple(one.name for one in shown),
            "standing_kinds": tuple(one.kind for one in shown),
            "standing_id": self._id[which],
            "T_world_standing": poses,
            "standing_bounds_m": np.array([one.bounds_m for one in shown]),
            "standing_box_xyxy": np.array([each.box_xyxy for each in labels]),
            "standing_visible_fraction": np.array([each.visible_fraction for each in labels]),
        }

    def _shape(self, k: int) -> JointedShape:
        if k not in self._shapes:
            self._shapes[k] = joined([self._all[k].mesh])
        return self._shapes[k]
