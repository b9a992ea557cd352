from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from benchmarks.judges.frame_out.judge import FrameOutJudge
from benchmarks.judges.frame_out.metrics.frame_outs import find_frame_outs
from scenarios import catalog
from scenarios.road_town.presets import PRESETS
from scenarios.road_town.scenario import RoadTownEpisode
from tests.benchmarks.hand_made import truth_of
from trackers.types import CameraModel, Start

STATES = st.lists(st.sampled_from(["in", "partial", "occluded", "out"]), min_size=1, max_size=60)


def test_a_frame_out_is_found_with_its_attributes() -> None:
    states = ["in", "partial", "out", "out", "out", "partial", "in", "in"]
    truth = truth_of(states, on_road=[True] * 4 + [False] + [True] * 3, turning=[False] * 3 + [True] + [False] * 4)
    (found,) = find_frame_outs(truth)
    assert found.attributes() == {
        "index": 0,
        "exit_frame": 2,
        "length_frames": 3,
        "back_frame": 6,
        "kind": "excursion",
        "side": "left",
        "turned": True,
        "long": None,
    }
    assert found.watch_end_frame == 8


def test_what_lasts_longer_than_any_that_the_preset_draws_is_long() -> None:
    states = ["in", "out", "out", "in", "out", "out", "out", "in"]
    assert [each.long for each in find_frame_outs(replace(truth_of(states), longest_frames=2))] == [False, True]


def test_the_longest_is_that_of_the_set_path_of_the_preset() -> None:
    """In closed loop the length of a frame-out is the tracker's doing."""
    assert isinstance(RoadTownEpisode.preset, property)
    start = Start(CameraModel(100, 80, 100.0), box_xyxy=np.zeros(4))
    for preset, closed_loop, longest_frames in (
        (PRESETS["standard"], False, 120),
        (PRESETS["standard"], True, None),
        ("another scene's", False, None),
    ):
        episode: Any = SimpleNamespace(rate_hz=15.0, closed_loop=closed_loop, start=start, preset=preset)
        assert FrameOutJudge(episode, catalog.scenario("road-town"))._longest_frames == longest_frames


def test_a_car_that_only_peeps_in_is_not_back() -> None:
    first, second = find_frame_outs(truth_of(["in", "out", "partial", "out", "in"]))
    assert first.back_frame is None
    assert first.watch_end_frame == 3
    assert second.back_frame == 4


def test_the_road_counts_until_the_car_is_back_in_full() -> None:
    (found,) = find_frame_outs(truth_of(["in", "out", "partial", "in"], on_road=[True, True, False, True]))
    assert found.kind == "excursion"
    (found,) = find_frame_outs(truth_of(["in", "out", "partial", "in"], on_road=[True, True, True, False]))
    assert found.kind == "road"


@settings(deadline=None)
@given(STATES)
def test_frame_outs_hold_exactly_the_frames_outside(states: list[str]) -> None:
    found = find_frame_outs(truth_of(states))
    covered = [k for f in found for k in range(f.exit_frame, f.exit_frame + f.length_frames)]
    assert covered == [k for k, state in enumerate(states) if state == "out"]
    for frame_out in found:
        assert frame_out.exit_frame == 0 or states[frame_out.exit_frame - 1] != "out"
        end = frame_out.exit_frame + frame_out.length_frames
        between = states[end : frame_out.watch_end_frame]
        assert "out" not in between
        expected = end + between.index("in") if "in" in between else None
        assert frame_out.back_frame == expected
