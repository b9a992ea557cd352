"""The vector env against Gymnasium's own, and what happens when something in it goes wrong."""

from __future__ import annotations

import contextlib
import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import gymnasium as gym
import numpy as np
import pytest
from gymnasium.vector import AutoresetMode, SyncVectorEnv

from scenarios.envs.follow_env import FollowEnv
from scenarios.envs.ids import register_envs
from scenarios.envs.truth_info import INFO
from scenarios.envs.vector_env import FollowVectorEnv
from tests.fakes_scenario import NoParameters, Raises, Still
from tests.scenarios.envs.compared import assert_same
from tests.scenarios.envs.stand_in import IDS, stand_in
from tests.scenarios.envs.stand_in import keywords as of_ids

__all__ = ["stand_in"]

COUNT, LAST_FRAME = 3, 11
ROOT = Path(__file__).parents[3]
register_envs()


def keywords(**others: Any) -> dict[str, Any]:
    """Return those of an env of the world without a renderer; the tracker brings it along to workers."""
    tracker = Still(NoParameters(), np.random.default_rng(0))
    changes = {"frame_count": LAST_FRAME + 1}
    base = {"scenario": "fake-town-v1", "preset": "tiny", "tracker": tracker, "changes": changes, "observation": "both"}
    return base | others


@pytest.fixture(scope="module")
def worked() -> Iterator[FollowVectorEnv]:
    """Three envs in two workers."""
    envs = FollowVectorEnv(COUNT, workers=2, render_mode="rgb_array", **keywords())
    yield envs
    envs.close()


def live_through(envs: gym.vector.VectorEnv) -> list[Any]:
    """Return all that two episodes and a bit bring, with a reset of some of the envs on the way."""
    rng = np.random.default_rng(5)
    told: list[Any] = [envs.reset(seed=7)]
    for k in range(2 * LAST_FRAME + 5):
        if k == 4:
            told.append(envs.reset(seed=[None, 3, 9], options={"reset_mask": np.array([False, True, True])}))
        told.append(envs.step(rng.uniform(-1, 1, envs.action_space.shape).astype(np.float32)))
    told.append(envs.reset())
    told.append(envs.reset(seed=1, options={"link": "noisy"}))
    told.append(envs.step(envs.action_space.low))
    return told


def gymnasium_s_own(**others: Any) -> SyncVectorEnv:
    return SyncVectorEnv([lambda: FollowEnv(**keywords(**others)) for _ in range(COUNT)])


def test_it_returns_exactly_what_gymnasium_s_own_does_whoever_steps_the_envs(worked):
    with contextlib.closing(gymnasium_s_own()) as reference:
        expected = live_through(reference)
    assert_same(tuple(live_through(worked)), tuple(expected))
    with contextlib.closing(FollowVectorEnv(COUNT, workers=0, **keywords())) as here:
        assert_same(tuple(live_through(here)), tuple(expected))
        assert here.observation_space == reference.observation_space == worked.observation_space
        assert here.action_space == reference.action_space
    truncated = np.array([each[3] for each in expected if len(each) == 5])
    assert (truncated.sum(axis=0) >= 2).all(), "episodes ended and began by themselves"


def test_what_one_observation_consists_of_alone_is_no_dictionary():
    for mode in ("track", "pixels"):
        with contextlib.closing(gymnasium_s_own(observation=mode)) as reference:
            expected = live_through(reference)
        with contextlib.closing(FollowVectorEnv(COUNT, workers=0, **keywords(observation=mode))) as here:
            assert_same(tuple(live_through(here)), tuple(expected))


def test_what_is_returned_is_fresh_unless_a_copy_is_declined(worked):
    still = np.zeros(worked.action_space.shape)
    worked.reset(seed=2)
    first, *rest = worked.step(still)
    kept = first["track"].copy(), rest[0].copy(), rest[-1]["time_s"].copy()
    worked.step(still + 1)
    for was, now in zip(kept, (first["track"], rest[0], rest[-1]["time_s"]), strict=True):
        np.testing.assert_array_equal(was, now)
    with contextlib.closing(FollowVectorEnv(COUNT, workers=0, copy=False, **keywords())) as shared:
        observed, _ = shared.reset(seed=2)
        again = shared.step(still)[0]
        assert np.shares_memory(observed["track"], again["track"])


@pytest.mark.usefixtures("stand_in")
@pytest.mark.parametrize("mode", ["sync", "async"])
def test_gymnasium_s_own_vector_envs_take_the_ids(mode):
    with (
        contextlib.closing(gym.make_vec(IDS[0], 2, vectorization_mode=mode, **of_ids())) as theirs,
        contextlib.closing(gym.make_vec(IDS[0], 2, workers=0, **of_ids())) as ours,
    ):
        assert_same(theirs.reset(seed=4), ours.reset(seed=4))
        for action in np.random.default_rng(0).uniform(-1, 1, (5, *ours.action_space.shape)).astype(np.float32):
            assert_same(theirs.step(action), ours.step(action))


def test_make_vec_makes_it_and_its_time_limit_truncates():
    tracker = "hold"
    changes = {"width_px": 84, "height_px": 84}
    envs = gym.make_vec("frameout/RoadTownFollow-v1", 2, tracker=tracker, preset="quick", changes=changes, workers=0)
    assert isinstance(envs, FollowVectorEnv)
    assert envs.metadata["autoreset_mode"] is AutoresetMode.NEXT_STEP
    assert envs.settings.tracker == "hold"
    envs.close()
    with contextlib.closing(FollowVectorEnv(2, max_episode_steps=4, workers=0, **keywords())) as limited:
        limited.reset(seed=0)
        still = np.zeros(limited.action_space.shape)
        truncated = [bool(limited.step(still)[3].all()) for _ in range(10)]
    # The fifth begins another episode.
    assert truncated == [False, False, False, True, False, False, False, False, True, False]


def test_info_says_what_is_declared():
    env = FollowEnv(**keywords())
    _, info = env.reset(seed=0)
    declared = {key: (dtype, shape) for key, (dtype, shape, _) in INFO.items()}
    assert {key: (str(np.asarray(value).dtype), np.shape(value)) for key, value in info.items()} == declared


def test_rendering_gives_a_picture_of_every_env(worked):
    worked.reset(seed=0)
    pictures = worked.render()
    assert isinstance(pictures, tuple)
    assert [picture.shape for picture in pictures] == [(192, 256, 3)] * COUNT


def test_what_is_asked_wrongly_is_refused_and_nothing_is_stepped(worked):
    worked.reset(seed=0)
    for bad in (np.zeros((2, 4)), np.full((COUNT, 4), np.nan), np.full((COUNT, 4), 1.5), "left"):
        with pytest.raises(ValueError, match=r"action: expected numbers of shape \(3, 4\) from -1 to 1, got"):
            worked.step(bad)
    with pytest.raises(ValueError, match=r"options: expected keys among episode_seed, .* got 'weather'"):
        worked.reset(options={"weather": "bad"})
    with pytest.raises(ValueError, match="episode_seed: expected a whole number >= 0, got -1"):
        worked.reset(options={"episode_seed": -1})
    with pytest.raises(ValueError, match="seed: expected as many as there are envs, 3, got 2"):
        worked.reset(seed=[1, 2])
    for mask in (np.zeros(COUNT, dtype=bool), np.ones(COUNT), [True] * COUNT):
        with pytest.raises(ValueError, match=r"reset_mask: expected an array of bool of shape \(3,\)"):
            worked.reset(options={"reset_mask": mask})
    assert (worked.step(np.zeros((COUNT, 4)))[-1]["frame"] == 1).all()


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        ({"num_envs": 0}, "num_envs: expected a whole number >= 1, got 0"),
        ({"workers": -1}, "workers: expected None or a whole number >= 0, got -1"),
        ({"max_episode_steps": 0}, "max_episode_steps: expected a whole number >= 1, -1 or None, got 0"),
        ({"render_mode": "human"}, "render_mode: expected None or rgb_array, got 'human'"),
        ({"weather": "bad"}, "keywords: expected some of .*, got 'weather'"),
        (
            {"tracker": type("Local", (Still,), {})(NoParameters(), None)},
            "keywords: expected values that can be pickled",
        ),
    ],
)
def test_an_unfit_keyword_is_refused_at_once(wrong, message):
    with pytest.raises(ValueError, match=message):
        FollowVectorEnv(**keywords(**wrong))


def test_before_a_reset_and_after_closing_there_are_no_steps():
    envs = FollowVectorEnv(2, workers=0, **keywords())
    with pytest.raises(gym.error.ResetNeeded):
        envs.step(np.zeros((2, 4)))
    envs.close()
    envs.close()
    for act in (envs.reset, lambda: envs.step(np.zeros((2, 4)))):
        with pytest.raises(gym.error.ClosedEnvironmentError):
            act()


@pytest.mark.parametrize("workers", [0, 2])
def test_a_tracker_that_raises_is_named_with_its_env_and_everything_is_closed(workers):
    tracker = Raises(NoParameters(), np.random.default_rng(0))
    envs = FollowVectorEnv(COUNT, workers=workers, **keywords(tracker=tracker, changes={"frame_count": 40}))
    ids = envs.worker_ids
    envs.reset(seed=0)
    # Env 1 is 5 frames ahead of the others.
    step_on(envs, 5)
    envs.reset(options={"reset_mask": np.array([True, False, True])})
    with pytest.raises(RuntimeError, match=r"^env 1: expected it to step, got RuntimeError: tracker: .* bug") as error:
        step_on(envs, 20)
    assert "misbehave" in "".join(error.value.__notes__), "the place in the tracker's code is told"
    assert envs.closed
    assert len(ids) == workers
    assert not any(is_alive(each) for each in ids)


@pytest.mark.parametrize(("killed", "its_envs"), [(0, "0, 1"), (1, "2")])
def test_a_worker_that_is_killed_is_named_with_its_envs_and_the_others_are_closed(killed: int, its_envs: str):
    envs = FollowVectorEnv(COUNT, workers=2, **keywords())
    ids = envs.worker_ids
    envs.reset(seed=0)
    os.kill(ids[killed], signal.SIGKILL)
    named = rf"^worker {killed} \(envs {its_envs}\): expected it to answer, got its end \(exit code -9"
    with pytest.raises(RuntimeError, match=named):
        step_on(envs, 3)
    assert envs.closed
    assert not any(is_alive(each) for each in ids)


SCRIPT = """
import signal, sys
import numpy as np
from scenarios.envs.vector_env import FollowVectorEnv
from tests.scenarios.envs.test_vector_env import keywords

# A shell that started the tests in the background made all of them deaf to Ctrl-C.
signal.signal(signal.SIGINT, signal.default_int_handler)
envs = FollowVectorEnv(2, workers=1, **keywords())
envs.reset(seed=0)
print(*envs.worker_ids, flush=True)
while True:
    envs.step(np.zeros((2, 4)))
    if "leave" in sys.argv:
        break
"""


def start(*arguments: str) -> subprocess.Popen[str]:
    command = [sys.executable, "-W", "error", "-c", SCRIPT, *arguments]
    pipes: dict[str, Any] = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, "text": True}
    return subprocess.Popen(command, cwd=ROOT, start_new_session=True, **pipes)


def test_ctrl_c_ends_all_processes_with_one_traceback():
    with start() as process:
        assert process.stdout is not None
        ids = [int(each) for each in process.stdout.readline().split()]
        assert all(is_alive(each) for each in ids)
        # As a terminal does: to every process of the group.
        os.killpg(process.pid, signal.SIGINT)
        complaints = told_by(process)[1]
    assert complaints.count("Traceback") == 1
    assert complaints.rstrip().endswith("KeyboardInterrupt")
    assert process.returncode == -signal.SIGINT
    assert not any(is_alive(each) for each in ids)


def test_who_forgets_to_close_leaves_nothing_behind_and_hears_nothing():
    with start("leave") as process:
        output, complaints = told_by(process)
    assert complaints == ""
    assert process.returncode == 0
    assert not any(is_alive(int(each)) for each in output.split())


def test_workers_end_when_the_process_that_holds_them_is_killed():
    with start() as process:
        assert process.stdout is not None
        ids = [int(each) for each in process.stdout.readline().split()]
        process.kill()
        process.communicate(timeout=60)
    until = time.monotonic() + 20
    while any(is_alive(each) for each in ids):
        assert time.monotonic() < until, "a worker lives on"
        time.sleep(0.05)


def told_by(process: subprocess.Popen[str]) -> tuple[str, str]:
    """Return what a process that ends by itself said; one that does not is killed, so that nobody waits for it."""
    try:
        return process.communicate(timeout=60)
    except subprocess.TimeoutExpired:
        process.kill()
        raise


def step_on(envs: FollowVectorEnv, steps: int) -> None:
    """Step without a movement."""
    for _ in range(steps):
        envs.step(np.zeros((envs.num_envs, 4)))


def is_alive(process_id: int) -> bool:
    """Return whether a process runs; one that has ended and was not asked how does not count."""
    try:
        return Path(f"/proc/{process_id}/stat").read_text().rsplit(")", 1)[1].split()[0] != "Z"
    except (FileNotFoundError, ProcessLookupError):
        return False
