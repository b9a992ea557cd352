"""The env: a camera follows a target, and the policy observes a tracker's belief."""

from __future__ import annotations

import copy
import dataclasses
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import gymnasium as gym
import numpy as np
from gymnasium.utils import EzPickle
from numpy.typing import NDArray

from scenarios import catalog
from scenarios.command_link import episode_link
from scenarios.envs.actions import Steering, action_count, checked_actions, steering
from scenarios.envs.observing import Channels, Observed, picture_size
from scenarios.envs.reward import Rewarder, effort_of
from scenarios.envs.settings import DEVELOPMENT_SEEDS, KEYWORDS, OWN_WORLD, FollowSettings
from scenarios.envs.truth_info import NO_REWARD, truth_info
from scenarios.envs.view import Window, draw_view
from scenarios.loop import FromPictures, Loop, tracker_stream
from scenarios.scenario import Frame
from scenarios.worlds import POOL
from sim.checks import check, check_choice
from trackers import registry
from trackers.belief.features import FeatureFilter, shares_of
from trackers.belief.sighting import BeliefFilter
from trackers.estimate_check import check_estimate
from trackers.types import CameraCommand, Carrier, Estimate, Start


def followed_episode(settings: FollowSettings, seed: int, world_seed: int = OWN_WORLD) -> Loop:
    """Open one episode in closed loop, in its own world with the pictures and estimates of ``frameout bench follow``.

    Its steps raise RuntimeError if the tracker raises, or returns no valid estimate. Without a tracker every estimate
    is NaN.

    Args:
        world_seed: of the world of this process's pool that it takes place in.
    """
    scenario = catalog.scenario(settings.scenario)
    preset = settings.configuration_of(seed)
    kept = None if world_seed == OWN_WORLD else POOL.world(scenario, preset, world_seed)
    episode = scenario.episode(preset, seed, renderer=settings.renderer, closed_loop=True, truth="target", kept=kept)
    try:
        trackers = [] if settings.tracker is None else [_EnvTracker(settings.tracker, seed, episode.start)]
    except Exception:
        episode.close()
        raise
    link = settings.link_settings
    sender = episode_link(scenario.carrier, episode.rate_hz, link, seed)
    return Loop(episode, trackers, sender, link.picture_delay_frames)


class _EnvTracker:
    """Runs an env's tracker in the loop; its exceptions become RuntimeErrors that name it."""

    def __init__(self, tracker: Any, seed: int, start: Start) -> None:
        """``tracker`` is a name, or an object, which is copied so that no state carries over between episodes."""
        self._seed = seed
        if isinstance(tracker, str):
            rng = tracker_stream(seed, tracker)
            own = registry.entry(tracker).create_for_one(rng, start.background, start.site)
            self._name = tracker
        else:
            own, self._name = copy.deepcopy(tracker), type(tracker).__name__
        self._tracker = FromPictures(own)

    def initialise(self, frame: Frame, start: Start) -> Estimate:
        """See ``LoopTracker``."""
        with self._named_errors(frame):
            return self._tracker.initialise(frame, start)

    def update(self, frame: Frame) -> Estimate:
        """See ``LoopTracker``."""
        with self._named_errors(frame):
            return check_estimate(self._tracker.update(frame), frame.observation.camera)

    @contextmanager
    def _named_errors(self, frame: Frame) -> Iterator[None]:
        try:
            yield
        except Exception as error:
            raise RuntimeError(
                f"tracker: expected an estimate of {self._name} after frame {frame.truth.frame} of episode "
                f"{self._seed}, got {type(error).__name__}: {error}"
            ) from error


class FollowEnv(gym.Env, EzPickle):
    """A camera on a steered carrier follows a target.

    Keywords are ``render_mode`` and those of ``FollowSettings``. An observation is a vector ``track``
    (``trackers.belief.features.FEATURES``, in [-1, 1]), the picture ``pixels`` (H, W, 3) uint8, the privileged
    ``depth`` (H, W) float32 or ``segmentation`` (H, W) uint8, or a dictionary of several. An action is (A,) in [-1, 1].
    But for the privileged ones truth is in ``info`` alone, see ``truth_info``.

    ``reset(seed=...)`` seeds the draw of episode seeds below 10,000; ``reset(options={"episode_seed": n})`` selects
    one. A seed names one episode, whatever came before: with ``worlds`` it takes place in a world that others share,
    and ``info`` has the seeds of both; with ``worlds=0``, or with ``"world_seed": -1`` among the options, it equals the
    catalogue's episode with this seed byte for byte. An episode is truncated after its last frame, and terminates only
    by ``lost_after_s``.
    """

    metadata: dict[str, Any] = {"render_modes": ["rgb_array", "human"], "render_fps": 15}

    def __init__(self, scenario: str, render_mode: str | None = None, **settings: Any) -> None:
        EzPickle.__init__(self, scenario, render_mode, **settings)
        alone = "gym.make_vec(…, pictures=False) alone, without a vectorization_mode"
        wanted = f"no such keyword here, as envs without pictures come from {alone}"
        check("pictures", "pictures" not in settings, wanted, settings.get("pictures"))
        for name in settings:
            check_choice("keywords", name, KEYWORDS)
        modes = self.metadata["render_modes"]
        check("render_mode", render_mode in (None, *modes), f"None or one of {', '.join(modes)}", repr(render_mode))
        self.settings = FollowSettings(scenario, **settings)
        # Videos and windows play as fast as the episode's time passes, where the preset says how fast that is.
        rate_hz = getattr(self.settings.configuration({}), "rate_hz", self.metadata["render_fps"])
        self.metadata = {**self.metadata, "render_fps": rate_hz}
        self.carrier: Carrier = catalog.scenario(scenario).carrier
        self.render_mode = render_mode
        self._channels = Channels(self.settings)
        self.observation_space = self._channels.space
        self.action_space = gym.spaces.Box(-1.0, 1.0, (action_count(self.settings, self.carrier),), np.float32)
        self._run: _Run | None = None
        # A missing screen is refused here, before anything runs.
        self._window = Window(self.metadata["render_fps"]) if render_mode == "human" else None

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Observed, dict[str, Any]]:
        """Begin a new episode; ``options`` are ``episode_seed`` and settings for this episode alone."""
        super().reset(seed=seed)
        wanted = options or {}
        settings = self.settings.with_options(wanted)
        if settings.observes_pictures:
            size, made_for = picture_size(settings), picture_size(self.settings)
            check("options", size == made_for, f"pictures of the size {made_for}, which the env was made for", size)
        drawn = int(self.np_random.integers(DEVELOPMENT_SEEDS))
        self._end()
        episode = int(wanted.get("episode_seed", drawn))
        self._run = _Run(settings, episode, int(wanted.get("world_seed", settings.world_of(episode))), self.carrier)
        self._show()
        return self._observed(self._run), self._run.info(NO_REWARD)

    def step(self, action: NDArray[Any]) -> tuple[Observed, float, bool, bool, dict[str, Any]]:
        """Advance by one frame.

        Raises:
            ResetNeeded: before the first reset, and after the last frame.
            ValueError: for an action of another shape, not finite, or outside [-1, 1] unless these are clipped.
            RuntimeError: if the tracker raises, or returns no valid estimate.
        """
        run = self._run
        if run is None or run.ended:
            raise gym.error.ResetNeeded("step: expected an episode that runs, got none: reset() begins one")
        checked = checked_actions(action, self.action_space.shape, self.settings.out_of_range)
        # Stays True if this step raises: after an error only a reset continues.
        run.ended = True
        terms = run.step(checked)
        self._show()
        terminated = run.is_lost
        truncated = run.loop.is_over
        run.ended = terminated or truncated
        return self._observed(run), float(sum(terms.values())), terminated, truncated, run.info(terms)

    def render(self) -> NDArray[np.uint8] | None:
        """Return the larger view (H, W, 3) with the picture, truth and estimate drawn in; None in ``human`` mode."""
        if self._run is None:
            raise gym.error.ResetNeeded("render: expected reset() before it, got an episode that has not begun")
        return draw_view(self._run.loop, self._run.target) if self.render_mode == "rgb_array" else None

    @property
    def progress(self) -> float:
        """Of the training, see ``FollowSettings``; set it for later episodes."""
        return self.settings.progress

    @progress.setter
    def progress(self, progress: float) -> None:
        self.settings = dataclasses.replace(self.settings, progress=progress)

    @property
    def episode(self) -> Loop:
        """The loop through the current episode, with its truth, for scoring."""
        if self._run is None:
            raise gym.error.ResetNeeded("episode: expected reset() before it, got an episode that has not begun")
        return self._run.loop

    def close(self) -> None:
        """End the episode and close the window; worlds stay for other envs of this process."""
        self._end()
        if self._window is not None:
            self._window.close()
            self._window = None

    def _observed(self, run: _Run) -> Observed:
        seen = run.loop.seen
        return self._channels.observed(seen.observation, seen.truth, run.features)

    def _show(self) -> None:
        if self.render_mode == "human" and self._run is not None:
            self._window = self._window or Window(self.metadata["render_fps"])
            self._window.show(draw_view(self._run.loop, self._run.target))

    def _end(self) -> None:
        if self._run is not None:
            self._run.loop.episode.close()
            self._run = None


class _Run:
    """One episode of the env."""

    def __init__(self, settings: FollowSettings, seed: int, world_seed: int, carrier: Carrier) -> None:
        """See ``followed_episode``."""
        self._carrier = carrier
        # Before the world is built: a refusal leaves no world behind.
        beliefs = BeliefFilter(carrier.looks)
        self._steering: Steering = steering(settings, carrier, beliefs)
        self.loop = followed_episode(settings, seed, world_seed)
        self.ended = False
        self._scenario = catalog.scenario(settings.scenario)
        self._seeds, rate_hz = (seed, world_seed), self.loop.episode.rate_hz
        self._rewarder = Rewarder(settings.reward, rate_hz, self._scenario.widest_view_m)
        lost_after_s = settings.lost_after_s
        self._lost_frames = None if lost_after_s is None else max(round(lost_after_s * rate_hz), 1)
        self._feature_filter = None if settings.tracker is None else FeatureFilter(carrier, beliefs)
        try:
            self._move()
        except BaseException:
            self.loop.episode.close()
            raise

    @property
    def target(self) -> int:
        """Index of the object that is followed."""
        return self.loop.frame.truth.index_of(self._scenario.target)

    @property
    def is_lost(self) -> bool:
        """Whether the target has been out of view for ``lost_after_s``."""
        return self._lost_frames is not None and self._rewarder.frames_out >= self._lost_frames

    def step(self, action: NDArray[np.float64]) -> dict[str, float]:
        """Advance by one frame; return the reward's terms."""
        self._move(self._steering(action, self.loop.seen.observation, self.loop.estimate))
        effort = effort_of(shares_of(self._carrier, self._obeyed))
        return self._rewarder.terms(self.loop.frame, self.target, effort)

    def features(self) -> NDArray[np.float32]:
        """Return the belief's features as a new vector."""
        return self._features.copy()

    def info(self, terms: dict[str, float]) -> dict[str, Any]:
        """Return the truth of the latest frame, see ``truth_info``."""
        answered = None if self._feature_filter is None else (self.loop.seen, self.loop.estimate)
        widest_view_m = self._scenario.widest_view_m
        return truth_info(self.loop.frame, self.target, answered, self._obeyed, terms, *self._seeds, widest_view_m)

    def _move(self, command: CameraCommand | None = None) -> None:
        still = CameraCommand()
        self.loop.step(command)
        self._obeyed = self.loop.obeyed or still
        if self._feature_filter is not None:
            self._features = self._feature_filter.update(
                self.loop.seen.observation, self.loop.estimate, command or still
            )
