"""Whims of drivers at any rate."""

from __future__ import annotations

import numpy as np
import pytest

from scenarios.stereo_follow.walks import draw_whims


class CountedDraws:
    """A generator that refuses to go on for ever."""

    def __init__(self) -> None:
        self._rng, self._left = np.random.default_rng(0), 10_000

    def uniform(self, low: float, high: float) -> float:
        self._left -= 1
        assert self._left, "drawn without an end"
        return self._rng.uniform(low, high)

    def normal(self, size: int) -> np.ndarray:
        return self._rng.normal(size=size)


@pytest.mark.parametrize("rate_hz", [0.05, 0.2, 0.5, 2.0, 15.0])
def test_each_frame_has_its_whims_at_any_rate(rate_hz: float) -> None:
    whims = draw_whims(90, rate_hz, CountedDraws())
    assert whims.attends.shape == whims.distance_m.shape == (90,)
    assert whims.attends[0]
    # He looks away for 0.4 to 1.1 s: where that is surely less than a frame, on none; in 6 s surely once.
    assert whims.attends.all() or rate_hz > 1 / 1.1
    assert not whims.attends.all() or rate_hz < 15
