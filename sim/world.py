"""The world: textured bodies at poses. Scenes move the bodies, renderers draw them; nothing here simulates physics.

``sim.bullet`` makes a physics simulation of a world for uses that need one.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from sim.mesh import TexturedMesh


@dataclass(frozen=True, eq=False)
class Body:
    """One rigid body of a world.

    Attributes:
        index: in ``World.bodies``, and instance id in every picture.
        name: for people, e.g. ``"target"``.
        category: ``ground``, ``building``, ``tree``, ``kerb``, ``vehicle`` …
        kind: of a vehicle its model, "" for what has none.
        mesh: its shape.
        movable: if False, the pose never changes, and renderers may cache the body.
    """

    index: int
    name: str
    category: str
    mesh: TexturedMesh
    movable: bool
    kind: str = ""


class World:
    """Bodies and their poses.

    Attributes:
        bodies: in the order in which they were added.
        original: the world that this one is a copy of, None for others.
    """

    def __init__(self) -> None:
        self._poses = np.empty((0, 4, 4))
        self.bodies: list[Body] = []
        self.original: World | None = None

    def copy(self) -> World:
        """Return a world with the same bodies, to which others are added; this one must stay as it is then.

        What renderers make of the shapes and textures of these bodies is made once for both.
        """
        made = World()
        made._poses, made.bodies, made.original = self._poses.copy(), list(self.bodies), self
        return made

    def add(
        self,
        mesh: TexturedMesh,
        T_world_body: NDArray[np.float64],
        *,
        name: str,
        category: str,
        movable: bool = False,
        kind: str = "",
    ) -> Body:
        """Add a body and return it."""
        body = Body(len(self.bodies), name, category, mesh, movable, kind)
        self.bodies.append(body)
        self._poses = np.concatenate([self._poses, np.asarray(T_world_body, dtype=float)[None]])
        return body

    def move(self, body: Body, T_world_body: NDArray[np.float64]) -> None:
        """Set the pose (4, 4) of a movable body."""
        self.move_all([body], np.asarray(T_world_body)[None])

    def move_all(self, bodies: Sequence[Body], T_world_body: NDArray[np.float64]) -> None:
        """Set the poses (B, 4, 4) of movable bodies.

        Raises:
            ValueError: for a body that was added with ``movable=False``.
        """
        for body in bodies:
            if not body.movable:
                raise ValueError(f"body: expected a movable one, got {body.name!r}, which was added with movable=False")
        self._poses[[body.index for body in bodies]] = T_world_body

    @property
    def poses(self) -> NDArray[np.float64]:
        """T_world_body of every body (B, 4, 4), in the order of ``bodies``; a view, not to be written to."""
        return self._poses
