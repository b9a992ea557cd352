"""Schedules lose the target as often and as long as the preset demands, and during the planned events."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from scenarios.road_town.flight import draw_air, set_path
from scenarios.road_town.frame_outs import IN, OUT, _acceptable, draw_pulses, frame_out_spans, picture_states
from scenarios.road_town.presets import PRESETS_V1, FrameOuts
from sim.optics import PinholeCamera
from sim.rng import generator

STANDARD = PRESETS_V1["standard"]
CAMERA = PinholeCamera.from_field_of_view(640, 480, np.deg2rad(50.0))


def _drive(frames: int):
    """Return positions (T, 2), headings (T,) and box corners (T, 8, 3) of a car that drives straight at 8 m/s."""
    position = np.column_stack([8.0 / 15.0 * np.arange(frames), np.zeros(frames)])
    corners = np.array([[x, y, z] for x in (-2.2, 2.2) for y in (-0.9, 0.9) for z in (0.0, 1.5)])
    return position, np.zeros(frames), corners + np.concatenate([position, np.zeros((frames, 1))], 1)[:, None]


def _states(preset, events, seed, closed_loop=False):
    position, heading, corners = _drive(preset.frame_count)
    rng = generator(seed, "air")
    air = draw_air(preset, position, heading, rng)
    pulses = draw_pulses(preset, CAMERA, air, position, corners, events, closed_loop, rng)
    return pulses, picture_states(CAMERA, set_path(preset, air, position, pulses), corners)


@settings(max_examples=12, deadline=None)
@given(st.integers(0, 9_999))
def test_number_length_and_spacing_are_those_of_the_preset(seed):
    _, states = _states(STANDARD, {"turn": [], "excursion": []}, seed)
    spans = frame_out_spans(states)
    assert 2 <= len(spans) <= 4
    assert all(5 <= end - start <= 122 for start, end in spans)
    assert (states[:25] == IN).all()
    for (_, end), (start, _) in zip(spans, [*spans[1:], (len(states), 0)], strict=True):
        assert (states[end:start] == IN).sum() >= 20


def test_lengths_are_spread_over_the_whole_range():
    lengths = np.concatenate(
        [
            [b - a for a, b in frame_out_spans(_states(STANDARD, {"turn": [], "excursion": []}, seed)[1])]
            for seed in range(40)
        ]
    )
    assert lengths.min() <= 8
    assert lengths.max() >= 80
    assert 15 <= np.median(lengths) <= 45


@pytest.mark.parametrize("seed", range(6))
def test_an_excursion_happens_outside_the_picture(seed):
    _, states = _states(STANDARD, {"turn": [], "excursion": [140]}, seed)
    assert any(start - 1 <= 140 <= end for start, end in frame_out_spans(states))


def test_closed_loop_is_forced_by_gusts_alone():
    for seed in range(4):
        pulses, _ = _states(STANDARD, {"turn": [], "excursion": []}, seed, closed_loop=True)
        assert all(pulse.tilts for pulse in pulses)


def test_impossible_wishes_are_refused_by_name():
    crowded = replace(STANDARD, frame_count=515, frame_outs=FrameOuts(count=(5, 5), frames=(60, 60)))
    with pytest.raises(
        ValueError, match="frame_count: expected enough for 5 to 5 frame-outs of 60 to 60 frames, got 515"
    ):
        _states(crowded, {"turn": [], "excursion": []}, 0)


def test_a_long_excursion_lets_no_other_frame_out_be_long() -> None:
    """Lengths of 25 and 8 frames are wanted; 14 is the largest length without an excursion."""
    preset = PRESETS_V1["paper-a3"]
    wanted = [(40, 25), (110, 8)]

    def states(*spans: tuple[int, int]) -> np.ndarray:
        seen = np.full(preset.frame_count, IN)
        for start, frames in spans:
            seen[start : start + frames] = OUT
        return seen

    assert preset.frame_outs.frames[1] == 14
    assert _acceptable(preset, states((40, 25), (110, 8)), wanted)
    assert _acceptable(preset, states((40, 27), (110, 16)), wanted)
    assert not _acceptable(preset, states((40, 25), (110, 17)), wanted)
    assert not _acceptable(preset, states((40, 28), (110, 8)), wanted)
