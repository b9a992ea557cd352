"""The judge of the suite ``follow``: the target's place in the picture, the effort, and the tracker's estimates."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from benchmarks.contract.judging import Ending, Score
from benchmarks.judges import in_view
from benchmarks.judges.follow.metrics import following
from benchmarks.judges.view_time import find_losses, view_scores
from scenarios.in_view import centring, is_in_view
from scenarios.scenario import Episode, Frame, Scenario
from scenarios.truth import Truth
from trackers.belief.features import shares_of
from trackers.belief.kernel import SEEN_PROBABILITY
from trackers.types import CameraCommand, Estimate


@dataclass
class _Seen:
    """Values of the frames so far, a list entry a frame; see ``scenarios.truth.Truth``.

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
    """See ``benchmarks.contract.judging.Judge``. For any scenario; people also have the scores of EVT-Bench."""

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
        """Yield the scores of the camera's view and commands, without the tracker's answers."""
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

    def present_and_absent(self) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
        """Return (F,) present and (F,) absent, see ``in_view``."""
        return in_view.present_and_absent(np.array(self._seen.watched_state), np.array(self._seen.watched_visible))

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
    """See ``benchmarks.contract.judging.ScoreSheet``. Estimates are compared with the boxes of their frame at once."""

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

    def scores(self, ending: Ending) -> Iterator[Score]:
        """See ``ScoreSheet``. After a failure the controller gets no estimates."""
        yield from self._judge.scores()
        failed = in_view.failed_frames(len(self._says), ending.failed_at_frame)
        says, on_target = np.array(self._says), np.array(self._on_target)
        yield from in_view.oxuva_scores(*self._judge.present_and_absent(), says, on_target, failed)
        yield Score("wrong_target_rate", float(np.mean(self._on_other[1:])), float(len(self._on_other) - 1))
        yield Score("silent_frames", float(self._silent_frames))


def _says_in_view(estimate: Estimate, frame: Frame) -> bool:
    """Return whether the tracker answers that it sees the target; without a probability, that it is in the picture."""
    if estimate.in_view_probability is not None:
        return estimate.in_view_probability >= SEEN_PROBABILITY
    x, y = estimate.position_px
    return bool(0 <= x < frame.camera.width_px and 0 <= y < frame.camera.height_px)
