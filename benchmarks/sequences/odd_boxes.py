"""Boxes of a sequence that are probably in other units or another order than its layout's."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

import numpy as np

from benchmarks.sequences.sequence import BoxedSequence, Collection, read_picture

_EXPECTED = "are these left, top, width, height in pixels"


def odd_boxes(collections: Iterable[Collection]) -> Iterator[str]:
    """Yield a line for each sequence whose boxes lie outside the picture, from 0 to 1, or are probably corners.

    Raises:
        ValueError: for a first picture that is broken.
    """
    for sequence in (sequence for each in collections for sequence in each.sequences):
        if (odd := _oddity(sequence)) is not None:
            yield f"{sequence.name}: {odd}"


def _oddity(sequence: BoxedSequence) -> str | None:
    """Return what is odd about the boxes of a sequence, None if nothing is."""
    boxes = sequence.box_xyxy[~np.isnan(sequence.box_xyxy).any(axis=1)]
    height, width = read_picture(sequence.pictures[0]).shape[:2]
    size_px = np.array([width, height])
    outside = ((boxes[:, 2:] <= 0) | (boxes[:, :2] >= size_px)).any(axis=1)
    below_one = (np.abs(boxes) <= 1).all(axis=1)
    over_px = np.maximum(boxes[:, 2:] - size_px, 0)
    # Corners that are taken for left, top, width and height: these are then larger than the first two.
    corners = (boxes[:, 2:] - boxes[:, :2] > boxes[:, :2]).all() and (over_px.max(axis=1) > 1).sum() > 1
    for odd, words in (
        (below_one, f"the box lies in the first pixel, from 0 to 1: {_EXPECTED}?"),
        (corners & (over_px > 1).any(axis=1), f"the box reaches beyond the picture: {_EXPECTED}, and not two corners?"),
        (outside, f"the box lies outside the picture: {_EXPECTED}, and NaN where the target is outside?"),
    ):
        if odd.any():
            return f"in {int(odd.sum()):,} of {len(sequence.pictures):,} pictures {words}"
    return None
