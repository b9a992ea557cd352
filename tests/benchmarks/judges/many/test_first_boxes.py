"""``first_boxes``, the row of the suite ``many`` that sees no picture: right on the first frame, then worth little."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from benchmarks import bench
from benchmarks.judges.many.first_boxes import FirstBoxes
from benchmarks.judges.many.judge import objects_of
from scenarios.fish_tank.scenario import FISH_TANK
from scenarios.loop import Loop


def test_it_answers_with_the_true_boxes_of_the_first_picture_on_every_one() -> None:
    loop = Loop(FISH_TANK.episode("quick", 0), [FirstBoxes()])
    first = loop.step().truth
    index, box_xyxy, is_target, _ = objects_of(first)
    for _ in range(3):
        (tracks,) = loop.answers
        assert [each.identity for each in tracks] == index[is_target].tolist()
        np.testing.assert_array_equal([each.estimate.box_xyxy for each in tracks], box_xyxy[is_target])
        later = loop.step().truth
    assert not np.allclose(later.box_xyxy, first.box_xyxy)


@pytest.mark.heavy
def test_it_follows_fish_far_worse_than_who_sees_them(tmp_path: Path) -> None:
    results = bench("many", scenario="fish-tank", preset="quick", seeds=range(2), out=tmp_path, workers=0)
    values = results.rows().query("metric == 'hota'").groupby("tracker")["value"].mean()
    assert 0.0 < values.pop("first_boxes") < 0.1 * values.min()
