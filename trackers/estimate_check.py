"""Checks of a tracker's answer, an estimate or the tracks of many targets, against its contract.

What passes is returned with arrays of its own, and numbers as NumPy's: that is what is judged and kept. Of what popular
trackers answer, lists, tensors, NumPy's scalars, whole numbers as floats and generators of tracks are taken as well.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from trackers.regions import box_of_mask
from trackers.types import CameraModel, Estimate, Track

MOST_PARTICLES = 10_000
"""A posterior is judged by all pairs of its particles: of so many it takes a quarter of a second."""
_WEIGHT_TOLERANCE = 1e-3
_PROBABILITY_TOLERANCE = 1e-4
"""Rounding of a sum of single-precision numbers."""
_IDENTITIES = 2**63
_TRACKS = "a sequence of Tracks, () without any"


def check_estimate(estimate: Estimate, camera: CameraModel | None = None) -> Estimate:
    """Return an estimate with arrays of its own, see ``_array``, and with the box of its mask if it has none.

    A position of NaN is allowed: it means that there is no estimate. So are particles that are not finite, e.g. of
    points behind the camera. Without an estimate there is no mask.

    Args:
        camera: of the picture, which a mask must be as large as; None if it is not known.

    Raises:
        ValueError: if it breaks its contract; names the field, what was expected and what came.
    """
    if not isinstance(estimate, Estimate):
        expected = "an Estimate, with a position of NaN where there is none"
        raise ValueError(f"update: expected {expected}, got {_kind_of(estimate)}")
    position = _array("position_px", estimate.position_px, (2,))
    silent = all(map(math.isnan, position.tolist()))
    if not silent:
        _finite("position_px", position)
    mask = None if estimate.mask is None else _mask(estimate.mask, camera)
    mask = None if silent else mask
    box = estimate.box_xyxy if estimate.box_xyxy is not None or mask is None else box_of_mask(mask)
    return Estimate(
        position,
        box_xyxy=None if box is None else _box(box, silent),
        heading_rad=None if estimate.heading_rad is None else _heading_rad(estimate.heading_rad, silent),
        in_view_probability=check_probability("in_view_probability", estimate.in_view_probability),
        **_posterior(estimate, silent),
        depth_m=None if estimate.depth_m is None else _depth_m(estimate.depth_m, silent),
        centre_line_px=None if estimate.centre_line_px is None else _points("centre_line_px", estimate.centre_line_px),
        mask=mask,
    )


def check_tracks(tracks: Iterable[Track], camera: CameraModel | None = None) -> tuple[Track, ...]:
    """Return tracks with arrays of their own, see ``check_estimate``.

    There may be any number of them. A position of NaN means that the track has no estimate on this picture.

    Raises:
        ValueError: if they break their contract; names the field, what was expected and what came.
    """
    if not isinstance(tracks, Iterable) or isinstance(tracks, str | Mapping | np.ndarray):
        raise ValueError(f"update: expected {_TRACKS}, got {_kind_of(tracks)}")
    checked: dict[int, Track] = {}
    for track in tracks:
        if not isinstance(track, Track):
            raise ValueError(f"update: expected {_TRACKS}, got one of {_kind_of(track)}")
        identity = _identity(track.identity)
        if identity in checked:
            raise ValueError(f"identity: expected each once in an answer, got {identity} twice")
        if track.kind is not None and not isinstance(track.kind, str):
            raise ValueError(f"kind: expected a name or None, got {_in_words(track.kind)}")
        checked[identity] = Track(
            identity,
            check_estimate(track.estimate, camera),
            track.kind,
            None if track.size_m is None else _size_m(track.size_m),
            check_probability("confidence", track.confidence),
        )
    return tuple(checked.values())


def check_probability(name: str, value: float | None) -> float | None:
    """Return a number in [0, 1], or None. Raises ValueError, naming the field, for one further outside than rounding
    leads.
    """
    if value is None:
        return None
    probability = _number(name, value)
    if not -_PROBABILITY_TOLERANCE <= probability <= 1.0 + _PROBABILITY_TOLERANCE:
        raise ValueError(f"{name}: expected a number from 0 to 1, got {probability}")
    return min(max(probability, 0.0), 1.0)


def _identity(value: Any) -> int:
    try:
        identity = int(value)
        good = bool(identity == value) and not isinstance(value, bool | np.bool_)
    except (TypeError, ValueError, OverflowError):
        identity, good = -1, False
    if not (good and 0 <= identity < _IDENTITIES):
        unconfirmed = " (a track that is not confirmed yet is left out)" if good and identity < 0 else ""
        raise ValueError(f"identity: expected a whole number from 0 to 2^63 - 1{unconfirmed}, got {_in_words(value)}")
    return identity


def _box(value: Any, silent: bool) -> NDArray[np.float64]:
    box = _array("box_xyxy", value, (4,))
    if not silent:
        _finite("box_xyxy", box)
        x_min, y_min, x_max, y_max = box.tolist()
        if x_max < x_min or y_max < y_min:
            told = f"expected x_min <= x_max and y_min <= y_max, got {box.tolist()}"
            raise ValueError(f"box_xyxy: {told}; is it left, top, width, height?")
    return box


def _heading_rad(value: Any, silent: bool) -> float:
    heading_rad = _number("heading_rad", value)
    if not silent:
        _finite("heading_rad", np.asarray(heading_rad))
    return heading_rad


def _depth_m(value: Any, silent: bool) -> float:
    depth_m = _number("depth_m", value)
    if not silent and not 0.0 < depth_m < np.inf:
        raise ValueError(f"depth_m: expected a finite number > 0, got {depth_m}")
    return depth_m


def _size_m(value: Any) -> NDArray[np.float64]:
    size_m = _array("size_m", value, (3,))
    if not (size_m > 0).all():
        raise ValueError(f"size_m: expected numbers > 0, got {size_m.tolist()}")
    return size_m


def _mask(value: Any, camera: CameraModel | None) -> NDArray[np.bool_]:
    """Return a mask of bool; one of whole numbers has 0 and one other number, e.g. 255."""
    try:
        mask: NDArray[Any] = np.asarray(value.detach().cpu() if hasattr(value, "detach") else value)
    except Exception:
        mask = np.array("")
    if mask.dtype.kind not in "bui" or mask.ndim != 2:
        got = f"{mask.dtype} of shape {mask.shape}" if mask.ndim else _in_words(value)
        raise ValueError(f"mask: expected bool of shape (H, W), got {got}")
    if camera is not None and mask.shape != (camera.height_px, camera.width_px):
        raise ValueError(f"mask: expected the picture's shape {camera.height_px, camera.width_px}, got {mask.shape}")
    there = np.array(mask != 0)
    if mask.dtype.kind != "b" and there.any() and not (mask[there] == mask[there][0]).all():
        raise ValueError("mask: expected 0 and one other number, got several: it may be a map of identities")
    return there


def _posterior(estimate: Estimate, silent: bool) -> dict[str, NDArray[np.float64] | None]:
    """Return the fields of an estimate's posterior."""
    particles = weights = covariance = None
    if estimate.particles_px is not None:
        particles = _points("particles_px", estimate.particles_px)
        count = len(particles)
        if count == 0:
            raise ValueError("particles_px: expected at least one particle, got none")
        if count > MOST_PARTICLES:
            raise ValueError(f"particles_px: expected at most {MOST_PARTICLES:,} (thin them), got {count:,}")
        if estimate.weights is not None:
            weights = _array("weights", estimate.weights, (count,))
            if not weights.min() >= 0 or abs(weights.sum() - 1.0) > _WEIGHT_TOLERANCE:
                raise ValueError(
                    f"weights: expected non-negative numbers with the sum 1, "
                    f"got the least {weights.min():.6g} and the sum {weights.sum():.6g}"
                )
    elif estimate.weights is not None:
        raise ValueError("weights: expected None without particles_px, got an array")
    if estimate.covariance_px is not None:
        covariance = _array("covariance_px", estimate.covariance_px, (2, 2))
    if covariance is not None and not silent:
        _finite("covariance_px", covariance)
        scale = 1e-6 * max(float(np.abs(covariance).max()), 1e-12)
        if abs(covariance[0, 1] - covariance[1, 0]) > scale or np.linalg.eigvalsh(covariance)[0] < -scale:
            raise ValueError(
                f"covariance_px: expected a symmetric matrix without negative eigenvalues, got {covariance.tolist()}"
            )
    return {"particles_px": particles, "weights": weights, "covariance_px": covariance}


def _points(name: str, value: Any) -> NDArray[np.float64]:
    """Return points (N, 2)."""
    points = _copy(name, value, "numbers of shape (N, 2)")
    count = len(points) if points.ndim else 0
    return _of_shape(name, points, (count, 2)) if points.size else np.empty((0, 2))


def _number(name: str, value: Any) -> float:
    """Return a number: of single precision as it is, by which a judge calculates, of others as a float."""
    if isinstance(value, float):
        return float(value)
    number: Any = _array(name, value, ())[()]
    return number if number.dtype == np.float32 else float(number)  # type: ignore[no-any-return]


def _array(name: str, value: Any, shape: tuple[int, ...]) -> NDArray[np.float64]:
    return _of_shape(name, _copy(name, value, f"numbers of shape {shape}"), shape)


def _copy(name: str, value: Any, expected: str) -> NDArray[np.float64]:
    """Return a copy of numbers: of single precision as they are, others as float64."""
    try:
        # Of PyTorch: a tensor with a gradient is not an array.
        numbers: NDArray[Any] = np.asarray(value.detach().cpu() if hasattr(value, "detach") else value)
        if numbers.dtype.kind == "c":
            raise TypeError
        return numbers.astype(np.float32 if numbers.dtype == np.float32 else np.float64)
    except Exception:
        raise ValueError(f"{name}: expected {expected}, got {_in_words(value)}") from None


def _of_shape(name: str, array: NDArray[np.float64], shape: tuple[int, ...]) -> NDArray[np.float64]:
    if array.shape != shape:
        raise ValueError(f"{name}: expected the shape {shape}, got {array.shape}")
    return array


def _finite(name: str, array: NDArray[np.float64]) -> None:
    # Of so few numbers ``np.isfinite`` takes four times as long.
    if not all(map(math.isfinite, array.ravel().tolist())):
        raise ValueError(f"{name}: expected finite numbers, got {array.tolist()}")


def _in_words(value: Any) -> str:
    """Return a value as Python shows it, cut off after 60 characters, in one line; also one that cannot be shown."""
    try:
        shown = f"{value!r:.60}"
    except Exception:
        shown = f"a {type(value).__name__} that cannot be shown"
    return " ".join(shown.split())


def _kind_of(value: Any) -> str:
    """Return what a value is, in words."""
    shape = getattr(value, "shape", None)
    return "None" if value is None else type(value).__name__ + (f" of shape {tuple(shape)}" if shape else "")
