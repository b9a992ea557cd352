"""The cameras of the tank tell nothing of fish but by their pictures: changed futures change nothing else."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import closing, contextmanager
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from scenarios.fish_tank import scenario as tank_scenario
from scenarios.fish_tank.presets import PRESETS
from scenarios.fish_tank.scenario import FISH_TANK, FishTankEpisode
from scenarios.fish_tank.shoal import Swims, swim
from tests.scenarios.handed import (
    Handed,
    assert_at_rest,
    assert_found_out,
    assert_pictures_alone_change,
    handed_by,
)
from trackers.types import CameraCommand

SEED, FRAMES, CHANGED_FROM = 3, 6, 3
COMMANDS = [CameraCommand(pan_rad_s=0.8 * (-1) ** (k // 3), tilt_rad_s=0.3, zoom_per_s=0.4) for k in range(FRAMES)]


@contextmanager
def fish_elsewhere() -> Iterator[None]:
    """Let all fish swim on the other side of the tank's middle from a frame on."""

    def changed(*given: Any, **named: Any) -> Swims:
        swims = swim(*given, **named)
        swims.position_m[CHANGED_FROM:, :, :2] *= -1.0
        swims.yaw_rad[CHANGED_FROM:] += np.pi
        return swims

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(tank_scenario, "swim", changed)
        yield


def handed(name: str, closed_loop: bool) -> Handed:
    preset = replace(PRESETS[name], width_px=96, height_px=72, frame_count=FRAMES)
    with closing(FISH_TANK.episode(preset, SEED, closed_loop=closed_loop, truth="target")) as episode:
        return handed_by(episode, COMMANDS if closed_loop else [None] * FRAMES)


def with_and_without_the_change(name: str, closed_loop: bool) -> tuple[Handed, Handed]:
    with fish_elsewhere():
        other = handed(name, closed_loop)
    return handed(name, closed_loop), other


@pytest.mark.heavy
@pytest.mark.parametrize("closed_loop", [False, True])
@pytest.mark.parametrize("name", PRESETS)
def test_fish_change_pictures_from_then_on_and_nothing_else(name: str, closed_loop: bool) -> None:
    assert_pictures_alone_change(*with_and_without_the_change(name, closed_loop), CHANGED_FROM)


def test_a_camera_at_rest_is_measured_the_same_on_every_frame() -> None:
    assert_at_rest(handed("quick", closed_loop=False))


def test_a_head_that_knows_where_its_fish_is_is_found_out(monkeypatch: pytest.MonkeyPatch) -> None:
    own = FishTankEpisode._obey

    def told(self: FishTankEpisode, command: CameraCommand) -> None:
        own(self, command)
        away_m = self._objects._swims.position_m[self._frame + 1, 0] - self._head.T_world_camera[:3, 3]
        self._head.pan_rad = float(np.arctan2(-away_m[0], away_m[1]))

    monkeypatch.setattr(FishTankEpisode, "_obey", told)
    assert_found_out(*with_and_without_the_change("quick", closed_loop=True), CHANGED_FROM)
