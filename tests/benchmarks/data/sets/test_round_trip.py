"""What is read back of every scene is what was simulated: the same values, dtypes and shapes."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from benchmarks.data.sets.data_set import REQUEST, DataSet
from benchmarks.data.sets.episode_writer import ROWS_AT_ONCE, write_episode
from benchmarks.data.sets.request import Request, existing_channels
from tests.benchmarks.data.same import assert_same
from tests.benchmarks.data.sets.small import made, tiny

SCENES = {
    "road-town-v2": "quick",
    "stereo-follow-v2": "quick",
    "fish-tank-v1": "quick",
    "harbour-v1": "quick",
    "paper-sheet-v1": "paper-b1",
}
FRAMES, SEED = 3, 4


@pytest.mark.heavy
@pytest.mark.parametrize("scenario", SCENES)
def test_frames_read_back_are_those_that_were_simulated(scenario, tmp_path, monkeypatch):
    asked = Request(scenario, SCENES[scenario], (SEED, SEED + 1), ())
    request = dataclasses.replace(asked, channels=existing_channels(asked))
    live = request.episode(SEED)
    live.frame_count = FRAMES
    step, frames = live.step, []
    monkeypatch.setattr(live, "step", lambda: frames.append(step()) or frames[-1])
    (tmp_path / REQUEST).write_text(request.as_json())
    data = DataSet(str(tmp_path))
    write_episode(data.files, data.root, request, SEED, live)
    data = DataSet(str(tmp_path))
    stored = data.episode(SEED)
    assert_same(stored.start, live.start, "start")
    for k in (2, 0, 1):
        assert_same(data[k], frames[k], f"frame {k}")
    np.testing.assert_array_equal(stored.normals_of(2), live.normals())
    for episode in (live, stored):
        episode.close()
    assert len(data) == FRAMES


@pytest.mark.heavy
def test_rows_and_shards_beyond_the_first_are_read_too(tmp_path, monkeypatch):
    """More frames than a row group holds, and more bytes than a shard."""
    monkeypatch.setattr("benchmarks.data.sets.episode_writer.SHARD_BYTES", 4096)
    data = made(tiny(seeds=(3, 4), frame_count=ROWS_AT_ONCE + 20), tmp_path / "set")
    assert len(list((tmp_path / "set/episodes/000003").glob("*.tar"))) > 10
    live = data.request.episode(3)
    for k, stored in enumerate(data):
        assert_same(stored, live.step(), f"frame {k}")
