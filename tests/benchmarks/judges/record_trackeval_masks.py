"""Records TrackEval's J and F of random masks in ``trackeval_masks.json``, which tests compare ours with.

TrackEval has them from the evaluation of DAVIS 2017. It is not a dependency, since it needs another OpenCV. In an
environment of its own, from the root of a checkout:

    pip install --no-deps trackeval==1.3.0
    pip install "numpy>=2.3.2" scipy scikit-image pycocotools opencv-python-headless
    python tests/benchmarks/judges/record_trackeval_masks.py
"""

from __future__ import annotations

import json
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

FILE = Path(__file__).with_name("trackeval_masks.json")
SEQUENCES = {
    "good": (1, (90, 120), 12, 1.0, 0.0),
    "drifting": (2, (90, 120), 17, 4.0, 0.0),
    "ragged": (3, (60, 80), 9, 1.0, 0.3),
    "wide tolerance": (4, (480, 640), 5, 6.0, 0.05),
    "a few frames": (5, (60, 80), 2, 2.0, 0.0),
    "not square": (6, (50, 200), 8, 3.0, 0.1),
}
"""Name to arguments of ``random_masks``."""

Masks = list[NDArray[np.bool_]]


def random_masks(seed: int, shape: tuple[int, int], frames: int, away_px: float, ragged: float) -> tuple[Masks, Masks]:
    """Return true masks, ellipses that move also to the border but are never empty, and a tracker's, some empty."""
    rng = np.random.default_rng(seed)
    rows, columns = np.indices(shape)
    middle, offset = 0.5 * np.array(shape), np.zeros(2)
    size = np.array(shape) * rng.uniform(0.1, 0.25, 2)
    true: Masks = []
    given: Masks = []
    for frame in range(frames):
        middle = np.clip(middle + rng.normal(0, 0.1, 2) * shape, 2, np.array(shape) - 3)
        offset = offset + rng.normal(0, away_px, 2)

        def ellipse(place: Any, axes: Any) -> NDArray[np.bool_]:
            inside: NDArray[np.bool_] = np.hypot((rows - place[0]) / axes[0], (columns - place[1]) / axes[1]) <= 1
            return inside

        true.append(ellipse(middle, size))
        shown = ellipse(middle + offset, size * rng.uniform(0.8, 1.2, 2)) ^ (
            (rng.random(shape) < 0.2 * ragged) & ellipse(middle, 1.5 * size)
        )
        given.append(shown & (frame % 7 != 3))
    return true, given


def _result(true: Masks, given: Masks) -> dict[str, float]:
    import trackeval
    from pycocotools import mask as coco

    def coded(masks: Masks) -> Any:
        return [[coco.encode(np.asfortranarray(each, np.uint8))] for each in masks]

    data = {
        "num_timesteps": len(true),
        "num_tracker_ids": 1,
        "num_gt_ids": 1,
        "gt_dets": coded(true),
        "tracker_dets": coded(given),
        "gt_ids": [[0]] * len(true),
        "tracker_ids": [[0]] * len(true),
    }
    result = trackeval.metrics.JAndF().eval_sequence(data)
    return {name: float(result[name]) for name in result if name != "num_gt_tracks"}


def main() -> None:
    """Write the file."""
    results = {name: _result(*random_masks(*how)) for name, how in SEQUENCES.items()}
    FILE.write_text(json.dumps({"trackeval": version("trackeval"), "results": results}, indent=1) + "\n")


if __name__ == "__main__":
    main()
