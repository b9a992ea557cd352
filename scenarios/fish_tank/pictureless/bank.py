"""Pictureless ``fish-tank``."""

from __future__ import annotations

from scenarios.envs.pictureless.head_bank import HeadPictureless
from scenarios.scenario import TrackerRuns


class TankPictureless(HeadPictureless):
    """See ``scenarios.scenario.Pictureless``."""

    scenario = "fish-tank-v1"
    version = 1
    runs = TrackerRuns(("hold",), wrong_from_m=0.02, jump_m=0.03)
