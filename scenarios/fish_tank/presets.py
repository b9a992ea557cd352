"""Presets of ``fish-tank``."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Literal, NamedTuple

from scenarios.scenario import check_length, check_size
from sim.checks import check, check_types, check_within
from sim.meshes.fish import Species
from sim.shaders.water import Water
from sim.water_surface import Ripples


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
        wall_follow: factor by which a fish within four times that distance turns along a wall at a burst.
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
    cruise_mps=0.0085,
    mood_s=3.13,
    mood_spread=0.224,
    burst_interval_s=0.312,
    burst_mps=0.0745,
    burst_spread=0.679,
    burst_s=0.0783,
    glide_s=0.791,
    turn_rad=0.45,
    turn_s=0.146,
    veer_radps=1.5,
    veer_s=0.9,
    wall_reach_m=0.035,
    wall_follow=0.92,
    school=0.38,
    align=0.25,
    school_reach_m=0.172,
    depth_s=6.0,
    glide_beat=0.1,
    beat_hz=2.5,
)
"""A few zebrafish, for the presets ``standard`` and ``quick``.

Fitted on development seeds (ten fish, 900 frames at 30 Hz) to five real zebrafish: idTracker's tracks of the Tracktor
project's video (Sridhar, Roche and Gingins 2019), scaled so that the box of all positions is as wide as our tank and
taken as 30 frames a second. Fitted were the percentiles of speed, turns over 5 and 15 frames, autocorrelations of
heading, velocity and speed, straightness over 50, 100 and 200 frames, distances to the walls and between mates, and
the errors of holding the last position, of constant velocity and of a constant-acceleration Kalman filter over such
gaps: by a search of the sum of squared log ratios of these (differences of autocorrelations), and by hand at last.
Real fish keep nearer to the walls, and half of their turns over 5 frames are smaller than here.
"""

CROWD = ZEBRAFISH._replace(school=0.2, school_reach_m=0.1)
"""A crowded tank: the same fish, attracted less and by fewer mates."""

AYU = ZEBRAFISH._replace(
    cruise_mps=0.0025,
    mood_s=32.0,
    mood_spread=0.04,
    burst_interval_s=float("inf"),
    veer_radps=0.008,
    veer_s=16.0,
    wall_reach_m=0.12,
    depth_s=float("inf"),
    glide_beat=0.35,
)
"""One fish that keeps its depth and its place against a slow current, so that it drifts ahead by 2.5 mm a second.

Fitted by hand on development seeds 0 to 25: speed, steadiness and distance from walls are such that the paper's filter,
its noise of maximum likelihood, misses about as in paper C, by 0.60, 1.05 and 2.81 after 50, 100 and 200 lost frames,
in pixels of the overview's picture at 30 Hz, measured to the true place. It got 0.61, 1.23 and 3.54
(``frameout paper C --seeds 13:21``). Most of that is the detector's noise, about 0.24 px, which the filter carries
ahead, and turns at walls; the fish itself swims 4 px in 50 frames. The preset's still water and soft light are fitted
too, so that positions are about as precise as in the paper.
"""


_LONGEST_S = 3600.0


@dataclass(frozen=True, slots=True)
class FishTank:
    """Configuration of an episode.

    Attributes:
        summary: one line.
        frame_count, rate_hz: number of frames, and frames per second.
        width_px, height_px: of each picture; it always shows the whole tank.
        closed_loop: True if commands steer the second camera, False if it stays.
        fish: number of fish.
        variety: 0 for fish that look alike, 1 for differences of size, shade and pattern as in a mixed stock.
        character: how they swim.
        glare: how much of the water mirrors lamps, 0 to 1, see ``room_lights``.
        lamp: brightness of the lamp that throws sharp shadows and caustics, 0 to 1.
        ripples: of the surface. water: what is in it.
        species: of the fish, in turn: the first fish is of the first one.
        tank_m: length, width and depth of the water, as wide as long if the tank is round.
        tank_shape, floor: of the tank.
        leaves: number of leaves that float on the water and hide fish.
        lamps: "room" for two tubes, a skylight and a lamp; "varied" for one to four tubes or panels and up to three
            lamps anywhere around the tank, warm to cold.
        glare_edge: of what the water mirrors, see ``smooth_glare`` of ``WaterShader``.
    """

    summary: str
    frame_count: int = 900
    rate_hz: float = 30.0
    width_px: int = 640
    height_px: int = 480
    closed_loop: bool = False
    fish: int = 10
    variety: float = 0.6
    character: Character = ZEBRAFISH
    glare: float = 0.4
    lamp: float = 1.0
    ripples: Ripples = field(default_factory=Ripples)
    water: Water = field(default_factory=Water)
    species: tuple[Species, ...] = ("zebrafish",)
    tank_m: tuple[float, float, float] = (0.60, 0.42, 0.12)
    tank_shape: Literal["rectangle", "round"] = "rectangle"
    floor: Literal["plain", "gravel", "sand"] = "plain"
    leaves: int = 0
    lamps: Literal["room", "varied"] = "room"
    glare_edge: Literal["sharp", "smooth"] = "sharp"

    def __post_init__(self) -> None:
        check_types(self)
        check_size(self)
        check_length(self, _LONGEST_S)
        check_within(self, "fish", 1, 150)
        check_within(self, "variety glare lamp", 0, 1)
        check("species", len(self.species) > 0, "one at least", self.species)
        check_within(self, "leaves", 0, 200)
        length_m, width_m, depth_m = self.tank_m
        good = 0.2 <= width_m <= length_m <= 2.0 and 0.06 <= depth_m <= 0.5
        check(
            "tank_m",
            good,
            "length and width within [0.2, 2], the length greater, depth within [0.06, 0.5]",
            self.tank_m,
        )
        is_square = self.tank_shape == "rectangle" or length_m == width_m
        check("tank_m", is_square, "a round tank's length and width alike", self.tank_m)


PRESETS = {
    "standard": FishTank("ten zebrafish in clear, rippled water"),
    "hard": FishTank(
        "a hundred fish that look alike in murky water",
        frame_count=450,
        fish=100,
        variety=0.1,
        character=CROWD,
        glare=1.0,
        ripples=Ripples(slope_rms=0.03),
        water=Water(scattering_per_m=6.0),
    ),
    "quick": FishTank("five fish in small pictures", frame_count=200, width_px=320, height_px=240, fish=5),
    "paper-c": FishTank(
        "the paper's experiment: one slow fish in still water under soft light",
        fish=1,
        character=AYU,
        glare=0.0,
        lamp=0.0,
        ripples=Ripples(slope_rms=0.003),
    ),
}

VARIED = {
    "mixed": replace(
        PRESETS["standard"],
        summary="zebrafish, tetras, guppies and barbs over gravel, under other lamps and floating leaves",
        fish=16,
        species=("zebrafish", "tetra", "guppy", "barb"),
        floor="gravel",
        leaves=14,
        lamps="varied",
        glare_edge="smooth",
    ),
    "round": replace(
        PRESETS["standard"],
        summary="two species in a round tank with a floor of sand",
        fish=12,
        species=("zebrafish", "barb"),
        tank_m=(0.5, 0.5, 0.15),
        tank_shape="round",
        floor="sand",
        lamps="varied",
        glare_edge="smooth",
    ),
}
"""Presets with more variety than those of the tables."""
PRESETS |= VARIED
