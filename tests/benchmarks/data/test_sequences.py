"""A real sequence as an episode: its frames, truth and pictures, and what is another recording."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np
import pytest

from benchmarks.data import sequences
from benchmarks.data.layouts.collection import read_collections
from benchmarks.data.sequences import BoxedSequence, SequenceEpisode
from scenarios.truth import check_truth
from tests.benchmarks.data.written_sequences import (
    AWAY,
    FRAMES,
    HEIGHT_PX,
    WIDTH_PX,
    lines_of,
    true_boxes,
    write_lines,
    write_otb,
)


def episode_of(folder: Path) -> SequenceEpisode:
    return SequenceEpisode(read_collections([folder])[0].sequences[0])


def test_frames_are_the_pictures_with_their_boxes(tmp_path: Path) -> None:
    episode = episode_of(write_otb(tmp_path / "Car1"))
    assert episode.frame_count == FRAMES
    frames = [episode.step() for _ in range(FRAMES)]
    camera = frames[0].observation.camera
    assert (camera.width_px, camera.height_px, camera.focal_px) == (WIDTH_PX, HEIGHT_PX, 1.2 * WIDTH_PX)
    for k, (frame, box) in enumerate(zip(frames, true_boxes(), strict=True)):
        check_truth(frame.truth)
        assert frame.observation.time_s == pytest.approx(k / 30)
        assert frame.observation.ego is None
        np.testing.assert_array_equal(frame.truth.box_xyxy[0], box)
        assert frame.truth.state[0] == ("out" if k in AWAY else "in")
        assert frame.truth.frames_since_exit[0] == (k - AWAY.start if k in AWAY else -1)
        red = (frame.observation.image_rgb == (220, 20, 20)).all(axis=2)
        assert red.sum() == (0 if k in AWAY else 12 * 8)
        assert k in AWAY or red[int(box[1]), int(box[0])]


def test_truth_has_the_states_that_files_tell(tmp_path: Path) -> None:
    pictures = tuple(sorted((write_otb(tmp_path / "Car1", true_boxes(8)) / "img").iterdir()))
    state = np.array(["in", "unlabelled", "occluded", "out", "unseen", "partial", "occluded", "in"])
    boxes = np.where((np.isin(np.arange(8), (0, 5, 6, 7)))[:, None], true_boxes(8), np.nan)
    sequence = BoxedSequence("a", pictures, boxes, 10.0, state=state, place=np.array([0, 1, 2, 4, 5, 6, 7, 9]))
    episode = SequenceEpisode(sequence)
    frames = [episode.step() for _ in range(8)]
    truths = [frame.truth for frame in frames]
    for truth in truths:
        check_truth(truth)
    words = ["in", "unlabelled", "occluded", "out", "out", "partial", "occluded", "in"]
    assert [truth.state[0] for truth in truths] == words
    assert [bool(truth.outside[0]) for truth in truths] == [k == 3 for k in range(8)]
    assert [truth.frames_since_exit[0] for truth in truths] == [-1, -1, -1, 0, 1, -1, -1, -1]
    shares = [truth.visible_fraction[0] for truth in truths]
    np.testing.assert_array_equal(shares, [np.nan, np.nan, 0, 0, 0, np.nan, np.nan, np.nan])
    assert [frame.observation.time_s for frame in frames] == [0.0, 0.1, 0.2, 0.4, 0.5, 0.6, 0.7, 0.9]


def test_other_states_and_places_are_another_recording(tmp_path: Path) -> None:
    pictures = tuple(sorted((write_otb(tmp_path / "Car1", true_boxes(3)) / "img").iterdir()))
    state, place = np.array(["in", "partial", "in"]), np.array([0, 1, 3])
    named = ({}, {"state": state}, {"place": place}, {"state": state, "place": place})
    assert len({BoxedSequence("a", pictures, true_boxes(3), **given).fingerprint for given in named}) == 4


def test_pictures_are_read_when_their_turn_comes(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    read: list[str] = []
    real = sequences.read_picture
    sequence = read_collections([write_otb(tmp_path / "Car1")])[0].sequences[0]
    monkeypatch.setattr(sequences, "read_picture", lambda path: (read.append(path.name), real(path))[1])
    episode = SequenceEpisode(sequence)
    for _ in range(3):
        episode.step()
    assert read == ["0001.png", "0001.png", "0002.png", "0003.png"]


def test_a_broken_picture_and_one_of_another_size_are_named(tmp_path: Path) -> None:
    folder = write_otb(tmp_path / "Car1")
    (folder / "img" / "0002.png").write_bytes(b"no picture")
    cv2.imwrite(str(folder / "img" / "0003.png"), np.zeros((10, 20, 3), np.uint8))
    episode = episode_of(folder)
    episode.step()
    with pytest.raises(ValueError, match=r"^Car1/img/0002.png: expected a whole picture, got 10 bytes that are none"):
        episode.step()
    episode._next = 2
    with pytest.raises(ValueError, match=r"^Car1/img/0003.png: expected 64 x 48 pixels as the first one, got 20 x 10"):
        episode.step()


def test_another_picture_or_annotation_or_rate_is_another_recording(tmp_path: Path) -> None:
    folder = write_otb(tmp_path / "Car1")
    found = [read_collections([folder])[0].sequences[0].fingerprint for _ in range(2)]
    (folder / "img" / "0003.png").write_bytes((folder / "img" / "0001.png").read_bytes())
    found += [read_collections([folder])[0].sequences[0].fingerprint]
    write_lines(folder / "groundtruth_rect.txt", lines_of(true_boxes(FRAMES, range(15, 21))))
    (usual,), (slower,) = (read_collections([folder], rate_hz=rate)[0].sequences for rate in (30.0, 10.0))
    assert (usual.rate_hz, slower.rate_hz) == (30.0, 10.0)
    assert len({*found, usual.fingerprint, slower.fingerprint}) == 4
    assert found[0] == found[1]
