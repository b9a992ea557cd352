"""The least that a scene needs: a colour camera at rest, and a belt that takes three boxes out of the picture and back.

It is the example of CONTRIBUTING, to copy from: a scenario, its own truth, a suite with its own judge, and their names.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from benchmarks.contract.judging import Ending, Score, truth_as
from benchmarks.contract.metric import Metric
from benchmarks.contract.suite import Scene, Suite, register_suite
from scenarios import catalog
from scenarios.camera_rig import SingleCamera
from scenarios.envs.ids import register_envs
from scenarios.scenario import Frame, RendererName, Scenario, preset_of
from scenarios.stage import Stage, covers_all
from scenarios.truth import Truth, TruthExtent, truth_field
from sim.checks import check_types, check_within
from sim.labels import amodal_boxes, outline, visible_fraction
from sim.mesh import TexturedMesh
from sim.meshes.facets import Facets, palette, swatch_uv
from sim.optics import PinholeCamera, look_down_pose
from sim.pose import pose_on_ground
from sim.rng import episode_seed, generator
from sim.sensors.camera_sensor import CameraSensor
from sim.sensors.config import SensorConfig
from sim.shaders.daylight import DaylightShader, Sun
from sim.world import World
from trackers.types import CameraCommand, CameraModel, CameraSettings, Carrier, EgoPose, Estimate, Observation, Start

RATE_HZ = 10.0
BOX_M = (0.3, 0.2, 0.2)
FLOOR_M = (8.0, 8.0, 0.1)
PAINTS_RGB = {"target": (200, 40, 30), "blue box": (40, 90, 200), "yellow box": (220, 180, 40)}
AT_REST = Carrier("pillar", (), "down")
"""A camera that no command moves: no axes."""


# The scenario ---------------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Belt:
    """Configuration of an episode. The belt runs ``travel_m`` one way and comes back, once."""

    summary: str
    frame_count: int = 60
    width_px: int = 128
    height_px: int = 96
    travel_m: float = 2.0
    closed_loop: bool = False

    def __post_init__(self) -> None:
        check_types(self)
        check_within(self, "frame_count width_px height_px", 2)


@dataclass(frozen=True, slots=True)
class BeltTruth(Truth):
    """Truth of one frame above the belt.

    Attributes:
        run_m: how far the belt has run since frame 0.
    """

    run_m: float = truth_field("m", coding="since frame 0")


class BeltEpisode(Stage):
    """One run of the belt. Poses (3, 4, 4) are those of the boxes, in the order of ``PAINTS_RGB``."""

    def __init__(self, preset: Belt, seed: int, renderer: RendererName, closed_loop: bool, truth: TruthExtent) -> None:
        self._preset, self._all = preset, covers_all(truth)
        world = World()
        world.add(_slab(FLOOR_M, (150, 150, 145)), pose_on_ground(0, 0, 0), name="floor", category="ground")
        self._boxes = [
            world.add(_slab(BOX_M, paint), np.eye(4), name=name, category="box", movable=True)
            for name, paint in PAINTS_RGB.items()
        ]
        self._view = PinholeCamera.from_field_of_view(preset.width_px, preset.height_px, float(np.deg2rad(60.0)))
        self._camera = SingleCamera(
            world, self._view, renderer, CameraSensor(SensorConfig(), generator(seed, "sensor"))
        )
        super().__init__(world, self._camera, frame_count=preset.frame_count, rate_hz=RATE_HZ, closed_loop=closed_loop)
        self._light = DaylightShader(world, Sun((0.3, 0.4, 1.0), 20_000.0), 8_000.0)
        rng = generator(seed, "boxes")
        self._rest_m = np.stack([np.array([0.0, -0.5, 0.5]) + rng.uniform(-0.05, 0.05, 3), rng.uniform(-0.3, 0.3, 3)])
        self._yaw_rad = rng.uniform(-0.5, 0.5, 3)
        self._outline = outline([box.mesh for box in self._boxes])
        self._T_world_camera = look_down_pose(np.array([0.0, 0.0, 2.0]), np.pi / 2, 0.0, 0.0)
        self._move_to(0)

    @property
    def start(self) -> Start:
        """See ``Stage``: where the target is on frame 0."""
        return Start(self._model, self._amodal_xyxy()[0])

    @property
    def _shader(self) -> DaylightShader:
        return self._light

    @property
    def _model(self) -> CameraModel:
        return CameraModel(self._view.width_px, self._view.height_px, self._view.focal_px)

    def map_of(self) -> None:
        """See ``Stage``: there is none."""

    def _obey(self, command: CameraCommand) -> None:
        """See ``Stage``: the camera is at rest."""

    def _move_to(self, frame: int) -> None:
        self._run_m = self._preset.travel_m * float(np.sin(np.pi * frame / (self._preset.frame_count - 1)))
        x_m, y_m = self._rest_m
        places = zip(x_m + self._run_m, y_m, self._yaw_rad, strict=True)
        self._poses = np.array([pose_on_ground(x, y, yaw) for x, y, yaw in places])
        self._poses[:, 2, 3] = FLOOR_M[2]
        self.world.move_all(self._boxes, self._poses)

    def _take(self, frame: int) -> Frame:
        seen = self._camera.take(self._light, self._T_world_camera, frame)
        boxes_xyxy = self._amodal_xyxy()
        fractions = np.full(len(self._boxes), np.nan)
        for k, box in enumerate(self._boxes if self._all else self._boxes[:1]):
            fractions[k] = visible_fraction(
                seen, self._view, self._T_world_camera, box.mesh, self._poses[k], box.index, boxes_xyxy[k]
            )
        common = self._seen(
            seen,
            T_world_object=self._poses,
            size_m=np.tile(BOX_M, (len(self._boxes), 1)),
            box_xyxy=boxes_xyxy,
            visible_fraction=fractions,
        )
        truth = BeltTruth(
            **common,
            names=tuple(PAINTS_RGB),
            kinds=("box",) * len(self._boxes),
            instance_id=np.array([box.index for box in self._boxes]),
            speed_mps=np.full(len(self._boxes), self._speed_mps(frame)),
            run_m=self._run_m,
        )
        settings = CameraSettings(truth.exposure_s, truth.gain)
        pose = EgoPose(self._T_world_camera)
        return Frame(Observation(seen.picture.image_rgb, truth.time_s, self._model, settings, pose), truth)

    def _speed_mps(self, frame: int) -> float:
        """Return the speed of the belt, the derivative of its run."""
        phase_rad = np.pi / (self._preset.frame_count - 1)
        return float(abs(self._preset.travel_m * np.cos(phase_rad * frame)) * phase_rad * RATE_HZ)

    def _amodal_xyxy(self) -> NDArray[np.float64]:
        return amodal_boxes(self._view, self._T_world_camera, self._outline, self._poses)


def _slab(size_m: tuple[float, float, float], paint_rgb: tuple[int, int, int]) -> TexturedMesh:
    """Return a box that stands on z = 0."""
    facets = Facets()
    x_m, y_m, z_m = size_m
    facets.box((-x_m / 2, -y_m / 2, 0.0), (x_m / 2, y_m / 2, z_m), swatch_uv(0, 1))
    return facets.mesh(palette([paint_rgb]))


@dataclass(frozen=True)
class Conveyor:
    """See ``scenarios.scenario.Scenario``."""

    id: str = "conveyor-v1"
    summary: str = "three boxes on a conveyor belt, under a camera at rest"
    start: str = "the first picture and the red box's box in it"
    target: str = "target"
    truth: type[BeltTruth] = BeltTruth
    classes: Mapping[str, str] = field(default_factory=lambda: {"box": "box"})
    carrier: Carrier = AT_REST
    pictureless: None = None
    presets: dict[str, Belt] = field(
        default_factory=lambda: {"standard": Belt("six seconds"), "quick": Belt("two seconds", frame_count=20)}
    )

    def episode(
        self,
        preset: Any,
        seed: int,
        *,
        renderer: RendererName = "raster",
        closed_loop: bool | None = None,
        truth: TruthExtent = "all",
    ) -> BeltEpisode:
        """See ``Scenario.episode``."""
        configuration = preset_of(self, preset)
        looped = configuration.closed_loop if closed_loop is None else closed_loop
        return BeltEpisode(configuration, episode_seed(seed, self.id, 0), renderer, looped, truth)


CONVEYOR = Conveyor()


# The suite ------------------------------------------------------------------------------------------------------------


class OutsideJudge:
    """See ``benchmarks.contract.judging.Judge``. Asks where the target is while it is outside the picture."""

    def __init__(self, episode: Any, scenario: Scenario) -> None:
        self._target = scenario.target

    def see(self, frame: Frame, command: CameraCommand | None) -> None:
        """See ``Judge``."""
        truth = truth_as(frame.truth, BeltTruth)
        target = truth.index_of(self._target)
        self.true_px, self.is_out = truth.position_px[target], truth.state[target] == "out"

    def sheet(self) -> OutsideSheet:
        """See ``Judge``."""
        return OutsideSheet(self)


class OutsideSheet:
    """See ``benchmarks.contract.judging.ScoreSheet``."""

    def __init__(self, judge: OutsideJudge) -> None:
        self._judge = judge
        self._errors_px: list[float] = []

    def keep(self, frame: Frame, answer: Estimate) -> None:
        """See ``ScoreSheet``. Silence is an error of a picture's width, the greatest there is."""
        if self._judge.is_out:
            width_px = frame.observation.camera.width_px
            error_px = np.linalg.norm(answer.position_px - self._judge.true_px)
            self._errors_px.append(float(np.fmin(error_px, width_px)))

    def scores(self, ending: Ending) -> Iterator[Score]:
        """Yield ``outside_error_px``: mean distance, in pixels, of estimate and box while it is outside the picture."""
        if self._errors_px:
            yield Score("outside_error_px", float(np.mean(self._errors_px)), len(self._errors_px))


register_suite(
    Suite(
        name="belt",
        summary="a box on a belt: where is it while it is outside the picture?",
        scenes=(Scene("conveyor", trackers_of="frame-out", trackers=("hold", "constant_velocity", "colour_pf")),),
        preset="standard",
        quick_preset="quick",
        judge=OutsideJudge,
        metrics=(
            Metric(
                "outside_error_px", "distance of estimate and box outside, at most a picture's width", "px", "lower"
            ),
        ),
        headline=("outside_error_px",),
        compared=("outside_error_px",),
        tuned_for={"outside_error_px": -1.0},
        silence="an error of a picture's width",
    )
)


# Their names ----------------------------------------------------------------------------------------------------------

catalog.register(catalog.Entry(CONVEYOR.id, f"{__name__}:CONVEYOR", "frameout/Conveyor-v1", "colour_pf"))
register_envs()
