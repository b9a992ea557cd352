"""What gap methods ship is learnt from simulated swims."""

from __future__ import annotations

import json

import numpy as np
import pytest

from scenarios import catalog
from tools.learn.swims import PRIOR_PATH, detected_track, fit_noise, learn_swims, write
from trackers.gaps import Piece
from trackers.swimmer.method import GAPS, KNOTS, SHARES, shipped


def test_the_noise_of_known_swims_is_found() -> None:
    rng, tracks = np.random.default_rng(0), []
    for _ in range(6):
        jerk = 0.02 * rng.normal(size=(500, 2))
        x = np.cumsum(np.cumsum(np.cumsum(jerk, axis=0), axis=0), axis=0) + 0.4 * rng.normal(size=(500, 2))
        tracks.append(Piece(0, x, 1 / 30))
    found = fit_noise(tracks)
    assert found.measured_px == pytest.approx(0.4, rel=0.1)
    assert found.jerk_px == pytest.approx(0.02, rel=0.3)


@pytest.mark.heavy
def test_what_is_learnt_is_the_same_each_time_and_is_read_as_written(tmp_path) -> None:
    content = learn_swims(range(2))
    assert content == learn_swims(range(2))
    assert json.loads(write(tmp_path / "prior.json", content, "by test").read_text()) == content | {
        "command": "by test"
    }
    shapes = [{key: np.shape(value) for key, value in each.items()} for each in content["ahead"] + content["between"]]
    kept = json.loads(PRIOR_PATH.read_text())
    assert shapes == [{key: np.shape(value) for key, value in each.items()} for each in kept["ahead"] + kept["between"]]
    ahead, between = shipped()
    assert set(ahead) == set(KNOTS)
    assert set(between) == {(gap, share) for gap in GAPS for share in SHARES}


@pytest.mark.heavy
def test_the_detected_track_goes_where_the_fish_swims() -> None:
    frames, known = 160, 60
    track = detected_track("paper-c", 5, frame_count=frames)
    episode = catalog.scenario("fish-tank").episode("paper-c", 5)
    true_px = np.array([episode.step().truth.position_px[0] for _ in range(frames)])
    episode.close()
    assert np.isfinite(track.position_px).all()
    # Once the detector knows the fish; a track that stands still would be off by 2 px in the median.
    swum_px = true_px[-1] - true_px[known]
    off_px = np.linalg.norm(track.position_px - true_px, axis=1)[known:]
    assert np.hypot(*swum_px) > 8.0
    assert np.median(off_px) < 0.4
    assert off_px.max() < 1.2
    assert track.heading_rad is not None
    aside_rad = track.heading_rad - np.arctan2(swum_px[1], swum_px[0])
    assert abs(np.median(np.arctan2(np.sin(aside_rad), np.cos(aside_rad)))) < 0.1


@pytest.mark.heavy
def test_what_is_shipped_is_what_the_command_learns() -> None:
    kept, content = json.loads(PRIOR_PATH.read_text()), learn_swims(range(80))
    assert kept["command"] == "python -m tools learn-swims --seeds 0:80"
    for part in ("ahead", "between"):
        for old, new in zip(kept[part], content[part], strict=True):
            for key, value in new.items():
                # By 0.0085 at most when measured, the reason unknown; with one episode of the 80 less by 0.085.
                off = np.linalg.norm(np.subtract(old[key], value)) / np.linalg.norm(old[key])
                assert off < 0.01, (part, key, off)
