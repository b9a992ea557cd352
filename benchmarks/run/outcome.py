"""What a run leaves beside its rows: what failed, what gave no answer, whose answers are odd.

Answers of another unit or layout pass every check, e.g. boxes of left, top, width and height, and score nothing: a line
for each oddity follows a run."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from benchmarks.contract.text import counted
from benchmarks.run.failures import Failure
from scenarios.scenario import Frame
from trackers.types import Answer, Estimate, Track

_BOXES = "boxes are x_min, y_min, x_max, y_max in pixels of the picture"
_SHOWN_FROM: Mapping[str, tuple[float, str]] = {
    "no depth": (0.0, "{n} of {m} tracks have no depth_m, which this suite needs; CONTRIBUTING.md says what else"),
    "new identities": (
        0.9,
        "in {n} of {m} pictures all identities are new; a target keeps its own from picture to picture",
    ),
    "fractions": (0.5, f"in {{n}} of {{m}} pictures the estimate lies in its first pixel, from 0 to 1; {_BOXES}"),
    "apart": (0.5, f"in {{n}} of {{m}} pictures the position lies outside its box; {_BOXES}"),
    "outside": (0.99, f"in {{n}} of {{m}} pictures the estimate lies outside the picture; {_BOXES}"),
}
"""Oddity -> share of pictures, or tracks, beyond which it is told, and the words. A picture counts where all of its
tracks are odd."""
_FEWEST = 5
"""Pictures, or tracks, that say something."""


@dataclass
class Oddities:
    """Numbers of odd answers.

    Attributes:
        odd: (tracker, oddity) -> number of pictures or tracks. of: the same -> of how many.
        told: (tracker, what else it did or lacks) -> number of episodes.
    """

    odd: Counter[tuple[str, str]] = field(default_factory=Counter)
    of: Counter[tuple[str, str]] = field(default_factory=Counter)
    told: Counter[tuple[str, str]] = field(default_factory=Counter)

    def __add__(self, other: Oddities) -> Oddities:
        return Oddities(self.odd + other.odd, self.of + other.of, self.told + other.told)

    def add(self, name: str, watch: AnswerWatch, told: Sequence[str]) -> None:
        """Add what one episode has shown of a tracker; ``told``: what else, in words, e.g. what it left running."""
        self.odd.update({(name, oddity): number for oddity, number in watch.odd.items()})
        self.of.update({(name, oddity): number for oddity, number in watch.of.items()})
        self.told.update((name, what) for what in told)

    def in_words(self) -> Iterator[str]:
        """Yield a line for each tracker and oddity."""
        for (name, oddity), m in self.of.items():
            share, words = _SHOWN_FROM[oddity]
            n = self.odd[name, oddity]
            if m >= _FEWEST and n > share * m:
                yield f"{name}: {words.format(n=f'{n:,}', m=f'{m:,}')}"
        for (name, what), n in self.told.items():
            yield f"{name} {what}, in {counted(n, 'episode')}"


class AnswerWatch:
    """Counts the odd answers of one tracker.

    Attributes:
        odd, of: oddity -> number, see ``Oddities``.
    """

    def __init__(self, needs_depth: bool = False) -> None:
        """``needs_depth``: whether tracks without a depth score nothing."""
        self.odd: Counter[str] = Counter()
        self.of: Counter[str] = Counter()
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
        if answered:
            size_px = np.array([frame.observation.camera.width_px, frame.observation.camera.height_px])
            self._see_places(answered, size_px)

    def _see_tracks(self, tracks: Sequence[Track]) -> None:
        identities = frozenset(track.identity for track in tracks)
        if self._before and identities:
            self._count("new identities", identities.isdisjoint(self._before))
        self._before = identities
        if self._needs_depth:
            self.of["no depth"] += len(tracks)
            self.odd["no depth"] += sum(track.estimate.depth_m is None for track in tracks)

    def _see_places(self, answered: Sequence[Estimate], size_px: NDArray[np.int64]) -> None:
        places = np.array([each.position_px for each in answered])
        boxed = [each for each in answered if each.box_xyxy is not None]
        self._count("outside", bool(((places < 0) | (places > size_px)).any(axis=1).all()))
        self._count("fractions", bool(((places >= 0) & (places <= 1)).all()))
        if boxed:
            boxes = np.array([each.box_xyxy for each in boxed])
            middles = np.array([each.position_px for each in boxed])
            self._count("apart", bool(((middles < boxes[:, :2]) | (middles > boxes[:, 2:])).any(axis=1).all()))

    def _count(self, oddity: str, is_odd: bool) -> None:
        self.of[oddity] += 1
        self.odd[oddity] += is_odd


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
        oddities: of the answers in these episodes, which may be why a tracker does not score.
        episodes: number of (tracker, episode) pairs that were run; ``resumed``: those that existed already.
        moved: messages about rows that were moved to another file.
        unusable: messages about real recordings that could not be used and have no rows.
    """

    summary: list[dict[str, Any]] = field(default_factory=list, repr=False)
    failures: list[Failure] = field(default_factory=list)
    silent: Counter[str] = field(default_factory=Counter)
    oddities: Oddities = field(default_factory=Oddities)
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
        failures, moved = [*self.failures, *later.failures], [*self.moved, *later.moved]
        episodes, resumed = self.episodes + later.episodes, self.resumed + later.resumed
        silent, oddities = self.silent + later.silent, self.oddities + later.oddities
        unusable = [*self.unusable, *later.unusable]
        return Outcome(later.summary, failures, silent, oddities, episodes, resumed, moved, unusable)

    def problems_in_words(self, silence: str) -> Iterator[str]:
        """Yield a line for moved rows and, once for each tracker, for failures and what is odd about answers."""
        yield from (f"note: {moved} ({WHY_MOVED})" for moved in self.moved)
        yield from (f"error: {unusable}" for unusable in self.unusable)
        yield from (f"error: {failed}" for failed in self.failures_in_words())
        yield from (f"note: {told}" for told in self.oddities_in_words(silence))

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
            if frames:
                yield f"{name} gave no answer (NaN) on {frames} frames; each counts as {silence}"
        yield from self.oddities.in_words()
