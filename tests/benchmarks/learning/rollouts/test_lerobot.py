"""A LeRobot set has the published layout, its frames are those of the episodes, and LeRobot's own reader reads it."""

from __future__ import annotations

import json
import os
import subprocess
from fractions import Fraction
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import av
import numpy as np
import pandas as pd
import pyarrow.parquet as pq
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from benchmarks.learning.rollouts import lerobot
from benchmarks.learning.rollouts.recording import EpisodeFile
from tests.benchmarks.learning.rollouts.painted_town import FRAMES, made, painted

STEPS = FRAMES - 1
SEEDS = range(3, 8)
READER = "LEROBOT_PYTHON"
"""Names a Python that has LeRobot, which needs other versions of torch and Hugging Face's packages."""


@pytest.fixture(scope="module")
def sets(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Path]:
    """Return the same episodes as a LeRobot set of small files, and as tables."""
    root = tmp_path_factory.mktemp("sets")
    with pytest.MonkeyPatch.context() as patch:
        # Two episodes a file, three files a chunk: megabytes, as numbers of a set in ``info``.
        patch.setattr(lerobot, "_DATA_MB", 0.025)
        patch.setattr(lerobot, "_FILM_MB", 0.005)
        patch.setattr(lerobot, "_FILES_A_CHUNK", 2)
        made(root / "lerobot", format="lerobot", seeds=(SEEDS.start, SEEDS.stop))
    made(root / "tables", seeds=(SEEDS.start, SEEDS.stop), pictures="png")
    return root / "lerobot", root / "tables" / "data"


def table_of(root: Path, part: str) -> pd.DataFrame:
    """Return all rows of a part of a set, in the order of its files."""
    files = sorted((root / part).rglob("*.parquet"))
    return pd.concat([pd.read_parquet(file) for file in files], ignore_index=True)


def film_of(root: Path, info: dict[str, Any], episode: pd.Series) -> list[tuple[float, NDArray[np.uint8]]]:
    """Return the times and pictures of an episode, by what ``meta/episodes`` says."""
    key = f"videos/{lerobot.CAMERA}"
    at = {name: int(episode[f"{key}/{name}"]) for name in ("chunk_index", "file_index")}
    with av.open(str(root / info["video_path"].format(video_key=lerobot.CAMERA, **at))) as file:
        frames = file.decode(video=0)
        found = [(float(each.time or 0), np.asarray(each.to_ndarray(format="rgb24"), np.uint8)) for each in frames]
    begin, end = episode[f"{key}/from_timestamp"], episode[f"{key}/to_timestamp"]
    return [
        (time - begin, np.asarray(picture, np.uint8)) for time, picture in found if begin - 1e-6 <= time < end - 1e-6
    ]


def test_frames_are_those_of_the_episodes(sets: tuple[Path, Path]) -> None:
    root, tables = sets
    info, frames = json.loads((root / "meta/info.json").read_text()), table_of(root, "data")
    assert info["codebase_version"] == "v3.0"
    assert (info["total_episodes"], info["total_frames"], info["fps"]) == (len(SEEDS), len(SEEDS) * STEPS, 15)
    assert info["splits"] == {"train": f"0:{len(SEEDS)}"}
    assert frames["index"].tolist() == list(range(len(frames)))
    for number, seed in enumerate(SEEDS):
        own, episode = frames[frames["episode_index"] == number], EpisodeFile(tables, seed)
        assert (own["episode_seed"] == seed).all()
        assert own["frame_index"].tolist() == list(range(STEPS))
        np.testing.assert_allclose(own["timestamp"], np.arange(STEPS) / 15, rtol=1e-6)
        np.testing.assert_array_equal(np.stack(own["observation.state"]), episode.numbers("observation.track")[:-1])
        np.testing.assert_array_equal(np.stack(own["action"]), episode.numbers("action"))
        np.testing.assert_array_equal(own["next.reward"], episode.numbers("reward").astype(np.float32))
        assert own["next.done"].tolist() == [False] * (STEPS - 1) + [True]
        np.testing.assert_array_equal(own["privileged.in_view"], episode.numbers("privileged.in_view")[:-1])
        places = np.stack(own["privileged.T_world_camera"]).reshape(-1, 4, 4)
        np.testing.assert_array_equal(places, episode.numbers("privileged.T_world_camera")[:-1])


def test_features_say_what_columns_and_films_are(sets: tuple[Path, Path]) -> None:
    root, _ = sets
    info, frames = json.loads((root / "meta/info.json").read_text()), table_of(root, "data")
    features = info["features"]
    assert set(features) == {*frames.columns, lerobot.CAMERA}
    for name in frames.columns:
        first = np.asarray(frames[name][0])
        assert (features[name]["dtype"], features[name]["shape"]) == (first.dtype.name, [first.size]), name
    assert len(features["observation.state"]["names"]) == features["observation.state"]["shape"][0]
    assert features["action"]["names"] == ["forward_mps", "right_mps", "climb_mps", "yaw_rate_rad_s"]
    assert features[lerobot.CAMERA]["shape"] == [120, 160, 3]
    assert features[lerobot.CAMERA]["info"]["video.codec"] == "h264"
    for file in (root / "videos").rglob("*.mp4"):
        with av.open(str(file)) as film:
            assert film.streams.video[0].average_rate == Fraction(info["fps"])


def test_episodes_say_where_their_frames_and_pictures_are(sets: tuple[Path, Path]) -> None:
    root, _ = sets
    info, episodes = json.loads((root / "meta/info.json").read_text()), table_of(root, "meta/episodes")
    assert len(list((root / "data").rglob("*.parquet"))) > 2
    assert len(list((root / "videos").rglob("*.mp4"))) > 2
    assert episodes["data/chunk_index"].nunique() > 1
    tasks = pd.read_parquet(root / "meta/tasks.parquet")
    for number, episode in episodes.iterrows():
        at = {name: int(episode[f"data/{name}"]) for name in ("chunk_index", "file_index")}
        rows = pd.read_parquet(root / info["data_path"].format(**at))
        begin, end = episode["dataset_from_index"], episode["dataset_to_index"]
        assert (rows["index"].between(begin, end - 1) == (rows["episode_index"] == number)).all()
        assert end - begin == episode["length"] == STEPS
        assert list(episode["tasks"]) == list(tasks.index)
        film = film_of(root, info, episode)
        np.testing.assert_allclose([time for time, _ in film], np.arange(STEPS) / 15, atol=1e-6)
        for frame, (_, picture) in enumerate(film):
            wrong = np.abs(picture.astype(int) - painted(frame, SEEDS[number]).astype(int))
            assert wrong.mean() < 3, "another frame's red differs by 8, another seed's blue by 20"
    for file in (root / "data").rglob("*.parquet"):
        groups = pq.ParquetFile(file)
        assert groups.num_row_groups == pd.read_parquet(file)["episode_index"].nunique()


def test_statistics_are_numpy_s(sets: tuple[Path, Path]) -> None:
    root, _ = sets
    told, frames = json.loads((root / "meta/stats.json").read_text()), table_of(root, "data")
    info, episodes = json.loads((root / "meta/info.json").read_text()), table_of(root, "meta/episodes")
    columns = {name: np.stack(frames[name]).reshape(len(frames), -1) for name in frames if name in told}
    films = [np.array([picture for _, picture in film_of(root, info, each)]) for _, each in episodes.iterrows()]
    columns[lerobot.CAMERA] = np.concatenate(films).reshape(-1, 3) / 255
    assert set(told) == set(columns) >= {"action", "observation.state", "next.reward", lerobot.CAMERA, "timestamp"}
    for name, values in columns.items():
        own, numbers = {part: np.array(each).reshape(-1) for part, each in told[name].items()}, values.astype(float)
        assert own["count"] == len(frames)
        for part in ("min", "max", "mean", "std"):
            wanted = getattr(numbers, part)(axis=0)
            np.testing.assert_allclose(own[part], wanted, rtol=1e-6, atol=1e-9, err_msg=f"{name} {part}")
        for share in (0.01, 0.1, 0.5, 0.9, 0.99):
            method: Any = "inverted_cdf" if name == lerobot.CAMERA else "linear"
            wanted = np.quantile(numbers, share, axis=0, method=method)
            np.testing.assert_allclose(own[f"q{round(100 * share):02d}"], wanted, rtol=1e-6, atol=1e-9)
    assert np.shape(told[lerobot.CAMERA]["mean"]) == (3, 1, 1)
    first, state = episodes.iloc[0], columns["observation.state"][:STEPS]
    np.testing.assert_allclose(first["stats/observation.state/max"], state.max(axis=0))
    np.testing.assert_allclose(first["stats/action/mean"], columns["action"][:STEPS].astype(float).mean(axis=0))


@settings(max_examples=40)
@given(sizes=st.lists(st.integers(1, 2_500_000), min_size=1, max_size=40))
def test_files_are_filled_in_order_up_to_their_size(sizes: list[int]) -> None:
    with TemporaryDirectory() as folder:
        files = lerobot._Files(Path(folder), "{chunk_index}-{file_index}", 2)
        found = [(*files.place(size), *files.columns("data").values()) for size in sizes]
    number, held = -1, np.inf
    for size, (path, is_new, chunk, file) in zip(sizes, found, strict=True):
        fits = held + size <= 2_000_000
        number, held = (number, held + size) if fits else (number + 1, size)
        assert is_new != fits
        assert (chunk, file) == divmod(number, 1000)
        assert path.name == f"{chunk}-{file}"


def test_without_pictures_there_is_no_film(tmp_path: Path) -> None:
    out = made(tmp_path / "set", format="lerobot", pictures="none")
    info = json.loads((out / "meta/info.json").read_text())
    assert info["video_path"] is None
    assert lerobot.CAMERA not in info["features"]
    assert not (out / "videos").exists()


@pytest.mark.heavy
@pytest.mark.skipif(READER not in os.environ, reason=f"{READER} names no Python that has LeRobot")
def test_lerobot_reads_it(sets: tuple[Path, Path]) -> None:
    script = """
import json, sys
from lerobot.datasets.lerobot_dataset import LeRobotDataset
data = LeRobotDataset("frameout/rollouts", root=sys.argv[1])
keys = ("action", "observation.state", "next.reward", "episode_seed", "timestamp")
items = [data[index] for index in range(len(data))]
told = [{key: item[key].tolist() for key in keys} for item in items]
camera = [(item["observation.images.camera"] * 255).mean((1, 2)).tolist() for item in items]
print(json.dumps({"episodes": data.num_episodes, "items": told, "camera": camera, "task": items[0]["task"]}))
"""
    root, tables = sets
    run = subprocess.run(
        [os.environ[READER], "-W", "ignore", "-c", script, str(root)],
        env={**os.environ, "HF_HUB_OFFLINE": "1", "PYTHONPATH": os.environ.get("LEROBOT_PYTHONPATH", "")},
        capture_output=True,
        text=True,
        check=False,
    )
    assert run.returncode == 0, run.stderr
    read = json.loads(run.stdout.splitlines()[-1])
    assert read["episodes"] == len(SEEDS)
    assert "car" in read["task"]
    for number, item in enumerate(read["items"]):
        seed, frame = SEEDS[number // STEPS], number % STEPS
        episode = EpisodeFile(tables, seed)
        assert item["episode_seed"] == seed
        np.testing.assert_array_equal(np.float32(item["action"]), episode.numbers("action")[frame])
        np.testing.assert_array_equal(
            np.float32(item["observation.state"]), episode.numbers("observation.track")[frame]
        )
        assert item["next.reward"] == np.float32(episode.numbers("reward")[frame])
        np.testing.assert_allclose(read["camera"][number], painted(frame, seed).mean(axis=(0, 1)), atol=3)
