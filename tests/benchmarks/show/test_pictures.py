"""Pictures of real sequences: all trackers run on each picture once, and are drawn as each one alone."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pytest

from benchmarks.contract.suite import suite
from benchmarks.data.layouts.collection import read_collections
from benchmarks.data.real import RealEpisode
from benchmarks.run.jobs import Job, opened
from benchmarks.run.selection import tracker_named
from benchmarks.show.pictures import drawn_cells, name_of, read_pictures, remove_picture, write_picture
from benchmarks.show.replay import replay
from benchmarks.show.video.drawing import InLargerView
from benchmarks.show.video.surroundings import CameraMotion, surrounded
from tests.benchmarks.data.written_sequences import lines_of, write_lines

NAMES = ("hold", "constant_velocity", "correlation_filter")
COUNT, WANTED = 30, [4, 11, 11, 24]


@pytest.fixture
def job(tmp_path: Path) -> Job:
    """Return a job on a sequence whose camera moves over a ground that it sees for the first time on every frame."""
    noise = np.random.default_rng(8).integers(0, 255, (30, 60, 3), np.uint8)
    ground = cv2.resize(noise, (480, 240), interpolation=cv2.INTER_CUBIC)
    (tmp_path / "Pan" / "img").mkdir(parents=True)
    for k in range(COUNT):
        cv2.imwrite(str(tmp_path / "Pan" / "img" / f"{k + 1:04d}.png"), ground[40:160, 6 * k : 6 * k + 160])
    boxes = np.array([[90.0 - 2 * k, 40.0, 120.0 - 2 * k, 64.0] for k in range(COUNT)])
    write_lines(tmp_path / "Pan" / "groundtruth_rect.txt", lines_of(boxes))
    (collection,) = read_collections([tmp_path / "Pan"])
    episode = RealEpisode(collection.name, 0, (), collection.sequences[0])
    return Job(suite("frame-out"), episode, {name: tracker_named(name) for name in NAMES}, repeats=1)


def test_a_condition_of_a_policy_has_a_picture_too(tmp_path: Path) -> None:
    condition = ("frame-out", "road-town-v2", "standard", "raster", "policy:results/mine/policy.json")
    write_picture(tmp_path, name_of(condition), np.zeros((4, 4, 3), np.uint8), condition, "title", "caption", "key")
    (shown,) = read_pictures(tmp_path)
    assert shown["condition"] == [*condition]
    remove_picture(tmp_path, name_of(condition))
    assert not read_pictures(tmp_path)


def test_trackers_in_one_run_are_drawn_as_each_alone_in_its_whole_video(
    job: Job, monkeypatch: pytest.MonkeyPatch
) -> None:
    expected = []
    for name, tracker in job.trackers.items():
        with opened(replace(job, trackers={name: tracker})) as live:
            drawing, rate_hz = InLargerView(300), live.loop.episode.rate_hz
            instants = replay(live, scale=1.0, wanted=range(COUNT), frame_count=COUNT)
            drawn = [(drawing.describe(each), drawing.picture(each)) for each in surrounded(instants, rate_hz, 1.5)]
        expected.append([(f"{name}   frame {frame}   {drawn[frame][0]}", drawn[frame][1]) for frame in WANTED])
    measured, told = [], []
    until = CameraMotion.until
    monkeypatch.setattr(CameraMotion, "until", lambda self, image: measured.append(0) or until(self, image))
    found = drawn_cells(job, lambda episode: InLargerView(300), WANTED, 1.5, lambda *done: told.append(done))
    assert [[words for words, _ in row] for row in found] == [[words for words, _ in row] for row in expected]
    np.testing.assert_array_equal(
        [[picture for _, picture in row] for row in found], [[picture for _, picture in row] for row in expected]
    )
    around = found[0][-1][1][60:150, 5:45]
    assert around.std(axis=(0, 1)).min() > 10, "what was seen before is beside the picture"
    # Up to the last picture that is shown, once for all trackers.
    assert len(measured) == max(WANTED) + 1
    assert told == [(k, max(WANTED) + 1) for k in range(1, max(WANTED) + 2)]
