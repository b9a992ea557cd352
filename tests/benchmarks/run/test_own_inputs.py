"""Inputs of a tracker are its own: no other one feels what it changes, and it is named."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from benchmarks.contract.rows import Row
from benchmarks.contract.suite import suite
from benchmarks.judges.tracker_speed import TIMES
from benchmarks.run.episodes import simulated
from benchmarks.run.jobs import Job, JobResult, run_job
from benchmarks.run.own_inputs import check_unchanged, own
from benchmarks.run.selection import tracker_named
from tests import fakes_offenders, fakes_scenario
from trackers.types import CameraModel, EgoPose, Observation, SiteSurvey, Start

PICTURE = np.arange(36, dtype=np.uint8).reshape(4, 3, 3)
SEEN = Observation(PICTURE, 0.5, CameraModel(3, 4, 5.0), ego=EgoPose(np.eye(4)))
START = Start(SEEN.camera, np.arange(4.0), (SEEN, SEEN), SiteSurvey((0.0, 1.0), (1.0, 0.0), -2.0, (1.0, 2.0, 3.0), 0.0))
EPISODE = simulated(fakes_scenario.FAKE_TOWN.id, "tiny", 0, changed={"frame_count": 20})


@pytest.mark.parametrize(
    "array",
    [
        PICTURE,
        PICTURE[::-1, ::2, 1],
        np.asfortranarray(np.arange(6.0).reshape(2, 3)),
        np.broadcast_to(PICTURE[..., :1], PICTURE.shape),
        np.array(3.0),
    ],
)
def test_a_copy_of_an_array_has_its_layout_and_is_read_only_down_to_its_memory(array: NDArray[Any]) -> None:
    copied = own(array)
    assert (copied.strides, copied.dtype) == (array.strides, array.dtype)
    np.testing.assert_array_equal(copied, array)
    assert not np.shares_memory(copied, array)
    below = copied
    while isinstance(below, np.ndarray):
        assert not below.flags.writeable
        below = below.base  # type: ignore[assignment]


def test_nothing_in_a_copy_is_that_of_another() -> None:
    mine = own(START)
    check_unchanged(START, mine, "start")
    assert mine.background[1].image_rgb is not START.background[1].image_rgb
    for a, b in ((mine.camera, START.camera), (mine.site, START.site), (mine.background[0], START.background[0])):
        assert a == b if a is not mine.background[0] else True
        assert a is not b


@pytest.mark.parametrize(
    ("path", "change"),
    [
        ("start.box_xyxy", lambda mine: mine.box_xyxy.__setitem__(0, 9.0)),
        ("start.camera.focal_px", lambda mine: object.__setattr__(mine.camera, "focal_px", 0.0)),
        ("start.site.edge_m[1]", lambda mine: object.__setattr__(mine.site, "edge_m", (0.0, 2.0))),
        ("start.background[1].image_rgb", lambda mine: mine.background[1].image_rgb.base.__setitem__(3, 99)),
        ("start.background[0].ego.T_world_camera", lambda mine: object.__setattr__(mine.background[0], "ego", None)),
    ],
)
def test_what_is_changed_is_named(path: str, change: Any) -> None:
    mine = own(START)
    for array in (mine.box_xyxy, mine.background[1].image_rgb):
        below: Any = array
        while isinstance(below, np.ndarray):
            below, one = below.base, below
            one.flags.writeable = one.base is None
        array.flags.writeable = True
    change(mine)
    with pytest.raises(ValueError, match=r"changed; inputs are read-only: .*image_rgb.copy") as told:
        check_unchanged(START, mine, "start")
    assert str(told.value).startswith(f"{path}: expected it as it was given")


def test_unknown_numbers_are_no_change() -> None:
    unknown = replace(SEEN, ego=EgoPose(np.full((4, 4), np.nan)))
    check_unchanged(unknown, own(unknown), "observation")


def job(trackers: tuple[str, ...]) -> Job:
    return Job(suite("frame-out"), EPISODE, {name: tracker_named(name) for name in trackers})


def rows_of(result: JobResult, tracker: str) -> list[Row]:
    rows = [row for block in result.blocks for row in block if row["tracker"] == tracker]
    return [{**row, "seconds": 0} for row in rows if row["metric"] not in TIMES]


def test_no_offender_changes_the_rows_of_another_and_each_is_named() -> None:
    innocent = ("fake_feels", "fake_knowing")
    alone = run_job(job(innocent))
    offenders = (*fakes_offenders.CHANGES, "offends_settings")
    together = run_job(job((*offenders, *innocent)))
    for name in innocent:
        assert rows_of(together, name) == rows_of(alone, name)
    told = {failure.tracker: (failure.frame, failure.reason) for failure in together.failures}
    for name, (changed, _) in fakes_offenders.CHANGES.items():
        frame, reason = told.pop(name)
        assert frame == fakes_offenders.STRIKES_AT
        assert reason.startswith(f"ValueError: {changed}: expected it as it was given, got it changed; inputs are read")
        assert reason.count("read-only") == 1
    assert told == {}
