"""What a detector of cars has to find in a frame, and the average precision (AP) of what it finds, by COCO's tools."""

from __future__ import annotations

import io
from collections.abc import Iterable, Sequence
from contextlib import redirect_stdout
from typing import Any

import numpy as np
from numpy.typing import NDArray
from pycocotools.coco import COCO
from pycocotools.cocoeval import COCOeval

from benchmarks.data.sets.tables import visible_boxes
from scenarios.scenario import Frame
from sim.meshes.vehicle import class_of

LEAST_VISIBLE = 0.5

Boxes = NDArray[np.floating[Any]]
"""(N, 5): x_min, y_min, x_max, y_max in pixels, and a number."""


def cars_seen(frame: Frame) -> Boxes:
    """Return the boxes around the visible pixels of all cars of towns that have any, parked ones too, but no lorries.

    The number is 1 for a car that counts: ``LEAST_VISIBLE`` of its pixels are visible (``Truth.visible_fraction``),
    the others hidden or beyond the border. Of other cars it is 0.
    """
    truth = frame.truth
    boxes = visible_boxes(truth.instance_map, np.concatenate([truth.instance_id, truth.standing_id]))
    counts = np.concatenate([truth.visible_fraction, truth.standing_visible_fraction]) >= LEAST_VISIBLE
    kinds = (*truth.kinds, *truth.standing_kinds)
    is_car = np.array([kind not in truth.passing and class_of(kind) == "car" for kind in kinds], np.bool_)
    return np.column_stack([boxes, counts])[np.isfinite(boxes[:, 0]) & is_car]


def average_precision(pictures: Iterable[tuple[Boxes, Boxes]], least_iou: float = 0.5) -> float:
    """Return the AP over pictures: the mean precision over recalls 0, 0.01 … 1; -1 if no box of the truth counts.

    Args:
        pictures: of each the truth, as ``cars_seen`` has it, and what was found, of which the number is the score. It
            is neither right nor wrong to find a car that does not count. The best 100 are judged.
        least_iou: overlap (intersection over union) from which on a box is found.
    """
    truth, found = zip(*pictures, strict=True)
    with redirect_stdout(io.StringIO()):
        scores = COCOeval(_coco(truth), _coco(found), "bbox")
        scores.params.iouThrs = np.array([least_iou])
        scores.evaluate()
        scores.accumulate()
    precision = scores.eval["precision"]  # by IoU, recall, class, range of areas, and number of detections
    return float(precision[0, :, 0, 0, -1].mean())


def _coco(pictures: Sequence[Boxes]) -> COCO:
    coco, boxes = COCO(), [(k, *box) for k, each in enumerate(pictures) for box in each.tolist()]
    coco.dataset = {
        "images": [{"id": k} for k in range(len(pictures))],
        "categories": [{"id": 1}],
        "annotations": [_annotation(number, *box) for number, box in enumerate(boxes, start=1)],
    }
    coco.createIndex()
    return coco


def _annotation(number: int, picture: int, x0: float, y0: float, x1: float, y1: float, last: float) -> dict[str, Any]:
    """Return a box for COCO, where ``iscrowd`` marks truth that is neither right nor wrong to find."""
    width, height = x1 - x0, y1 - y0
    box = {"bbox": [x0, y0, width, height], "area": width * height, "score": last, "iscrowd": int(last == 0)}
    return {"id": number, "image_id": picture, "category_id": 1, **box}
