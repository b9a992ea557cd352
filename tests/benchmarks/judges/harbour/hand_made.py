"""A harbour made by hand: the overview camera, intruders as boxes, clutter as rectangles of the picture, and tracks."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, fields
from typing import Any

import numpy as np
from numpy.typing import NDArray

from benchmarks.contract.judging import Ending, Score
from benchmarks.judges.harbour.judge import HarbourJudge
from scenarios.harbour.truth import HarbourTruth
from scenarios.scenario import Frame
from sim.optics import project
from trackers.types import CameraModel, Estimate, Observation, Track

CAMERA = CameraModel(384, 288, 770.0, band="thermal")
SEA, MOORED, BIRD, LAND = 1, 2, 3, 4
CLUTTER = {SEA: "sea", MOORED: "moored", BIRD: "bird", LAND: "land"}
FIRST_ID = 10
SIZE_M = {"person": (0.4, 0.5, 1.8), "car": (4.0, 1.7, 1.5), "boat": (7.0, 2.2, 2.2)}
INTERVAL_S = 2.0


def camera_pose() -> NDArray[np.float64]:
    """Return T_world_camera at (-100, 0, 20), aimed at the origin."""
    place = np.array([-100.0, 0.0, 20.0])
    ahead = -place / np.linalg.norm(place)
    right = np.array([0.0, -1.0, 0.0])
    T = np.eye(4)
    T[:3, :3] = np.stack([right, np.cross(ahead, right), ahead], axis=1)
    T[:3, 3] = place
    return T


POSE = camera_pose()


@dataclass(frozen=True)
class Intruder:
    """An intruder whose centre is over (x, y) at each frame in ``places_m``, absent at others."""

    kind: str
    places_m: Mapping[int, tuple[float, float]]
    contrast_to_noise: float = 50.0
    visible: Mapping[int, float] = field(default_factory=dict)
    size_m: tuple[float, float, float] | None = None

    def size(self) -> NDArray[np.float64]:
        return np.array(self.size_m or SIZE_M[self.kind])


def standing(kind: str, at_m: tuple[float, float], frames: range, **kwargs: Any) -> Intruder:
    """Return an intruder that stands still."""
    return Intruder(kind, dict.fromkeys(frames, at_m), **kwargs)


def box_of(centre_m: NDArray[np.float64], size_m: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the box in the picture (4,) of an upright box along the axes of the world."""
    corners = centre_m + 0.5 * np.array(np.meshgrid(*[[-1, 1]] * 3)).reshape(3, -1).T * size_m
    px, _ = project(CAMERA, POSE, corners)
    return np.concatenate([px.min(axis=0), px.max(axis=0)])


def truth_of(intruders: Sequence[Intruder], k: int, *, agc_step: bool = False, clutter: int = SEA) -> HarbourTruth:
    """Return the truth of frame ``k``; moored boats fill the left fifth of the picture, a bird a few pixels."""
    count = len(intruders)
    drawn = np.full((288, 384), clutter, np.int32)
    drawn[:, :77] = MOORED
    drawn[122:126, 300:304] = BIRD
    poses, sizes, boxes, px = np.tile(np.eye(4), (count, 1, 1)), [], np.zeros((count, 4)), np.zeros((count, 2))
    here = np.array([k in each.places_m for each in intruders], dtype=bool)
    visible = np.array([each.visible.get(k, 1.0) for each in intruders])
    for n, each in enumerate(intruders):
        size = each.size()
        sizes.append(size)
        poses[n, :2, 3] = each.places_m.get(k, (0.0, 0.0))
        centre = poses[n, :3, 3] + (0, 0, 0.5 * size[2])
        boxes[n], px[n] = box_of(centre, size), project(CAMERA, POSE, centre)[0]
        if here[n] and visible[n] > 0:
            x0, y0, x1, y1 = np.round(boxes[n]).astype(int)
            drawn[max(y0, 0) : y1, max(x0, 0) : x1] = FIRST_ID + n
    x, y = poses[:, 0, 3], poses[:, 1, 3]
    given: dict[str, Any] = {
        "frame": k,
        "time_s": k * INTERVAL_S,
        "T_world_camera": POSE,
        "names": tuple(f"{each.kind}-{n}" for n, each in enumerate(intruders)),
        "kinds": tuple(each.kind for each in intruders),
        "T_world_object": poses,
        "size_m": np.array(sizes, float).reshape(count, 3),
        "position_px": px,
        "box_xyxy": boxes,
        "instance_id": FIRST_ID + np.arange(count),
        "visible_fraction": np.where(here, visible, 0.0),
        "state": np.where(here, np.where(visible >= 0.5, "in", "occluded"), "absent"),
        "side": np.array([""] * count, str),
        "frames_since_exit": np.full(count, -1),
        "instance_map": drawn,
        "depth_m": np.ones((288, 384), np.float32),
        "exposure_s": 0.0,
        "gain": 1.0,
        "contrast_to_noise": np.where(here, [each.contrast_to_noise for each in intruders], np.nan),
        "watched": here & (np.abs(x) <= 45.0) & (np.abs(y) <= 16.5),
        "agc_step": agc_step,
    }
    for named in fields(HarbourTruth):
        if named.name not in given:
            scalar = named.name in ("tide_m", "wave_height_m", "agc_gain")
            given[named.name] = 0.0 if scalar else np.zeros(count)
    return HarbourTruth(**given)


def track(
    identity: int,
    at_m: tuple[float, float],
    kind: str = "person",
    confidence: float | None = None,
    *,
    size_m: Sequence[float] | None = None,
    named: str | None = None,
) -> Track:
    """Return a track with its centre over (x, y), of the size of its kind."""
    size = np.array(SIZE_M[kind] if size_m is None else size_m, float)
    centre = np.array([*at_m, 0.5 * size[2]])
    px, depth_m = project(CAMERA, POSE, centre)
    estimate = Estimate(px, box_of(centre, size), depth_m=float(depth_m))
    return Track(identity, estimate, named, size, confidence)


@dataclass
class HarbourMapByHand:
    """What the judge asks of a map."""

    clutter: Mapping[int, str] = field(default_factory=lambda: dict(CLUTTER))


@dataclass
class EpisodeByHand:
    """What the judge asks of an episode."""

    rate_hz: float = 1.0 / INTERVAL_S

    def map_of(self) -> HarbourMapByHand:
        return HarbourMapByHand()


def frame_of(truth: HarbourTruth) -> Frame:
    """Return the truth with a grey picture."""
    model = CameraModel(CAMERA.width_px, CAMERA.height_px, CAMERA.focal_px, band="thermal")
    grey = np.broadcast_to(np.uint8(90), (288, 384, 3))
    return Frame(Observation(grey, truth.time_s, model), truth)


def judged(
    intruders: Sequence[Intruder],
    frames: int,
    answer: Callable[[int], Sequence[Track]],
    *,
    steps: Sequence[int] = (),
    clutter: int = SEA,
    decides_at: float = 0.0,
) -> list[Score]:
    """Return the scores of the answers on all frames; the AGC steps on ``steps``."""
    judge = HarbourJudge(EpisodeByHand(), None)  # type: ignore[arg-type]
    sheet = judge.sheet()
    for k in range(frames):
        frame = frame_of(truth_of(intruders, k, agc_step=k in steps, clutter=clutter))
        judge.see(frame, None)
        sheet.keep(frame, answer(k))
    return list(sheet.scores(Ending(decides_at=decides_at)))


def values(scores: Sequence[Score]) -> dict[str, Any]:
    """Return the scores of the whole episode by name."""
    return {each.metric: each.value for each in scores if each.event is None}


def of_visits(scores: Sequence[Score], metric: str) -> dict[str, Any]:
    """Return one metric by the name of the intruder."""
    return {each.event.attributes()["name"]: each.value for each in scores if each.event and each.metric == metric}
