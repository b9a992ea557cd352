"""The kernels of ``sim.labels.backward_flow``.

A (3, 4) matrix ``[A | t]`` takes a surface point, given as its pixel and nearness ``(u, v, 1, 1 / depth)`` now, to
``q`` with pixel ``(q_x, q_y) / q_w`` at the other instant. With ``D = A - I`` and ``r = D (u, v, 1) + t / depth``
(so ``q = (u, v, 1) + r``), the displacement is computed without cancellation in 32 bits:

    flow = (r_x - u r_w, r_y - v r_w) / (1 + r_w)
"""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

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


@njit(cache=True, fastmath=FAST, error_model="numpy")
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
