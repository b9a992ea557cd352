"""Marks on a picture: boxes, crosses, particles, arrows, text. Anti-aliased, readable on any ground.

All positions are in pixels, ``(x, y)`` from the top left corner, pixel centres at halves. Colours are RGB,
those of Okabe and Ito for colour-blind people.
"""

from __future__ import annotations

import colorsys
import functools

import cv2
import numpy as np
from numpy.typing import ArrayLike, NDArray

Image = NDArray[np.uint8]
Rgb = tuple[int, int, int]

TRUTH: Rgb = (86, 180, 233)
ESTIMATE: Rgb = (230, 159, 0)
PARTICLE: Rgb = (240, 228, 66)
OBSERVED: Rgb = (255, 255, 255)
HALO: Rgb = (16, 18, 22)
GROUND: Rgb = (24, 26, 31)
INK: Rgb = (236, 238, 242)
QUIET: Rgb = (150, 156, 166)
CALM: Rgb = (54, 58, 66)
"""Where nothing is to be seen on a time line."""

_LABEL_MARGIN_PX = 3
_POINTER_MARGIN_PX = 14.0
_LABEL_GROUND = 0.7
"""Opacity of the ground of a label."""
_SHIFT = 4
"""OpenCV draws at 1/16 pixel."""
_GOLDEN_TURN = 0.618034


def colour_of(identity: int) -> Rgb:
    """Return the colour of an identity; those of neighbouring numbers differ most."""
    red, green, blue = colorsys.hls_to_rgb((identity * _GOLDEN_TURN) % 1.0, 0.6, 0.95)
    return int(255 * red), int(255 * green), int(255 * blue)


def fixed_point(points_px: ArrayLike) -> NDArray[np.int32]:
    """Return points (..., 2) in OpenCV's fixed-point coordinates: pixel centres at whole numbers."""
    clipped = np.clip(np.asarray(points_px, dtype=float) - 0.5, -30_000.0, 30_000.0)
    return np.round(clipped * (1 << _SHIFT)).astype(np.int32)


def draw_lines(image: Image, lines_px: ArrayLike, colour: Rgb, stroke_px: int = 2) -> None:
    """Draw polylines (L, P, 2) with a dark halo."""
    lines = list(fixed_point(lines_px))
    halo_px = stroke_px + (2 if stroke_px > 1 else 1)
    cv2.polylines(image, lines, False, HALO, halo_px, cv2.LINE_AA, _SHIFT)
    cv2.polylines(image, lines, False, colour, stroke_px, cv2.LINE_AA, _SHIFT)


def draw_path(image: Image, places_px: NDArray[np.float64], colour: Rgb, stroke_px: int = 1) -> None:
    """Draw the way through places (K, 2); it is broken where they are not finite."""
    known = np.isfinite(places_px).all(axis=1)
    for piece in np.split(places_px, np.flatnonzero(~known)):
        line = piece[np.isfinite(piece).all(axis=1)]
        if len(line) > 1:
            draw_lines(image, [line], colour, stroke_px)


def draw_box(image: Image, box_xyxy: NDArray[np.float64], colour: Rgb, stroke_px: int = 2) -> None:
    """Draw the outline of a box; nothing where it is not finite."""
    if np.isfinite(box_xyxy).all():
        x0, y0, x1, y1 = box_xyxy
        draw_lines(image, [[(x0, y0), (x1, y0), (x1, y1), (x0, y1), (x0, y0)]], colour, stroke_px)


def draw_corners(image: Image, box_xyxy: NDArray[np.float64], colour: Rgb, stroke_px: int = 2) -> None:
    """Draw a box by its four corners alone; nothing where it is not finite."""
    if not np.isfinite(box_xyxy).all():
        return
    x0, y0, x1, y1 = box_xyxy
    ex, ey = 0.28 * (x1 - x0), 0.28 * (y1 - y0)
    corners = ((x0, y0, ex, ey), (x1, y0, -ex, ey), (x1, y1, -ex, -ey), (x0, y1, ex, -ey))
    draw_lines(image, [[(x + dx, y), (x, y), (x, y + dy)] for x, y, dx, dy in corners], colour, stroke_px)


def draw_cross(image: Image, centre_px: NDArray[np.float64], colour: Rgb, *, stroke_px: int = 2) -> None:
    """Draw an upright cross, open in the middle."""
    x, y = centre_px
    arm_px = 2.0 + 3.5 * stroke_px
    gap = 0.3 * arm_px
    arms = [(dx * s, dy * s) for dx, dy in ((1, 0), (0, 1)) for s in (-1, 1)]
    lines = [[(x + gap * a, y + gap * b), (x + arm_px * a, y + arm_px * b)] for a, b in arms]
    draw_lines(image, lines, colour, stroke_px)


def draw_particles(
    image: Image, points_px: NDArray[np.float64], weights: NDArray[np.float64] | None, colour: Rgb
) -> None:
    """Draw points (N, 2), larger with greater weight (N,); translucent, so that many look dense."""
    count = len(points_px)
    share = np.ones(count) if weights is None else np.asarray(weights) * count
    radius = np.clip(1.6 * np.sqrt(share), 0.7, 4.0)
    seen = np.isfinite(points_px).all(axis=1)
    layer = image.copy()
    for centre, size in zip(fixed_point(points_px[seen]), radius[seen], strict=True):
        cv2.circle(layer, centre, round(size * (1 << _SHIFT)), colour, -1, cv2.LINE_AA, _SHIFT)
    cv2.addWeighted(layer, 0.7, image, 0.3, 0.0, dst=image)


def draw_ellipse(image: Image, centre_px: NDArray[np.float64], covariance_px: NDArray[np.float64], colour: Rgb) -> None:
    """Draw a Gaussian's 95 % ellipse: squared Mahalanobis distance 5.991 (chi², 2 degrees of freedom)."""
    variances, axes = np.linalg.eigh(covariance_px)
    turn = np.linspace(0.0, 2.0 * np.pi, 73)
    circle = np.stack([np.cos(turn), np.sin(turn)], axis=1)
    radii = np.sqrt(5.991 * np.maximum(variances, 0.0))
    draw_lines(image, [centre_px + (circle * radii) @ axes.T], colour, 1)


def draw_pointer(image: Image, target_px: NDArray[np.float64], colour: Rgb) -> None:
    """Draw an arrow head at the border towards ``target_px`` (2,), if that lies outside the picture."""
    height, width = image.shape[:2]
    half = np.array([0.5 * width, 0.5 * height])
    direction = np.asarray(target_px, dtype=float) - half
    if not np.isfinite(direction).all() or (np.abs(direction) <= half).all():
        return
    tip = half + direction * np.min((half - _POINTER_MARGIN_PX) / np.maximum(np.abs(direction), 1e-9))
    ahead = 12.0 * direction / np.hypot(*direction)
    left = np.array([-ahead[1], ahead[0]])
    head = fixed_point([tip, tip - ahead + 0.6 * left, tip - ahead - 0.6 * left])
    cv2.polylines(image, [head], True, HALO, 4, cv2.LINE_AA, _SHIFT)
    cv2.fillPoly(image, [head], colour, cv2.LINE_AA, _SHIFT)


@functools.cache
def _font() -> cv2.FontFace:
    return cv2.FontFace("sans")


def draw_text(
    image: Image, at_px: tuple[int, int], text: str, colour: Rgb, *, size: int = 16, weight: int = 400
) -> int:
    """Write ``text`` with its baseline starting at ``at_px``; return the x where it ends."""
    end, _ = cv2.putText(image, text, at_px, colour, _font(), size, weight)
    return int(end[0])


def draw_label(
    image: Image, at_px: tuple[int, int], text: str, colour: Rgb, *, size: int = 16, weight: int = 400
) -> None:
    """Write text as ``draw_text`` does, on a dark patch: readable on any picture, whatever its colours."""
    x, y = at_px
    end = x + text_width_px(text, size=size, weight=weight)
    rows = slice(max(y - size, 0), max(y + round(0.3 * size), 0))
    patch = image[rows, max(x - _LABEL_MARGIN_PX, 0) : max(end + _LABEL_MARGIN_PX, 0)]
    patch[:] = ((1.0 - _LABEL_GROUND) * patch + _LABEL_GROUND * np.array(HALO)).astype(np.uint8)
    draw_text(image, at_px, text, colour, size=size, weight=weight)


def text_width_px(text: str, *, size: int = 16, weight: int = 400) -> int:
    """Return the width of the text of ``draw_text``."""
    return int(cv2.getTextSize((0, 0), text, (0, 0), _font(), size, weight)[2])


def shortened(text: str, width_px: float, *, size: int = 16) -> str:
    """Return the text with a gap in its middle, if it is wider than ``width_px``."""
    kept = len(text)
    shown = text
    while kept > 1 and text_width_px(shown, size=size) > width_px:
        kept -= 1
        shown = f"{text[: (kept + 1) // 2]}…{text[len(text) - kept // 2 :]}"
    return shown
