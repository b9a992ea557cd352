"""The judge of the suite ``follow`` on drawn episodes."""

from __future__ import annotations

import numpy as np
import pytest

from benchmarks.contract.judging import Ending
from benchmarks.judges.follow.judge import FollowJudge
from scenarios import catalog
from scenarios.envs.follow_env import FollowEnv
from scenarios.scenario import Frame
from scenarios.stereo_follow.robot import FASTEST_MPS
from scenarios.visibility import is_in_view
from tests.benchmarks.judges.follow import fake_follow
from tests.benchmarks.judges.follow.fake_follow import HIDDEN, RATE_HZ, people_m
from trackers.types import CameraCommand, Estimate

HALF_SPEED = CameraCommand(forward_mps=0.5 * FASTEST_MPS)


def scores_of(
    estimates: dict[int, Estimate] | None = None, failed_at_frame: int | None = None
) -> tuple[dict[str, float | None], list[Frame]]:
    """Run the drawn episode at half speed; return the scores of whole episodes and the frames."""
    episode = fake_follow.FAKE_FOLLOW.episode("tiny", 0)
    judge = FollowJudge(episode, fake_follow.FAKE_FOLLOW)
    sheet, frames = judge.sheet(), []
    for k in range(episode.frame_count):
        frame = episode.step()
        frames.append(frame)
        judge.see(frame, None if k == 0 else HALF_SPEED)
        target_px = frame.truth.position_px[0]
        sheet.keep(frame, (estimates or {}).get(k, Estimate(target_px, in_view_probability=0.9)))
    return {each.metric: each.value for each in sheet.scores(Ending(failed_at_frame)) if each.event is None}, frames  # type: ignore[misc]


def test_scores_are_those_of_what_was_seen() -> None:
    scores, frames = scores_of()
    in_view = [is_in_view(frame.truth, 0, frame.camera) for frame in frames]
    assert scores["time_in_view"] == pytest.approx(np.mean(in_view[1:]))
    assert scores["time_in_view"] == 1.0
    # Hidden is not seen.
    visible = [frame.truth.visible_fraction[0] for frame in frames]
    assert scores["time_seen"] == pytest.approx(1.0 - len(HIDDEN) / (len(frames) - 1))
    assert [k for k, share in enumerate(visible) if share < 0.5] == list(HIDDEN)
    assert scores["effort"] == pytest.approx(0.5 / np.sqrt(2))
    assert scores["jerkiness_per_s"] == pytest.approx(RATE_HZ * 0.5 / np.sqrt(2) / (len(frames) - 1))
    assert scores["wrong_target_rate"] == 0.0
    # Five metres is too far for EVT-Bench and ends its episode.
    assert min(np.linalg.norm(people_m(k)[0]) for k in range(len(frames))) > 4.0
    assert (scores["evt_success_rate"], scores["evt_tracking_rate"], scores["evt_collision_rate"]) == (0.0, 0.0, 0.0)
    assert (scores["sr_500"], scores["episode_length_steps"]) == (1.0, len(frames) - 1.0)


def test_a_tracker_that_says_when_it_sees_has_both_rates() -> None:
    hidden = {k: Estimate(np.full(2, 5.0), in_view_probability=0.1) for k in HIDDEN}
    scores, _ = scores_of(hidden)
    assert (scores["in_view_tpr"], scores["in_view_tnr"]) == (1.0, 1.0)
    silent = {k: Estimate(np.full(2, np.nan)) for k in range(40, 70)}
    scores, frames = scores_of({**hidden, **silent}, failed_at_frame=40)
    assert scores["in_view_tpr"] == pytest.approx((40 - len(HIDDEN)) / (len(frames) - len(HIDDEN)))
    assert scores["silent_frames"] == 30.0


def test_the_return_is_the_sum_of_the_env_s_rewards() -> None:
    env = FollowEnv("road-town-v2", preset="quick", tracker="hold")
    env.reset(options={"episode_seed": 3})
    judge = FollowJudge(env.episode.episode, catalog.scenario("road-town-v2"))
    judge.see(env.episode.frame, None)
    total = 0.0
    for k in range(100):
        total += env.step(np.array([1.0 if k > 40 else 0.0, 0.0, 0.0, 0.0]))[1]
        judge.see(env.episode.frame, env.episode.obeyed)
    scores = {each.metric: each.value for each in judge.scores() if each.event is None}
    assert scores["episode_return"] == pytest.approx(total)
    # The car was in the picture, and left it for long enough to be lost.
    assert 0.1 < scores["time_in_view"] < 0.9  # type: ignore[operator]
    assert scores["losses_per_minute"] > 0  # type: ignore[operator]
