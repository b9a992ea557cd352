"""The env ids in Gymnasium's vector envs, and failures of envs in processes of their own."""

from __future__ import annotations

import contextlib
import os
import signal
import subprocess
import sys
import time
from functools import partial
from pathlib import Path
from typing import Any

import gymnasium as gym
import numpy as np
import pytest
from gymnasium.vector import AutoresetMode

from benchmarks.cli import main as cli
from scenarios.envs.follow_env import FollowEnv
from scenarios.envs.truth_info import INFO, truth_keys
from scenarios.envs.vectors import FollowVectorEnv
from tests.fakes_trackers import NoParameters, Still
from tests.scenarios.envs.compared import assert_same
from tests.scenarios.envs.stand_in import IDS, stand_in
from tests.scenarios.envs.stand_in import keywords as of_ids
from trackers.types import Estimate, Observation

__all__ = ["stand_in"]

COUNT, LAST_FRAME = 2, 11
ROOT = Path(__file__).parents[3]


def keywords() -> dict[str, Any]:
    """Return the keywords of an env in the world without a renderer; the tracker carries that world to processes."""
    tracker = Still(NoParameters(), np.random.default_rng(0))
    changes = {"frame_count": LAST_FRAME + 1}
    return {"scenario": "fake-town-v1", "preset": "tiny", "tracker": tracker, "changes": changes, "observation": "both"}


def side_by_side(workers: int = 2, count: int = COUNT, **others: Any) -> FollowVectorEnv:
    return FollowVectorEnv(count, workers=workers, **keywords() | others)


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
@pytest.mark.parametrize("mode", [{"workers": 0}, {"vectorization_mode": "sync"}])
def test_gymnasium_s_vector_envs_take_the_ids(env_id, mode):
    single = [gym.make(env_id, **of_ids()) for _ in range(COUNT)]
    with contextlib.closing(gym.make_vec(env_id, COUNT, **mode, **of_ids())) as envs:
        assert_episodes_of_single_envs(envs, single)


@pytest.mark.usefixtures("stand_in")
def test_rendered_envs_side_by_side_take_a_limit_of_steps_and_refuse_what_single_ones_do():
    with contextlib.closing(gym.make_vec(IDS[0], COUNT, max_episode_steps=2, workers=0, **of_ids())) as envs:
        envs.reset(seed=0)
        assert [envs.step(envs.action_space.sample())[3].all() for _ in range(2)] == [False, True]
    with pytest.raises(ValueError, match=r"keywords: expected one of tracker, preset, .*; got 'weather'"):
        gym.make_vec(IDS[0], COUNT, weather="bad")
    with pytest.raises(ValueError, match="num_envs: expected a whole number >= 1, got 0"):
        gym.make_vec(IDS[0], 0)


@pytest.mark.heavy
@pytest.mark.parametrize("workers", [1, 2])
def test_processes_live_as_single_envs_do(workers):
    with contextlib.closing(side_by_side(workers)) as envs:
        assert len(envs.worker_ids) == workers
        assert_episodes_of_single_envs(envs, [FollowEnv(**keywords()) for _ in range(COUNT)])
    assert not any(is_alive(each) for each in envs.worker_ids)


def test_in_one_process_they_live_as_single_envs_do():
    with contextlib.closing(side_by_side(0, 3)) as envs:
        assert envs.worker_ids == []
        assert_episodes_of_single_envs(envs, [FollowEnv(**keywords()) for _ in range(3)])


def rollout(envs: gym.vector.VectorEnv, steps: int = 2 * LAST_FRAME + 5) -> list[Any]:
    rng = np.random.default_rng(1)
    results: list[Any] = [envs.reset(seed=[5, None, 2][: envs.num_envs])]
    for _ in range(steps):
        results.append(envs.step(rng.uniform(-1, 1, envs.action_space.shape).astype(np.float32)))
    return results


def assert_alike(ours: Any, theirs: Any) -> None:
    """Compare results as Gymnasium's own vector envs have them; order of keys and dtypes may differ."""
    if isinstance(theirs, dict):
        assert ours.keys() == theirs.keys()
        for key in theirs:
            assert_alike(ours[key], theirs[key])
    elif isinstance(theirs, tuple | list) or np.asarray(theirs).dtype.hasobject:
        for mine, other in zip(ours, theirs, strict=True):
            assert_alike(mine, other)
    else:
        np.testing.assert_array_equal(ours, theirs)


@pytest.mark.parametrize("observation", ["both", "pixels", ("depth", "track")])
@pytest.mark.parametrize("mode", [AutoresetMode.NEXT_STEP, AutoresetMode.SAME_STEP])
def test_results_are_those_of_gymnasium_s_own_vector_env(mode, observation):
    others: dict[str, Any] = {"observation": observation, "lost_after_s": 0.3}
    theirs = gym.vector.SyncVectorEnv([partial(FollowEnv, **keywords() | others)] * 2, autoreset_mode=mode)
    with contextlib.closing(side_by_side(0, autoreset_mode=mode, **others)) as envs:
        assert envs.single_observation_space == theirs.single_observation_space
        assert envs.observation_space == theirs.observation_space
        assert envs.action_space == theirs.action_space
        assert {**theirs.metadata} == envs.metadata
        for made in (envs, theirs):
            made.reset(seed=[1, 2])
        ours = rollout(envs)
        assert_alike(ours, rollout(theirs))
        assert all(observed in envs.observation_space for observed, *_ in ours)
    ends = [result[-1].get("final_info") for result in ours[1:]]
    assert any(ends) == (mode == AutoresetMode.SAME_STEP)


def test_without_autoreset_a_mask_chooses_who_begins_anew():
    with contextlib.closing(side_by_side(0, autoreset_mode="Disabled")) as envs:
        with pytest.raises(ValueError, match="reset_mask: expected every env in the first reset"):
            envs.reset(options={"reset_mask": np.array([True, False])})
        with pytest.raises(gym.error.ResetNeeded):
            envs.step(np.zeros((COUNT, 4)))
        envs.reset(options={"episode_seed": [7, 8]})
        for _ in range(LAST_FRAME):
            *_, truncated, infos = envs.step(np.zeros((COUNT, 4)))
        assert truncated.all()
        np.testing.assert_array_equal(infos["episode_seed"], [7, 8])
        mask = np.array([False, True])
        _, infos = envs.reset(options={"episode_seed": 9, "reset_mask": mask})
        np.testing.assert_array_equal(infos["_frame"], mask)
        assert infos["episode_seed"][1] == 9
        with pytest.raises(gym.error.ResetNeeded, match="step: expected an episode that runs"):
            envs.step(np.zeros((COUNT, 4)))


def test_attributes_and_methods_are_those_of_every_env():
    with contextlib.closing(side_by_side(0, 3, render_mode="rgb_array")) as envs:
        envs.reset(seed=1)
        assert [view.ndim for view in envs.render()] == [3, 3, 3]
        envs.set_attr("colour", [1, 2, 3])
        assert envs.get_attr("colour") == (1, 2, 3)
        envs.set_attr("colour", 4)
        assert envs.call("colour") == (4, 4, 4)
        with pytest.raises(ValueError, match="values: expected one value, or a list of 3, got 2"):
            envs.set_attr("colour", [1, 2])
    for refused in (envs.reset, lambda: envs.step(np.zeros((3, 4)))):
        with pytest.raises(gym.error.ClosedEnvironmentError, match="vector env: expected it to be open"):
            refused()


def test_all_envs_make_the_same_progress_in_a_curriculum():
    grows = {"randomise": {"frame_count": ((5, 5), (25, 25))}, "changes": {}}
    theirs = gym.vector.SyncVectorEnv([partial(FollowEnv, **keywords() | grows)] * 2)
    with contextlib.closing(side_by_side(0, **grows)) as envs:
        envs.progress = 0.5
        theirs.set_attr("progress", 0.5)
        for made in (envs, theirs):
            made.reset(seed=1)
            assert [loop.episode.frame_count for loop in made.get_attr("episode")] == [15, 15]
        assert envs.progress == 0.5


@pytest.mark.parametrize("wrapper", ["NormalizeObservation", "NormalizeReward", "RecordEpisodeStatistics"])
def test_gymnasium_s_wrappers_take_it(wrapper):
    with contextlib.closing(getattr(gym.wrappers.vector, wrapper)(side_by_side(0, observation="track"))) as envs:
        rollout(envs)


FAILS_AT = 4


class FailsSoon(Still):
    """Has a bug."""

    def misbehave(self, observation: Observation) -> Estimate:
        if self._frame == FAILS_AT:
            raise ZeroDivisionError("nothing")
        return super().misbehave(observation)


@pytest.mark.heavy
def test_an_error_of_one_env_is_told_and_a_reset_mends_it():
    failing = keywords() | {"tracker": FailsSoon(NoParameters(), np.random.default_rng(0))}
    with contextlib.closing(FollowVectorEnv(2, workers=2, **failing)) as envs:
        envs.reset(seed=1)
        for _ in range(FAILS_AT - 1):
            envs.step(np.zeros((2, 4)))
        with pytest.raises(RuntimeError, match=r"tracker: expected an estimate of FailsSoon .*nothing"):
            envs.step(np.zeros((2, 4)))
        with pytest.raises(ValueError, match="options: expected keys among"):
            envs.reset(options={"weather": 1})
        assert envs.reset(seed=1)[1]["frame"].tolist() == [0, 0]


def test_info_says_what_is_declared():
    env = FollowEnv(**keywords())
    _, info = env.reset(seed=0)
    keys = INFO | truth_keys(type(env.episode.frame.truth))
    declared = {key: (dtype, shape) for key, (dtype, shape, _) in keys.items()}
    assert {key: (str(np.asarray(value).dtype), np.shape(value)) for key, value in info.items()} == declared


@pytest.mark.heavy
def test_a_process_that_is_killed_is_told_in_one_line_and_the_others_are_ended(monkeypatch, capsys):
    with contextlib.closing(side_by_side()) as envs:
        ids = envs.worker_ids
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


@pytest.mark.heavy
def test_an_interrupted_call_leaves_no_answers_to_the_next(monkeypatch):
    with contextlib.closing(side_by_side()) as envs:
        envs.reset(seed=0)
        ids = envs.worker_ids

        def interrupted(self: Any) -> Any:
            raise KeyboardInterrupt

        monkeypatch.setattr("scenarios.envs.workers.Connection.recv", interrupted)
        with pytest.raises(KeyboardInterrupt):
            envs.step(np.zeros((COUNT, 4)))
        assert not any(is_alive(each) for each in ids)
        with pytest.raises(ChildProcessError, match="envs: expected processes that run, got none"):
            envs.step(np.zeros((COUNT, 4)))


OF_ITS_OWN = """
from tests.fakes_trackers import NoParameters, Still, register
import tests.fakes_scenario

@register("of_a_script", role="external", summary="of a script")
class OfAScript(Still):
    Parameters = NoParameters
"""
MAKES = """
import gymnasium as gym
import numpy as np

envs = gym.make_vec(
    "frameout/RoadTownFollow", 2, scenario="fake-town-v1", preset="tiny", tracker={tracker}, workers=2
)
observed, _ = envs.reset(seed=1)
print(observed.shape, *envs.worker_ids)
"""


def indented(text: str) -> str:
    return 'if __name__ == "__main__":\n' + "".join(f"    {line}\n" for line in text.splitlines())


@pytest.mark.heavy
@pytest.mark.parametrize(
    ("script", "tracker"),
    [
        (MAKES, '"fake_still"'),
        (OF_ITS_OWN + MAKES, "OfAScript(NoParameters(), np.random.default_rng(0))"),
        (OF_ITS_OWN + indented(MAKES), '"of_a_script"'),
    ],
)
def test_a_script_needs_a_guard_only_if_workers_must_run_it(script, tracker, tmp_path):
    file = tmp_path / "script.py"
    start = "import scenarios\nimport tests.fakes_scenario\n"
    file.write_text(start + script.replace("{tracker}", tracker).replace("RoadTownFollow", "RoadTownFollow-v3"))
    environment = os.environ | {"PYTHONPATH": str(ROOT)}
    pipes: dict[str, Any] = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, "text": True}
    with subprocess.Popen([sys.executable, file], cwd=tmp_path, env=environment, **pipes) as process:
        printed, complaints = output_of(process)
    assert complaints == ""
    *shape, first, second = printed.replace("(", "").replace(")", "").replace(",", "").split()
    assert shape[0] == "2"
    # It did not close them.
    wait_until_gone(int(first), int(second))


@pytest.mark.heavy
def test_a_script_that_workers_must_run_and_that_has_no_guard_is_told(tmp_path):
    file = tmp_path / "script.py"
    file.write_text(OF_ITS_OWN + MAKES.replace("{tracker}", '"of_a_script"').replace("Follow", "Follow-v3"))
    environment = os.environ | {"PYTHONPATH": str(ROOT)}
    pipes: dict[str, Any] = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, "text": True}
    with subprocess.Popen([sys.executable, file], cwd=tmp_path, env=environment, **pipes) as process:
        complaints = output_of(process)[1]
    assert complaints.count("Traceback") == 1
    wanted = 'ValueError: script: expected envs made below `if __name__ == "__main__":` only'
    assert complaints.splitlines()[-1].startswith(wanted)


def wait_until_gone(*ids: int) -> None:
    deadline = time.monotonic() + 20
    while any(is_alive(each) for each in ids):
        assert time.monotonic() < deadline, "a process is left behind"
        time.sleep(0.05)


SCRIPT = """
import contextlib, signal
import numpy as np
from tests.scenarios.envs.test_vector_env import COUNT, side_by_side

# A shell that started the tests in the background made all of them deaf to Ctrl-C.
signal.signal(signal.SIGINT, signal.default_int_handler)
with contextlib.closing(side_by_side()) as envs:
    envs.reset(seed=0)
    print(*envs.worker_ids, flush=True)
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
