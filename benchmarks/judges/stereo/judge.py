"""The judge of the suite ``stereo``: answers on the ground against the people's places, scored at the end.

The column ``event`` holds the attributes of an event, a stretch of frames::

    {"index": 2, "kind": "occlusion" | "lamp on" | "lamp off" | "back light" | "doorway"
     | "shade" | "near person" | "nobody near", "first_frame": 57, "length_frames": 8,
     "back_frame": 66 or null, "place": "hall", "light": true of a change of light}

``back_frame`` is the first frame after an occlusion on which half of the target is seen;
null if it was hidden again, or the episode ended, before that, and of other events. A
change of light is the two seconds from its beginning on.

Rows about events, see ``metrics.people`` for the classes of frames:

=================================  =====================================================================
``recovered``                      occlusions with at least 10 frames of the episode after ``back_frame``: 1 if
                                   right within 10 frames after it, else 0
``recovery_frames``                frames from ``back_frame`` to the first right one; null = never
``watched_frames``                 frames from ``back_frame`` to the next occlusion or the episode's end
``locked_on_wrong_person``         1 if on one other person in most of the frames
                                   ``back_frame`` … ``back_frame + 10``, of the same occlusions
``event_right_frames``, ``event_wrong_frames``, ``event_missed_frames``, ``event_wrong_person_rate``
                                   other events: the same as of the whole episode, of their frames alone
=================================  =====================================================================

Rows about the whole episode but its first frame: ``right_frames``, ``wrong_frames``,
``missed_frames`` (A, B and C, of which precision, recall, F and F1 are made), ``wrong_person_rate`` (share of all
frames), ``position_error_m`` (frames on which at least a tenth of the target is seen), ``position_error_found_m``
(frames with a right answer), ``outcome_by_frame`` (*series* of ``metrics.people.Outcome``, frame 0 included),
``visible_fraction_by_frame`` (*series*), ``rate_hz``, ``silent_frames``, the times,
``failed_at_frame``, ``frames``. ``stereo.disparity``, the same for all trackers of the same pictures, on every tenth
pair whose right picture is not lost, over pixels that both cameras see:
``disparity_error_px_GROUP`` (median absolute error, at full size), ``disparity_bad_1_GROUP``, ``disparity_bad_3_GROUP``
(shares of the known disparities with a larger error) and ``disparity_density_GROUP`` (share of pixels that have one).
GROUP is ``all``, ``target`` (the target's pixels) or a place (all pixels while the target is there).
"""

from __future__ import annotations

from collections.abc import Iterator
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from benchmarks.contract.judging import Ending, Score, truth_as
from benchmarks.judges import recovery
from benchmarks.judges.masks import MaskScores
from benchmarks.judges.stereo.disparity import DisparityMeasurement
from benchmarks.judges.stereo.metrics import people
from benchmarks.judges.stereo.metrics.people import PeopleSeries
from benchmarks.judges.stereo.metrics.people_events import OCCLUSION, PeopleEvent, find_events
from scenarios.scenario import Episode, Frame, Scenario
from scenarios.stereo_follow.truth import PeopleTruth, StereoTruth
from scenarios.truth import without_pixels
from trackers.types import CameraCommand, Estimate

OCCLUSION_WINDOW_FRAMES = 10
"""A tracker has recovered if it is on the target when half of it is seen again, or within so many frames after."""


class StereoJudge:
    """See ``benchmarks.contract.judging.Judge``."""

    def __init__(self, episode: Episode, scenario: Scenario) -> None:
        self.closed_loop, self.disparity = episode.closed_loop, DisparityMeasurement(scenario.target)
        self._rate_hz, self.target = episode.rate_hz, scenario.target
        self._truths: list[StereoTruth] = []

    def see(self, frame: Frame, command: CameraCommand | None) -> None:
        """See ``Judge``."""
        self.disparity.see(frame)
        self._truths.append(without_pixels(truth_as(frame.truth, StereoTruth)))

    def sheet(self) -> StereoSheet:
        """See ``Judge``."""
        return StereoSheet(self)

    @cached_property
    def truth(self) -> PeopleSeries:
        """Truth of the whole episode; the number of people is constant."""
        truths, target = self._truths, self._truths[0].index_of(self.target)
        return people.PeopleSeries(
            rate_hz=self._rate_hz,
            target=target,
            ground_m=np.array([truth.T_world_object[:, :2, 3] for truth in truths]),
            visible_fraction=np.array([truth.visible_fraction[target] for truth in truths]),
            out=np.array([truth.state[target] == "out" for truth in truths]),
            place=np.array([truth.place for truth in truths]),
            light_event=np.array([truth.light_event or "" for truth in truths]),
            near_person=np.array([isinstance(truth, PeopleTruth) and truth.near_person for truth in truths]),
        )


class StereoSheet:
    """See ``ScoreSheet``. Answers are projected to the ground at once, while the true depth is at hand."""

    def __init__(self, judge: StereoJudge) -> None:
        self._judge = judge
        self._given: list[bool] = []
        self._place_m: list[NDArray[np.float64]] = []
        self._silent_frames = 0
        self._masks = MaskScores()

    def keep(self, frame: Frame, estimate: Estimate) -> None:
        """See ``ScoreSheet``."""
        self._given.append(people.answers(estimate))
        self._place_m.append(people.answered_place_m(estimate, truth_as(frame.truth, StereoTruth), frame.camera))
        self._silent_frames += bool(np.isnan(estimate.position_px).any())
        self._masks.keep(frame.truth, frame.truth.index_of(self._judge.target), estimate)

    def scores(self, ending: Ending) -> Iterator[Score]:
        """See ``ScoreSheet``. After a failure there are no answers: a miss where the target is seen."""
        given, place_m, judge = np.array(self._given), np.array(self._place_m), self._judge
        yield from score_episode(judge.truth, given, place_m, closed_loop=judge.closed_loop)
        yield from judge.disparity.scores()
        yield Score("silent_frames", float(self._silent_frames))
        yield from self._masks.scores()


def score_episode(
    truth: PeopleSeries, given: NDArray[np.bool_], place_m: NDArray[np.float64], *, closed_loop: bool
) -> Iterator[Score]:
    """Yield all scores of one tracker in one episode.

    Args:
        given: (F,) there is an answer. place_m: (F, 2) its place on the ground, NaN without one.
    """
    outcome = people.outcomes(truth, given, place_m)
    found = outcome == people.Outcome.RIGHT
    other = people.on_other(truth, np.where(given[:, None], place_m, np.nan))
    for event in find_events(truth):
        if event.kind == OCCLUSION:
            judged = recovery.judge_recovery(
                event, found, other, window_frames=OCCLUSION_WINDOW_FRAMES, closed_loop=closed_loop
            )
            if judged is not None:
                yield Score("recovered", float(judged.recovered), event=event)
                yield Score("locked_on_wrong_person", float(judged.locked_on_other), event=event)
            yield from recovery.time_scores(event, found, closed_loop=closed_loop)
        else:
            yield from _count_scores(outcome[event.first_frame : event.end_frame], event)
    yield from _count_scores(outcome[1:])
    error_m = people.position_error_m(truth, given, place_m)
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
