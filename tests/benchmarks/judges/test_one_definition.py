"""A metric of one name is the same number in every suite."""

from __future__ import annotations

import pytest

from benchmarks.contract.judging import Ending
from benchmarks.judges.follow.judge import FollowJudge
from benchmarks.judges.frame_out.judge import FrameOutJudge
from scenarios.road_town.scenario import ROAD_TOWN
from tests.benchmarks.fake_episode import FakeEpisode
from trackers.types import CameraCommand, Estimate


def test_view_and_losses_of_a_steered_camera_are_those_of_the_suite_follow() -> None:
    episode = FakeEpisode(closed_loop=True)
    judges = [judge(episode, ROAD_TOWN) for judge in (FrameOutJudge, FollowJudge)]
    sheets = [judge.sheet() for judge in judges]
    for k in range(episode.frame_count):
        frame = episode.step()
        for judge, sheet in zip(judges, sheets, strict=True):
            judge.see(frame, None if k == 0 else CameraCommand())
            sheet.keep(frame, Estimate(frame.truth.position_px[0]))
    told, by_follow = (
        {score.metric: (score.value, score.weight) for score in sheet.scores(Ending())} for sheet in sheets
    )
    names = ("time_seen", "time_in_view", "losses_per_minute")
    assert {name: told[name] for name in names} == {name: by_follow[name] for name in names}
    # The centre of the box leaves with frame 14, and the box is whole up to frame 12: 15 frames a second, one loss.
    steps = episode.frame_count - 1
    assert told["time_in_view"] == (pytest.approx(13 / steps), steps)
    assert told["time_seen"] == (pytest.approx(12 / steps), steps)
    assert told["losses_per_minute"] == (pytest.approx(60 * 15 / steps), steps)
