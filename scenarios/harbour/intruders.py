"""The people, cars and boats that come and go: their bodies, poses on every frame, and temperatures."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from scenarios.harbour.clutter import CAR_PAINTS, HULLS
from scenarios.harbour.conditions import Conditions, float_poses, rocking
from scenarios.harbour.plan import SIZE_FACTORS, Plan, Visit, draw_car, draw_person, names_of
from scenarios.harbour.seakeeping import afloat_on
from scenarios.harbour.warmth import (
    BOAT_VIEW,
    CAR_VIEW,
    Clothes,
    DayWarmth,
    Kelvins,
    boat_materials,
    car_materials,
    draw_clothes,
    heated_k,
    level_ground,
    person_kelvins,
)
from scenarios.objects import AWAY, JointedObjects, add_parts
from sim.jointed_labels import JointedShape, joined
from sim.meshes.boat import Place, above_water, boat, places_aboard
from sim.meshes.person import person_size_m
from sim.meshes.thermal_paint import thermal_car, thermal_person
from sim.motion.gait import part_poses, stride_length_m
from sim.motion.keypoints import person_points
from sim.motion.skeleton import Skeleton, skeleton
from sim.thermal.waves import SeaWaves
from sim.thermal.weather import Weather
from sim.world import Body, World

_LEAST_SPEED_MPS = 0.05
_BOAT_M = (8.0, 2.64)
"""Length and beam of a boat of middle size."""


@dataclass(frozen=True, slots=True)
class _Intruder:
    """One visit's bodies.

    Attributes:
        bodies: its parts. shape: of its labels: of a boat, what is above its waterline.
        size_m: (3,). bones: of a person, None for others. clothes: likewise.
        materials, sky_view, heated_k (F, P): of a car or boat; see ``warmth``.
        aboard: where people have room on a boat.
        ground_k: of a cold car, see ``Visit``, how much warmer the yard about it is than one without patches.
    """

    bodies: list[Body]
    shape: JointedShape
    size_m: NDArray[np.float64]
    bones: Skeleton | None = None
    clothes: Clothes | None = None
    materials: tuple[str, ...] = ()
    sky_view: float = 0.0
    heated_k: NDArray[np.float64] | None = None
    aboard: tuple[Place, ...] = ()
    ground_k: float | None = None


class Intruders(JointedObjects):
    """N visits of people, cars and boats; the height of a boat is that above its waterline.

    Attributes:
        presence: (F, N) whether each is there. course: (F, N, 4, 4) poses, those of absent ones far below the ground;
            course_mps: (F, N) speeds, 0 for absent ones.
        aboard: of each boat by its number, where people have room on it.
    """

    def __init__(
        self,
        world: World,
        plan: Plan,
        conditions: Conditions,
        time_s: NDArray[np.float64],
        rng: np.random.Generator,
        bay_k: Mapping[float, float] | None = None,
        waves: SeaWaves | None = None,
    ) -> None:
        """Put all in a world.

        Args:
            bay_k: see ``Scenery``; needed for cars without contrast.
            waves: on which boats float; None: they move by chance.
        """
        self._waves = waves
        self.world, self._bay_k = world, bay_k or {}
        names = tuple(names_of(plan.visits))
        weather = conditions.days[-1].weather
        makers = {"person": self._person, "car": self._car, "boat": self._boat}
        self._all = [
            makers[visit.kind](visit, name, time_s, weather, rng)
            for visit, name in zip(plan.visits, names, strict=True)
        ]
        super().__init__(
            world,
            names,
            [each.kind for each in plan.visits],
            [each.bodies for each in self._all],
            np.array([each.size_m for each in self._all]),
            [each.shape for each in self._all],
            [None if each.bones is None else person_points(each.bones) for each in self._all],
        )
        self._plan_poses(plan, conditions, time_s, rng)
        self.aboard = {k: each.aboard for k, each in enumerate(self._all) if each.aboard}
        self.present = np.zeros(len(names), np.bool_)

    def _person(
        self, visit: Visit, name: str, time_s: NDArray[np.float64], weather: Weather, rng: np.random.Generator
    ) -> _Intruder:
        look = draw_person(rng)
        meshes = thermal_person(look, rng)
        bones, clothes = skeleton(look.stature_m, look.build), draw_clothes(weather, rng)
        bodies = add_parts(self.world, name, "person", meshes, AWAY)
        return _Intruder(bodies, joined(list(meshes.values())), person_size_m(look), bones, clothes)

    def _car(
        self, visit: Visit, name: str, time_s: NDArray[np.float64], weather: Weather, rng: np.random.Generator
    ) -> _Intruder:
        look = draw_car(rng)
        mesh = thermal_car(look.model, look.factors)
        materials = car_materials(str(rng.choice(CAR_PAINTS)))
        heated = heated_k("car", time_s, visit.engine_s)
        return _Intruder(
            add_parts(self.world, name, "car", {0: mesh}, AWAY),
            joined([mesh]),
            mesh.size_m.astype(float),
            materials=materials,
            sky_view=CAR_VIEW,
            heated_k=heated,
            ground_k=self._bay_k[float(visit.journey.place_m[-1, 1])] if visit.is_cold else None,
        )

    def _boat(
        self, visit: Visit, name: str, time_s: NDArray[np.float64], weather: Weather, rng: np.random.Generator
    ) -> _Intruder:
        length, beam = np.array(_BOAT_M) * rng.uniform(*SIZE_FACTORS, 2)
        model = str(rng.choice(["fisher", "launch"], p=[0.7, 0.3]))
        mesh = boat(model, float(length), float(beam))
        above = above_water(mesh)
        return _Intruder(
            add_parts(self.world, name, "boat", {0: mesh}, AWAY),
            joined([above]),
            above.size_m.astype(float),
            materials=boat_materials(str(rng.choice(HULLS))),
            sky_view=BOAT_VIEW,
            heated_k=heated_k("boat", time_s, visit.engine_s),
            aboard=places_aboard(model, float(length)),
        )

    def _plan_poses(
        self, plan: Plan, conditions: Conditions, time_s: NDArray[np.float64], rng: np.random.Generator
    ) -> None:
        shape = len(time_s), len(plan.visits)
        self.presence = np.zeros(shape, np.bool_)
        self.course_mps, self._phase_rad = np.zeros(shape), np.zeros(shape)
        self.course = np.tile(AWAY, (*shape, 1, 1))
        level_m = conditions.tide.level_m(time_s)
        waves_m = np.full(len(time_s), conditions.days[-1].waves.significant_m)
        for k, (visit, one) in enumerate(zip(plan.visits, self._all, strict=True)):
            here = (time_s >= visit.begin_s) & (time_s < visit.end_s)
            place, heading, speed = visit.journey.at(time_s)
            flat = np.zeros(len(time_s))
            height, roll, pitch = flat, flat, flat
            if visit.kind == "boat":
                rocked = rocking(time_s, waves_m, float(one.size_m[0]), rng)
                if self._waves is not None:
                    rocked = afloat_on(self._waves, time_s, place, heading, *one.size_m[:2].tolist())
                height, roll, pitch = level_m + rocked.heave_m, rocked.roll_rad, rocked.pitch_rad
            poses = float_poses(np.column_stack([place, height]), heading, roll, pitch)
            self.presence[:, k], self.course_mps[:, k] = here, np.where(here, speed, 0.0)
            self.course[here, k] = poses[here]
            if one.bones is not None:
                walked_m = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(place, axis=0).T))])
                typical = float(np.median(speed[here & (speed > 0)])) if (here & (speed > 0)).any() else 1.3
                self._phase_rad[:, k] = 2.0 * np.pi * walked_m / stride_length_m(one.bones.stature, typical)

    def move_to(self, frame: int) -> None:
        """Move all to their poses on a frame."""
        here = self.presence[frame]
        self.T_world_object, self.speed_mps = self.course[frame], self.course_mps[frame]
        self.take_out(np.flatnonzero(self.present & ~here).tolist())
        for k in np.flatnonzero(here).tolist():
            one, pose = self._all[k], self.course[frame, k]
            if one.bones is None:
                self.move_parts(k, pose[None])
            else:
                speed = float(self.speed_mps[k])
                walks = speed if speed > _LEAST_SPEED_MPS else 0.0
                self.move_parts(k, part_poses(one.bones, pose, float(self._phase_rad[frame, k]), walks))

    def warmth_kinds(self) -> set[tuple[str, float]]:
        """Return the materials and shares of sky of all cars and boats."""
        return {(name, each.sky_view) for each in self._all for name in each.materials}

    def is_heated(self, k: int) -> bool:
        """Return whether one of them has parts that an engine heats."""
        return self._all[k].heated_k is not None

    def kelvins(self, frame: int, k: int, warmth: DayWarmth) -> tuple[list[Body], Kelvins]:
        """Return the bodies of one of them, and the temperatures of its parts on a frame."""
        one = self._all[k]
        if one.clothes is not None:
            return one.bodies, person_kelvins(one.clothes, warmth)
        if one.ground_k is not None:
            return one.bodies, level_ground(warmth, len(one.materials), one.ground_k)
        shaded, sunlit, emissivity = warmth.of(one.materials, one.sky_view)
        extra = np.zeros(len(shaded)) if one.heated_k is None else one.heated_k[frame]
        return one.bodies, (shaded + extra, sunlit + extra, emissivity)
