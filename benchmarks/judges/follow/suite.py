"""The suite ``follow``: how well does a controller, steering by a tracker's estimate, keep the target in view?"""

from __future__ import annotations

from benchmarks.contract.suite import Metric, Scene, Suite, register_suite
from benchmarks.contract.tuning_episodes import TuningEpisodes
from benchmarks.judges import in_view, view_time
from benchmarks.judges.follow.events import COMPARED, EVENTS
from benchmarks.judges.follow.judge import FollowJudge
from benchmarks.judges.follow.metrics import following
from benchmarks.judges.follow.references import ORACLE
from benchmarks.judges.follow.row_meanings import ROW_MEANINGS
from benchmarks.judges.tracker_speed import SPEED

_WITHOUT_PICTURES = TuningEpisodes(seeds=range(64), fresh=8)
"""Without pictures episodes are cheap; those that check the best setting have pictures."""


def _share(name: str, summary: str) -> Metric:
    return Metric(name, summary, "fraction", "higher")


FOLLOW = Suite(
    name="follow",
    edition=2,
    summary="a controller steers the camera by a tracker's estimate: is the target kept in view?",
    scenes=(
        Scene("road-town", "frame-out", ("mosaic_graph_pf", "colour_pf"), tuned_on=_WITHOUT_PICTURES),
        Scene("stereo-follow", "stereo", ("stereo_people", "stereo_wb_shutter_gain"), tuned_on=_WITHOUT_PICTURES),
        Scene("fish-tank", "fish", ("shoal_chain", "ca_kalman"), tuned_on=TuningEpisodes("quick")),
        Scene(
            "harbour",
            "harbour",
            ("harbour_watch", "eigen_swarm"),
            preset="patrol",
            tuned_on=TuningEpisodes("patrol", range(300, 302)),
        ),
    ),
    preset="standard",
    quick_preset="quick",
    judge=FollowJudge,
    metrics=(
        *COMPARED,
        Metric("dat_cumulative_reward", "DAT_Benchmark: sum of tanh(4 p³)", "1", "higher"),
        _share("dat_tsr", "DAT_Benchmark: steps with the target's centre in the picture"),
        Metric(
            "episode_length_steps",
            "AD-VAT, UnrealZoo: steps until it was out of view for 2 simulated seconds, or to the end",
            "steps",
            "higher",
        ),
        _share(
            "sr_500",
            "AD-VAT, UnrealZoo: episodes of 500 steps, or shorter, never out of view for over 2 simulated s",
        ),
        _share("evt_success_rate", "EVT-Bench: episodes that end in the picture and within 3 m, never lost"),
        _share("evt_tracking_rate", "EVT-Bench: steps in the picture and within 3 m, none after a loss"),
        Metric(
            "evt_collision_rate", "EVT-Bench: episodes that end with the camera nearer than 0.5 m", "fraction", "lower"
        ),
        _share("in_view_tpr", 'OxUvA: frames in view on which the tracker says "in view" and is on the target'),
        _share("in_view_tnr", "OxUvA: frames with the target absent on which the tracker says so"),
        in_view.IN_VIEW_GM,
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
    events=EVENTS,
    silence="no estimate for its controller; only where the camera looks is scored",
    references=(ORACLE,),
    contestants=("controller", "tracker"),
    truth="target",
    definitions={
        view_time: ("time_seen", "time_in_view", "losses_per_minute"),
        following: ("centring_error", "effort", "jerkiness_per_s"),
        view_time.losses_per_minute: ("losses_per_minute",),
        view_time.Loss: ("losses_per_minute", "recovery_frames", "watched_frames", "rate_hz"),
        following.centring_error: ("centring_error",),
        following.effort: ("effort",),
        following.jerkiness_per_s: ("jerkiness_per_s",),
        following.is_on_other: ("wrong_target_rate",),
        following.dat_cumulative_reward: ("dat_cumulative_reward",),
        following.dat_tsr: ("dat_tsr",),
        following.episode_length_steps: ("episode_length_steps",),
        following.survives: ("sr_500",),
        following.person_following: ("evt_success_rate", "evt_tracking_rate", "evt_collision_rate"),
        in_view.present_and_absent: ("in_view_tpr", "in_view_tnr"),
        in_view.true_positive_rate: ("in_view_tpr",),
        in_view.true_negative_rate: ("in_view_tnr",),
    },
    row_meanings=ROW_MEANINGS,
)
register_suite(FOLLOW)
