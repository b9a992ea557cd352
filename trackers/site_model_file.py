"""Files of what a tracker learnt of a site's background: arrays, and the camera that they hold for. No code in them."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from safetensors import SafetensorError, safe_open
from safetensors.numpy import save

from trackers.atomic_file import write_atomic
from trackers.site import SiteView

_FOCAL_TOLERANCE, _PLACE_TOLERANCE_M, _TURN_TOLERANCE_PX = 1e-3, 0.5, 2.0
"""A camera that was surveyed twice is the same one: half a metre moves no block of the background by half."""


class Form(NamedTuple):
    """What an array of a model must be.

    Attributes:
        dtype: name of the type of its numbers.
        shape: lengths of its sides. A name is a length that is free, and the same wherever the name occurs.
    """

    dtype: str
    shape: tuple[int | str, ...] = ()


def save_model(path: Path, kind: str, view: SiteView, arrays: Mapping[str, NDArray[Any]]) -> Path:
    """Write a background model, complete or not at all, and return ``path``, which gets the suffix ``.safetensors``.

    Args:
        kind: name and version of the model's form, e.g. the tracker's name; ``load_model`` expects the same.
        view: the camera whose pictures it was learnt from.
        arrays: what was learnt, by name.
    """
    camera = view.camera
    about = {
        "kind": kind,
        "band": camera.band,
        "width_px": camera.width_px,
        "height_px": camera.height_px,
        "focal_px": camera.focal_px,
        "T_world_camera": view.T_world_camera.tolist(),
    }
    path = path.with_suffix(".safetensors")
    tensors = {name: np.array(array, order="C") for name, array in arrays.items()}
    write_atomic(path, save(tensors, metadata={"model": json.dumps(about)}))
    return path


def load_model(path: Path, kind: str, view: SiteView, forms: Mapping[str, Form]) -> dict[str, NDArray[Any]]:
    """Return the arrays of a background model of this kind and this camera.

    Args:
        forms: of its arrays, by name.

    Raises:
        ValueError: for a file that cannot be read, a model of another kind, one of another camera: another band, size,
            focal length (by 0.1 %), place (by half a metre) or direction (by two pixels); and for other arrays than
            those of ``forms``.
    """
    path = path.with_suffix(".safetensors")
    try:
        with safe_open(path, framework="numpy") as file:
            about = json.loads((file.metadata() or {})["model"])
            arrays = {name: file.get_tensor(name) for name in file.keys()}  # noqa: SIM118 (it is no mapping)
        stored = about["kind"]
        pose = np.asarray(about["T_world_camera"], dtype=np.float64)
        differences = _differences(about, pose, view)
    except OSError as error:
        raise ValueError(f"model: expected a file that can be read, got {str(path)!r}: {error}") from None
    except (KeyError, TypeError, ValueError, SafetensorError) as error:
        raise ValueError(f"model: expected a background model, got {str(path)!r}: {error}") from None
    if stored != kind:
        raise ValueError(f"model: expected one of {kind}, got {str(path)!r}, one of {stored}")
    if differences:
        raise ValueError(f"model: expected one of this camera, got {str(path)!r}, of another: {'; '.join(differences)}")
    _check(arrays, forms, path)
    return arrays


def _check(arrays: Mapping[str, NDArray[Any]], forms: Mapping[str, Form], path: Path) -> None:
    if set(arrays) != set(forms):
        raise ValueError(f"model: expected the arrays {sorted(forms)}, got {str(path)!r} with {sorted(arrays)}")
    lengths: dict[str, int] = {}
    for name, (dtype, shape) in forms.items():
        array = arrays[name]
        for side, length in zip(shape, array.shape, strict=False):
            if isinstance(side, str):
                lengths.setdefault(side, length)
        expected = tuple(lengths.get(side, 0) if isinstance(side, str) else side for side in shape)
        if array.dtype != dtype or array.shape != expected:
            raise ValueError(
                f"model: expected {name} of {dtype} {expected}, got {str(path)!r} with {array.dtype} {array.shape}"
            )
        if array.dtype.kind == "f" and not np.isfinite(array).all():
            raise ValueError(f"model: expected finite numbers in {name}, got {str(path)!r} with others")


def _differences(about: Mapping[str, Any], pose: NDArray[np.float64], view: SiteView) -> list[str]:
    """Return in words how the camera of a model differs from ``view``."""
    camera, found = view.camera, []
    for name in ("band", "width_px", "height_px"):
        if about[name] != getattr(camera, name):
            found.append(f"{name} {getattr(camera, name)} here and {about[name]} there")
    if abs(about["focal_px"] / camera.focal_px - 1.0) > _FOCAL_TOLERANCE:
        found.append(f"focal_px {camera.focal_px:g} here and {about['focal_px']:g} there")
    away_m = float(np.linalg.norm(pose[:3, 3] - view.place_m))
    if not away_m <= _PLACE_TOLERANCE_M:
        found.append(f"place_m {away_m:.2f} m away")
    # The angle of a rotation R: 2 sin(angle / 2) = |R - 1| / sqrt(2).
    turn = pose[:3, :3].T @ view.T_world_camera[:3, :3] - np.eye(3)
    turned_rad = 2.0 * np.arcsin(min(float(np.linalg.norm(turn)) / np.sqrt(8.0), 1.0))
    if not turned_rad * camera.focal_px <= _TURN_TOLERANCE_PX:
        found.append(f"T_world_camera turned by {np.degrees(turned_rad):.2f} degrees")
    return found
