"""Truth computed from geometry and G-buffer after the picture is drawn: boxes, visibility, flow, ground motion.

A (3, 4) matrix ``[A | t]`` takes a surface point, given as its pixel and nearness ``(u, v, 1, 1 / depth)`` now, to
``q`` with pixel ``(q_x, q_y) / q_w`` at the other instant. With ``D = A - I`` and ``r = D (u, v, 1) + t / depth``
(so ``q = (u, v, 1) + r``), the displacement is computed without cancellation in 32 bits:

    flow = (r_x - u r_w, r_y - v r_w) / (1 + r_w)

Labels do not depend on light; both renderers give the same ones up to their sampling of pixels.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import lru_cache
from typing import NamedTuple, Protocol

import numpy as np
from numba import njit
from numpy.typing import NDArray
from scipy.spatial import ConvexHull

from sim.mesh import TexturedMesh
from sim.optics import Camera, intrinsic_matrix, invert_pose

FAST = {"contract", "arcp", "nsz"}
ONE, HALF = np.float32(1.0), np.float32(0.5)


@njit(cache=True)
def flow_picture(
    depth_m: NDArray[np.float32],
    instance_id: NDArray[np.int32],
    at_rest: NDArray[np.float32],
    moved: NDArray[np.bool_],
    matrices: NDArray[np.float32],
    flow: NDArray[np.float32],
) -> None:
    """Write the flow (H, W, 2) of a picture; NaN where depth is inf or q_w <= 0.

    Args:
        at_rest: ``[D | t]`` (3, 4) of bodies that did not move.
        moved: (B,) whether each body moved.
        matrices: (B, 3, 4), ``[D | t]`` of those that did.
    """
    width = depth_m.shape[1]
    x_flow, y_flow = np.empty(width, np.float32), np.empty(width, np.float32)
    lowest_moved = moved.shape[0]
    for body in range(moved.shape[0] - 1, -1, -1):
        if moved[body]:
            lowest_moved = body
    for row in range(depth_m.shape[0]):
        _flow_along(at_rest, 0, row, depth_m[row], x_flow)
        _flow_along(at_rest, 1, row, depth_m[row], y_flow)
        # Movers mostly come after what stands, and most rows show none.
        if _greatest(instance_id[row]) >= lowest_moved:
            _flow_of_moved(depth_m[row], instance_id[row], moved, matrices, row, x_flow, y_flow)
        _interleave(x_flow, y_flow, flow[row])


@njit(cache=True)
def _greatest(values: NDArray[np.int32]) -> np.int32:
    greatest = np.int32(-1)
    for k in range(values.shape[0]):
        greatest = max(greatest, values[k])
    return greatest


@njit(cache=True, forceinline=True, fastmath=FAST, error_model="numpy")
def _flow_along(
    matrix: NDArray[np.float32], axis: int, row: int, depth_m: NDArray[np.float32], flow: NDArray[np.float32]
) -> None:
    v = np.float32(row) + HALF
    a, b, t = matrix[axis, 0], matrix[axis, 1] * v + matrix[axis, 2], matrix[axis, 3]
    w_a, w_b, w_t = matrix[2, 0], matrix[2, 1] * v + matrix[2, 2], matrix[2, 3]
    along_u, constant = (ONE, np.float32(0.0)) if axis == 0 else (np.float32(0.0), v)
    nothing, infinity = np.float32(np.nan), np.float32(np.inf)
    for k in range(depth_m.shape[0]):
        u = np.float32(np.int32(k)) + HALF
        nearness = ONE / depth_m[k]
        r_w = w_a * u + w_b + w_t * nearness
        r = a * u + b + t * nearness
        value = (r - (along_u * u + constant) * r_w) / (ONE + r_w)
        flow[k] = value if depth_m[k] < infinity and r_w > -ONE else nothing


@njit(cache=True, error_model="numpy")
def _flow_of_moved(
    depth_m: NDArray[np.float32],
    instance_id: NDArray[np.int32],
    moved: NDArray[np.bool_],
    matrices: NDArray[np.float32],
    row: int,
    x_flow: NDArray[np.float32],
    y_flow: NDArray[np.float32],
) -> None:
    v = np.float32(row) + HALF
    for k in range(instance_id.shape[0]):
        body = instance_id[k]
        if body < 0 or not moved[body]:
            continue
        m = matrices[body]
        u, nearness = np.float32(k) + HALF, ONE / depth_m[k]
        r_x = m[0, 0] * u + m[0, 1] * v + m[0, 2] + m[0, 3] * nearness
        r_y = m[1, 0] * u + m[1, 1] * v + m[1, 2] + m[1, 3] * nearness
        r_w = m[2, 0] * u + m[2, 1] * v + m[2, 2] + m[2, 3] * nearness
        seen = r_w > -ONE
        x_flow[k] = (r_x - u * r_w) / (ONE + r_w) if seen else np.nan
        y_flow[k] = (r_y - v * r_w) / (ONE + r_w) if seen else np.nan


@njit(cache=True)
def _interleave(x_flow: NDArray[np.float32], y_flow: NDArray[np.float32], flow: NDArray[np.float32]) -> None:
    for k in range(x_flow.shape[0]):
        flow[k, 0] = x_flow[k]
        flow[k, 1] = y_flow[k]


class SeenSurfaces(Protocol):
    """Maps of a picture that labels need; ``GBuffer`` and ``Capture`` have them."""

    @property
    def depth_m(self) -> NDArray[np.float32]:
        """(H, W), see ``GBuffer``."""
        ...

    @property
    def instance_id(self) -> NDArray[np.int32]:
        """(H, W), see ``GBuffer``."""
        ...


def amodal_box(
    camera: Camera, T_world_camera: NDArray[np.float64], mesh: TexturedMesh, T_world_body: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Return the box (4,) around all of a body's vertices in the unbounded picture.

    NaN if any vertex is not in front of the camera.
    """
    view = body_view(camera.focal_px, 0.5 * camera.width_px, 0.5 * camera.height_px, T_world_camera, T_world_body)
    return _box(mesh.vertices_m, view)


class Outline(NamedTuple):
    """The vertices of several bodies that can bound their boxes, one body after the other.

    Attributes:
        vertices_m: (V, 3) float32, each in its body's frame.
        first: (B + 1,) where each body's share begins.
    """

    vertices_m: NDArray[np.float32]
    first: NDArray[np.int64]


def outline(meshes: Sequence[TexturedMesh]) -> Outline:
    """Return the vertices that ``amodal_boxes`` needs, a tenth of a car's."""
    parts = [_outermost(mesh) for mesh in meshes]
    return Outline(np.concatenate(parts), np.cumsum([0] + [len(part) for part in parts]))


_SURELY_INSIDE_M = 1e-3


@lru_cache(maxsize=256)
def _outermost(mesh: TexturedMesh) -> NDArray[np.float32]:
    """Return the vertices (n, 3) on the convex hull, each once, and those so near it that rounding may decide."""
    vertices_m = np.unique(mesh.vertices_m, axis=0)
    planes = ConvexHull(vertices_m.astype(float)).equations
    outside_m = (vertices_m @ planes[:, :3].T + planes[:, 3]).max(axis=1)
    return vertices_m[outside_m > -_SURELY_INSIDE_M]


def amodal_boxes(
    camera: Camera, T_world_camera: NDArray[np.float64], bodies: Outline, T_world_body: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Return the ``amodal_box`` of each of B bodies (B, 4), by their poses (B, 4, 4)."""
    boxes = np.empty((len(T_world_body), 4))
    focal_px, centre_x, centre_y = camera.focal_px, 0.5 * camera.width_px, 0.5 * camera.height_px
    _boxes(bodies, focal_px, centre_x, centre_y, T_world_camera, T_world_body, boxes)
    return boxes


def visible_fraction(
    seen: SeenSurfaces,
    camera: Camera,
    T_world_camera: NDArray[np.float64],
    mesh: TexturedMesh,
    T_world_body: NDArray[np.float64],
    instance_id: int,
    box_xyxy: NDArray[np.float64],
    *,
    pixel_offset: float = 0.5,
) -> float:
    """Return the share of a body's own pixels, drawn alone on an unbounded picture, that are seen in this one (0-1).

    0 for a body that reaches behind the camera.

    Args:
        box_xyxy: the body's ``amodal_box`` (4,).
        pixel_offset: where in a pixel ``seen`` was sampled.
    """
    left, top, right, bottom = box_xyxy.tolist()
    # Comparisons with NaN are false.
    if not (right > 0 and bottom > 0 and left < camera.width_px and top < camera.height_px):
        return 0.0
    x, y = math.floor(left), math.floor(top)
    width, height = math.ceil(right) - x + 1, math.ceil(bottom) - y + 1
    centre_x, centre_y = 0.5 * camera.width_px - x - pixel_offset, 0.5 * camera.height_px - y - pixel_offset
    view = body_view(camera.focal_px, centre_x, centre_y, T_world_camera, T_world_body)
    alone = _pixels_alone(mesh.vertices_m, mesh.faces, view, height, width)
    window = seen.instance_id[max(y, 0) : y + height, max(x, 0) : x + width]
    return min(1.0, np.count_nonzero(window == instance_id) / max(alone, 1))


@njit(cache=True)
def _pixels_alone(
    vertices_m: NDArray[np.float32], faces: NDArray[np.int32], view: NDArray[np.float64], height: int, width: int
) -> int:
    """Return how many samples of a picture (``height``, ``width``) a body before the camera covers."""
    pixels, covered = np.empty((len(vertices_m), 2)), np.zeros((height, width), np.bool_)
    for n in range(len(vertices_m)):
        x, y, z = vertices_m[n]
        w = view[2, 0] * x + view[2, 1] * y + view[2, 2] * z + view[2, 3]
        for axis in range(2):
            pixels[n, axis] = (view[axis, 0] * x + view[axis, 1] * y + view[axis, 2] * z + view[axis, 3]) / w
    cover(pixels, faces, covered)
    return int(np.count_nonzero(covered))


@njit(cache=True)
def seen_ids(instance_map: NDArray[np.int32], count: int) -> NDArray[np.bool_]:
    """Return which of the ids 0 to ``count`` - 1 a map (H, W) shows (``count``,)."""
    is_seen = np.zeros(count, np.bool_)
    before = np.int32(-1)
    for row in range(instance_map.shape[0]):
        for column in range(instance_map.shape[1]):
            here = instance_map[row, column]
            if here != before:
                before = here
                if here >= 0:
                    is_seen[here] = True
    return is_seen


@njit(cache=True)
def bright_fractions(
    image_rgb: NDArray[np.uint8], instance_map: NDArray[np.int32], instance_id: NDArray[np.int64], level: int
) -> NDArray[np.float64]:
    """Return the share of each object's pixels (N,) whose channels are all at least ``level``; 0 without pixels.

    Args:
        image_rgb: (H, W, 3). instance_map: (H, W). instance_id: (N,).
    """
    first, last = instance_id.min(), instance_id.max()
    counts = np.zeros((last - first + 1, 2))
    for row in range(instance_map.shape[0]):
        for column in range(instance_map.shape[1]):
            here = instance_map[row, column]
            if here >= first and here <= last:
                counts[here - first, 0] += 1
                red, green, blue = image_rgb[row, column]
                counts[here - first, 1] += min(red, green, blue) >= level
    own = counts[instance_id - first]
    return own[:, 1] / np.maximum(own[:, 0], 1.0)


def pixels_from_ground(camera: Camera, T_world_camera: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return ``K [r1 r2 t]`` (3, 3): from a ground point (x, y, 1), z = 0, to its homogeneous pixel."""
    R_camera_world = T_world_camera[:3, :3].T
    columns = np.empty((3, 3))
    columns[:, :2], columns[:, 2] = R_camera_world[:, :2], -R_camera_world @ T_world_camera[:3, 3]
    return intrinsic_matrix(camera) @ columns


def ground_homography(before: NDArray[np.float64], after: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return H (3, 3), scaled to H[2, 2] = 1, that takes pixels of ground points from one picture to another.

    Args:
        before, after: ``pixels_from_ground`` of the two.
    """
    H = after @ np.linalg.inv(before)
    return H / H[2, 2]


def backward_flow(
    seen: SeenSurfaces,
    camera: Camera,
    T_world_camera: NDArray[np.float64],
    T_world_camera_before: NDArray[np.float64],
    body_poses: NDArray[np.float64],
    body_poses_before: NDArray[np.float64],
) -> NDArray[np.float32]:
    """Return where each pixel's surface point lay in the picture before, minus where it lies now.

    Args:
        body_poses, body_poses_before: T_world_body (B, 4, 4) of all bodies at both instants.

    Returns:
        (H, W, 2) float32 pixels; NaN for sky and for points that were behind the camera.
    """
    K = intrinsic_matrix(camera)
    to_world = T_world_camera @ _homogeneous(np.linalg.inv(K).astype(float))
    from_world = _homogeneous(K) @ invert_pose(T_world_camera_before)
    moved = (body_poses != body_poses_before).any(axis=(1, 2))
    # The inverse of all rigid poses at once.
    now, before = body_poses[moved], body_poses_before[moved]
    R_back = now[:, :3, :3].transpose(0, 2, 1)
    motion = np.zeros_like(now)
    motion[:, :3, :3] = before[:, :3, :3] @ R_back
    motion[:, :3, 3] = before[:, :3, 3] - (motion[:, :3, :3] @ now[:, :3, 3, None])[..., 0]
    motion[:, 3, 3] = 1.0
    matrices = np.zeros((len(body_poses), 3, 4), dtype=np.float32)
    matrices[moved] = (from_world @ motion @ to_world - np.eye(4))[:, :3]
    at_rest = _less_identity(from_world @ to_world).astype(np.float32)
    flow = np.empty((*seen.depth_m.shape, 2), np.float32)
    flow_picture(seen.depth_m, seen.instance_id, at_rest, moved, matrices, flow)
    return flow


def _homogeneous(matrix: NDArray[np.float64]) -> NDArray[np.float64]:
    whole = np.eye(4)
    whole[:3, :3] = matrix
    return whole


def _less_identity(matrix: NDArray[np.float64]) -> NDArray[np.float64]:
    return (matrix - np.eye(4))[:3]


@njit(cache=True)
def body_view(
    focal_px: float,
    centre_x: float,
    centre_y: float,
    T_world_camera: NDArray[np.float64],
    T_world_body: NDArray[np.float64],
) -> NDArray[np.float64]:
    """Return ``K [R_cw | -R_cw c] T_world_body`` (3, 4): from a body's frame to homogeneous pixels."""
    view = np.zeros((3, 4))
    for k in range(4):
        x = y = z = 0.0
        for j in range(3):
            away = T_world_body[j, k] - (T_world_camera[j, 3] if k == 3 else 0.0)
            x += T_world_camera[j, 0] * away
            y += T_world_camera[j, 1] * away
            z += T_world_camera[j, 2] * away
        view[0, k] = focal_px * x + centre_x * z
        view[1, k] = focal_px * y + centre_y * z
        view[2, k] = z
    return view


@njit(cache=True)
def _boxes(
    bodies: Outline,
    focal_px: float,
    centre_x: float,
    centre_y: float,
    T_world_camera: NDArray[np.float64],
    T_world_body: NDArray[np.float64],
    boxes: NDArray[np.float64],
) -> None:
    for n in range(boxes.shape[0]):
        view = body_view(focal_px, centre_x, centre_y, T_world_camera, T_world_body[n])
        boxes[n] = _box(bodies.vertices_m[bodies.first[n] : bodies.first[n + 1]], view)


@njit(cache=True)
def _box(vertices_m: NDArray[np.float32], view: NDArray[np.float64]) -> NDArray[np.float64]:
    """Bounds of π(view (p, 1)) over all vertices p (n, 3); NaN if one has a depth that is not positive."""
    box = np.array([np.inf, np.inf, -np.inf, -np.inf])
    for n in range(vertices_m.shape[0]):
        x, y, z = vertices_m[n]
        w = view[2, 0] * x + view[2, 1] * y + view[2, 2] * z + view[2, 3]
        if w <= 1e-6:
            return np.full(4, np.nan)
        for axis in range(2):
            pixel = (view[axis, 0] * x + view[axis, 1] * y + view[axis, 2] * z + view[axis, 3]) / w
            box[axis] = min(box[axis], pixel)
            box[axis + 2] = max(box[axis + 2], pixel)
    return box


@njit(cache=True, error_model="numpy")
def cover(pixels: NDArray[np.float64], faces: NDArray[np.int32], covered: NDArray[np.bool_]) -> None:
    """Set each sample (column, row) that lies in a triangle that faces the camera.

    The picture's y grows downwards, so a front face is clockwise there: going round it, sides that go up have the
    inside on their right and sides that go down on their left, and at row y the side from a to b is at column
    ``a_x + (y - a_y) (b_x - a_x) / (b_y - a_y)``. Level sides bound no row.
    """
    rows, columns = covered.shape
    for face in range(faces.shape[0]):
        i, j, k = faces[face, 0], faces[face, 1], faces[face, 2]
        ax, ay, bx, by, cx, cy = pixels[i, 0], pixels[i, 1], pixels[j, 0], pixels[j, 1], pixels[k, 0], pixels[k, 1]
        if (bx - ax) * (cy - ay) - (by - ay) * (cx - ax) >= 0.0:
            continue
        first, last = max(int(np.ceil(min(ay, by, cy))), 0), min(int(np.floor(max(ay, by, cy))), rows - 1)
        if first > last:
            continue
        ab, bc, ca = (bx - ax) / (by - ay), (cx - bx) / (cy - by), (ax - cx) / (ay - cy)
        for y in range(first, last + 1):
            left, right = 0.0, columns - 1.0
            if by != ay:
                x = ax + (y - ay) * ab
                left, right = (left, min(right, x)) if by < ay else (max(left, x), right)
            if cy != by:
                x = bx + (y - by) * bc
                left, right = (left, min(right, x)) if cy < by else (max(left, x), right)
            if ay != cy:
                x = cx + (y - cy) * ca
                left, right = (left, min(right, x)) if ay < cy else (max(left, x), right)
            for column in range(int(np.ceil(left)), int(np.floor(right)) + 1):
                covered[y, column] = True
