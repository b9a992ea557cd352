"""Measures of an oriented box of a car's size in a picture: inside it, around it, and against a template."""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

ALONG, ACROSS = 12, 6
"""Samples inside the box, front to rear and left to right."""
INSIDE, AROUND, MISMATCH, MOVED, MOVED_AROUND, KNOWN, COVERED = range(7)
"""Columns of the measures: mean log-ratio of colour inside the box and around it, mean difference from the template,
mean difference from the known background inside the box and around it, share of the samples in the picture whose
background is known, and share of all samples in the picture.
"""
MEASURES = 7
UNKNOWN = 255
"""Difference from an unknown background; known differences are at most 254."""
_RING = 1.45
_LEAST_GAIN, _LARGEST_GAIN = 0.6, 1.6
_PLACES_INSIDE = np.array(
    [(1 - (2 * a + 1) / ALONG, (2 * b + 1) / ACROSS - 1) for a in range(ALONG) for b in range(ACROSS)]
)
"""Of the samples: shares of the box's half length towards the front, and of its half width towards the right."""
_PLACES_AROUND = np.array(
    [
        (_RING * a / (ALONG // 2), _RING * b / (ACROSS // 2))
        for a in range(-ALONG // 2, ALONG // 2 + 1)
        for b in range(-ACROSS // 2, ACROSS // 2 + 1)
        if abs(a) == ALONG // 2 or abs(b) == ACROSS // 2
    ]
)


@njit(cache=True, fastmath=True, error_model="numpy")
def sample_template(
    rgb: NDArray[np.uint8],
    centre: NDArray[np.float64],
    half_length: NDArray[np.float64],
    half_width: NDArray[np.float64],
) -> NDArray[np.float32]:
    """Return the colours (ALONG, ACROSS, 3) inside a box, bilinear; NaN outside the picture (H, W, 3).

    Args:
        centre: (2,) x and y, whole numbers at pixel centres. half_length, half_width: (2,) vectors from it to the
            front and to the right side.
    """
    height, width = rgb.shape[:2]
    result = np.empty((ALONG, ACROSS, 3), np.float32)
    for a in range(ALONG):
        for b in range(ACROSS):
            along, across = _PLACES_INSIDE[a * ACROSS + b, 0], _PLACES_INSIDE[a * ACROSS + b, 1]
            x = centre[0] + along * half_length[0] + across * half_width[0]
            y = centre[1] + along * half_length[1] + across * half_width[1]
            j, i = int(np.floor(x)), int(np.floor(y))
            if i < 0 or j < 0 or i >= height - 1 or j >= width - 1:
                result[a, b] = np.nan
                continue
            f, g = x - j, y - i
            for c in range(3):
                upper = (1 - f) * rgb[i, j, c] + f * rgb[i, j + 1, c]
                lower = (1 - f) * rgb[i + 1, j, c] + f * rgb[i + 1, j + 1, c]
                result[a, b, c] = (1 - g) * upper + g * lower
    return result


@njit(cache=True, fastmath=True, error_model="numpy")
def measure_box(
    rgb: NDArray[np.uint8],
    log_ratio: NDArray[np.float32],
    difference: NDArray[np.uint8],
    template: NDArray[np.float32],
    centre: NDArray[np.float64],
    half_length: NDArray[np.float64],
    half_width: NDArray[np.float64],
) -> NDArray[np.float64]:
    """Return the measures (MEASURES,) of a box.

    Inside: a grid of ALONG x ACROSS samples; around: a frame of samples at 1.45 times the box. ``MISMATCH = mean
    |I - T|`` over samples and colours, 8-bit levels, after the brightness of I is scaled to T's by a factor in [0.6,
    1.6]; the smaller one of T and T rotated by half a turn, as the axis does not give the heading.

    Args:
        rgb (H, W, 3), log_ratio (H, W), difference (H, W): picture, log-ratio of colour, difference from background.
        template: (ALONG, ACROSS, 3); all zero = none, and the mismatch is 0.
        centre, half_length, half_width: see ``sample_template``.
    """
    result = np.zeros(MEASURES)
    pixels = np.empty((len(_PLACES_INSIDE), 2), np.int64)
    _find_pixels(_PLACES_INSIDE, centre, half_length, half_width, log_ratio.shape, pixels)
    count, known, total, moved = _sums(log_ratio, difference, pixels)
    result[COVERED] = count / (ALONG * ACROSS)
    if count == 0:
        return result
    result[INSIDE], result[KNOWN], result[MOVED] = total / count, known / count, moved / max(known, 1)
    result[MISMATCH] = _mismatch(rgb, template, pixels) / (3 * count)
    pixels = pixels[: len(_PLACES_AROUND)]
    _find_pixels(_PLACES_AROUND, centre, half_length, half_width, log_ratio.shape, pixels)
    count, known, total, moved = _sums(log_ratio, difference, pixels)
    result[AROUND], result[MOVED_AROUND] = total / max(count, 1), moved / max(known, 1)
    return result


@njit(cache=True, fastmath=True, error_model="numpy")
def _find_pixels(
    places: NDArray[np.float64],
    centre: NDArray[np.float64],
    half_length: NDArray[np.float64],
    half_width: NDArray[np.float64],
    shape: tuple[int, int],
    pixels: NDArray[np.int64],
) -> None:
    """Write row and column (N, 2) of the pixels at places (N, 2) of a box, row -1 outside the picture."""
    for n in range(len(places)):
        along, across = places[n, 0], places[n, 1]
        j = int(np.floor(centre[0] + along * half_length[0] + across * half_width[0] + 0.5))
        i = int(np.floor(centre[1] + along * half_length[1] + across * half_width[1] + 0.5))
        is_outside = i < 0 or j < 0 or i >= shape[0] or j >= shape[1]
        pixels[n, 0], pixels[n, 1] = -1 if is_outside else i, j


@njit(cache=True, fastmath=True, error_model="numpy")
def _sums(
    log_ratio: NDArray[np.float32], difference: NDArray[np.uint8], pixels: NDArray[np.int64]
) -> tuple[int, int, float, float]:
    """Return the number of pixels (N, 2) inside the picture, and of those with known background, and the sums there of
    the log-ratio and of the difference from the background.
    """
    total, moved, known, count = 0.0, 0.0, 0, 0
    for n in range(len(pixels)):
        i, j = pixels[n, 0], pixels[n, 1]
        if i < 0:
            continue
        count += 1
        total += log_ratio[i, j]
        if difference[i, j] != UNKNOWN:
            known += 1
            moved += difference[i, j]
    return count, known, total, moved


@njit(cache=True, fastmath=True, error_model="numpy")
def _mismatch(rgb: NDArray[np.uint8], template: NDArray[np.float32], pixels: NDArray[np.int64]) -> float:
    """Return the sum of ``|I - T|``, see ``measure_box``, over pixels (ALONG ACROSS, 2) and colours."""
    picture_sum, template_sum = 1e-6, 1e-6
    for n in range(len(pixels)):
        i, j = pixels[n, 0], pixels[n, 1]
        if i < 0:
            continue
        for c in range(3):
            picture_sum += rgb[i, j, c]
            template_sum += template[n // ACROSS, n % ACROSS, c]
    if template_sum < 1.0:
        return 0.0
    gain = min(max(template_sum / picture_sum, _LEAST_GAIN), _LARGEST_GAIN)
    forth, back = 0.0, 0.0
    for n in range(len(pixels)):
        i, j = pixels[n, 0], pixels[n, 1]
        if i < 0:
            continue
        a, b = n // ACROSS, n % ACROSS
        for c in range(3):
            value = gain * rgb[i, j, c]
            forth += abs(value - template[a, b, c])
            back += abs(value - template[ALONG - 1 - a, ACROSS - 1 - b, c])
    return min(forth, back)


@njit(cache=True, fastmath=True, error_model="numpy")
def fit_box(
    rgb: NDArray[np.uint8],
    log_ratio: NDArray[np.float32],
    difference: NDArray[np.uint8],
    template: NDArray[np.float32],
    centre: NDArray[np.float64],
    pixels_per_metre: NDArray[np.float64],
    half_size_m: NDArray[np.float64],
    headings_rad: NDArray[np.float64],
    reach_px: int,
    merit: NDArray[np.float64],
) -> tuple[NDArray[np.float64], float, NDArray[np.float64]]:
    """Maximise ``merit . measures`` over place and heading of a box: a coarse grid, then decreasing steps.

    Args:
        centre: (2,) start. pixels_per_metre: (2, 2), map metres to picture pixels there.
        half_size_m: (2,) half length and half width of the car.
        headings_rad: (K,) of the grid, on the map. reach_px: of the grid to either side, in steps of 2.
        merit: (MEASURES,) weights.

    Returns:
        centre (2,), heading and measures (MEASURES,) of the best box.
    """
    best_merit = -1e9
    best_centre = centre.copy()
    best_heading = headings_rad[0]
    best = np.zeros(MEASURES)
    trial = np.empty(2)
    for heading in headings_rad:
        along, across = half_axes(pixels_per_metre, half_size_m, heading)
        for d_y in range(-reach_px, reach_px + 1, 2):
            for d_x in range(-reach_px, reach_px + 1, 2):
                trial[0], trial[1] = centre[0] + d_x, centre[1] + d_y
                measures = measure_box(rgb, log_ratio, difference, template, trial, along, across)
                value = np.dot(merit, measures)
                if value > best_merit:
                    best_merit, best_heading, best = value, heading, measures
                    best_centre[:] = trial
    turn, step = 0.13, 1.0
    for _ in range(3):
        improved = True
        rounds = 0
        while improved and rounds < 3:
            improved = False
            rounds += 1
            start_x, start_y, start_heading = best_centre[0], best_centre[1], best_heading
            for move in range(6):
                trial[0] = start_x + step * ((move == 0) - (move == 1))
                trial[1] = start_y + step * ((move == 2) - (move == 3))
                heading = start_heading + turn * ((move == 4) - (move == 5))
                along, across = half_axes(pixels_per_metre, half_size_m, heading)
                measures = measure_box(rgb, log_ratio, difference, template, trial, along, across)
                value = np.dot(merit, measures)
                if value > best_merit:
                    best_merit, best_heading, best = value, heading, measures
                    best_centre[:] = trial
                    improved = True
        turn, step = 0.5 * turn, 0.5 * step
    return best_centre, best_heading, best


@njit(cache=True)
def half_axes(
    pixels_per_metre: NDArray[np.float64], half_size_m: NDArray[np.float64], heading_rad: float
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return picture vectors from a car's centre to its front and to its right side."""
    c, s = np.cos(heading_rad), np.sin(heading_rad)
    along, across = np.empty(2), np.empty(2)
    for k in range(2):
        along[k] = half_size_m[0] * (pixels_per_metre[k, 0] * c + pixels_per_metre[k, 1] * s)
        across[k] = half_size_m[1] * (pixels_per_metre[k, 0] * s - pixels_per_metre[k, 1] * c)
    return along, across


@njit(cache=True)
def spot_axis(
    log_ratio: NDArray[np.float32],
    difference: NDArray[np.uint8],
    centre: NDArray[np.float64],
    radius_px: float,
    difference_worth: float,
) -> tuple[NDArray[np.float64], float]:
    """Return centre (2,) and axis (rad, from +x towards +y) of the spot around a pixel, by its moments.

    Each pixel within ``radius_px`` has the mass ``max(log-ratio, 0) + worth * difference``. The window is moved to the
    centre of mass twice. The axis is that of the larger second moment: ``tan 2a = 2 m_xy / (m_xx - m_yy)``.
    """
    height, width = log_ratio.shape
    x, y = centre[0], centre[1]
    angle = 0.0
    for _ in range(3):
        total, s_x, s_y, s_xx, s_xy, s_yy = 1e-9, 0.0, 0.0, 0.0, 0.0, 0.0
        for i in range(max(0, int(y - radius_px)), min(height, int(y + radius_px) + 2)):
            for j in range(max(0, int(x - radius_px)), min(width, int(x + radius_px) + 2)):
                d_x, d_y = j - x, i - y
                if d_x * d_x + d_y * d_y > radius_px * radius_px:
                    continue
                mass = max(log_ratio[i, j], 0.0)
                if difference[i, j] != UNKNOWN:
                    mass += difference_worth * difference[i, j]
                total += mass
                s_x += mass * d_x
                s_y += mass * d_y
                s_xx += mass * d_x * d_x
                s_xy += mass * d_x * d_y
                s_yy += mass * d_y * d_y
        m_x, m_y = s_x / total, s_y / total
        x, y = x + m_x, y + m_y
        angle = 0.5 * np.arctan2(2 * (s_xy / total - m_x * m_y), s_xx / total - m_x * m_x - s_yy / total + m_y * m_y)
    return np.array([x, y]), angle
