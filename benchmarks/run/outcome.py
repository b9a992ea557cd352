"""What a run leaves beside its rows: what failed, what gave no answer, whose answers are odd.

Answers of another unit or layout pass every check, e.g. boxes of left, top, width and height, and score nothing: a line
for each oddity follows a run."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, fields
from typing import Any

import numpy as np

from benchmarks.contract.text import counted
from benchmarks.run.failures import Failure
from scenarios.scenario import Frame
from trackers.types import Answer, Estimate, Track

_BOXES = "boxes are x_min, y_min, x_max, y_max in pixels of the picture"
_ODDITIES: Mapping[str, tuple[float, str]] = {
    "no depth": (0.0, "gives tracks without depth_m, which this suite needs; CONTRIBUTING.md says what else"),
    "new identities": (0.9, "gives all targets new identities; a target keeps its own from picture to picture"),
    "fractions": (0.5, f"answers in the picture's first pixel, from 0 to 1; {_BOXES}"),
    "apart": (0.5, f"answers with positions outside their boxes; {_BOXES}"),
    "outside": (0.99, f"answers outside the picture; {_BOXES}"),
}
"""Oddity -> share of pictures beyond which a line says so, and its words. A picture is odd if all of its tracks are;
one without a depth, if any is."""
_FEWEST = 5
"""Pictures that say something."""


class AnswerWatch:
    """Counts the odd answers of one tracker in one episode."""

    def __init__(self, needs_depth: bool = False) -> None:
        """``needs_depth``: whether tracks without a depth score nothing."""
        self._odd, self._of = Counter[str](), Counter[str]()
        self._needs_depth = needs_depth
        self._before: frozenset[int] = frozenset()

    def see(self, frame: Frame, answer: Answer) -> None:
        """Count the next answer, which has been checked."""
        if isinstance(answer, Estimate):
            estimates = [answer]
        else:
            self._see_tracks(answer)
            estimates = [track.estimate for track in answer]
        answered = [each for each in estimates if not np.isnan(each.position_px).any()]
        if not answered:
            return
        places, camera = np.array([each.position_px for each in answered]), frame.observation.camera
        self._count("outside", ((places < 0) | (places > (camera.width_px, camera.height_px))).any(axis=1).all())
        self._count("fractions", ((places >= 0) & (places <= 1)).all())
        boxed = np.array([(*each.position_px, *each.box_xyxy) for each in answered if each.box_xyxy is not None])
        if len(boxed):
            self._count("apart", ((boxed[:, :2] < boxed[:, 2:4]) | (boxed[:, :2] > boxed[:, 4:])).any(axis=1).all())

    def _see_tracks(self, tracks: Sequence[Track]) -> None:
        identities = frozenset(track.identity for track in tracks)
        if self._before and identities:
            self._count("new identities", identities.isdisjoint(self._before))
        self._before = identities
        if self._needs_depth and tracks:
            self._count("no depth", any(track.estimate.depth_m is None for track in tracks))

    def _count(self, oddity: str, is_odd: bool | np.bool_) -> None:
        self._of[oddity] += 1
        self._odd[oddity] += bool(is_odd)

    def in_words(self) -> list[str]:
        """Return what is odd about most answers."""
        known = ((words, self._odd[oddity], share, self._of[oddity]) for oddity, (share, words) in _ODDITIES.items())
        return [words for words, odd, share, of in known if of >= _FEWEST and odd > share * of]


WHY_MOVED = "rows of other editions or of a stopped run, or ones that a second run in the folder has made too"
"""What every message about moved rows leaves open."""


class TrackerWarning(UserWarning):
    """A tracker failed, or gave no answer on some frames; or a real recording could not be used."""


@dataclass
class Outcome:
    """The result of a run.

    Attributes:
        summary: the list of ``summary.json``.
        failures: of trackers and controllers, also in episodes that existed already.
        silent: tracker → number of frames without an answer, in the episodes that were run.
        oddities: (tracker, what is odd about it in these episodes) → number of episodes; it may be why a tracker does
            not score.
        episodes: number of (tracker, episode) pairs that were run; ``resumed``: those that existed already.
        moved: messages about rows that were moved to another file.
        unusable: messages about real recordings that could not be used and have no rows.
    """

    summary: list[dict[str, Any]] = field(default_factory=list, repr=False)
    failures: list[Failure] = field(default_factory=list)
    silent: Counter[str] = field(default_factory=Counter)
    oddities: Counter[tuple[str, str]] = field(default_factory=Counter)
    episodes: int = 0
    resumed: int = 0
    moved: list[str] = field(default_factory=list)
    unusable: list[str] = field(default_factory=list)

    @property
    def failed(self) -> bool:
        """Whether a tracker failed or a recording could not be used."""
        return bool(self.failures or self.unusable)

    def followed_by(self, later: Outcome) -> Outcome:
        """Return this result joined with that of a later run into the same folder."""
        both = {each.name: getattr(self, each.name) + getattr(later, each.name) for each in fields(self)}
        return Outcome(**both | {"summary": later.summary})

    def problems_in_words(self, silence: str) -> Iterator[str]:
        """Yield a line for moved rows and, once for each tracker, for failures and what is odd about answers."""
        yield from (f"note: {moved} ({WHY_MOVED})" for moved in self.moved)
        yield from (f"error: {unusable}" for unusable in self.unusable)
        yield from (f"error: {failed}" for failed in self.failures_in_words())
        yield from (f"note: {odd}" for odd in self.oddities_in_words(silence))

    def failures_in_words(self) -> Iterator[str]:
        """Yield a line for each tracker or controller that failed: its first failure, and how many more there were."""
        first = {failure.tracker: failure for failure in reversed(self.failures)}
        for name, count in Counter(failure.tracker for failure in self.failures).items():
            more = f" (and {counted(count - 1, 'more failure')})" if count > 1 else ""
            yield f"{first[name]}{more}"

    def oddities_in_words(self, silence: str) -> Iterator[str]:
        """Yield a line for each tracker without an answer on some frames, and for what is odd about answers.

        ``silence``: what a frame without an answer counts as.
        """
        for name, frames in self.silent.items():
            yield f"{name} gave no answer (NaN) on {frames} frames; each counts as {silence}"
        for (name, what), count in self.oddities.items():
            yield f"{name} {what}, in {counted(count, 'episode')}"
