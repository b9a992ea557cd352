"""The contact sheet of a data set: frames of several episodes with their boxes, and every channel of one frame."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from benchmarks.data.sets.channels import EMPTY, PICTURES, Rgb, channel_picture, value_of
from benchmarks.data.sets.data_set import DataSet
from benchmarks.data.sets.stored_episode import StoredEpisode
from benchmarks.show.video import marks
from benchmarks.show.video.drawing import picture_sheet
from scenarios import catalog
from scenarios.truth import INSIDE, Truth, meanings

LEGEND = "visible boxes blue, amodal ones orange at their corners, those of what is parked or moored pink"
_STANDING_RGB = (204, 121, 167)
_EPISODES, _FRAMES, _WIDTH_PX, _CELL_PX = 4, 4, 512, 320
_LABEL_SIZE, _LABEL_PX = 13, 17
"""Size of a label's letters, and its height."""
_LABELLED_FROM_PX = 26.0
"""Width of a box from which on an object has corners and a label; the target always has."""
_THICK_FROM_PX = 40.0
"""Width from which on the visible box of the target is drawn thick; it would cover a smaller object."""
Cell = tuple[str, Rgb]
"""A title and a picture."""


def contact_sheet(data: DataSet) -> NDArray[np.uint8]:
    """Return frames with boxes, a row an episode, and below them one frame's channels: (H, W, 3)."""
    rows = boxed_frames(data)
    count = len(rows[0])
    cells = channel_cells(data)
    cells += [("", np.full_like(rows[0][0][1], EMPTY))] * (-len(cells) % count)
    return picture_sheet([*rows, *(cells[k : k + count] for k in range(0, len(cells), count))], _CELL_PX)


def boxed_frames(data: DataSet) -> list[list[Cell]]:
    """Return a few frames of several episodes, evenly spaced and equally many, with boxes."""
    episodes = [data.episode(data.seeds[k]) for k in _spread(len(data.seeds), _EPISODES)]
    count = min(_FRAMES, *map(len, episodes))
    return [[_boxed(data, episode, frame) for frame in _spread(len(episode), count)] for episode in episodes]


def channel_cells(data: DataSet) -> list[Cell]:
    """Return the other channels of one frame, that of the first episode with most visible boxes, nearest its middle."""
    episode = data.episode(data.seeds[0])
    count = len(episode)
    seen = np.array([np.isfinite(episode.visible_boxes_of(k)[:, 0]).sum() for k in range(count)])
    index = int(np.argmax(seen - np.abs(np.arange(count) - count / 2) / (count + 1)))
    others = (channel for channel in data.request.channels if channel != _background(data))
    drawn = [(channel, _drawn(episode, index, channel)) for channel in others]
    return [(f"{channel} {found[1]}".strip(), _zoomed(found[0], _WIDTH_PX)) for channel, found in drawn if found]


def _spread(count: int, wanted: int) -> list[int]:
    """Return up to ``wanted`` evenly spaced ones of the indices 0 … count - 1."""
    taken = min(count, wanted)
    return [int((k + 0.5) * count / taken) for k in range(taken)]


def _background(data: DataSet) -> str:
    """Return the channel that boxes are drawn on: a picture, or without one whatever there is."""
    return next((each for each in PICTURES if each in data.request.channels), data.request.channels[0])


def _drawn(episode: StoredEpisode, index: int, channel: str) -> tuple[Rgb, str] | None:
    """Return a channel of a frame as a picture with its range in words; None for a picture that was lost."""
    frame = episode.frame(index, (channel,))
    value = value_of(frame, channel, lambda: episode.normals_of(index))
    ids = np.concatenate([frame.truth.instance_id, frame.truth.standing_id])
    return None if value is None else channel_picture(channel, value, meanings(frame.truth).get(channel), ids)


def _boxed(data: DataSet, episode: StoredEpisode, index: int) -> Cell:
    frame = episode.frame(index, ())
    truth, camera = frame.truth, frame.observation.camera
    drawn = _drawn(episode, index, _background(data))
    large = _zoomed(drawn[0] if drawn else np.full((camera.height_px, camera.width_px, 3), EMPTY, np.uint8), _WIDTH_PX)
    zoom = large.shape[1] / camera.width_px
    draw_boxes(large, zoom, truth, episode.visible_boxes_of(index), catalog.scenario(data.request.scenario).target)
    for box_xyxy in episode.visible_boxes_of(index, "standing"):
        marks.draw_box(large, box_xyxy * zoom, _STANDING_RGB, 1)
    return f"seed {episode.seed} · frame {index} · {truth.time_s:.2f} s", large


def _zoomed(image: Rgb, width_px: int) -> Rgb:
    """Return a picture (h, w, 3) scaled to a width; pixels stay sharp where it grows."""
    height = round(width_px * image.shape[0] / image.shape[1])
    # Whole steps first: other factors would make some pixels wider than others.
    whole = max(1, -(-width_px // image.shape[1]))
    image = np.repeat(np.repeat(image, whole, axis=0), whole, axis=1)
    return np.asarray(cv2.resize(image, (width_px, height), interpolation=cv2.INTER_AREA), np.uint8)


def draw_boxes(image: Rgb, zoom: float, truth: Truth, visible_xyxy: NDArray[np.float64], target: str) -> None:
    """Draw the boxes of all objects that are at least in part within the borders; an arrow points to a target outside.

    Args:
        image: the frame's picture at ``zoom`` times its size.
        visible_xyxy: (N, 4) boxes of the visible pixels, NaN where there are none.
        target: its name; nothing special if no object has it.
    """
    widths = np.nan_to_num(truth.box_xyxy[:, 2] - truth.box_xyxy[:, 0]) * zoom
    is_target = np.array([name == target for name in truth.names])
    # Corners of a few pixels would hide what they are about.
    is_large = is_target | (widths >= _LABELLED_FROM_PX)
    inside = np.isin(truth.state, INSIDE)
    for k in np.flatnonzero(inside & is_large):
        marks.draw_corners(image, truth.box_xyxy[k] * zoom, marks.ESTIMATE, 1)
    for k in np.flatnonzero(inside):
        thick = is_target[k] and widths[k] >= _THICK_FROM_PX
        marks.draw_box(image, visible_xyxy[k] * zoom, marks.TRUTH, 2 if thick else 1)
    labels: list[NDArray[np.float64]] = []
    for k in sorted(np.flatnonzero(inside & is_large), key=lambda k: (not is_target[k], -widths[k])):
        words = truth.names[k] if truth.state[k] == "in" else f"{truth.names[k]} {truth.state[k]}"
        _draw_label(image, truth.box_xyxy[k] * zoom, words, labels)
    for k in np.flatnonzero(is_target & (truth.state == "out")):
        marks.draw_pointer(image, truth.position_px[k] * zoom, marks.TRUTH)


def _draw_label(image: Rgb, box_xyxy: NDArray[np.float64], words: str, others: list[NDArray[np.float64]]) -> None:
    """Write above a box, or below it at the upper border; not over another label, all of which are ``others``."""
    if not np.isfinite(box_xyxy).all():
        return
    size = np.array([marks.text_width_px(words, size=_LABEL_SIZE) + 6, _LABEL_PX])
    above = box_xyxy[1] - _LABEL_PX - 2
    corner = np.array([box_xyxy[0], above if above >= 0 else box_xyxy[3] + 2])
    corner = np.clip(corner, 0, np.maximum(np.array(image.shape[1::-1]) - size, 0)).astype(int)
    if any((corner < other[2:]).all() and (other[:2] < corner + size).all() for other in others):
        return
    others.append(np.concatenate([corner, corner + size]))
    marks.draw_label(image, (corner[0] + 3, corner[1] + 13), words, marks.OBSERVED, size=_LABEL_SIZE)
