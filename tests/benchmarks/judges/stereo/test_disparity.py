"""Rows and table of the disparity matched from the pair: what is measured, how often, and each episode once."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray

from benchmarks.contract.rows import Row
from benchmarks.judges.stereo.disparity import EVERY_FRAMES, DisparityMeasurement
from benchmarks.show.suites.stereo import MATCHES
from benchmarks.show.tables import facts_table
from scenarios.scenario import Frame
from tests.benchmarks.judges.follow.fake_follow import CAMERA, POSE, FakeFollow, FakeFollowEpisode

DISPARITY_PX = 6
T_BESIDE = np.array([[1, 0, 0, 0.12], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1.0]])
TARGET_COLUMNS = slice(60, 90)


def pair_before_a_wall() -> tuple[NDArray[np.uint8], NDArray[np.uint8]]:
    """Return pictures of a speckled wall whose every point is 6 pixels further left in the right one."""
    rng = np.random.default_rng(0)
    speckled = cv2.GaussianBlur(rng.uniform(0, 255, (CAMERA.height_px, CAMERA.width_px + DISPARITY_PX)), (0, 0), 1.0)
    levels = cv2.normalize(speckled, None, 0, 255, cv2.NORM_MINMAX).astype(np.uint8)
    left, right = levels[:, :-DISPARITY_PX], levels[:, DISPARITY_PX:]
    return np.repeat(left[..., None], 3, axis=2), np.repeat(right[..., None], 3, axis=2)


def frames(count: int, wrong_by_px: float = 0.0) -> list[Frame]:
    """Return frames of the speckled wall, which truth has where disparities are less by ``wrong_by_px``."""
    left, right = pair_before_a_wall()
    depth_m = np.full(left.shape[:2], CAMERA.focal_px * 0.12 / (DISPARITY_PX - wrong_by_px), np.float32)
    instances = np.full(left.shape[:2], 99, np.int32)
    instances[:, TARGET_COLUMNS] = 0
    episode = FakeFollowEpisode(FakeFollow("a fixed camera"), closed_loop=False)
    made = []
    for _ in range(count):
        frame = episode.step()
        truth = replace(
            frame.truth, depth_m=depth_m, right_depth_m=depth_m, instance_map=instances, T_world_right=POSE @ T_BESIDE
        )
        made.append(Frame(replace(frame.observation, image_rgb=left, right_rgb=right), truth))
    return made


def rows_of(shown: list[Frame]) -> dict[str, tuple[Any, float]]:
    measurement = DisparityMeasurement("target")
    for frame in shown:
        measurement.see(frame)
    return {score.metric: (score.value, score.weight) for score in measurement.scores()}


def test_the_matcher_finds_what_is_so() -> None:
    rows = rows_of(frames(1))
    for pixels in ("all", "target", "hall"):
        assert rows[f"disparity_error_px_{pixels}"][0] == pytest.approx(0.0, abs=0.1)
        assert rows[f"disparity_bad_1_{pixels}"][0] < 0.03
        assert rows[f"disparity_density_{pixels}"][0] > 0.95
    # The right camera does not see the first columns of the left picture.
    assert rows["disparity_density_all"][1] == (CAMERA.width_px - DISPARITY_PX) * CAMERA.height_px
    assert rows["disparity_density_target"][1] == 30 * CAMERA.height_px
    assert not any("yard" in name for name in rows)


def test_what_is_off_by_two_pixels_is_bad_1_and_not_bad_3() -> None:
    rows = rows_of(frames(1, wrong_by_px=2.0))
    assert rows["disparity_error_px_all"][0] == pytest.approx(2.0, abs=0.1)
    assert rows["disparity_bad_1_all"][0] > 0.95
    assert rows["disparity_bad_3_all"][0] < 0.03


def test_every_tenth_pair_is_measured_and_lost_ones_are_not() -> None:
    shown = frames(51)
    once = rows_of(shown[:1])["disparity_density_all"][1]
    assert rows_of(shown)["disparity_density_all"][1] == 6 * once
    # The target is in the hall until frame 40.
    assert rows_of(shown)["disparity_density_corridor"][1] == 2 * once
    lost = [replace(f, observation=replace(f.observation, right_rgb=None)) for f in shown[:: 2 * EVERY_FRAMES]]
    assert rows_of([*lost, *shown[EVERY_FRAMES :: 2 * EVERY_FRAMES]])["disparity_density_all"][1] == 3 * once
    assert rows_of(lost) == {}


def row(tracker: str, seed: int, value: float, controller: str | None = None, **other: Any) -> Row:
    return {
        "metric": "disparity_bad_3_all",
        "tracker": tracker,
        "seed": seed,
        "value": value,
        "weight": 1.0,
        "controller": controller,
        "event": None,
        **other,
    }


def test_an_episode_counts_once_however_many_watch_it() -> None:
    trackers = {
        "one": [row("one", 0, 0.1), row("one", 1, 0.4)],
        "other": [row("other", 0, 0.1), row("other", 0, 0.1, repeat=1)],
    }
    table = facts_table(MATCHES, trackers)
    (line,) = table.lines
    assert line.names == ("all pixels",)
    assert [cell.text for cell in line.cells] == ["–", "–", "25.0", "–"]
    assert line.cells[2].interval == "10.0 … 40.0"
    assert [(column.title, column.unit, column.goal) for column in table.columns] == [
        ("error", "px", "↓"),
        ("bad 1", "%", "↓"),
        ("bad 3", "%", "↓"),
        ("density", "%", "↑"),
    ]


def test_a_tracker_that_steers_sees_pictures_of_its_own() -> None:
    trackers = {name: [row(name, 0, value, "centre")] for name, value in (("one", 0.1), ("other", 0.3))}
    (line,) = facts_table(MATCHES, trackers).lines
    assert line.cells[2].text == "20.0"
