"""The episode of an env, with its tracker."""

from __future__ import annotations

import copy
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

import numpy as np

from scenarios import catalog
from scenarios.command_link import episode_link
from scenarios.envs.settings import FollowSettings
from scenarios.loop import Contestant, FromPictures, Loop, tracker_stream
from scenarios.scenario import Frame, KeptWorld
from sim.rng import generator
from trackers import registry
from trackers.estimate_check import check_estimate
from trackers.types import Estimate, Start


def watched_episode(settings: FollowSettings, seed: int, world_of: Callable[[Any], KeptWorld] | None = None) -> Loop:
    """Open one episode in closed loop, with the same pictures and estimates as in ``frameout bench follow``.

    Its steps raise RuntimeError if the tracker raises, or returns no valid estimate. Without a tracker every estimate
    is NaN.

    Args:
        world_of: returns a kept world for the episode's configuration, of a scenario that keeps worlds; None: the
            episode's own world.
    """
    scenario = catalog.scenario(settings.scenario)
    rng = generator(seed, "randomise")
    drawn = {name: float(rng.uniform(*limits)) for name, limits in settings.randomise.items()}
    preset = settings.configuration(drawn)
    kept = None if world_of is None else world_of(preset)
    episode = scenario.episode(preset, seed, renderer=settings.renderer, closed_loop=True, truth="target", kept=kept)
    try:
        watcher = _watcher(settings.tracker, seed, episode.start)
    except Exception:
        episode.close()
        raise
    return Loop(episode, [watcher], episode_link(scenario.carrier, episode.rate_hz, settings.link_settings, seed))


def _watcher(tracker: Any, seed: int, start: Start) -> Contestant:
    return _Nobody() if tracker is None else _Watcher(tracker, seed, start)


class _Nobody:
    """No tracker: it knows no place on any frame, not even on the first."""

    def initialise(self, frame: Frame, start: Start) -> Estimate:
        """See ``Contestant``."""
        return self.update(frame)

    def update(self, frame: Frame) -> Estimate:
        """See ``Contestant``."""
        return Estimate(np.full(2, np.nan))


class _Watcher:
    """An env's tracker as a contestant; its exceptions become RuntimeErrors that name it."""

    def __init__(self, tracker: Any, seed: int, start: Start) -> None:
        """``tracker`` is a name, or an object, which is copied so that no state carries over between episodes."""
        self._seed = seed
        if isinstance(tracker, str):
            rng = tracker_stream(seed, tracker)
            self._tracker, self._name = (
                registry.entry(tracker).create_for_one(rng, start.background, start.site),
                tracker,
            )
        else:
            self._tracker, self._name = copy.deepcopy(tracker), type(tracker).__name__

    def initialise(self, frame: Frame, start: Start) -> Estimate:
        """See ``Contestant``."""
        with self._blamed(frame):
            return FromPictures(self._tracker).initialise(frame, start)

    def update(self, frame: Frame) -> Estimate:
        """See ``Contestant``."""
        with self._blamed(frame):
            return check_estimate(self._tracker.update(frame.observation))

    @contextmanager
    def _blamed(self, frame: Frame) -> Iterator[None]:
        try:
            yield
        except Exception as error:
            raise RuntimeError(
                f"tracker: expected an estimate of {self._name} after frame {frame.truth.frame} of episode "
                f"{self._seed}, got {type(error).__name__}: {error}"
            ) from error
