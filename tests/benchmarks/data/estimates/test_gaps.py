"""What a method said about gaps is kept and said again, to the judge that asks the same."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow.parquet as pq
import pytest

from benchmarks.contract.judging import Ending, Score
from benchmarks.data.estimates.block_file import read_block
from benchmarks.data.estimates.keeping import KeepingJudge
from benchmarks.data.estimates.rejudging import RecalledGapMethod
from benchmarks.run.guards import GuardedTracker
from scenarios.loop import Loop, ManyFromPictures
from scenarios.scenario import Frame
from tests import fakes_scenario
from tests.benchmarks.data.same import assert_same
from trackers.gaps import Bridge, GapMethod, Piece, Surroundings
from trackers.types import CameraCommand, CameraModel, Observation, Track

PAST, FUTURE = Piece(0, np.zeros((4, 2)), 0.1), Piece(7, np.zeros((4, 2)), 0.1)
HEADING = {
    **{"suite": "fish", "scenario": "fake-town-v1", "preset": "tiny", "tracker": "bridges", "role": "ours"},
    **{"controller": None, "renderer": "raster", "seed": 3},
}


class Bridges:
    """Follows nothing; extrapolates two gaps, fails on the third, and needs no second end."""

    def __init__(self) -> None:
        self.gap_method, self.asked = self, 0

    def start(self, background: Sequence[Observation], camera: CameraModel) -> None:
        """See ``MultiTracker``."""

    def update(self, observation: Observation) -> list[Track]:
        """See ``MultiTracker``."""
        return []

    def learn(self, pieces: Sequence[Piece]) -> None:
        """Learn nothing."""

    def extrapolate(self, past: Piece, count: int, around: Surroundings) -> Bridge | None:
        """See ``GapMethod``."""
        self.asked += 1
        place = np.arange(2.0 * count, dtype=np.float32).reshape(count, 2) / self.asked
        return Bridge(place, None if self.asked == 1 else np.tile(np.eye(2), (count, 1, 1))) if self.asked < 3 else 7  # type: ignore[return-value]

    def interpolate(self, past: Piece, future: Piece, around: Surroundings) -> Bridge | None:
        """See ``GapMethod``."""
        return None


class Asks:
    """A judge, and its sheet, that asks about gaps."""

    def __init__(self) -> None:
        self.bridges: list[Bridge | None] = []

    def see(self, frame: Frame, command: CameraCommand | None) -> None:
        """See ``Judge``."""

    def sheet(self) -> Asks:
        """See ``Judge``."""
        return self

    def keep(self, frame: Frame, answer: Any) -> None:
        """See ``ScoreSheet``."""

    def scores(self, ending: Ending) -> Iterable[Score]:
        """See ``ScoreSheet``."""
        assert ending.new_gap_method is not None
        self.bridges = asked_of(ending.new_gap_method()) + asked_of(ending.new_gap_method())
        return ()


def asked_of(method: GapMethod) -> list[Bridge | None]:
    around = Surroundings()
    return [
        method.extrapolate(PAST, 2, around),
        method.interpolate(PAST, FUTURE, around),
        method.extrapolate(PAST, 3, around),
        method.extrapolate(FUTURE, 1, around),
    ]


@pytest.fixture
def kept(tmp_path: Path) -> tuple[Asks, GuardedTracker, Path]:
    episode = fakes_scenario.FAKE_TOWN.episode("tiny", 3)
    episode.frame_count = 4
    asks, guard = Asks(), GuardedTracker(lambda: ManyFromPictures(Bridges()), 60.0, many=True)
    keeping = KeepingJudge(asks)
    sheet, loop = keeping.sheet(), Loop(episode, [guard])
    for frame in loop.frames():
        keeping.see(frame, None)
        sheet.keep(frame, loop.answers[0])
    list(sheet.scores(guard.ending()))
    block = [HEADING | {"repeat": 0, "metric": "frames", "value": 4.0, "weight": 1.0, "event": None, "editions": {}}]
    keeping.write(tmp_path, [block], [("bridges", guard)])
    return asks, guard, next(tmp_path.iterdir())


def test_bridges_come_back_in_the_order_of_the_questions(kept: tuple[Asks, GuardedTracker, Path]) -> None:
    asks, guard, path = kept
    block = read_block(path)
    (run,), (said,) = block.facts.runs, block.answered
    assert (run.failed_at_frame, run.failed_in_the_end, run.bridges) == (None, 4, True)
    assert guard.failed_at_frame == 4
    gaps = iter(said.gaps)
    again = asked_of(RecalledGapMethod(gaps)) + asked_of(RecalledGapMethod(gaps))
    assert len(again) == len(asks.bridges) == 8
    assert_same(tuple(again), tuple(asks.bridges), "bridges")
    table = pq.read_table(path).to_pandas()
    first = table[table["gap"] == 0]
    assert (first["answer"].tolist(), first["frame"].tolist()) == (["extrapolated"] * 2, [4, 5])
    assert table.loc[table["gap"] == 1, "track"].isna().tolist() == [True]


@pytest.mark.parametrize(
    "asks",
    [
        lambda method: method.extrapolate(PAST, 3, Surroundings()),
        lambda method: method.extrapolate(FUTURE, 2, Surroundings()),
        lambda method: method.interpolate(PAST, FUTURE, Surroundings()),
        lambda method: [*asked_of(method), *asked_of(method), *asked_of(method)],
    ],
)
def test_a_judge_that_asks_in_another_way_gets_no_answer(kept: tuple[Asks, GuardedTracker, Path], asks: Any) -> None:
    (said,) = read_block(kept[2]).answered
    with pytest.raises(ValueError, match=r"estimates: expected an answer to the gap of .* cut other gaps"):
        asks(RecalledGapMethod(iter(said.gaps)))
