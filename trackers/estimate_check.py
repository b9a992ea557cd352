"""Checks of a tracker's answer, an estimate or the tracks of many targets, against its contract."""

from __future__ import annotations

from collections.abc import Sequence
from numbers import Integral

import numpy as np
from numpy.typing import NDArray

from trackers.types import Estimate, Track

_WEIGHT_TOLERANCE = 1e-3


def check_estimate(estimate: Estimate) -> None:
    """Raise ValueError, naming the field, what was expected and what came, if an estimate breaks its contract.

    A position of NaN is allowed: it means that there is no estimate. So are particles that are not finite, e.g. of
    points behind the camera.
    """
    if not isinstance(estimate, Estimate):
        raise ValueError(f"update: expected an Estimate, got {type(estimate).__name__}")
    position = _array("position_px", estimate.position_px, (2,))
    silent = bool(np.isnan(position).all())
    if not silent:
        _finite("position_px", position)
    if estimate.box_xyxy is not None:
        box = _array("box_xyxy", estimate.box_xyxy, (4,))
        if not silent:
            _finite("box_xyxy", box)
            if not (box[2:] >= box[:2]).all():
                raise ValueError(f"box_xyxy: expected x_min <= x_max and y_min <= y_max, got {box.tolist()}")
    if estimate.heading_rad is not None:
        heading = _array("heading_rad", estimate.heading_rad, ())
        if not silent:
            _finite("heading_rad", heading)
    if estimate.depth_m is not None:
        depth_m = float(_array("depth_m", estimate.depth_m, ()))
        if not silent and not 0.0 < depth_m < np.inf:
            raise ValueError(f"depth_m: expected a finite number > 0, got {depth_m}")
    if estimate.centre_line_px is not None:
        _array("centre_line_px", estimate.centre_line_px, (np.size(estimate.centre_line_px) // 2, 2))
    check_probability("in_view_probability", estimate.in_view_probability)
    _check_posterior(estimate, silent)


def check_tracks(tracks: Sequence[Track]) -> None:
    """Raise ValueError, naming the field, what was expected and what came, if tracks break their contract.

    There may be any number of them. A position of NaN means that the track has no estimate on this picture.
    """
    if not isinstance(tracks, Sequence) or isinstance(tracks, str):
        raise ValueError(f"update: expected a sequence of Tracks, got {type(tracks).__name__}")
    seen: set[int] = set()
    for track in tracks:
        if not isinstance(track, Track):
            raise ValueError(f"update: expected Tracks, got {type(track).__name__}")
        if not isinstance(track.identity, Integral) or isinstance(track.identity, bool) or track.identity < 0:
            raise ValueError(f"identity: expected a whole number >= 0, got {track.identity!r:.60}")
        if track.identity in seen:
            raise ValueError(f"identity: expected each once in an answer, got {track.identity} twice")
        seen.add(int(track.identity))
        check_estimate(track.estimate)
        if track.kind is not None and not isinstance(track.kind, str):
            raise ValueError(f"kind: expected a name or None, got {track.kind!r:.60}")
        if track.size_m is not None and not (_array("size_m", track.size_m, (3,)) > 0).all():
            raise ValueError(f"size_m: expected numbers > 0, got {np.asarray(track.size_m).tolist()}")
        check_probability("confidence", track.confidence)


def check_probability(name: str, value: float | None) -> None:
    """Raise ValueError, naming the field, for a number that is not in [0, 1]; None is allowed."""
    if value is not None and not 0.0 <= (probability := float(_array(name, value, ()))) <= 1.0:
        raise ValueError(f"{name}: expected a number from 0 to 1, got {probability}")


def _check_posterior(estimate: Estimate, silent: bool) -> None:
    if estimate.particles_px is not None:
        count = len(np.asarray(estimate.particles_px))
        if count == 0:
            raise ValueError("particles_px: expected at least one particle, got none")
        _array("particles_px", estimate.particles_px, (count, 2))
        if estimate.weights is not None:
            weights = _array("weights", estimate.weights, (count,))
            if not (weights >= 0).all() or abs(weights.sum() - 1.0) > _WEIGHT_TOLERANCE:
                raise ValueError(
                    f"weights: expected non-negative numbers with the sum 1, "
                    f"got the least {weights.min():.6g} and the sum {weights.sum():.6g}"
                )
    elif estimate.weights is not None:
        raise ValueError("weights: expected None without particles_px, got an array")
    if estimate.covariance_px is None:
        return
    covariance = _array("covariance_px", estimate.covariance_px, (2, 2))
    if not silent:
        _finite("covariance_px", covariance)
        scale = 1e-6 * max(float(np.abs(covariance).max()), 1e-12)
        if abs(covariance[0, 1] - covariance[1, 0]) > scale or np.linalg.eigvalsh(covariance)[0] < -scale:
            raise ValueError(
                f"covariance_px: expected a symmetric matrix without negative eigenvalues, got {covariance.tolist()}"
            )


def _array(name: str, value: object, shape: tuple[int, ...]) -> NDArray[np.float64]:
    try:
        array = np.asarray(value, dtype=float)
    except (TypeError, ValueError):
        raise ValueError(f"{name}: expected numbers of shape {shape}, got {value!r:.60}") from None
    if array.shape != shape:
        raise ValueError(f"{name}: expected the shape {shape}, got {array.shape}")
    return array


def _finite(name: str, array: NDArray[np.float64]) -> None:
    if not np.isfinite(array).all():
        raise ValueError(f"{name}: expected finite numbers, got {array.tolist()}")
