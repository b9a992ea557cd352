"""Writes rollouts as a LeRobot data set, format v3.0, by the published layout.

Source: https://huggingface.co/docs/lerobot/lerobot-dataset-v3. Many episodes lie in one Parquet file, a row group each,
and in one film; ``meta/episodes`` says where. A frame is an observation with the action and what it brought
(``next.…``); the observation after the last step has no frame. What is ``privileged.…`` is no input of a policy, since
LeRobot takes those from ``observation`` and ``action`` alone; it has no statistics, as it need not be finite.
"""

from __future__ import annotations

import json
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path
from typing import Any, cast

import av
import numpy as np
import pandas as pd
import pyarrow as pa
import pyarrow.parquet as pq
from numpy.typing import NDArray

from benchmarks.data.codec import column_of
from benchmarks.learning.rollouts.recording import PRIVILEGED, EpisodeFile, huggingface
from benchmarks.learning.rollouts.request import Rollouts
from scenarios import catalog
from scenarios.envs.follow_env import FollowEnv
from trackers.belief.features import FEATURES

CAMERA = "observation.images.camera"
_FILES_A_CHUNK = 1000
_DATA_MB, _FILM_MB = 100, 200
"""Largest file, unless one episode alone is larger."""
_PATH = "chunk-{chunk_index:03d}/file-{file_index:03d}"
_DATA, _EPISODES = f"data/{_PATH}.parquet", f"meta/episodes/{_PATH}.parquet"
_FILM = f"videos/{{video_key}}/{_PATH}.mp4"
_QUANTILES = (0.01, 0.1, 0.5, 0.9, 0.99)
_SHADES = np.arange(256) / 255.0
Stats = dict[str, NDArray[Any]]


def write_lerobot(rollouts: Rollouts, episodes: Sequence[EpisodeFile], folder: Path) -> None:
    """Write recorded episodes into a folder."""
    writer = _Writer(rollouts, episodes, folder)
    writer.write_data()
    if rollouts.pictures != "none":
        writer.write_films()
    writer.write_meta()


class _Writer:
    """Writes one data set."""

    def __init__(self, rollouts: Rollouts, episodes: Sequence[EpisodeFile], folder: Path) -> None:
        made = rollouts.make()
        env: FollowEnv = made.unwrapped  # type: ignore[assignment]
        made.close()
        self._rollouts, self._episodes, self._folder = rollouts, episodes, folder
        self._axes, self._rate_hz = [axis.name for axis in env.carrier.axes], env.metadata["render_fps"]
        self._carrier, scenario = env.carrier.name, catalog.scenario(env.settings.scenario)
        self._task = f"Keep the {scenario.target} in the picture: {scenario.summary}"
        self._rows: list[dict[str, Any]] = [{} for _ in episodes]
        self._features: dict[str, Any] = {}
        self._stats: dict[str, list[NDArray[np.float64]]] = {}
        self._shades = np.zeros((3, 256), np.int64)

    def write_data(self) -> None:
        """Write the frames' numbers, and keep what is told about each episode."""
        files = _Files(self._folder, _DATA, _DATA_MB)
        writer, first = None, 0
        try:
            for number, episode in enumerate(self._episodes):
                columns = self._columns(episode, number, first)
                table = self._table(columns)
                place, is_new = files.place(table.nbytes)
                if writer is None or is_new:
                    if writer is not None:
                        writer.close()
                    writer = pq.ParquetWriter(place, table.schema, compression="snappy")
                writer.write_table(table)
                row = self._rows[number]
                row |= {"episode_index": number, "tasks": [self._task], "length": len(table)}
                row |= files.columns("data")
                row |= {"dataset_from_index": first, "dataset_to_index": first + len(table)}
                for name, values in columns.items():
                    if not name.startswith(PRIVILEGED):
                        flat = values.reshape(len(values), -1).astype(float)
                        row |= _flat(name, _stats(flat))
                        self._stats.setdefault(name, []).append(flat)
                first += len(table)
        finally:
            if writer is not None:
                writer.close()

    def _columns(self, episode: EpisodeFile, number: int, first: int) -> dict[str, NDArray[Any]]:
        """Return the columns of an episode's frames (T, …), whose first one is frame ``first`` of the set."""
        count = episode.step_count
        index = np.arange(count)
        ended = {name: episode.numbers(name) for name in ("terminated", "truncated")}
        names = [name for name in episode.names if name.startswith(PRIVILEGED)]
        return {
            "observation.state": episode.numbers("observation.track")[:-1],
            "action": episode.numbers("action"),
            "next.reward": episode.numbers("reward").astype(np.float32),
            "next.done": ended["terminated"] | ended["truncated"],
            **{f"next.{name}": values for name, values in ended.items()},
            **{name: episode.numbers(name)[:-1].reshape(count, -1) for name in names},
            "episode_seed": np.full(count, episode.seed),
            "timestamp": (index / self._rate_hz).astype(np.float32),
            "frame_index": index,
            "episode_index": np.full(count, number),
            "index": first + index,
            "task_index": np.zeros(count, np.int64),
        }

    def _table(self, columns: dict[str, NDArray[Any]]) -> pa.Table:
        named = {"observation.state": list(FEATURES), "action": self._axes}
        arrays, fields = [], []
        for name, values in columns.items():
            size = int(np.prod(values.shape[1:]))
            kind = pa.from_numpy_dtype(values.dtype)
            # A list of one number is a number there.
            is_list = size > 1 or name in named
            kind = pa.list_(kind, size) if is_list else kind
            arrays.append(column_of(values if is_list else values.reshape(-1), kind))
            fields.append(pa.field(name, kind))
            self._features[name] = {"dtype": values.dtype.name, "shape": [size], "names": named.get(name)}
        return pa.table(arrays, schema=huggingface(pa.schema(fields)))

    def write_films(self) -> None:
        """Join the episodes' films to a few."""
        files = _Files(self._folder, _FILM.replace("{video_key}", CAMERA), _FILM_MB)
        shares: list[list[EpisodeFile]] = []
        places: list[Path] = []
        for number, episode in enumerate(self._episodes):
            place, is_new = files.place(episode.film.stat().st_size)
            if is_new:
                shares.append([])
                places.append(place)
            begin = sum(each.step_count for each in shares[-1])
            shares[-1].append(episode)
            row, key = self._rows[number], f"videos/{CAMERA}"
            row |= files.columns(key)
            row |= {f"{key}/from_timestamp": begin / self._rate_hz}
            row |= {f"{key}/to_timestamp": (begin + episode.step_count) / self._rate_hz}
            shades = _shades(episode.film)
            self._shades += shades
            row |= _flat(CAMERA, _shade_stats(shades, episode.step_count))
        for place, share in zip(places, shares, strict=True):
            self._features[CAMERA] = _joined([each.film for each in share], place)

    def write_meta(self) -> None:
        """Write all that tells of the set."""
        frames = sum(row["length"] for row in self._rows)
        stats = {name: _stats(np.concatenate(values)) for name, values in self._stats.items()}
        if CAMERA in self._features:
            stats[CAMERA] = _shade_stats(self._shades, frames)
        info = {
            "codebase_version": "v3.0",
            "robot_type": self._carrier,
            "total_episodes": len(self._episodes),
            "total_frames": frames,
            "total_tasks": 1,
            "chunks_size": _FILES_A_CHUNK,
            "data_files_size_in_mb": _DATA_MB,
            "video_files_size_in_mb": _FILM_MB,
            "fps": int(self._rate_hz) if float(self._rate_hz).is_integer() else self._rate_hz,
            "splits": {self._rollouts.split: f"0:{len(self._episodes)}"},
            "data_path": _DATA,
            "video_path": _FILM if CAMERA in self._features else None,
            "features": self._features,
        }
        meta = self._folder / "meta"
        path = self._folder / _EPISODES.format(chunk_index=0, file_index=0)
        path.parent.mkdir(parents=True)
        (meta / "info.json").write_text(json.dumps(info, indent=4) + "\n")
        listed = {name: {part: numbers.tolist() for part, numbers in each.items()} for name, each in stats.items()}
        (meta / "stats.json").write_text(json.dumps(listed, indent=4) + "\n")
        tasks = pd.DataFrame({"task_index": [0]}, index=pd.Index([self._task], name="task"))
        pq.write_table(pa.Table.from_pandas(tasks), meta / "tasks.parquet")
        where = {"meta/episodes/chunk_index": 0, "meta/episodes/file_index": 0}
        pq.write_table(pa.Table.from_pylist([row | where for row in self._rows]), path)


class _Files:
    """The numbered files of a part of the set, each filled up to a size."""

    def __init__(self, folder: Path, pattern: str, most_mb: int) -> None:
        self._folder, self._pattern, self._most_bytes = folder, pattern, most_mb * 1_000_000
        self._number, self._bytes = -1, self._most_bytes

    def place(self, size: int) -> tuple[Path, bool]:
        """Return the file for the next ``size`` bytes, and whether it is a new one."""
        self._bytes += size
        is_new = self._bytes > self._most_bytes
        if is_new:
            self._number, self._bytes = self._number + 1, size
        chunk, file = divmod(self._number, _FILES_A_CHUNK)
        path = self._folder / self._pattern.format(chunk_index=chunk, file_index=file)
        path.parent.mkdir(parents=True, exist_ok=True)
        return path, is_new

    def columns(self, key: str) -> dict[str, int]:
        """Return where the latest bytes are."""
        chunk, file = divmod(self._number, _FILES_A_CHUNK)
        return {f"{key}/chunk_index": chunk, f"{key}/file_index": file}


def _stats(values: NDArray[np.float64]) -> Stats:
    """Return the statistics of numbers (T, N): each (N,), and their count (1,)."""
    quantiles = np.quantile(values, _QUANTILES, axis=0)
    return {
        "min": values.min(axis=0),
        "max": values.max(axis=0),
        "mean": values.mean(axis=0),
        "std": values.std(axis=0),
        "count": np.array([len(values)]),
        **{f"q{round(100 * q):02d}": each for q, each in zip(_QUANTILES, quantiles, strict=True)},
    }


def _shade_stats(shades: NDArray[np.int64], frames: int) -> Stats:
    """Return the statistics of pictures by channel, (3, 1, 1) in [0, 1], from the counts (3, 256) of each value."""
    share = np.cumsum(shades, axis=1) / shades.sum(axis=1, keepdims=True)
    seen = [np.flatnonzero(row) for row in shades]
    mean = (shades * _SHADES).sum(axis=1) / shades.sum(axis=1)
    variance = (shades * (_SHADES - mean[:, None]) ** 2).sum(axis=1) / shades.sum(axis=1)
    found = {
        "min": _SHADES[[row[0] for row in seen]],
        "max": _SHADES[[row[-1] for row in seen]],
        "mean": mean,
        "std": np.sqrt(variance),
        **{f"q{round(100 * q):02d}": _SHADES[(share < q).sum(axis=1)] for q in _QUANTILES},
    }
    return {name: each.reshape(3, 1, 1) for name, each in found.items()} | {"count": np.array([frames])}


def _flat(name: str, stats: Stats) -> dict[str, Any]:
    return {f"stats/{name}/{part}": numbers.tolist() for part, numbers in stats.items()}


def _shades(film: Path) -> NDArray[np.int64]:
    """Return how often each value (3, 256) is in a film's pictures."""
    counts = np.zeros((3, 256), np.int64)
    for picture in _pictures(film):
        counts += [np.bincount(channel.ravel(), minlength=256) for channel in np.moveaxis(picture, 2, 0)]
    return counts


def _pictures(film: Path) -> Iterator[NDArray[np.uint8]]:
    with av.open(str(film)) as file:
        for frame in file.decode(video=0):
            yield np.asarray(frame.to_ndarray(format="rgb24"), np.uint8)


def _joined(films: Iterable[Path], place: Path) -> dict[str, Any]:
    """Write films one after the other, without coding anything anew; return what the set tells of them."""
    told: dict[str, Any] = {}
    with av.open(str(place), "w", format="mp4", options={"movflags": "+faststart"}) as out:
        out.flags |= cast(int, av.container.Flags.bitexact.value)
        stream, frames = None, 0
        for film in films:
            with av.open(str(film)) as part:
                source: Any = part.streams.video[0]
                if stream is None:
                    stream = out.add_stream_from_template(source)
                    told = _told(source)
                ticks = 1 / (source.average_rate * source.time_base)
                for packet in part.demux(source):
                    if packet.dts is None:
                        continue
                    packet.pts, packet.dts = (round(at + frames * ticks) for at in (packet.pts, packet.dts))
                    packet.stream = stream
                    out.mux(packet)
                frames += source.frames
    return told


def _told(source: Any) -> dict[str, Any]:
    height, width, rate_hz = source.codec_context.height, source.codec_context.width, float(source.average_rate)
    about = {
        "video.height": height,
        "video.width": width,
        "video.codec": source.codec_context.name,
        "video.pix_fmt": source.codec_context.pix_fmt,
        "video.is_depth_map": False,
        "video.fps": int(rate_hz) if rate_hz.is_integer() else rate_hz,
        "video.channels": 3,
        "has_audio": False,
    }
    return {"dtype": "video", "shape": [height, width, 3], "names": ["height", "width", "channels"], "info": about}
