"""Events while a person is followed: begin, length and return of each."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from benchmarks.judges.runs import runs
from benchmarks.judges.stereo.metrics.people_events import NEAR, NOBODY_NEAR, OCCLUSION, PeopleEvent, find_events
from tests.benchmarks.judges.stereo.hand_made_people import people_of


def of_kind(events: list[PeopleEvent], *kinds: str) -> list[tuple[str, int, int]]:
    return [(each.kind, each.first_frame, each.length_frames) for each in events if each.kind in kinds]


def test_an_occlusion_is_a_run_of_at_least_two_hidden_frames() -> None:
    #          0    1     2     3    4     5    6    7    8
    visible = [1.0, 0.09, 0.05, 0.1, 0.09, 0.1, 0.0, 0.0, 0.0]
    events = find_events(people_of(visible))
    assert of_kind(events, OCCLUSION) == [(OCCLUSION, 1, 2), (OCCLUSION, 6, 3)]


def test_the_first_frame_is_given_and_in_no_occlusion() -> None:
    assert of_kind(find_events(people_of([0.0, 0.0, 0.0, 1.0])), OCCLUSION) == [(OCCLUSION, 1, 2)]
    assert of_kind(find_events(people_of([0.0, 0.0, 1.0])), OCCLUSION) == []


def test_who_is_outside_the_picture_is_not_hidden() -> None:
    visible = [1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0]
    assert of_kind(find_events(people_of(visible, out=range(1, 6))), OCCLUSION) == []
    # Hidden, then out while hidden: what is left is one frame too short.
    assert of_kind(find_events(people_of(visible, out=[2, 3, 4])), OCCLUSION) == []
    assert of_kind(find_events(people_of(visible, out=[3, 4, 5])), OCCLUSION) == [(OCCLUSION, 1, 2)]


def test_he_is_back_when_half_of_him_is_seen_before_he_is_hidden_again() -> None:
    visible = [1.0, 0.0, 0.0, 0.3, 0.5, 0.0, 0.0, 0.49, 0.0, 0.0, 1.0]
    occlusions = [each for each in find_events(people_of(visible)) if each.kind == OCCLUSION]
    assert [each.back_frame for each in occlusions] == [4, None, 10]
    assert [each.watch_end_frame for each in occlusions] == [5, 8, 11]


def test_light_changes_where_an_event_begins_or_becomes_another() -> None:
    lights = {0: "shade", 1: "shade", 4: "lamp on", 5: "lamp on", 6: "lamp off", 9: "lamp off"}
    events = find_events(people_of([1.0] * 16, lights=lights, rate_hz=3.0))
    assert of_kind(events, "lamp on", "lamp off", "shade") == [
        ("lamp on", 4, 6),
        ("lamp off", 6, 6),
        ("lamp off", 9, 6),
    ]


def test_two_seconds_after_a_change_end_with_the_episode() -> None:
    events = find_events(people_of([1.0] * 10, lights={7: "doorway"}, rate_hz=5.0))
    assert of_kind(events, "doorway") == [("doorway", 7, 3)]
    assert next(each for each in events if each.kind == "doorway").attributes() == {
        "index": 0,
        "kind": "doorway",
        "first_frame": 7,
        "length_frames": 3,
        "back_frame": None,
        "place": "hall",
        "light": True,
    }


@given(st.lists(st.booleans(), min_size=1, max_size=30))
def test_every_frame_but_the_first_is_with_or_without_somebody_near(near: list[bool]) -> None:
    events = find_events(people_of([1.0] * len(near), near=np.flatnonzero(near).tolist()))
    told: dict[int, str] = {}
    for each in events:
        for frame in range(each.first_frame, each.end_frame):
            assert frame not in told
            told[frame] = each.kind
    assert told == {k: NEAR if flag else NOBODY_NEAR for k, flag in enumerate(near) if k > 0}
    assert [each.index for each in events] == list(range(len(events)))


@pytest.mark.parametrize(
    ("flags", "expected"),
    [("", []), ("0", []), ("1", [(0, 1)]), ("0110", [(1, 3)]), ("1101", [(0, 2), (3, 4)]), ("011", [(1, 3)])],
)
def test_runs(flags: str, expected: list[tuple[int, int]]) -> None:
    assert runs(np.array([flag == "1" for flag in flags], dtype=bool)) == expected
