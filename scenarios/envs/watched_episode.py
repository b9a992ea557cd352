"""An episode with a tracker that watches it: what an env steps through."""

from __future__ import annotations

import copy
from typing import Any

import numpy as np

from scenarios import catalog
from scenarios.command_link import CommandLink
from scenarios.envs.settings import FollowSettings
from sim.rng import generator
from trackers import registry
from trackers.estimate_check import check_estimate
from trackers.protocols import Tracker
from trackers.types import CameraCommand, Estimate


class WatchedEpisode:
    """One episode in closed loop, as ``frameout bench follow`` lives it: same seeds, same pictures, same estimates.

    Attributes:
        seed: of the episode. rate_hz, frame_count: see ``Episode``.
        episode: the scenario's own. frame, estimate: the latest. obeyed: the latest command as the carrier got it.
    """

    def __init__(self, settings: FollowSettings, seed: int) -> None:
        scenario = catalog.scenario(settings.scenario)
        rng = generator(seed, "randomise")
        drawn = {name: float(rng.uniform(*limits)) for name, limits in settings.randomise.items()}
        self.seed = seed
        self._tracker, self._tracker_name = _tracker(settings.tracker, seed)
        self.episode = scenario.episode(
            settings.configuration(drawn), seed, renderer=settings.renderer, closed_loop=True, truth="target"
        )
        self.rate_hz, self.frame_count = self.episode.rate_hz, self.episode.frame_count
        self._link = CommandLink(scenario.carrier, self.rate_hz, settings.link_settings, generator(seed, "link"))
        self.obeyed = CameraCommand()
        self.frame = self.episode.step()
        box = self.episode.target_box_xyxy
        self.estimate = Estimate(0.5 * (box[:2] + box[2:]), box_xyxy=box.copy(), in_view_probability=1.0)
        try:
            self._tracker.initialise(self.frame.observation, box.copy())
        except Exception as error:
            self.close()
            raise self._blamed(error) from error

    def step(self, command: CameraCommand) -> None:
        """Move on by one frame.

        Raises:
            RuntimeError: if the tracker raises, or returns what is no estimate.
        """
        self.obeyed = self._link.send(command)
        self.frame = self.episode.step(self.obeyed)
        try:
            self.estimate = self._tracker.update(self.frame.observation)
            check_estimate(self.estimate)
        except Exception as error:
            raise self._blamed(error) from error

    @property
    def is_over(self) -> bool:
        """Whether this was the last frame."""
        return self.frame.truth.frame + 1 >= self.frame_count

    def larger_view(self, scale: float) -> np.ndarray:
        """See ``Episode``."""
        return self.episode.larger_view(scale)

    def close(self) -> None:
        """Free the world."""
        self.episode.close()

    def _blamed(self, error: Exception) -> RuntimeError:
        at = self.frame.truth.frame
        return RuntimeError(
            f"tracker: expected an estimate of {self._tracker_name} after frame {at} of episode {self.seed}, "
            f"got {type(error).__name__}: {error}"
        )


def _tracker(tracker: Any, seed: int) -> tuple[Tracker, str]:
    """Return a fresh tracker and its name; of an object a copy, so that it carries nothing over."""
    if isinstance(tracker, str):
        # The benchmark's stream: an episode of the env is an episode of the benchmark.
        return registry.entry(tracker).create(generator(seed, f"tracker/{tracker}")), tracker
    return copy.deepcopy(tracker), type(tracker).__name__
