"""Objects of a scene as bodies of its world: where they are, and where a picture shows them."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from scenarios.visibility import centres_px
from sim.jointed_labels import (
    JointedShape,
    PartPoints,
    enclosing_bounds,
    joined,
    merge_parts,
    places_of,
    seen_bodies,
    seen_body,
)
from sim.labels import SeenSurfaces, amodal_boxes, outline, seen_ids, visible_fraction
from sim.mesh import TexturedMesh
from sim.world import Body, World
from trackers.types import CameraModel

AWAY_M = -1000.0
"""Height of bodies that are not in the world."""
AWAY = np.eye(4)
AWAY[2, 3] = AWAY_M
AWAY.setflags(write=False)
_NO_PICTURE = np.empty((0, 0), np.int32)


@dataclass(frozen=True, slots=True)
class Labels:
    """N objects in the picture of a camera.

    Attributes:
        position_px: (N, 2) and box_xyxy: (N, 4), see ``Truth``; NaN for absent objects.
        visible_fraction: (N,) see ``Truth``; 0 for absent objects, NaN where it was not computed.
        hidden_by: (N,) index of the object that hides most of each, -1 for none; hidden_fraction: (N,) share of its own
            pixels that show another object. Of jointed objects alone, where ``visible_fraction`` was computed.
    """

    position_px: NDArray[np.float64]
    box_xyxy: NDArray[np.float64]
    visible_fraction: NDArray[np.float64]
    hidden_by: NDArray[np.int64]
    hidden_fraction: NDArray[np.float64]


class SceneObjects(ABC):
    """N objects, each of one or more movable bodies of a world: its parts.

    Attributes:
        world: theirs. parts: bodies of each.
        names, kinds: (N,) see ``Truth``.
        size_m: (N, 3). instance_id: (N,) of each object's first part.
        T_world_object: (N, 4, 4) and speed_mps: (N,), at present.
        present: (N,) False for objects that are not in the world at present.
    """

    def __init__(
        self,
        world: World,
        parts: Sequence[Sequence[Body]],
        names: Sequence[str],
        kinds: Sequence[str],
        size_m: NDArray[np.float64],
    ) -> None:
        self.world, self.parts, self.size_m = world, parts, size_m
        self.names, self.kinds = tuple(names), tuple(kinds)
        self.instance_id = np.array([bodies[0].index for bodies in parts])
        self.T_world_object = np.tile(np.eye(4), (len(parts), 1, 1))
        self.speed_mps = np.zeros(len(parts))
        self.present = np.ones(len(parts), np.bool_)

    def take_out(self, which: Iterable[int] | None = None) -> None:
        """Move objects out of sight, by default all; they are absent until they are moved again."""
        for k in range(len(self.parts)) if which is None else which:
            self.world.move_all(self.parts[k], np.tile(AWAY, (len(self.parts[k]), 1, 1)))
            self.present[k] = False

    def merge(self, instance_map: NDArray[np.int32]) -> None:  # noqa: B027
        """Write each object's ``instance_id`` over the ids of its other bodies in a map (H, W)."""

    @abstractmethod
    def bounds_m(self) -> NDArray[np.float64]:
        """Return ``Truth.bounds_m`` (N, 2, 3)."""

    def keypoints_m(self) -> NDArray[np.float64] | None:
        """Return the named points (N, K, 3), see ``keypoints_field``; None if no object has any."""
        return None

    @abstractmethod
    def labels(
        self,
        camera: CameraModel,
        T_world_camera: NDArray[np.float64],
        seen: SeenSurfaces | None = None,
        in_full: NDArray[np.bool_] | None = None,
    ) -> Labels:
        """Return where a camera sees the objects.

        Args:
            seen: the merged picture, for visible shares; None: places and boxes alone.
            in_full: (N,) the objects of which visible shares are computed.
        """

    def _centres_px(self, camera: CameraModel, T_world_camera: NDArray[np.float64]) -> NDArray[np.float64]:
        positions_px = centres_px(camera, T_world_camera, self.T_world_object, self.size_m)
        positions_px[~self.present] = np.nan
        return positions_px


class Objects(SceneObjects):
    """N rigid objects, each one movable body of a world; see ``SceneObjects``.

    Their poses stand upright, see ``Truth.T_world_object``. What rolls or tumbles is one part of ``JointedObjects``.
    """

    def __init__(
        self,
        world: World,
        bodies: Sequence[Body],
        *,
        kinds: Sequence[str] = (),
        size_m: NDArray[np.float64] | None = None,
    ) -> None:
        """``kinds`` and ``size_m``: those of the bodies (``category``) and meshes if they are left out."""
        self.bodies = list(bodies)
        super().__init__(
            world,
            [[body] for body in bodies],
            [body.name for body in bodies],
            kinds or [body.category for body in bodies],
            np.array([body.mesh.size_m for body in bodies], float) if size_m is None else size_m,
        )
        self._outline = outline([body.mesh for body in bodies])
        self._bounds_m = np.array([body.mesh.bounds_m for body in bodies])

    def move(self, T_world_object: NDArray[np.float64], speed_mps: NDArray[np.float64]) -> None:
        """Move all objects to poses (N, 4, 4); ``speed_mps`` (N,) is that of this frame."""
        self.T_world_object, self.speed_mps = T_world_object, speed_mps
        self.world.move_all(self.bodies, T_world_object)
        self.present[:] = True

    def bounds_m(self) -> NDArray[np.float64]:
        """See ``SceneObjects``."""
        return self._bounds_m

    def labels(
        self,
        camera: CameraModel,
        T_world_camera: NDArray[np.float64],
        seen: SeenSurfaces | None = None,
        in_full: NDArray[np.bool_] | None = None,
    ) -> Labels:
        """See ``SceneObjects``."""
        count = len(self.names)
        boxes = amodal_boxes(camera, T_world_camera, self._outline, self.T_world_object)
        boxes[~self.present] = np.nan
        fraction = np.full(count, np.nan)
        if seen is not None and in_full is not None:
            fraction[in_full] = 0.0
            for k in np.flatnonzero(in_full & self.present).tolist():
                body, pose = self.bodies[k], self.T_world_object[k]
                fraction[k] = visible_fraction(seen, camera, T_world_camera, body.mesh, pose, body.index, boxes[k])
        return Labels(self._centres_px(camera, T_world_camera), boxes, fraction, np.full(count, -1), np.zeros(count))


class JointedObjects(SceneObjects):
    """N objects of several parts each, see ``SceneObjects``; merged maps have the id of the first part for all of them.

    Attributes:
        part_poses: of each object, T_world_part (P, 4, 4) at present.
        cover_id: ids of standing bodies that hide objects: they count in ``hidden_fraction``, not in ``hidden_by``.
    """

    cover_id = np.empty(0, np.int64)

    def __init__(
        self,
        world: World,
        names: Sequence[str],
        kinds: Sequence[str],
        parts: Sequence[Sequence[Body]],
        size_m: NDArray[np.float64],
        shapes: Sequence[JointedShape] = (),
        keypoints: Sequence[PartPoints | None] = (),
    ) -> None:
        """``shapes``: what labels take for the objects; left out: all of their parts. ``keypoints``: of each object, as
        many of all that have any.
        """
        super().__init__(world, parts, names, kinds, size_m)
        self._keypoints = {k: points for k, points in enumerate(keypoints) if points is not None}
        self._shapes = shapes or [joined([body.mesh for body in bodies]) for bodies in parts]
        self._part_id = np.array([body.index for bodies in parts for body in bodies])
        self._whole_id = np.repeat(self.instance_id, [len(bodies) for bodies in parts])
        self.part_poses: list[NDArray[np.float64]] = [np.tile(np.eye(4), (len(bodies), 1, 1)) for bodies in parts]

    def move_parts(self, k: int, T_world_part: NDArray[np.float64]) -> None:
        """Move the parts of the k-th object to poses (P, 4, 4)."""
        self.part_poses[k], self.present[k] = T_world_part, True
        self.world.move_all(self.parts[k], T_world_part)

    def merge(self, instance_map: NDArray[np.int32]) -> None:
        """See ``SceneObjects``."""
        whole = np.arange(len(self.world.bodies), dtype=np.int32)
        whole[self._part_id] = self._whole_id
        merge_parts(instance_map, whole, int(self.instance_id[0]))

    def bounds_m(self) -> NDArray[np.float64]:
        """See ``SceneObjects``; of objects as they are posed, NaN for absent ones."""
        bounds = np.full((len(self.names), 2, 3), np.nan)
        for k in np.flatnonzero(self.present).tolist():
            if len(self.parts[k]) == 1:
                bounds[k] = self.parts[k][0].mesh.bounds_m
            else:
                bounds[k] = enclosing_bounds(self._shapes[k], self.part_poses[k], self.T_world_object[k])
        return bounds

    def keypoints_m(self) -> NDArray[np.float64] | None:
        """See ``SceneObjects``."""
        if not self._keypoints:
            return None
        count = len(next(iter(self._keypoints.values())).part)
        places_m = np.full((len(self.names), count, 3), np.nan)
        for k, points in self._keypoints.items():
            if self.present[k]:
                places_m[k] = places_of(points, self.part_poses[k])
        return places_m

    def labels(
        self,
        camera: CameraModel,
        T_world_camera: NDArray[np.float64],
        seen: SeenSurfaces | None = None,
        in_full: NDArray[np.bool_] | None = None,
    ) -> Labels:
        """See ``SceneObjects``."""
        return self._labels(camera, T_world_camera, seen, in_full)

    def _labels(
        self,
        camera: CameraModel,
        T_world_camera: NDArray[np.float64],
        seen: SeenSurfaces | None,
        in_full: NDArray[np.bool_] | None,
        shift_px: NDArray[np.float64] | None = None,
    ) -> Labels:
        """Return the labels of parts that are seen ``shift_px`` (N, P, 2) beside their places, see ``seen_body``."""
        count = len(self.names)
        boxes, hidden_by, hidden = np.full((count, 4), np.nan), np.full(count, -1), np.zeros(count)
        wanted = np.zeros(count, np.bool_) if in_full is None or seen is None else in_full
        fraction = np.where(wanted, 0.0, np.nan)
        for k in np.flatnonzero(self.present).tolist():
            own = int(self.instance_id[k])
            one = seen_body(
                self._shapes[k],
                self.part_poses[k],
                camera,
                T_world_camera,
                seen.instance_id if seen is not None and wanted[k] else _NO_PICTURE,
                own,
                hiders=np.concatenate([self.instance_id[self.instance_id != own], self.cover_id]),
                shift_px=None if shift_px is None else shift_px[k],
            )
            boxes[k] = one.box_xyxy
            if wanted[k]:
                fraction[k], hidden[k] = one.visible_fraction, one.hidden_fraction
                is_object = one.hidden_by >= 0 and one.hidden_by not in self.cover_id
                hidden_by[k] = np.searchsorted(self.instance_id, one.hidden_by) if is_object else -1
        return Labels(self._centres_px(camera, T_world_camera), boxes, fraction, hidden_by, hidden)


def add_parts(
    world: World,
    name: str,
    category: str,
    meshes: Mapping[Any, TexturedMesh],
    T_world_part: NDArray[np.float64] | None = None,
) -> list[Body]:
    """Add the movable bodies of a jointed object to a world, at the origin or a pose, by the names of its parts."""
    T = np.eye(4) if T_world_part is None else T_world_part
    return [world.add(mesh, T, name=f"{name} {part}", category=category, movable=True) for part, mesh in meshes.items()]


@dataclass(frozen=True, eq=False)
class Standing:
    """A body of a labelled kind that no question is about, e.g. a parked car or someone who walks by.

    Attributes:
        name, kind: see ``Truth.standing_names`` and ``standing_kinds``.
        mesh: its shape in pictures: of a boat, what is above the water.
        limbs: further bodies of it, whose ids count as that of ``body``.
    """

    body: Body
    name: str
    kind: str
    mesh: TexturedMesh
    limbs: tuple[Body, ...] = ()

    @cached_property
    def bounds_m(self) -> NDArray[np.float64]:
        """Bounds (2, 3) of the whole body, of a boat with the hull in the water."""
        return self.body.mesh.bounds_m

    @cached_property
    def shape(self) -> JointedShape:
        """``mesh`` for labels. A town parks thousands of cars, of which few come into view."""
        return joined([self.mesh, *(limb.mesh for limb in self.limbs)])

    @cached_property
    def ids(self) -> list[int]:
        """Ids of all of its bodies, the first one its own."""
        return [self.body.index, *(limb.index for limb in self.limbs)]


class StandingObjects:
    """All bodies of a world that stand about."""

    def __init__(self, world: World, standing: Sequence[Standing]) -> None:
        self._world, self._all = world, standing
        self._id = np.array([each.body.index for each in standing], np.int64)
        limbed = [each.ids for each in standing if each.limbs]
        self._first_limbed = min((ids[0] for ids in limbed), default=-1)
        self._whole = np.arange(len(world.bodies), dtype=np.int32)
        for ids in limbed:
            self._whole[ids] = ids[0]

    def merge(self, instance_map: NDArray[np.int32]) -> None:
        """Write the ids of those of several bodies over the ids of their limbs in a map (H, W)."""
        if self._first_limbed >= 0:
            merge_parts(instance_map, self._whole, self._first_limbed)

    def labels(self, seen: SeenSurfaces, camera: CameraModel, T_world_camera: NDArray[np.float64]) -> dict[str, Any]:
        """Return the fields of ``Truth`` about those that a picture shows at least one pixel of, by name."""
        which: list[int] = []
        if self._all:
            which = np.flatnonzero(seen_ids(seen.instance_id, len(self._world.bodies))[self._id]).tolist()
        if not which:
            return {}
        shown, poses = [self._all[k] for k in which], self._world.poses[self._id[which]]
        box_xyxy, visible_fraction, bounds_m = seen_bodies(
            [one.shape for one in shown],
            [self._world.poses[one.ids] for one in shown],
            camera,
            T_world_camera,
            seen.instance_id,
            self._id[which],
        )
        for k, one in enumerate(shown):
            if not one.limbs:
                bounds_m[k] = one.bounds_m
        return {
            "standing_names": tuple(one.name for one in shown),
            "standing_kinds": tuple(one.kind for one in shown),
            "standing_id": self._id[which],
            "T_world_standing": poses,
            "standing_bounds_m": bounds_m,
            "standing_box_xyxy": box_xyxy,
            "standing_visible_fraction": visible_fraction,
        }
