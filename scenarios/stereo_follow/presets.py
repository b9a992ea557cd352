"""Presets of ``stereo-follow``."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Literal

from scenarios.scenario import check_length, check_size
from sim.checks import check_types, check_within
from sim.meshes.file import check_models, mesh_of_file

NOTHING = "nothing"
CARRIED_SIDES_M = (0.05, 1.2)
"""Longest side of what people carry."""
LEAST_LEG_M = 0.7
"""Shortest straight piece of the target's path."""
_LONGEST_S = 60.0
"""A path through the building goes on for as long, whatever the lengths of its pieces."""


@dataclass(frozen=True, slots=True)
class StereoFollow:
    """Configuration of an episode. Numbers of people are upper limits: a person without a free path is left out.

    Attributes:
        summary: one line.
        frame_count, rate_hz: number of frames, and frames per second.
        width_px, height_px: of each picture.
        closed_loop: True if commands drive the robot, False if it is driven by hand.
        crossers: people who cross between robot and target, and hide the target for a moment.
        oncomers: people who walk the target's path in the opposite direction and pass close by the robot.
        followers: people who walk close behind the target and change sides.
        walkers: people on paths of their own.
        standers: people who stand beside the target's path.
        alike: number of others with a top of the target's colour; the first of them also has the trousers' colour.
        uniformed: number of others in the same working clothes as the target; 0: no one wears working clothes.
        people_builds: "one" for adults of one figure; "many" for women, men and children of different figures, with
            more kinds of hair, headwear, coats, skirts and bags. Who is dressed alike remains so.
        hand_models: what people have in the right hand, each as often: ``nothing``, or files of meshes, see
            ``sim.meshes.file``. back_models: likewise on the back, in place of a backpack. Both are parts of the person
            in truth.
        carriers: who carries something: all, the target alone, or all others.
        place: "building" for corridor, hall and yard; "outdoors" for a square between the houses of a town.
        rooms: "bare", or "furnished" with desks in the middle of the hall, which all walk around, and with cabinets,
            shelves, plants, radiators and pictures along the walls.
        pauses: number of times that the target stands still.
        leg_m, corner_deg: least and largest length of a straight piece of the target's path in a room, and angle
            between two pieces.
        stays: share of the pieces after which the target stays in the room.
        lamp_events: number of times that a room's lights are switched. clouds: number of clouds before the sun.
        lamps_off_s, cloud_s: shortest and longest time that lamps are off, and that a cloud stays.
        lamps_left_on: smallest and largest share of a room's lamps that stay on, so that brightness changes more than
            colour.
        cloud_edge_s: standard deviation of the smoothing of a cloud's start and end.
        sky_behind_cloud: remaining share of the light of sky and windows under a cloud, in (0, 1].
        brightening_s: time in which returning light grows by at most a factor of e, as lamps warm up and haze clears;
            0: light returns at once.
        dropped_share: share of pairs whose right picture is lost, in [0, 1].
        odometry: whether the robot has odometry.
        smooth_edges: whether edges in pictures are without stairs, see ``sim.render.smooth_edges``.
    """

    summary: str
    frame_count: int = 300
    rate_hz: float = 15.0
    width_px: int = 640
    height_px: int = 480
    closed_loop: bool = False
    crossers: int = 3
    oncomers: int = 1
    followers: int = 1
    walkers: int = 2
    standers: int = 1
    alike: int = 1
    uniformed: int = 0
    pauses: int = 1
    leg_m: tuple[float, float] = (2.0, 7.0)
    corner_deg: tuple[float, float] = (0.0, 100.0)
    stays: float = 0.4
    lamp_events: int = 1
    clouds: int = 1
    lamps_off_s: tuple[float, float] = (2.5, 8.0)
    cloud_s: tuple[float, float] = (3.0, 10.0)
    lamps_left_on: tuple[float, float] = (0.02, 0.3)
    cloud_edge_s: float = 0.8
    sky_behind_cloud: float = 0.7
    brightening_s: float = 0.0
    dropped_share: float = 0.0
    odometry: bool = True
    people_builds: Literal["one", "many"] = "one"
    place: Literal["building", "outdoors"] = "building"
    rooms: Literal["bare", "furnished"] = "bare"
    smooth_edges: bool = False
    hand_models: tuple[str, ...] = (NOTHING,)
    back_models: tuple[str, ...] = (NOTHING,)
    carriers: Literal["all", "target", "others"] = "all"

    def __post_init__(self) -> None:
        check_types(self)
        check_size(self)
        check_length(self, _LONGEST_S)
        check_within(self, "crossers oncomers followers walkers standers", 0, 30)
        check_within(self, "alike uniformed pauses lamp_events clouds", 0, 100)
        check_within(self, "lamps_off_s cloud_s brightening_s", 0, 600)
        check_within(self, "cloud_edge_s", 0, 600, above=True)
        check_within(self, "corner_deg", 0, 100)
        # A path of shorter pieces hardly grows once its corners are rounded.
        check_within(self, "leg_m", LEAST_LEG_M, 100)
        check_within(self, "lamps_left_on stays dropped_share", 0, 1)
        check_within(self, "sky_behind_cloud", 0, 1, above=True)
        for field in ("hand_models", "back_models"):
            check_models(field, getattr(self, field), (NOTHING,), lambda file: mesh_of_file(file, CARRIED_SIDES_M))


PRESETS = {
    "standard": StereoFollow("a person among up to eight others, one dressed alike; lamps and clouds change"),
    "hard": StereoFollow(
        "more people, three of them dressed alike, lamps that go off and on, lost pictures",
        crossers=5,
        oncomers=2,
        followers=2,
        walkers=3,
        standers=2,
        alike=3,
        pauses=2,
        lamp_events=3,
        clouds=2,
        dropped_share=0.02,
    ),
    "quick": StereoFollow(
        "a short episode in small pictures; the person goes round corners",
        frame_count=60,
        width_px=320,
        height_px=240,
        crossers=1,
        pauses=0,
        leg_m=(1.4, 2.4),
        corner_deg=(60.0, 100.0),
        stays=0.9,
    ),
    "paper-b3": StereoFollow(
        "the paper's experiment: ten drives of 853 frames are its 8,530; all wear the same, light comes and goes",
        frame_count=853,
        crossers=2,
        oncomers=3,
        followers=0,
        walkers=4,
        standers=2,
        alike=0,
        uniformed=11,
        pauses=2,
        lamp_events=14,
        lamps_off_s=(0.3, 1.0),
        lamps_left_on=(0.2, 0.5),
        clouds=15,
        cloud_s=(0.3, 1.0),
        cloud_edge_s=0.25,
        sky_behind_cloud=0.3,
        brightening_s=3.0,
    ),
}
PRESETS["paper-b3-dressed-apart"] = replace(
    PRESETS["paper-b3"], summary="the same drives, but no one wears what the person who is followed wears", uniformed=0
)

VARIED = {
    "varied": replace(
        PRESETS["standard"],
        summary="people of many builds, hair and clothes in furnished rooms",
        people_builds="many",
        rooms="furnished",
        smooth_edges=True,
    ),
    "outdoors": replace(
        PRESETS["standard"],
        summary="people of many builds on a square between houses, in the sun, in shade and under clouds",
        people_builds="many",
        place="outdoors",
        walkers=4,
        standers=2,
        clouds=2,
        lamp_events=0,
        smooth_edges=True,
    ),
}
"""Presets with more variety than those of the tables."""
PRESETS |= VARIED
