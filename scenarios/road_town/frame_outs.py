"""Frame-outs of the target: swings of the view, fitted to the wanted starts and lengths."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from scenarios.road_town.flight import AirState, Pulse, set_path, swing_out
from scenarios.road_town.presets import SETTLE_FRAMES, RoadTown
from scenarios.road_town.schedule import no_schedule, schedules
from scenarios.road_town.smooth import PEAK_SPEED
from sim.optics import PinholeCamera

STEERING_LAG_M = 9.0
"""Distance by which a steered camera trails the car; gusts in closed loop swing the view further out by as much."""
DRIFT_FROM_FRAMES = 45
"""Only frame-outs of at least this length may come from the helicopter's drift; in edition 2 all of them do."""
_DRIFT_SPEED_MPS = 16.0

IN, PARTIAL, OUT = 0, 1, 2


def picture_states(
    camera: PinholeCamera, poses: NDArray[np.float64], corners_world_m: NDArray[np.float64]
) -> NDArray[np.int64]:
    """Return IN, PARTIAL or OUT for the box around ``corners_world_m`` (T, K, 3) in each frame (T,)."""
    points_camera = np.einsum("tkj,tji->tki", corners_world_m - poses[:, None, :3, 3], poses[:, :3, :3])
    behind = (points_camera[..., 2] <= 1e-6).any(axis=1)
    with np.errstate(divide="ignore", invalid="ignore"):
        pixels = camera.focal_px * points_camera[..., :2] / points_camera[..., 2:] + camera.centre_px
    low, high = pixels.min(axis=1), pixels.max(axis=1)
    size = (camera.width_px, camera.height_px)
    out = behind | (high <= 0).any(axis=1) | (low >= size).any(axis=1)
    whole = (low >= 0).all(axis=1) & (high <= size).all(axis=1)
    return np.where(out, OUT, np.where(whole, IN, PARTIAL))


def frame_out_spans(states: NDArray[np.int64]) -> list[tuple[int, int]]:
    """Return (first frame out, first frame after it that is not out) of every stretch of OUT."""
    out = np.concatenate([[False], states == OUT, [False]])
    edges = np.flatnonzero(out[1:] != out[:-1])
    return [(int(a), int(b)) for a, b in zip(edges[::2], edges[1::2], strict=True)]


def draw_pulses(
    preset: RoadTown,
    camera: PinholeCamera,
    air: AirState,
    car_position_m: NDArray[np.float64],
    car_corners_m: NDArray[np.float64],
    events: dict[str, list[int]],
    closed_loop: bool,
    rng: np.random.Generator,
) -> list[Pulse]:
    """Return swings of the view that lose the car as often and as long as the preset demands.

    Args:
        car_position_m: (T, 2). car_corners_m: (T, 8, 3) of its bounding box.
        events: frames at which the car starts a ``turn`` or an ``excursion``; frame-outs are placed over them.

    Raises:
        ValueError: if no schedule fits, which a test over many seeds excludes for the presets.
    """
    for wanted in schedules(preset, events, rng):
        pulses = [_draw_pulse(preset, camera, air, *span, closed_loop, rng) for span in wanted]
        pulses = _fit(preset, camera, air, car_position_m, car_corners_m, pulses, wanted)
        states = picture_states(camera, set_path(preset, air, car_position_m, pulses), car_corners_m)
        if _acceptable(preset, states, wanted):
            return pulses
    raise no_schedule(preset)


def _draw_pulse(
    preset: RoadTown,
    camera: PinholeCamera,
    air: AirState,
    start: int,
    frames: int,
    closed_loop: bool,
    rng: np.random.Generator,
) -> Pulse:
    settings = preset.frame_outs
    direction = 0.0 if settings.aim == "ahead" else float(rng.uniform(-np.pi, np.pi))
    margin = float(rng.uniform(5.0, 9.0)) if frames < 15 else float(rng.uniform(6.0, 16.0))
    if closed_loop:
        margin += STEERING_LAG_M
    offset = swing_out(camera, air.altitude_m, direction, margin)
    tilts = closed_loop or settings.gusts_only or frames < DRIFT_FROM_FRAMES or rng.random() < 0.3
    if tilts:
        rise, fall = (int(rng.integers(5, 11)) for _ in range(2))
    else:
        rise = fall = int(PEAK_SPEED * np.hypot(*offset) / _DRIFT_SPEED_MPS * preset.rate_hz)
    return Pulse(start - rise // 2, rise, max(frames - rise // 2, 1), fall, offset, tilts)


def _fit(
    preset: RoadTown,
    camera: PinholeCamera,
    air: AirState,
    car_position_m: NDArray[np.float64],
    car_corners_m: NDArray[np.float64],
    pulses: list[Pulse],
    wanted: list[tuple[int, int]],
) -> list[Pulse]:
    """Shift and stretch the swings until start and length of each frame-out are close to those wanted."""
    for _ in range(6):
        states = picture_states(camera, set_path(preset, air, car_position_m, pulses), car_corners_m)
        spans = frame_out_spans(states)
        fitted = []
        for pulse, (start, frames) in zip(pulses, wanted, strict=True):
            middle = pulse.start_frame + pulse.rise_frames + pulse.hold_frames // 2
            span = min(spans, key=lambda s: abs(0.5 * (s[0] + s[1]) - middle), default=None)
            if span is None:
                return pulses
            fitted.append(
                replace(
                    pulse,
                    start_frame=pulse.start_frame + start - span[0],
                    hold_frames=max(pulse.hold_frames + frames - (span[1] - span[0]), 0),
                )
            )
        if fitted == pulses:
            break
        pulses = fitted
    return pulses


def _acceptable(preset: RoadTown, states: NDArray[np.int64], wanted: list[tuple[int, int]]) -> bool:
    spans = frame_out_spans(states)
    if len(spans) != len(wanted):
        return False
    low, high = preset.frame_outs.frames
    lengths = [end - start for start, end in spans]
    # A frame-out over an excursion may be longer than the preset's range.
    if not all(low <= length <= max(high, goal[1]) + 2 for length, goal in zip(lengths, wanted, strict=True)):
        return False
    if any(abs(span[0] - goal[0]) > 3 for span, goal in zip(spans, wanted, strict=True)):
        return False
    if not (states[:SETTLE_FRAMES] == IN).all():
        return False
    ends = [end for _, end in spans]
    nexts = [start for start, _ in spans[1:]] + [len(states)]
    for end, following in zip(ends, nexts, strict=True):
        back = np.flatnonzero(states[end:following] == IN)
        if len(back) == 0 or following - (end + int(back[0])) < SETTLE_FRAMES:
            return False
    return True
