"""Contact sheets of a data set: frames with their boxes, and one frame's channels."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from benchmarks.data.sets.channels import PICTURES, value_of
from benchmarks.data.sets.data_set import DataSet
from benchmarks.data.sets.page.boxes import STANDING_RGB, draw_boxes, zoomed
from benchmarks.data.sets.page.channel_pictures import Rgb, channel_picture
from benchmarks.data.sets.stored_episode import StoredEpisode
from benchmarks.show.video import marks
from benchmarks.show.video.drawing import picture_sheet
from scenarios import catalog
from scenarios.truth import Truth, meanings
from sim.checks import check

_EPISODES, _FRAMES, _WIDTH_PX, _CELL_PX = 4, 4, 512, 320
_NOTHING = (28, 30, 35)


@dataclass(frozen=True, slots=True)
class Shot:
    """A picture of a sheet: its title, more words, and its pixels (H, W, 3)."""

    title: str
    words: str
    image_rgb: Rgb


def boxed_shots(data: DataSet) -> list[list[Shot]]:
    """Return a few frames of several episodes, evenly spaced and equally many, with boxes; none without a channel."""
    if not data.request.channels:
        return []
    episodes = [data.episode(data.seeds[k]) for k in _spread(len(data.seeds), _EPISODES)]
    count = min(_FRAMES, *map(len, episodes))
    return [[_boxed(data, episode, frame) for frame in _spread(len(episode), count)] for episode in episodes]


def channel_shots(data: DataSet) -> list[Shot]:
    """Return every channel of one frame, that of the first episode which shows most objects."""
    episode = data.episode(data.seeds[0])
    index = _fullest(episode)
    frame = episode.frame(index)
    known = meanings(frame.truth)
    shots = []
    for channel in data.request.channels:
        value = value_of(frame, channel, lambda: episode.normals_of(index))
        if value is not None:
            image, words = channel_picture(channel, value, known.get(channel), _ids(frame.truth))
            shots.append(Shot(channel, words or f"seed {episode.seed}, frame {index}", zoomed(image, _WIDTH_PX)))
    return shots


def contact_sheet(data: DataSet) -> NDArray[np.uint8]:
    """Return frames with boxes, a row an episode, and below them one frame's channels: (H, W, 3).

    Raises:
        ValueError: if the set has no pixels.
    """
    check("channels", bool(data.request.channels), "a data set with at least one", "none")
    rows = [[(each.title, each.image_rgb) for each in row] for row in boxed_shots(data)]
    count = len(rows[0])
    # The channel under the boxes has been seen.
    cells = [(each.title, each.image_rgb) for each in channel_shots(data) if each.title != _drawn_on(data)]
    cells += [("", np.full_like(rows[0][0][1], _NOTHING))] * (-len(cells) % count)
    rows += [cells[k : k + count] for k in range(0, len(cells), count)]
    return picture_sheet(rows, _CELL_PX)


def _spread(count: int, wanted: int) -> list[int]:
    """Return up to ``wanted`` evenly spaced ones of the indices 0 … count - 1."""
    taken = min(count, wanted)
    return [int((k + 0.5) * count / taken) for k in range(taken)]


def _fullest(episode: StoredEpisode) -> int:
    """Return the frame with most visible boxes; of several that nearest to the middle."""
    count = len(episode)
    seen = [np.isfinite(episode.visible_boxes_of(k)[:, 0]).sum() for k in range(count)]
    return int(np.argmax(np.array(seen) - np.abs(np.arange(count) - count / 2) / (count + 1)))


def _drawn_on(data: DataSet) -> str:
    """Return the channel that boxes are drawn on: a picture, or without one whatever there is."""
    return next((each for each in PICTURES if each in data.request.channels), data.request.channels[0])


def _boxed(data: DataSet, episode: StoredEpisode, index: int) -> Shot:
    channel = _drawn_on(data)
    frame = episode.frame(index, (channel,))
    truth, camera = frame.truth, frame.observation.camera
    value = value_of(frame, channel, lambda: episode.normals_of(index))
    if value is None:
        image = np.full((camera.height_px, camera.width_px, 3), _NOTHING, np.uint8)
    else:
        image, _ = channel_picture(channel, value, meanings(truth).get(channel), _ids(truth))
    large = zoomed(image, _WIDTH_PX)
    target = catalog.scenario(data.request.scenario).target
    zoom = large.shape[1] / image.shape[1]
    draw_boxes(large, zoom, truth, episode.visible_boxes_of(index), target)
    for box_xyxy in episode.visible_boxes_of(index, "standing"):
        marks.draw_box(large, box_xyxy * zoom, STANDING_RGB, 1)
    title = f"seed {episode.seed} · frame {index} · {truth.time_s:.2f} s"
    return Shot(title, _described(truth, target), large)


def _ids(truth: Truth) -> NDArray[np.int64]:
    """Return the ids of all objects in the instance map, those that stand about too."""
    return np.concatenate([truth.instance_id, truth.standing_id])


def _described(truth: Truth, target: str) -> str:
    """Return the target's state, and how many of the objects are seen, in words."""
    seen = int(np.isin(truth.state, ("in", "partial")).sum())
    others = f"{seen} of {len(truth.names)} objects in view"
    if target not in truth.names:
        return others
    k = truth.index_of(target)
    state = str(truth.state[k])
    if state == "out":
        state = f"out for {truth.frames_since_exit[k] + 1} frames"
    return f"{target}: {state}; {others}"
