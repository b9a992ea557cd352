"""The suite ``follow``: how well does a controller, steering by a tracker's estimate, keep the target in view?"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from math import inf
from typing import Any

from benchmarks.contract.metric import OWN, Better, Mean, Metric, Quantity
from benchmarks.contract.suite import EventWords, Scene, Suite, TuningEpisodes, register_suite
from benchmarks.contract.text import counted, lengths_text
from benchmarks.judges import in_view
from benchmarks.judges.follow.judge import FollowJudge
from benchmarks.judges.follow.metrics import following
from benchmarks.judges.follow.omniscient import OmniscientController, OmniscientHead
from benchmarks.judges.follow.references import ORACLE
from benchmarks.judges.recovery import recovery_times
from benchmarks.judges.tracker_speed import SPEED
from benchmarks.judges.view_time import LOSS_S, LOSSES_PER_MINUTE, TIME_IN_VIEW, TIME_SEEN, Loss
from benchmarks.statistics.pooling import RestrictedMean
from scenarios.envs.reward import Rewarder
from trackers.controllers.catalogue import register_controller


def _describe(losses: Sequence[dict[str, Any]]) -> str:
    if not losses:
        return f"no losses: the target was never out of view for longer than {LOSS_S:g} s"
    lengths = [each["length_frames"] for each in losses]
    never = sum(each["back_frame"] is None for each in losses)
    return f"{counted(len(losses), 'loss', 'losses')} of {lengths_text(lengths)}, {never} of them to the end"


_WITHOUT_PICTURES = TuningEpisodes(seeds=range(256), fresh=64)
"""Without pictures episodes are cheap; those that check the best setting have pictures."""
_OF_HEADS = replace(_WITHOUT_PICTURES, preset="quick", fresh=40)
"""An episode of ``standard`` takes a minute or two, since its tracker watches the whole site."""

LONGEST_SEARCH_FRAMES = 150
"""Horizon of the restricted mean of the time to find the target again (10 s at 15 frames a second)."""
_STEPS = "every frame but the first"
_DAT = "DAT_Benchmark, 2025"
_AD_VAT = "AD-VAT: Zhong et al., 2019; UnrealZoo: Zhong et al., 2025"
_EVT = "EVT-Bench (TrackVLA), 2025"
_RATE_HZ = Quantity("rate_hz", 0, inf, "", OWN, (Loss,))


def _metric(
    name: str,
    summary: str,
    defined_by: Callable[..., Any],
    better: Better = "higher",
    unit: str = "fraction",
    *,
    conditions: str = _STEPS,
    source: str = OWN,
) -> Metric:
    high = 1.0 if unit == "fraction" else inf
    return Metric(name, summary, unit, better, Mean(Quantity(name, 0, high, conditions, source, (defined_by,))))


def _evt(name: str, summary: str, better: Better = "higher") -> Metric:
    about = "episodes with a person as the target"
    return _metric(name, f"EVT-Bench: {summary}", following.person_following, better, conditions=about, source=_EVT)


COMPARED = (
    TIME_SEEN,
    TIME_IN_VIEW,
    _metric(
        "centring_error",
        "distance of the target from the picture's middle, over half the diagonal, while in view",
        following.centring_error,
        "lower",
        conditions=f"{_STEPS}, with the target in view",
    ),
    LOSSES_PER_MINUTE,
    Metric(
        "time_to_find_again_s",
        f"of losses (out of view for longer than {LOSS_S:g} s): mean time from leaving view to being in view again, "
        f"never = {LONGEST_SEARCH_FRAMES} frames (Kaplan-Meier, restricted)",
        "s",
        "lower",
        RestrictedMean(LONGEST_SEARCH_FRAMES, *recovery_times("losses: over 1 s out of view", Loss), _RATE_HZ),
    ),
    _metric(
        "wrong_target_rate",
        "time with the estimate on another visible object, outside the target's box",
        following.is_on_other,
        "lower",
    ),
    _metric(
        "effort",
        "mean size of the obeyed commands, 1 = every axis at its limit all the time",
        following.effort,
        "lower",
    ),
    _metric(
        "jerkiness_per_s",
        "mean change of the obeyed commands in a second, in the same measure",
        following.jerkiness_per_s,
        "lower",
        "1",
    ),
    Metric(
        "episode_return",
        "sum of the rewards of the envs, with the weights that they have by default",
        "1",
        "higher",
        Mean(Quantity("episode_return", -inf, inf, _STEPS, OWN, (Rewarder.terms,))),
    ),
)
"""Metrics of whole episodes in comparisons."""

FOLLOW = Suite(
    name="follow",
    edition=3,
    summary="a controller steers the camera by a tracker's estimate: is the target kept in view?",
    scenes=(
        Scene("road-town", "frame-out", ("mosaic_graph_pf", "colour_pf"), tuned_on=_WITHOUT_PICTURES),
        Scene("stereo-follow", "stereo", ("stereo_people", "stereo_wb_shutter_gain"), tuned_on=_WITHOUT_PICTURES),
        Scene("fish-tank", "fish", ("shoal_chain", "ca_kalman"), tuned_on=_OF_HEADS),
        Scene(
            "harbour",
            "harbour",
            ("harbour_watch", "eigen_swarm"),
            preset="patrol",
            tuned_on=replace(_OF_HEADS, preset="patrol"),
        ),
        Scene("fish-tank-ptz", "frame-out", ("panorama_difference", "correlation_filter")),
        Scene("harbour-ptz", "frame-out", ("panorama_difference", "correlation_filter")),
    ),
    preset="standard",
    quick_preset="quick",
    judge=FollowJudge,
    metrics=(
        *COMPARED,
        _metric(
            "dat_cumulative_reward",
            "DAT_Benchmark: sum of tanh(4 p³)",
            following.dat_cumulative_reward,
            unit="1",
            source=_DAT,
        ),
        _metric(
            "dat_tsr", "DAT_Benchmark: steps with the target's centre in the picture", following.dat_tsr, source=_DAT
        ),
        _metric(
            "episode_length_steps",
            "AD-VAT, UnrealZoo: steps until it was out of view for 2 simulated seconds, or to the end",
            following.episode_length_steps,
            unit="steps",
            source=_AD_VAT,
        ),
        _metric(
            "sr_500",
            "AD-VAT, UnrealZoo: episodes of 500 steps, or shorter, never out of view for over 2 simulated s",
            following.survives,
            conditions="the first 500 steps of an episode, or all",
            source=_AD_VAT,
        ),
        _evt("evt_success_rate", "episodes that end in the picture and within 3 m, never lost"),
        _evt("evt_tracking_rate", "steps in the picture and within 3 m, none after a loss"),
        _evt("evt_collision_rate", "episodes that end with the camera nearer than 0.5 m", "lower"),
        *in_view.IN_VIEW,
        *SPEED,
    ),
    headline=(
        "time_seen",
        "time_in_view",
        "centring_error",
        "losses_per_minute",
        "time_to_find_again_s",
        "wrong_target_rate",
        "effort",
        "sr_500",
    ),
    compared=tuple(metric.name for metric in COMPARED),
    tuned_for={"time_in_view": 1.0, "effort": -0.1},
    # Losses depend on the controller, so trackers are compared over whole episodes only.
    events=EventWords("losses", "event", tests={}, describe=_describe, episodes=COMPARED),
    silence="no estimate for its controller; only where the camera looks is scored",
    references=(ORACLE,),
    key_columns=("controller", "tracker"),
    truth="target",
)
register_suite(FOLLOW)

for _carrier in ("helicopter", "robot"):
    register_controller(
        "omniscient",
        role="oracle",
        carrier=_carrier,
        summary="knows the target's path and all that moves the camera: what a controller could do at best",
        edition=2,
    )(OmniscientController)
for _carrier in ("tank-ptz", "harbour-ptz"):
    register_controller(
        "omniscient",
        role="oracle",
        carrier=_carrier,
        summary="knows the target's path: what a controller could do at best",
    )(OmniscientHead)
