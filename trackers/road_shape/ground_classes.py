"""Colour statistics of road and other ground, learnt from development towns by ``python -m tools learn-colours``."""

from __future__ import annotations

import json
from dataclasses import dataclass
from importlib import resources
from pathlib import Path

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True)
class ClassStatistics:
    """Colours of the two classes of paper A.3 that are defined by colour, in L lights of both together.

    Attributes:
        mean_rgb, variance_rgb: (L, 3), sRGB 0-255.
        of_road: (L,) True for road's, False for other's.
    """

    mean_rgb: NDArray[np.float64]
    variance_rgb: NDArray[np.float64]
    of_road: NDArray[np.bool_]


def load_class_statistics(model: str) -> ClassStatistics:
    """Read the statistics of a shipped model by its name, or of a file by its path ending in ``.json``.

    Raises:
        ValueError: if there is no such model.
    """
    bundled = resources.files(__package__).joinpath(f"{model}.json")
    file = Path(model) if model.endswith(".json") else bundled
    if not file.is_file():
        raise ValueError(f"class_model: expected a model's name or the path of a .json file, got {model!r}")
    classes = json.loads(file.read_text())["classes"]
    road, other = classes["road"], classes["other"]
    mean_rgb, variance_rgb = (
        np.array([light[key] for light in (*road, *other)]) for key in ("mean_rgb", "variance_rgb")
    )
    return ClassStatistics(mean_rgb, variance_rgb, np.arange(len(mean_rgb)) < len(road))
