"""What a run leaves beside its rows: what failed, what gave no answer, how much there was."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any

from benchmarks.contract.text import counted
from benchmarks.run.failures import Failure
from benchmarks.run.oddities import Oddities

WHY_MOVED = "rows of other editions or of a stopped run, or ones that a second run in the folder has made too"
"""What every message about moved rows leaves open."""


class ContestantWarning(UserWarning):
    """A contestant failed, or gave no answer on some frames; or a real recording could not be used."""


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
        """Whether a contestant failed or a recording could not be used."""
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
