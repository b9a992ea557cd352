"""Warm crates on a yard: a thermal camera at rest, and a second camera on a pan-tilt-zoom head that may be steered."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from scenarios.camera_rig import SingleCamera
from scenarios.scenario import Frame, RendererName, preset_of
from scenarios.stage import Stage, covers_all
from scenarios.truth import Truth, TruthExtent, without_pixels
from scenarios.visibility import Exits, centres_px, states_of
from sim.labels import amodal_boxes, outline, visible_fraction
from sim.mesh import TexturedMesh
from sim.meshes.facets import Facets, palette, swatch_uv
from sim.optics import PinholeCamera, look_down_pose
from sim.pose import pose_on_ground
from sim.rng import episode_seed, generator
from sim.world import World
from tests.toy_scene.thermal import BODY_K, GROUND_K, ThermalSensor, Warmth
from trackers.types import (
    CameraCommand,
    CameraModel,
    Carrier,
    CommandAxis,
    EgoPose,
    Observation,
    Start,
    SteeredCamera,
)

RATE_HZ = 10.0
EMPTY_FRAMES = 5
HEIGHT_M, YARD_M, CRATE_M = 20.0, 30.0, (1.6, 0.9, 0.8)
HEAD = Carrier(
    "yard-head",
    (CommandAxis("pan_rad_s", 1.0, 4.0), CommandAxis("tilt_rad_s", 1.0, 4.0), CommandAxis("zoom_per_s", 0.5, 2.0)),
    "around",
)
LENS = PinholeCamera.from_field_of_view(320, 240, float(np.deg2rad(50.0)))
"""Of the camera on the head, not zoomed."""
_STEEPEST_RAD, _ZOOM = np.deg2rad(80.0), (1.0, 4.0)


@dataclass(frozen=True)
class Yard:
    """Configuration of an episode."""

    summary: str
    frame_count: int = 40
    width_px: int = 96
    height_px: int = 72
    crates: int = 4
    speed_mps: float = 2.0
    closed_loop: bool = False


def box_mesh(size_m: tuple[float, float, float]) -> TexturedMesh:
    """Return a box that stands on z = 0."""
    facets = Facets()
    x_m, y_m, z_m = size_m
    facets.box((-x_m / 2, -y_m / 2, 0.0), (x_m / 2, y_m / 2, z_m), swatch_uv(0, 1))
    return facets.mesh(palette([(128, 128, 128)]))


class Head:
    """A pan-tilt-zoom head at the yard's corner."""

    def __init__(self, camera: PinholeCamera) -> None:
        self._camera = camera
        self.pan_rad, self.tilt_rad, self.zoom = np.pi / 4, -0.4, 1.0

    def obey(self, command: CameraCommand) -> None:
        """Turn for the time of one frame, within the head's limits."""
        pan, tilt, zoom = (
            np.clip(getattr(command, each.name), -each.limit, each.limit) / RATE_HZ for each in HEAD.axes
        )
        self.pan_rad += float(pan)
        self.tilt_rad = float(np.clip(self.tilt_rad + tilt, -_STEEPEST_RAD, 0.0))
        self.zoom = float(np.clip(self.zoom * np.exp(zoom), *_ZOOM))

    @property
    def camera(self) -> PinholeCamera:
        """The camera as it is zoomed."""
        return replace(self._camera, focal_px=self._camera.focal_px * self.zoom)

    @property
    def T_world_camera(self) -> NDArray[np.float64]:
        """Pose (4, 4)."""
        c, s, ct, st = np.cos(self.pan_rad), np.sin(self.pan_rad), np.cos(self.tilt_rad), np.sin(self.tilt_rad)
        ahead = np.array([c * ct, s * ct, st])
        right = np.array([s, -c, 0.0])
        T = np.eye(4)
        T[:3, :3] = np.stack([right, np.cross(ahead, right), ahead], axis=1)
        T[:3, 3] = (-0.5 * YARD_M, -0.5 * YARD_M, 6.0)
        return T


class YardEpisode(Stage):
    """See ``scenarios.scenario.Episode``."""

    def __init__(self, preset: Yard, seed: int, renderer: RendererName, closed_loop: bool, truth: TruthExtent) -> None:
        self._all, self._seed = covers_all(truth), seed
        world = World()
        world.add(box_mesh((2 * YARD_M, 2 * YARD_M, 0.01)), pose_on_ground(0, 0, 0), name="ground", category="ground")
        names = tuple("target" if k == 0 else f"crate-{k}" for k in range(preset.crates))
        self._crates = [
            world.add(box_mesh(CRATE_M), np.eye(4), name=name, category="crate", movable=True) for name in names
        ]
        self._names = names
        self._view = PinholeCamera.from_field_of_view(preset.width_px, preset.height_px, float(np.deg2rad(70.0)))
        camera = SingleCamera(world, self._view, renderer, ThermalSensor(generator(seed, "sensor")))
        super().__init__(world, camera, frame_count=preset.frame_count, rate_hz=RATE_HZ, closed_loop=closed_loop)
        self._camera = camera
        kelvin = np.full(len(world.bodies), GROUND_K)
        kelvin[[body.index for body in self._crates]] = BODY_K
        self._warmth = Warmth(kelvin)
        rng = generator(seed, "crates")
        self._radius_m = rng.uniform(3.0, 0.4 * YARD_M, preset.crates)
        self._phase_rad = rng.uniform(0, 2 * np.pi, preset.crates)
        self._speed_mps = preset.speed_mps * rng.uniform(0.5, 1.0, preset.crates)
        self._outline = outline([body.mesh for body in self._crates])
        self._head = Head(LENS)
        self._head_exits = Exits(LENS, preset.crates)
        self._T_world_camera = look_down_pose(np.array([0.0, 0.0, HEIGHT_M]), 0.0, 0.0, 0.0)
        self._move_to(0)
        self._start = Start(self._model, self._boxes(self._view, self._T_world_camera)[0], self._empty_yard(renderer))

    @property
    def start(self) -> Start:
        """Pictures of the empty yard, and the box of the crate that a tracker of one target is started on."""
        return self._start

    def _empty_yard(self, renderer: RendererName) -> tuple[Observation, ...]:
        self.world.move_all(self._crates, self._poses + _far_away())
        camera = SingleCamera(self.world, self._view, renderer, ThermalSensor(generator(self._seed, "background")))
        seen = [camera.take(self._warmth, self._T_world_camera, k).picture for k in range(EMPTY_FRAMES)]
        self.world.move_all(self._crates, self._poses)
        return tuple(
            Observation(each.image_rgb, (k - EMPTY_FRAMES) / RATE_HZ, self._model, counts=each.counts)
            for k, each in enumerate(seen)
        )

    @property
    def _model(self) -> CameraModel:
        return _model(self._view)

    @property
    def _shader(self) -> Warmth:
        return self._warmth

    def map_of(self) -> None:
        """Return nothing: a yard has no map."""

    def _obey(self, command: CameraCommand) -> None:
        self._head.obey(command)

    def _move_to(self, frame: int) -> None:
        angle = self._phase_rad + self._speed_mps / self._radius_m * frame / RATE_HZ
        places = self._radius_m[:, None] * np.stack([np.cos(angle), np.sin(angle)], axis=1)
        self._poses = np.array(
            [pose_on_ground(x, y, turn + np.pi / 2) for (x, y), turn in zip(places, angle, strict=True)]
        )
        self.world.move_all(self._crates, self._poses)

    def _boxes(self, camera: PinholeCamera, T_world_camera: NDArray[np.float64]) -> NDArray[np.float64]:
        return amodal_boxes(camera, T_world_camera, self._outline, self._poses)

    def _take(self, frame: int) -> Frame:
        seen = self._camera.take(self._warmth, self._T_world_camera, frame)
        boxes = self._boxes(self._view, self._T_world_camera)
        fractions = np.full(len(self._crates), np.nan)
        for k, body in enumerate(self._crates):
            if self._all or k == 0:
                fractions[k] = visible_fraction(
                    seen, self._view, self._T_world_camera, body.mesh, self._poses[k], body.index, boxes[k]
                )
        sizes = np.tile(CRATE_M, (len(self._crates), 1))
        truth = Truth(
            **self._seen(seen, T_world_object=self._poses, size_m=sizes, box_xyxy=boxes, visible_fraction=fractions),
            names=self._names,
            kinds=("crate",) * len(self._crates),
            instance_id=np.array([body.index for body in self._crates]),
            speed_mps=self._speed_mps,
        )
        observation = Observation(
            image_rgb=seen.picture.image_rgb,
            time_s=frame / RATE_HZ,
            camera=self._model,
            ego=EgoPose(self._T_world_camera),
            counts=seen.picture.counts,
            steered=SteeredCamera(_model(self._head.camera), EgoPose(self._head.T_world_camera)),
        )
        return Frame(observation, truth, steered=self._by_head(truth))

    def _by_head(self, truth: Truth) -> Truth:
        """Return the truth of the steered camera: no picture is taken, what is inside counts as seen."""
        camera, T = self._head.camera, self._head.T_world_camera
        boxes = self._boxes(camera, T)
        state = states_of(camera, boxes, np.ones(len(boxes)))
        side, since = self._head_exits.follow(state, boxes)
        return replace(
            without_pixels(truth),
            T_world_camera=T,
            box_xyxy=boxes,
            position_px=centres_px(camera, T, self._poses, truth.size_m),
            visible_fraction=np.ones(len(boxes)),
            state=state,
            side=side,
            frames_since_exit=since,
        )


def _model(camera: PinholeCamera) -> CameraModel:
    return CameraModel(camera.width_px, camera.height_px, camera.focal_px, band="thermal")


def _far_away() -> NDArray[np.float64]:
    T = np.zeros((4, 4))
    T[2, 3] = -1000.0
    return T


@dataclass(frozen=True)
class ToyYard:
    """See ``scenarios.scenario.Scenario``."""

    id: str = "toy-yard-v1"
    summary: str = "warm crates on a yard, under a thermal camera at rest"
    start: str = "a picture of the empty yard, and the box of one crate"
    target: str = "target"
    truth: type[Truth] = Truth
    classes: Mapping[str, str] = field(default_factory=lambda: {"crate": "crate"})
    carrier: Carrier = HEAD
    pictureless: None = None
    presets: dict[str, Yard] = field(
        default_factory=lambda: {"standard": Yard("four crates"), "quick": Yard("two crates", frame_count=20, crates=2)}
    )

    def episode(
        self,
        preset: Any,
        seed: int,
        *,
        renderer: RendererName = "raster",
        closed_loop: bool | None = None,
        truth: TruthExtent = "all",
    ) -> YardEpisode:
        """Build one episode."""
        configuration = preset_of(self, preset)
        looped = configuration.closed_loop if closed_loop is None else closed_loop
        return YardEpisode(configuration, episode_seed(seed, self.id, 0), renderer, looped, truth)


TOY_YARD = ToyYard()
