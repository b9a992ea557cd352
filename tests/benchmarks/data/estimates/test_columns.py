"""Answers come back as they were given: every field, shape and type of number."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from benchmarks.data.codec import mask_of
from benchmarks.data.estimates.block_file import (
    SCHEMA,
    answer_of,
    command_of,
    row_of_command,
    rows_of_answer,
    table_of,
    values_of,
)
from tests.benchmarks.data.same import assert_same
from trackers.types import Answer, CameraCommand, Estimate, Track

FULL = Estimate(
    position_px=np.array([1.5, np.nan]),
    box_xyxy=np.array([1, 2, 3, 4]),
    heading_rad=np.float32(0.1),
    in_view_probability=1,
    particles_px=np.arange(8, dtype=np.float32).reshape(4, 2) / 3,
    weights=np.array([0.1, 0.2, 0.3, 0.4]),
    covariance_px=np.array([[2.0, 0.5], [0.5, 1 / 3]]),
    depth_m=0.1,
    centre_line_px=np.array([[0.0, np.inf], [1.0, 2.0], [3.0, 4.0]]),
    mask=np.random.default_rng(0).random((7, 9)) > 0.6,
)
BARE = Estimate(np.full(2, np.nan))
TRACKS = (
    Track(3, BARE, kind="person", size_m=np.ones(3, np.float16), confidence=0.25),
    Track(0, FULL),
)


def passed_through(answers: list[Answer]) -> list[Answer]:
    rows = [{"frame": k, **row} for k, answer in enumerate(answers) for row in rows_of_answer(answer)]
    table, types = table_of(rows, {"tracker": "one"})
    assert set(table["tracker"].to_pylist()) == {"one"}
    back = values_of(table, types)
    many = not isinstance(answers[0], Estimate)
    return [answer_of([row for row in back if row["frame"] == k], many) for k in range(len(answers))]


def test_estimates_of_one_target_come_back() -> None:
    mixed = [BARE, FULL, dataclasses.replace(FULL, position_px=np.zeros(2, np.float32), heading_rad=0.1), FULL]
    assert_same(tuple(passed_through([*mixed])), tuple(mixed), "estimates")


def test_tracks_and_a_frame_without_any_come_back() -> None:
    frames = (TRACKS, (), TRACKS[:1])
    assert_same(tuple(passed_through([*frames])), frames, "tracks")


def test_what_is_kept_is_a_copy() -> None:
    place, mask = np.zeros(2), np.eye(3, dtype=bool)
    (row,) = rows_of_answer(Estimate(place, mask=mask))
    place[:], mask[:] = 9.0, False
    assert row["position_px"].tolist() == [0.0, 0.0]
    np.testing.assert_array_equal(mask_of(row["mask"]), np.eye(3))  # type: ignore[arg-type]


def test_ten_thousand_masks_take_a_few_megabytes() -> None:
    rows, columns = np.indices((480, 640))
    mask = np.hypot(rows - 240, 2 * columns - 600) < 100
    (row,) = rows_of_answer(Estimate(np.zeros(2), mask=mask))
    assert 10_000 * len(row["mask"]["counts"]) < 4e6


@pytest.mark.parametrize("command", [None, CameraCommand(), CameraCommand(*(k / 7 for k in range(7)))])
def test_commands_come_back(command: CameraCommand | None) -> None:
    table, types = table_of([row_of_command(command)], {})
    assert command_of(values_of(table, types)[0]) == command


def test_every_column_says_its_unit() -> None:
    assert all(field.metadata[b"unit"] for field in SCHEMA)
    assert SCHEMA.field("covariance_px").metadata[b"unit"] == b"px^2"
    assert SCHEMA.field("obeyed_yaw_rate_rad_s").metadata[b"unit"] == b"rad/s"
