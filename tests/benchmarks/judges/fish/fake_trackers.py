"""For tests of the suite ``fish``, registered on import: a tracker that revises, one for gaps, a small preset."""

from __future__ import annotations

import os
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from scipy.optimize import linear_sum_assignment

from scenarios.fish_tank.scenario import FISH_TANK
from trackers.fish_chain.detection import Detector, DetectorParameters
from trackers.gaps import Bridge, Piece, Surroundings
from trackers.registry import NoParameters, register
from trackers.types import CameraModel, Estimate, Observation, Track

_GATE_PX = 25.0
FISH_TANK.presets["few"] = replace(FISH_TANK.presets["paper-c"], fish=2, glare=0.0, frame_count=180)


class Holds:
    """Keeps the last place, the less sure the longer; with a far end it goes straight there."""

    def learn(self, pieces: Sequence[Piece]) -> None:
        """Learn nothing."""

    def extrapolate(self, past: Piece, count: int, around: Surroundings) -> Bridge | None:
        """See ``GapMethod``."""
        steps = np.arange(1.0, count + 1)[:, None, None]
        return Bridge(np.tile(past.position_px[-1], (count, 1)), np.eye(2) * (3.0 + steps) ** 2)

    def interpolate(self, past: Piece, future: Piece, around: Surroundings) -> Bridge | None:
        """See ``GapMethod``."""
        count = future.first_frame - past.end_frame
        share = (np.arange(1, count + 1) / (count + 1))[:, None]
        return Bridge((1 - share) * past.position_px[-1] + share * future.position_px[0])


@register("fake_nearest", role="external", summary="joins each detection to the nearest before", suites=("fish",))
class Nearest:
    """Follows by the nearest detection; with hindsight all identities are one higher."""

    Parameters = NoParameters

    def __init__(self, parameters: NoParameters, rng: np.random.Generator) -> None:
        self.gap_method = Holds()

    def start(self, background: Sequence[Observation], camera: CameraModel) -> None:
        """See ``MultiTracker``."""
        self._detector = Detector(DetectorParameters())
        self._detector.start(background)
        self._places: dict[int, np.ndarray] = {}
        self._answers: list[list[Track]] = []

    def update(self, observation: Observation) -> list[Track]:
        """See ``MultiTracker``."""
        found, names = self._detector.detect(observation), list(self._places)
        places = np.array([each.position_px for each in found]).reshape(-1, 2)
        known = np.array([self._places[name] for name in names]).reshape(-1, 2)
        away_px = np.minimum(np.linalg.norm(places[:, None] - known[None], axis=2), _GATE_PX)
        pairs = {k: j for k, j in zip(*linear_sum_assignment(away_px), strict=True) if away_px[k, j] < _GATE_PX}
        tracks = []
        for k, place in enumerate(places):
            name = names[pairs[k]] if k in pairs else len(self._places)
            self._places[name] = place
            tracks.append(Track(name, Estimate(place), confidence=0.5))
        self._answers.append(tracks)
        return tracks

    def revised(self) -> list[list[Track]]:
        """See ``RevisingTracker``."""
        return [[Track(each.identity + 1, each.estimate, confidence=0.5) for each in told] for told in self._answers]


@register("fake_holds", role="external", summary="keeps the last place over a gap", suites=("fish",))
class HoldsAlone:
    """Follows no fish, and bridges gaps."""

    Parameters = NoParameters

    def __init__(self, parameters: NoParameters, rng: np.random.Generator) -> None:
        self.gap_method = Holds()

    def start(self, background: Sequence[Observation], camera: CameraModel) -> None:
        """See ``MultiTracker``."""

    def update(self, observation: Observation) -> list[Track]:
        """See ``MultiTracker``."""
        return []


class Exits(Holds):
    """Ends its process on the first gap."""

    def extrapolate(self, past: Piece, count: int, around: Surroundings) -> Bridge | None:
        """See ``GapMethod``."""
        os._exit(3)


@register("fake_dies", role="external", summary="ends its process on the first gap", suites=("fish",))
class ExitsAlone(HoldsAlone):
    """Follows no fish, and ends its process."""

    def __init__(self, parameters: NoParameters, rng: np.random.Generator) -> None:
        self.gap_method = Exits()
