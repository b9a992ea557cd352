"""A play with simulated keys on a virtual screen."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from benchmarks.cli.main import main
from benchmarks.contract.rows import read_rows
from benchmarks.learning import playing
from benchmarks.learning.playing import action_of, play
from benchmarks.statistics.summary import write_summary
from scenarios import catalog
from scenarios.envs.follow_env import FollowEnv
from scenarios.envs.settings import FollowSettings
from scenarios.fish_tank.scenario import HEAD as TANK_HEAD
from scenarios.harbour.scenario import HEAD as HARBOUR_HEAD
from scenarios.loop import Loop
from scenarios.road_town.flight import HELICOPTER
from scenarios.stereo_follow.robot import ROBOT
from tests.scenarios.envs.stand_in import IDS, stand_in  # noqa: F401


def test_keys_together_are_an_action() -> None:
    for carrier, keys, action in (
        (HELICOPTER, "", [0, 0, 0, 0]),
        (HELICOPTER, "w", [1, 0, 0, 0]),
        (HELICOPTER, "safe", [-1, -1, -1, -1]),
        (HELICOPTER, "wsd", [0, 1, 0, 0]),
        (ROBOT, "wa", [1, 1]),
        *((head, "jiu", [0.25, 0.25, 0.25]) for head in (TANK_HEAD, HARBOUR_HEAD)),
        *((head, "l", [-0.25, 0, 0]) for head in (TANK_HEAD, HARBOUR_HEAD)),
    ):
        np.testing.assert_array_equal(action_of(carrier, set(map(ord, keys))), action)


@pytest.mark.heavy
def test_a_second_camera_is_steered_through_its_outline(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The outline is in the first picture, and moves to the left while j is down."""
    pygame = pytest.importorskip("pygame")
    monkeypatch.setenv("SDL_VIDEODRIVER", "dummy")
    white: list[float] = []
    drawn = playing._picture

    def shown(loop: Loop, zoom: float) -> Any:
        picture, taken = drawn(loop, zoom), loop.frame.observation.image_rgb
        white.append(float(np.nonzero((picture != taken).any(axis=2))[1].mean()))
        return picture

    def pressed(self: FollowEnv, action: Any) -> Any:
        pygame.event.post(pygame.event.Event(pygame.KEYDOWN, key=ord("j")))
        if len(white) == 12:
            raise KeyboardInterrupt
        return step(self, action)

    step = FollowEnv.step
    monkeypatch.setattr(FollowEnv, "step", pressed)
    monkeypatch.setattr(playing, "_picture", shown)
    command = ["play", "frameout/FishTankFollow-v2", "--preset", "quick", "--seeds", "3", "--out", str(tmp_path)]
    assert main(command) == 130
    assert white[-1] < white[0] - 5


@pytest.mark.parametrize(
    ("env", "preset"), [("frameout/RoadTownFollow-v3", "standard"), ("frameout/HarbourFollow-v1", "patrol")]
)
def test_the_preset_is_the_env_s(env: str, preset: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    asked: list[FollowSettings] = []
    monkeypatch.setattr(playing, "check_screen", lambda: None)
    monkeypatch.setattr(playing, "play", lambda given, *_: asked.append(given) or 0)
    assert main(["play", env, "--out", str(tmp_path)]) == 0
    assert (asked[0].preset_name, asked[0].tracker) == (preset, catalog.envs()[env][1])


@pytest.mark.heavy
@pytest.mark.usefixtures("stand_in")
@pytest.mark.parametrize("key", ["w", ""])
def test_an_episode_is_played_and_scored_if_a_key_was_pressed(
    key: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    pygame = pytest.importorskip("pygame")
    monkeypatch.setenv("SDL_VIDEODRIVER", "dummy")
    shown: list[Any] = []
    step = FollowEnv.step

    def pressed(self: FollowEnv, action: Any) -> Any:
        if key and not shown:
            pygame.event.post(pygame.event.Event(pygame.KEYDOWN, key=ord(key)))
        shown.append(np.array(action))
        return step(self, action)

    monkeypatch.setattr(FollowEnv, "step", pressed)
    settings = FollowSettings(catalog.envs()[IDS[0]][0], "hold", preset="tiny")
    assert play(settings, range(3, 4), tmp_path) == len(key)
    # No command before the key is down; then ahead, at full speed.
    np.testing.assert_array_equal(shown[0], np.zeros(4))
    np.testing.assert_array_equal(shown[10], [len(key), 0, 0, 0])
    if not key:
        assert list(tmp_path.iterdir()) == []
        assert "note: episode 3 is not scored: no key was pressed" in capsys.readouterr().err
        return
    rows = read_rows(tmp_path)
    assert {(row["controller"], row["role"], row["seed"]) for row in rows} == {("human", "external", 3)}
    effort = next(row["value"] for row in rows if row["metric"] == "effort")
    assert effort == pytest.approx(0.5, abs=0.03)
    entries = write_summary(tmp_path)
    assert any(entry["metric"] == "time_in_view" and entry["controller"] == "human" for entry in entries)


def test_without_a_screen_nothing_is_played(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    pytest.importorskip("pygame")
    for name in ("DISPLAY", "WAYLAND_DISPLAY", "SDL_VIDEODRIVER"):
        monkeypatch.delenv(name, raising=False)
    assert main(["play", "--preset", "quick", "--seeds", "3:4", "--out", str(tmp_path)]) == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert err.startswith("error: display: expected a screen to open a window on")
    assert list(tmp_path.iterdir()) == []
