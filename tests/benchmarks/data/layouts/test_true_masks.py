"""Masks of real sequences: read as they were written, and trackers that answer with masks are judged by them."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from benchmarks.data.sequences import BoxedSequence, SequenceEpisode
from tests.benchmarks.data.judged_sequences import all_scores_of
from tests.benchmarks.data.layouts.test_layouts import read_one
from tests.benchmarks.data.layouts.written_layouts import (
    CLIPPED_XYXY,
    FRAMES,
    number_map,
    write_davis,
    write_mots,
    write_vot,
    xywh,
)
from tests.benchmarks.data.written_sequences import write_lines
from trackers.types import Estimate


def write_masks_of_vot(root: Path) -> Path:
    """Write only masks and a code."""
    write_vot(root)
    seen = []
    for k, box in enumerate(CLIPPED_XYXY):
        x, y, width, height = map(int, np.nan_to_num(xywh(box)))
        area = int((number_map(k, 1) == 1).sum())
        seen.append(f"m{x},{y},{width},{height},0,{area}" if area else "0")
    write_lines(root / "car1" / "groundtruth.txt", seen)
    return root


WRITERS = {"mots": (write_mots, 1), "davis": (write_davis, 2), "vot": (write_masks_of_vot, 1)}
"""And every how many pictures have a label."""


@pytest.mark.parametrize("name", WRITERS)
def test_true_masks_are_those_of_the_files(tmp_path: Path, name: str) -> None:
    write, every = WRITERS[name]
    sequence = read_one(write(tmp_path / "set"))
    episode = SequenceEpisode(sequence)
    for k in range(len(sequence.pictures)):
        truth = episode.step().truth
        if k % every:
            assert truth.instance_map.shape == (0, 0)
        else:
            np.testing.assert_array_equal(truth.instance_map == truth.instance_id[0], number_map(k, 1) == 1)


def scores_of(sequence: BoxedSequence, answer: Callable[[int], Estimate]) -> dict[str, float]:
    return {score.metric: score.value for score in all_scores_of(sequence, answer) if isinstance(score.value, float)}


@pytest.mark.parametrize("name", WRITERS)
def test_masks_are_judged_where_files_have_them(tmp_path: Path, name: str) -> None:
    write, every = WRITERS[name]
    sequence = read_one(write(tmp_path / "set"))
    there = ~np.isnan(CLIPPED_XYXY[:, 0])

    def perfect(k: int) -> Estimate:
        return Estimate(np.full(2, 20.0), mask=number_map(k, 1) == 1)

    assert scores_of(sequence, perfect)["j_and_f"] == 1.0
    counted = [k for k in range(1, len(sequence.pictures)) if there[k] and k % every == 0]
    missed = scores_of(sequence, lambda k: perfect(k) if k != counted[-1] else Estimate(np.full(2, 20.0)))
    assert missed["mask_iou"] == pytest.approx(1 - 1 / len(counted))
    assert "j_and_f" not in scores_of(sequence, lambda k: Estimate(np.full(2, 20.0)))


def test_files_without_masks_have_no_scores_of_them(tmp_path: Path) -> None:
    sequence = read_one(write_vot(tmp_path / "set"))
    assert sequence.masks == ()
    scores = scores_of(sequence, lambda k: Estimate(np.full(2, 20.0), mask=number_map(k, 1) == 1))
    assert "j_and_f" not in scores
    assert len(sequence.pictures) == FRAMES


def test_another_mask_is_another_sequence(tmp_path: Path) -> None:
    first = read_one(write_masks_of_vot(tmp_path / "one"))
    file = tmp_path / "one" / "car1" / "groundtruth.txt"
    file.write_text(file.read_text().replace("m10,20,12,8,0,96", "m10,20,12,8,0,94,1,1"))
    second = read_one(tmp_path / "one")
    np.testing.assert_array_equal(first.box_xyxy, second.box_xyxy)
    assert first.fingerprint != second.fingerprint
