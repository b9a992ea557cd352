"""People and cyclists on the pavements: they walk around the blocks, cross streets, and stand in groups.

The motion of all cars is known before theirs is drawn: they step onto a street only if no car comes near while they are
on it, and keep off wherever a car leaves the road. So people wait for cars, never the other way round, and the traffic
of an episode is the same with them and without.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np
import shapely
from numpy.typing import NDArray
from scipy.spatial import KDTree

from scenarios.road_town.blocks import FreeGround
from scenarios.road_town.canvas import rings_of
from scenarios.road_town.layout import Layout
from scenarios.road_town.road_map import RoadMap
from scenarios.road_town.traffic import Motion
from sim.meshes.pedestrian import PedestrianLook, draw_look, stride_rate_radps
from sim.pose import pose_on_ground

NEAR_KERB_M, FAR_FROM_KERB_M = 0.85, 1.5
"""Lines on which people walk: along the kerb one way, along the gardens the other way."""
CAR_CLEAR_M, CAR_CLEAR_S = 0.75, 0.7
"""Least distance from a car's sides and ends, and the time before and after a person for which it holds."""
_STEP_M = 0.25
_GROUPED = 0.25
"""Share of people who stand in groups."""
_CROSSES = 0.5
"""Share of the crossings passed at which a person crosses."""
_GAP_M = {"person": 0.9, "cyclist": 2.3}
_SPEED_MPS = {"person": (1.35, 0.2, 0.8, 1.9), "cyclist": (4.0, 0.6, 2.8, 5.2)}
"""Mean, standard deviation, least and greatest (of people: Bohannon 1997, comfortable gait)."""
_NEAR_TARGET_M = 40.0
_PATIENCE_S = 12.0
"""Time after which one who waits to cross walks on."""
_LOOKS_EVERY = 3
"""Frames between two looks for a gap in the traffic."""


@dataclass(frozen=True, eq=False)
class PassersBy:
    """N people and cyclists over T frames.

    Attributes:
        kinds: ``person`` or ``cyclist``. looks: of each.
        T_world: (T, N, 4, 4). speed_mps, phase_rad: (T, N), the latter of their strides.
    """

    kinds: tuple[str, ...]
    looks: tuple[PedestrianLook, ...]
    T_world: NDArray[np.float64]
    speed_mps: NDArray[np.float64]
    phase_rad: NDArray[np.float64]


class Cars:
    """All moving cars of an episode as rectangles, at any frame."""

    def __init__(self, motion: Motion, sizes_m: NDArray[np.float64], rate_hz: float) -> None:
        self.motion, self.rate_hz = motion, rate_hz
        self.half_m = 0.5 * sizes_m[:, :2]
        self._window = np.arange(-round(CAR_CLEAR_S * rate_hz), round(CAR_CLEAR_S * rate_hz) + 1)

    def keep_off(self, points_m: NDArray[np.float64], frames: NDArray[np.floating[Any]]) -> bool:
        """Return whether no car is near any of the points (K, 2) around the frames (K,) on which a person is there."""
        last = len(self.motion.position_m) - 1
        at = np.clip(np.rint(frames)[:, None].astype(int) + self._window, 0, last)
        return not bool(self._near(points_m[:, None], at).any())

    def hits(self, points_m: NDArray[np.float64]) -> NDArray[np.bool_]:
        """Return whether a car ever comes near each of the points (M, 2)."""
        found = np.zeros(len(points_m), bool)
        tree = KDTree(points_m)
        reach_m = float(np.hypot(*self.half_m.T).max()) + CAR_CLEAR_M
        for car in range(self.motion.position_m.shape[1]):
            places = self.motion.position_m[:, car]
            for frame, near in enumerate(tree.query_ball_point(places, reach_m)):
                if near:
                    found[near] |= self._in_one(points_m[near], frame, car)
        return found

    def _in_one(self, points_m: NDArray[np.float64], frame: int, car: int) -> NDArray[np.bool_]:
        heading = self.motion.heading_rad[frame, car]
        c, s = np.cos(heading), np.sin(heading)
        x, y = (points_m - self.motion.position_m[frame, car]).T
        along, across = np.abs(c * x + s * y), np.abs(c * y - s * x)
        half = self.half_m[car] + CAR_CLEAR_M
        return np.asarray((along < half[0]) & (across < half[1]))

    def _near(self, points_m: NDArray[np.float64], frames: NDArray[np.int64]) -> NDArray[np.bool_]:
        """Return whether each car is near points (K, 1, 2) at frames (K, W): (K, W, N)."""
        offset = points_m[:, :, None] - self.motion.position_m[frames]
        heading = self.motion.heading_rad[frames]
        c, s = np.cos(heading), np.sin(heading)
        along = np.abs(c * offset[..., 0] + s * offset[..., 1]) < self.half_m[:, 0] + CAR_CLEAR_M
        across = np.abs(c * offset[..., 1] - s * offset[..., 0]) < self.half_m[:, 1] + CAR_CLEAR_M
        return np.asarray(along & across)


@dataclass(eq=False)
class _Line:
    """A closed walking line around a block, walked one way.

    Attributes:
        points_m: (M, 2), about ``_STEP_M`` apart. heading_rad: (M,).
        hit: (M,) whether a car ever comes near. doors: place -> (line, place) beyond a street.
    """

    points_m: NDArray[np.float64]
    heading_rad: NDArray[np.float64]
    hit: NDArray[np.bool_]
    doors: dict[int, tuple[int, int]] = field(default_factory=dict)


@dataclass(eq=False)
class _Walker:
    kind: str
    speed_mps: float
    line: int
    place: float
    crossing: tuple[NDArray[np.float64], NDArray[np.float64], int, int] | None = None
    done_m: float = 0.0
    free_until: float = -1.0
    passed: int = -1
    wants: int = -1
    patience: int = 0
    waits: bool = False


def draw_passers_by(
    layout: Layout,
    motion: Motion,
    sizes_m: NDArray[np.float64],
    path_m: NDArray[np.float64],
    numbers: dict[str, tuple[int, int]],
    rate_hz: float,
    rng: np.random.Generator,
) -> PassersBy:
    """Draw people and cyclists, most of them near the target's path, and move them through the episode.

    Args:
        sizes_m: (N, 3) of the cars. path_m: (T, 2) of the target.
        numbers: kind -> range of how many there are; fewer where there is no room.
    """
    cars = Cars(motion, sizes_m, rate_hz)
    lines = _lines(layout, cars)
    wanted = {kind: int(rng.integers(low, high + 1)) for kind, (low, high) in numbers.items()}
    near = KDTree(path_m)
    starts = _Starts(lines, near, rng)
    standing = round(_GROUPED * wanted.get("person", 0))
    walkers: list[_Walker] = []
    for kind, count in wanted.items():
        for _ in range(count - (standing if kind == "person" else 0)):
            found = starts.draw(2.5 if kind == "cyclist" else 1.3)
            if found is not None:
                mean, deviation, least, most = _SPEED_MPS[kind]
                walkers.append(_Walker(kind, float(np.clip(rng.normal(mean, deviation), least, most)), *found))
    groups = _stand_in_groups(layout, lines, starts, motion, standing, rng)
    frames, count = len(motion.position_m), len(walkers) + len(groups)
    looks = tuple(draw_look(rng) for _ in range(count))
    T_world, speed = np.tile(np.eye(4), (frames, count, 1, 1)), np.zeros((frames, count))
    for frame in range(frames):
        for k, (place_m, heading_rad) in enumerate(_walk(walkers, lines, cars, frame, speed[frame], rng)):
            T_world[frame, k] = pose_on_ground(place_m[0], place_m[1], heading_rad)
    for k, (place_m, heading_rad) in enumerate(groups, start=len(walkers)):
        T_world[:, k] = pose_on_ground(place_m[0], place_m[1], heading_rad)
    kinds = (*(walker.kind for walker in walkers), *("person" for _ in groups))
    rates = np.array([[stride_rate_radps(look, v) for look, v in zip(looks, row, strict=True)] for row in speed])
    first_rad = rng.uniform(0.0, 2.0 * np.pi, count)
    phase = first_rad + np.cumsum(rates.reshape(frames, count), axis=0) / rate_hz
    return PassersBy(kinds, looks, T_world, speed, phase)


def _lines(layout: Layout, cars: Cars) -> list[_Line]:
    """Return the walking lines: for each block one along the kerb and one along the gardens, the other way round."""
    roads = RoadMap(layout.graph)
    lines: list[_Line] = []
    for aside_m, backwards in ((NEAR_KERB_M, False), (FAR_FROM_KERB_M, True)):
        for ring in rings_of(roads.area.buffer(aside_m)):
            if ring.length < 60.0:
                continue
            steps = np.linspace(0.0, ring.length, round(ring.length / _STEP_M), endpoint=False)
            points = shapely.get_coordinates(shapely.line_interpolate_point(ring, steps))
            # Walkers keep to the right of those who come towards them, whichever way shapely has turned the ring.
            if shapely.is_ccw(ring) == backwards:
                points = points[::-1]
            ahead = np.roll(points, -2, axis=0) - np.roll(points, 2, axis=0)
            heading = np.arctan2(ahead[:, 1], ahead[:, 0])
            lines.append(_Line(np.ascontiguousarray(points), heading, cars.hits(points)))
    near_kerb = [k for k, line in enumerate(lines) if roads.area.distance(shapely.Point(line.points_m[0])) < 1.2]
    trees = {k: KDTree(lines[k].points_m) for k in near_kerb}
    for street, arc_m in layout.zebras:
        half_m = 0.5 * roads.width_m[street] + NEAR_KERB_M
        ends = []
        for side in (-1.0, 1.0):
            place_m, _ = roads.pose_at(street, arc_m, side * half_m)
            away, k = min((*trees[k].query(place_m), k)[::2] for k in near_kerb)
            if away < 2.0:
                ends.append((k, int(trees[k].query(place_m)[1])))
        if len(ends) == 2:
            for here, there in (ends, ends[::-1]):
                lines[here[0]].doors[here[1]] = there
    return lines


class _Starts:
    """Places on the walking lines where somebody may start: more of them near the target's path."""

    def __init__(self, lines: list[_Line], near: KDTree, rng: np.random.Generator) -> None:
        self._rng = rng
        self._line = np.repeat(np.arange(len(lines)), [len(line.points_m) for line in lines])
        self._place = np.concatenate([np.arange(len(line.points_m)) for line in lines])
        self.points_m = np.concatenate([line.points_m for line in lines])
        away_m = near.query(self.points_m)[0]
        weight = np.exp(-((away_m / _NEAR_TARGET_M) ** 2)) + 0.02
        weight[np.concatenate([line.hit for line in lines])] = 0.0
        self._sum = np.cumsum(weight)
        self.taken_m: list[NDArray[np.float64]] = []

    def draw(self, apart_m: float) -> tuple[int, float] | None:
        """Return (line, place) away from all before."""
        for _ in range(40):
            k = int(np.searchsorted(self._sum, self._rng.random() * self._sum[-1]))
            here = self.points_m[k]
            if all(np.hypot(*(here - other)) > apart_m for other in self.taken_m):
                self.taken_m.append(here)
                return int(self._line[k]), float(self._place[k])
        return None


def _stand_in_groups(
    layout: Layout, lines: list[_Line], starts: _Starts, motion: Motion, count: int, rng: np.random.Generator
) -> list[tuple[NDArray[np.float64], float]]:
    """Return places and headings of people who stand together behind the pavements, facing each other."""
    ground = FreeGround.of(layout)
    people: list[tuple[NDArray[np.float64], float]] = []
    driven = KDTree(motion.position_m.reshape(-1, 2))
    for _ in range(30 * count):
        if len(people) >= count:
            break
        found = starts.draw(0.0)
        assert found is not None
        middle = lines[found[0]].points_m[int(found[1])] + rng.uniform(-2.2, 2.2, 2)
        if driven.query(middle)[0] < 4.5 or not ground.take(middle, (1.5, 1.5), 0.0, 0.0):
            continue
        size = min(int(rng.integers(1, 5)), count - len(people))
        turn = float(rng.uniform(0.0, 2.0 * np.pi))
        for k in range(size):
            angle = turn + 2.0 * np.pi * k / size + float(rng.normal(0.0, 0.2))
            reach_m = 0.0 if size == 1 else 0.5
            people.append((middle + reach_m * np.array([np.cos(angle), np.sin(angle)]), angle + np.pi))
    return people


def _walk(
    walkers: list[_Walker],
    lines: list[_Line],
    cars: Cars,
    frame: int,
    speed_mps: NDArray[np.float64],
    rng: np.random.Generator,
) -> list[tuple[NDArray[np.float64], float]]:
    """Return where all are on a frame, write how fast they go on, and move them to the next frame."""
    shown = [_pose(walker, lines) for walker in walkers]
    dt_s = 1.0 / cars.rate_hz
    for k, walker in enumerate(walkers):
        limit = _free_speed(walker, walkers, lines)
        if walker.crossing is not None:
            start, end, line, place = walker.crossing
            walker.done_m += walker.speed_mps * dt_s
            speed_mps[k] = walker.speed_mps
            if walker.done_m >= np.linalg.norm(end - start):
                walker.crossing, walker.line, walker.place, walker.passed = None, line, float(place), place
                walker.free_until = -1.0
            continue
        waits = _must_wait(walker, walkers, lines, cars, frame, limit, rng)
        # Where cars come, nobody slows down for others: the gap was for this speed.
        speed_mps[k] = 0.0 if waits else walker.speed_mps if walker.free_until >= 0.0 else limit
        if walker.crossing is None:
            walker.place = (walker.place + speed_mps[k] * dt_s / _STEP_M) % len(lines[walker.line].points_m)
    return shown


def _pose(walker: _Walker, lines: list[_Line]) -> tuple[NDArray[np.float64], float]:
    if walker.crossing is not None:
        start, end, _, _ = walker.crossing
        along = (end - start) / np.linalg.norm(end - start)
        return start + walker.done_m * along, float(np.arctan2(along[1], along[0]))
    line, k = lines[walker.line], int(walker.place)
    share, after = walker.place - k, (k + 1) % len(line.points_m)
    return line.points_m[k] + share * (line.points_m[after] - line.points_m[k]), float(line.heading_rad[k])


def _free_speed(walker: _Walker, walkers: list[_Walker], lines: list[_Line]) -> float:
    """Return the speed at which the walker does not run into the next one on its line."""
    speed, count = walker.speed_mps, len(lines[walker.line].points_m)
    for other in walkers:
        if other is walker or other.line != walker.line or other.crossing is not None:
            continue
        gap_m = ((other.place - walker.place) % count) * _STEP_M
        need_m = max(_GAP_M[walker.kind], _GAP_M[other.kind])
        if gap_m < need_m + 0.6:
            speed = min(speed, 0.9 * other.speed_mps if gap_m > need_m and not other.waits else 0.0)
    return speed


def _must_wait(
    walker: _Walker,
    walkers: list[_Walker],
    lines: list[_Line],
    cars: Cars,
    frame: int,
    speed_mps: float,
    rng: np.random.Generator,
) -> bool:
    """Return whether the walker stands on this frame; a crossing that is free begins."""
    line = lines[walker.line]
    k, count = int(walker.place), len(line.points_m)
    ahead = range(k, k + 1 + int(np.ceil(speed_mps / cars.rate_hz / _STEP_M)) + 1)
    walker.waits = False
    if walker.wants < 0:
        door = next((at % count for at in ahead if at % count in line.doors and at % count != walker.passed), -1)
        if door >= 0:
            walker.passed = door
            if walker.kind == "person" and not line.hit[door] and rng.random() < _CROSSES:
                walker.wants, walker.patience = door, round(_PATIENCE_S * cars.rate_hz)
    if walker.wants >= 0:
        walker.patience -= 1
        if frame % _LOOKS_EVERY == 0:
            _try_to_cross(walker, walkers, lines, cars, frame, walker.wants)
        if walker.crossing is not None or walker.patience < 0:
            walker.wants = -1
        walker.waits = walker.wants >= 0
        return walker.waits
    if walker.free_until >= 0.0 and (walker.place - walker.free_until) % count < 0.5 * count:
        walker.free_until = -1.0
    blocked = [at for at in ahead if line.hit[at % count]]
    if not blocked or walker.free_until >= 0.0:
        return False
    end = blocked[0]
    while line.hit[end % count] and end < blocked[0] + count:
        end += 1
    places = np.arange(k, end + 2)
    frames = frame + (places - walker.place) * _STEP_M / max(walker.speed_mps, 0.1) * cars.rate_hz
    if frame % _LOOKS_EVERY == 0 and cars.keep_off(line.points_m[places % count], frames):
        walker.free_until = float((end + 1) % count)
        return False
    walker.waits = True
    return True


def _try_to_cross(
    walker: _Walker, walkers: list[_Walker], lines: list[_Line], cars: Cars, frame: int, door: int
) -> None:
    """Begin to cross the street if no car comes, and nobody is where the walker would arrive."""
    there, place = lines[walker.line].doors[door]
    start, _ = _pose(walker, lines)
    end = lines[there].points_m[place]
    length_m = float(np.linalg.norm(end - start))
    along = np.linspace(0.0, 1.0, max(2, round(length_m / 0.3)))
    frames = frame + along * length_m / walker.speed_mps * cars.rate_hz
    points = start + along[:, None] * (end - start)
    if lines[there].hit[place] or not cars.keep_off(points, frames):
        return
    for other in walkers:
        if other.crossing is not None and other.crossing[2:] == (there, place):
            return
        if other.crossing is None and other.line == there and other is not walker:
            later = other.place + other.speed_mps * length_m / walker.speed_mps / _STEP_M
            count = len(lines[there].points_m)
            if min((later - place) % count, (place - later) % count) * _STEP_M < 1.2:
                return
    walker.crossing, walker.done_m = (start, end, there, place), 0.0
