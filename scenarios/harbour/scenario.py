"""The scenario ``harbour-v1``: a harbour through a thermal camera; people, cars and boats come and go.

There is one site, but for the presets ``SITES``, which have another one each day. All others share, in both splits,
its quay, berths, sheds, bays and lamp posts, the camera's place and its pattern of pixels; episodes differ in weather,
tide, boats, looks and ways. What was learnt on development seeds was learnt on this site: the confidences of
``harbour_mog2``, ``harbour_knn``, ``harbour_median`` and ``eigen_swarm_learnt_confidence``, the places of
``harbour_blind`` and ``harbour_posts``, the values in ``trackers/tuned``, the settings of ``harbour_watch`` and what
paper D leaves open of ``eigen_swarm``, the controllers' for the second camera. Weather and intruders of test episodes
are new, their place is not: no figure there predicts how any of them does at another harbour, where all but the
pictures without intruders and the survey is taken along; ``SITES`` measure that.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from scenarios.harbour.clutter import Afloat, Clutter
from scenarios.harbour.conditions import DAYS_BEFORE, draw_conditions, draw_waves
from scenarios.harbour.crew import Crews
from scenarios.harbour.intruders import Intruders
from scenarios.harbour.layout import FIXED, VOLUME_BOTTOM_M, Site
from scenarios.harbour.pictureless.bank import HarbourPictureless
from scenarios.harbour.plan import draw_plan
from scenarios.harbour.presets import PRESETS
from scenarios.harbour.scenery import build_scenery
from scenarios.harbour.sites import site_of
from scenarios.harbour.surroundings import add_surroundings
from scenarios.harbour.thermals import Thermals
from scenarios.harbour.truth import HarbourMap, HarbourTruth, contrasts
from scenarios.objects import Labels
from scenarios.pan_tilt_zoom import Head, Mount
from scenarios.scenario import Scenario, Setup
from scenarios.stage import SceneCamera, Stage
from sim.pose import rotation_by
from sim.render.pipeline import Capture
from sim.sensors.thermal_sensor import ThermalConfig, ThermalSensor
from sim.world import World
from trackers.types import CameraModel, Carrier, CommandAxis, EgoPose, Observation, Start

HEAD = Carrier(
    "harbour-head",
    (CommandAxis("pan_rad_s", 1.0, 4.0), CommandAxis("tilt_rad_s", 0.6, 3.0), CommandAxis("zoom_per_s", 0.7, 3.0)),
    "around",
)
"""Limits are those of a surveillance head with a motor zoom."""
LENS = CameraModel.from_field_of_view(384, 288, float(np.deg2rad(5.0)), band="thermal")
"""Of its camera at zoom 1: at 100 m it sees 9 m, and a person 75 pixels tall."""


def mount_at(site: Site) -> Mount:
    """Return the head of the second camera, on the mast of the overview camera, to its right and below it."""
    (x, y, z), (ahead, left) = site.camera_m, site.volume_axes
    right_x, right_y = -0.8 * left
    return Mount(
        HEAD,
        LENS,
        place_m=(x + float(right_x), y + float(right_y), z - 0.5),
        aim_m=(0.0, 0.0, 0.0),
        ahead=(float(ahead[0]), float(ahead[1]), 0.0),
        left=(float(left[0]), float(left[1]), 0.0),
        widest_pan_rad=0.9,
        tilt_rad=(-0.9, 0.1),
        zoom=(0.5, 3.0),
    )


MOUNT = mount_at(FIXED)


_SURVEY_RAD, _SURVEY_M = np.deg2rad(0.02), 0.05
"""Standard deviations of the surveyed pose of the camera."""
_DRAWN_CAMERA = ThermalConfig(plateau=0.015, linear=0.2, detail=24.0)
"""Of drawn harbours: it shows waves of half a kelvin beside a quay in the sun that is 20 K warmer."""
_BACKGROUND_FROM = 4000
"""Number of the sensor's first frame of the days before, or a later one: no noise of the episode's own repeats."""


class HarbourEpisode(Stage):
    """See ``scenarios.scenario.Episode``. In closed loop the steered camera follows the first of ``patrols``."""

    _objects: Intruders

    def __init__(self, setup: Setup) -> None:
        preset = setup.preset
        if setup.closed_loop:
            # There is a target from the first picture on.
            preset = replace(preset, patrols=max(preset.patrols, 1))
        self._preset = preset
        self._time_s = np.arange(preset.frame_count) / preset.rate_hz
        self._site = site = site_of(preset, setup)
        camera = site.camera
        scale = min(preset.width_px / camera.width_px, preset.height_px / camera.height_px)
        self._view = replace(
            camera, width_px=preset.width_px, height_px=preset.height_px, focal_px=camera.focal_px * scale
        )
        self._conditions = draw_conditions(preset, setup.day_rng("conditions"))
        # Alone on its day an episode draws all of a kind from one stream.
        alone = preset.episodes_a_day == 1
        plan = draw_plan(preset, setup.rng("plan"), None if alone else setup.day_rng("bays"), site)
        world = World()
        scenery = build_scenery(world, setup.day_rng("scenery"), site)
        if site.is_drawn:
            scenery.surfaces.extend(add_surroundings(world, site, setup.day_rng("surroundings")))
        waves = draw_waves(self._conditions, setup.day_rng("waves"))
        carrying = waves if preset.swell_period_s is not None else []
        self._clutter = Clutter(world, plan, self._conditions, setup.day_rng("clutter"), site, carrying)
        self._labels = {body.index: body.category for body in world.bodies}
        intruders = Intruders(
            world,
            plan,
            self._conditions,
            self._time_s,
            setup.rng("looks"),
            scenery.bay_k,
            carrying[-1] if carrying else None,
        )
        weather = self._conditions.days[-1].weather
        self._crews = Crews(world, intruders, weather, setup.rng("crew")) if site.is_drawn else None
        self._thermals = Thermals(
            world,
            self._conditions,
            scenery.surfaces,
            self._clutter,
            intruders,
            preset.rate_hz,
            waves,
            self._crews,
        )
        self._shader = self._thermals.shader
        self._afloat = self._clutter.afloat(self._time_s, before=False)
        self._config = replace(_DRAWN_CAMERA if site.is_drawn else ThermalConfig(), rate_hz=preset.rate_hz)
        self._T_world_camera = site.overview_pose()
        self._surveyed = EgoPose(_surveyed(self._T_world_camera, setup.day_rng("survey")))
        super().__init__(
            setup,
            intruders,
            self._overview(setup, world, None if alone else setup.rng("noise")),
            standing=[*self._clutter.standing, *(self._crews.standing if self._crews is not None else ())],
            head=self._head_before(setup, intruders),
        )

    def _head_before(self, setup: Setup, intruders: Intruders) -> Head:
        """Return the head of the steered camera."""
        return Head(mount_at(self._site), setup.preset.rate_hz)

    @property
    def start(self) -> Start:
        """The calibration, the survey of the site, and pictures of the days before; in closed loop the target's box."""
        start = super().start
        return replace(start, site=self._site.survey, box_xyxy=start.box_xyxy if self.closed_loop else None)

    def map_of(self) -> HarbourMap:
        """Return what is where."""
        site = self._site
        high, span = 900.0, site.span_m
        return HarbourMap(
            np.array(site.volume_m),
            np.array([0.0, 0.0, VOLUME_BOTTOM_M + 0.5 * site.volume_m[2]]),
            site.volume_axes,
            dict(self._labels),
            np.array([*site.edge_m, (high, span), (high, -span)]),
            np.array(site.edge_m),
        )

    def _move_to(self, frame: int) -> None:
        self._objects.move_to(frame)
        if self._crews is not None:
            self._crews.move_to(frame)
        self._clutter.move_to(self._afloat, frame, DAYS_BEFORE)
        self._thermals.show_frame(frame)

    def _overview(self, setup: Setup, world: World, noise_rng: np.random.Generator | None = None) -> SceneCamera:
        """Return the overview camera; all have the same pattern of pixels, as there is only one."""
        sensor = ThermalSensor(self._config, setup.day_rng("sensor"), noise_rng)
        return SceneCamera(setup, world, self._view, sensor)

    def _ego(self) -> EgoPose:
        return self._surveyed

    def _empty_pictures(self) -> list[Observation]:
        """Return pictures of the days before."""
        time_s = self._conditions.background_times(self._preset.background)
        if not len(time_s):
            return []
        afloat: Afloat = self._clutter.afloat(time_s, before=True)
        camera = self._overview(self._setup, self.world)
        self._objects.take_out()
        if self._crews is not None:
            self._crews.take_out()
        pictures = []
        first = max(_BACKGROUND_FROM, self.frame_count)
        for k, each in enumerate(time_s.tolist()):
            self._clutter.move_to(afloat, k, self._conditions.day_at(each))
            self._thermals.show_earlier(each)
            frame = first + round((each - time_s[0]) * self.rate_hz)
            seen = camera.take(self._shader, self._T_world_camera, frame)
            pictures.append(camera.observation(seen.picture, each, self._surveyed))
        return pictures

    def _own_truth(self, capture: Capture[Any], labels: Labels) -> dict[str, Any]:
        intruders, picture = self._objects, capture.picture
        contrast_k, to_noise = contrasts(
            picture.radiance, capture.instance_id, intruders.instance_id, labels.box_xyxy, self._config.netd_k
        )
        poses = intruders.T_world_object
        centres_m = poses[:, :3, 3] + 0.5 * intruders.size_m[:, 2:] * poses[:, :3, 2]
        return {
            "temperature_contrast_k": contrast_k,
            "contrast_to_noise": to_noise,
            "watched": intruders.present & self._site.is_watched(centres_m),
            "tide_m": float(self._conditions.tide.above_mean_m(np.array(self._frame / self.rate_hz))),
            "wave_height_m": self._conditions.days[-1].waves.significant_m,
            "agc_gain": picture.settings.gain,
            "agc_step": picture.settings.has_stepped,
        }


def _surveyed(T_world_camera: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
    T = T_world_camera.copy()
    T[:3, :3] = rotation_by(rng.normal(0.0, _SURVEY_RAD, 3)) @ T[:3, :3]
    T[:3, 3] += rng.normal(0.0, _SURVEY_M, 3)
    return T


def day_of(preset: Any, seed: int) -> int:
    """Return the seed of the first episode of the same day, see ``Scenario.day_of``."""
    return seed - seed % int(preset.episodes_a_day)


HARBOUR = Scenario(
    id="harbour-v1",
    summary="a harbour through a thermal camera; people, cars and boats come and go",
    start=(
        "pictures of three earlier days without intruders, the surveyed pose of the camera, and the survey of the "
        "site: quay, mean water, watched volume"
    ),
    stage=HarbourEpisode,
    presets=PRESETS,
    classes={kind: kind for kind in ("person", "car", "boat")},
    carrier=HEAD,
    truth=HarbourTruth,
    target="person-0",
    pictureless=HarbourPictureless(),
    day_of=day_of,
)
