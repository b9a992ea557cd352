"""The judge of the suite ``stereo``: answers on the ground against the people's places, scored at the end."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from benchmarks.contract.judging import Ending, Score, truth_as
from benchmarks.judges import recovery
from benchmarks.judges.stereo.disparity import DisparityMeasurement
from benchmarks.judges.stereo.metrics import people
from benchmarks.judges.stereo.metrics.people import PeopleSeries
from benchmarks.judges.stereo.metrics.people_events import OCCLUSION, PeopleEvent, find_events
from scenarios.scenario import Episode, Frame, Scenario
from scenarios.stereo_follow.truth import StereoTruth
from scenarios.truth import without_pixels
from trackers.types import CameraCommand, Estimate

OCCLUSION_WINDOW_FRAMES = 10
"""A tracker has recovered if it is on the target when half of it is seen again, or within so many frames after."""


class StereoJudge:
    """See ``benchmarks.contract.judging.Judge``."""

    def __init__(self, episode: Episode, scenario: Scenario) -> None:
        self._rate_hz, self._closed_loop = episode.rate_hz, episode.closed_loop
        self._target = scenario.target
        self._truths: list[StereoTruth] = []
        self._disparity = DisparityMeasurement(scenario.target)

    def see(self, frame: Frame, command: CameraCommand | None) -> None:
        """See ``Judge``."""
        self._disparity.see(frame)
        self._truths.append(without_pixels(truth_as(frame.truth, StereoTruth)))

    def sheet(self) -> StereoSheet:
        """See ``Judge``."""
        return StereoSheet(self)

    @cached_property
    def truth(self) -> PeopleSeries:
        """Truth of the whole episode."""
        return people.people_series(self._truths, self._truths[0].index_of(self._target), self._rate_hz)

    @cached_property
    def events(self) -> list[PeopleEvent]:
        """Events of the whole episode."""
        return find_events(self.truth)

    def scores(self, given: NDArray[np.bool_], place_m: NDArray[np.float64]) -> Iterator[Score]:
        """Yield the scores of one tracker, see ``people.outcomes``, and those of the episode itself."""
        yield from score_episode(self.truth, self.events, given, place_m, closed_loop=self._closed_loop)
        yield from self._disparity.scores()


class StereoSheet:
    """See ``ScoreSheet``. Answers are projected to the ground at once, while the true depth is at hand."""

    def __init__(self, judge: StereoJudge) -> None:
        self._judge = judge
        self._given: list[bool] = []
        self._place_m: list[NDArray[np.float64]] = []
        self._silent_frames = 0

    def keep(self, frame: Frame, estimate: Estimate) -> None:
        """See ``ScoreSheet``."""
        self._given.append(people.answers(estimate))
        self._place_m.append(people.answered_place_m(estimate, truth_as(frame.truth, StereoTruth), frame.camera))
        self._silent_frames += bool(np.isnan(estimate.position_px).any())

    def scores(self, ending: Ending) -> Iterator[Score]:
        """See ``ScoreSheet``. After a failure there are no answers: a miss where the target is seen."""
        yield from self._judge.scores(np.array(self._given), np.array(self._place_m))
        yield Score("silent_frames", float(self._silent_frames))


def score_episode(
    truth: PeopleSeries,
    events: Sequence[PeopleEvent],
    given: NDArray[np.bool_],
    place_m: NDArray[np.float64],
    *,
    closed_loop: bool,
) -> Iterator[Score]:
    """Yield all scores of one tracker in one episode.

    Args:
        given: (F,) there is an answer. place_m: (F, 2) its place on the ground, NaN without one.
    """
    outcome = people.outcomes(truth, given, place_m)
    other = people.on_other(truth, np.where(given[:, None], place_m, np.nan))
    for event in events:
        if event.kind == OCCLUSION:
            yield from _occlusion_scores(event, outcome, other, closed_loop)
        else:
            yield from _count_scores(outcome[event.first_frame : event.end_frame], event)
    yield from _count_scores(outcome[1:])
    error_m = people.position_error_m(truth, given, place_m)
    found = outcome == people.Outcome.RIGHT
    for metric, among in (("position_error_m", truth.seen), ("position_error_found_m", found)):
        yield Score(metric, float(error_m[among].mean()) if among.any() else None, float(among.sum()))
    yield Score("outcome_by_frame", outcome.astype(float).tolist())
    yield Score("visible_fraction_by_frame", truth.visible_fraction.tolist())
    yield Score("rate_hz", truth.rate_hz)


def _count_scores(outcome: NDArray[np.int64], event: PeopleEvent | None = None) -> Iterator[Score]:
    """Yield the counts and the share of frames on a wrong person, of the episode or an event."""
    about = "" if event is None else "event_"
    for name, count in zip(("right", "wrong", "missed"), people.counts(outcome), strict=True):
        yield Score(f"{about}{name}_frames", float(count), event=event)
    share = float(people.on_wrong_person(outcome).mean()) if len(outcome) else None
    yield Score(f"{about}wrong_person_rate", share, float(len(outcome)), event)


def _occlusion_scores(
    occlusion: PeopleEvent,
    outcome: NDArray[np.int64],
    on_other: NDArray[np.int64],
    closed_loop: bool,
) -> Iterator[Score]:
    """Yield the outcome of an occlusion, if it can be judged, and the time to recover."""
    found = outcome == people.Outcome.RIGHT
    judged = recovery.judge_recovery(
        occlusion, found, on_other, window_frames=OCCLUSION_WINDOW_FRAMES, closed_loop=closed_loop
    )
    if judged is not None:
        yield Score("recovered", float(judged.recovered), event=occlusion)
        yield Score("locked_on_wrong_person", float(judged.locked_on_other), event=occlusion)
    yield from recovery.time_scores(occlusion, found, closed_loop=closed_loop)
