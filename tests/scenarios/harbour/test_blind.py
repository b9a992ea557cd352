"""The cameras of the harbour tell nothing of intruders but by their pictures: changed futures change nothing else."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import closing, contextmanager
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from scenarios.harbour.intruders import Intruders
from scenarios.harbour.presets import PRESETS
from scenarios.harbour.scenario import HARBOUR, HarbourEpisode
from tests.scenarios.handed import (
    Handed,
    assert_at_rest,
    assert_found_out,
    assert_pictures_alone_change,
    handed_by,
)
from trackers.types import CameraCommand

SEED, FRAMES, CHANGED_FROM, BACKGROUND = 3, 9, 5, 2
ALONG_M = 7.0
"""How far along the quay intruders are elsewhere."""
COMMANDS = [CameraCommand(pan_rad_s=0.3 * (-1) ** (k // 4), tilt_rad_s=-0.1, zoom_per_s=0.2) for k in range(FRAMES)]
MODES = [(name, False) for name in PRESETS] + [(name, True) for name in PRESETS if PRESETS[name].patrols]


@contextmanager
def intruders_elsewhere() -> Iterator[None]:
    """Let all intruders be elsewhere, and face the other way, from a frame on."""
    own = Intruders._plan_poses

    def changed(self: Intruders, *given: Any) -> None:
        own(self, *given)
        later = self.course[CHANGED_FROM:]
        later[..., 1, 3] += ALONG_M
        later[..., :2, :2] *= -1.0

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(Intruders, "_plan_poses", changed)
        yield


def handed(name: str, closed_loop: bool) -> Handed:
    preset = replace(PRESETS[name], background=BACKGROUND)
    with closing(HARBOUR.episode(preset, SEED, closed_loop=closed_loop, truth="target")) as episode:
        return handed_by(episode, COMMANDS if closed_loop else [None] * FRAMES)


def with_and_without_the_change(name: str, closed_loop: bool) -> tuple[Handed, Handed]:
    with intruders_elsewhere():
        other = handed(name, closed_loop)
    return handed(name, closed_loop), other


@pytest.mark.heavy
@pytest.mark.parametrize(("name", "closed_loop"), MODES)
def test_intruders_change_pictures_from_then_on_and_nothing_else(name: str, closed_loop: bool) -> None:
    assert_pictures_alone_change(*with_and_without_the_change(name, closed_loop), CHANGED_FROM)


def test_a_camera_at_rest_is_measured_the_same_on_every_frame() -> None:
    assert_at_rest(handed("quick", closed_loop=False))


@pytest.mark.heavy
def test_a_head_that_knows_where_its_target_is_is_found_out(monkeypatch: pytest.MonkeyPatch) -> None:
    own = HarbourEpisode._obey

    def told(self: HarbourEpisode, command: CameraCommand) -> None:
        own(self, command)
        target = self._objects.course[self._frame + 1, self._objects.names.index(HARBOUR.target), :3, 3]
        away_m = target - self._head.T_world_camera[:3, 3]
        self._head.pan_rad = float(np.arctan2(away_m[1], away_m[0]))

    monkeypatch.setattr(HarbourEpisode, "_obey", told)
    assert_found_out(*with_and_without_the_change("quick", closed_loop=True), CHANGED_FROM)
