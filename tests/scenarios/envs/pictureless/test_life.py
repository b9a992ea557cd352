"""Kernels are compiled for each scene's record by itself, in whichever order scenes come in one process."""

from __future__ import annotations

from itertools import permutations
from typing import Any

import numpy as np
import pytest
from numba import njit

from scenarios.envs.pictureless.life import LIFE
from scenarios.road_town.pictureless.flight_kernel import FLIGHT_LIFE
from scenarios.stereo_follow.pictureless.drive_kernel import DRIVE_LIFE


@pytest.mark.parametrize("records", list(permutations((LIFE, FLIGHT_LIFE, DRIVE_LIFE))))
def test_no_record_is_taken_for_another(records: tuple[np.dtype[Any], ...]) -> None:
    @njit
    def step(lives: Any) -> Any:
        return frame_of(lives[0])

    @njit
    def frame_of(life: Any) -> Any:
        return life.frame

    for count, record in enumerate(records):
        lives = np.zeros(1, record)
        lives["frame"] = count + 5
        assert step(lives) == count + 5
        assert len(frame_of.signatures) == count + 1
