"""Reads the files of programs that find body parts, SLEAP and DeepLabCut, as one place for each animal and frame.

An animal's place is the mean of its body parts, on frames on which more than half of them are known; else it is
missing. A part that DeepLabCut is less than ``LIKELY`` sure of is not known; SLEAP leaves out such parts itself.

* DeepLabCut, CSV: three heads, ``scorer``, ``bodyparts`` and ``coords`` (x, y, likelihood), with several animals a
  fourth, ``individuals``; then a row a frame, which begins with its number. HDF5: the same table as pandas stores it
  (``format="table"``), under ``df_with_missing``. Its heads are the text of a pickle there, whose words are read and
  which is not run. From DeepLabCut's documentation, "Output files", https://deeplabcut.github.io/DeepLabCut.
* SLEAP, analysis HDF5: ``tracks`` (track, xy, node, frame), or in the order that its attribute ``dims`` gives, and
  ``track_names``. Analysis CSV: ``track frame_idx instance.score`` and for each node ``NODE.x NODE.y NODE.score``, a
  row for each animal and frame. A project, ``.slp``: ``frames``, ``instances`` and the points of both kinds, those that
  a person placed and predicted ones; where both are of one track and frame the person's count. From the documentation
  of sleap-io, "Formats", https://io.sleap.ai.
"""

from __future__ import annotations

import json
import pickletools
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from sim.checks import check

LIKELY = 0.6
"""DeepLabCut's own default, ``pcutoff`` of its ``config.yaml``."""
_DIMS = ("track", "xy", "node", "frame")
_ONE = "1"
Tidy = tuple[pd.DataFrame, float | None]
"""Columns ``frame individual x y``, a row for each animal and frame; and the frame rate, None if it is not told."""


def read_deeplabcut_csv(path: Path) -> Tidy:
    """Return the animals of a CSV file of DeepLabCut."""
    heads = pd.read_csv(path, header=None, nrows=2, dtype=str).iloc[:, 0]
    levels = 4 if heads[1] == "individuals" else 3
    return _of_parts(pd.read_csv(path, header=list(range(levels)), index_col=0)), None


def read_sleap_csv(path: Path) -> Tidy:
    """Return the animals of an analysis CSV file of SLEAP. Raises ValueError for several in a frame without tracks."""
    table = pd.read_csv(path)
    nodes = [head[:-2] for head in table if head.endswith(".x")]
    x, y = (table[[f"{node}.{axis}" for node in nodes]].to_numpy(float) for axis in "xy")
    return _identified(path, table["frame_idx"].to_numpy(), table["track"].to_numpy(object), _middles(x, y)), None


def read_pose_hdf5(path: Path, file: Any) -> Tidy | None:
    """Return the animals of an open HDF5 file of SLEAP or DeepLabCut; None if it is of neither."""
    if "df_with_missing/table" in file:
        return _of_pandas(file["df_with_missing/table"]), None
    if {"tracks", "track_names"} <= set(file):
        return _of_analysis(file)
    if {"instances", "pred_points", "points", "frames"} <= set(file):
        return _of_project(path, file)
    return None


def _of_pandas(table: Any) -> pd.DataFrame:
    stored = table[()]
    kind = table.attrs["values_block_0_kind"]
    words = _words_of(kind if isinstance(kind, bytes) else str(kind).encode())
    values = stored["values_block_0"]
    check("df_with_missing", len(words) % values.shape[1] == 0, f"heads of {values.shape[1]} columns", len(words))
    heads = pd.MultiIndex.from_arrays(np.array(words).reshape(values.shape[1], -1).T)
    return _of_parts(pd.DataFrame(values, index=stored["index"], columns=heads))


def _words_of(pickled: bytes) -> list[str]:
    """Return the words of a pickled list of tuples of words, in order, without running it."""
    words: list[str] = []
    memory: dict[Any, str] = {}
    latest: str | None = None
    for operation, argument, _ in pickletools.genops(pickled):
        if operation.name in ("UNICODE", "BINUNICODE", "SHORT_BINUNICODE", "STRING"):
            latest = str(argument)
            words.append(latest)
        elif operation.name in ("PUT", "BINPUT", "LONG_BINPUT", "MEMOIZE"):
            if latest is not None:
                memory[len(memory) if argument is None else argument] = latest
            latest = None
        elif operation.name in ("GET", "BINGET", "LONG_BINGET") and argument in memory:
            words.append(memory[argument])
    return words


def _of_parts(table: pd.DataFrame) -> pd.DataFrame:
    """Return the animals of a table with heads scorer, individuals (maybe), bodyparts and coords."""
    *above, _, coordinate = (table.columns.get_level_values(k) for k in range(table.columns.nlevels))
    animal = above[1].astype(str) if len(above) > 1 else pd.Index([_ONE] * table.shape[1])
    found = []
    for name in dict.fromkeys(animal):
        x, y, sure = (
            table.loc[:, (animal == name) & (coordinate == each)].to_numpy(float) for each in ("x", "y", "likelihood")
        )
        unsure = sure < LIKELY if sure.shape == x.shape else np.zeros(x.shape, bool)
        place = _middles(np.where(unsure, np.nan, x), y)
        found.append(pd.DataFrame({"frame": table.index, "individual": name, "x": place[:, 0], "y": place[:, 1]}))
    return pd.concat(found)


def _of_analysis(file: Any) -> Tidy:
    tracks = file["tracks"]
    dims = json.loads(tracks.attrs["dims"]) if "dims" in tracks.attrs else list(_DIMS)
    check("dims", sorted(dims) == sorted(_DIMS), f"the dimensions {', '.join(_DIMS)}", ", ".join(map(str, dims)))
    ordered = np.transpose(tracks[()], [dims.index(each) for each in ("frame", "track", "xy", "node")])
    place = _middles(ordered[:, :, 0], ordered[:, :, 1])
    names = [each.decode() if isinstance(each, bytes) else str(each) for each in file["track_names"][()]]
    frame, track = (each.ravel() for each in np.indices(place.shape[:2]))
    names = names or [_ONE] * place.shape[1]
    x, y = place.reshape(-1, 2).T
    rows = pd.DataFrame({"frame": frame, "individual": np.array(names)[track], "x": x, "y": y})
    return rows, _rate_in(json.loads(file.attrs.get("video_backend_metadata", "{}")))


def _of_project(path: Path, file: Any) -> Tidy:
    frames, instances = file["frames"][()], file["instances"][()]
    videos = np.unique(frames["video"])
    check(path.name, len(videos) <= 1, "labels of one video", f"ones of {len(videos)}")
    names = [json.loads(each)[1] for each in file["tracks_json"][()]]
    # A person's last, since the last one of a track and frame counts.
    instances = instances[np.argsort(instances["instance_type"] == 0, kind="stable")]
    points = {kind: file[name][()] for kind, name in ((0, "points"), (1, "pred_points"))}
    place = np.full((len(instances), 2), np.nan)
    for k, each in enumerate(instances):
        own = points[int(each["instance_type"])][each["point_id_start"] : each["point_id_end"]]
        seen = own["visible"].astype(bool)
        place[k] = _middles(np.where(seen, own["x"], np.nan)[None], own["y"][None])[0]
    of_frame = dict(zip(frames["frame_id"].tolist(), frames["frame_idx"].tolist(), strict=True))
    frame = np.array([of_frame[each] for each in instances["frame_id"].tolist()], int)
    track = np.array([names[each] if each >= 0 else np.nan for each in instances["track"].tolist()], object)
    told = json.loads(file["videos_json"][int(videos[0])]) if len(videos) else {}
    return _identified(path, frame, track, place), _rate_in(told.get("backend", {}))


def _identified(path: Path, frame: NDArray[Any], track: NDArray[Any], place: NDArray[np.float64]) -> pd.DataFrame:
    """Return the rows that have a track; all of them if none has one and each is alone in its frame."""
    rows = pd.DataFrame({"frame": frame, "individual": track, "x": place[:, 0], "y": place[:, 1]})
    if rows["individual"].isna().all():
        alone = not rows["frame"].duplicated().any()
        check(path.name, alone, "tracks, as several animals are in one frame", "instances without any")
        return rows.assign(individual=_ONE)
    named = rows[rows["individual"].notna()].astype({"individual": str})
    return named.drop_duplicates(["frame", "individual"], keep="last")


def _middles(x: NDArray[np.float64], y: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the mean (…, 2) of points (…, K) where more than half are known, else NaN."""
    known = np.isfinite(x) & np.isfinite(y)
    count = known.sum(axis=-1)
    sums = (np.where(known, each, 0.0).sum(axis=-1) for each in (x, y))
    good = 2 * count > x.shape[-1]
    return np.stack([np.where(good, total / np.maximum(count, 1), np.nan) for total in sums], axis=-1)


def _rate_in(values: dict[str, Any]) -> float | None:
    rate_hz = values.get("fps")
    return float(rate_hz) if rate_hz and 0 < float(rate_hz) < np.inf else None
