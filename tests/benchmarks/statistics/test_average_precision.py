"""Average precision: exact on small cases, and the same as by pycocotools."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from benchmarks.contract.metric import Quantity
from benchmarks.contract.rows import Row
from benchmarks.statistics import average_precision, froc
from benchmarks.statistics.pooling import AveragePrecision

PRECISION = AveragePrecision(*map(Quantity, ("boxes_right", "boxes_told", "boxes_true")))
Array = NDArray[np.float64]


def rows(right: list[float], wrong: list[float], true: int, seed: int = 0) -> list[Row]:
    """Return the rows of an episode by the confidences of right and of wrong boxes."""
    values = {
        "boxes_right": froc.reached(np.array(right)).tolist(),
        "boxes_told": froc.reached(np.array([*right, *wrong])).tolist(),
        "boxes_true": float(true),
    }
    ending = {"suite": "fish", "seed": seed, "weight": 1.0, "event": None}
    return [{"metric": name, "value": value, **ending} for name, value in values.items()]


def value(of: list[Row]) -> float:
    pool = PRECISION.pooled(of)
    assert pool is not None
    return pool.mean


def test_steps_of_precision() -> None:
    assert value(rows([0.9, 0.8], [], 2)) == 1.0
    assert value(rows([], [0.5], 2)) == value(rows([], [], 2)) == 0.0
    # Up to a recall of 0.5, at 51 of 101 recalls, all is right; above it two of four.
    assert value(rows([0.9, 0.2], [0.5, 0.6], 2)) == pytest.approx((51 * 1.0 + 50 * 0.5) / 101)
    # Two episodes count as one: together they have half of the boxes, and all of these are right.
    assert value([*rows([0.9], [], 1, seed=0), *rows([], [], 1, seed=1)]) == pytest.approx(51 / 101)


@pytest.mark.parametrize(
    ("x_min", "right", "counts"), [(0.0, True, True), (3.3, True, True), (3.4, False, True), (20.0, False, False)]
)
def test_half_an_overlap_and_boxes_that_do_not_count(x_min: float, right: bool, counts: bool) -> None:
    true = np.array([[0.0, 0.0, 10.0, 10.0], [18.0, 0.0, 40.0, 10.0]])
    box = np.array([[x_min, 0.0, x_min + 10.0, 10.0]])
    found = average_precision.told_right(box, np.ones(1), true, np.array([True, False]))
    assert [each.tolist() for each in found] == [[right], [counts]]


def test_each_true_box_is_found_once_by_the_surest() -> None:
    box = np.array([[0.0, 0.0, 10.0, 10.0]])
    right, counts = average_precision.told_right(box.repeat(2, axis=0), np.array([0.2, 0.7]), box, np.ones(1, bool))
    assert (right.tolist(), counts.tolist()) == ([False, True], [True, True])


@settings(max_examples=20, deadline=None)
@given(st.integers(0, 2**32 - 1))
def test_it_is_that_of_pycocotools(seed: int) -> None:
    pytest.importorskip("pycocotools", reason="pycocotools is not installed")
    from detections import average_precision as by_coco

    rng = np.random.default_rng(seed)
    pictures: list[tuple[Array, Array]] = []
    # No two boxes between the same thresholds: else they would be one step here and two there.
    levels = rng.permutation(0.5 * (froc.THRESHOLDS[1:-2] + froc.THRESHOLDS[2:-1])).tolist()
    right, told, true = [], [], 0
    for _ in range(12):
        count = int(rng.integers(0, 6))
        corner = rng.uniform(0.0, 60.0, (count, 2))
        boxes = np.hstack([corner, corner + rng.uniform(5.0, 30.0, (count, 2))])
        counted = rng.random(count) < 0.7
        moved = boxes[rng.random(count) < 0.9] + rng.normal(0.0, 2.0, (1, 4))
        # COCO does not count a box with a negative side; here answers have none.
        moved[:, 2:] = np.maximum(moved[:, 2:], moved[:, :2] + 1.0)
        at = rng.uniform(0.0, 80.0, (int(rng.integers(0, 4)), 2))
        said = np.vstack([moved, moved[:1] + 1.0, np.hstack([at, at + 12.0])])
        sure = np.array([levels.pop() for _ in said])
        pictures.append((np.column_stack([boxes, counted]), np.column_stack([said, sure])))
        is_right, counts = average_precision.told_right(said, sure, boxes, counted)
        right += sure[is_right].tolist()
        told += sure[counts].tolist()
        true += int(counted.sum())
    wrong: Any = sorted(set(told) - set(right))
    expected = by_coco(pictures)
    assert value(rows(right, wrong, true)) == pytest.approx(max(expected, 0.0), abs=1e-9)
