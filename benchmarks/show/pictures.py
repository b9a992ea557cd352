"""Pictures in the result folder, embedded in the report: ``pictures/NAME.jpg`` with its text in ``NAME.json``."""

from __future__ import annotations

import base64
import json
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from benchmarks.contract.suite import Condition
from trackers.atomic_file import write_atomic

FOLDER_NAME = "pictures"


@dataclass(frozen=True, slots=True)
class Picture:
    """A picture as the page shows it.

    Attributes:
        condition: of its section.
        title, caption: text. source: data URL of the picture.
        width_px, height_px: its size.
    """

    condition: Condition
    title: str
    caption: str
    source: str
    width_px: int
    height_px: int


def write_picture(
    directory: Path,
    name: str,
    image_rgb: NDArray[np.uint8],
    condition: Condition,
    title: str,
    caption: str,
    made_from: str,
) -> None:
    """Write a picture (H, W, 3) and its text, both atomically.

    ``made_from`` identifies the rows that it shows, to detect changes.
    """
    folder = directory / FOLDER_NAME
    folder.mkdir(parents=True, exist_ok=True)
    _, encoded = cv2.imencode(".jpg", image_rgb[..., ::-1], [cv2.IMWRITE_JPEG_QUALITY, 86])
    write_atomic(folder / f"{name}.jpg", encoded.tobytes())
    words = {
        "condition": condition,
        "title": title,
        "caption": caption,
        "made_from": made_from,
        "width_px": image_rgb.shape[1],
        "height_px": image_rgb.shape[0],
    }
    write_atomic(folder / f"{name}.json", json.dumps(words, indent=1) + "\n")


def made_from(directory: Path, name: str) -> str | None:
    """Return ``made_from`` of the picture ``name``, None if there is none."""
    path = directory / FOLDER_NAME / f"{name}.json"
    return json.loads(path.read_text())["made_from"] if path.is_file() else None


def remove_picture(directory: Path, name: str) -> None:
    """Remove a picture, text first; nothing if there is none."""
    for suffix in (".json", ".jpg"):
        (directory / FOLDER_NAME / f"{name}{suffix}").unlink(missing_ok=True)


def read_pictures(directory: Path) -> list[Picture]:
    """Return the pictures of a result directory, in order of their names."""
    return [_read(path) for path in sorted((directory / FOLDER_NAME).glob("*.json"))]


def _read(path: Path) -> Picture:
    words = json.loads(path.read_text())
    data = base64.b64encode(path.with_suffix(".jpg").read_bytes()).decode()
    condition: Sequence[str] = words["condition"]
    return Picture(
        condition=(condition[0], condition[1], condition[2], condition[3], condition[4]),
        title=words["title"],
        caption=words["caption"],
        source=f"data:image/jpeg;base64,{data}",
        width_px=words["width_px"],
        height_px=words["height_px"],
    )
