"""J, F, recall and decay against TrackEval's record and against brute force; which frames count."""

from __future__ import annotations

import json
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from scipy.spatial.distance import cdist

from benchmarks.contract.judging import Ending
from benchmarks.contract.suite import suite
from benchmarks.judges.masks import MASKS, MaskScores, contour_accuracy, region_similarity
from scenarios import catalog
from tests.benchmarks.judges.record_trackeval_masks import FILE, SEQUENCES, random_masks
from trackers.types import Estimate

NAMES = {"J": "mask_iou", "F": "contour_accuracy"}
masks = arrays(bool, (13, 17)).flatmap(lambda one: st.tuples(st.just(one), arrays(bool, (13, 17))))


class Seen:
    """The truth of one frame that ``MaskScores`` reads."""

    def __init__(self, frame: int, true: Any) -> None:
        self.frame, self.instance_map, self.instance_id = frame, np.where(true, 5, 1), np.array([9, 5])


def scores_of(true: Any, given_masks: Any) -> dict[str, float]:
    kept = MaskScores()
    for frame, (one, other) in enumerate(zip(true, given_masks, strict=True)):
        kept.keep(Seen(frame, one), 1, Estimate(np.zeros(2), mask=other))  # type: ignore[arg-type]
    return {score.metric: score.value for score in kept.scores()}  # type: ignore[misc]


@pytest.mark.parametrize("name", SEQUENCES)
def test_scores_are_those_of_trackeval(name: str) -> None:
    true, shown = random_masks(*SEQUENCES[name])
    # The first frame does not count here.
    ours = scores_of([true[0], *true], [None, *shown])
    for theirs, value in json.loads(FILE.read_text())["results"][name].items():
        which, _, what = theirs.partition("-")
        wanted = "j_and_f" if theirs == "J&F" else NAMES[which] + ("" if what == "Mean" else f"_{what.lower()}")
        assert ours[wanted] == pytest.approx(value, abs=1e-12), theirs


@given(masks, st.sampled_from([1, 4]))
def test_contours_are_matched_as_by_brute_force(two: Any, larger: int) -> None:
    one, other = (np.kron(each, np.ones((larger, larger), bool)) for each in two)

    def contour(mask: Any) -> Any:
        height, width = mask.shape
        points = [
            (row, column)
            for row in range(height)
            for column in range(width)
            if any(
                mask[row, column] != mask[min(row + down, height - 1), min(column + right, width - 1)]
                for down, right in ((0, 1), (1, 0), (1, 1))
            )
        ]
        return np.array(points, float).reshape(-1, 2)

    a, b = contour(one), contour(other)
    tolerance = np.ceil(0.008 * np.hypot(*one.shape))
    if not len(a) or not len(b):
        wanted = float(len(a) == len(b))
    else:
        away = cdist(a, b)
        precision, recall = (away.min(axis=1) <= tolerance).mean(), (away.min(axis=0) <= tolerance).mean()
        wanted = 2 * precision * recall / (precision + recall) if precision + recall else 0.0
    assert contour_accuracy(one, other) == pytest.approx(wanted, abs=1e-12)
    assert contour_accuracy(other, one) == pytest.approx(wanted, abs=1e-12)
    both = [set(map(tuple, np.argwhere(each))) for each in (one, other)]
    union = both[0] | both[1]
    assert region_similarity(one, other) == pytest.approx(len(both[0] & both[1]) / len(union) if union else 1.0)


def test_only_frames_with_a_pixel_of_the_target_count_and_one_without_a_mask_is_a_miss() -> None:
    there, nothing = np.zeros((20, 20), bool), np.zeros((20, 20), bool)
    there[5:12, 6:14] = True
    true = [there, there, nothing, nothing, nothing, there, there]
    ours = scores_of(true, [nothing, there, nothing, there, None, None, nothing])
    assert ours["mask_iou"] == ours["contour_accuracy"] == ours["j_and_f"] == pytest.approx(1 / 3)


def test_a_tracker_without_masks_has_no_scores_of_them() -> None:
    there = np.ones((4, 4), bool)
    assert scores_of([there] * 3, [None] * 3) == {}
    assert scores_of([there, ~there], [there, there]) == {}


def test_the_true_masks_of_an_episode_are_perfect() -> None:
    scenario = catalog.scenario("road-town")
    episode = scenario.episode("quick", 3)
    kept = MaskScores()
    seen = []
    for _ in range(48):
        truth = episode.step().truth
        target = truth.index_of(scenario.target)
        mask = truth.instance_map == truth.instance_id[target]
        assert mask.any() == (truth.visible_fraction[target] > 0)
        seen.append(mask.any())
        kept.keep(truth, target, Estimate(truth.position_px[target], mask=mask))
    episode.close()
    assert 0 < sum(seen) < len(seen)
    assert {score.metric: score.value for score in kept.scores()}["j_and_f"] == 1.0


@pytest.mark.parametrize(
    ("judging", "scenario"),
    [("frame-out", "road-town"), pytest.param("stereo", "stereo-follow", marks=pytest.mark.heavy)],
)
def test_suites_of_one_target_judge_masks(judging: str, scenario: str) -> None:
    scene = catalog.scenario(scenario)
    episode = scene.episode("quick", 0)
    judge = suite(judging).judge_of(episode, scene)
    sheets = [judge.sheet(), judge.sheet()]
    for _ in range(8):
        frame = episode.step()
        truth = frame.truth
        target = truth.index_of(scene.target)
        mask = truth.instance_map == truth.instance_id[target]
        judge.see(frame, None)
        for sheet, own in zip(sheets, (mask, None), strict=True):
            sheet.keep(frame, Estimate(truth.position_px[target], mask=own))
    episode.close()
    with_masks, without = ({score.metric: score.value for score in sheet.scores(Ending())} for sheet in sheets)
    assert {name: with_masks[name] for name in ("j_and_f", "mask_iou", "contour_accuracy", "mask_iou_decay")} == {
        "j_and_f": 1.0,
        "mask_iou": 1.0,
        "contour_accuracy": 1.0,
        "mask_iou_decay": 0.0,
    }
    assert with_masks.keys() - without.keys() == {metric.name for metric in MASKS}
