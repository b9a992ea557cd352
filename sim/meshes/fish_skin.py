"""Textures of fish: a dark back, stripes along paler flanks, spots, a pale belly; fins and eyes."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter

from sim.mesh import Texture
from sim.meshes.fish_look import FishLook

HEIGHT_TEXELS, WIDTH_TEXELS = 96, 24
_BODY_TEXELS = 64
"""Rows of the skin, from snout to tail; columns go from the middle of the back down to that of the belly. Both sides of
a fish are alike, so that there is no seam on its back."""
_FIN_ROWS, _EYE_ROWS = (68, 82), (82, 96)

FIN_UV = (0.5, (_FIN_ROWS[0] + _FIN_ROWS[1]) / 2 / HEIGHT_TEXELS)
EYE_UV = (0.5, (_EYE_ROWS[0] + _EYE_ROWS[1]) / 2 / HEIGHT_TEXELS)
"""Where fins and eyes have their one colour."""

_EYE_RGB = (22, 21, 20)
_STRIPES_RAD = np.deg2rad([42.0, 75.0, 108.0])
"""Azimuths of the stripes from the middle of the back."""


def body_uv(share: NDArray[np.float64], y: NDArray[np.float64], z: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the place (V, 2) in the texture of points on the skin.

    Args:
        share: (V,) behind the snout, in lengths. y, z: (V,) to the left of and above the axis.
    """
    u = np.abs(np.arctan2(y, z)) / np.pi
    v = np.clip(share, 0.0, 1.0) * (_BODY_TEXELS / HEIGHT_TEXELS)
    return np.column_stack([u, v])


def paint(look: FishLook, rng: np.random.Generator) -> Texture:
    """Return a fish's texture.

    Args:
        rng: of the mottling.
    """
    picture = np.empty((HEIGHT_TEXELS, WIDTH_TEXELS, 3))
    picture[:] = look.fin_rgb
    picture[:_BODY_TEXELS] = _skin(look, rng)
    picture[_BODY_TEXELS : _FIN_ROWS[0]] = picture[_BODY_TEXELS - 1]
    picture[_EYE_ROWS[0] :] = _EYE_RGB
    return Texture(np.clip(picture + 0.5, 0, 255).astype(np.uint8), smooth=True)


def _skin(look: FishLook, rng: np.random.Generator) -> NDArray[np.float64]:
    share = ((np.arange(_BODY_TEXELS) + 0.5) / _BODY_TEXELS)[:, None]
    azimuth = (np.pi * (np.arange(WIDTH_TEXELS) + 0.5) / WIDTH_TEXELS)[None]
    back, flank = np.array(look.back_rgb, dtype=float), np.array(look.flank_rgb, dtype=float)
    # The dark of the back reaches farther down on the head.
    edge = np.deg2rad(38.0) + np.deg2rad(30.0) * np.clip((0.2 - share) / 0.08, 0.0, 1.0)
    dark = 1.0 / (1.0 + np.exp((azimuth - edge) / np.deg2rad(9.0)))
    colour = flank + (back - flank) * dark[..., None]
    belly = np.clip((azimuth - np.deg2rad(120.0)) / np.deg2rad(30.0), 0.0, 1.0)
    colour += (230.0 - colour) * (0.6 * belly * np.ones_like(share))[..., None]
    lines = sum(np.exp(-0.5 * ((azimuth - at) / np.deg2rad(8.0)) ** 2) for at in _STRIPES_RAD)
    behind_gills = np.clip((share - 0.2) / 0.04, 0.0, 1.0)
    shade = 1.0 - 0.7 * look.stripes * lines * behind_gills
    for place, darkness in look.spots:
        shade = shade * (1.0 - darkness * np.exp(-0.5 * ((share - place) / 0.018) ** 2 - 0.5 * (azimuth / 0.5) ** 2))
    # A pale edge of the gills, and mottling.
    shade = shade * (1.0 + 0.18 * np.exp(-0.5 * ((share - 0.2) / 0.012) ** 2))
    mottling = gaussian_filter(rng.normal(size=colour.shape[:2]), 1.2, mode="nearest")
    return colour * (shade * (1.0 + 0.05 * mottling / mottling.std()))[..., None]
