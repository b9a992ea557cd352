"""An upright box on a plane and the rectangle that it covers in the picture: measurement model of the tracks."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from trackers.site.view import SiteView

Array = NDArray[np.float64]

STATE = 7
"""x, y, velocity along both (metres, metres a second), logarithms of length, width and height (metres)."""

_CORNERS = np.array([[x, y, z] for x in (-0.5, 0.5) for y in (-0.5, 0.5) for z in (0.0, 1.0)])
_STEPS = np.diag([0.05, 0.05, 0.0, 0.0, 0.02, 0.02, 0.02])[[0, 1, 4, 5, 6]]


def rectangles(states: Array, heading_rad: float, base_m: float, roof: tuple[float, float], view: SiteView) -> Array:
    """Return the rectangles (N, 4) around the projected bodies of states (N, 7) that stand at height ``base_m``.

    A body has the box's base and, at its height, a smaller roof. NaN where a part is behind the camera.
    """
    c, s = np.cos(heading_rad), np.sin(heading_rad)
    corners = np.where(_CORNERS[:, 2:] > 0.0, _CORNERS * (*roof, 1.0), _CORNERS)
    corners_m = (corners * np.exp(states[:, None, 4:])) @ np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]])
    corners_m[..., :2] += states[:, None, :2]
    corners_m[..., 2] += base_m
    px = view.project(corners_m.reshape(-1, 3))[0].reshape(len(states), 8, 2)
    return np.concatenate([px.min(axis=1), px.max(axis=1)], axis=1)


def linearised(
    state: Array, heading_rad: float, base_m: float, roof: tuple[float, float], view: SiteView
) -> tuple[Array, Array]:
    """Return the rectangle (4,) of a state (7,), and its derivatives (4, 7) by differences."""
    boxes = rectangles(np.vstack([state, state + _STEPS]), heading_rad, base_m, roof, view)
    jacobian = np.zeros((4, STATE))
    jacobian[:, [0, 1, 4, 5, 6]] = (boxes[1:] - boxes[0]).T / _STEPS.max(axis=1)
    return boxes[0], jacobian
