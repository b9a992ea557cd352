"""Scores in pixels of real sequences, against loops over frames and pycocotools' overlap."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray
from pycocotools import mask

from benchmarks.contract.judging import Score
from benchmarks.judges.frame_out.metrics.frame_outs import find_frame_outs
from benchmarks.judges.frame_out.metrics.series import EstimateSeries, TruthSeries
from benchmarks.judges.frame_out.real import score_sequence
from benchmarks.judges.frame_out.suite import FRAME_OUT

SIZE_PX = (100, 80)
NONE = np.full(4, np.nan)


def truth_of_boxes(box_xyxy: NDArray[np.float64], rate_hz: float = 4.0) -> TruthSeries:
    frames = len(box_xyxy)
    state = np.where(np.isnan(box_xyxy).any(axis=1), "out", "in")
    return TruthSeries(
        rate_hz=rate_hz,
        size_px=SIZE_PX,
        target=0,
        ground_m=np.full((frames, 1, 2), np.nan),
        object_size_m=np.full((1, 3), np.nan),
        position_px=0.5 * (box_xyxy[:, None, :2] + box_xyxy[:, None, 2:]),
        box_xyxy=box_xyxy[:, None],
        visible_fraction=np.where(state == "out", 0.0, np.nan),
        state=state,
        side=np.full(frames, ""),
    )


def answers_of(box_xyxy: NDArray[np.float64], probability: NDArray[np.float64]) -> EstimateSeries:
    frames = len(box_xyxy)
    unknown = np.full(frames, np.nan)
    position_px = 0.5 * (box_xyxy[:, :2] + box_xyxy[:, 2:])
    none = np.zeros(frames, bool)
    nowhere = np.full((frames, 2), np.nan)
    return EstimateSeries(position_px, nowhere, box_xyxy, probability, none, unknown, unknown, ~none)


def values(scores: list[Score]) -> dict[str, float | list[float] | None]:
    return {score.metric: score.value for score in scores if score.event is None}


def overlap(first: NDArray[np.float64], second: NDArray[np.float64]) -> float:
    """IoU by pycocotools, which takes left, top, width and height; 0 for NaN."""
    if np.isnan([*first, *second]).any():
        return 0.0
    one, other = (np.array([[*box[:2], *(box[2:] - box[:2])]]) for box in (first, second))
    return float(mask.iou(one, other, [0])[0, 0])


@st.composite
def runs(draw: st.DrawFn) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
    """True boxes, a tracker's boxes near or far from them or NaN, and its probabilities or NaN."""
    frames = draw(st.integers(2, 25))
    rng = np.random.default_rng(draw(st.integers(0, 2**20)))
    corner = rng.uniform(0, 60, (frames, 2))
    truth = np.concatenate([corner, corner + rng.uniform(5, 30, (frames, 2))], axis=1)
    answer = truth + rng.normal(0, 1, (frames, 4)) * rng.choice([0.1, 3.0, 40.0], (frames, 1))
    answer[:, 2:] = np.maximum(answer[:, 2:], answer[:, :2] + 1)
    answer[rng.random(frames) < 0.1] = np.nan
    truth[(rng.random(frames) < 0.3) & (np.arange(frames) > 0)] = np.nan
    probability = np.where(rng.random(frames) < 0.5, rng.random(frames), np.nan)
    return truth, answer, probability


@settings(deadline=None, max_examples=60)
@given(runs())
def test_scores_are_those_of_a_loop_over_frames(
    run: tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]],
) -> None:
    truth, answer, probability = run
    got = values(score_sequence(truth_of_boxes(truth), answers_of(answer, probability), None))
    seen = [k for k in range(len(truth)) if not np.isnan(truth[k]).any()]
    away = [k for k in range(len(truth)) if k not in seen]
    iou = [overlap(truth[k], answer[k]) for k in range(len(truth))]
    middle = 0.5 * (answer[:, :2] + answer[:, 2:])
    inside = [bool(0 <= x < SIZE_PX[0] and 0 <= y < SIZE_PX[1]) for x, y in middle]
    says = [p >= 0.5 if np.isfinite(p) else place for p, place in zip(probability, inside, strict=True)]
    worst = float(np.hypot(*SIZE_PX))
    error = []
    for k in seen:
        distance = np.hypot(*(middle[k] - 0.5 * (truth[k, :2] + truth[k, 2:])))
        error.append(min(worst if np.isnan(distance) else float(distance), worst))
    success = [np.mean([iou[k] > t / 20 for k in seen]) for t in range(21)]
    expected = {
        "success_auc": np.mean(success),
        "precision_20_px": np.mean([each <= 20 for each in error]),
        "centre_error_px": np.mean(error),
        "in_view_tpr": np.mean([says[k] and iou[k] >= 0.5 for k in seen]),
        "in_view_tnr": np.mean([not says[k] for k in away]) if away else np.nan,
    }
    for name, value in expected.items():
        assert got[name] == pytest.approx(value, nan_ok=True, abs=1e-9), name
    sure = [(p if np.isfinite(p) else 1.0) if place else 0.0 for p, place in zip(probability, inside, strict=True)]
    for t in range(21):
        said = [k for k in range(len(truth)) if sure[k] >= t / 20 and sure[k] > 0]
        total = sum(iou[k] for k in said)
        assert got["precision_curve"][t] == pytest.approx(total / len(said) if said else 1.0)  # type: ignore[index]
        assert got["recall_curve"][t] == pytest.approx(total / len(seen))  # type: ignore[index]


def test_a_point_alone_is_on_the_target_in_the_middle_half_of_its_box_however_large_that_has_grown() -> None:
    truth = np.array([[10.0, 10.0, 20.0, 20.0], [10.0, 10.0, 50.0, 30.0], [10.0, 10.0, 50.0, 30.0], [np.nan] * 4])
    small = np.array([[10.0, 10.0, 20.0, 20.0], [34.0, 20.0, 44.0, 30.0], [37.0, 16.0, 47.0, 26.0], [np.nan] * 4])
    boxes = answers_of(small, np.full(4, np.nan))
    points = replace(boxes, has_box=np.zeros(4, bool))
    with_boxes, with_points = (values(score_sequence(truth_of_boxes(truth), each, None)) for each in (boxes, points))
    assert with_boxes["in_view_tpr"] == pytest.approx(1 / 3)
    assert with_points["in_view_tpr"] == pytest.approx(2 / 3)
    assert with_points["precision_20_px"] == 1.0


def test_nothing_in_metres_and_nothing_about_other_cars_is_scored() -> None:
    boxes = np.tile([10.0, 10.0, 30.0, 20.0], (40, 1))
    boxes[5:9] = np.nan
    scores = score_sequence(truth_of_boxes(boxes), answers_of(np.nan_to_num(boxes), np.full(40, np.nan)), None)
    names = {score.metric for score in scores}
    assert not [name for name in names if name.endswith("_m") or "car" in name or "coverage" in name or name == "nees"]
    assert {"recovered", "kept", "recovery_frames", "watched_frames", "run_kept"} <= names


def test_a_return_is_found_within_five_frames_and_kept_for_a_second() -> None:
    boxes = np.tile([10.0, 10.0, 30.0, 20.0], (60, 1))
    boxes[10:14] = boxes[30:32] = boxes[57:] = np.nan
    answer = np.tile([10.0, 10.0, 30.0, 20.0], (60, 1))
    answer[10:16] += 50.0
    answer[30:42] += 50.0
    scores = score_sequence(truth_of_boxes(boxes), answers_of(answer, np.full(60, np.nan)), None)
    events = [(s.event.attributes()["index"], s.metric, s.value) for s in scores if s.event is not None]
    assert events == [
        (0, "recovered", 1.0),
        (0, "kept", 1.0),
        (0, "recovery_frames", 2.0),
        (0, "watched_frames", 16.0),
        (1, "recovered", 0.0),
        (1, "kept", 0.0),
        (1, "recovery_frames", 10.0),
        (1, "watched_frames", 25.0),
    ]
    assert values(scores)["run_kept"] == 0.0


def test_absences_are_described_without_roads_and_turns() -> None:
    boxes = np.tile([10.0, 10.0, 30.0, 20.0], (6, 1))
    boxes[[1, 2, 4]] = np.nan
    found = [each.attributes() for each in find_frame_outs(truth_of_boxes(boxes))]
    assert {(each["kind"], each["side"], each["turned"], each["long"]) for each in found} == {
        ("unseen", "", None, None)
    }
    assert FRAME_OUT.events.describe(found) == "2 absences of 1 to 2 frames"
    groups = [name for name, is_one in FRAME_OUT.events.tests.items() if is_one(found[0])]
    assert groups == ["all", "1 to 15 frames"]


def test_sequences_count_the_same_in_scores_of_otb() -> None:
    boxes = np.tile([10.0, 10.0, 30.0, 20.0], (8, 1))
    boxes[3] = np.nan
    scores = score_sequence(truth_of_boxes(boxes), answers_of(boxes, np.full(8, np.nan)), None)
    weights = {score.metric: score.weight for score in scores}
    assert [weights[name] for name in ("success_auc", "centre_error_px", "precision_20_px")] == [1.0, 1.0, 1.0]
    assert (weights["in_view_tpr"], weights["in_view_tnr"]) == (7.0, 1.0)


def test_a_failure_denies_presence_and_absence() -> None:
    boxes = np.tile([10.0, 10.0, 30.0, 20.0], (8, 1))
    boxes[5] = np.nan
    answer = answers_of(np.where(np.isnan(boxes), 500.0, boxes), np.full(8, np.nan))
    got = values(score_sequence(truth_of_boxes(boxes), answer, failed_at_frame=4))
    assert (got["in_view_tpr"], got["in_view_tnr"]) == (pytest.approx(4 / 7), 0.0)


def test_twenty_pixels_are_still_precise() -> None:
    boxes = np.tile([10.0, 10.0, 30.0, 20.0], (4, 1))
    answer = answers_of(boxes + np.array([[0.0], [12.0], [12.01], [300.0]]) * [1, 4 / 3, 1, 4 / 3], np.full(4, np.nan))
    assert values(score_sequence(truth_of_boxes(boxes), answer, None))["precision_20_px"] == 0.5


def told(box_xyxy: NDArray[np.float64], state: NDArray[np.str_], outside: NDArray[np.bool_]) -> TruthSeries:
    """Return what files tell, as ``SequenceTruth`` says."""
    seen = ~np.isnan(box_xyxy).any(axis=1)
    fraction = np.where(seen | (state == "unlabelled"), np.nan, 0.0)
    return replace(truth_of_boxes(box_xyxy), state=state, outside=outside, visible_fraction=fraction)


@settings(deadline=None, max_examples=60)
@given(runs(), st.integers(0, 2**20))
def test_a_frame_without_a_label_counts_in_no_score(
    run: tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]], seed: int
) -> None:
    """The scores of single frames are those of a sequence that lacks them."""
    truth, answer, probability = run
    rng = np.random.default_rng(seed)
    hides = np.where(rng.random(len(truth)) < 0.5, "out", "occluded")
    state = np.where(np.isnan(truth[:, 0]), hides, np.where(rng.random(len(truth)) < 0.2, "partial", "in"))
    outside = (state == "out") & (rng.random(len(truth)) < 0.5)
    known = rng.random(len(truth)) < 0.6
    known[0] = True
    blank = np.where(known[:, None], truth, np.nan)
    scores = [
        score_sequence(told(boxes, words, tagged), answers_of(mine, sure), None)
        for boxes, words, tagged, mine, sure in (
            (blank, np.where(known, state, "unlabelled"), outside & known, answer, probability),
            (truth[known], state[known], outside[known], answer[known], probability[known]),
        )
    ]
    left, right = ({name: value for name, value in values(each).items() if name not in _OF_EVENTS} for each in scores)
    assert left.keys() == right.keys()
    for name, value in left.items():
        assert value == pytest.approx(right[name], nan_ok=True, abs=1e-12), name


_OF_EVENTS = ("run_kept", "silent_frames")


def test_frame_outs_of_tags_are_outside_and_what_is_hidden_is_none() -> None:
    boxes = np.tile([10.0, 10.0, 30.0, 20.0], (60, 1))
    state = np.full(60, "in", "<U10")
    state[5:8], state[12:15], state[20:23], state[23:26] = "occluded", "out", "out", "partial"
    boxes[[*range(5, 8), *range(12, 15), *range(20, 23)]] = np.nan
    outside = np.arange(60) >= 20
    found = find_frame_outs(told(boxes, state, outside & (state == "out")))
    assert [(each.kind, each.exit_frame, each.length_frames, each.back_frame) for each in found] == [
        ("unseen", 12, 3, 15),
        ("outside", 20, 3, 26),
    ]
    assert FRAME_OUT.events.describe([each.attributes() for each in found]) == "2 frame-outs or absences of 3 frames"
    assert FRAME_OUT.events.describe([found[1].attributes()]) == "1 frame-out of 3 frames"
    got = {
        s.metric: s.weight
        for s in score_sequence(told(boxes, state, outside), answers_of(boxes, np.full(60, np.nan)), None)
        if s.event is None
    }
    assert (got["in_view_tpr"], got["in_view_tnr"]) == (51.0, 9.0)


@pytest.mark.parametrize(("blank", "judged"), [(11, [1]), (16, [1]), (19, [1]), (40, [0]), (None, [0, 1])])
def test_a_frame_out_beside_frames_without_a_label_is_not_judged(blank: int | None, judged: list[int]) -> None:
    """Their exit, return or recovery may lie there."""
    boxes = np.tile([10.0, 10.0, 30.0, 20.0], (60, 1))
    boxes[[*range(12, 15), *range(30, 33)]] = np.nan
    state = np.where(np.isnan(boxes[:, 0]), "out", "in").astype("<U10")
    if blank is not None:
        state[blank], boxes[blank] = "unlabelled", np.nan
    scores = score_sequence(told(boxes, state, state == "out"), answers_of(boxes, np.full(60, np.nan)), None)
    assert [s.event.attributes()["index"] for s in scores if s.metric == "recovered" and s.event] == judged
