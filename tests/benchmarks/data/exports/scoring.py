"""Average precision of labels read from an export against the pixels of the truth, by pycocotools."""

from __future__ import annotations

import contextlib
import io
from collections.abc import Iterable
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

coco = pytest.importorskip("pycocotools.coco")
cocoeval = pytest.importorskip("pycocotools.cocoeval")

Box = tuple[str, int, NDArray[np.float64]]
"""Picture, class, and box (4,) as x_min, y_min, x_max, y_max."""


def average_precision(truth: Iterable[Box], found: Iterable[Box]) -> float:
    """Return the AP of boxes, mean over IoU thresholds from 0.5 to 0.95."""
    truth, found = list(truth), list(found)
    pictures = {name: k for k, name in enumerate(sorted({name for name, *_ in truth}), start=1)}
    entries = [[_entry(k, pictures, box) for k, box in enumerate(boxes, start=1)] for boxes in (truth, found)]
    read = coco.COCO()
    read.dataset = {
        "info": {},
        "images": [{"id": number} for number in pictures.values()],
        "categories": [{"id": number} for number in {number for _, number, _ in truth}],
        "annotations": entries[0],
    }
    return evaluated(read, entries[1], "bbox")


def evaluated(read: Any, found: list[dict[str, Any]], kind: str, sigmas: Any = None) -> float:
    """Return the AP of results against annotations; ``kind`` as pycocotools has it."""
    with contextlib.redirect_stdout(io.StringIO()):
        read.createIndex()
        scores = cocoeval.COCOeval(read, read.loadRes(found), kind)
        if sigmas is not None:
            scores.params.kpt_oks_sigmas = np.array(sigmas)
        scores.evaluate()
        scores.accumulate()
        scores.summarize()
    return float(scores.stats[0])


def _entry(number: int, pictures: dict[str, int], box: Box) -> dict[str, Any]:
    name, kind, (x_min, y_min, x_max, y_max) = box[0], box[1], box[2].tolist()
    xywh = [x_min, y_min, x_max - x_min, y_max - y_min]
    return {
        "id": number,
        "image_id": pictures[name],
        "category_id": kind,
        "bbox": xywh,
        "area": xywh[2] * xywh[3],
        "iscrowd": 0,
        "score": 1.0,
    }
