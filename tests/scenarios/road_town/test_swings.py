"""Gusts of edition 2: in closed loop they build up and turn the helicopter slowly, on set paths they are sudden."""

from __future__ import annotations

import math

import numpy as np
import pytest

from scenarios.road_town.flight import AirState, Pulse, draw_air, gust_attitude_rad
from scenarios.road_town.presets import PRESETS, RoadTown
from scenarios.road_town.swings import FASTEST_TURN_RAD_S, draw_swings
from sim.optics import PinholeCamera
from sim.rng import generator

STEERABLE = ["standard", "hard", "quick", "oblique"]


def _drawn(preset: RoadTown, closed_loop: bool) -> list[tuple[AirState, Pulse]]:
    """Return the swings of twenty episodes with their air."""
    camera = PinholeCamera.from_field_of_view(640, 480, math.radians(preset.field_of_view_deg))
    still_m, heading_rad = np.zeros((preset.frame_count, 2)), np.zeros(preset.frame_count)
    drawn = []
    for seed in range(20):
        rng = generator(seed, "air")
        air = draw_air(preset, still_m, heading_rad, rng)
        swings = draw_swings(preset, camera, air, {"turn": [], "excursion": []}, closed_loop, rng)
        drawn += [(air, swing) for swing in swings]
    return drawn


def _fastest_rad_s(preset: RoadTown, air: AirState, swing: Pulse) -> float:
    attitude_rad = gust_attitude_rad([swing], air.altitude_m, preset.frame_count, air.mount_rad)
    return float(np.abs(np.diff(attitude_rad, axis=0)).max() * preset.rate_hz)


@pytest.mark.parametrize("name", STEERABLE)
def test_no_gust_in_closed_loop_turns_the_helicopter_too_fast_to_be_flown_against(name: str) -> None:
    preset = PRESETS[name]
    for air, swing in _drawn(preset, True):
        assert swing.tilts
        assert swing.start_frame >= 0
        assert _fastest_rad_s(preset, air, swing) <= FASTEST_TURN_RAD_S + 1e-9
    open_loop = [_fastest_rad_s(preset, *each) for each in _drawn(preset, False) if each[1].tilts]
    assert max(open_loop, default=np.inf) > FASTEST_TURN_RAD_S, "the bound does not bind"


def test_most_gusts_in_closed_loop_build_up_and_some_are_sudden() -> None:
    preset = PRESETS["standard"]
    rises_s = np.array([swing.rise_frames / preset.rate_hz for _, swing in _drawn(preset, True)])
    assert preset.frame_outs.build_up_s is not None
    least_s, most_s = preset.frame_outs.build_up_s
    builds_up = rises_s >= least_s - 0.5 / preset.rate_hz
    assert 0.4 < builds_up.mean() < 0.85
    assert rises_s.max() <= most_s + 0.5 / preset.rate_hz
    assert rises_s[~builds_up].max() < 1.1


@pytest.mark.parametrize(("name", "closed_loop"), [("standard", False), ("paper-a2", True), ("paper-a3", False)])
def test_gusts_of_set_paths_and_of_paper_a_are_sudden(name: str, closed_loop: bool) -> None:
    rises = {swing.rise_frames for _, swing in _drawn(PRESETS[name], closed_loop) if swing.tilts}
    assert rises <= set(range(5, 11))
    assert len(rises) > 3
