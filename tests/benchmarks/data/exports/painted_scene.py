"""A scene of three painted rectangles, whose truth follows from counting pixels.

The target, a car, runs to the right behind a bus, and out of the picture. A kite is behind the camera for the first two
frames and has no box there. Importing it adds ``painted-v1`` to the catalogue.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from benchmarks.data.sets.channels import NORMALS, channels_of
from benchmarks.data.sets.data_set import REQUEST, DataSet
from benchmarks.data.sets.episode_writer import write_episode
from benchmarks.data.sets.places import place_of
from benchmarks.data.sets.request import Request
from scenarios import catalog
from scenarios.scenario import Frame, Scenario, Setup
from scenarios.truth import Keypoints, Truth, keypoints_field, truth_field
from tests.benchmarks.fake_episode import FakeEpisode
from trackers.types import CameraCommand, CameraModel, Carrier, Observation, Start

WIDTH_PX, HEIGHT_PX, FOCAL_PX = 40, 32, 50.0
FRAMES = 9
NAMES, KINDS = ("bus-1", "target", "kite-1"), ("bus", "car", "kite")
CLASSES = {"bus": "bus", "van": "car", "car": "car", "kite": "kite"}
PARKED_XYXY, PARKED_ID = np.array([4.0, 26.0, 12.0, 30.0]), 9
"""A van that stands about, in the preset ``parked``; nothing hides it."""
IDS = np.array([4, 2, 7])
DEPTHS_M = np.array([5.0, 8.0, 20.0])
NO_BOX = np.full(4, np.nan)


@dataclass(frozen=True)
class Painted:
    """Configuration of an episode."""

    summary: str
    frame_count: int = FRAMES
    width_px: int = WIDTH_PX
    height_px: int = HEIGHT_PX
    closed_loop: bool = False
    baseline_m: float | None = 0.5
    first_x_px: float = 2
    lost: int = -1
    parks: bool = False
    turns_at: int = 1000


BUMPERS = Keypoints(("rear", "middle", "front"), ((0, 1), (1, 2)), (0.1,) * 3, (0.5,) * 3, "keypoints_m")
"""Points of the car, 30 cm below its surface."""


@dataclass(frozen=True, slots=True)
class PaintedTruth(Truth):
    """Truth of one frame.

    Attributes:
        keypoints_m: (3, 3, 3), of the car alone.
        flow_px: (H, W, 2) each pixel's place in the previous frame minus its present one; NaN without a surface.
    """

    keypoints: ClassVar[Mapping[str, Keypoints]] = {"car": BUMPERS}

    flow_px: NDArray[np.float32] = truth_field("px", "H", "W", 2, coding="x, y", left_out=True)
    keypoints_m: NDArray[np.float64] = keypoints_field(BUMPERS)


def boxes_at(preset: Painted, frame: int) -> NDArray[np.float64]:
    """Return the amodal boxes (3, 4)."""
    x = max(preset.first_x_px, preset.first_x_px + 6 * min(frame, 2 * preset.turns_at - frame))
    kite = NO_BOX if frame < 2 else np.array([30.0, 2.0, 34.0, 5.0])
    return np.array([[16.0, 8.0, 28.0, 24.0], [x, 10.0, x + 8.0, 16.0], kite])


def points_px(box_xyxy: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return x, y and 0 of the car's points (3, 3) in the picture."""
    x_min, y_min, x_max, y_max = box_xyxy
    y = 0.5 * (y_min + y_max)
    return np.array([[x_min + 0.5, y, 0.0], [0.5 * (x_min + x_max), y, 0.0], [x_max - 0.5, y, 0.0]])


@dataclass
class PaintedEpisode(FakeEpisode):
    """See ``scenarios.scenario.Episode``."""

    rate_hz: float = 7.5
    preset: Painted = Painted("")
    seed: int = 0

    @property
    def start(self) -> Start:
        return Start(self._camera, boxes_at(self.preset, 0)[1])

    @property
    def _camera(self) -> CameraModel:
        return CameraModel(WIDTH_PX, HEIGHT_PX, FOCAL_PX, self.preset.baseline_m)

    def step(self, command: CameraCommand | None = None) -> Frame:
        self._frame += 1
        rng = np.random.default_rng([self.seed, self._frame])
        left, right = rng.integers(0, 256, (2, HEIGHT_PX, WIDTH_PX, 3), dtype=np.uint8)
        pair = self.preset.baseline_m is not None and self._frame != self.preset.lost
        truth = truth_at(self.preset, self._frame, self.rate_hz)
        observation = Observation(left, truth.time_s, self._camera, right_rgb=right if pair else None)
        return Frame(observation, truth)

    def normals(self) -> NDArray[np.float32]:
        return np.zeros((HEIGHT_PX, WIDTH_PX, 3), np.float32)


def truth_at(preset: Painted, frame: int, rate_hz: float) -> PaintedTruth:
    """Return the truth of a frame; the sky is the upper rows, without depth and flow."""
    boxes = boxes_at(preset, frame)
    instance_map = np.full((HEIGHT_PX, WIDTH_PX), -1, np.int32)
    depth_m = np.full((HEIGHT_PX, WIDTH_PX), 60.25, np.float32)
    depth_m[:4] = np.inf
    flow_px = np.zeros((HEIGHT_PX, WIDTH_PX, 2), np.float32)
    flow_px[:4] = np.nan
    for k in np.argsort(-DEPTHS_M):
        if not np.isnan(boxes[k]).any():
            x_min, y_min, x_max, y_max = boxes[k].astype(int).clip(0)
            instance_map[y_min:y_max, x_min:x_max] = IDS[k]
            depth_m[y_min:y_max, x_min:x_max] = DEPTHS_M[k]
            flow_px[y_min:y_max, x_min:x_max] = (-6.03, 0.26) if k == 1 and frame > 0 else 0.0
    standing = {}
    if preset.parks:
        x_min, y_min, x_max, y_max = PARKED_XYXY.astype(int)
        instance_map[y_min:y_max, x_min:x_max] = PARKED_ID
        standing = {
            "standing_names": ("parked-0",),
            "standing_kinds": ("van",),
            "standing_id": np.array([PARKED_ID]),
            "T_world_standing": np.eye(4)[None],
            "standing_bounds_m": np.array([[[-1.0, -1.0, 0.0], [3.0, 1.0, 2.0]]]),
            "standing_box_xyxy": PARKED_XYXY[None],
            "standing_visible_fraction": np.ones(1),
        }
    seen = np.array([(instance_map == number).sum() for number in IDS])
    own = np.nan_to_num(np.prod(boxes[:, 2:] - boxes[:, :2], axis=1), nan=12.0)
    share = seen / own
    left_of_border = boxes[:, 0] < WIDTH_PX
    inside = boxes[:, 2] <= WIDTH_PX
    state = np.select([~left_of_border, ~inside, share < 0.5], ["out", "partial", "occluded"], "in")
    keypoints_m = np.full((3, 3, 3), np.nan)
    keypoints_m[1] = points_px(boxes[1]) - [[WIDTH_PX / 2, HEIGHT_PX / 2, -FOCAL_PX]]
    keypoints_m[1] *= (DEPTHS_M[1] + 0.3) / FOCAL_PX
    return PaintedTruth(
        frame=frame,
        time_s=frame / rate_hz,
        T_world_camera=np.eye(4),
        names=NAMES,
        kinds=KINDS,
        T_world_object=np.tile(np.eye(4), (3, 1, 1)),
        size_m=np.ones((3, 3)),
        speed_mps=np.array([0.0, 1.5, 0.0]),
        position_px=0.5 * (boxes[:, :2] + boxes[:, 2:]),
        box_xyxy=boxes,
        instance_id=IDS,
        visible_fraction=share,
        state=state,
        side=np.where(state == "out", "right", ""),
        frames_since_exit=np.where(state == "out", 0, -1),
        instance_map=instance_map,
        depth_m=depth_m,
        exposure_s=0.01,
        gain=1.0,
        flow_px=flow_px,
        keypoints_m=keypoints_m,
        **standing,
    )


def painted_episode(setup: Setup) -> PaintedEpisode:
    """Build one episode."""
    return PaintedEpisode(setup.preset.frame_count, preset=setup.preset, seed=setup.seed)


class PaintedScenario(Scenario):
    """Gives its episodes the seeds as they are given."""

    def _own(self, seed: int) -> int:
        return seed


PAINTED = PaintedScenario(
    id="painted-v1",
    summary="three painted rectangles",
    start="the car's box",
    stage=painted_episode,
    presets={
        "quick": Painted("two cameras"),
        "single": Painted("one camera", baseline_m=None),
        "late": Painted("the car is outside at first", first_x_px=50),
        "parked": Painted("a van stands about", baseline_m=None, parks=True),
        "returns": Painted("the car comes back", frame_count=30, baseline_m=None, first_x_px=7 / 3, turns_at=8),
        "lossy": Painted("a right picture is lost", lost=3),
    },
    classes=CLASSES,
    carrier=Carrier("easel", (), "down"),
    truth=PaintedTruth,
)
catalog.register(catalog.Entry(PAINTED.id, "tests.benchmarks.data.exports.painted_scene:PAINTED"))


def painted_data_set(
    folder: Path, preset: str = "quick", seeds: tuple[int, int] = (3, 5), pictures: str = "blosc2", without: str = ""
) -> DataSet:
    """Write episodes into a folder; return them as a data set.

    Args:
        without: a channel that is not stored.
    """
    none = ("counts",) if PAINTED.configuration(preset, seeds[0]).baseline_m else ("right_rgb", "counts")
    stored = [c for c in channels_of(PAINTED) if c not in none]
    channels = tuple(channel for channel in stored if channel not in (without, NORMALS))
    request = Request(PAINTED.id, preset, seeds, channels, pictures)
    files, root = place_of(str(folder))
    folder.mkdir(parents=True, exist_ok=True)
    (folder / REQUEST).write_text(request.as_json())
    for seed in range(*seeds):
        write_episode(files, root, request, seed, request.episode(seed))
    return DataSet(str(folder))


def cars_in_some(folder: Path) -> DataSet:
    """Return a set of cars alone, without pictures that have none: those are all pictures of training."""
    data = painted_data_set(folder, "single[first_x_px=choice(2,50)]", (2, 4))
    data.request = replace(data.request, classes=("car",), negatives=0.0, splits={"train": 0.5, "val": 0.5})
    return data


def truths(preset: str = "quick") -> list[PaintedTruth]:
    """Return the truth of all frames of an episode; it is the same for every seed."""
    painted = PAINTED.presets[preset]
    return [truth_at(painted, frame, 7.5) for frame in range(painted.frame_count)]


def picture(seed: int, frame: int) -> NDArray[np.uint8]:
    """Return the left picture of a frame."""
    rng = np.random.default_rng([seed, frame])
    return rng.integers(0, 256, (2, HEIGHT_PX, WIDTH_PX, 3), dtype=np.uint8)[0]
