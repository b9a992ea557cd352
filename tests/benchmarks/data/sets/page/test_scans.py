"""Numbers from the tables: equal to those of the frames, without reading a pixel."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from benchmarks.data.sets.card import write_card
from benchmarks.data.sets.data_set import DataSet
from benchmarks.data.sets.page import scans
from benchmarks.data.sets.page.page import render_page
from benchmarks.data.sets.page.scans import OTHERS, TARGET
from benchmarks.data.sets.page.statistics import statistics
from tests.benchmarks.data.exports.painted_scene import IDS, KINDS, painted_data_set, truths
from tests.benchmarks.data.sets.hand_made import FRAMES, OBJECT_SIZE, write_set


def by_name(data: DataSet) -> dict[str, scans.Quantity]:
    return {each.name: each for each in scans.quantities(data)}


def test_frame_outs_are_runs_that_begin_in_the_picture_and_end_with_the_episode(hand_made: DataSet) -> None:
    # The other car is first absent, then out: it has not left the picture until frame 20.
    outs = scans.frame_outs(hand_made)
    assert outs[TARGET].lengths.tolist() == [5, 5]
    assert outs[TARGET].unfinished == 0
    assert outs[OTHERS].lengths.tolist() == [10, 10]
    assert outs[OTHERS].unfinished == 2


def test_states_are_counted_by_group(hand_made: DataSet) -> None:
    counts = scans.state_counts(hand_made)
    assert counts[TARGET] == {"in": 50, "partial": 0, "occluded": 0, "out": 10, "absent": 0}
    assert counts[OTHERS] == {"in": 20, "partial": 0, "occluded": 0, "out": 30, "absent": 10}


def test_sizes_and_visible_fractions_are_of_what_is_in_the_picture(hand_made: DataSet) -> None:
    sides = scans.box_sides_px(hand_made)
    side = np.sqrt(OBJECT_SIZE[0] * OBJECT_SIZE[1])
    np.testing.assert_allclose(sides[TARGET], np.full(50, side))
    np.testing.assert_allclose(sides[OTHERS], np.full(20, side))
    assert scans.visible_fractions(hand_made)[TARGET].tolist() == [1.0] * 50


def test_quantities_follow_from_the_fields_of_the_truth(hand_made: DataSet) -> None:
    found = by_name(hand_made)
    assert {name: each.kind for name, each in found.items() if each.table == "frames"} == {
        "exposure_s": "number",
        "gain": "number",
        "on_road": "flag",
        "turning": "flag",
        "light.sun_illuminance_lx": "number",
        "light.sky_illuminance_lx": "number",
    }
    assert found["light.sun_illuminance_lx"].unit == "lx"
    exposures = scans.numbers(hand_made, found["exposure_s"])[""]
    np.testing.assert_allclose(exposures, np.tile(0.001 * (1 + np.arange(FRAMES)), 2))
    assert set(scans.numbers(hand_made, found["light.sun_illuminance_lx"])[""]) == {50_000.0}
    assert scans.numbers(hand_made, found["on_road"])[""].mean() == 0.5


def test_numbers_of_objects_leave_out_those_that_are_not_in_the_world(hand_made: DataSet) -> None:
    speeds = scans.numbers(hand_made, by_name(hand_made)["speed_mps"])
    assert set(speeds[TARGET]) == {8.0}
    assert set(speeds[OTHERS]) == {4.0}


def test_no_pixel_is_read(tmp_path: Path) -> None:
    data = write_set(tmp_path, frames=4)
    for shard in tmp_path.glob("episodes/*/pixels-*.tar"):
        shard.unlink()
    assert statistics(data)["frames"] == 8
    with pytest.raises(FileNotFoundError):
        data[0]


def test_what_is_seen_is_counted_by_kind_and_group(tmp_path: Path) -> None:
    data = painted_data_set(tmp_path / "set", "parked", without="flow_px")
    seen = {
        name: 2 * sum(bool((truth.instance_map == number).any()) for truth in truths("parked"))
        for name, number in zip(KINDS, IDS, strict=True)
    }
    assert scans.seen_counts(data) == {
        "bus": {"other objects": seen["bus"]},
        "car": {"target": seen["car"]},
        "kite": {"other objects": seen["kite"]},
        "van": {"standing about": len(data)},
    }
    assert f"van: {len(data)} standing about" in render_page(data)
    write_card(data)
    card = (tmp_path / "set" / "README.md").read_text()
    assert f"| van | 0 | 0 | {len(data)} |" in card
    assert f"| car | {seen['car']} | 0 | 0 |" in card
    assert "| `standing_box_xyxy` | standing | px |" in card
