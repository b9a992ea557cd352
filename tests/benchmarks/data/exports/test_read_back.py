"""Each export of boxes read back by ``--real``: the target's boxes and states, and the scores, are those of the truth.

What is judged on both sides is the judge of sequences. The truth beside it is what the format can tell: a box where at
least one pixel of the target is seen, of the whole target or of what is seen of it; and why there is none, if it tells.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from benchmarks.contract.judging import Score
from benchmarks.data.exports.exporter import export, formats
from benchmarks.data.layouts.collection import read_collections
from benchmarks.data.sequences import BoxedSequence, SequenceEpisode
from benchmarks.data.sets.data_set import DataSet
from benchmarks.judges.frame_out.judge import FrameOutJudge
from benchmarks.judges.frame_out.metrics.frame_outs import find_frame_outs
from benchmarks.judges.frame_out.real import SequenceJudge
from tests.benchmarks.data.exports.painted_scene import HEIGHT_PX, IDS, PAINTED, WIDTH_PX, painted_data_set, truths
from tests.benchmarks.data.judged_sequences import all_scores_of
from trackers.types import Estimate

TRUTHS = truths("returns")
FRAMES = len(TRUTHS)
STATES = {
    "all": ("otb", "vot", "tao-amodal", "webdataset"),
    "hidden": ("mot",),
    "none": ("coco", "coco-keypoints", "davis", "mots", "yolo"),
}
"""What formats tell of a target without a box: whether it is outside or hidden; that it is hidden; nothing."""
SEEN_PART = STATES["none"]
"""Formats whose boxes are around what is seen."""
FORMATS = [name for names in STATES.values() for name in names]
HOW = dict.fromkeys(("otb", "coco", "coco-keypoints", "davis", "mots", "yolo"), 7.5)
"""Rates of formats that tell none."""


@pytest.fixture(scope="module")
def data(tmp_path_factory: pytest.TempPathFactory) -> DataSet:
    return painted_data_set(tmp_path_factory.mktemp("painted") / "set", "returns")


def expected(name: str, pictures: tuple[Path, ...]) -> BoxedSequence:
    """Return the sequence that a format can tell."""
    boxes, words = np.full((FRAMES, 4), np.nan), []
    for k, truth in enumerate(TRUTHS):
        pixels, state = truth.instance_map == IDS[1], str(truth.state[1])
        if pixels.any():
            rows, columns = np.nonzero(pixels)
            around = [columns.min(), rows.min(), columns.max() + 1, rows.max() + 1]
            boxes[k] = around if name in SEEN_PART else truth.box_xyxy[1]
            words.append("in" if name in SEEN_PART else state)
        elif name in STATES["all"] or (name in STATES["hidden"] and state == "occluded"):
            words.append(state)
        else:
            words.append("unseen")
    return BoxedSequence("expected", pictures, boxes, 7.5, state=np.array(words))


def answer(k: int) -> Estimate:
    """Return written answers: near the car, late after its return, and once silent."""
    box = TRUTHS[max(k - (2 if k > 10 else 0), 0)].box_xyxy[1] + np.array([0.37, -0.21, 0.55, 0.13])
    if k == 5:
        return Estimate(np.full(2, np.nan))
    return Estimate(0.5 * (box[:2] + box[2:]), box, in_view_probability=float(box[0] < WIDTH_PX - 2.0) * (0.9 - k / 60))


def as_values(scores: list[Score]) -> list[tuple[Any, ...]]:
    events = [score.event.attributes() if score.event else None for score in scores]
    return [(score.metric, score.weight, event) for score, event in zip(scores, events, strict=True)]


def numbers(scores: list[Score]) -> NDArray[np.float64]:
    return np.concatenate([np.atleast_1d(np.array(score.value, float)) for score in scores])


def test_every_format_with_a_target_is_read_back() -> None:
    """Some hold maps or labels of single pictures alone, and Rerun's a recording for its own viewer."""
    pictures = {
        "dota",
        "hub",
        "kitti-depth",
        "kitti-flow",
        "kitti-forward-flow",
        "sintel-flow",
        "kitti-object",
        "kitti-stereo",
        "yolo-obb",
        "yolo-seg",
    }
    assert set(formats()) == {*FORMATS, *pictures, "rerun"}


@pytest.mark.parametrize(("name", "within_px"), [("yolo-seg", 0.5), ("yolo-obb", 1e-9)])
def test_outlines_of_yolo_are_read_as_the_boxes_around_them(
    data: DataSet, tmp_path: Path, name: str, within_px: float
) -> None:
    export(data, name, tmp_path / "out")
    (collection,) = read_collections([tmp_path / "out"], target="target", rate_hz=7.5)
    for read in collection.sequences:
        told = expected("yolo", read.pictures)
        np.testing.assert_allclose(read.box_xyxy, told.box_xyxy, rtol=0, atol=within_px + 1e-9)


@pytest.mark.parametrize("name", FORMATS)
def test_an_export_has_the_scores_of_the_truth(data: DataSet, tmp_path: Path, name: str) -> None:
    export(data, name, tmp_path / "out")
    (collection,) = read_collections([tmp_path / "out"], target=_target(name), rate_hz=HOW.get(name))
    assert (len(collection.sequences), collection.unusable) == (2, ())
    for read in collection.sequences:
        told = expected(name, read.pictures)
        assert read.rate_hz == 7.5
        assert read.state.tolist() == told.state.tolist()
        np.testing.assert_allclose(read.box_xyxy, told.box_xyxy, rtol=0, atol=1e-12)
        got, wanted = all_scores_of(read, answer), all_scores_of(told, answer)
        assert as_values(got) == as_values(wanted)
        np.testing.assert_allclose(numbers(got), numbers(wanted), rtol=0, atol=1e-12)
        recovered = [score.value for score in got if score.metric in ("recovered", "recovery_frames")]
        assert recovered, "the car returns"


def _target(name: str) -> str | None:
    """Return the target's identity: MOT has numbers, in the order in which objects are listed."""
    return {"otb": None, "vot": None, "mot": "2", "mots": "1000"}.get(name, "target")


@pytest.mark.parametrize("name", [*STATES["all"], *STATES["hidden"]])
def test_frame_outs_of_an_export_are_those_of_the_simulated_episode(data: DataSet, tmp_path: Path, name: str) -> None:
    """Of all formats that tell hidden from outside."""
    judge = FrameOutJudge(data.episode(3), PAINTED)
    for k in range(FRAMES):
        judge.see(data.episode(3).frame(k, ()), None)
    simulated = find_frame_outs(judge.truth)
    export(data, name, tmp_path / "out")
    sequence = read_collections([tmp_path / "out"], target=_target(name))[0].sequences[0]
    episode = SequenceEpisode(sequence)
    real = SequenceJudge(episode)
    for _ in range(FRAMES):
        real.see(episode.step(), None)
    found = find_frame_outs(real.truth)
    places = [(each.exit_frame, each.length_frames, each.back_frame, each.watch_end_frame) for each in found]
    assert places == [(e.exit_frame, e.length_frames, e.back_frame, e.watch_end_frame) for e in simulated]
    assert [each.kind for each in found] == ["unseen" if name == "mot" else "outside"] == [places and found[0].kind]


def test_the_car_is_seen_in_every_way() -> None:
    """Else the comparisons would be of less than they say."""
    states = [str(truth.state[1]) for truth in TRUTHS]
    assert {"in", "partial", "occluded", "out"} == set(states)
    shares = [float(truth.visible_fraction[1]) for truth in TRUTHS]
    assert {0.0, 1.0} < set(shares)
    assert TRUTHS[0].instance_map.shape == (HEIGHT_PX, WIDTH_PX)
