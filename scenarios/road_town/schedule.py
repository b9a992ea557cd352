"""Schedules: when the frame-outs of an episode shall begin and how long they shall last."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from scenarios.road_town.presets import APART_FRAMES, OVERHANG_FRAMES, SETTLE_FRAMES, RoadTown

_LENGTH_DRAWS, _PLACEMENTS, _SCHEDULES = 40, 400, 6
"""Numbers of draws of lengths, of placements per draw, and of schedules per draw before lengths are drawn anew."""


def schedules(
    preset: RoadTown, events: dict[str, list[int]], apart_frames: int, rng: np.random.Generator
) -> Iterator[list[tuple[int, int]]]:
    """Yield schedules: (first frame out, frames out) of every frame-out in order.

    The last one always fits: the fewest and shortest frame-outs, evenly, whatever the car does meanwhile.

    Args:
        events: frames at which the car starts a ``turn`` or an ``excursion``; frame-outs are placed over them.
        apart_frames: shortest time between frame-outs of the last one.
    """
    # An excursion too near either end cannot lie within a frame-out; it then happens in the picture.
    first, last = SETTLE_FRAMES + 22, preset.frame_count - SETTLE_FRAMES - preset.frame_outs.excursion_frames - 8
    events = {**events, "excursion": [frame for frame in events["excursion"] if first <= frame <= last]}
    for _ in range(_LENGTH_DRAWS):
        lengths = _draw_lengths(preset, events, rng)
        found = 0
        for _ in range(_PLACEMENTS):
            spans = _place(preset, events, lengths, rng)
            if spans:
                yield spans
                found += 1
            if found == _SCHEDULES:
                break
    yield preset.frame_outs.evenly(preset.frame_count, apart_frames)


def _draw_lengths(preset: RoadTown, events: dict[str, list[int]], rng: np.random.Generator) -> list[int]:
    """Return the length of every frame-out, in frames; the first ones are for the excursions."""
    settings = preset.frame_outs
    low, high = np.log(settings.frames[0]), np.log(settings.frames[1] + 1)
    count = int(rng.integers(settings.count[0], settings.count[1] + 1))
    lengths = np.exp(rng.uniform(low, high, count)).astype(int).tolist()
    for k in range(min(count, len(events["excursion"]))):
        # Long enough for the car to be well off the road when it is back in the picture.
        lengths[k] = max(lengths[k], settings.excursion_frames)
    # Drop frame-outs instead of shortening them: this keeps the preset's distribution of lengths.
    while len(lengths) > settings.count[0] and sum(lengths) + APART_FRAMES * len(lengths) > preset.frame_count - 50:
        lengths.pop()
    return lengths


def _place(
    preset: RoadTown, events: dict[str, list[int]], lengths: list[int], rng: np.random.Generator
) -> list[tuple[int, int]] | None:
    """Return (first frame out, frames out) of every frame-out in order, or None if two are too close."""
    settings, excursions, turns = preset.frame_outs, events["excursion"], events["turn"]
    spans: list[tuple[int, int]] = []
    for k, frames in enumerate(lengths):
        if settings.start_frame is not None and k == 0:
            start = settings.start_frame
        elif k < len(excursions):
            start = excursions[k] - int(rng.integers(0, 8))
        elif turns and rng.random() < settings.turn_share:
            start = turns[int(rng.integers(len(turns)))] - int(rng.integers(0, max(2, frames // 2)))
        else:
            start = int(rng.integers(SETTLE_FRAMES, max(preset.frame_count - frames, SETTLE_FRAMES + 1)))
        spans.append((start, frames))
    spans.sort()
    ends = [-OVERHANG_FRAMES] + [start + frames for start, frames in spans]
    starts = [start for start, _ in spans] + [preset.frame_count + OVERHANG_FRAMES]
    apart = all(start - end >= APART_FRAMES for start, end in zip(starts, ends, strict=True))
    return spans if apart else None
