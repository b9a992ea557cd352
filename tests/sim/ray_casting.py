"""The world as trimesh sees it: rays against triangles, by other people's code."""

from __future__ import annotations

import numpy as np
import trimesh
from numpy.typing import NDArray

from sim.world import World


class RayCaster:
    """Casts rays against all bodies of a world where they are now."""

    def __init__(self, world: World) -> None:
        self._shapes = []
        for body, pose in zip(world.bodies, world.poses, strict=True):
            shape = trimesh.Trimesh(body.mesh.vertices_m, body.mesh.faces, process=False)
            shape.apply_transform(pose)
            self._shapes.append(shape)
        self._all = trimesh.util.concatenate(self._shapes)
        self._body_of_face = np.repeat(np.arange(len(self._shapes)), [len(s.faces) for s in self._shapes])

    def nearest(
        self, origins_m: NDArray[np.float64], directions: NDArray[np.float64], skip: tuple[int, ...] = ()
    ) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
        """Return distance in units of ``directions`` (N,), inf for none, and body (N,), -1 for none.

        Only faces that look towards the origin count, and no bodies in ``skip``.
        """
        rays = trimesh.ray.ray_triangle.RayMeshIntersector(self._all)
        faces, ray, points_m = rays.intersects_id(origins_m, directions, multiple_hits=True, return_locations=True)
        front = np.einsum("ij,ij->i", self._all.face_normals[faces], directions[ray]) < 0
        front &= ~np.isin(self._body_of_face[faces], skip)
        faces, ray, points_m = faces[front], ray[front], points_m[front]
        distance = np.einsum("ij,ij->i", points_m - origins_m[ray], directions[ray])
        distance /= np.einsum("ij,ij->i", directions[ray], directions[ray])
        nearest, body = np.full(len(origins_m), np.inf), np.full(len(origins_m), -1)
        for k in np.argsort(-distance):
            if distance[k] > 0:
                nearest[ray[k]], body[ray[k]] = distance[k], self._body_of_face[faces[k]]
        return nearest, body


def away_from_edges(instance_id: NDArray[np.int32], margin: int = 1) -> NDArray[np.bool_]:
    """Return (H, W): every pixel within ``margin`` shows the same body (those at the border are out)."""
    height, width = instance_id.shape
    inside = np.zeros((height, width), dtype=bool)
    middle = instance_id[margin : height - margin, margin : width - margin]
    same = np.ones(middle.shape, dtype=bool)
    for row in range(2 * margin + 1):
        for column in range(2 * margin + 1):
            same &= instance_id[row : row + middle.shape[0], column : column + middle.shape[1]] == middle
    inside[margin : height - margin, margin : width - margin] = same
    return inside
