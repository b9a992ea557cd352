"""The judge of the suite ``harbour``: intruders found, false alarms, places and sizes."""

from __future__ import annotations

import zlib
from collections.abc import Iterator, Sequence
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from benchmarks.contract.judging import Ending, Score, truth_as
from benchmarks.judges.harbour.alarms import PAUSE_S, Clutter, alarm_scores, causes_of_alarms, froc_alarms, raised
from benchmarks.judges.harbour.answers import Objects, answers_of, objects_of
from benchmarks.judges.harbour.boxes import box_scores
from benchmarks.judges.harbour.chance import chance_levels
from benchmarks.judges.harbour.found import froc_scores, visit_scores
from benchmarks.judges.harbour.history import Answered, History, Met, confident, rows_of
from benchmarks.judges.harbour.identity_scores import identity_scores
from benchmarks.judges.harbour.matching import Matcher
from benchmarks.judges.harbour.sizes import measured_scores, region_scores
from benchmarks.judges.harbour.streaks import highest, streaks
from benchmarks.judges.harbour.visits import Visit, find_visits
from scenarios.harbour.truth import HarbourTruth
from scenarios.scenario import Episode, Frame, Scenario
from sim.rng import generator
from trackers.types import CameraCommand, Track

_HOUR_S = 3600.0


class HarbourJudge:
    """See ``benchmarks.contract.judging.Judge``. Targets are all intruders whose centre is in the watched volume.

    Attributes:
        clutter: what alarms may be caused by. objects: on each frame so far.
    """

    def __init__(self, episode: Episode, scenario: Scenario) -> None:
        self.clutter = Clutter(episode.map_of().clutter)
        self.objects: list[Objects] = []
        self._interval_s = 1.0 / episode.rate_hz
        self._agc_step: list[bool] = []

    def see(self, frame: Frame, command: CameraCommand | None) -> None:
        """See ``Judge``."""
        truth = truth_as(frame.truth, HarbourTruth)
        self.objects.append(objects_of(truth))
        self._agc_step.append(truth.agc_step)
        self._names, self._kinds = truth.names, truth.kinds

    def sheet(self) -> HarbourSheet:
        """See ``Judge``."""
        return HarbourSheet(self)

    def scores(self, shown: History, decided: History, decides_at: float) -> Iterator[Score]:
        """Yield the scores of all answers but for those of whole tracks.

        ``shown``: all that the tracker answers. ``decided``: those with a confidence of at least ``decides_at``.
        """
        visits = self._visits
        chance = chance_levels(shown, self._judged, *self._places, self._own_generator())
        found, begins = self._reached(decided)
        met = decided.met
        pair = met.target * decided.names + met.identity
        regions = streaks(met.frame, pair, met.confidence)
        by_region = np.isin(np.arange(self._count), regions.key // decided.names)
        counted = np.isin(pair, regions.key)
        by_chance = (chance >= decides_at).mean(axis=0)
        yield from visit_scores(visits, np.isfinite(found), begins, by_region, by_chance, self._interval_s)
        yield from froc_scores(visits, self._reached(shown)[0], chance)
        yield from self._alarms(shown, decided)
        yield from region_scores(visits, Met._make(each[counted] for each in met))
        distance_m = np.array([each.distance_m for each in self.objects])
        yield from measured_scores(visits, decided, self.objects[0].size_m, distance_m)

    def _reached(self, history: History) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Return for each intruder (N,) the highest threshold at which it is found, and the first frame on which it
        begins to be; -inf and inf where it is not.
        """
        on = history.target >= 0
        key = history.target[on] * history.names + history.identity[on]
        own = streaks(history.frame[on], key, history.confidence[on])
        target = own.key // history.names
        return highest(target, own.level, self._count), -highest(target, -own.begins.astype(float), self._count)

    def _alarms(self, shown: History, decided: History) -> Iterator[Score]:
        pause_frames = PAUSE_S / self._interval_s
        frame, identity, confidence = decided.false_tracks()
        number = raised(frame, identity, pause_frames)
        alarms = streaks(frame, number, confidence)
        causes = causes_of_alarms(alarms, frame, number, decided.cause, np.array(self._agc_step))
        frames = len(self.objects)
        yield from alarm_scores(causes, len(frame), frames, frames * self._interval_s / _HOUR_S)
        yield from froc_alarms(*shown.false_tracks(), pause_frames)

    def _own_generator(self) -> np.random.Generator:
        """Return the same generator for all trackers of an episode; its intruders' sizes stand for its seed."""
        return generator(zlib.crc32(self.objects[0].size_m.tobytes()), "chance")

    @property
    def _count(self) -> int:
        return len(self._names)

    @cached_property
    def _judged(self) -> NDArray[np.bool_]:
        """(T, N)."""
        return np.array([each.judged for each in self.objects])

    @cached_property
    def _places(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Centres over the ground (T, N, 2) and boxes (T, N, 4)."""
        return np.array([each.place_m[:, :2] for each in self.objects]), np.array(
            [each.box_xyxy for each in self.objects]
        )

    @cached_property
    def _visits(self) -> list[Visit]:
        contrast = np.array([each.contrast_to_noise for each in self.objects])
        return find_visits(self._names, self._kinds, self._judged, contrast)


class HarbourSheet:
    """See ``benchmarks.contract.judging.ScoreSheet``."""

    def __init__(self, judge: HarbourJudge) -> None:
        self._judge = judge
        self._matcher = Matcher()
        self._frames: list[Answered] = []

    def keep(self, frame: Frame, tracks: Sequence[Track]) -> None:
        """See ``ScoreSheet``."""
        answers = answers_of(tracks, frame.camera, frame.truth.T_world_camera)
        matches = self._matcher.match(self._judge.objects[-1], answers)
        causes = self._judge.clutter.causes(frame.truth.instance_map, answers.box_xyxy[matches.false])
        self._frames.append(Answered(answers, matches, causes))

    def scores(self, ending: Ending) -> Iterator[Score]:
        """Yield the scores of all answers."""
        objects, decides_at = self._judge.objects, ending.decides_at
        decided = self._frames if decides_at <= 0 else confident(objects, self._frames, decides_at)
        history = rows_of(objects, decided)
        shown = history if decides_at <= 0 else rows_of(objects, self._frames)
        yield from self._judge.scores(shown, history, decides_at)
        yield from box_scores(objects, [each.answers for each in self._frames])
        yield from identity_scores(objects, decided)
