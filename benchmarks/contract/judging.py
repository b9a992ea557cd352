"""Judging of an episode: protocols for keeping truth and answers, and for the scores at the end."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Protocol, TypeVar

from scenarios.scenario import Episode, Frame
from scenarios.truth import Truth
from sim.checks import check
from trackers.gaps import GapMethod
from trackers.types import CameraCommand, Track

_T = TypeVar("_T", bound=Truth)


class UnreadableSequence(ValueError):
    """A picture of a real sequence is missing, broken or of another size: no tracker can be judged on the sequence."""


class Event(Protocol):
    """A part of an episode that may have scores of its own."""

    def attributes(self) -> dict[str, Any]:
        """Return its attributes in rows: ``index``, ``kind``, ``length_frames`` and others of the suite."""
        ...


@dataclass(frozen=True, slots=True)
class TimeBlock:
    """A block of time of a recording, which has rows of its own: its number, and the number of its frames."""

    index: int
    frame_count: int


@dataclass(frozen=True, slots=True)
class Score:
    """One value of one metric, see ``benchmarks.contract.rows``; ``event`` None is about the whole episode.

    ``block``: of a recording; None of episodes.
    """

    metric: str
    value: float | list[float] | None
    weight: float = 1.0
    event: Event | None = None
    block: TimeBlock | None = None


@dataclass(frozen=True, slots=True)
class Ending:
    """What is known of a tracker after the last frame.

    Attributes:
        failed_at_frame: from this frame on it gave no answers; None without a failure. The number of frames if it
            failed only afterwards.
        revised: its answers on all frames as decided with hindsight; None if it does not revise them.
        new_gap_method: makes a copy of its method to bridge gaps in tracks, as it was before the first picture. After
            a failure it predicts NaN. None if it has no method.
        decides_at: confidence from which on its tracks are its decision; others show what it would answer with a lower
            threshold.
    """

    failed_at_frame: int | None = None
    revised: Sequence[Sequence[Track]] | None = None
    new_gap_method: Callable[[], GapMethod] | None = None
    decides_at: float = 0.0


class ScoreSheet(Protocol):
    """The answers of one tracker in one episode, and their scores."""

    def keep(self, frame: Frame, answer: Any) -> None:
        """Take one frame's answer, from frame 0 on: an ``Estimate``, or the tracks of many targets.

        ``frame`` is what the tracker saw: over a link with late pictures an earlier one than the judge sees.
        The answer of a failed or silent tracker is NaN, or no track.
        """
        ...

    def scores(self, ending: Ending) -> Iterable[Score]:
        """Return all scores, after every frame was kept."""
        ...


class Judge(Protocol):
    """Judges all trackers of one episode by the same truth; decides which objects are targets.

    Made from the ``Episode``, before its first frame, and its ``Scenario``.
    """

    def see(self, frame: Frame, command: CameraCommand | None) -> None:
        """Take one frame's truth, before any estimate of it, and the command obeyed since the frame before.

        The command is None for frame 0 and on a set path.
        """
        ...

    def sheet(self) -> ScoreSheet:
        """Return a fresh sheet for one tracker."""
        ...


USUAL_RATE_HZ = 30.0
"""Frames a second where files give none. UAV123 and UAVDT were recorded at this rate (their papers)."""


def check_no_layout(layout: str, target: int | str | None, rate_hz: float | None) -> None:
    """Raise ValueError for arguments of folders of pictures where there are none."""
    options = {"layout": (layout, ""), "target": (target, None), "rate_hz": (rate_hz, None)}
    for name, (given, default) in options.items():
        check(name, given == default, "none but with --real and a suite that judges pictures", repr(str(given)))


@dataclass(frozen=True, slots=True)
class OnSequences:
    """How a suite judges trackers on real sequences of pictures with boxes of one target.

    Attributes:
        judge: makes the judge of a sequence.
        headline: metrics of the leaderboard; the first one ranks. Ranks in simulated episodes are compared in them.
        compared: metrics of comparisons.
        silence: score of a frame without an answer, in words.
        conditions: name of a quantity of its rows → which frames, events or sequences count, see ``Quantity``; those of
            a sequence are others than those of a simulated episode. A quantity that is not named is as there.
    """

    judge: Callable[[Episode], Judge]
    headline: tuple[str, ...]
    compared: tuple[str, ...]
    silence: str
    conditions: Mapping[str, str] = field(default_factory=dict)


class Recording(Judge, Protocol):
    """Real tracks without pictures, judged by what was measured: a judge that sees no frame.

    Its sheets take the method to bridge gaps alone; their scores have a ``block``.

    Attributes:
        name: of the recording.
    """

    name: str

    @property
    def fingerprint(self) -> str:
        """Hash of the tracks and their rate: rows of others are outdated."""
        ...


def truth_as(truth: Truth, kind: type[_T]) -> _T:
    """Return a truth as the kind that a suite needs.

    Raises:
        TypeError: if the scenario has another kind of truth.
    """
    if not isinstance(truth, kind):
        raise TypeError(f"truth: expected {kind.__name__}, which the suite is about, got {type(truth).__name__}")
    return truth
