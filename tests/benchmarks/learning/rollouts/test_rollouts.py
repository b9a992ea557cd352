"""Rollouts replay, do not depend on who made them or how often that was stopped, and say what is wrong."""

from __future__ import annotations

import hashlib
import json
import os
import re
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import cv2
import gymnasium as gym
import numpy as np
import pandas as pd
import pytest

from benchmarks.cli.main import main
from benchmarks.learning.rollouts import making
from benchmarks.learning.rollouts.recording import EpisodeFile, options_of
from benchmarks.learning.rollouts.request import Rollouts
from benchmarks.run.result_folder import alone_in
from scenarios import catalog
from scenarios.road_town.flight import HELICOPTER
from tests.benchmarks.learning.rollouts.painted_town import ENV, FRAMES, MODULES, made, painted, rollouts
from tests.benchmarks.no_room import no_room
from tests.fakes_policy import random_policy
from trackers.controllers.policy import save_policy

OURS = [each.env_id for each in catalog.entries() if each.env_id and each.place.startswith("scenarios.")]
FORMATS = ("lerobot", "minari", "parquet")
COMMAND = ["rollout", ENV, "--seeds", "3:5", "--controller", "wild", "--modules", *MODULES, "--workers", "0"]
COMMAND += ["--env-kwargs", json.dumps({"changes": {"frame_count": FRAMES}})]


def digests(folder: Path) -> dict[str, str]:
    """Return the checksum of every file in a folder."""
    files = sorted(path for path in folder.rglob("*") if path.is_file())
    return {str(path.relative_to(folder)): hashlib.sha256(path.read_bytes()).hexdigest() for path in files}


def check_replay(env: gym.Env[Any, Any], episode: EpisodeFile) -> None:
    """Step through a recorded episode, and compare all that it holds."""
    observed, info = env.reset(options=options_of(episode.seed))
    actions = episode.numbers("action")
    assert actions.dtype == np.float32
    assert (np.abs(actions) <= 1).all()
    for step in range(episode.step_count + 1):
        track = observed["track"] if isinstance(observed, dict) else observed
        np.testing.assert_array_equal(track, episode.numbers("observation.track")[step])
        for name in ("place_m", "T_world_camera", "in_view", "command", "reward_effort"):
            np.testing.assert_array_equal(info[name], episode.numbers(f"privileged.{name}")[step], name)
        if step < episode.step_count:
            observed, reward, terminated, truncated, info = env.step(actions[step])
            told = [episode.numbers(name)[step] for name in ("reward", "terminated", "truncated")]
            assert [reward, terminated, truncated] == told
    assert terminated or truncated


def test_what_is_stored_replays_although_the_controller_wants_more_than_it_may(tmp_path: Path) -> None:
    made(tmp_path / "set", pictures="png")
    env = gym.make(ENV, changes={"frame_count": FRAMES})
    episodes = [EpisodeFile(tmp_path / "set" / "data", seed) for seed in (3, 4)]
    for episode in episodes:
        check_replay(env, episode)
        assert episode.step_count == FRAMES - 1
        assert (episode.numbers("action")[:4, :2] == [1, -1]).all(), "clipped, as the carrier does it"
        assert 0 < episode.numbers("action")[5, 0] < 1
        pictures = np.array([painted(frame, episode.seed) for frame in range(FRAMES)])
        np.testing.assert_array_equal(episode.pictures(), pictures)


def test_a_policy_of_a_file_steers(tmp_path: Path) -> None:
    path = save_policy(random_policy(HELICOPTER, history=2, action_repeat=3), tmp_path / "policy.json")
    out = made(tmp_path / "set", controller=f"policy:{path}", pictures="none")
    episode = EpisodeFile(out / "data", 3)
    check_replay(gym.make(ENV, changes={"frame_count": FRAMES}), episode)
    actions = episode.numbers("action")
    np.testing.assert_array_equal(actions[:9], np.repeat(actions[:9:3], 3, axis=0))
    assert len(np.unique(actions, axis=0)) == 4
    assert f"{ENV}, steered by policy:{path}" in (out / "README.md").read_text()


def test_an_episode_that_terminates_ends_there(tmp_path: Path) -> None:
    keywords = {"changes": {"frame_count": 200}, "lost_after_s": 0.5}
    made(tmp_path / "set", env_kwargs=keywords, seeds=(3, 4), pictures="none")
    episode = EpisodeFile(tmp_path / "set" / "data", 3)
    check_replay(gym.make(ENV, **keywords), episode)
    assert episode.step_count < 199
    assert episode.numbers("terminated").tolist() == [False] * (episode.step_count - 1) + [True]
    assert not episode.numbers("truncated").any()


@pytest.mark.heavy
@pytest.mark.parametrize(
    ("env_id", "controller", "keywords"),
    [
        ("frameout/RoadTownFollow-v3", "omniscient", {"link": "delayed"}),
        ("frameout/RoadTownFollow-v3", "", {"randomise": {"rate_hz": (10.0, 20.0)}}),
        ("frameout/StereoFollow-v3", "omniscient", {}),
        *((env_id, "", {}) for env_id in OURS),
    ],
)
def test_real_envs_replay(env_id: str, controller: str, keywords: dict[str, Any], tmp_path: Path) -> None:
    order = Rollouts(env_id, (3, 4), "parquet", controller, "none", preset="quick", env_kwargs=keywords)
    making.make(order, tmp_path / "set", 0, lambda done, of: None)
    check_replay(gym.make(env_id, preset="quick", **keywords), EpisodeFile(tmp_path / "set" / "data", 3))


@pytest.mark.parametrize("form", FORMATS)
def test_made_twice_it_has_the_same_bytes(form: str, tmp_path: Path) -> None:
    one = made(tmp_path / "one", format=form)
    # Times in files have a resolution of a second.
    time.sleep(1.1)
    assert digests(made(tmp_path / "two", format=form)) == digests(one)


@pytest.mark.heavy
@pytest.mark.parametrize("form", FORMATS)
def test_any_number_of_workers_makes_the_same_bytes(form: str, tmp_path: Path) -> None:
    one = digests(made(tmp_path / "one", format=form))
    for workers in (1, 2):
        assert digests(made(tmp_path / str(workers), workers, format=form)) == one


@pytest.mark.parametrize("stops", ["record", "write_set"])
def test_a_stopped_run_continues_with_the_same_command_and_makes_the_same_bytes(
    stops: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """After the first episode, and after the last one."""
    out, recorded, record = tmp_path / "set", list[int](), making.record

    def records(order: Rollouts, seed: int, folder: Path) -> EpisodeFile:
        recorded.append(seed)
        return interrupted() if stops == "record" and seed == 4 else record(order, seed, folder)

    def interrupted(*_: object) -> Any:
        raise KeyboardInterrupt

    with monkeypatch.context() as patch:
        patch.setattr(making, "record", records)
        if stops == "write_set":
            patch.setattr(making, "write_set", interrupted)
        with pytest.raises(KeyboardInterrupt):
            made(out, format="lerobot")
    assert sorted(path.name for path in tmp_path.iterdir()) == ["set.unfinished"]
    assert recorded == [3, 4]
    recorded.clear()
    monkeypatch.setattr(making, "record", lambda *given: recorded.append(given[1]) or record(*given))
    made(out, format="lerobot")
    assert recorded == ([4] if stops == "record" else []), "a whole episode is not made again"
    assert sorted(path.name for path in tmp_path.iterdir()) == ["set"]
    assert digests(out) == digests(made(tmp_path / "whole", format="lerobot"))


@pytest.mark.heavy
def test_a_killed_run_continues_with_the_same_command_and_makes_the_same_bytes(tmp_path: Path) -> None:
    out, seeds = tmp_path / "set", (3, 33)
    script = "from pathlib import Path\nfrom tests.benchmarks.learning.rollouts.painted_town import made\n"
    script += f"made(Path({str(out)!r}), workers=2, format='lerobot', seeds={seeds})\n"
    kills, rng = 0, np.random.default_rng(0)
    while kills < 5:
        run = subprocess.Popen([sys.executable, "-c", script], env=os.environ, cwd=Path(__file__).parents[4])
        limit = time.monotonic() + 120
        while not Path(f"{out}.unfinished").exists() and run.poll() is None and time.monotonic() < limit:
            time.sleep(0.01)
        time.sleep(float(rng.uniform(0.0, 6.0)))
        if run.poll() is None:
            os.kill(run.pid, signal.SIGKILL)
            kills += 1
        run.wait()
        if out.exists():
            shutil.rmtree(out)
    made(out, format="lerobot", seeds=seeds)
    assert digests(out) == digests(made(tmp_path / "whole", format="lerobot", seeds=seeds))


def test_a_set_that_is_whole_is_not_made_again(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    out = made(tmp_path / "set")
    monkeypatch.setattr(making, "record", None)
    told = making.make(rollouts(), out, 0, lambda done, of: None)
    assert (told.episodes, told.steps) == (2, 2 * (FRAMES - 1))


def test_a_folder_with_something_else_is_refused(tmp_path: Path) -> None:
    out = made(tmp_path / "set")
    before = digests(out)
    with pytest.raises(ValueError, match=r"out: expected rollouts with controller 'hold', got .* with 'wild'"):
        made(out, controller="hold")
    with pytest.raises(ValueError, match=r"out: expected rollouts with seeds \[3, 6\], got .* with \[3, 5\]"):
        made(out, seeds=(3, 6))
    assert digests(out) == before
    (tmp_path / "mine").mkdir()
    (tmp_path / "mine" / "thesis.txt").touch()
    with pytest.raises(ValueError, match="out: expected a new or empty folder, or the same rollouts"):
        made(tmp_path / "mine")
    with pytest.raises(ValueError, match="out: expected a folder that can be written, got '/proc/set"):
        made(Path("/proc/set"))


def test_a_second_writer_is_refused(tmp_path: Path) -> None:
    (tmp_path / "set.unfinished").mkdir()
    with alone_in(tmp_path / "set.unfinished"), pytest.raises(ValueError, match="out: expected a folder that no"):
        made(tmp_path / "set")


@pytest.mark.parametrize("form", FORMATS)
def test_a_full_disk_is_one_line_and_what_was_made_is_kept(
    form: str, tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """The episodes, and in the second run the files of the set."""
    monkeypatch.chdir(tmp_path)
    words = [*COMMAND, "--format", form, "--out", "set"]
    with no_room(2_000):
        assert main(words) == 1
    assert "File too large; what was written before is kept" in capsys.readouterr().err.splitlines()[-1]
    with monkeypatch.context() as patch:
        patch.setattr(making, "write_set", lambda *_: (_ for _ in ()).throw(KeyboardInterrupt))
        assert main(words) == 130
    assert capsys.readouterr().err.endswith("stopped; the same command continues\n")
    largest = max(path.stat().st_size for path in Path("set.unfinished/episodes").iterdir())
    kept = digests(tmp_path / "set.unfinished/episodes")
    assert len(kept) == (4 if form == "lerobot" else 2)
    with no_room(min(largest, 2_000)):
        assert main(words) == 1
    assert "File too large; what was written before is kept" in capsys.readouterr().err.splitlines()[-1]
    assert sorted(path.name for path in tmp_path.iterdir()) == ["set.unfinished"]
    assert digests(tmp_path / "set.unfinished/episodes") == kept
    assert main(words) == 0
    assert digests(tmp_path / "set") == digests(made(tmp_path / "other", format=form))


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"controller": "nix"}, "controller: expected one of hold, .*; got 'nix'"),
        ({"controller": "policy:nix.json"}, "policy: expected a file that can be read, got 'nix.json'"),
        ({"tracker": "nix"}, "tracker: expected one of .*; got 'nix'"),
        ({"preset": "nix"}, "preset: expected one of standard; got 'nix'"),
        ({"format": "rlds"}, "format: expected one of lerobot, minari, parquet; got 'rlds'"),
        ({"format": "minari", "pictures": "h264"}, "pictures: expected one of none, raw; got 'h264'"),
        ({"seeds": (3, 3)}, "seeds: expected A:B with 0 <= A < B, got 3:3"),
        ({"seeds": (9_999, 10_001)}, "seeds: expected all of the test split, which is 10000:20000, or none"),
        ({"env_kwargs": {"action": "correction"}}, "env_kwargs: expected none of action, .*, got action"),
        (
            {"format": "lerobot", "env_kwargs": {"randomise": {"rate_hz": (9, 12)}}},
            "env_kwargs: expected a fixed rate_hz for lerobot, got randomise of it",
        ),
        ({"env_kwargs": {"wheels": 4}}, "keywords: expected one of .*; got 'wheels'"),
    ],
)
def test_wrong_orders_are_named(changes: dict[str, Any], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        rollouts(**changes)


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["--controller", "fails"], "seed 3: controller: expected a command of fails after frame 3, got ZeroDiv"),
        (
            ["--controller", "infinite"],
            "seed 3: controller: expected a command of infinite after frame 0, got .*fin",
        ),
        (["--tracker", "fake_raises"], "seed 3: tracker: expected an estimate of fake_raises after frame 20"),
        (["--tracker", "fake_exits"], r"seed 3: tracker: expected an estimate of fake_exits, got sys.exit\("),
        (["--env-kwargs", "[]"], "env_kwargs: expected an object of JSON, got '\\[\\]'"),
        (["--episodes", "2"], "episodes: expected none beside --seeds, got 2"),
    ],
)
def test_what_fails_is_one_line(
    words: list[str], message: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    command = [*COMMAND[:-2], "--env-kwargs", '{"changes": {"frame_count": 30}}', "--out", str(tmp_path / "set")]
    assert main([*command, *words]) == 2
    (line,) = [line for line in capsys.readouterr().err.splitlines() if line.startswith("error")]
    assert line.startswith("error: ")
    assert re.match(message, line.removeprefix("error: ")), line
    assert not (tmp_path / "set").exists()


@pytest.mark.parametrize("form", FORMATS)
def test_missing_packages_are_named_with_the_command_that_installs_them(
    form: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr("benchmarks.run.packages.find_spec", lambda name: None)
    # Its import would fail without them.
    monkeypatch.setitem(sys.modules, making.__name__, None)
    assert main([*COMMAND, "--format", form, "--out", str(tmp_path / "set")]) == 2
    said = capsys.readouterr().err
    assert "error: packages: expected fsspec, pyarrow" in said
    assert "(pip install 'frameout[data]')" in said
    assert not list(tmp_path.iterdir())


def test_a_forecast_makes_nothing_and_is_near(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    words = [*COMMAND, "--out", str(tmp_path / "set")]
    assert main([*words, "--dry-run"]) == 0
    told = capsys.readouterr().out
    assert told.startswith("2 episodes, ")
    assert not list(tmp_path.iterdir())
    size, seconds = making.forecast(rollouts())
    assert main(words) == 0
    assert size == pytest.approx(making.bytes_of(tmp_path / "set"), rel=0.6)
    assert seconds > 0
    assert capsys.readouterr().out.splitlines()[1].startswith("mean return ")


def test_pandas_reads_parquet_with_its_pictures(tmp_path: Path) -> None:
    out = made(tmp_path / "set")
    table = pd.read_parquet(out / "data")
    assert table.groupby("episode_seed").size().to_dict() == {3: FRAMES, 4: FRAMES}
    last = table.groupby("episode_seed").tail(1)
    assert last[["action", "reward", "terminated", "truncated"]].isna().all().all()
    steps = table.dropna(subset="action")
    assert len(steps) == 2 * (FRAMES - 1)
    assert steps["truncated"].sum() == 2
    coded = np.frombuffer(table["observation.pixels"][5]["bytes"], np.uint8)
    seen = cv2.cvtColor(cv2.imdecode(coded, cv2.IMREAD_COLOR), cv2.COLOR_BGR2RGB)
    assert np.abs(seen.astype(int) - painted(5, 3)).mean() < 2


def test_the_card_names_every_column(tmp_path: Path) -> None:
    for form in FORMATS:
        out = made(tmp_path / form, format=form)
        card = (out / "README.md").read_text()
        assert f"--format {form} " in card
        assert "| `place_m` | target's true place in the world, in metres |" in card
        assert "| 0 | `known` |" in card
        assert "| 0 | `forward_mps` | 25 |" in card
        assert "{{" not in card
        assert str(tmp_path) not in card
    names = pd.read_parquet(tmp_path / "parquet" / "data").columns
    for name in names:
        assert f"`{name.removeprefix('privileged.')}`" in card
