"""The env ids in Gymnasium's vector envs, and failures of envs in processes of their own."""

from __future__ import annotations

import contextlib
import os
import signal
import subprocess
import sys
from functools import partial
from pathlib import Path
from typing import Any

import gymnasium as gym
import numpy as np
import pytest

from benchmarks.cli import main as cli
from scenarios.envs.follow_env import FollowEnv
from scenarios.envs.processes import EnvProcesses
from scenarios.envs.truth_info import INFO, truth_keys
from tests.fakes_trackers import NoParameters, Still
from tests.scenarios.envs.compared import assert_same
from tests.scenarios.envs.stand_in import IDS, stand_in
from tests.scenarios.envs.stand_in import keywords as of_ids

__all__ = ["stand_in"]

COUNT, LAST_FRAME = 2, 11
ROOT = Path(__file__).parents[3]


def keywords() -> dict[str, Any]:
    """Return the keywords of an env in the world without a renderer; the tracker carries that world to processes."""
    tracker = Still(NoParameters(), np.random.default_rng(0))
    changes = {"frame_count": LAST_FRAME + 1}
    return {"scenario": "fake-town-v1", "preset": "tiny", "tracker": tracker, "changes": changes, "observation": "both"}


def processes() -> EnvProcesses:
    return EnvProcesses([partial(FollowEnv, **keywords())] * COUNT)


def assert_episodes_of_single_envs(envs: gym.vector.VectorEnv, single: list[gym.Env]) -> None:
    """Compare two episodes of each env, with seeds and options, with those of single envs; infos have their keys."""
    results, alone = envs.reset(seed=7, options={"link": "noisy"}), []
    for k, env in enumerate(single):
        alone.append(env.reset(seed=7 + k, options={"link": "noisy"}))
    rng = np.random.default_rng(5)
    ended = 0
    over = np.zeros(len(single), dtype=bool)
    while True:
        for k in range(len(single)):
            assert_same({key: results[0][key][k] for key in alone[k][0]}, alone[k][0])
            for key, value in alone[k][-1].items():
                np.testing.assert_array_equal(results[-1][key][k], value, err_msg=key)
            if len(results) == 5 and len(alone[k]) == 5:
                assert [each[k] for each in results[1:4]] == list(alone[k][1:4])
        if ended == 2:
            return
        actions = rng.uniform(-1, 1, envs.action_space.shape).astype(np.float32)
        results = envs.step(actions)
        alone = [env.reset() if over[k] else env.step(actions[k]) for k, env in enumerate(single)]
        over = results[2] | results[3]
        ended += int(over.all())


@pytest.mark.usefixtures("stand_in")
@pytest.mark.parametrize("env_id", IDS)
@pytest.mark.parametrize("mode", [{}, {"vectorization_mode": "sync"}])
def test_gymnasium_s_vector_envs_take_the_ids(env_id, mode):
    single = [gym.make(env_id, **of_ids()) for _ in range(COUNT)]
    with contextlib.closing(gym.make_vec(env_id, COUNT, **mode, **of_ids())) as envs:
        assert_episodes_of_single_envs(envs, single)


@pytest.mark.usefixtures("stand_in")
def test_rendered_envs_side_by_side_take_a_limit_of_steps_and_refuse_what_single_ones_do():
    with contextlib.closing(gym.make_vec(IDS[0], COUNT, max_episode_steps=2, **of_ids())) as envs:
        envs.reset(seed=0)
        assert [envs.step(envs.action_space.sample())[3].all() for _ in range(2)] == [False, True]
    with pytest.raises(ValueError, match=r"keywords: expected one of tracker, preset, .*; got 'weather'"):
        gym.make_vec(IDS[0], COUNT, weather="bad")
    with pytest.raises(ValueError, match="num_envs: expected a whole number >= 1, got 0"):
        gym.make_vec(IDS[0], 0)


@pytest.mark.heavy
def test_processes_live_as_single_envs_do():
    with contextlib.closing(processes()) as envs:
        assert_episodes_of_single_envs(envs, [FollowEnv(**keywords()) for _ in range(COUNT)])


def test_info_says_what_is_declared():
    env = FollowEnv(**keywords())
    _, info = env.reset(seed=0)
    keys = INFO | truth_keys(type(env.episode.frame.truth))
    declared = {key: (dtype, shape) for key, (dtype, shape, _) in keys.items()}
    assert {key: (str(np.asarray(value).dtype), np.shape(value)) for key, value in info.items()} == declared


@pytest.mark.heavy
def test_a_process_that_is_killed_is_told_in_one_line_and_the_others_are_ended(monkeypatch, capsys):
    with contextlib.closing(processes()) as envs:
        ids = [process.pid for process in envs.processes]
        envs.reset(seed=0)
        os.kill(ids[0], signal.SIGKILL)

        class Steps:
            resumes = False

            def run(self) -> int:
                while True:
                    envs.step(np.zeros((COUNT, 4), np.float32))

        monkeypatch.setattr(cli, "_parsed", lambda *_: Steps())
        assert cli.main(["list"]) == 1
    results = capsys.readouterr().err.splitlines()
    assert results == ["error: envs: expected every process to answer, got the end of one (out of memory?)"]
    assert not any(is_alive(each) for each in ids)


SCRIPT = """
import contextlib, signal
import numpy as np
from tests.scenarios.envs.test_vector_env import COUNT, processes

# A shell that started the tests in the background made all of them deaf to Ctrl-C.
signal.signal(signal.SIGINT, signal.default_int_handler)
with contextlib.closing(processes()) as envs:
    envs.reset(seed=0)
    print(*(process.pid for process in envs.processes), flush=True)
    while True:
        envs.step(np.zeros((COUNT, 4), np.float32))
"""


@pytest.mark.heavy
def test_ctrl_c_ends_all_processes_with_one_traceback():
    command = [sys.executable, "-W", "error", "-c", SCRIPT]
    pipes: dict[str, Any] = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, "text": True}
    with subprocess.Popen(command, cwd=ROOT, start_new_session=True, **pipes) as process:
        assert process.stdout is not None
        ids = [int(each) for each in process.stdout.readline().split()]
        assert len(ids) == COUNT
        assert all(is_alive(each) for each in ids)
        # As from a terminal: to every process of the group.
        os.killpg(process.pid, signal.SIGINT)
        complaints = output_of(process)[1]
    assert complaints.count("Traceback") == 1
    assert complaints.rstrip().endswith("KeyboardInterrupt")
    assert process.returncode == -signal.SIGINT
    assert not any(is_alive(each) for each in ids)


def output_of(process: subprocess.Popen[str]) -> tuple[str, str]:
    """Return the output of a process that ends by itself; another one is killed, so that the test does not wait."""
    try:
        return process.communicate(timeout=60)
    except subprocess.TimeoutExpired:
        process.kill()
        raise


def is_alive(process_id: int) -> bool:
    """Return whether a process runs; a zombie does not count."""
    try:
        return Path(f"/proc/{process_id}/stat").read_text().rsplit(")", 1)[1].split()[0] != "Z"
    except (FileNotFoundError, ProcessLookupError):
        return False
