"""The judge of the suite ``follow``: where the camera had its target, what it cost, and what the tracker was on."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from benchmarks.scores import in_view
from benchmarks.scores.view_time import find_losses, view_scores
from benchmarks.suites.follow.metrics import following
from benchmarks.suites.judging import Score
from scenarios.in_view import centring, is_in_view
from scenarios.scenario import Episode, Frame, Scenario
from scenarios.truth import Truth
from trackers.belief.command_shares import shares_of
from trackers.belief.kernel import SEEN_PROBABILITY
from trackers.types import CameraCommand, Estimate


@dataclass
class _Seen:
    """What is kept of the frames so far, a list entry a frame; see ``scenarios.truth.Truth``.

    Attributes:
        position_px: of the target. is_in_view, centring: see ``scenarios.in_view``.
        visible: of the target. watched_state, watched_visible: the same of the camera that the tracker watches.
        shares: of the command that led to the frame; none for frame 0.
        distance_m: on the ground, from a camera that looks ahead to the target.
    """

    position_px: list[NDArray[np.float64]] = field(default_factory=list)
    is_in_view: list[bool] = field(default_factory=list)
    centring: list[float] = field(default_factory=list)
    visible: list[float] = field(default_factory=list)
    watched_state: list[str] = field(default_factory=list)
    watched_visible: list[float] = field(default_factory=list)
    shares: list[NDArray[np.float64]] = field(default_factory=list)
    distance_m: list[float] = field(default_factory=list)


class FollowJudge:
    """See ``benchmarks.suites.judging.Judge``. Any scenario will do; people are moreover scored as EVT-Bench does."""

    def __init__(self, episode: Episode, scenario: Scenario) -> None:
        self._rate_hz, self._carrier, self._target = episode.rate_hz, scenario.carrier, scenario.target
        self._size_px = (0, 0)
        self._seen = _Seen()

    def target(self, truth: Truth) -> int:
        """Return the index of the target among the objects."""
        return truth.index_of(self._target)

    def see(self, frame: Frame, command: CameraCommand | None) -> None:
        """See ``Judge``."""
        (truth, camera), seen = frame.judged, self._seen
        target = self.target(truth)
        self._size_px = (camera.width_px, camera.height_px)
        seen.position_px.append(truth.position_px[target])
        seen.is_in_view.append(is_in_view(truth, target, camera))
        seen.centring.append(centring(truth, target, camera))
        seen.visible.append(float(truth.visible_fraction[target]))
        seen.watched_state.append(str(frame.truth.state[target]))
        seen.watched_visible.append(float(frame.truth.visible_fraction[target]))
        if command is not None:
            seen.shares.append(shares_of(self._carrier, command))
        if self._carrier.looks == "ahead":
            offset_m = truth.T_world_object[target, :2, 3] - truth.T_world_camera[:2, 3]
            seen.distance_m.append(float(np.hypot(*offset_m)))

    def sheet(self) -> FollowSheet:
        """See ``Judge``."""
        return FollowSheet(self)

    def scores(self) -> Iterator[Score]:
        """Yield what the camera saw and did, whatever the tracker said."""
        rate_hz, seen = self._rate_hz, np.array(self._seen.is_in_view)
        steps = float(len(seen) - 1)
        for loss in find_losses(seen, rate_hz):
            frames = None if loss.back_frame is None else float(loss.length_frames)
            yield Score("recovery_frames", frames, event=loss)
            yield Score("watched_frames", float(loss.length_frames), event=loss)
        yield Score("rate_hz", rate_hz)
        yield from view_scores(seen, np.array(self._seen.visible), rate_hz)
        position_px = np.array(self._seen.position_px)
        error = following.centring_error(position_px, self._size_px, seen)
        yield Score("centring_error", error, float(seen[1:].sum()))
        shares = np.array(self._seen.shares)
        yield Score("effort", following.effort(shares), steps)
        yield Score("jerkiness_per_s", following.jerkiness_per_s(shares, rate_hz), steps)
        yield from self._rivals_scores(np.array(self._seen.centring), seen, steps)

    def oxuva_scores(
        self, says: NDArray[np.bool_], on_target: NDArray[np.bool_], failed_at_frame: int | None
    ) -> Iterator[Score]:
        """Yield TPR and TNR of what the tracker says (F,) of its target's being in view; wrong from its failure on."""
        failed = np.arange(len(says)) >= (len(says) if failed_at_frame is None else failed_at_frame)
        present, absent = in_view.present_and_absent(
            np.array(self._seen.watched_state), np.array(self._seen.watched_visible)
        )
        tpr = in_view.true_positive_rate(present, says & ~failed, on_target)
        yield Score("in_view_tpr", tpr, float(present.sum()))
        yield Score("in_view_tnr", in_view.true_negative_rate(absent, says | failed), float(absent.sum()))

    def _rivals_scores(self, centred: NDArray[np.float64], seen: NDArray[np.bool_], steps: float) -> Iterator[Score]:
        yield Score("dat_cumulative_reward", following.dat_cumulative_reward(centred))
        yield Score("dat_tsr", following.dat_tsr(centred), steps)
        yield Score("episode_length_steps", float(following.episode_length_steps(seen, self._rate_hz)))
        yield Score("sr_500", float(following.survives(seen, self._rate_hz)))
        if self._seen.distance_m:
            person = following.person_following(centred > 0, np.array(self._seen.distance_m))
            yield Score("evt_success_rate", float(person.success))
            yield Score("evt_tracking_rate", person.tracking_rate, steps)
            yield Score("evt_collision_rate", float(person.collision))


class FollowSheet:
    """See ``benchmarks.suites.judging.ScoreSheet``. Estimates are held against the boxes of their frame at once."""

    def __init__(self, judge: FollowJudge) -> None:
        self._judge = judge
        self._on_target: list[bool] = []
        self._on_other: list[bool] = []
        self._says: list[bool] = []
        self._silent_frames = 0

    def keep(self, frame: Frame, estimate: Estimate) -> None:
        """See ``ScoreSheet``."""
        position_px, target = np.asarray(estimate.position_px, dtype=float), self._judge.target(frame.truth)
        self._on_target.append(following.is_on_target(position_px, frame.truth, target))
        self._on_other.append(following.is_on_other(position_px, frame.truth, target))
        self._says.append(_says_in_view(estimate, frame))
        self._silent_frames += bool(np.isnan(position_px).any())

    def scores(self, failed_at_frame: int | None) -> Iterator[Score]:
        """See ``ScoreSheet``. One that failed is silent from there on, which its controller is told."""
        yield from self._judge.scores()
        yield from self._judge.oxuva_scores(np.array(self._says), np.array(self._on_target), failed_at_frame)
        yield Score("wrong_target_rate", float(np.mean(self._on_other[1:])), float(len(self._on_other) - 1))
        yield Score("silent_frames", float(self._silent_frames))


def _says_in_view(estimate: Estimate, frame: Frame) -> bool:
    """Return whether it says that it sees its target; without a probability, its position is in the picture."""
    if estimate.in_view_probability is not None:
        return estimate.in_view_probability >= SEEN_PROBABILITY
    x, y = estimate.position_px
    return bool(0 <= x < frame.camera.width_px and 0 <= y < frame.camera.height_px)
