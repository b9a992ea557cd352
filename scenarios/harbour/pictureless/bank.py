"""Pictureless ``harbour``."""

from __future__ import annotations

from scenarios.envs.pictureless.head_bank import HeadPictureless
from scenarios.scenario import TrackerRuns


class HarbourPictureless(HeadPictureless):
    """See ``scenarios.scenario.Pictureless``."""

    scenario = "harbour-v1"
    version = 1
    runs = TrackerRuns(("hold",), wrong_from_m=1.5, jump_m=2.0)
