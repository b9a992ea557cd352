"""What is told of files of real tracks before they are judged."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from benchmarks.contract.track_table import TrackTable
from benchmarks.data.tracks import read_tracks
from benchmarks.judges.fish.real import FishRecording, recordings
from tests.benchmarks.data.written_tracks import write_tracks
from tests.benchmarks.judges.fish.gap_methods import swimming


def table_of(**changes: object) -> TrackTable:
    return TrackTable(**{"name": "pond", "position": swimming(40, 2), "names": ("7", "8"), "rate_hz": 25.0, **changes})  # type: ignore[arg-type]


def test_a_sound_file_needs_no_words(tmp_path: Path) -> None:
    (path, _) = write_tracks(table_of(), tmp_path, "idtracker.ai")
    assert recordings(read_tracks([path]))[1:] == ([], [])


def test_places_of_exactly_zero_are_not_tracked(tmp_path: Path) -> None:
    position = swimming(40, 2)
    position[5:9, 0] = 0.0
    position[30, 1] = 0.0
    (path, _) = write_tracks(table_of(position=position), tmp_path, "idtracker.ai")
    (recording,), notes, _ = recordings(read_tracks([path]))
    assert notes == ["trajectories: 5 places of exactly 0, 0 are taken as not tracked"]
    tracked = np.isfinite(recording._tracks.position_px[..., 0])
    assert [np.flatnonzero(~tracked[:, animal]).tolist() for animal in range(2)] == [[5, 6, 7, 8], [30]]
    # An animal that is nowhere else is there.
    position[:, 0] = 0.0
    (path, _) = write_tracks(table_of(position=position), tmp_path, "idtracker.ai")
    assert np.isfinite(recordings(read_tracks([path]))[0][0]._tracks.position_px[:, 0]).all()


@pytest.mark.parametrize("changes", [{"rate_hz": 26.0}, {"name": "lake"}, {"position": swimming(40, 2) + 1.0}])
def test_another_content_is_another_recording(changes: dict[str, object]) -> None:
    first, same, other = (FishRecording(table_of(**each)).fingerprint for each in ({}, {}, changes))
    assert first == same != other
