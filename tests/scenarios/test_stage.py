"""The skeleton of an episode, with a scene of one ball that leaves the picture to the right."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from scenarios.scenario import Frame
from scenarios.stage import Stage, covers_all
from scenarios.truth import Truth, check_truth
from sim.optics import PinholeCamera
from sim.render.pipeline import Capture
from sim.sensors.config import Picture, SensorSettings
from sim.world import World
from trackers.types import CameraCommand, CameraModel, Observation, Start

CAMERA = PinholeCamera(16, 12, 14.0)
MODEL = CameraModel(16, 12, 14.0)
FRAMES, RATE_HZ = 4, 10.0
AHEAD = CameraCommand(forward_mps=1.0)


class FakeRig:
    """Records the requests for larger views."""

    camera = CAMERA

    def larger_view(self, shader: Any, T_world_camera: NDArray[np.float64], scale: float) -> Any:
        """See ``Rig``."""
        return shader, T_world_camera.copy(), scale


class BallStage(Stage):
    """Records its calls."""

    def __init__(self, closed_loop: bool) -> None:
        self.done: list[Any] = []
        super().__init__(World(), FakeRig(), frame_count=FRAMES, rate_hz=RATE_HZ, closed_loop=closed_loop)
        self.poses = np.eye(4)[None].copy()

    @property
    def start(self) -> Start:
        """A start without a box."""
        return Start(MODEL)

    @property
    def _shader(self) -> Any:
        return "shader"

    def map_of(self) -> None:
        """There is none."""

    def _obey(self, command: CameraCommand) -> None:
        self.done.append(command)

    def _move_to(self, frame: int) -> None:
        self.done.append(f"move to {frame}")
        self.poses[0, :3, 3] = frame, 0.0, 5.0
        self._T_world_camera = np.eye(4)

    def _take(self, frame: int) -> Frame:
        self.done.append(f"take {frame}")
        picture = Picture(np.zeros((12, 16, 3), np.uint8), SensorSettings(0.01, 2.0))
        capture = Capture(picture, np.ones((12, 16), np.float32), np.zeros((12, 16), np.int32))
        box = np.array([[8.0, 4.0, 12.0, 8.0]]) + np.array([4.0, 0.0, 4.0, 0.0]) * frame
        truth = Truth(
            **self._seen(
                capture,
                T_world_object=self.poses,
                size_m=np.ones((1, 3)),
                box_xyxy=box,
                visible_fraction=np.array([0.4]),
            ),
            names=("ball",),
            kinds=("ball",),
            instance_id=np.array([7]),
            speed_mps=np.array([10.0]),
        )
        return Frame(Observation(picture.image_rgb, truth.time_s, MODEL), truth)


def test_on_a_set_path_it_moves_and_takes_frame_after_frame_until_the_last() -> None:
    stage = BallStage(closed_loop=False)
    assert [stage.step().truth.frame for _ in range(FRAMES)] == list(range(FRAMES))
    assert stage.done == [f"{act} {frame}" for frame in range(FRAMES) for act in ("move to", "take")]
    with pytest.raises(StopIteration, match=f"episode: expected at most {FRAMES} steps"):
        stage.step()
    assert stage.done[-1] == f"take {FRAMES - 1}"


@pytest.mark.parametrize("frame", [0, 1])
def test_a_command_on_a_set_path_is_refused_and_nothing_is_stepped(frame: int) -> None:
    stage = BallStage(closed_loop=False)
    for _ in range(frame):
        stage.step()
    done = list(stage.done)
    with pytest.raises(ValueError, match="command: expected None, since this episode follows a set path, got a"):
        stage.step(AHEAD)
    assert stage.done == done
    assert stage.step().truth.frame == frame


def test_in_closed_loop_the_carrier_obeys_before_all_moves_but_not_on_the_way_to_frame_0() -> None:
    stage = BallStage(closed_loop=True)
    stage.step(AHEAD)
    assert stage.done == ["move to 0", "take 0"]
    stage.step(AHEAD)
    assert stage.done[2:] == [AHEAD, "move to 1", "take 1"]


def test_in_closed_loop_a_missing_command_is_refused_and_nothing_is_stepped() -> None:
    stage = BallStage(closed_loop=True)
    stage.step()
    with pytest.raises(
        ValueError, match="command: expected a CameraCommand, since this episode is in closed loop, got"
    ):
        stage.step()
    assert stage.done == ["move to 0", "take 0"]
    assert [stage.step(AHEAD).truth.frame for _ in range(FRAMES - 1)] == [1, 2, 3]
    with pytest.raises(StopIteration):
        stage.step(AHEAD)


def test_truth_that_all_scenes_share_is_told_of_the_frame_just_taken() -> None:
    stage = BallStage(closed_loop=False)
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
    stage = BallStage(closed_loop=False)
    stage.step()
    view: Any = stage.larger_view(1.5)
    assert view[0] == "shader"
    assert (view[1] == np.eye(4)).all()
    assert view[2] == 1.5


def test_how_much_truth_is_asked_for_is_a_word() -> None:
    assert covers_all("all")
    assert not covers_all("target")
    with pytest.raises(ValueError, match=r"^truth: expected 'all' or 'target', got some"):
        covers_all("some")  # type: ignore[arg-type]
