"""The skeleton of an episode, with a scene of one ball that leaves the picture to the right."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from scenarios.objects import Labels, SceneObjects
from scenarios.scenario import Scenario, Setup
from scenarios.stage import SceneCamera, Stage
from scenarios.truth import check_truth
from sim.render.pipeline import Capture
from sim.rng import episode_seed
from sim.sensors.config import Picture, SensorSettings
from sim.world import World
from trackers.types import CameraCommand, CameraModel, Carrier

CAMERA = CameraModel(16, 12, 14.0)
FRAMES, RATE_HZ = 4, 10.0
AHEAD = CameraCommand(forward_mps=1.0)
PRESET = SimpleNamespace(frame_count=FRAMES, rate_hz=RATE_HZ, closed_loop=False)


class FakeCamera(SceneCamera):
    """Takes blank pictures."""

    def __init__(self) -> None:
        self.model = CAMERA

    def take(self, shader: Any, T_world_camera: NDArray[np.float64], frame: int, **exposing: Any) -> Capture[Any]:
        """See ``SceneCamera``."""
        picture = Picture(np.zeros((12, 16, 3), np.uint8), SensorSettings(0.01, 2.0))
        return Capture(picture, np.ones((12, 16), np.float32), np.zeros((12, 16), np.int32))

    def larger_view(self, shader: Any, T_world_camera: NDArray[np.float64], scale: float) -> Any:
        """See ``SceneCamera``."""
        return shader, T_world_camera.copy(), scale


class Ball(SceneObjects):
    """A ball on its way out of the picture, with a place on each frame."""

    def __init__(self) -> None:
        body: Any = SimpleNamespace(index=7)
        super().__init__(World(), [[body]], ["ball"], ["ball"], np.ones((1, 3)))

    def bounds_m(self) -> NDArray[np.float64]:
        """See ``SceneObjects``."""
        return np.zeros((1, 2, 3))

    def labels(self, camera: Any, T_world_camera: Any, seen: Any = None, in_full: Any = None) -> Labels:
        """See ``SceneObjects``."""
        right_px = 4.0 * self.T_world_object[0, 0, 3]
        box = np.array([[8.0, 4.0, 12.0, 8.0]]) + np.array([1.0, 0.0, 1.0, 0.0]) * right_px
        centres_px = self._centres_px(camera, T_world_camera)
        return Labels(centres_px, box, np.array([0.4]), np.array([-1]), np.zeros(1))


class BallStage(Stage):
    """Records its calls."""

    def __init__(self, setup: Setup) -> None:
        self.done: list[Any] = []
        self._shader: Any = "shader"
        super().__init__(setup, Ball(), FakeCamera())
        assert self.done == ["move to 0"]
        self.done.clear()

    def _obey(self, command: CameraCommand) -> None:
        self.done.append(command)

    def _move_to(self, frame: int) -> None:
        self.done.append(f"move to {frame}")
        self._objects.T_world_object[0, :3, 3] = frame, 0.0, 5.0
        self._T_world_camera = np.eye(4)

    def _capture(self, frame: int) -> Capture[Any]:
        self.done.append(f"take {frame}")
        return super()._capture(frame)


BALL = Scenario(
    "ball-v1", "a ball", "", BallStage, {"only": PRESET}, {"ball": "ball"}, Carrier("", (), "down"), target="ball"
)


def ball(closed_loop: bool) -> BallStage:
    """Return an episode."""
    return BALL.episode("only", 0, closed_loop=closed_loop)


def test_on_a_set_path_it_moves_and_takes_frame_after_frame_until_the_last() -> None:
    stage = ball(closed_loop=False)
    assert [stage.step().truth.frame for _ in range(FRAMES)] == list(range(FRAMES))
    assert stage.done == [f"{act} {frame}" for frame in range(FRAMES) for act in ("move to", "take")]
    with pytest.raises(StopIteration, match=f"episode: expected at most {FRAMES} steps"):
        stage.step()
    assert stage.done[-1] == f"take {FRAMES - 1}"


@pytest.mark.parametrize("frame", [0, 1])
def test_a_command_on_a_set_path_is_refused_and_nothing_is_stepped(frame: int) -> None:
    stage = ball(closed_loop=False)
    for _ in range(frame):
        stage.step()
    done = list(stage.done)
    with pytest.raises(ValueError, match="command: expected None, since this episode follows a set path, got a"):
        stage.step(AHEAD)
    assert stage.done == done
    assert stage.step().truth.frame == frame


def test_in_closed_loop_the_carrier_obeys_before_all_moves_but_not_on_the_way_to_frame_0() -> None:
    stage = ball(closed_loop=True)
    stage.step(AHEAD)
    assert stage.done == ["move to 0", "take 0"]
    stage.step(AHEAD)
    assert stage.done[2:] == [AHEAD, "move to 1", "take 1"]


def test_in_closed_loop_a_missing_command_is_refused_and_nothing_is_stepped() -> None:
    stage = ball(closed_loop=True)
    stage.step()
    with pytest.raises(
        ValueError, match="command: expected a CameraCommand, since this episode is in closed loop, got"
    ):
        stage.step()
    assert stage.done == ["move to 0", "take 0"]
    assert [stage.step(AHEAD).truth.frame for _ in range(FRAMES - 1)] == [1, 2, 3]
    with pytest.raises(StopIteration):
        stage.step(AHEAD)


def test_truth_that_all_scenes_share_is_of_the_frame_just_taken() -> None:
    stage = ball(closed_loop=False)
    truths = [stage.step().truth for _ in range(FRAMES)]
    for k, truth in enumerate(truths):
        check_truth(truth)
        assert truth.time_s == k / RATE_HZ
        assert (truth.exposure_s, truth.gain) == (0.01, 2.0)
        assert truth.position_px[0] == pytest.approx([8.0 + 14.0 * k / 5.5, 6.0])
        # Bodies move on; the truth of an earlier frame does not change.
        assert truth.T_world_object[0, 0, 3] == k
    assert [str(truth.state[0]) for truth in truths] == ["occluded", "occluded", "out", "out"]
    assert [str(truth.side[0]) for truth in truths] == ["", "", "right", "right"]
    assert [int(truth.frames_since_exit[0]) for truth in truths] == [-1, -1, 0, 1]


def test_larger_views_are_of_the_present_instant() -> None:
    stage = ball(closed_loop=False)
    stage.step()
    view: Any = stage.larger_view(1.5)
    assert view[0] == "shader"
    assert (view[1] == np.eye(4)).all()
    assert view[2] == 1.5


def test_a_scenario_resolves_preset_seed_loop_and_extent_of_truth_once() -> None:
    setups: list[Setup] = []
    scenario = replace(BALL, stage=setups.append)
    scenario.episode("only", 3)
    scenario.episode(PRESET, 3, closed_loop=True, truth="target", renderer="pybullet")
    assert [each.seed for each in setups] == [episode_seed(3, "ball-v1", 0)] * 2
    assert [each.preset for each in setups] == [PRESET, PRESET]
    assert [(each.renderer, each.closed_loop, each.covers_all) for each in setups] == [
        ("raster", False, True),
        ("pybullet", True, False),
    ]
    replace(scenario, seeded_as="other-v1").episode("only", 3)
    assert setups[-1].seed == episode_seed(3, "other-v1", 0)
    with pytest.raises(ValueError, match=r"^truth: expected 'all' or 'target', got some"):
        scenario.episode("only", 3, truth="some")  # type: ignore[arg-type]
    with pytest.raises(ValueError, match=r"^preset: expected one of only; got 'nix'"):
        scenario.episode("nix", 3)
    with pytest.raises(ValueError, match=r"^scenario: expected one that keeps worlds, got ball-v1"):
        scenario.keep_world("only", 3)
