"""Configuration of ``road-town``, and its presets."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any, Literal

from scenarios.road_town.blocks import BUILDING_SIDES_M
from scenarios.road_town.patterns import SMALLEST_EXTENT_M, STREET_PATTERNS
from scenarios.road_town.swing_geometry import PEAK_SPEED, SHORT_OF_NADIR_RAD
from scenarios.scenario import MOST_FRAMES, check_length, check_size
from sim.checks import check, check_types, check_within
from sim.meshes.file import check_models, mesh_of_file
from sim.meshes.vehicle import CARS, VEHICLES, vehicle

SETTLE_FRAMES = 25
"""Shortest time that the target is whole in the picture at both ends and between frame-outs."""
APART_FRAMES = SETTLE_FRAMES + 14
"""Shortest time from the end of a frame-out to the start of the next: the car also crosses the border twice."""
OVERHANG_FRAMES = 10
"""A frame-out may be nearer to either end of the episode by this much."""
OUT_FROM_SHARE = 0.65
"""Share of a swing's rise after which a centred car is out; it is back at the same share before the end of the fall."""
FASTEST_TURN_RAD_S = math.radians(90.0)
"""No gust of a preset with ``build_up_s`` turns a steered helicopter faster about any axis, nor do short ones."""
CALM_FRAMES = 5
"""Shortest time without a gust between two that build up."""
LARGEST_EXTENT_M = 1600.0
"""A town has a shorter side than this."""
ALTITUDE_RANGE_M = (40.0, 100.0)
"""Heights between which the helicopter flies."""
MOST_CARS = 60
"""The smallest town that is shipped has room for as many."""
_LONGEST_S = 3600.0


@dataclass(frozen=True)
class EgoErrors:
    """Errors of the instruments on board.

    Attributes:
        position_noise_m, position_bias_m: standard deviations, per axis; the bias is drawn once an episode.
        attitude_noise_deg, attitude_bias_deg: likewise, for roll, pitch and yaw.
    """

    position_noise_m: float = 0.05
    position_bias_m: float = 1.0
    attitude_noise_deg: float = 0.1
    attitude_bias_deg: float = 0.5

    def __post_init__(self) -> None:
        check_types(self)
        check_within(self, "position_noise_m position_bias_m", 0, 1000)
        check_within(self, "attitude_noise_deg attitude_bias_deg", 0, 90)


@dataclass(frozen=True)
class FrameOuts:
    """Frame-outs of the target.

    Attributes:
        count: range of the number per episode, both ends included; 0 = none.
        frames: range of their lengths, drawn log-uniformly.
        excursion_frames: shortest length of one that hides an excursion: the car is then well off the road.
        turn_share: share that is placed over a turn at a crossing, where the route has one.
        start_frame: frame of the first one, or None for a random time.
        aim: direction of the camera meanwhile: ``any``, or ``ahead`` of the car.
        gusts_only: False allows long ones by drift of the helicopter; True (and always in closed loop) makes all of
            them gusts that tilt it.
        build_up_s: range of the time in which a gust builds up in closed loop, and of that in which it dies away;
            shorter where the frame-out or the calm around it leaves less. Short ones are sudden. None: all are as
            sudden as on a set path, so the car is lost whoever steers.
    """

    count: tuple[int, int] = (2, 4)
    frames: tuple[int, int] = (5, 120)
    excursion_frames: int = 25
    turn_share: float = 0.5
    start_frame: int | None = None
    aim: Literal["any", "ahead"] = "any"
    gusts_only: bool = False
    build_up_s: tuple[float, float] | None = (1.5, 3.0)

    def __post_init__(self) -> None:
        check_types(self)
        check_within(self, "count", 0, 1000)
        check_within(self, "frames", 1, MOST_FRAMES)
        check_within(self, "excursion_frames", 0, MOST_FRAMES)
        if self.build_up_s is not None:
            check_within(self, "build_up_s", 0, 60, above=True)
        check_within(self, "turn_share", 0, 1)
        earliest = APART_FRAMES - OVERHANG_FRAMES
        good = self.start_frame is None or self.start_frame >= earliest
        check("start_frame", good, f"None or at least {earliest}", self.start_frame)

    def evenly(self, frame_count: int, apart_frames: int) -> list[tuple[int, int]]:
        """Return the fewest and shortest, (first frame out, frames out), spread over an episode.

        Args:
            apart_frames: shortest time from the end of one to the start of the next.
        """
        count, frames = self.count[0], self.frames[0]
        first = APART_FRAMES - OVERHANG_FRAMES if self.start_frame is None else self.start_frame
        spare = max(frame_count - self.fewest_frames(apart_frames), 0)
        before = [0 if self.start_frame is not None else spare * (k + 1) // (count + 1) for k in range(count)]
        return [(first + before[k] + k * (frames + apart_frames), frames) for k in range(count)]

    def fewest_frames(self, apart_frames: int) -> int:
        """Return the length of the shortest episode that can contain them, see ``evenly``."""
        count = self.count[0]
        if count == 0:
            return 1
        ends = APART_FRAMES - OVERHANG_FRAMES
        first = ends if self.start_frame is None else self.start_frame
        return first + count * self.frames[0] + (count - 1) * apart_frames + ends


@dataclass(frozen=True)
class RoadTown:
    """One configuration of the scenario.

    Attributes:
        summary: one line for ``frameout list``.
        width_px, height_px: of each picture. field_of_view_deg: of the camera, horizontal.
        rate_hz: frames per second. frame_count: length of an episode.
        street_patterns: one is drawn per episode.
        extent_m: side of the town.
        buildings: ``plain``, or ``varied`` in form, roofing and windows.
        gardens: ``painted``, or ``grown``: hedges, shrubs, fences and bins stand in them.
        signs: range of the number of signs in the town.
        overpasses: range of the number of bridges and covers over streets, where the target drives if there is room.
        people, cyclists: ranges of their numbers; they keep to the pavements and cross where no car comes.
        traffic_cars: number of moving cars besides the target, up to 60; a small town may have room for fewer.
        traffic_looks: ``others`` = any model and any paint but the target's; ``twins`` = half of them have the target's
            model and paint.
        vehicles: models of which traffic, target and parked cars are; one that is named twice drives twice as often.
            Shares of kinds: ``fleet.SHARES``.
        target_vehicle: the target's model, or ``any`` of these.
        traffic_keeps_apart: whether no two bodies ever touch, see ``kept_apart``; always so where others than cars
            drive. Else all count as 4.8 m long, and they keep apart on most crossings.
        building_models: ``house``, and files of others, each as often. Wherever a vehicle's model is named a file may
            stand too, see ``sim.meshes.file``.
        cruise_mps: range of the target's speed on a free straight.
        turn_preference: weight of turning against going straight on at a crossing.
        start_before_bend: whether the target starts shortly before the sharpest bend of its route.
        stop_share: share of crossings where a car halts first.
        starts_at_turn: whether the target starts in closed loop from rest, close to its first turn. A camera at rest
            then keeps it for longer than one that is steered at random.
        traffic_side: side of the street on which cars drive.
        driver: model of all drivers' speeds: ``idm`` = ``traffic``, ``gipps`` = ``gipps``.
        excursions: range of the number of excursions off the road per episode, both ends included.
        altitude_m: range of the height above the ground at the start, within [40, 100], between which it flies.
        attitude_noise_deg: standard deviation of roll and pitch; yaw has 1.5 times that.
        camera_pitch_deg: range of the angle by which the camera is pitched forward from straight down; 0, or so much
            that a gust can swing the view off the car.
        frame_outs: see ``FrameOuts``.
        sun_elevation_deg: range; below 0 it is dusk or night, with the lights of cars on, and the street lamps.
        weather: ``clear``, ``overcast``, ``rain``, ``fog`` or ``snow`` that falls.
        fog_visibility_m: range of the meteorological visibility in fog.
        rain_mm_h: range of the rate of rain. Wet surfaces are darker and mirror; drops stay on the camera's window.
        snow_cover: range of the amount of snow on the ground, 0 to 1, in any weather.
        season: of leaves, lawns and fields: ``summer``, ``autumn``, ``winter`` or ``spring``.
        lamp_posts: whether street lamps stand along the streets; where the sun is below 0 they do.
        smooth_edges: whether edges in pictures are without stairs, see ``sim.render.smooth_edges``.
        ego: errors of the measured pose, or None for no instruments.
        closed_loop: whether a controller steers the camera by default.
    """

    summary: str
    width_px: int = 640
    height_px: int = 480
    field_of_view_deg: float = 50.0
    rate_hz: float = 15.0
    frame_count: int = 300
    street_patterns: tuple[str, ...] = ("grid", "organic", "ring")
    extent_m: float = 420.0
    buildings: Literal["plain", "varied"] = "plain"
    gardens: Literal["painted", "grown"] = "painted"
    signs: tuple[int, int] = (0, 0)
    overpasses: tuple[int, int] = (0, 0)
    people: tuple[int, int] = (0, 0)
    cyclists: tuple[int, int] = (0, 0)
    traffic_cars: int = 16
    traffic_looks: Literal["others", "twins"] = "others"
    vehicles: tuple[str, ...] = CARS
    target_vehicle: str = "any"
    traffic_keeps_apart: bool = False
    building_models: tuple[str, ...] = ("house",)
    cruise_mps: tuple[float, float] = (7.0, 12.0)
    turn_preference: float = 1.0
    start_before_bend: bool = False
    stop_share: float = 0.25
    starts_at_turn: bool = False
    traffic_side: Literal["right", "left"] = "right"
    driver: Literal["idm", "gipps"] = "idm"
    excursions: tuple[int, int] = (0, 1)
    altitude_m: tuple[float, float] = (50.0, 80.0)
    attitude_noise_deg: float = 1.5
    camera_pitch_deg: tuple[float, float] = (0.0, 0.0)
    frame_outs: FrameOuts = FrameOuts()
    sun_elevation_deg: tuple[float, float] = (35.0, 65.0)
    ego: EgoErrors | None = EgoErrors()
    closed_loop: bool = False
    weather: Literal["clear", "overcast", "rain", "fog", "snow"] = "clear"
    fog_visibility_m: tuple[float, float] = (150.0, 400.0)
    rain_mm_h: tuple[float, float] = (2.0, 12.0)
    snow_cover: tuple[float, float] = (0.0, 0.0)
    season: Literal["summer", "autumn", "winter", "spring"] = "summer"
    lamp_posts: bool = False
    smooth_edges: bool = False

    def __post_init__(self) -> None:
        check_types(self)
        check_size(self)
        self.check_room(self.closed_loop)
        check_length(self, _LONGEST_S)
        check_within(self, "field_of_view_deg", 10, 120)
        check_within(self, "cruise_mps", 0, 60, above=True)
        check_within(self, "turn_preference", 0, 1e6, above=True)
        check_within(self, "altitude_m", *ALTITUDE_RANGE_M)
        check_within(self, "traffic_cars", 0, MOST_CARS)
        check_within(self, "excursions", 0, 10)
        check_within(self, "signs", 0, 1000)
        check_within(self, "overpasses", 0, 8)
        check_within(self, "people", 0, 200)
        check_within(self, "cyclists", 0, 50)
        check_within(self, "attitude_noise_deg", 0, 30)
        check_within(self, "stop_share", 0, 1)
        check_within(self, "camera_pitch_deg", 0, 60)
        check_within(self, "sun_elevation_deg", -90, 90)
        check_within(self, "fog_visibility_m", 20, 1e6)
        check_within(self, "rain_mm_h", 0, 100)
        check_within(self, "snow_cover", 0, 1)
        good = SMALLEST_EXTENT_M <= self.extent_m < LARGEST_EXTENT_M
        check("extent_m", good, f"a number in [{SMALLEST_EXTENT_M:g}, {LARGEST_EXTENT_M:g})", self.extent_m)
        known = f"some of {', '.join(STREET_PATTERNS)}"
        patterns = set(self.street_patterns)
        check("street_patterns", bool(patterns) and patterns <= set(STREET_PATTERNS), known, self.street_patterns)
        check_models("vehicles", self.vehicles, VEHICLES, lambda file: vehicle(file, (0, 0, 0)))
        target = (self.target_vehicle,)
        check_models("target_vehicle", target, ("any", *VEHICLES), lambda file: vehicle(file, (0, 0, 0)))
        buildings = self.building_models
        check_models("building_models", buildings, ("house",), lambda file: mesh_of_file(file, BUILDING_SIDES_M))
        low, high = self.camera_pitch_deg
        wanted = f"0, or angles of which gusts can make use: above {self._least_pitch_deg:.1f}"
        check("camera_pitch_deg", high == 0 or low > self._least_pitch_deg, wanted, self.camera_pitch_deg)

    def check_room(self, closed_loop: bool) -> None:
        """Raise ValueError if no episode is long enough for the frame-outs, which take longer in closed loop."""
        fewest = self.frame_outs.fewest_frames(self.apart_frames(closed_loop))
        loop = " in closed loop" if closed_loop else ""
        wanted = f"at least {fewest} for {self.frame_outs.count[0]} or more frame-outs{loop}"
        check("frame_count", self.frame_count >= fewest, wanted, self.frame_count)

    def apart_frames(self, closed_loop: bool) -> int:
        """Return the shortest time from the end of a frame-out to the start of the next that the shortest ones need.

        Gusts that build up are in each other's way where the quickest ones last for longer than their frame-outs.
        """
        if not closed_loop or self.frame_outs.build_up_s is None:
            return APART_FRAMES
        # No gust turns the helicopter by more than a right angle.
        slope = math.ceil(PEAK_SPEED * 0.5 * math.pi / FASTEST_TURN_RAD_S * self.rate_hz)
        frames = self.frame_outs.frames[0]
        hold = max(frames - round((1 - OUT_FROM_SHARE) * 2 * slope), 1)
        delay = max(math.ceil(OUT_FROM_SHARE * slope) - (APART_FRAMES - OVERHANG_FRAMES), 0)
        return max(APART_FRAMES, 2 * slope + hold - frames + CALM_FRAMES + delay)

    @property
    def keeps_apart(self) -> bool:
        """Whether bodies of vehicles never touch, see ``traffic_keeps_apart``."""
        return self.traffic_keeps_apart or not {*self.vehicles, self.target_vehicle} <= {"any", *CARS}

    @property
    def has_lamp_posts(self) -> bool:
        """Whether street lamps stand in its towns."""
        return self.lamp_posts or self.sun_elevation_deg[0] < 0.0

    @property
    def _least_pitch_deg(self) -> float:
        """Pitch at which the widest gust, down or aside, moves the middle of the picture just to the border."""
        half_width = math.tan(0.5 * math.radians(self.field_of_view_deg))
        down_rad = math.atan(half_width * self.height_px / self.width_px) + SHORT_OF_NADIR_RAD
        # After a yaw by a right angle the middle is seen at the tangent sin(a) / cos(a)^2 = half_width.
        aside_rad = math.asin((math.hypot(1.0, 2.0 * half_width) - 1.0) / (2.0 * half_width))
        return math.degrees(max(down_rad, aside_rad))


STANDARD = RoadTown("the benchmark: towns, traffic, two to four frame-outs of 5 to 120 frames")

PRESETS: dict[str, RoadTown] = {
    "paper-a2": RoadTown(
        "paper A, experiment 1: one winding road, closed loop, a gust while the car rounds a bend",
        width_px=320,
        height_px=240,
        frame_count=110,
        street_patterns=("winding",),
        traffic_cars=4,
        cruise_mps=(9.5, 11.0),
        turn_preference=0.01,
        start_before_bend=True,
        stop_share=0.0,
        excursions=(0, 0),
        # From high up through a long lens the picture moves almost rigidly, as the paper's motion model assumes.
        field_of_view_deg=24.0,
        altitude_m=(90.0, 99.0),
        attitude_noise_deg=0.4,
        frame_outs=FrameOuts(
            count=(1, 1), frames=(24, 28), turn_share=1.0, start_frame=48, aim="ahead", build_up_s=None
        ),
        ego=EgoErrors(0.0, 0.0, 0.0, 0.0),
        closed_loop=True,
    ),
    "paper-a3": RoadTown(
        "paper A, experiment 2: a town with crossings and traffic, set paths, motion not measured",
        width_px=320,
        height_px=240,
        frame_count=200,
        street_patterns=("grid", "organic"),
        traffic_cars=10,
        cruise_mps=(7.0, 10.0),
        # Cars go straight over crossings where possible: the paper's road is one curve without branches, along which
        # the car leaves the picture. The paper does not treat turns while the car is out of view.
        turn_preference=0.0001,
        stop_share=0.0,
        excursions=(1, 1),
        field_of_view_deg=26.0,
        altitude_m=(88.0, 99.0),
        attitude_noise_deg=0.4,
        # On the road and off it the same lengths, so that they do not decide between the two: longer than the car needs
        # to leave the road.
        frame_outs=FrameOuts(count=(2, 2), frames=(15, 30), excursion_frames=15, turn_share=0.0, gusts_only=True),
        ego=None,
    ),
    "standard": STANDARD,
    "hard": replace(
        STANDARD,
        summary="twins of the target in the traffic, low sun, rough air, more ways off the road",
        traffic_cars=24,
        traffic_looks="twins",
        excursions=(1, 2),
        attitude_noise_deg=3.0,
        sun_elevation_deg=(12.0, 25.0),
    ),
    "quick": replace(
        STANDARD,
        summary="small and short, to try things out: one long frame-out, mostly while the car turns",
        width_px=320,
        height_px=240,
        frame_count=150,
        cruise_mps=(9.0, 13.0),
        turn_preference=20.0,
        stop_share=0.1,
        starts_at_turn=True,
        excursions=(0, 0),
        frame_outs=FrameOuts(count=(1, 1), frames=(25, 60), turn_share=0.9, build_up_s=(0.8, 1.6)),
    ),
    "oblique": replace(
        STANDARD,
        summary="the camera looks ahead and down, from behind the car: houses and trees may hide it",
        camera_pitch_deg=(35.0, 50.0),
    ),
}
ABLATIONS: dict[str, RoadTown] = {
    "standard-left-hand": replace(STANDARD, summary="standard, but cars drive on the left", traffic_side="left"),
    "standard-gipps": replace(STANDARD, summary="standard, with another model of drivers (Gipps 1981)", driver="gipps"),
    "standard-slow": replace(STANDARD, summary="standard, with cars that drive 30 % slower", cruise_mps=(4.9, 8.4)),
    "standard-fast": replace(STANDARD, summary="standard, with cars that drive 30 % faster", cruise_mps=(9.1, 15.6)),
    "standard-other-town": replace(
        STANDARD, summary="standard, with winding streets, a pattern that it lacks", street_patterns=("winding",)
    ),
}
"""Further presets: ``standard`` with one assumption of a tracker violated in each."""

_LIVELY: dict[str, Any] = {
    "buildings": "varied",
    "gardens": "grown",
    "signs": (40, 60),
    "people": (24, 40),
    "cyclists": (3, 6),
    "traffic_keeps_apart": True,
    "smooth_edges": True,
}
LIVELY = replace(STANDARD, summary="people, cyclists, signs, gardens, houses of many kinds; smooth edges", **_LIVELY)
NEXT_PRESETS: dict[str, RoadTown] = {
    "standard": LIVELY,
    **{name: replace(PRESETS[name], **_LIVELY) for name in ("hard", "quick", "oblique")},
    "mixed-traffic": replace(
        LIVELY,
        summary="lorries, buses and motorbikes too, more of them",
        traffic_cars=24,
        vehicles=tuple(VEHICLES),
    ),
    "bridges": replace(LIVELY, summary="bridges and covers that hide the car in the picture", overpasses=(2, 4)),
    "night": replace(
        LIVELY,
        summary="after sunset: street lamps, headlights, a camera that sees little light",
        sun_elevation_deg=(-18.0, -7.0),
    ),
    "rain": replace(LIVELY, summary="rain: wet streets, drops on the camera's window", weather="rain"),
    "fog": replace(LIVELY, summary="fog of 150 to 400 m visibility", weather="fog"),
    "snow": replace(
        LIVELY,
        summary="winter, under snow that still falls",
        weather="snow",
        season="winter",
        snow_cover=(0.6, 1.0),
    ),
    "autumn": replace(LIVELY, summary="autumn, under a low sun", season="autumn", sun_elevation_deg=(14.0, 30.0)),
}
"""Presets of the next edition, ``road-town-v3``."""
