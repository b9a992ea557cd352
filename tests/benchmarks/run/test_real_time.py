"""Pictures that come while a tracker works are lost to it, and its latest finished answer stands."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from benchmarks.cli.main import main
from benchmarks.contract.rows import read_rows
from benchmarks.judges.tracker_speed import FRAMES_SEEN, TIMES
from benchmarks.run.guards import GuardedTracker
from benchmarks.run.jobs import opened
from benchmarks.run.real_time import GRACE, RealTimeTracker
from benchmarks.run.selection import job_on
from benchmarks.run.time_limit import Stopwatch, Taken
from benchmarks.show.provenance import provenance
from scenarios.loop import FromPictures
from tests.benchmarks.fake_episode import FakeEpisode
from tests.benchmarks.named import NamedExperiment, run_named
from tests.fakes_scenario import FAKE_TOWN
from trackers.types import Estimate, Observation

few = settings(max_examples=25)
RATE_HZ = 20.0
PERIODS = st.lists(st.sampled_from([0.0, 0.5, 1.0, 1.25, 2.0, 3.5, 7.0]), min_size=60, max_size=60)


@dataclass
class Clocked:
    """Takes the given times, in periods, for start and updates; answers with the number of the picture that it got."""

    periods: Sequence[float]
    fails_at: int = -1
    got: list[int] = field(default_factory=list)

    def initialise(self, observation: Observation, box_xyxy: Any) -> None:
        """Start."""
        self._get(observation)

    def update(self, observation: Observation) -> Estimate:
        """Answer."""
        return Estimate(np.array([self._get(observation), 0.0]))

    def _get(self, observation: Observation) -> float:
        self.got.append(round(observation.time_s * FakeEpisode.rate_hz))
        if self.got[-1] == self.fails_at:
            raise RuntimeError("no")
        return float(self.got[-1])


def run(tracker: Clocked, kind: Any = RealTimeTracker, **how: Any) -> tuple[list[float], Any]:
    """Return the number of the picture whose answer stands on each picture, NaN for silence; and the guard.

    Stopwatches tell what the tracker takes for its latest call.
    """
    with pytest.MonkeyPatch.context() as patched:
        taken = property(lambda watch: Taken(0.0, tracker.periods[len(tracker.got) - 1] / RATE_HZ))
        patched.setattr(Stopwatch, "taken", taken)
        rate = {"rate_hz": RATE_HZ} if kind is RealTimeTracker else {}
        guard = kind(lambda: FromPictures(tracker), 60.0, **rate | how)
        episode = FakeEpisode()
        answers = [guard.initialise(episode.step(), episode.start)]
        given_box = answers[0]
        answers += [guard.update(episode.step()) for _ in range(episode.frame_count - 1)]
    return [0.0 if each is given_box else float(each.position_px[0]) for each in answers], guard


def by_hand(periods: Sequence[float], count: int) -> tuple[list[int], list[float]]:
    """Return the pictures that are got, and the one whose answer stands on each: every instant is looked at."""
    left, work = GRACE, list(periods)
    got, ready = [], []
    for picture in range(count):
        if ready and ready[-1] > picture:
            continue
        length = work.pop(0)
        if length > 1 and left:
            left, length = left - 1, 1.0
        got.append(picture)
        ready.append(picture + length)
    stands = []
    for picture in range(count):
        done = [which for which, when in zip(got, ready, strict=True) if which <= picture and when <= picture + 1]
        stands.append(float(done[-1]) if done else 0.0)
    return got, stands


def share_seen(guard: Any) -> float:
    (value,) = (score.value for score in guard.scores() if score.metric == "frames_seen")
    return float(value)


def same(one: list[float], other: list[float]) -> bool:
    """Return whether lists are equal, silence included."""
    return bool(np.array_equal(one, other, equal_nan=True))


@few
@given(periods=PERIODS)
def test_who_gets_which_picture_and_what_stands_is_as_by_hand(periods: list[float]) -> None:
    tracker = Clocked(periods)
    stands, guard = run(tracker)
    got, wanted = by_hand(periods, 30)
    assert (tracker.got, stands) == (got, wanted)
    assert share_seen(guard) == len(got) / 30
    assert list(guard.taken) == got[1:]


@few
@given(periods=PERIODS, factors=st.lists(st.sampled_from([1.0, 1.1, 3.0]), min_size=60, max_size=60))
def test_one_that_needs_longer_for_each_answer_sees_no_more(periods: list[float], factors: list[float]) -> None:
    faster, slower = (run(Clocked(each))[1] for each in (periods, list(np.multiply(periods, factors))))
    assert share_seen(slower) <= share_seen(faster)


@few
@given(periods=st.lists(st.floats(0.0, 1.0), min_size=60, max_size=60))
def test_one_that_is_always_in_time_answers_as_without_a_clock(periods: list[float]) -> None:
    tracker, free = Clocked(periods), Clocked(periods)
    stands, guard = run(tracker)
    assert stands == run(free, GuardedTracker)[0]
    assert (tracker.got, share_seen(guard)) == (free.got, 1.0)


@pytest.mark.parametrize("fails_at", [0, 1, 12, 29])
def test_a_failure_is_not_held_and_is_on_a_picture_that_it_got(fails_at: int) -> None:
    stands, guard = run(Clocked([0.5] * 60, fails_at=fails_at))
    free, other = run(Clocked([0.5] * 60, fails_at=fails_at), GuardedTracker)
    assert same(stands, free)
    assert np.isnan(stands[max(fails_at, 1) :]).all()
    assert (guard.failed_at_frame, guard.silent_frames) == (fails_at, other.silent_frames)
    assert share_seen(guard) == 1.0


def test_a_process_that_ended_on_a_picture_fails_on_the_next_one_that_it_gets() -> None:
    stands, guard = run(Clocked([5.0] * 60), ends_process_at=12)
    later = next(picture for picture in by_hand([5.0] * 60, 30)[0] if picture >= 12)
    assert guard.failed_at_frame == later
    assert list(np.flatnonzero(np.isnan(stands))) == [*range(later, 30)]


def test_silence_that_stands_counts_on_every_picture() -> None:
    class Silent(Clocked):
        def update(self, observation: Observation) -> Estimate:
            self._get(observation)
            return Estimate(np.full(2, np.nan))

    stands, guard = run(Silent([3.0] * 60))
    assert guard.silent_frames == np.isnan(stands).sum() > 20


TINY = NamedExperiment(
    suite="frame-out",
    scenario=FAKE_TOWN.id,
    presets=("tiny",),
    trackers=("fake_still", "fake_knowing"),
    seeds=range(1),
    workers=0,
    modules=("tests.fakes_scenario",),
)


def rows_of(folder: Path) -> list[dict[str, Any]]:
    """Return the rows without what a clock makes."""
    return [row | {"seconds": 0} for row in read_rows(folder) if row["metric"] not in (*TIMES, FRAMES_SEEN)]


def test_pictures_that_come_slowly_give_the_rows_of_a_run_that_waits(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    run_named(TINY, tmp_path / "waits")
    outcome = run_named(replace(TINY, real_time_hz=1e-3), tmp_path / "slow")
    slow = rows_of(tmp_path / "slow")
    assert {row.pop("real_time_hz") for row in slow} == {1e-3}
    assert slow == rows_of(tmp_path / "waits")
    seen = [entry for entry in outcome.summary if entry["metric"] == "frames_seen"]
    assert [(entry["mean"], entry["real_time_hz"]) for entry in seen] == [(1.0, 1e-3)] * 2
    assert "frames_seen" not in {row["metric"] for row in read_rows(tmp_path / "waits")}
    for rate_hz, folder, held in ((None, "slow", "in real time at 0.001 Hz"), (1e-3, "waits", "not in real time")):
        with pytest.raises(ValueError, match=rf"out: expected a folder of rows .*, got .*{folder}', of rows {held}"):
            run_named(replace(TINY, real_time_hz=rate_hz), tmp_path / folder)
    again = run_named(replace(TINY, real_time_hz=1e-3), tmp_path / "slow")
    assert (again.episodes, again.resumed) == (0, 2)
    assert "--real-time 0.001" in provenance(read_rows(tmp_path / "slow"))["command"]
    capsys.readouterr()
    assert main(["compare", *(f"{tmp_path / name}:fake_still" for name in ("slow", "waits"))]) == 0
    told = "".join(capsys.readouterr().out.split())
    assert "slow:fake_still(inrealtimeat0.001Hz)minus" in told
    assert "waits:fake_still,pairedoverepisodes" in told
    assert main(["report", str(tmp_path / "slow"), "--markdown"]) == 0
    assert "in real time at 0.001 Hz: 1 episode" in capsys.readouterr().out
    assert "set path · raster · in real time at 0.001 Hz" in (tmp_path / "slow" / "report.html").read_text()


def test_pictures_that_come_too_fast_are_lost(tmp_path: Path) -> None:
    outcome = run_named(replace(TINY, trackers=("fake_knowing",), real_time_hz=1e6), tmp_path)
    mean = {entry["metric"]: entry["mean"] for entry in outcome.summary}
    assert mean["frames_seen"] < 0.1
    assert mean["offscreen_error_30_m"] > 5.0


@pytest.mark.parametrize("rate_hz", [0, -1.0, float("inf"), float("nan"), "fast"])
def test_a_rate_that_is_none_is_refused(rate_hz: Any) -> None:
    with pytest.raises(ValueError, match="real_time: expected pictures a second, a number > 0, got"):
        replace(TINY, real_time_hz=rate_hz).made()


def test_a_controller_steers_by_the_answer_that_stands() -> None:
    job = job_on("follow", "road-town", "quick", 0, ("colour_pf",), controller="centre", real_time_hz=1e6)
    with opened(job) as live:
        places = [live.loop.estimate.position_px[0] for _ in live.frames(8)]
    assert len(set(places[GRACE - 1 :])) == 1
