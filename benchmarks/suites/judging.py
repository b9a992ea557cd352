"""How an episode is judged: what a suite keeps of truth and estimates, and the scores it gives at the end."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any, Protocol, TypeVar

from scenarios.scenario import Frame
from scenarios.truth import Truth
from trackers.types import CameraCommand

_T = TypeVar("_T", bound=Truth)


class Event(Protocol):
    """A part of an episode that scores may be about."""

    def attributes(self) -> dict[str, Any]:
        """Return what rows say of it: ``index``, ``kind``, ``length_frames`` and what else the suite tells of it."""
        ...


@dataclass(frozen=True, slots=True)
class Score:
    """One value of one metric, see ``benchmarks.run.records``; ``event`` None is about the whole episode."""

    metric: str
    value: float | list[float] | None
    weight: float = 1.0
    event: Event | None = None


class ScoreSheet(Protocol):
    """What one contestant says in one episode, and what it is worth."""

    def keep(self, frame: Frame, answer: Any) -> None:
        """Take one frame's answer, from frame 0 on: an ``Estimate``, or the tracks of many targets.

        One that failed or is silent answers NaN, or no track.
        """
        ...

    def scores(self, failed_at_frame: int | None) -> Iterable[Score]:
        """Return all scores, when every frame was kept; from ``failed_at_frame`` on it has said nothing."""
        ...


class Judge(Protocol):
    """Judges all contestants of one episode by the same truth. Made from the ``Episode``, before its first frame, and
    its ``Scenario``. Which objects are targets, it decides.
    """

    def see(self, frame: Frame, command: CameraCommand | None) -> None:
        """Take one frame's truth, before anyone's estimate of it, and the command that was obeyed on the way to it:
        None for frame 0 and on a set path.
        """
        ...

    def sheet(self) -> ScoreSheet:
        """Return a fresh sheet for one contestant."""
        ...


def told_by(truth: Truth, kind: type[_T]) -> _T:
    """Return a truth that knows what a suite asks of it.

    Raises:
        TypeError: where the scenario tells another kind of truth.
    """
    if not isinstance(truth, kind):
        raise TypeError(f"truth: expected {kind.__name__}, which the suite is about, got {type(truth).__name__}")
    return truth
