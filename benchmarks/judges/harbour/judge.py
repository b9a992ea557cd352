"""The judge of the suite ``harbour``: intruders found, false alarms, places and sizes."""

from __future__ import annotations

import zlib
from collections.abc import Iterator, Sequence
from functools import cached_property

import numpy as np

from benchmarks.contract.judging import Ending, Score, truth_as
from benchmarks.judges.harbour.alarms import PAUSE_S, Clutter, alarm_scores, froc_alarms
from benchmarks.judges.harbour.answers import Objects, answers_of, objects_of
from benchmarks.judges.harbour.found import box_scores, chance_levels, froc_scores, visit_scores
from benchmarks.judges.harbour.identity_scores import identity_scores
from benchmarks.judges.harbour.matching import Answered, Matcher, confident, history_of
from benchmarks.judges.harbour.sizes import measured_scores, overlapping_regions, region_scores
from benchmarks.judges.harbour.visits import Visit, find_visits
from scenarios.harbour.truth import HarbourTruth
from scenarios.scenario import Episode, Frame, Scenario
from sim.rng import generator
from trackers.types import CameraCommand, Track


class HarbourJudge:
    """See ``benchmarks.contract.judging.Judge``. Targets are all intruders whose centre is in the watched volume.

    Attributes:
        clutter: what alarms may be caused by. interval_s: time between frames.
        objects: on each frame so far. agc_step: whether the AGC stepped on it.
    """

    def __init__(self, episode: Episode, scenario: Scenario) -> None:
        self.clutter = Clutter(episode.map_of().clutter)
        self.interval_s = 1.0 / episode.rate_hz
        self.objects: list[Objects] = []
        self.agc_step: list[bool] = []

    def see(self, frame: Frame, command: CameraCommand | None) -> None:
        """See ``Judge``."""
        truth = truth_as(frame.truth, HarbourTruth)
        self.objects.append(objects_of(truth))
        self.agc_step.append(truth.agc_step)
        self._names, self._kinds = truth.names, truth.kinds

    def sheet(self) -> HarbourSheet:
        """See ``Judge``."""
        return HarbourSheet(self)

    @cached_property
    def everywhere(self) -> Objects:
        """The objects on all frames, (T, N)."""
        return Objects._make(map(np.array, zip(*self.objects, strict=True)))

    @cached_property
    def visits(self) -> list[Visit]:
        """The visits of all intruders."""
        return find_visits(self._names, self._kinds, self.everywhere.judged, self.everywhere.contrast_to_noise)


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
        """Yield the scores of all that the tracker answers, and of what it decides for: tracks with a confidence of at
        least ``ending.decides_at``.
        """
        judge, least = self._judge, ending.decides_at
        visits, objects = judge.visits, judge.everywhere
        frames = self._frames if least <= 0 else confident(judge.objects, self._frames, least)
        shown, decided = history_of(self._frames), history_of(frames)
        # The same generator for all trackers of an episode; its intruders' sizes stand for its seed.
        rng = generator(zlib.crc32(objects.size_m[0].tobytes()), "chance")
        chance = chance_levels(shown, objects, rng)
        regions = overlapping_regions(decided)
        yield from visit_scores(visits, decided, regions[1], (chance >= least).mean(axis=0), judge.interval_s)
        yield from froc_scores(visits, shown, chance)
        yield from alarm_scores(decided, np.array(judge.agc_step), judge.interval_s)
        yield from froc_alarms(*shown.false_tracks(), PAUSE_S / judge.interval_s)
        yield from region_scores(visits, decided, objects, regions)
        yield from measured_scores(visits, decided, objects)
        yield from box_scores(judge.objects, [each.answers for each in self._frames])
        yield from identity_scores(judge.objects, frames)
