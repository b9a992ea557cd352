"""The least that a scene needs: a colour camera at rest, and a belt that takes three boxes out of the picture and back.

It is the example of CONTRIBUTING, to copy from: a scenario, its own truth, a suite with its own judge, and their names.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from benchmarks import Ending, Metric, Scene, Score, Suite, register_suite
from scenarios import Frame, Objects, Scenario, SceneCamera, Setup, Stage, Truth, catalog, truth_field
from sim.checks import check_types, check_within
from sim.meshes.facets import painted_box
from sim.optics import look_down_pose
from sim.pose import pose_on_ground
from sim.shaders.daylight import DaylightShader, Sun
from sim.world import World
from trackers import CameraModel, Carrier, Estimate

BOX_M, FLOOR_M = (0.3, 0.2, 0.2), (8.0, 8.0, 0.1)
PAINTS_RGB = {"target": (200, 40, 30), "blue box": (40, 90, 200), "yellow box": (220, 180, 40)}


# The scenario ---------------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Belt:
    """Configuration of an episode. The belt runs ``travel_m`` one way and comes back, once."""

    summary: str
    frame_count: int = 60
    rate_hz: float = 10.0
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
    """One run of the belt."""

    def __init__(self, setup: Setup) -> None:
        preset, rng, world = setup.preset, setup.rng("boxes"), World()
        world.add(painted_box(FLOOR_M, (150, 150, 145)), np.eye(4), name="floor", category="ground")
        boxes = [
            world.add(painted_box(BOX_M, paint), np.eye(4), name=name, category="box", movable=True)
            for name, paint in PAINTS_RGB.items()
        ]
        self._travel_m, self._phase_rad = preset.travel_m, np.pi / (preset.frame_count - 1)
        x_m, y_m = np.array([0.0, -0.5, 0.5]) + rng.uniform(-0.05, 0.05, 3), rng.uniform(-0.3, 0.3, 3)
        self._rest = [pose_on_ground(*place) for place in zip(x_m, y_m, rng.uniform(-0.5, 0.5, 3), strict=True)]
        self._shader = DaylightShader(world, Sun((0.3, 0.4, 1.0), 20_000.0), 8_000.0)
        self._T_world_camera = look_down_pose(np.array([0.0, 0.0, 2.0]), np.pi / 2, 0.0, 0.0)
        view = CameraModel.from_field_of_view(preset.width_px, preset.height_px, float(np.deg2rad(60.0)))
        super().__init__(setup, Objects(world, boxes), SceneCamera(setup, world, view))

    def _move_to(self, frame: int) -> None:
        self._run_m = self._travel_m * float(np.sin(self._phase_rad * frame))
        speed_mps = abs(self._travel_m * np.cos(self._phase_rad * frame)) * self._phase_rad * self.rate_hz
        poses = np.array(self._rest)
        poses[:, 0, 3] += self._run_m
        poses[:, 2, 3] = FLOOR_M[2]
        self._objects.move(poses, np.full(len(poses), speed_mps))

    def _own_truth(self, *seen: Any) -> dict[str, Any]:
        return {"run_m": self._run_m}


CONVEYOR = Scenario(
    id="conveyor-v1",
    summary="three boxes on a conveyor belt, under a camera at rest",
    start="the first picture and the red box's box in it",
    stage=BeltEpisode,
    presets={"standard": Belt("six seconds"), "quick": Belt("two seconds", frame_count=20)},
    classes={"box": "box"},
    carrier=Carrier("pillar", (), "down"),
    truth=BeltTruth,
)
catalog.register(catalog.Entry(CONVEYOR.id, f"{__name__}:CONVEYOR", "frameout/Conveyor-v1", "colour_pf"))


# The suite ------------------------------------------------------------------------------------------------------------


class OutsideJudge:
    """See ``benchmarks.contract.judging.Judge``. It compares answers with the target's place outside the picture."""

    def __init__(self, episode: Any, scenario: Scenario) -> None:
        self._target = scenario.target

    def see(self, frame: Frame, command: Any) -> None:
        """See ``Judge``."""
        truth, target = frame.truth, frame.truth.index_of(self._target)
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
