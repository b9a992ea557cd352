"""Ranges, conditions and sources of the rows of suite ``follow``."""

from __future__ import annotations

from math import inf

from benchmarks.contract.metric import OWN, RowMeaning
from benchmarks.judges.row_meanings import IN_VIEW, KAPLAN_MEIER, SPEED, time_in_view

_STEPS = "every frame but the first"
_DAT = "DAT_Benchmark, 2025"
_AD_VAT = "AD-VAT: Zhong et al., 2019; UnrealZoo: Zhong et al., 2025"
_EVT = "EVT-Bench (TrackVLA), 2025"
_PEOPLE = "episodes with a person as the target"

ROW_MEANINGS = (
    *time_in_view("every episode"),
    RowMeaning(("centring_error",), 0, 1, f"{_STEPS}, with the target in view", OWN),
    RowMeaning(("recovery_frames", "watched_frames"), 0, inf, "losses: over 1 s out of view", KAPLAN_MEIER),
    RowMeaning(("rate_hz",), 0, inf, "", OWN),
    RowMeaning(("wrong_target_rate",), 0, 1, _STEPS, OWN),
    RowMeaning(("effort",), 0, 1, _STEPS, OWN),
    RowMeaning(("jerkiness_per_s",), 0, inf, _STEPS, OWN),
    RowMeaning(("dat_cumulative_reward",), 0, inf, _STEPS, _DAT),
    RowMeaning(("dat_tsr",), 0, 1, _STEPS, _DAT),
    RowMeaning(("episode_length_steps",), 0, inf, _STEPS, _AD_VAT),
    RowMeaning(("sr_500",), 0, 1, "the first 500 steps of an episode, or all", _AD_VAT),
    RowMeaning(("evt_success_rate", "evt_tracking_rate", "evt_collision_rate"), 0, 1, _PEOPLE, _EVT),
    *IN_VIEW,
    SPEED,
)
