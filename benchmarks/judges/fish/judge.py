"""The judge of the suite ``fish``: gaps bridged, links over gaps, and the whole chain."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from benchmarks.contract.judging import Ending, Score, truth_as
from benchmarks.judges.fish import contact
from benchmarks.judges.fish.gap_protocol import GapTask
from benchmarks.judges.fish.gap_scores import gap_scores
from benchmarks.judges.fish.gaps import FishGap, find_gaps
from benchmarks.judges.fish.links import answered, bearers, identity_series, judge_links, link_events, link_scores
from benchmarks.judges.fish.measured import Measurement, body_length_px
from benchmarks.judges.fish.motion import motion_scores
from benchmarks.judges.identities import Pairing, clear_counts, numbered, pairing, track_scores
from scenarios.fish_tank.truth import FishTruth
from scenarios.scenario import Episode, Frame, Scenario
from trackers.types import CameraCommand, Track

STRIDE_FRAMES = 25
"""Frames from one cut gap of a fish to its next of the same length."""
AT_ONCE = "_at_once"
"""End of the names of scores of the immediate answers; of a tracker that revises nothing they equal the others."""


class Seen(NamedTuple):
    """The N fish on a frame, or on all T frames.

    Attributes:
        position_px: (N, 2) middles; NaN outside the picture. length_px: (N,) of the bodies.
        apart: (N,) see ``contact.stands_apart``. together: (N, N). crosses: (N,) see ``contact.crossing``.
    """

    position_px: NDArray[np.float64]
    length_px: NDArray[np.float64]
    apart: NDArray[np.bool_]
    together: NDArray[np.bool_]
    crosses: NDArray[np.bool_]


class FishJudge:
    """See ``benchmarks.contract.judging.Judge``. Targets are all fish, on every frame on which their middle is seen."""

    def __init__(self, episode: Episode, scenario: Scenario) -> None:
        self._measurement = Measurement(episode.start.background, 1.0 / episode.rate_hz)
        camera = episode.start.camera
        self._size_px = np.array([camera.width_px, camera.height_px], dtype=float)
        self._frames: list[Seen] = []

    def see(self, frame: Frame, command: CameraCommand | None) -> None:
        """See ``Judge``."""
        truth = truth_as(frame.truth, FishTruth)
        together = contact.together(truth)
        apart = contact.stands_apart(truth, together)
        self._measurement.see(frame.observation, truth, apart)
        inside = ((truth.position_px >= 0) & (truth.position_px < self._size_px)).all(axis=1, keepdims=True)
        position_px = np.where(inside, truth.position_px, np.nan)
        crosses = contact.crossing(truth, together)
        self._frames.append(Seen(position_px, body_length_px(truth), apart, together, crosses))

    def sheet(self) -> FishSheet:
        """See ``Judge``."""
        return FishSheet(self)

    @cached_property
    def fish(self) -> Seen:
        """All fish on all frames."""
        return Seen._make(map(np.array, zip(*self._frames, strict=True)))

    @cached_property
    def length_px(self) -> float:
        """Median length of a body in the picture."""
        return float(np.nanmedian(self.fish.length_px))

    @cached_property
    def gaps(self) -> list[FishGap]:
        """Gaps of all fish."""
        return find_gaps(self.fish.apart, self.fish.together, self.fish.crosses)

    @cached_property
    def motion(self) -> list[Score]:
        """How the fish swim, the same for all trackers."""
        return list(motion_scores(self.fish.position_px, self.length_px))

    @cached_property
    def task(self) -> GapTask:
        """Gaps cut out of the measured tracks."""
        cap_px = float(np.hypot(*self._size_px))
        return GapTask(self._measurement.tracks(), STRIDE_FRAMES, cap_px, sees_mates=True)


class FishSheet:
    """See ``benchmarks.contract.judging.ScoreSheet``."""

    def __init__(self, judge: FishJudge) -> None:
        self._judge = judge
        self._answers: list[Sequence[Track]] = []

    def keep(self, frame: Frame, tracks: Sequence[Track]) -> None:
        """See ``ScoreSheet``."""
        self._answers.append(tracks)

    def scores(self, ending: Ending) -> Iterator[Score]:
        """Yield the scores of the answers, revised ones if there are any, and of the method to bridge gaps.

        A method that only bridges gaps and follows no fish has no scores of its answers.
        """
        final = self._answers if ending.revised is None else ending.revised
        follows = any(self._answers) or any(final)
        if follows or ending.failed_at_frame is not None or ending.new_gap_method is None:
            yield from self._of_answers(final)
            yield from self._of_answers(self._answers, AT_ONCE)
        yield from self._judge.motion
        if ending.new_gap_method is not None:
            task = self._judge.task
            yield from gap_scores(task.tracks, task.bridged(ending.new_gap_method))

    def _of_answers(self, answers: Sequence[Sequence[Track]], ending: str = "") -> Iterator[Score]:
        """Yield the scores of answers; events and series of those that count, whose scores have no ``ending``."""
        judge = self._judge
        placed = [answered(tracks) for tracks in answers]
        frames = [
            pairing(places, each.identity, each.position_px, judge.length_px)
            for places, each in zip(judge.fish.position_px, placed, strict=True)
        ]
        borne = bearers(placed, judge.fish.position_px, 0.5 * judge.length_px)
        links = judge_links(judge.gaps, judge.fish.apart, borne)
        yield from chain_scores(numbered(frames), ending)
        yield from link_scores(links, ending)
        if not ending:
            yield from link_events(links)
            yield from identity_series(borne, judge.fish.apart)


def chain_scores(frames: Sequence[Pairing], ending: str = "") -> Iterator[Score]:
    """Yield the scores of whole tracks; ``ending`` is added to their names.

    See ``track_scores``, with a similarity of 0 at the distance of a body's length. ``missed_rate``, ``false_rate``:
    frames of fish without a track, and of tracks on no fish, of all frames of fish.
    """
    clear = clear_counts(frames)
    yield from track_scores(frames, clear, ending)
    there = float(max(clear.found + clear.missed, 1))
    yield Score(f"missed_rate{ending}", clear.missed / there, there)
    yield Score(f"false_rate{ending}", clear.false / there, there)
