"""How the fish of a shoal swim: the parameters of ``scenarios.fish_tank.shoal``."""

from __future__ import annotations

from typing import NamedTuple


class Character(NamedTuple):
    """Parameters of swimming, alike for all fish of a shoal.

    Attributes:
        cruise_mps: speed that a fish without bursts settles at.
        mood_s, mood_spread: correlation time of a fish's activity, and standard deviation of its logarithm; it
            multiplies all speeds and the rate of bursts.
        burst_interval_s: mean time between the beginnings of two bursts of average activity; inf for no bursts.
        burst_mps, burst_spread: median speed at the end of a burst, and standard deviation of its logarithm.
        burst_s: duration of a burst.
        glide_s: time constant of the decay of speed to the cruising speed.
        turn_rad: scale of the turns at bursts, which have the heavy tails of a Student distribution.
        turn_s: duration of a turn.
        veer_radps, veer_s: standard deviation and correlation time of the rate of turn between bursts.
        wall_reach_m: distance at which a fish begins to turn away from the wall ahead.
        wall_follow: share in [0, 1] by which a fish within twice that distance turns along a wall at a burst.
        school: share in [0, 1] by which a fish turns to its mates and to their heading at a burst.
        align: weight of their heading; that of the direction to them is 1.
        school_reach_m: distance at which mates are seen.
        depth_s: mean time between changes of the wanted depth.
        glide_beat: amplitude of the tail beat between bursts, as a share of that in them.
        beat_hz: frequency of the tail beat at rest; it rises by 1.3 Hz for a body length per second,
            up to 9 Hz.
    """

    cruise_mps: float
    mood_s: float
    mood_spread: float
    burst_interval_s: float
    burst_mps: float
    burst_spread: float
    burst_s: float
    glide_s: float
    turn_rad: float
    turn_s: float
    veer_radps: float
    veer_s: float
    wall_reach_m: float
    wall_follow: float
    school: float
    align: float
    school_reach_m: float
    depth_s: float
    glide_beat: float
    beat_hz: float


ZEBRAFISH = Character(
    cruise_mps=0.02,
    mood_s=4.0,
    mood_spread=0.35,
    burst_interval_s=0.7,
    burst_mps=0.11,
    burst_spread=0.4,
    burst_s=0.15,
    glide_s=0.9,
    turn_rad=0.35,
    turn_s=0.2,
    veer_radps=0.25,
    veer_s=0.4,
    wall_reach_m=0.08,
    wall_follow=0.3,
    school=0.15,
    align=0.2,
    school_reach_m=0.3,
    depth_s=6.0,
    glide_beat=0.1,
    beat_hz=2.5,
)
"""A few zebrafish in a tank, one of the presets ``standard`` and ``quick``."""

CROWD = ZEBRAFISH._replace(burst_mps=0.08, school=0.2, school_reach_m=0.1)
"""A crowded tank."""

AYU = ZEBRAFISH._replace(
    cruise_mps=0.0038,
    mood_s=32.0,
    mood_spread=0.1,
    burst_interval_s=float("inf"),
    veer_radps=0.0125,
    veer_s=16.0,
    depth_s=float("inf"),
    glide_beat=0.35,
)
"""One fish that keeps its place against a slow current."""
