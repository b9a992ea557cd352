"""Trackers of many targets that answer oddly, registered on import for the suite ``fish``."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from scenarios.fish_tank.scenario import FISH_TANK
from trackers.registry import NoParameters, register
from trackers.types import CameraModel, Estimate, Observation, Track

FISH_TANK.presets["glimpse"] = replace(FISH_TANK.presets["paper-c"], fish=2, glare=0.0, frame_count=16)


@register("fake_wanders", role="external", summary="says float32, NaN and nothing in turn", suites=("fish",))
class Wanders:
    """Follows what it makes up; with hindsight the names are others."""

    Parameters = NoParameters

    def __init__(self, parameters: NoParameters, rng: np.random.Generator) -> None:
        self._rng, self._told = rng, []

    def start(self, background: Sequence[Observation], camera: CameraModel) -> None:
        """See ``MultiTracker``."""

    def update(self, observation: Observation) -> list[Track]:
        """See ``MultiTracker``."""
        frame = len(self._told)
        place = self._rng.uniform(0, 200, 2).astype(np.float32)
        line = place + np.arange(6, dtype=np.float32).reshape(3, 2)
        tracks = [
            Track(0, Estimate(place, heading_rad=np.float32(0.1), centre_line_px=line), "fish", np.ones(3), 0.5),
            Track(7, Estimate(np.full(2, np.nan) if frame % 3 else np.array([50.0, 60.0]), depth_m=2)),
        ]
        self._told.append([] if frame % 4 == 1 else tracks)
        return self._told[-1]

    def revised(self) -> list[list[Track]]:
        """See ``RevisingTracker``."""
        return [[Track(each.identity + 1, each.estimate) for each in told] for told in self._told]


@register("fake_gives_up", role="external", summary="raises on frame 9", suites=("fish",))
class GivesUp(Wanders):
    """Fails, so that nothing is revised."""

    def update(self, observation: Observation) -> list[Track]:
        """See ``MultiTracker``."""
        if len(self._told) == 9:
            raise RuntimeError("no more")
        return super().update(observation)


@register("fake_regrets", role="external", summary="fails with hindsight", suites=("fish",))
class Regrets(Wanders):
    """Fails after the last frame."""

    def revised(self) -> list[list[Track]]:
        """See ``RevisingTracker``."""
        raise RuntimeError("too late")
