"""The skeleton of an episode: on each frame the bodies move, the camera takes its picture, and truth is recorded."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from scenarios.camera_rig import Rig
from scenarios.scenario import Frame
from scenarios.standing import Standing, StandingObjects
from scenarios.truth import TruthExtent
from scenarios.visibility import Exits, centres_px, states_of
from sim.checks import check
from sim.render.pipeline import Capture, Shader
from sim.world import World
from trackers.types import CameraCommand, Start


class Stage(ABC):
    """See ``scenarios.scenario.Episode``. A scene defines how its bodies and its carrier move, and its own truth.

    Attributes:
        world: the bodies at their current places; other renderers may draw it.
        frame_count, rate_hz, closed_loop: see ``Episode``.
    """

    def __init__(
        self,
        world: World,
        rig: Rig,
        *,
        frame_count: int,
        rate_hz: float,
        closed_loop: bool,
        standing: Sequence[Standing] = (),
    ) -> None:
        """``standing``: what stands about, where truth covers all, see ``Truth``."""
        self.world, self.frame_count, self.rate_hz, self.closed_loop = world, frame_count, rate_hz, closed_loop
        self._rig = rig
        self._standing = StandingObjects(world, standing)
        self._frame = -1
        self._T_world_camera = np.eye(4)
        self._exits: Exits | None = None

    @property
    @abstractmethod
    def start(self) -> Start:
        """What a tracker gets before the first picture."""

    @property
    @abstractmethod
    def _shader(self) -> Shader:
        """The current light."""

    @abstractmethod
    def map_of(self) -> Any:
        """Return the scenario's map, for reference trackers with unfair knowledge."""

    @abstractmethod
    def _obey(self, command: CameraCommand) -> None:
        """Move the carrier by a command."""

    @abstractmethod
    def _move_to(self, frame: int) -> None:
        """Set bodies, light and camera to a frame."""

    @abstractmethod
    def _take(self, frame: int) -> Frame:
        """Take the picture of the current world, and record its truth."""

    def step(self, command: CameraCommand | None = None) -> Frame:
        """Return the next frame; see ``Episode.step``.

        Raises:
            ValueError: if a command is missing in closed loop, or given on a set path.
            StopIteration: after the last frame.
        """
        frame = self._frame + 1
        if frame >= self.frame_count:
            raise StopIteration(f"episode: expected at most {self.frame_count} steps")
        steered = self.closed_loop and frame > 0
        if steered and command is None:
            raise ValueError("command: expected a CameraCommand, since this episode is in closed loop, got None")
        if command is not None and not self.closed_loop:
            raise ValueError("command: expected None, since this episode follows a set path, got a CameraCommand")
        if steered and command is not None:
            self._obey(command)
        self._move_to(frame)
        self._frame = frame
        return self._take(frame)

    def larger_view(self, scale: float) -> NDArray[np.uint8]:
        """Return the current instant in a picture ``scale`` times as wide and high; see ``Episode.larger_view``."""
        return self._rig.larger_view(self._shader, self._T_world_camera, scale)

    def normals(self) -> NDArray[np.float32]:
        """Return the normals (H, W, 3) of what the camera sees now; see ``Episode.normals``."""
        return self._rig.normals(self._T_world_camera)

    def close(self) -> None:  # noqa: B027
        """Do nothing: what an episode holds goes with it; see ``Episode.close``."""

    def _seen(
        self,
        capture: Capture,
        *,
        T_world_object: NDArray[np.float64],
        size_m: NDArray[np.float64],
        box_xyxy: NDArray[np.float64],
        visible_fraction: NDArray[np.float64],
        is_absent: NDArray[np.bool_] | None = None,
    ) -> dict[str, Any]:
        """Return the fields of ``Truth`` by name, except names, kinds, ids and speeds.

        Args:
            is_absent: (N,) who is not in the world now; None: nobody.
        """
        camera = self._rig.camera
        self._exits = self._exits or Exits(camera, len(box_xyxy))
        state = states_of(camera, box_xyxy, visible_fraction)
        position_px = centres_px(camera, self._T_world_camera, T_world_object, size_m)
        if is_absent is not None:
            state[is_absent] = "absent"
            position_px[is_absent] = np.nan
        side, frames_since_exit = self._exits.follow(state, box_xyxy)
        used = capture.picture.settings
        return {
            "frame": self._frame,
            "time_s": self._frame / self.rate_hz,
            "T_world_camera": self._T_world_camera,
            "T_world_object": T_world_object.copy(),
            "size_m": size_m,
            "position_px": position_px,
            "box_xyxy": box_xyxy,
            "visible_fraction": visible_fraction,
            "state": state,
            "side": side,
            "frames_since_exit": frames_since_exit,
            "instance_map": capture.instance_id,
            "depth_m": capture.depth_m,
            "exposure_s": used.exposure_s,
            "gain": used.gain,
            **self._standing.seen(capture, camera, self._T_world_camera),
        }


def covers_all(truth: TruthExtent) -> bool:
    """Return whether truth has to cover more than the target. Raises ValueError for an unknown extent."""
    check("truth", truth in ("all", "target"), "'all' or 'target'", truth)
    return truth == "all"
