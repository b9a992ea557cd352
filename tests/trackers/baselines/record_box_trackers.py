"""Records the tracks of the authors' SORT and ByteTrack in ``box_trackers.json``, which tests compare ours with.

Neither is a dependency: SORT is under the GPL and ByteTrack needs an old NumPy. Both run beside ours as they are, from
checkouts of their repositories, with the solver and the overlaps that they import (``lap``, ``cython_bbox``). What they
import for pictures and networks alone (matplotlib, scikit-image, OpenCV, PyTorch) is replaced by nothing. In an
environment of its own (Python 3.11), from the root of a checkout:

    pip install "numpy==1.23.5" "scipy==1.11.4" filterpy lap cython "setuptools<70" wheel
    pip install --no-build-isolation cython_bbox
    git clone https://github.com/abewley/sort
    git clone https://github.com/ifzhang/ByteTrack
    python -m tests.trackers.baselines.record_box_trackers sort ByteTrack

``cython_bbox`` takes boxes as first and last pixels, so that each is a pixel wider and higher. ByteTrack runs with it
(``pixels``) and with the overlaps of continuous boxes, as SORT's are (``continuous``).
"""

from __future__ import annotations

import json
import subprocess
import sys
from argparse import Namespace
from collections.abc import Callable, Iterator
from importlib import import_module
from pathlib import Path
from types import ModuleType
from typing import Any
from unittest.mock import MagicMock

import numpy as np
from numpy.typing import NDArray

FILE = Path(__file__).with_name("box_trackers.json")
SORT = {
    "published": {"least_overlap": 0.3, "max_age": 1, "min_hits": 3},
    "ours": {"least_overlap": 0.02, "max_age": 30, "min_hits": 1},
    "strict": {"least_overlap": 0.6, "max_age": 4, "min_hits": 2},
}
BYTETRACK = {
    "published": {"high": 0.6, "first_cost": 0.8, "buffer_frames": 30},
    "short": {"high": 0.5, "first_cost": 0.9, "buffer_frames": 3},
    "lenient": {"high": 0.7, "first_cost": 0.98, "buffer_frames": 8},
}
"""The program's other thresholds are written in its code."""
OVERLAPS = ("pixels", "continuous")
_WITHOUT = ("matplotlib", "matplotlib.pyplot", "matplotlib.patches", "skimage", "cv2")
_NETWORKS = ("torch", "torch.nn", "torch.nn.functional")

Boxes = list[list[list[float]]]
"""On each frame the x_min, y_min, x_max, y_max and score of each detection; no two scores of a frame are alike."""
Names = list[list[int]]
"""On each frame the identity of each detection, -1 for none."""


def random_boxes(seed: int, targets: int, frames: int, room_px: float, missed: float, weak: float) -> Boxes:
    """Return boxes of targets that cross, pause, change their size and are missed, with weak and false ones.

    The score of one lies at the published threshold at times.
    """
    rng = np.random.default_rng(seed)
    place, velocity = rng.uniform(0, room_px, (targets, 2)), rng.normal(0, 3.0, (targets, 2))
    size, pause = rng.uniform(14, 34, (targets, 2)), np.zeros(targets, int)
    hidden = np.zeros(targets, int)
    told = []
    for _ in range(frames):
        pause = np.where((pause == 0) & (rng.random(targets) < 0.05), rng.integers(3, 12, targets), pause - (pause > 0))
        hidden = np.where((hidden == 0) & (rng.random(targets) < missed), rng.integers(1, 12, targets), hidden - 1)
        hidden = np.maximum(hidden, 0)
        velocity = np.where((place < 0) | (place > room_px), -np.sign(place - room_px / 2) * abs(velocity), velocity)
        velocity = velocity + rng.normal(0, 0.4, velocity.shape)
        place = place + np.where(pause > 0, 0.0, 1.0)[:, None] * velocity
        size = np.clip(size * np.exp(rng.normal(0, 0.03, size.shape)), 10, 40)
        scores = np.where(rng.random(targets) < weak, rng.uniform(0.02, 0.75, targets), rng.uniform(0.6, 1.0, targets))
        if rng.random() < 0.2:
            scores[0] = BYTETRACK["published"]["high"]
        low = place - size / 2 + rng.normal(0, 0.8, place.shape)
        boxes = np.column_stack([low, low + size, scores])[hidden == 0]
        if rng.random() < 0.1:
            corner = rng.uniform(0, room_px, 2)
            boxes = np.vstack([boxes, [*corner, *(corner + rng.uniform(10, 30, 2)), rng.uniform(0.05, 1.0)]])
        if rng.random() < 0.03:
            boxes = boxes[:0]
        told.append(np.column_stack([boxes[:, :4].round(1), boxes[:, 4].round(4)]).tolist())
    return told


def sequences() -> dict[str, Boxes]:
    """Return the recorded sequences by name."""
    return {
        "crossing": random_boxes(1, 6, 70, 120.0, 0.02, 0.15),
        "crowd": random_boxes(2, 14, 40, 150.0, 0.04, 0.3),
        "often lost": random_boxes(3, 4, 110, 90.0, 0.12, 0.4),
        "in competition": random_boxes(23, 8, 70, 110.0, 0.12, 0.4),
    }


def renamed(names: Names) -> Names:
    """Return identities by the order in which they appear."""
    known = {-1: -1}
    return [[known.setdefault(each, len(known) - 1) for each in frame] for frame in names]


def _sort_of(module: Any, boxes: Boxes, least_overlap: float, max_age: int, min_hits: int) -> Names:
    class Seeing(module.KalmanBoxTracker):  # type: ignore[misc, name-defined]
        """Remembers which detection it took last: the fifth column, which the program ignores."""

        def __init__(self, bbox: NDArray[np.float64]) -> None:
            super().__init__(bbox)
            self.seen = int(bbox[4])

        def update(self, bbox: NDArray[np.float64]) -> None:
            super().update(bbox)
            self.seen = int(bbox[4])

    shipped, module.KalmanBoxTracker = module.KalmanBoxTracker, Seeing
    tracker = module.Sort(max_age, min_hits, least_overlap)
    told = []
    for frame in boxes:
        numbered = np.array([[*each[:4], place] for place, each in enumerate(frame)]).reshape(-1, 5)
        names = {int(row[4]) - 1 for row in tracker.update(numbered)}
        told.append(_by_detection(len(frame), ((each.seen, each.id) for each in tracker.trackers if each.id in names)))
    module.KalmanBoxTracker = shipped
    return renamed(told)


def _bytetrack_of(module: Any, boxes: Boxes, high: float, first_cost: float, buffer_frames: int) -> Names:
    thresholds = Namespace(track_thresh=high, match_thresh=first_cost, track_buffer=buffer_frames, mot20=False)
    tracker = module.BYTETracker(thresholds)
    told = []
    for frame in boxes:
        scores = [each[4] for each in frame]
        assert len(set(scores)) == len(scores)
        tracks = tracker.update(np.array(frame).reshape(-1, 5), (1, 1), (1, 1))
        told.append(_by_detection(len(frame), ((scores.index(each.score), each.track_id) for each in tracks)))
    return renamed(told)


def _by_detection(count: int, pairs: Iterator[tuple[int, int]]) -> list[int]:
    names = [-1] * count
    for place, name in pairs:
        names[place] = name
    return names


def _programs(sort: Path, bytetrack: Path) -> tuple[ModuleType, ModuleType, ModuleType]:
    """Return the modules of SORT and ByteTrack and the one of ByteTrack's overlaps."""
    sys.modules.update({name: MagicMock() for name in (*_WITHOUT, *_NETWORKS)})
    # The package's own first lines set up its networks.
    package = ModuleType("yolox")
    package.__path__ = [str(bytetrack / "yolox")]
    sys.modules["yolox"] = package
    sys.path.insert(0, str(sort))
    return import_module("sort"), import_module("yolox.tracker.byte_tracker"), import_module("yolox.tracker.matching")


def _commit(folder: Path) -> str:
    return subprocess.check_output(["git", "-C", str(folder), "rev-parse", "HEAD"], text=True).strip()


def main(sort: Path, bytetrack: Path) -> None:
    """Write the file."""
    sort_module, byte_module, matching = _programs(sort, bytetrack)
    overlaps: dict[str, Callable[..., Any]] = {"pixels": matching.bbox_ious, "continuous": sort_module.iou_batch}
    recorded: dict[str, Any] = {"commits": {"sort": _commit(sort), "bytetrack": _commit(bytetrack)}, "sequences": {}}
    for name, boxes in sequences().items():
        entry: dict[str, Any] = {"boxes": boxes}
        entry["sort"] = {key: _sort_of(sort_module, boxes, **each) for key, each in SORT.items()}
        for kind in OVERLAPS:
            matching.bbox_ious = overlaps[kind]
            entry[f"bytetrack, {kind}"] = {
                k: _bytetrack_of(byte_module, boxes, **each) for k, each in BYTETRACK.items()
            }
        recorded["sequences"][name] = entry
    FILE.write_text(json.dumps(recorded, separators=(",", ":")) + "\n")


if __name__ == "__main__":
    main(Path(sys.argv[1]), Path(sys.argv[2]))
