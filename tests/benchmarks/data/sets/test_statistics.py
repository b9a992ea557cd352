"""Counts and distributions from the tables: equal to those of the frames, without reading a pixel."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from benchmarks.data.sets.card import write_card
from benchmarks.data.sets.data_set import REQUEST, DataSet
from benchmarks.data.sets.request import Request
from benchmarks.data.sets.statistics import OTHERS, STANDING, TARGET, statistics
from tests.benchmarks.data.exports.painted_scene import IDS, KINDS, painted_data_set, truths
from tests.benchmarks.data.sets.hand_made import OBJECT_SIZE, write_set


def test_frame_outs_are_runs_that_begin_in_the_picture_and_end_with_the_episode(hand_made: DataSet) -> None:
    # The other car is first absent, then out: it has not left the picture until frame 20.
    outs = statistics(hand_made).frame_outs
    found = sorted(map(tuple, outs.astype(object).to_numpy()))
    assert found == [(OTHERS, 10, True)] * 2 + [(TARGET, 5, False)] * 2


def test_states_are_counted_by_group(hand_made: DataSet) -> None:
    states = statistics(hand_made).states
    assert states.index.tolist() == [TARGET, OTHERS]
    np.testing.assert_allclose(60 * states.to_numpy(), [[50, 0, 0, 10, 0], [20, 0, 0, 30, 10]])


def test_sizes_and_visible_fractions_are_of_what_is_in_the_picture(hand_made: DataSet) -> None:
    sizes = statistics(hand_made).sizes
    sides = sizes.groupby("group", observed=True)["side_px"]
    assert sides.count().to_dict() == {TARGET: 50, OTHERS: 20}
    np.testing.assert_allclose(sizes["side_px"].dropna(), np.sqrt(OBJECT_SIZE[0] * OBJECT_SIZE[1]), rtol=1e-6)
    assert sizes[sizes["group"] == TARGET]["visible_fraction"].dropna().tolist() == [1.0] * 50


def test_no_pixel_is_read(tmp_path: Path) -> None:
    data = write_set(tmp_path, frames=4)
    for shard in tmp_path.glob("episodes/*/pixels-*.tar"):
        shard.unlink()
    assert len(statistics(data).sizes) == 16
    with pytest.raises(FileNotFoundError):
        data[0]


def test_what_is_seen_is_counted_by_kind_and_group(tmp_path: Path) -> None:
    data = painted_data_set(tmp_path / "set", "parked", without="flow_px")
    seen = {
        name: 2 * sum(bool((truth.instance_map == number).any()) for truth in truths("parked"))
        for name, number in zip(KINDS, IDS, strict=True)
    }
    found = statistics(data).seen
    assert {kind: row[row > 0].to_dict() for kind, row in found.iterrows()} == {
        "bus": {OTHERS: seen["bus"]},
        "car": {TARGET: seen["car"]},
        "kite": {OTHERS: seen["kite"]},
        "van": {STANDING: len(data)},
    }
    write_card(data)
    card = (tmp_path / "set" / "README.md").read_text()
    assert f"| van | 0 | 0 | {len(data)} |" in card
    assert f"| car | {seen['car']} | 0 | 0 |" in card
    assert "| `standing_box_xyxy` | standing | px |" in card


def test_a_set_without_episodes_is_refused(tmp_path: Path) -> None:
    (tmp_path / REQUEST).write_text(Request("road-town-v2", "quick", (0, 3), ()).as_json())
    with pytest.raises(ValueError, match=r"expected a data set with at least one whole episode, got none"):
        statistics(DataSet(str(tmp_path)))
