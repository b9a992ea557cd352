"""Refusals of an env, which leave nothing behind."""

from __future__ import annotations

from typing import Any

import gymnasium as gym
import numpy as np
import pytest

from scenarios.envs.follow_env import FollowEnv
from tests import fakes_scenario
from tests.fakes_trackers import HalfNan, Raises, Still
from tests.scenarios.envs.compared import assert_same
from tests.scenarios.envs.stand_in import IDS, fresh, keywords, make, stand_in
from trackers.types import Observation

__all__ = ["stand_in"]
pytestmark = pytest.mark.usefixtures("stand_in")


def test_an_action_that_is_none_is_refused_and_does_not_count():
    env = make()
    env.reset(seed=0)
    for bad in (np.full(4, np.nan), np.full(4, np.inf), np.array([0, 0, 0, 1.01]), np.zeros(3), np.zeros((1, 4)), "up"):
        with pytest.raises(ValueError, match=r"^action: expected numbers of shape \(4,\) from -1 to 1, got"):
            env.step(bad)  # type: ignore[arg-type]
    assert env.step(np.zeros(4))[-1]["frame"] == 1


def test_an_action_out_of_range_is_clipped_if_so_asked_and_one_that_is_not_finite_refused():
    clipping, other = make(out_of_range="clip"), make()
    for env in (clipping, other):
        env.reset(seed=0)
    for bad in (np.full(4, np.nan), np.full(4, -np.inf), np.zeros(3), "up"):
        with pytest.raises(ValueError, match=r"^action: expected finite numbers of shape \(4,\), got"):
            clipping.step(bad)  # type: ignore[arg-type]
    for action in ([5.0, -0.3, -7.0, 1.01], [0.1, 0.2, 0.3, 0.4]):
        assert_same(clipping.step(np.array(action)), other.step(np.clip(action, -1.0, 1.0)))
    with pytest.raises(ValueError, match="out_of_range: expected one of refuse, clip; got 'wrap'"):
        make(out_of_range="wrap")


@pytest.mark.parametrize("tracker", [Raises, HalfNan])
def test_a_tracker_that_fails_inside_a_step_is_named_and_a_reset_mends_it(tracker):
    env = make(tracker=fresh(tracker))
    env.reset(options={"episode_seed": 8})
    for _ in range(19):
        env.step(np.zeros(4))
    with pytest.raises(
        RuntimeError, match=f"tracker: expected an estimate of {tracker.__name__} after frame 20 of .* 8"
    ):
        env.step(np.zeros(4))
    with pytest.raises(gym.error.ResetNeeded):
        env.step(np.zeros(4))
    env.reset(seed=0)
    env.step(np.zeros(4))


class NeverBegins(Still):
    """Fails at once."""

    def initialise(self, observation: Observation, box_xyxy: Any) -> None:
        raise ZeroDivisionError("nothing")


def test_the_world_is_freed_when_a_tracker_does_not_begin(monkeypatch):
    closed = []
    monkeypatch.setattr(fakes_scenario.FakeEpisode, "close", lambda self: closed.append(self))
    with pytest.raises(RuntimeError, match=r"tracker: expected an estimate of NeverBegins after frame 0 .*nothing"):
        make(tracker=fresh(NeverBegins)).reset(seed=0)
    assert len(closed) == 1


def test_every_world_is_freed_before_the_next(monkeypatch):
    closed = []
    monkeypatch.setattr(fakes_scenario.FakeEpisode, "close", lambda self: closed.append(self))
    env = make()
    for expected in range(3):
        env.reset(seed=expected)
        assert len(closed) == expected
    env.close()
    assert len(closed) == 3


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"weather": 1}, "options: expected keys among episode_seed, world_seed, preset, .*, got 'weather'"),
        ({"episode_seed": -1}, "episode_seed: expected a whole number >= 0, got -1"),
        ({"episode_seed": 1.5}, "episode_seed: expected a whole number >= 0, got 1.5"),
        ({"changes": {"wheels": 3}}, "changes: expected one of frame_count, .*; got 'wheels'"),
        ({"changes": {"width_px": 200}}, r"options: expected pictures of the size \(120, 160, 3\), .*, got"),
    ],
)
def test_unfit_options_are_refused_and_the_episode_goes_on(options, message):
    env = make()
    env.reset(seed=0)
    env.step(np.zeros(4))
    with pytest.raises(ValueError, match=message):
        env.reset(options=options)
    assert env.step(np.zeros(4))[-1]["frame"] == 2


def test_after_a_first_reset_that_was_refused_a_good_one_is_needed_and_enough():
    # After a refused first reset Gymnasium's passive checker fails in the first step.
    env = gym.make(IDS[0], disable_env_checker=True, **keywords())
    with pytest.raises(ValueError, match="episode_seed: expected a whole number >= 0, got -1"):
        env.reset(options={"episode_seed": -1})
    with pytest.raises(gym.error.ResetNeeded, match="step: expected an episode that runs, got none"):
        env.step(np.zeros(4))
    env.reset(seed=0)
    assert env.step(np.zeros(4, np.float32))[-1]["frame"] == 1


def test_a_window_without_a_screen_is_refused_when_the_env_is_made(monkeypatch):
    pytest.importorskip("pygame")
    for name in ("DISPLAY", "WAYLAND_DISPLAY", "SDL_VIDEODRIVER"):
        monkeypatch.delenv(name, raising=False)
    with pytest.raises(ValueError, match=r"render_mode: expected a screen to open a window on .*, got none"):
        make(render_mode="human")
    monkeypatch.setenv("SDL_VIDEODRIVER", "x11")
    with pytest.raises(ValueError, match=r"render_mode: expected a screen .*, got none .*x11 not available"):
        make(render_mode="human")
    # On request, the window is invisible.
    monkeypatch.setenv("SDL_VIDEODRIVER", "dummy")
    env = make(render_mode="human")
    env.reset(seed=0)
    assert env.render() is None
    env.close()


def test_unknown_keywords_and_render_modes_are_refused():
    with pytest.raises(ValueError, match=r"keywords: expected one of tracker, preset, .*; got 'weather'"):
        make(weather="bad")
    with pytest.raises(ValueError, match=r"got 'observations' \(did you mean observation\?\)"):
        make(observations="pixels")
    with pytest.raises(
        ValueError,
        match=r"pictures: .* gym.make_vec\(…, pictures=False\) alone, without a vectorization_mode, got False",
    ):
        make(pictures=False)
    with pytest.raises(ValueError, match="render_mode: expected None or one of rgb_array, human, got 'ansi'"):
        FollowEnv("road-town-v2", render_mode="ansi", **keywords())
