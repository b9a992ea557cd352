"""Swings of the view: drawn before the flight, by the clock, not fitted to what the car does."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace
from itertools import pairwise

import numpy as np

from scenarios.road_town.flight import AirState, Pulse, gust_attitude_rad, swing_out
from scenarios.road_town.presets import (
    APART_FRAMES,
    CALM_FRAMES,
    FASTEST_TURN_RAD_S,
    OUT_FROM_SHARE,
    OVERHANG_FRAMES,
    SETTLE_FRAMES,
    RoadTown,
)
from scenarios.road_town.swing_geometry import PEAK_SPEED, drift_out, gust_out
from trackers.types import CameraModel

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
            if spans is not None:
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


STEERING_LAG_M = 9.0
"""Distance by which a steered camera trails the car; gusts in closed loop swing the view further out by as much."""
DRIFT_FROM_FRAMES = 45
"""Frame-outs of at least this length come from the helicopter's drift, where the preset allows it."""
_SHORT_FRAMES, _SHORT_MARGIN_M, _MARGIN_M = 15, (12.0, 16.0), (13.0, 24.0)
"""Ranges of the distance by which a centred car is outside the border, in short frame-outs and in longer ones."""
_SUDDEN_FRAMES = (5, 10)
"""Range of the rise and of the fall of a sudden gust."""
_DRIFT_SPEED_MPS = 20.0
_RIGHT_ANGLE_RAD = 0.5 * math.pi


def draw_swings(
    preset: RoadTown,
    camera: CameraModel,
    air: AirState,
    events: dict[str, list[int]],
    closed_loop: bool,
    rng: np.random.Generator,
) -> list[Pulse]:
    """Return the scheduled swings, in order. They take a car out that is in the middle of the picture.

    Args:
        events: frames at which the car starts a ``turn`` or an ``excursion``; swings are placed over them.

    Raises:
        ValueError: if an episode has no room for the fewest and shortest frame-outs.
    """
    preset.check_room(closed_loop)
    builds_up = closed_loop and preset.frame_outs.build_up_s is not None
    for wanted in schedules(preset, events, preset.apart_frames(closed_loop), rng):
        swings = [_draw_swing(preset, camera, air, *span, closed_loop, rng) for span in wanted]
        if not builds_up or not swings:
            return swings
        swings = _within_calm(preset, air, swings, wanted)
        if _are_apart(swings):
            return swings
    raise AssertionError("the last schedule fits")


def begun_at(swing: Pulse, frame: int, frame_count: int) -> Pulse | None:
    """Return a swing that begins on a frame; shorter, or None, if the episode would end before the car is back."""
    rise, fall = swing.rise_frames, swing.fall_frames
    latest = frame_count - SETTLE_FRAMES - frame - rise - round((1 - OUT_FROM_SHARE) * fall)
    return replace(swing, start_frame=frame, hold_frames=min(swing.hold_frames, latest)) if latest > 0 else None


def _draw_swing(
    preset: RoadTown,
    camera: CameraModel,
    air: AirState,
    start: int,
    frames: int,
    closed_loop: bool,
    rng: np.random.Generator,
) -> Pulse:
    settings = preset.frame_outs
    direction = 0.0 if settings.aim == "ahead" else float(rng.uniform(-np.pi, np.pi))
    margin = float(rng.uniform(*(_SHORT_MARGIN_M if frames < _SHORT_FRAMES else _MARGIN_M)))
    if closed_loop:
        margin += STEERING_LAG_M
    tilts = closed_loop or settings.gusts_only or frames < DRIFT_FROM_FRAMES
    if not tilts:
        # Near to one of the borders' normals: the way out of a corner would take seconds.
        nearest = round(direction / _RIGHT_ANGLE_RAD) * _RIGHT_ANGLE_RAD
        direction = 0.5 * (direction + nearest)
    offset = _offset_m(camera, air, direction, margin, tilts)
    build_up_frames = _SUDDEN_FRAMES
    if closed_loop and settings.build_up_s is not None and frames >= _SHORT_FRAMES:
        quickest_s, slowest_s = settings.build_up_s
        build_up_frames = round(quickest_s * preset.rate_hz), round(slowest_s * preset.rate_hz)
    rise, fall = _frames_between(*build_up_frames, rng)
    if not tilts:
        rise = fall = int(PEAK_SPEED * math.hypot(*offset) / _DRIFT_SPEED_MPS * preset.rate_hz)
    return _swing_over(start, frames, rise, fall, offset, tilts)


def _swing_over(start: int, frames: int, rise: int, fall: int, offset_m: tuple[float, float], tilts: bool) -> Pulse:
    """Return the swing that takes a centred car out for ``frames`` from ``start`` on; longer if its slopes are."""
    hold = max(frames - round((1 - OUT_FROM_SHARE) * (rise + fall)), 1)
    return Pulse(start - round(OUT_FROM_SHARE * rise), rise, hold, fall, offset_m, tilts)


def _within_calm(preset: RoadTown, air: AirState, swings: list[Pulse], wanted: list[tuple[int, int]]) -> list[Pulse]:
    """Return gusts that build up within what their frame-outs and the calm between these allow.

    The bound on their speed comes first: those that would turn the helicopter too fast take longer than wanted.
    """
    starts = [start for start, _ in wanted]
    ends = [start + frames for start, frames in wanted]
    # The frames of calm that each gust may take; half of what is between two.
    before = [starts[0], *((start - end - CALM_FRAMES) // 2 for end, start in zip(ends, starts[1:], strict=False))]
    after = [*before[1:], preset.frame_count]
    fitted = []
    for swing, (start, frames), calm_before, calm_after in zip(swings, wanted, before, after, strict=True):
        fewest, most = _fewest_frames(preset, air, swing.offset_m), int(0.5 * (frames - 1) / (1 - OUT_FROM_SHARE))
        rise = max(min(swing.rise_frames, most, int(calm_before / OUT_FROM_SHARE)), fewest)
        fall = max(min(swing.fall_frames, most, int(calm_after / OUT_FROM_SHARE)), fewest)
        start = max(start, math.ceil(OUT_FROM_SHARE * rise))
        fitted.append(_swing_over(start, frames, rise, fall, swing.offset_m, swing.tilts))
    return fitted


def _are_apart(gusts: list[Pulse]) -> bool:
    return all(after.start_frame - gust.end_frame >= CALM_FRAMES for gust, after in pairwise(gusts))


def _fewest_frames(preset: RoadTown, air: AirState, offset_m: tuple[float, float]) -> int:
    """Return the shortest rise of a gust in which it turns the helicopter slowly enough."""
    whole = Pulse(-1, 1, 1, 1, offset_m, True)
    turn_rad = float(np.abs(gust_attitude_rad([whole], air.altitude_m, 1, air.mount_rad)).max())
    return math.ceil(PEAK_SPEED * turn_rad / FASTEST_TURN_RAD_S * preset.rate_hz)


def _frames_between(fewest: int, most: int, rng: np.random.Generator) -> tuple[int, int]:
    rise, fall = rng.integers(fewest, most + 1, 2)
    return int(rise), int(fall)


def _offset_m(
    camera: CameraModel, air: AirState, direction_rad: float, margin_m: float, tilts: bool
) -> tuple[float, float]:
    if air.mount_rad == 0.0:
        return swing_out(camera, air.altitude_m, direction_rad, margin_m)
    out = gust_out if tilts else drift_out
    return out(camera, air.altitude_m, air.mount_rad, direction_rad, margin_m)
