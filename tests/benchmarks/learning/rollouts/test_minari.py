"""A Minari set is read by Minari, which brings its env back, and its episodes replay there."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from benchmarks.learning.rollouts.card import dataset_id
from tests.benchmarks.learning.rollouts.painted_town import ENV, FRAMES, made, painted, rollouts

minari = pytest.importorskip("minari", reason="minari is not installed")


@pytest.mark.parametrize("pictures", ["none", "raw"])
def test_minari_loads_it_and_its_env_replays_it(pictures: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    out = made(tmp_path / "set", format="minari", pictures=pictures)
    monkeypatch.setenv("MINARI_DATASETS_PATH", str(out))
    name = f"{ENV}/wild-v0"
    assert list(minari.list_local_datasets()) == [name]
    data = minari.load_dataset(name)
    assert (data.total_episodes, data.total_steps) == (2, 2 * (FRAMES - 1))
    env = data.recover_environment()
    assert data.spec.observation_space == env.observation_space
    assert data.spec.action_space == env.action_space
    for episode, told in zip(data, data.storage.get_episode_metadata([0, 1]), strict=True):
        seed, options = int(told["options"]["episode_seed"]), {k: int(v) for k, v in told["options"].items()}
        assert seed == 3 + episode.id
        observed, info = env.reset(options=options)
        for step in range(FRAMES):
            stored = episode.observations
            if pictures == "raw":
                np.testing.assert_array_equal(stored["pixels"][step], painted(step, seed))
                np.testing.assert_array_equal(observed["pixels"], stored["pixels"][step])
                observed, stored = observed["track"], stored["track"]
            np.testing.assert_array_equal(observed, stored[step])
            np.testing.assert_array_equal(info["T_world_camera"], episode.infos["T_world_camera"][step])
            assert info["in_view"] == episode.infos["in_view"][step]
            if step < FRAMES - 1:
                observed, reward, terminated, truncated, info = env.step(episode.actions[step])
                ends = (episode.terminations[step], episode.truncations[step])
                assert (reward, terminated, truncated) == (episode.rewards[step], *ends)


@pytest.mark.parametrize(
    ("controller", "name"),
    [("wild", "wild"), ("policy:a/b/best one.json", "best_one"), ("policy:.json", "json"), ("x-y.z", "x_y")],
)
def test_the_id_has_letters_that_minari_takes(controller: str, name: str) -> None:
    order = rollouts()
    object.__setattr__(order, "controller", controller)
    assert dataset_id(order) == f"{ENV}/{name}-v0"
    assert minari.dataset.minari_dataset.parse_dataset_id(dataset_id(order)) == (ENV, name, 0)
