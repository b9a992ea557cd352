"""Flights that start shortly before a gust start in no other: the first picture tells how the camera is mounted."""

from __future__ import annotations

import numpy as np
import pytest

from scenarios.envs.pictureless.episode_state import LEAD_FRAMES
from scenarios.road_town.flight import gust_attitude_rad
from scenarios.road_town.pictureless.bank import RoadPictureless
from scenarios.road_town.plan import make_plan
from scenarios.road_town.presets import PRESETS


@pytest.mark.heavy
@pytest.mark.parametrize("name", ["standard", "oblique"])
def test_no_flight_starts_in_a_gust(name: str) -> None:
    preset, kept, dropped = PRESETS[name], 0, 0
    for seed in range(6):
        plan = make_plan(preset, seed, closed_loop=True)
        gusts = [pulse.start_frame for pulse in plan.pulses]
        onsets = RoadPictureless().arrays(preset, seed)["onsets"]
        onsets = onsets[onsets >= 0.0].astype(int)
        assert onsets[0] == gusts[0]
        assert set(onsets) <= set(gusts)
        kept, dropped = kept + len(onsets) - 1, dropped + len(gusts) - len(onsets)
        turned_rad = gust_attitude_rad(list(plan.pulses), plan.air.altitude_m, preset.frame_count, plan.air.mount_rad)
        starts = np.maximum(onsets[:, None] - np.arange(LEAD_FRAMES[0], LEAD_FRAMES[1] + 1), 0)
        assert (turned_rad[starts] == 0.0).all()
    assert kept > 0
    assert dropped > 0
