"""Textured pictures that can be sampled anywhere, so that a target's true place is known to any fraction of a pixel."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

Texture = Callable[[NDArray[np.float64], NDArray[np.float64]], NDArray[np.float64]]


def texture(seed: int, finest_px: float, coarsest_px: float) -> Texture:
    """Return colours (..., 3), 0 to 1, as a function of x and y in pixels: 12 waves of random direction and length."""
    rng = np.random.default_rng(seed)
    lengths_px = np.exp(rng.uniform(np.log(finest_px), np.log(coarsest_px), 12))
    angles, phases = rng.uniform(0, 2 * np.pi, (2, 12))
    colours = rng.normal(size=(12, 3))
    waves = 2 * np.pi / lengths_px * np.stack([np.cos(angles), np.sin(angles)])

    def at(x: NDArray[np.float64], y: NDArray[np.float64]) -> NDArray[np.float64]:
        signals = np.sin(x[..., None] * waves[0] + y[..., None] * waves[1] + phases)
        return 0.5 + 0.5 * np.tanh(signals @ colours / 3)

    return at


def picture(
    centre_px: tuple[float, float],
    size_px: tuple[float, float],
    *,
    seed: int = 0,
    shape: tuple[int, int] = (160, 200),
    scale: float = 1.0,
    is_hidden: bool = False,
) -> NDArray[np.uint8]:
    """Return a picture (H, W, 3) of a target of a size in front of a background, which ``scale`` makes larger.

    The target's middle is at ``centre_px``; all is sampled twice a pixel in each direction.
    """
    target, ground = texture(seed, 5, 25), texture(seed + 1000, 8, 60)
    rows, columns = shape
    y, x = ((np.arange(2 * side) + 0.5) / 2 for side in (rows, columns))
    x, y = np.meshgrid(x, y)
    colours = ground(x / scale, y / scale)
    u, v = (x - centre_px[0]) / scale, (y - centre_px[1]) / scale
    on = (np.abs(u) <= 0.5 * size_px[0]) & (np.abs(v) <= 0.5 * size_px[1]) & (not is_hidden)
    colours[on] = target(u[on], v[on])
    mean = colours.reshape(rows, 2, columns, 2, 3).mean((1, 3))
    return np.rint(255 * mean).astype(np.uint8)
