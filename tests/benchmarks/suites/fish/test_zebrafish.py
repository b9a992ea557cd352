"""What is stored of real fish has the rows that episodes have, and is made by the module's command."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from benchmarks.report.facts import facts_table
from benchmarks.suites.fish.motion import motion_scores
from benchmarks.suites.fish.suite import FISH
from benchmarks.suites.fish.zebrafish import measured_rows, zebrafish_rows

RNG = np.random.default_rng(0)
PLACES_PX = 200.0 + np.cumsum(RNG.normal(0, 2, (400, 2, 2)), axis=0)


def test_the_stored_rows_are_those_of_an_episode() -> None:
    assert zebrafish_rows().keys() == {score.metric for score in motion_scores(PLACES_PX, 35.0)}


def test_a_file_is_scaled_to_the_tank(tmp_path: Path) -> None:
    """So a camera twice as near changes nothing."""
    rows = []
    for zoom in (1.0, 2.0):
        cells = [[*(zoom * place), 1.0] for fish in PLACES_PX.transpose(1, 0, 2) for place in fish]
        lines = np.array(cells).reshape(2, 400, 3).transpose(1, 0, 2).reshape(400, 6)
        text = "X1\tY1\tProbId1\tX2\tY2\tProbId2\n" + "\n".join("\t".join(map(repr, map(float, x))) for x in lines)
        path = tmp_path / f"{zoom:g}.txt"
        path.write_text(text + "\n")
        rows.append(measured_rows(path))
    assert rows[0] == pytest.approx(rows[1], rel=1e-3)
    width_px = np.ptp(PLACES_PX[..., 0])
    steps_px = np.linalg.norm(np.diff(PLACES_PX, axis=0), axis=2) * 600.0 / width_px
    assert rows[0]["motion_step_p50_any"] == pytest.approx(np.median(steps_px), rel=1e-3)


def test_real_fish_stand_beside_each_line_of_an_episode() -> None:
    assert FISH.facts is not None
    rows = [
        {"metric": s.metric, "value": s.value, "weight": s.weight, "seed": 0, "controller": None, "event": None}
        for s in motion_scores(PLACES_PX, 35.0)
    ]
    table = facts_table(FISH.facts, {"hold": rows})
    names = [line.names[0] for line in table.lines]
    assert names[:2] == ["over 5 frames", "over 5 frames, real zebrafish"]
    assert len(names) == 2 * len(FISH.facts.lines)
    assert table.lines[1].cells[0].text == "12.9"
