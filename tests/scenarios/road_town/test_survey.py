"""The survey of frame-outs says what is wrong where there is nothing to survey."""

from __future__ import annotations

import pytest

from scenarios.road_town.presets import PRESETS
from scenarios.road_town.survey import FRAME_OUTS


def test_seeds_without_a_frame_out_are_refused_by_name() -> None:
    with pytest.raises(ValueError, match=r"seeds: expected one at least of an episode .*, got range\(0, 0\)"):
        FRAME_OUTS.measure(PRESETS["quick"], range(0))
