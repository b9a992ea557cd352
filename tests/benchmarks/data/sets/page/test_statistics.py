"""The statistics of a data set, as a data card tells them."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from benchmarks.data.sets.data_set import REQUEST, DataSet
from benchmarks.data.sets.page.statistics import statistics
from benchmarks.data.sets.request import Request


def test_counts_shares_and_medians(hand_made: DataSet) -> None:
    told = statistics(hand_made)
    assert (told["episodes"], told["missing_seeds"], told["frames"], told["objects"]) == (2, [2], 60, 120)
    assert told["seconds"] == pytest.approx(4.0)
    assert told["states"]["target"]["out"] == pytest.approx(1 / 6)
    # Each object is in view in half of the frames or more; nothing is parked here.
    assert set(told["seen"]) == {"sedan"}
    assert set(told["seen"]["sedan"]) == {"target", "other objects"}
    assert told["states"]["other objects"]["absent"] == pytest.approx(1 / 6)
    outs = told["frame_outs"]["other objects"]
    assert (outs["count"], outs["unfinished"], outs["median"], outs["most"]) == (2, 2, 10.0, 10.0)
    assert told["quantities"]["exposure_s"]["unit"] == "s"
    assert told["quantities"]["exposure_s"]["levels"][""]["median"] == pytest.approx(0.0155)
    assert told["quantities"]["on_road"]["shares"] == {"": 0.5}
    assert told["box_side_px"]["target"]["median"] == pytest.approx(240**0.5)


def test_they_are_json(hand_made: DataSet) -> None:
    told = statistics(hand_made)
    assert json.loads(json.dumps(told, allow_nan=False)) == told


def test_a_set_without_episodes_is_refused(tmp_path: Path) -> None:
    (tmp_path / REQUEST).write_text(Request("road-town-v2", "quick", (0, 3), ()).as_json())
    with pytest.raises(ValueError, match=r"expected a data set with at least one whole episode, got none"):
        statistics(DataSet(str(tmp_path)))
