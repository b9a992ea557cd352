"""One episode of ``harbour``: a thermal camera at rest overlooks the site; a second one, on a head, may be steered."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from scenarios.camera_rig import SingleCamera
from scenarios.harbour.clutter import Afloat, Clutter
from scenarios.harbour.conditions import DAYS_BEFORE, draw_conditions
from scenarios.harbour.head import MOUNT
from scenarios.harbour.intruders import Intruders
from scenarios.harbour.layout import (
    AIM_M,
    CAMERA,
    SURVEY,
    VOLUME_BOTTOM_M,
    VOLUME_M,
    WALL_X_M,
    is_watched,
    overview_pose,
)
from scenarios.harbour.plan import draw_plan
from scenarios.harbour.presets import Harbour
from scenarios.harbour.scenery import SPAN_M, build_scenery
from scenarios.harbour.thermals import Thermals
from scenarios.harbour.truth import HarbourMap, HarbourTruth, contrasts
from scenarios.pan_tilt_zoom import Head
from scenarios.scenario import Frame, RendererName
from scenarios.stage import Stage, covers_all
from scenarios.truth import TruthExtent, without_pixels, without_standing
from scenarios.visibility import Exits, centres_px, states_of
from sim.optics import PinholeCamera
from sim.pose import rotation_by
from sim.rng import generator
from sim.sensors.thermal_sensor import ThermalConfig, ThermalSensor
from sim.shaders.thermal.shader import ThermalShader
from sim.world import World
from trackers.types import CameraCommand, CameraModel, EgoPose, Observation, Start, SteeredCamera

TARGET = "person-0"
_SURVEY_RAD, _SURVEY_M = np.deg2rad(0.02), 0.05
"""Standard deviations of the surveyed pose of the camera."""
_BACKGROUND_FROM = 4000
"""Number of the sensor's first frame of the days before, or a later one: no noise of the episode's own repeats."""


class HarbourEpisode(Stage):
    """See ``scenarios.scenario.Episode``."""

    def __init__(
        self, preset: Harbour, seed: int, renderer: RendererName, closed_loop: bool, truth: TruthExtent
    ) -> None:
        self._preset, self._all, self._seed, self._renderer = preset, covers_all(truth), seed, renderer
        self._time_s = np.arange(preset.frame_count) / preset.rate_hz
        scale = min(preset.width_px / CAMERA.width_px, preset.height_px / CAMERA.height_px)
        self._view = PinholeCamera(preset.width_px, preset.height_px, CAMERA.focal_px * scale)
        self._conditions = draw_conditions(preset, generator(seed, "conditions"))
        plan = draw_plan(preset, generator(seed, "plan"))
        world = World()
        scenery = build_scenery(world, generator(seed, "scenery"))
        self._clutter = Clutter(world, plan, self._conditions, generator(seed, "clutter"))
        self._labels = {body.index: body.category for body in world.bodies}
        looks = generator(seed, "looks")
        self._intruders = Intruders(world, plan, self._conditions, self._time_s, looks, scenery.bay_k)
        self._thermals = Thermals(
            world,
            self._conditions,
            scenery.surfaces,
            self._clutter,
            self._intruders,
            preset.rate_hz,
            generator(seed, "waves"),
        )
        self._afloat = self._clutter.afloat(self._time_s, before=False)
        self._config = ThermalConfig(rate_hz=preset.rate_hz)
        self._camera = self._overview(world)
        super().__init__(
            world,
            self._camera,
            frame_count=preset.frame_count,
            rate_hz=preset.rate_hz,
            closed_loop=closed_loop,
            standing=self._clutter.standing if self._all else (),
        )
        self._T_world_camera = overview_pose()
        self._ego = EgoPose(_surveyed(self._T_world_camera, generator(seed, "survey")))
        self._background: tuple[Observation, ...] | None = None
        self._head = Head(MOUNT, preset.rate_hz)
        self._head_exits = Exits(self._head.camera, len(self._intruders.names))

    @property
    def start(self) -> Start:
        """The calibration, the survey of the site, and pictures of the days before, taken when first asked for; for a
        tracker that a second camera follows, the target's box.
        """
        if self._background is None:
            self._background = tuple(self._days_before())
        return Start(_model(self._view), self._first_box() if self.closed_loop else None, self._background, SURVEY)

    @property
    def _shader(self) -> ThermalShader:
        return self._thermals.shader

    def map_of(self) -> HarbourMap:
        """Return what is where."""
        low, high = WALL_X_M, 900.0
        return HarbourMap(
            np.array(VOLUME_M),
            np.array([AIM_M[0], AIM_M[1], VOLUME_BOTTOM_M + 0.5 * VOLUME_M[2]]),
            dict(self._labels),
            np.array([(low, -SPAN_M), (high, -SPAN_M), (high, SPAN_M), (low, SPAN_M)]),
            np.array([(WALL_X_M, -SPAN_M), (WALL_X_M, SPAN_M)]),
        )

    def _obey(self, command: CameraCommand) -> None:
        self._head.obey(command)

    def _move_to(self, frame: int) -> None:
        self._intruders.move_to(frame)
        self._clutter.move_to(self._afloat, frame, DAYS_BEFORE)
        self._thermals.show_frame(frame)

    def _overview(self, world: World) -> SingleCamera:
        """Return the overview camera; all have the same pattern of pixels, as there is only one."""
        return SingleCamera(
            world, self._view, self._renderer, ThermalSensor(self._config, generator(self._seed, "sensor"))
        )

    def _days_before(self) -> list[Observation]:
        time_s = self._conditions.background_times(self._preset.background)
        if not len(time_s):
            return []
        afloat: Afloat = self._clutter.afloat(time_s, before=True)
        camera = self._overview(self.world)
        self._intruders.take_out()
        pictures = []
        first = max(_BACKGROUND_FROM, self.frame_count)
        for k, each in enumerate(time_s.tolist()):
            self._clutter.move_to(afloat, k, self._conditions.day_at(each))
            self._thermals.show_earlier(each)
            frame = first + round((each - time_s[0]) * self.rate_hz)
            seen = camera.take(self._shader, self._T_world_camera, frame).picture
            pictures.append(self._observed(seen, each))
        self._move_to(max(self._frame, 0))
        return pictures

    def _first_box(self) -> NDArray[np.float64]:
        self._intruders.move_to(0)
        target = self._intruders.names.index(TARGET)
        box_xyxy = self._intruders.seen(self._view, self._T_world_camera, None, target).box_xyxy
        self._intruders.move_to(max(self._frame, 0))
        return box_xyxy

    def _observed(self, seen: Any, time_s: float, steered: SteeredCamera | None = None) -> Observation:
        model = _model(self._view)
        return Observation(seen.image_rgb, time_s, model, ego=self._ego, counts=seen.counts, steered=steered)

    def _take(self, frame: int) -> Frame:
        capture = self._camera.take(self._shader, self._T_world_camera, frame)
        intruders, seen = self._intruders, capture.picture
        # In place: the map belongs to this frame alone.
        intruders.merge(capture.instance_id)
        here = intruders.present[frame]
        box_xyxy, fraction = np.full((len(here), 4), np.nan), np.zeros(len(here))
        target = intruders.names.index(TARGET)
        for k in np.flatnonzero(here):
            wanted = capture.instance_id if self._all or k == target else None
            one = intruders.seen(self._view, self._T_world_camera, wanted, int(k))
            box_xyxy[k], fraction[k] = one.box_xyxy, one.visible_fraction
        if not self._all:
            fraction[np.arange(len(here)) != target] = np.nan
        poses = intruders.T_world_object[frame]
        common = self._seen(
            capture,
            T_world_object=poses,
            size_m=intruders.size_m,
            box_xyxy=box_xyxy,
            visible_fraction=fraction,
            is_absent=~here,
        )
        contrast_k, to_noise = contrasts(
            seen.radiance,
            capture.instance_id,
            intruders.instance_id,
            box_xyxy,
            self._config.netd_k,
        )
        centres_m = poses[:, :3, 3] + 0.5 * intruders.size_m[:, 2:] * poses[:, :3, 2]
        time_s = common["time_s"]
        truth = HarbourTruth(
            **common,
            names=intruders.names,
            kinds=intruders.kinds,
            bounds_m=intruders.bounds_m(frame),
            instance_id=intruders.instance_id,
            speed_mps=intruders.speed_mps[frame].copy(),
            temperature_contrast_k=contrast_k,
            contrast_to_noise=to_noise,
            watched=here & is_watched(centres_m),
            tide_m=float(self._conditions.tide.above_mean_m(np.array(time_s))),
            wave_height_m=self._conditions.days[-1].waves.significant_m,
            agc_gain=seen.settings.gain,
            agc_step=seen.settings.has_stepped,
        )
        if not self.closed_loop:
            return Frame(self._observed(seen, time_s), truth)
        head = SteeredCamera(_model(self._head.camera), EgoPose(self._head.T_world_camera))
        return Frame(self._observed(seen, time_s, head), truth, steered=self._by_head(truth))

    def _by_head(self, truth: HarbourTruth) -> HarbourTruth:
        """Return the truth of the steered camera: it takes no picture, and what the overview sees counts as seen."""
        camera, T = self._head.camera, self._head.T_world_camera
        here = truth.state != "absent"
        box_xyxy = np.full(truth.box_xyxy.shape, np.nan)
        for k in np.flatnonzero(here):
            box_xyxy[k] = self._intruders.seen(camera, T, None, int(k)).box_xyxy
        position_px = centres_px(camera, T, truth.T_world_object, truth.size_m)
        state = states_of(camera, box_xyxy, truth.visible_fraction)
        state[~here] = "absent"
        side, since = self._head_exits.follow(state, box_xyxy)
        return replace(
            without_standing(without_pixels(truth)),
            T_world_camera=T,
            box_xyxy=box_xyxy,
            position_px=np.where(here[:, None], position_px, np.nan),
            state=state,
            side=side,
            frames_since_exit=since,
        )


def _surveyed(T_world_camera: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
    T = T_world_camera.copy()
    T[:3, :3] = rotation_by(rng.normal(0.0, _SURVEY_RAD, 3)) @ T[:3, :3]
    T[:3, 3] += rng.normal(0.0, _SURVEY_M, 3)
    return T


def _model(camera: PinholeCamera) -> CameraModel:
    return CameraModel(camera.width_px, camera.height_px, camera.focal_px, band="thermal")
