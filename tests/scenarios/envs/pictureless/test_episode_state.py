"""Kernels are compiled for each scene's record separately, in any order of the scenes in one process."""

from __future__ import annotations

from itertools import permutations
from typing import Any

import numpy as np
import pytest
from numba import njit

from scenarios.envs.pictureless.episode_state import EPISODE_STATE
from scenarios.road_town.pictureless.world import FLIGHT_STATE
from scenarios.stereo_follow.pictureless.world import DRIVE_STATE


@pytest.mark.heavy
@pytest.mark.parametrize("records", list(permutations((EPISODE_STATE, FLIGHT_STATE, DRIVE_STATE))))
def test_no_record_is_taken_for_another(records: tuple[np.dtype[Any], ...]) -> None:
    @njit
    def step(states: Any) -> Any:
        return frame_of(states[0])

    @njit
    def frame_of(state: Any) -> Any:
        return state.frame

    for count, record in enumerate(records):
        states = np.zeros(1, record)
        states["frame"] = count + 5
        assert step(states) == count + 5
        assert len(frame_of.signatures) == count + 1
