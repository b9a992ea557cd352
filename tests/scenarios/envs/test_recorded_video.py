"""Gymnasium's ``RecordVideo`` writes what an env renders: a picture after the reset, and one after every step."""

from __future__ import annotations

from pathlib import Path

import av
import gymnasium as gym
import numpy as np
import pytest
from gymnasium.wrappers import RecordVideo

from tests.scenarios.envs.stand_in import IDS, keywords, stand_in

__all__ = ["stand_in"]
STEPS = 5


@pytest.mark.usefixtures("stand_in")
def test_a_video_has_a_frame_for_the_reset_and_each_step_at_the_preset_s_rate(tmp_path: Path) -> None:
    pytest.importorskip("moviepy")
    changes = {"frame_count": STEPS + 1, "rate_hz": 10.0}
    env = RecordVideo(gym.make(IDS[0], render_mode="rgb_array", **keywords(changes=changes)), str(tmp_path / "video"))
    env.reset(seed=0)
    shown = []
    ended = False
    while not ended:
        shown.append(env.render())
        _, _, terminated, truncated, _ = env.step(np.zeros(4, np.float32))
        ended = terminated or truncated
    shown.append(env.render())
    env.close()
    [file] = (tmp_path / "video").glob("*.mp4")
    with av.open(str(file)) as video:
        assert video.streams.video[0].average_rate == 10
        frames = [frame.to_ndarray(format="rgb24") for frame in video.decode(video=0)]
    assert len(frames) == len(shown) == STEPS + 1
    for frame, picture in zip(frames, shown, strict=True):
        assert picture is not None
        assert frame.shape == picture.shape
        # Compressed, and with colours of half the resolution.
        assert np.abs(frame.astype(float) - picture).mean() < 12.0
