"""Lamps as a camera sees them: street lamps and the lights of cars, and their mirror images on a wet road.

A lamp of intensity I towards the camera, d away, fills less than a pixel. Its light ``I / d²`` falls on few pixels, and
lens and housing scatter a small share of it widely about.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from sim.optics import Camera
from sim.shaders.colour import black_body_rgb
from sim.shaders.ground_map import Footprint
from sim.shaders.specks import BLUE, COLUMNS, LONG, RED, SHORT, X, round_specks

_SPREAD = ((1.5, 0.93), (9.0, 0.05), (28.0, 0.02))
"""Radius in pixels of a lamp's picture, of its glow and of its wide glow, each with its share of the light, through a
lens of ``_SPREAD_AT_PX``."""
_SPREAD_AT_PX, _FAINTEST_NIT = 686.0, 0.012
UPWARD_SHARE = 0.02
"""Of a street lamp's greatest intensity that its bowl lets out above the horizon; none of modern flat ones."""
HEAD_STRAY_CD, HEAD_STRAIGHT_CD = 14.0, 240.0
"""Of a headlight above its beam: to the side and up, and ahead (UN Regulation 112 limits it to 625 cd)."""
TAIL_CD, BRAKE_CD = 8.0, 60.0
"""Of a rear lamp (UN Regulation 7: 4 to 17, and 60 to 260)."""
_SIDES = np.array([[[-1.0], [1.0]]])
_LEAST_SEEN = 0.22
"""Share of its intensity that a rear lamp sends straight up and to the side."""
_ROUGHNESS = 0.09
"""Slope of wet asphalt's film, by which a mirror image is spread."""
RED_RGB = np.array([4.2, 0.12, 0.05])
"""Colour of rear lamps, of luminance 1."""
HEAD_K = 5200.0


def street_lamp_specks(
    camera: Camera,
    T_world_camera: NDArray[np.float64],
    lamps_m: NDArray[np.float64],
    down_cd: NDArray[np.float64],
    rgb: NDArray[np.float64],
    *,
    wet: bool,
) -> NDArray[np.float32]:
    """Return the specks of street lamps at places (K, 3) of colour (3,), and below a wet road their mirror images."""
    tables = [_seen(camera, T_world_camera, lamps_m, UPWARD_SHARE * down_cd, rgb)]
    if wet:
        below_m = lamps_m * (1.0, 1.0, -1.0)
        away_m = np.linalg.norm(below_m - T_world_camera[:3, 3], axis=1)
        radius_px = np.maximum(camera.focal_px * _ROUGHNESS * 2.0 * lamps_m[:, 2] / away_m, 2.0)
        nit = _nit(camera, down_cd, away_m, radius_px)[:, None] * rgb
        tables.append(round_specks(camera, T_world_camera, below_m, radius_px, nit, mirrored=True))
    return np.concatenate(tables)


def car_light_specks(
    camera: Camera,
    T_world_camera: NDArray[np.float64],
    cars: list[Footprint],
    poses: NDArray[np.float64],
    braking: NDArray[np.bool_],
) -> NDArray[np.float32]:
    """Return the specks of head and rear lamps of cars at poses (K, 4, 4).

    Args:
        braking: (K,).
    """
    if not cars:
        return np.zeros((0, COLUMNS), np.float32)
    sizes_m = np.array([each[1:] for each in cars])
    height_m = np.minimum(0.45 * sizes_m[:, 2], 0.85)
    ends = np.stack([0.5 * sizes_m[:, 0] - 0.06, 0.04 - 0.5 * sizes_m[:, 0]])
    # Of both ends and sides of each car: (2, 2, K, 3).
    local = np.empty((2, 2, len(cars), 3))
    local[..., 0], local[..., 1], local[..., 2] = ends[:, None], 0.36 * _SIDES * sizes_m[:, 1], height_m
    places_m = np.einsum("kij,abkj->abki", poses[:, :3, :3], local) + poses[:, :3, 3]
    towards = T_world_camera[:3, 3] - places_m
    ahead = np.einsum("abkj,kj->abk", towards, poses[:, :3, 0]) / np.linalg.norm(towards, axis=-1)
    cd, rgb = np.empty(ahead.shape), np.empty(local.shape)
    cd[0] = HEAD_STRAY_CD + (HEAD_STRAIGHT_CD - HEAD_STRAY_CD) * np.maximum(ahead[0], 0.0) ** 2
    cd[1] = np.where(braking, BRAKE_CD, TAIL_CD) * np.maximum(-ahead[1], _LEAST_SEEN)
    rgb[0], rgb[1] = black_body_rgb(HEAD_K), RED_RGB
    return _seen(camera, T_world_camera, places_m.reshape(-1, 3), cd.ravel(), rgb.reshape(-1, 3))


def _seen(
    camera: Camera,
    T_world_camera: NDArray[np.float64],
    places_m: NDArray[np.float64],
    cd: NDArray[np.float64],
    rgb: NDArray[np.float64],
) -> NDArray[np.float32]:
    """Return the specks of lamps of intensities (K,), each in parts as ``_SPREAD`` has them."""
    away_m = np.linalg.norm(places_m - T_world_camera[:3, 3], axis=1)
    # A finer picture of the same view spreads the same light over more pixels.
    scale = camera.focal_px / _SPREAD_AT_PX
    sharp = round_specks(camera, T_world_camera, places_m, 1.0, np.broadcast_to(rgb, (len(cd), 3)) * cd[:, None])
    nit = _nit(camera, np.ones(len(cd)), away_m, np.ones(len(cd)))
    tables = []
    for radius, share in _SPREAD:
        table, radius_px = sharp.copy(), max(radius * scale, 1.2)
        table[:, LONG] = table[:, SHORT] = radius_px
        table[:, RED : BLUE + 1] *= (share * nit / radius_px**2)[:, None]
        tables.append(table[np.isfinite(table[:, X]) & (table[:, RED : BLUE + 1].max(axis=1) > _FAINTEST_NIT)])
    return np.concatenate(tables)


def _nit(
    camera: Camera, cd: NDArray[np.float64], away_m: NDArray[np.float64], radius_px: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Return the luminance (K,) in the middle of specks that together have the light of sources of that intensity.

    A pixel covers ``(d / f)²``; the weights of a speck add up to a third of its area.
    """
    return np.asarray(cd * (camera.focal_px / away_m) ** 2 / (np.pi / 3.0 * radius_px**2))
