"""The judge of the suite ``follow``: the target's place in the picture, the effort, and the tracker's estimates.

The column ``event`` holds the attributes of a loss::

    {"kind": "loss", "index": 0, "first_frame": 57, "length_frames": 43,
     "back_frame": 100 or null}

A loss is a stretch longer than 1 s on which the target was out of view.

Rows, with formulas in ``metrics.following`` and ``judges.view_time``; about a loss: ``recovery_frames``
(from leaving view to being in view again; null = never) and ``watched_frames`` (the same, or to the episode's end);
about the whole episode: ``rate_hz``, ``time_seen``, ``time_in_view``, ``losses_per_minute``, ``centring_error``,
``effort``, ``jerkiness_per_s``, ``episode_return``, ``dat_cumulative_reward``, ``dat_tsr``, ``episode_length_steps``,
``sr_500``, people's ``evt_success_rate``, ``evt_tracking_rate`` and ``evt_collision_rate``; of the tracker's answers
``in_view_tpr``, ``in_view_tnr``, ``wrong_target_rate`` and ``silent_frames``; then the times of the tracker,
``failed_at_frame``, and in every suite ``controller_failed_at_frame`` (only if the controller failed), ``frames``.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from benchmarks.contract.judging import Ending, Score
from benchmarks.judges import in_view
from benchmarks.judges.follow.metrics import following
from benchmarks.judges.view_time import find_losses, view_scores
from scenarios.envs.reward import Reward, Rewarder, effort_of
from scenarios.scenario import Episode, Frame, Scenario
from scenarios.visibility import centring, is_in_view
from trackers.belief.features import shares_of
from trackers.belief.kernel import SEEN_PROBABILITY
from trackers.types import CameraCommand, Estimate


class _Seen(NamedTuple):
    """What is kept of a frame, see ``scenarios.truth.Truth``; as series, of all frames.

    Attributes:
        position_px: of the target. is_in_view, centring: see ``scenarios.visibility``.
        visible: of the target.
        distance_m: on the ground from the camera to the target.
    """

    position_px: Any
    is_in_view: Any
    centring: Any
    visible: Any
    distance_m: Any


class FollowJudge:
    """See ``benchmarks.contract.judging.Judge``. For any scenario; people also have the scores of EVT-Bench."""

    def __init__(self, episode: Episode, scenario: Scenario) -> None:
        self._rate_hz, self._carrier, self.target = episode.rate_hz, scenario.carrier, scenario.target
        self._widest_view_m = scenario.widest_view_m
        self._size_px = (0, 0)
        self._seen: list[_Seen] = []
        self._shares: list[NDArray[np.float64]] = []
        self._rewarder, self._return = Rewarder(Reward(), self._rate_hz, self._widest_view_m), 0.0

    def see(self, frame: Frame, command: CameraCommand | None) -> None:
        """See ``Judge``."""
        truth, camera = frame.judged
        target = truth.index_of(self.target)
        self._size_px = (camera.width_px, camera.height_px)
        self._seen.append(
            _Seen(
                position_px=truth.position_px[target],
                is_in_view=is_in_view(truth, target, camera, self._widest_view_m),
                centring=centring(truth, target, camera),
                visible=float(truth.visible_fraction[target]),
                distance_m=float(np.hypot(*(truth.T_world_object[target, :2, 3] - truth.T_world_camera[:2, 3]))),
            )
        )
        if command is not None:
            shares = shares_of(self._carrier, command)
            self._shares.append(shares)
            self._return += sum(self._rewarder.terms(frame, target, effort_of(shares)).values())

    def sheet(self) -> FollowSheet:
        """See ``Judge``."""
        return FollowSheet(self)

    def series(self) -> _Seen:
        """Return what was seen so far as arrays (F, ...)."""
        return _Seen(*map(np.array, zip(*self._seen, strict=True)))

    def scores(self) -> Iterator[Score]:
        """Yield the scores of the camera's view and commands, without the tracker's answers."""
        rate_hz, series, shares = self._rate_hz, self.series(), np.array(self._shares)
        seen, centred = series.is_in_view, series.centring
        steps = float(len(seen) - 1)
        for loss in find_losses(seen, rate_hz):
            frames = None if loss.back_frame is None else float(loss.length_frames)
            yield Score("recovery_frames", frames, event=loss)
            yield Score("watched_frames", float(loss.length_frames), event=loss)
        yield Score("rate_hz", rate_hz)
        yield from view_scores(seen, series.visible, rate_hz)
        error = following.centring_error(series.position_px, self._size_px, seen)
        yield Score("centring_error", error, float(seen[1:].sum()))
        yield Score("effort", following.effort(shares), steps)
        yield Score("jerkiness_per_s", following.jerkiness_per_s(shares, rate_hz), steps)
        yield Score("episode_return", self._return)
        yield Score("dat_cumulative_reward", following.dat_cumulative_reward(centred))
        yield Score("dat_tsr", following.dat_tsr(centred), steps)
        yield Score("episode_length_steps", float(following.episode_length_steps(seen, rate_hz)))
        yield Score("sr_500", float(following.survives(seen, rate_hz)))
        if self._carrier.looks == "ahead":
            person = following.person_following(centred > 0, series.distance_m)
            yield Score("evt_success_rate", float(person.success))
            yield Score("evt_tracking_rate", person.tracking_rate, steps)
            yield Score("evt_collision_rate", float(person.collision))


class FollowSheet:
    """See ``benchmarks.contract.judging.ScoreSheet``. Estimates are compared with the boxes of their frame at once."""

    def __init__(self, judge: FollowJudge) -> None:
        self._judge = judge
        self._kept: list[tuple[bool, ...]] = []
        # Of the target, in the pictures that the tracker saw: frame, state, visible fraction.
        self._watched: list[tuple[int, str, float]] = []

    def keep(self, frame: Frame, estimate: Estimate) -> None:
        """See ``ScoreSheet``. Without a probability, a position in the picture says that the target is in view."""
        truth, position_px = frame.truth, np.asarray(estimate.position_px, dtype=float)
        target = truth.index_of(self._judge.target)
        self._watched.append((truth.frame, str(truth.state[target]), float(truth.visible_fraction[target])))
        probability = estimate.in_view_probability
        inside = (position_px >= 0) & (position_px < (frame.camera.width_px, frame.camera.height_px))
        self._kept.append(
            (
                following.is_on_target(position_px, truth, target),
                following.is_on_other(position_px, truth, target),
                bool(inside.all()) if probability is None else probability >= SEEN_PROBABILITY,
                bool(np.isnan(position_px).any()),
            )
        )

    def scores(self, ending: Ending) -> Iterator[Score]:
        """See ``ScoreSheet``. After a failure the controller gets no estimates."""
        yield from self._judge.scores()
        on_target, on_other, says, silent = np.array(self._kept).T
        seen_frame, state, visible = map(np.array, zip(*self._watched, strict=True))
        present, absent = in_view.present_and_absent(state, visible)
        failed = in_view.failed_frames(len(says), ending.failed_at_frame)[seen_frame]
        yield from in_view.oxuva_scores(present, absent, says, on_target, failed)
        yield Score("wrong_target_rate", float(np.mean(on_other[1:])), float(len(on_other) - 1))
        yield Score("silent_frames", float(silent.sum()))
