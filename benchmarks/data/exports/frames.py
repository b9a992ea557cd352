"""Goes through the frames of a data set, one episode open at a time."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from benchmarks.data.sets.channels import CODINGS, PICTURES
from benchmarks.data.sets.data_set import DataSet
from benchmarks.data.sets.episode_writer import episode_folder
from benchmarks.data.sets.stored_episode import StoredEpisode
from scenarios.scenario import Frame
from trackers.types import CameraModel

ABSENT, OUT, OCCLUDED, PARTIAL = "absent", "out", "occluded", "partial"
"""States of objects, see ``Truth.state``."""


@dataclass(frozen=True)
class StoredFrame:
    """One frame of a data set.

    Attributes:
        episode: that it is of. index: in that.
        frame: observation and truth, with the pixels that were asked for only.
        visible_xyxy: (N, 4) boxes around the visible pixels of the objects, in pixels; NaN where none is seen.
        standing_visible_xyxy: (S, 4) likewise of those that stand about.
    """

    episode: StoredEpisode
    index: int
    frame: Frame
    visible_xyxy: NDArray[np.float64]
    standing_visible_xyxy: NDArray[np.float64]

    @property
    def is_seen(self) -> NDArray[np.bool_]:
        """(N,) whether objects show at least one pixel."""
        return ~np.isnan(self.visible_xyxy[:, 0])

    @property
    def camera(self) -> CameraModel:
        """Geometry of the camera."""
        return self.frame.observation.camera


def episodes(data: DataSet) -> Iterator[StoredEpisode]:
    """Yield the episodes of a data set, each closed and forgotten before the next is opened."""
    for seed in data.seeds:
        with closing(StoredEpisode(data.files, episode_folder(data.root, seed), data.request)) as episode:
            yield episode


def frames(episode: StoredEpisode, channels: tuple[str, ...] = ()) -> Iterator[StoredFrame]:
    """Yield the frames of an episode; of their pixels only ``channels`` are read."""
    for index in range(len(episode)):
        boxes = (episode.visible_boxes_of(index, table) for table in ("objects", "standing"))
        yield StoredFrame(episode, index, episode.frame(index, channels), *boxes)


def set_name(data: DataSet) -> str:
    """Return a name for a data set, without dots: scenario, preset, what was changed in that, and a renderer."""
    request = data.request
    changes = {
        "": None if request.size_px is None else "{}x{}".format(*request.size_px),
        "hz": None if request.rate_hz is None else f"{request.rate_hz:g}",
        "frames": request.frame_count,
    }
    words = [request.scenario, request.preset, *(f"{value}{unit}" for unit, value in changes.items() if value)]
    if request.renderer != "raster":
        words.append(request.renderer)
    # Readers take what follows a dot for the ending of a file.
    return "-".join(words).replace(".", "_")


def sequence_name(data: DataSet, seed: int) -> str:
    """Return a name for an episode: ``set_name`` and seed. Two of one name and edition show the same."""
    return f"{set_name(data)}-{seed:06d}"


def picture_ending(data: DataSet) -> str:
    """Return the ending of exported pictures, without a dot."""
    return _coding(data.request.pictures)[1]


def picture_bytes(episode: StoredEpisode, index: int, channel: str) -> tuple[str, bytes] | None:
    """Return the ending and the content of a picture's file: as stored, or as PNG. None if the frame has none."""
    assert channel in PICTURES
    stored = episode.coded(index, channel)
    if stored is None:
        return None
    coding, content = stored
    target, ending = _coding(coding)
    return ending, content if target == coding else CODINGS[target].encode(CODINGS[coding].decode(content))


def black_picture(data: DataSet, camera: CameraModel) -> tuple[str, bytes]:
    """Return the ending and the content of the file of a picture that is black all over."""
    coding, ending = _coding(data.request.pictures)
    return ending, CODINGS[coding].encode(np.zeros((camera.height_px, camera.width_px, 3), np.uint8))


def write_picture(stored: StoredFrame, channel: str, path: Path) -> bool:
    """Write a picture to ``path``, whose ending is set; return whether there was one."""
    found = picture_bytes(stored.episode, stored.index, channel)
    if found is not None:
        path.with_name(f"{path.name}.{found[0]}").write_bytes(found[1])
    return found is not None


def _coding(stored: str) -> tuple[str, str]:
    """Return the coding of exported pictures and their ending."""
    coding = stored if stored in ("png", "jpeg") else "png"
    return coding, CODINGS[coding].extension
