"""A tracker for the suite ``harbour`` that sees the same on all pictures."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from trackers.registry import NoParameters, register
from trackers.types import CameraModel, Estimate, Observation, Track


@register("fake_stares", role="external", summary="the same on all pictures", suites=("harbour",))
class FakeStares:
    """Decides for one of two tracks."""

    Parameters = NoParameters
    decides_at = 0.5

    def __init__(self, parameters: NoParameters, rng: np.random.Generator) -> None:
        pass

    def start(self, background: Sequence[Observation], camera: CameraModel) -> None:
        assert all(each.counts is not None and each.ego is not None for each in background)
        assert len(background) > 0

    def update(self, observation: Observation) -> list[Track]:
        return [_track(0, (192.0, 160.0), 0.9), _track(1, (60.0, 240.0), 0.2)]


def _track(identity: int, at_px: tuple[float, float], confidence: float) -> Track:
    px = np.array(at_px)
    estimate = Estimate(px, np.concatenate([px - 5.0, px + 5.0]), depth_m=95.0)
    return Track(identity, estimate, "car", np.ones(3), confidence)
