"""Plays an episode with a controller and keeps it: a table, and a film of its pictures if they are not in the table.

The table is ``SEED.parquet``, with a row for each observation and the step that followed it; that of the last
observation has none, and null in its place. Columns:

- ``episode_seed``, ``step``, ``time_s``;
- ``observation.track``, ``observation.pixels``: of the env, see ``FollowEnv``; a picture is the content of its file;
- ``action``: shares of the carrier's limits in the order of its axes, as ``env.step`` takes them;
- ``reward``, ``terminated``, ``truncated``: what the step returned;
- ``privileged.NAME``: the env's ``info`` beside the observation, truth that no policy may see.
"""

from __future__ import annotations

import json
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
from numpy.typing import NDArray

from benchmarks.data.codec import array_of, column_of
from benchmarks.data.sets.channels import CODINGS
from benchmarks.learning.rollouts.request import Rollouts
from benchmarks.run.episodes import ForeseeingController
from benchmarks.run.failures import reason_of
from benchmarks.show.video.episode_video import write_mp4
from scenarios.envs.follow_env import FollowEnv
from scenarios.envs.settings import OWN_WORLD
from sim.checks import check
from trackers.atomic_file import atomic_file
from trackers.belief.features import shares_of
from trackers.protocols import Controller
from trackers.types import CameraCommand

PIXELS = "observation.pixels"
PRIVILEGED = "privileged."
IN_VIEW = f"{PRIVILEGED}in_view"
ENCODING = {"crf": "18", "g": "2", "bf": "0", "preset": "veryfast"}
"""Of films: every other picture is a key frame, so that any one of them is soon decoded."""
_STEP = ("action", "reward", "terminated", "truncated")
_PICTURE = pa.struct([("bytes", pa.binary()), ("path", pa.string())])
Rows = list[dict[str, Any]]


@dataclass(frozen=True)
class EpisodeFile:
    """A recorded episode.

    Attributes:
        folder: where its files lie. seed: of the episode.
    """

    folder: Path
    seed: int

    @property
    def table_file(self) -> Path:
        """The table; written last of all, so that an episode without it does not exist."""
        return self.folder / f"{self.seed:06d}.parquet"

    @property
    def film(self) -> Path:
        """The film, if the set has one: a picture a step."""
        return self.folder / f"{self.seed:06d}.mp4"

    @property
    def names(self) -> list[str]:
        """Names of the columns."""
        return list(pq.read_schema(self.table_file).names)

    @property
    def step_count(self) -> int:
        """Number of steps T."""
        return int(pq.read_metadata(self.table_file).num_rows) - 1

    def numbers(self, name: str) -> NDArray[Any]:
        """Return a column as (T + 1, …), of the parts of a step as (T, …)."""
        table = pq.read_table(self.table_file, columns=[name])
        rows, field = table.slice(0, len(table) - 1) if name in _STEP else table, table.schema.field(name)
        is_list = pa.types.is_fixed_size_list(field.type)
        dtype = np.dtype((field.type.value_type if is_list else field.type).to_pandas_dtype())
        return array_of(rows[name], dtype, tuple(json.loads(field.metadata[b"shape"])) if is_list else ())

    def pictures(self) -> NDArray[np.uint8]:
        """Return the pictures of the table (T + 1, H, W, 3)."""
        coded = pq.read_table(self.table_file, columns=[PIXELS])[PIXELS].to_pylist()
        return np.array([CODINGS["png"].decode(each["bytes"]) for each in coded], np.uint8)


def options_of(seed: int) -> dict[str, int]:
    """Return the options of ``reset`` that bring an episode, in its own world as the catalogue has it."""
    return {"episode_seed": seed, "world_seed": OWN_WORLD}


def record(rollouts: Rollouts, seed: int, folder: Path) -> EpisodeFile:
    """Play an episode and write its files. Raises ValueError if the tracker or the controller fails."""
    env, rows, file = rollouts.make(), Rows(), EpisodeFile(folder, seed)
    try:
        played = _play(rollouts, env, seed)
        if rollouts.pictures == "h264":
            # A worker that outlived a killed run may be filming the same episode.
            with TemporaryDirectory(prefix=".film-", dir=folder) as scratch:
                film, rate_hz = Path(scratch) / file.film.name, env.unwrapped.metadata["render_fps"]
                write_mp4(film, _filmed(played, rows), rate_hz, options=ENCODING)
                film.replace(file.film)
        else:
            rows += (_coded(row, rollouts.pictures) for row in played)
    finally:
        env.close()
    table = _table(rows)
    with atomic_file(file.table_file) as opened:
        pq.write_table(table, opened, compression="zstd")
    return file


def _play(rollouts: Rollouts, env: Any, seed: int) -> Iterator[dict[str, Any]]:
    """Yield the rows of an episode; pictures are arrays (H, W, 3)."""
    with _of_tracker(rollouts.tracker):
        observed, info = env.reset(options=options_of(seed))
    steered: FollowEnv = env.unwrapped
    controller, loop, carrier = _controller(rollouts, steered, seed), steered.episode, steered.carrier
    step, ended = 0, False
    while True:
        row: dict[str, Any] = {"episode_seed": seed, "step": step, "time_s": float(loop.frame.observation.time_s)}
        views = observed if isinstance(observed, dict) else {"track": observed}
        row |= {f"observation.{name}": views[name] for name in sorted(views, reverse=True)}
        truth = {PRIVILEGED + name: value for name, value in info.items() if name != "episode_seed"}
        if ended:
            yield row | dict.fromkeys(_STEP) | truth
            return
        command = _command(rollouts.controller, controller, loop)
        # What is beyond the limits is clipped: the carrier does not obey it either.
        action = shares_of(carrier, command).astype(np.float32)
        with _of_tracker(rollouts.tracker):
            observed, reward, terminated, truncated, info = env.step(action)
        yield row | dict(zip(_STEP, (action, reward, terminated, truncated), strict=True)) | truth
        step, ended = step + 1, terminated or truncated


@contextmanager
def _of_tracker(name: str) -> Iterator[None]:
    """Raise ValueError in place of what a tracker's failure raises."""
    try:
        yield
    except RuntimeError as error:
        # The env has named it.
        raise ValueError(str(error)) from error
    except SystemExit as left:
        raise ValueError(f"tracker: expected an estimate of {name}, got sys.exit({left.code!r})") from left


def _controller(rollouts: Rollouts, env: FollowEnv, seed: int) -> Controller:
    made = rollouts.entry.create()
    if isinstance(made, ForeseeingController):
        settings = env.settings
        made.foresee(settings.scenario, settings.configuration_of(seed), seed, settings.link_settings)
    return made


def _command(name: str, controller: Controller, loop: Any) -> CameraCommand:
    observation = loop.seen.observation
    try:
        command = controller.command(observation, loop.estimate)
        check("command", isinstance(command, CameraCommand), "a CameraCommand", type(command).__name__)
        numbers = [getattr(command, axis) for axis in CameraCommand.__dataclass_fields__]
        check("command", bool(np.isfinite(numbers).all()), "finite numbers", command)
    except Exception as error:
        where = f"after frame {loop.frame.truth.frame}"
        raise ValueError(f"controller: expected a command of {name} {where}, got {reason_of(error)}") from error
    return command


def _filmed(played: Iterator[dict[str, Any]], rows: Rows) -> Iterator[tuple[NDArray[np.uint8], float]]:
    """Yield the picture and the time of each step, and keep the rest of all rows."""
    for row in played:
        picture = row.pop(PIXELS)
        rows.append(row)
        if row["action"] is not None:
            yield picture, row["time_s"]


def _coded(row: dict[str, Any], pictures: str) -> dict[str, Any]:
    if PIXELS in row:
        coding = CODINGS["png" if pictures == "raw" else pictures]
        row[PIXELS] = {"bytes": coding.encode(row[PIXELS]), "path": f"{row['step']:06d}.{coding.extension}"}
    return row


def _table(rows: Rows) -> pa.Table:
    """Return rows as a table; the metadata of a column has the shape of its arrays."""
    columns, fields = [], []
    for name, first in rows[0].items():
        values = [row[name] for row in rows]
        shape = np.shape(first) if isinstance(first, np.ndarray) else None
        if name == PIXELS:
            columns.append(pa.array(values, _PICTURE))
        elif shape is None:
            columns.append(pa.array(values, pa.from_numpy_dtype(np.asarray(first).dtype)))
        else:
            kind = pa.list_(pa.from_numpy_dtype(first.dtype), first.size)
            given = column_of(np.array([value for value in values if value is not None]), kind)
            columns.append(pa.concat_arrays([given, pa.nulls(len(values) - len(given), kind)]))
        metadata = None if shape is None else {"shape": json.dumps(shape)}
        fields.append(pa.field(name, columns[-1].type, metadata=metadata))
    return pa.table(columns, schema=huggingface(pa.schema(fields)))


def huggingface(schema: pa.Schema) -> pa.Schema:
    """Return a schema with the description of its columns that the library ``datasets`` reads."""
    features = {field.name: _feature(field) for field in schema}
    return schema.with_metadata({"huggingface": json.dumps({"info": {"features": features}})})


def _feature(field: pa.Field) -> dict[str, Any]:
    if field.name == PIXELS:
        return {"_type": "Image"}
    if pa.types.is_fixed_size_list(field.type):
        value = {"dtype": _named(field.type.value_type), "_type": "Value"}
        return {"feature": value, "length": field.type.list_size, "_type": "Sequence"}
    return {"dtype": _named(field.type), "_type": "Value"}


def _named(kind: pa.DataType) -> str:
    return {"double": "float64", "float": "float32"}.get(str(kind), str(kind))
