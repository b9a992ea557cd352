"""What is stored of real fish has the rows that episodes have, and is made by the module's command."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from benchmarks.judges.fish.motion import motion_scores
from benchmarks.show.suites.fish import SWIMS
from benchmarks.show.tables import facts_table
from tools.learn.zebrafish import PIECE_FRAMES, measured_rows

RNG = np.random.default_rng(0)
PLACES_PX = 200.0 + np.cumsum(RNG.normal(0, 2, (400, 2, 2)), axis=0)


def idtracker_file(folder: Path, name: str, places_px: NDArray[np.float64]) -> Path:
    """Write places (T, 2, 2) as idTracker does."""
    cells = np.concatenate([places_px, np.ones((len(places_px), 2, 1))], axis=2).reshape(-1, 6)
    text = "X1\tY1\tProbId1\tX2\tY2\tProbId2\n" + "\n".join("\t".join(map(repr, map(float, x))) for x in cells)
    path = folder / f"{name}.txt"
    path.write_text(text + "\n")
    return path


def test_the_stored_rows_are_those_of_an_episode() -> None:
    assert SWIMS.beside["real zebrafish"].keys() == {score.metric for score in motion_scores(PLACES_PX, 35.0)}


def test_a_file_is_scaled_to_the_tank(tmp_path: Path) -> None:
    """So a camera twice as near changes nothing."""
    places_px = np.cumsum(RNG.normal(0, 2, (PIECE_FRAMES, 2, 2)), axis=0)
    rows = [measured_rows(idtracker_file(tmp_path, f"{zoom:g}", zoom * places_px)) for zoom in (1.0, 2.0)]
    assert rows[0] == pytest.approx(rows[1], rel=1e-3)
    width_px = np.ptp(places_px[..., 0])
    steps_px = np.linalg.norm(np.diff(places_px, axis=0), axis=2) * 600.0 / width_px
    assert rows[0]["motion_step_p50_any"] == pytest.approx(np.median(steps_px), rel=1e-3)


def test_statistics_are_means_over_pieces_as_long_as_an_episode(tmp_path: Path) -> None:
    """The second piece is the first one in another corner; the distance to the wall is that of each, not of both."""
    piece = np.cumsum(RNG.normal(0, 2, (PIECE_FRAMES, 2, 2)), axis=0)
    both = np.concatenate([piece, piece + 3000.0, np.zeros((PIECE_FRAMES - 1, 2, 2))])
    rows = measured_rows(idtracker_file(tmp_path, "both", both))
    scale = 600.0 / np.ptp(both[..., 0])
    alone = {score.metric: score.value for score in motion_scores(piece * scale, 35.0)}
    assert rows == pytest.approx(alone, rel=1e-3)
    with pytest.raises(ValueError, match=f"short: expected at least {PIECE_FRAMES} frames, got {PIECE_FRAMES - 1}"):
        measured_rows(idtracker_file(tmp_path, "short", piece[1:]))


def test_real_fish_stand_beside_each_line_of_an_episode() -> None:
    rows = [
        {"metric": s.metric, "value": s.value, "weight": s.weight, "seed": 0, "controller": None, "event": None}
        for s in motion_scores(PLACES_PX, 35.0)
    ]
    table = facts_table(SWIMS, {"hold": rows})
    names = [line.names[0] for line in table.lines]
    assert names[:2] == ["over 5 frames", "over 5 frames, real zebrafish"]
    assert len(names) == 2 * len(SWIMS.lines)
    assert table.lines[1].cells[0].text == f"{SWIMS.beside['real zebrafish']['motion_turn_5']:.1f}"
    assert {column.goal for column in table.columns} == {""}, "nothing of it is better or worse"
