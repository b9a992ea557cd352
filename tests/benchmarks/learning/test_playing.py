"""A play with simulated keys on a virtual screen."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from benchmarks.cli.main import main
from benchmarks.contract.rows import read_rows
from benchmarks.learning import playing
from benchmarks.learning.playing import Play, key_combinations, play
from benchmarks.statistics.summary import write_summary
from scenarios import catalog
from scenarios.envs.follow_env import FollowEnv
from scenarios.fish_tank.scenario import HEAD as TANK_HEAD
from scenarios.harbour.scenario import HEAD as HARBOUR_HEAD
from scenarios.road_town.flight import HELICOPTER
from scenarios.stereo_follow.robot import ROBOT
from tests.scenarios.envs.stand_in import IDS, stand_in  # noqa: F401


def test_keys_together_are_an_action() -> None:
    air, ground = dict(key_combinations(HELICOPTER)), dict(key_combinations(ROBOT))
    assert len(air) == 3**4 - 1
    np.testing.assert_array_equal(air["w"], [1, 0, 0, 0])
    np.testing.assert_array_equal(air["safe"], [-1, -1, -1, -1])
    assert len(ground) == 3**2 - 1
    np.testing.assert_array_equal(ground["wa"], [1, 1])
    for head in (TANK_HEAD, HARBOUR_HEAD):
        turned = dict(key_combinations(head))
        assert len(turned) == 3**3 - 1
        np.testing.assert_array_equal(turned["jiu"], [0.25, 0.25, 0.25])
        np.testing.assert_array_equal(turned["l"], [-0.25, 0, 0])


@pytest.mark.heavy
def test_a_second_camera_is_steered_through_its_outline(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The outline is in the first picture, and moves to the left while j is down."""
    pygame = pytest.importorskip("pygame")
    monkeypatch.setenv("SDL_VIDEODRIVER", "dummy")
    monkeypatch.setitem(FollowEnv.metadata, "render_fps", 10_000)
    white: list[float] = []
    render = playing._Recorded.render

    def shown(self: Any) -> Any:
        picture, taken = render(self), self._follow.episode.frame.observation.image_rgb
        white.append(float(np.nonzero((picture != taken).any(axis=2))[1].mean()))
        return picture

    def pressed(self: FollowEnv, action: Any) -> Any:
        pygame.event.post(pygame.event.Event(pygame.KEYDOWN, key=ord("j")))
        if len(white) == 12:
            raise KeyboardInterrupt
        return step(self, action)

    step = FollowEnv.step
    monkeypatch.setattr(FollowEnv, "step", pressed)
    monkeypatch.setattr(playing._Recorded, "render", shown)
    command = ["play", "frameout/FishTankFollow-v2", "--preset", "quick", "--seeds", "3", "--out", str(tmp_path)]
    assert main(command) == 130
    assert white[-1] < white[0] - 5


@pytest.mark.parametrize(
    ("env", "preset"), [("frameout/RoadTownFollow-v2", "standard"), ("frameout/HarbourFollow-v1", "patrol")]
)
def test_the_preset_is_the_env_s(env: str, preset: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    asked: list[Play] = []
    monkeypatch.setattr(playing, "check_screen", lambda: None)
    monkeypatch.setattr(playing, "play", lambda given: asked.append(given) or 0)
    assert main(["play", env, "--out", str(tmp_path)]) == 0
    assert (asked[0].preset, asked[0].tracker) == (preset, catalog.envs()[env][1])


@pytest.mark.heavy
@pytest.mark.usefixtures("stand_in")
def test_an_episode_is_played_and_scored(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    pygame = pytest.importorskip("pygame")
    monkeypatch.setenv("SDL_VIDEODRIVER", "dummy")
    # As fast as it goes, instead of as fast as a person plays.
    monkeypatch.setitem(FollowEnv.metadata, "render_fps", 10_000)
    shown: list[Any] = []
    step = FollowEnv.step

    def pressed(self: FollowEnv, action: Any) -> Any:
        if not shown:
            pygame.event.post(pygame.event.Event(pygame.KEYDOWN, key=ord("w")))
        shown.append(np.array(action))
        return step(self, action)

    monkeypatch.setattr(FollowEnv, "step", pressed)
    played = Play(IDS[0], "tiny", "hold", "prompt", range(3, 4), tmp_path)
    assert play(played) == 1
    rows = read_rows(tmp_path)
    assert {row["controller"] for row in rows} == {"human"}
    assert {row["role"] for row in rows} == {"external"}
    assert {row["seed"] for row in rows} == {3}
    # No command before the key is down; then ahead, at full speed.
    np.testing.assert_array_equal(shown[0], np.zeros(4))
    np.testing.assert_array_equal(shown[10], [1, 0, 0, 0])
    effort = next(row["value"] for row in rows if row["metric"] == "effort")
    assert effort == pytest.approx(0.5, abs=0.03)
    entries = write_summary(tmp_path)
    assert any(entry["metric"] == "time_in_view" and entry["controller"] == "human" for entry in entries)


@pytest.mark.heavy
@pytest.mark.usefixtures("stand_in")
def test_an_episode_without_a_key_pressed_is_not_scored(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    pytest.importorskip("pygame")
    monkeypatch.setenv("SDL_VIDEODRIVER", "dummy")
    monkeypatch.setitem(FollowEnv.metadata, "render_fps", 10_000)
    played = Play(IDS[0], "tiny", "hold", "prompt", range(3, 4), tmp_path)
    assert play(played) == 0
    assert list(tmp_path.iterdir()) == []
    assert "note: episode 3 is not scored: no key was pressed" in capsys.readouterr().err


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
