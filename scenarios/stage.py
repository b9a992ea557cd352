"""The stage of an episode: on each frame bodies and camera move, the camera takes its picture, truth is recorded."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from scenarios.objects import Labels, SceneObjects, Standing, StandingObjects
from scenarios.pan_tilt_zoom import Head
from scenarios.scenario import Frame, Setup
from scenarios.truth import Truth, without_pixels, without_standing
from scenarios.visibility import Exits, states_of
from sim.checks import check, check_choice
from sim.labels import SeenSurfaces
from sim.render.pipeline import Capture, Sensor, Shader, capture, radiance_of
from sim.render.protocol import Renderer, create_renderer
from sim.sensors.camera_sensor import CameraSensor
from sim.sensors.config import SensorConfig
from sim.world import World
from trackers.types import CameraCommand, CameraModel, CameraSettings, EgoPose, Observation, Start, SteeredCamera


class SceneCamera:
    """The camera that the tracker watches: its model, its renderer and its sensor.

    Attributes:
        model: as trackers receive it.
    """

    def __init__(
        self,
        setup: Setup,
        world: World,
        model: CameraModel,
        sensor: Sensor[Any] | None = None,
        *,
        through: Callable[[Renderer], Renderer] | None = None,
        smooth: bool = False,
    ) -> None:
        """Stand before a world.

        Args:
            sensor: None: a standard colour sensor.
            smooth: whether edges are without stairs, see ``sim.render.pipeline.capture``.
            through: returns the renderer of what is seen through something, of the one that draws the world.
        """
        self.model = model
        self._renderer = create_renderer(setup.renderer, world)
        if through is not None:
            self._renderer = through(self._renderer)
        self._sensor = sensor or CameraSensor(SensorConfig(), setup.rng("sensor"))
        self._smooth = smooth
        self._frame = 0
        self._settings: Any = None

    def take(self, shader: Shader, T_world_camera: NDArray[np.float64], frame: int, **exposing: Any) -> Capture[Any]:
        """Take a picture of the current world; the sensor's loops take one step.

        Args:
            frame: index, >= 0; it determines the noise.
            exposing: see ``sim.render.pipeline.capture``.
        """
        seen = capture(
            self._renderer, shader, self._sensor, self.model, T_world_camera, frame, smooth=self._smooth, **exposing
        )
        self._frame, self._settings = frame, seen.picture.settings
        return seen

    def observation(self, picture: Any, time_s: float, ego: EgoPose | None = None, **others: Any) -> Observation:
        """Return a picture of this camera as an observation; ``others`` are its other fields."""
        if self.model.band == "thermal":
            others["counts"] = picture.counts
        else:
            others.setdefault("settings", CameraSettings(picture.settings.exposure_s, picture.settings.gain))
        return Observation(picture.image_rgb, time_s, self.model, ego=ego, **others)

    def surfaces(self, T_world_camera: NDArray[np.float64]) -> SeenSurfaces:
        """Return the visible surfaces, without taking a picture."""
        return self._renderer.gbuffer(self.model, T_world_camera)

    def normals(self, T_world_camera: NDArray[np.float64]) -> NDArray[np.float32]:
        """Return the unit normals (H, W, 3) of the visible surfaces, world frame; 0 where there is none."""
        return self._renderer.normals(self.model, T_world_camera)

    def larger_view(self, shader: Shader, T_world_camera: NDArray[np.float64], scale: float) -> NDArray[np.uint8]:
        """Return the current instant in a picture ``scale`` times as wide and high.

        Raises:
            ValueError: before the first picture, whose settings it takes.
        """
        check("larger_view", self._settings is not None, "a picture taken before", "none")
        width_px, height_px = (2 * round(0.5 * scale * side) for side in (self.model.width_px, self.model.height_px))
        wide = replace(self.model, width_px=width_px, height_px=height_px)
        radiance = radiance_of(self._renderer, shader, wide, T_world_camera, smooth=self._smooth)
        return self._sensor.develop(radiance, wide, self._frame, self._settings).image_rgb


class Planned(NamedTuple):
    """An episode without its pictures: T frames, N objects, a steered head beside a camera at rest.

    Attributes:
        T_world_object: (T, N, 4, 4) and present: (T, N), see ``SceneObjects``. size_m: (N, 3). target: its index.
        visible_fraction: (T,) of the target in the camera's picture, see ``Truth``.
        head_px: (T, 2) where the head's camera sees the target's centre, at its first pose and zoom.
        camera: that trackers watch. T_world_camera: (4, 4) its pose, ``ego`` as measured.
        head: at its first pose and zoom. head_ego: that pose as measured.
    """

    T_world_object: NDArray[np.float64]
    present: NDArray[np.bool_]
    size_m: NDArray[np.float64]
    target: int
    visible_fraction: NDArray[np.float64]
    head_px: NDArray[np.float64]
    camera: CameraModel
    T_world_camera: NDArray[np.float64]
    ego: EgoPose
    head: Head
    head_ego: EgoPose


class Stage(ABC):
    """One episode, see ``scenarios.scenario.Episode``: a scene adds how its bodies move, and its own truth.

    A scene sets what ``_move_to`` needs, then calls ``__init__``. On every frame ``_move_to`` moves the objects and
    everything else; boxes, visible shares, the common truth and the observation follow from where they are.

    Attributes:
        world: the bodies at their current places; other renderers may draw it.
        frame_count, rate_hz, closed_loop: see ``Episode``.
        _shader: the current light; set by the scene before ``__init__`` or in ``_move_to``.
        _T_world_camera: (4, 4), the camera's current pose; likewise.
    """

    _shader: Shader
    _T_world_camera: NDArray[np.float64]

    def __init__(
        self,
        setup: Setup,
        objects: SceneObjects,
        camera: SceneCamera,
        *,
        standing: Sequence[Standing] = (),
        head: Head | None = None,
    ) -> None:
        """Move everything to frame 0.

        Args:
            objects: that truth is about. standing: bodies of the same kinds that no question is about, see ``Truth``.
            head: carries the steered camera, which takes the pictures itself or is a second one, see ``Mount``.
        """
        self.world, self.closed_loop = objects.world, setup.closed_loop
        self.frame_count: int = setup.preset.frame_count
        self.rate_hz: float = setup.preset.rate_hz
        self._setup, self._objects, self._camera, self._head = setup, objects, camera, head
        check_choice("target", setup.scenario.target, objects.names)
        for kind in {*objects.kinds, *(each.kind for each in standing)}:
            check_choice("kind", kind, setup.scenario.classes, why=", which the scenario's classes lack")
        self._target = objects.names.index(setup.scenario.target)
        self._in_full = np.full(len(objects.names), setup.covers_all)
        self._in_full[self._target] = True
        self._standing = StandingObjects(self.world, standing if setup.covers_all else ())
        self._exits = Exits(camera.model, len(objects.names))
        if head is not None:
            self._head_exits = Exits(head.camera, len(objects.names))
            self._look_through(head)
        self._frame = -1
        self._background: tuple[Observation, ...] | None = None
        self._move_to(0)
        self._first_camera = camera.model
        self._first_box_xyxy = objects.labels(camera.model, self._T_world_camera).box_xyxy[self._target]

    @abstractmethod
    def _move_to(self, frame: int) -> None:
        """Set objects, other bodies, light and camera to a frame.

        It is called several times for the same frame, so it must not advance anything: what a command changes belongs
        in ``_obey``.
        """

    def _own_truth(self, capture: Capture[Any], labels: Labels) -> dict[str, Any]:
        """Return the fields of truth that the scene adds, by name, and those that it states in another way."""
        return {}

    def _of_camera(self, labels: Labels) -> dict[str, Any]:
        """Return those of the scene's own fields of truth that are of a camera's view, by name."""
        return {}

    def map_of(self) -> Any:
        """Return the scenario's map, for reference trackers with unfair knowledge; None without one."""
        return None

    def _obey(self, command: CameraCommand) -> None:
        """Move the carrier by a command; a camera at rest stays."""
        if self._head is not None:
            self._head.obey(command)
            self._look_through(self._head)

    def _look_through(self, head: Head) -> None:
        """Set the camera to the head's pose and zoom, if it is the one on the head."""
        if head.mount.watches:
            self._T_world_camera, self._camera.model = head.T_world_camera, head.camera

    def _capture(self, frame: int) -> Capture[Any]:
        """Take the picture of the current world."""
        return self._camera.take(self._shader, self._T_world_camera, frame)

    def _ego(self) -> EgoPose | None:
        """Return the measured pose of the camera, which trackers receive: as its head measures it, or the true one."""
        head = self._head
        if head is None or not head.mount.watches:
            return self._measured(self._T_world_camera)
        return self._measured(head.T_world_measured)

    def _measured(self, T_world_camera: NDArray[np.float64]) -> EgoPose:
        """Return a pose in the carrier's navigation frame."""
        return EgoPose(T_world_camera.copy())

    def _empty_pictures(self) -> Sequence[Observation]:
        """Return pictures without targets, for ``Start``; bodies may be left anywhere."""
        return ()

    @property
    def start(self) -> Start:
        """What a tracker gets before the first picture: here the target's box in it, and ``_empty_pictures``."""
        if self._background is None:
            self._background = tuple(self._empty_pictures()) if self._setup.background else ()
            if self._background:
                self._move_to(max(self._frame, 0))
        return Start(self._first_camera, self._first_box_xyxy.copy(), self._background)

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
        return self._take()

    def turn(self, command: CameraCommand) -> None:
        """Move the carrier by a command, without a picture: for references with unfair knowledge."""
        self._obey(command)

    def target_ahead(self, frame: int) -> tuple[NDArray[np.float64], float]:
        """Return the pixel (2,) at which the camera, where it is now, sees the target on a frame, and its distance.

        For references with unfair knowledge: nothing is drawn. The distance is in metres along the camera's axis; the
        pixel is NaN behind the camera.
        """
        self._move_to(min(frame, self.frame_count - 1))
        T_world_camera, middle_m = self._T_world_camera, self._objects.T_world_object[self._target, :3, 3]
        seen = self._objects.labels(self._camera.model, T_world_camera)
        return seen.position_px[self._target], float((middle_m - T_world_camera[:3, 3]) @ T_world_camera[:3, 2])

    @property
    def camera(self) -> CameraModel:
        """The camera, as it is zoomed now."""
        return self._camera.model

    def larger_view(self, scale: float) -> NDArray[np.uint8]:
        """Return the current instant in a picture ``scale`` times as wide and high; see ``Episode.larger_view``."""
        return self._camera.larger_view(self._shader, self._T_world_camera, scale)

    def normals(self) -> NDArray[np.float32]:
        """Return the normals (H, W, 3) of what the camera sees now; see ``Episode.normals``."""
        return self._camera.normals(self._T_world_camera)

    def close(self) -> None:  # noqa: B027
        """Do nothing: what an episode holds goes with it; see ``Episode.close``."""

    def _take(self) -> Frame:
        """Take the picture of the current world, and record its truth."""
        capture = self._capture(self._frame)
        # In place: the map belongs to this frame alone.
        self._objects.merge(capture.instance_id)
        self._standing.merge(capture.instance_id)
        labels = self._objects.labels(self._camera.model, self._T_world_camera, capture, self._in_full)
        truth = self._truth(capture, labels)
        picture, time_s, ego, head = capture.picture, truth.time_s, self._ego(), self._head
        if head is None or head.mount.watches or not self.closed_loop:
            return Frame(self._camera.observation(picture, time_s, ego), truth)
        steered = SteeredCamera(head.camera, self._measured(head.T_world_camera))
        observation = self._camera.observation(picture, time_s, ego, steered=steered)
        return Frame(observation, truth, steered=self._truth_of_head(head, truth))

    def planned(self) -> Planned:
        """Return all frames without taking a picture, before the first step."""
        objects, camera, target, head, ego = self._objects, self._camera, self._target, self._head, self._ego()
        assert head is not None
        assert ego is not None
        only = np.arange(len(objects.names)) == target
        poses, present, visible, head_px = [], [], np.ones(self.frame_count), []
        for frame in range(self.frame_count):
            self._move_to(frame)
            poses.append(objects.T_world_object.copy())
            present.append(objects.present.copy())
            head_px.append(objects.labels(head.camera, head.T_world_camera).position_px[target])
            if self._may_be_hidden():
                seen = camera.surfaces(self._T_world_camera)
                objects.merge(seen.instance_id)
                labels = objects.labels(camera.model, self._T_world_camera, seen, only)
                visible[frame] = labels.visible_fraction[target]
        return Planned(
            np.array(poses),
            np.array(present),
            objects.size_m,
            target,
            visible,
            np.array(head_px),
            camera.model,
            self._T_world_camera.copy(),
            ego,
            head,
            self._measured(head.T_world_camera),
        )

    def _may_be_hidden(self) -> bool:
        """Return False if nothing can stand before the target now."""
        return True

    def _truth(self, capture: Capture[Any], labels: Labels) -> Truth:
        objects, camera, T_world_camera = self._objects, self._camera.model, self._T_world_camera
        used = capture.picture.settings
        common = {
            "frame": self._frame,
            "time_s": self._frame / self.rate_hz,
            "T_world_camera": T_world_camera,
            "names": objects.names,
            "kinds": objects.kinds,
            "T_world_object": objects.T_world_object.copy(),
            "size_m": objects.size_m,
            "bounds_m": objects.bounds_m(),
            "speed_mps": objects.speed_mps.copy(),
            "instance_id": objects.instance_id.copy(),
            "visible_fraction": labels.visible_fraction,
            "instance_map": capture.instance_id,
            "depth_m": capture.depth_m,
            "exposure_s": used.exposure_s,
            "gain": used.gain,
            **self._placed(camera, labels, labels.visible_fraction, self._exits),
            **self._standing.labels(capture, camera, T_world_camera),
        }
        if (keypoints_m := objects.keypoints_m()) is not None:
            common["keypoints_m"] = keypoints_m
        return self._setup.scenario.truth(**common | self._own_truth(capture, labels))

    def _placed(
        self, camera: CameraModel, labels: Labels, visible_fraction: NDArray[np.float64], exits: Exits
    ) -> dict[str, Any]:
        """Return the fields of truth that say where objects are in a camera's view, by name."""
        state = states_of(camera, labels.box_xyxy, visible_fraction)
        state[~self._objects.present] = "absent"
        side, frames_since_exit = exits.follow(state, labels.box_xyxy)
        return {
            "position_px": labels.position_px,
            "box_xyxy": labels.box_xyxy,
            "state": state,
            "side": side,
            "frames_since_exit": frames_since_exit,
            **self._of_camera(labels),
        }

    def _truth_of_head(self, head: Head, truth: Truth) -> Truth:
        """Return the truth of the head's camera: it takes no picture, and visible shares are those of the other one."""
        camera, T_world_camera = head.camera, head.T_world_camera
        labels = self._objects.labels(camera, T_world_camera)
        placed = self._placed(camera, labels, truth.visible_fraction, self._head_exits)
        return replace(without_standing(without_pixels(truth)), T_world_camera=T_world_camera, **placed)
