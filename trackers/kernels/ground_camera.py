"""A camera over flat ground: its pose, and the homographies between the ground map and the picture.

The *map* is the ground plane in metres, with x and y of the first camera's world. Without a measured pose the first
view is assumed to be straight down. If it was tilted, the map is a projective image of the true ground:
``g = m / (1 - a x - b y)``, to first order ``(a, b) = tilt / height``. ``bend = (a, b)`` is constant during a flight;
its estimate makes the fit exact for any first view.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np
from numba import njit
from numpy.typing import NDArray

from trackers.types import CameraModel

CENTRE_HEIGHT_M = 0.7
"""Height above ground of the middle of a car, the reference point of boxes and truth."""
TYPICAL_LENGTH_M = 4.5
"""Of a car."""
CAR_HEIGHT_M = 1.5
_LEAST_CAR_PX, _LARGEST_CAR = 1.0, 4.0
"""Shortest car that can be followed, in pixels, and longest, in sides of the picture."""


@dataclass(frozen=True, slots=True, eq=False)
class GroundCamera:
    """Camera model and pose at one instant.

    Attributes:
        model: intrinsics.
        T_world_camera: (4, 4), camera x right, y down, z forward; world z up, ground at z = 0.
        bend: (2,) a and b above, 1 / m.
    """

    model: CameraModel
    T_world_camera: NDArray[np.float64]
    bend: NDArray[np.float64]
    _computed: dict[tuple[str, float], NDArray[np.float64]] = field(default_factory=dict, init=False, repr=False)

    def H_picture_map(self, height_m: float = 0.0) -> NDArray[np.float64]:
        """Return the homography (3, 3) from map points, raised to ``height_m``, to pixels."""
        H = self._computed.get(("picture", height_m))
        if H is None:
            R, C = self.T_world_camera[:3, :3], self.T_world_camera[:3, 3]
            plane = np.column_stack([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [-C[0], -C[1], height_m - C[2]]])
            H = self._computed["picture", height_m] = self._intrinsic_matrix() @ R.T @ plane @ self._unbend()
        return H

    def H_map_picture(self, height_m: float = 0.0) -> NDArray[np.float64]:
        """Return the inverse homography (3, 3), with a positive denominator in front of the camera."""
        H = self._computed.get(("map", height_m))
        if H is None:
            H = np.asarray(np.linalg.inv(self.H_picture_map(height_m)), dtype=np.float64)
            # The inverse's sign is free.
            centre = np.array([0.5 * self.model.width_px, 0.5 * self.model.height_px, 1.0])
            H = self._computed["map", height_m] = H if H[2] @ centre >= 0 else -H
        return H

    def to_picture(self, map_m: NDArray[np.float64], height_m: float = 0.0) -> NDArray[np.float64]:
        """Return pixels (N, 2) of map points (N, 2) at ``height_m`` above ground."""
        return apply_homography(self.H_picture_map(height_m), np.ascontiguousarray(map_m, dtype=float))

    def to_map(self, pixels: NDArray[np.float64], height_m: float = 0.0) -> NDArray[np.float64]:
        """Return map points (N, 2) at ``height_m`` above ground seen at pixels (N, 2); NaN above the horizon."""
        return apply_homography(self.H_map_picture(height_m), np.ascontiguousarray(pixels, dtype=float))

    def footprint_m(self) -> NDArray[np.float64]:
        """Return the map points (4, 2) at the picture's corners, clockwise from the top left."""
        width, height = self.model.width_px, self.model.height_px
        return self.to_map(np.array([[0.0, 0.0], [width, 0.0], [width, height], [0.0, height]]))

    def shows_ground(self, pixel: NDArray[np.float64] | None = None) -> bool:
        """Return whether a pixel (2,), by default the middle one, shows ground on which a car has a visible size.

        False for a pose that is not finite or below the roofs of cars, and at or above the horizon.
        """
        if not (np.isfinite(self.T_world_camera).all() and np.isfinite(self.bend).all()):
            return False
        if self.T_world_camera[2, 3] < CAR_HEIGHT_M:
            return False
        metres_per_pixel = self.metres_per_pixel(pixel)
        largest_px = _LARGEST_CAR * max(self.model.width_px, self.model.height_px)
        return _LEAST_CAR_PX * metres_per_pixel < TYPICAL_LENGTH_M < largest_px * metres_per_pixel

    def metres_per_pixel(self, pixel: NDArray[np.float64] | None = None) -> float:
        """Return the side of the ground covered by a pixel (2,), by default the middle one; NaN above the horizon."""
        centre = np.array([0.5 * self.model.width_px, 0.5 * self.model.height_px]) if pixel is None else pixel
        across = self.to_map(centre + np.array([[-5.0, 0.0], [5.0, 0.0], [0.0, -5.0], [0.0, 5.0]]))
        return float(np.sqrt(np.linalg.norm(across[1] - across[0]) * np.linalg.norm(across[3] - across[2])) / 10.0)

    def moved(self, step: NDArray[np.float64]) -> GroundCamera:
        """Return the camera rotated by ``step[:3]`` (rad, own frame), shifted by ``step[3:6]`` (m, world), and with
        ``step[6:8]`` (1 / m) added to the bend.
        """
        T = self.T_world_camera.copy()
        T[:3, :3] = T[:3, :3] @ rotation_matrix(step[:3])
        T[:3, 3] += step[3:6]
        return replace(self, T_world_camera=T, bend=self.bend + step[6:8])

    def derivatives(self) -> NDArray[np.float64]:
        """Return d H_picture_map / d step at step = 0, (8, 3, 3), in the order of ``moved``."""
        R, C = self.T_world_camera[:3, :3], self.T_world_camera[:3, 3]
        K, unbend = self._intrinsic_matrix(), self._unbend()
        seen = R.T @ np.column_stack([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], -C])
        result = np.zeros((8, 3, 3))
        for axis in range(3):
            result[axis] = -K @ _cross_matrix(axis) @ seen @ unbend
            shift = np.zeros((3, 3))
            shift[axis, 2] = -1.0
            result[3 + axis] = K @ R.T @ shift @ unbend
        for axis in range(2):
            result[6 + axis, :, axis] = -(K @ seen)[:, 2]
        return result

    def _intrinsic_matrix(self) -> NDArray[np.float64]:
        m = self.model
        return np.array([[m.focal_px, 0.0, 0.5 * m.width_px], [0.0, m.focal_px, 0.5 * m.height_px], [0.0, 0.0, 1.0]])

    def _unbend(self) -> NDArray[np.float64]:
        return np.array([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [-self.bend[0], -self.bend[1], 1.0]])


@dataclass(frozen=True, slots=True)
class Fit:
    """Outcome of ``fit_pose``.

    Attributes:
        camera: the fitted camera.
        information: (8, 8) of the data at the fit, in the order of ``GroundCamera.moved``.
        support: sum of the robust weights, the effective number of points.
    """

    camera: GroundCamera
    information: NDArray[np.float64]
    support: float


def fit_pose(
    camera: GroundCamera,
    map_m: NDArray[np.float64],
    pixels: NDArray[np.float64],
    prior_information: NDArray[np.float64],
    scales_px: tuple[float, ...],
) -> Fit:
    """Fit pose and bend robustly, so that ``map_m`` (N, 2) appear at ``pixels`` (N, 2).

    Gauss-Newton from ``camera``, which is also the mean of a Gaussian prior with ``prior_information`` (8, 8). The
    robust scale decreases through ``scales_px``, which removes houses (above the plane) and cars.
    """
    moved_so_far = np.zeros(8)
    start = camera
    for scale_px in scales_px:
        A, b, support = robust_normal_equations(camera.H_picture_map(), camera.derivatives(), map_m, pixels, scale_px)
        step = np.asarray(np.linalg.solve(A + prior_information, b - prior_information @ moved_so_far), np.float64)
        moved_so_far = moved_so_far + step
        camera = camera.moved(step)
    # Small rotations do not add up exactly, but the prior needs only their sum.
    return Fit(replace(camera, bend=start.bend + moved_so_far[6:8]), A, support)


def looking_down(model: CameraModel, metres_per_pixel: float) -> GroundCamera:
    """Return a camera that looks straight down on the map's origin, its x axis along that of the map."""
    T = np.diag([1.0, -1.0, -1.0, 1.0])
    T[2, 3] = model.focal_px * metres_per_pixel
    return GroundCamera(model, T, np.zeros(2))


def rotation_matrix(rotation_rad: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the rotation matrix (3, 3) of a rotation vector (3,), by Rodrigues' formula."""
    angle = float(np.linalg.norm(rotation_rad))
    W = sum(rotation_rad[axis] * _cross_matrix(axis) for axis in range(3))
    if angle < 1e-12:
        return np.eye(3) + W
    return np.eye(3) + np.sin(angle) / angle * W + (1 - np.cos(angle)) / angle**2 * W @ W


def _cross_matrix(axis: int) -> NDArray[np.float64]:
    """Return the generator of rotations about one axis: ``_cross_matrix(k) @ v = e_k x v``."""
    matrix = np.zeros((3, 3))
    i, j = (axis + 1) % 3, (axis + 2) % 3
    matrix[j, i], matrix[i, j] = 1.0, -1.0
    return matrix


@njit(cache=True)
def apply_homography(H: NDArray[np.float64], points: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return ``(h_1 . p, h_2 . p) / (h_3 . p)`` (N, 2), p = (x, y, 1), of points (N, 2); NaN where h_3 . p <= 0."""
    result = np.empty((points.shape[0], 2))
    for i in range(points.shape[0]):
        x, y = points[i, 0], points[i, 1]
        w = H[2, 0] * x + H[2, 1] * y + H[2, 2]
        if w > 1e-9:
            result[i, 0] = (H[0, 0] * x + H[0, 1] * y + H[0, 2]) / w
            result[i, 1] = (H[1, 0] * x + H[1, 1] * y + H[1, 2]) / w
        else:
            result[i] = np.nan
    return result


@njit(cache=True)
def robust_normal_equations(
    H: NDArray[np.float64],
    H_derivatives: NDArray[np.float64],
    points: NDArray[np.float64],
    pixels: NDArray[np.float64],
    scale_px: float,
) -> tuple[NDArray[np.float64], NDArray[np.float64], float]:
    """Sum the weighted normal equations of ``pixels ~ H points`` for the parameters of H.

    ``r_i = z_i - pi(H p_i)``, ``J_i = d pi(H p_i) / d parameters``, Geman-McClure weight
    ``w_i = (1 + |r_i|^2 / s^2)^-2``:  ``A = sum w J^T J / s^2``,  ``b = sum w J^T r / s^2``.

    Args:
        H: (3, 3) plane to pixels.
        H_derivatives: (P, 3, 3) of H by each parameter.
        points, pixels: (N, 2) each; rows with NaN are left out.
        scale_px: s, residual at which a point has lost three quarters of its weight.

    Returns:
        A (P, P), b (P,) and the sum of weights.
    """
    count = H_derivatives.shape[0]
    A = np.zeros((count, count))
    b = np.zeros(count)
    total = 0.0
    j_u = np.empty(count)
    j_v = np.empty(count)
    inverse_variance = 1.0 / (scale_px * scale_px)
    for i in range(points.shape[0]):
        x, y = points[i, 0], points[i, 1]
        w = H[2, 0] * x + H[2, 1] * y + H[2, 2]
        if not w > 1e-9:
            continue
        u = (H[0, 0] * x + H[0, 1] * y + H[0, 2]) / w
        v = (H[1, 0] * x + H[1, 1] * y + H[1, 2]) / w
        r_u = pixels[i, 0] - u
        r_v = pixels[i, 1] - v
        square = (r_u * r_u + r_v * r_v) * inverse_variance
        if not square < 1e6:
            continue
        weight = 1.0 / ((1.0 + square) * (1.0 + square))
        total += weight
        for p in range(count):
            D = H_derivatives[p]
            d_w = D[2, 0] * x + D[2, 1] * y + D[2, 2]
            j_u[p] = (D[0, 0] * x + D[0, 1] * y + D[0, 2] - u * d_w) / w
            j_v[p] = (D[1, 0] * x + D[1, 1] * y + D[1, 2] - v * d_w) / w
        for p in range(count):
            b[p] += weight * inverse_variance * (j_u[p] * r_u + j_v[p] * r_v)
            for q in range(count):
                A[p, q] += weight * inverse_variance * (j_u[p] * j_u[q] + j_v[p] * j_v[q])
    return A, b, total
