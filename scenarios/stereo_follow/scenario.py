"""The scenario ``stereo-follow``: a person among others, followed by a robot with a stereo camera."""

from __future__ import annotations

from scenarios.scenario import KeptWorld, Scenario, Setup
from scenarios.stereo_follow.crowd import KINDS
from scenarios.stereo_follow.episode import StereoFollowEpisode
from scenarios.stereo_follow.lighting import LitBuilding, build
from scenarios.stereo_follow.pictureless.bank import StereoPictureless
from scenarios.stereo_follow.plan import building_of
from scenarios.stereo_follow.presets import PRESETS
from scenarios.stereo_follow.robot import ROBOT
from scenarios.stereo_follow.truth import PeopleTruth
from sim.world import World


def keep_building(setup: Setup) -> KeptWorld:
    """Build the building of an episode, and its light."""
    building, world = building_of(setup.seed), World()
    baked = build(world, building)
    return KeptWorld(world, len(world.bodies), LitBuilding(building, baked))


STEREO_FOLLOW = Scenario(
    id="stereo-follow-v2",
    summary="a person among others, followed by a robot with a stereo camera from corridor to yard",
    start="the first pair and the person's box in the left picture; the camera's settings; odometry",
    stage=StereoFollowEpisode,
    presets=PRESETS,
    classes=dict.fromkeys(KINDS, "person"),
    carrier=ROBOT,
    truth=PeopleTruth,
    pictureless=StereoPictureless(),
    new_world=keep_building,
)
