"""Gusts: in closed loop they build up and turn the helicopter slowly, on set paths they are sudden."""

from __future__ import annotations

import itertools
import math
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from scenarios.road_town.flight import AirState, Pulse, draw_air, gust_attitude_rad
from scenarios.road_town.pilot import frame_out_spans, picture_states
from scenarios.road_town.plan import TARGET, make_plan
from scenarios.road_town.presets import (
    APART_FRAMES,
    CALM_FRAMES,
    FASTEST_TURN_RAD_S,
    OUT_FROM_SHARE,
    OVERHANG_FRAMES,
    PRESETS,
    FrameOuts,
    RoadTown,
)
from scenarios.road_town.road_map import RoadMap
from scenarios.road_town.swing_geometry import smooth_step
from scenarios.road_town.swings import draw_swings
from sim.rng import episode_seed, generator
from trackers.types import CameraModel


def test_a_smooth_step_goes_from_rest_to_rest() -> None:
    t, dt = np.linspace(-0.5, 1.5, 20_001, retstep=True)
    place = smooth_step(t)
    speed = np.gradient(place, dt)
    acceleration = np.gradient(speed, dt)
    assert (place[t <= 0] == 0).all()
    assert (place[t >= 1] == 1).all()
    assert (speed >= 0).all()
    # Speed 1.875 in the middle is the polynomial's; neither it nor the acceleration jumps.
    assert abs(speed.max() - 1.875) < 1e-6
    assert np.abs(np.diff(acceleration)).max() < 0.01


STEERABLE = ["standard", "hard", "quick", "oblique"]


def _drawn(preset: RoadTown, closed_loop: bool) -> list[tuple[AirState, Pulse]]:
    """Return the swings of twenty episodes with their air."""
    return [(air, swing) for air, swings in _episodes(preset, closed_loop, 20) for swing in swings]


def _episodes(preset: RoadTown, closed_loop: bool, count: int) -> list[tuple[AirState, list[Pulse]]]:
    """Return the air and the swings of each episode."""
    camera = CameraModel.from_field_of_view(640, 480, math.radians(preset.field_of_view_deg))
    episodes = []
    for seed in range(count):
        rng = generator(seed, "air")
        air = draw_air(preset, 0.0, rng)
        swings = draw_swings(preset, camera, air, {"turn": [], "excursion": []}, closed_loop, rng)
        episodes.append((air, swings))
    return episodes


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


@pytest.mark.parametrize("name", ["standard", "oblique"])
def test_between_gusts_that_build_up_there_is_calm(name: str) -> None:
    preset, calm_frames = PRESETS[name], []
    for _, gusts in _episodes(preset, True, 100):
        calm_frames += [after.start_frame - before.end_frame for before, after in pairwise(gusts)]
        assert gusts[-1].end_frame <= preset.frame_count
    assert len(calm_frames) > 100
    assert min(calm_frames) >= CALM_FRAMES
    assert np.median(calm_frames) > 2 * CALM_FRAMES


def test_an_early_gust_begins_later_rather_than_too_fast_or_before_the_episode() -> None:
    frame_outs = replace(PRESETS["oblique"].frame_outs, count=(1, 1), start_frame=APART_FRAMES - OVERHANG_FRAMES)
    preset = replace(PRESETS["oblique"], rate_hz=30.0, frame_outs=frame_outs)
    for air, gust in _drawn(preset, True):
        assert gust.start_frame >= 0
        assert _fastest_rad_s(preset, air, gust) <= FASTEST_TURN_RAD_S + 1e-9


@pytest.mark.parametrize("frames", [16, 20, 25, 31])
def test_gusts_that_build_up_last_as_long_as_planned(frames: int) -> None:
    frame_outs = replace(PRESETS["standard"].frame_outs, count=(2, 2), frames=(frames, frames))
    for _, gust in _drawn(replace(PRESETS["standard"], frame_outs=frame_outs), True):
        out = gust.share(300) > smooth_step(np.array([OUT_FROM_SHARE]))
        assert abs(np.count_nonzero(out) - frames) <= 2


def test_most_gusts_in_closed_loop_build_up_and_some_are_sudden() -> None:
    preset = PRESETS["standard"]
    rises_s = np.array([swing.rise_frames / preset.rate_hz for _, swing in _drawn(preset, True)])
    assert preset.frame_outs.build_up_s is not None
    least_s, most_s = preset.frame_outs.build_up_s
    builds_up = rises_s >= least_s - 0.5 / preset.rate_hz
    assert 0.4 < builds_up.mean() < 0.85
    assert rises_s.max() <= most_s + 0.5 / preset.rate_hz
    assert 0.2 < (rises_s < 1.1).mean() < 0.5


@pytest.mark.parametrize(("name", "closed_loop"), [("standard", False), ("paper-a2", True), ("paper-a3", False)])
def test_gusts_of_set_paths_and_of_paper_a_are_sudden(name: str, closed_loop: bool) -> None:
    rises = {swing.rise_frames for _, swing in _drawn(PRESETS[name], closed_loop) if swing.tilts}
    assert rises <= set(range(5, 11))
    assert len(rises) > 3


def test_more_frame_outs_than_an_episode_has_room_for_are_refused() -> None:
    crowded = replace(PRESETS["standard"], frame_count=515, frame_outs=FrameOuts(count=(5, 5), frames=(60, 60)))
    assert all(len(swings) == 5 for _, swings in _episodes(crowded, False, 3))
    with pytest.raises(ValueError, match=r"frame_count: expected at least 5.. for 5 or more frame-outs, got 513"):
        replace(crowded, frame_count=513)
    with pytest.raises(ValueError, match=r"frame_count: expected at least 5.. for 5 or .* in closed loop, got 515"):
        _episodes(crowded, True, 1)


@pytest.mark.parametrize("closed_loop", [False, True])
@pytest.mark.parametrize("frame_count", [2, 20, 100])
def test_episodes_of_any_length_may_have_no_frame_out(frame_count: int, closed_loop: bool) -> None:
    none = FrameOuts(count=(0, 0))
    preset = replace(PRESETS["standard"], frame_count=frame_count, frame_outs=none, excursions=(1, 1))
    for seed in range(3):
        plan = make_plan(preset, seed, closed_loop=closed_loop)
        assert plan.pulses == ()
        assert len(plan.camera_poses) == frame_count


def test_some_episodes_have_no_frame_out_where_the_range_begins_at_none() -> None:
    preset = replace(PRESETS["standard"], frame_outs=FrameOuts(count=(0, 2)))
    assert {len(swings) for _, swings in _episodes(preset, False, 12)} == {0, 1, 2}


@pytest.mark.heavy
@pytest.mark.parametrize("closed_loop", [False, True])
@pytest.mark.parametrize(("name", "rate_hz"), [("standard", 15.0), ("oblique", 30.0), ("quick", 5.0)])
def test_a_length_that_is_allowed_has_room_for_the_frame_outs_of_every_seed(
    name: str, rate_hz: float, closed_loop: bool
) -> None:
    """An excursion in the middle of 150 frames left room for no two frame-outs, so the third episode was an error."""
    preset = replace(PRESETS[name], rate_hz=rate_hz)
    shortest = preset.frame_outs.fewest_frames(preset.apart_frames(closed_loop))
    camera = CameraModel.from_field_of_view(640, 480, math.radians(preset.field_of_view_deg))
    for frame_count, excursion in itertools.product((shortest, shortest + 7, 1.4 * shortest), (50, 65, 90)):
        asked = replace(preset, frame_count=int(frame_count))
        air = draw_air(asked, 0.0, generator(1, "air"))
        events = {"turn": [70], "excursion": [excursion]}
        swings = draw_swings(asked, camera, air, events, closed_loop, generator(excursion, "swings"))
        assert len(swings) >= asked.frame_outs.count[0]
        assert all(after.start_frame > before.start_frame for before, after in pairwise(swings))
        assert swings[-1].start_frame + OUT_FROM_SHARE * swings[-1].rise_frames < frame_count
        if closed_loop:
            gaps = [after.start_frame - before.end_frame for before, after in pairwise(swings)]
            assert min(gaps, default=CALM_FRAMES) >= CALM_FRAMES


@pytest.mark.heavy
def test_the_lengths_of_paper_a3_are_alike_on_the_road_and_off_it() -> None:
    """They were 8 and 25 frames in the middle, so that the lengths alone could have made the paper's difference."""
    lengths: dict[bool, list[int]] = {True: [], False: []}
    for seed in range(60):
        plan = make_plan(PRESETS["paper-a3"], episode_seed(seed, "road-town-v2", 0), closed_loop=False)
        states = picture_states(plan.camera, plan.camera_poses, plan.target_corners_m())
        on_road = RoadMap(plan.layout.graph).is_on_road(plan.motion.position_m[:, TARGET])
        for start, end in frame_out_spans(states):
            lengths[bool(on_road[start:end].all())].append(end - start)
    road, off = (np.array(lengths[on]) for on in (True, False))
    print(f"paper-a3: {len(road)} on the road, median {np.median(road)}; {len(off)} off it, {np.median(off)}")
    assert min(len(road), len(off)) > 30
    assert abs(np.median(road) - np.median(off)) <= 3
    np.testing.assert_allclose(np.percentile(road, (10, 90)), np.percentile(off, (10, 90)), atol=4)
