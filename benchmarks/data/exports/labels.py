"""The labels of a stored frame: its objects with their classes, boxes and visibilities."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from benchmarks.data.sets.data_set import DataSet
from benchmarks.data.sets.stored_episode import StoredEpisode
from scenarios import catalog
from scenarios.scenario import Frame
from scenarios.visibility import MOSTLY_SEEN, states_of
from sim.checks import check
from trackers.types import CameraModel

ClassLevel = Literal["class", "kind"]
ABSENT, OUT, OCCLUDED, PARTIAL = "absent", "out", "occluded", "partial"
"""States of objects, see ``Truth.state``."""


@dataclass(frozen=True)
class StoredFrame:
    """One frame of a data set.

    Attributes:
        episode: that it is of. index: in that.
        frame: observation and truth, with those pixels only that the export reads.
        visible_xyxy: (N, 4) boxes around the visible pixels of the objects, in pixels; NaN where none is seen.
        standing_visible_xyxy: (S, 4) likewise of those that stand about.
    """

    episode: StoredEpisode
    index: int
    frame: Frame
    visible_xyxy: NDArray[np.float64]
    standing_visible_xyxy: NDArray[np.float64]

    @property
    def camera(self) -> CameraModel:
        """Geometry of the camera."""
        return self.frame.observation.camera


@dataclass(frozen=True)
class Instance:
    """One object of one frame: of those that a scene asks about, or of those that stand about.

    Attributes:
        name, kind: see ``Truth``. class_number: from 0, see ``Labels``.
        instance_id: in ``instance_map``.
        state: see ``Truth``; of those that stand about it follows from the box and what is seen.
        box_xyxy: (4,) amodal, visible_xyxy: (4,) around what is seen; NaN where there is none.
        visible_fraction, glare_fraction: see ``Truth``; the second is 0 for those that stand about.
        T_world_object: (4, 4). bounds_m: (2, 3), see ``Truth``.
        stands: whether it only stands about.
    """

    name: str
    kind: str
    class_number: int
    instance_id: int
    state: str
    box_xyxy: NDArray[np.float64]
    visible_xyxy: NDArray[np.float64]
    visible_fraction: float
    glare_fraction: float
    T_world_object: NDArray[np.float64]
    bounds_m: NDArray[np.float64]
    stands: bool = False

    @property
    def is_seen(self) -> bool:
        """Whether at least one pixel shows it."""
        return bool(np.isfinite(self.visible_xyxy[0]))

    @property
    def role(self) -> str:
        """What it does in the scene: its name without a number, ``target``, ``traffic``, ``parked`` …"""
        return self.name.rpartition("-")[0] or self.name

    def attributes(self) -> dict[str, Any]:
        """Return what formats with free attributes say beside class and boxes, as JSON values."""
        seen, covered = round(self.visible_fraction, 5), round(self.glare_fraction, 5)
        values = (self.name, self.kind, self.role, seen, covered, seen < MOSTLY_SEEN, self.state == PARTIAL)
        return dict(zip(ATTRIBUTES, values, strict=True))


ATTRIBUTES = ("name", "kind", "role", "visible_fraction", "glare_fraction", "occluded", "truncated")
"""Keys of ``Instance.attributes``."""


class Labels:
    """Which number each class has, and what is left out.

    Numbers are those of the scene's own full list of a level, so that they are the same in all exports with that level.
    Of a set that keeps some classes (``Request.classes``) they count these, in their order: parts of other scenes have
    the same numbers.

    Attributes:
        level, min_visible, min_size_px, ignore_standing: as given.
        names: of the classes, in the order of their numbers, which begin with 0.
        left_out: number of instances that a format has left out or marked so far, since ``takes`` refuses them.
    """

    def __init__(
        self,
        data: DataSet,
        level: ClassLevel = "class",
        min_visible: float = 0.0,
        min_size_px: float = 0.0,
        ignore_standing: bool = False,
    ) -> None:
        """Read the classes of a data set's scene.

        Args:
            level: ``class`` (car, person, …) or ``kind``, see ``Scenario.classes``.
            min_visible: least share of a label's own pixels, 0 to 1, that is seen and that no glare covers.
            min_size_px: least shorter side of a label's visible box, pixels.
            ignore_standing: whether what only stands about is no label.

        Raises:
            ValueError: for a value that is not possible.
        """
        check("min_visible", 0.0 <= min_visible <= 1.0, "a share of 0 to 1", min_visible)
        check("min_size", 0.0 <= min_size_px < np.inf, "a number of pixels >= 0", min_size_px)
        scenario, kept = catalog.scenario(data.request.scenario), data.request.classes
        self._classes: Mapping[str, str] = scenario.classes
        self._scenario, self.level = scenario.id, level
        kinds = [kind for kind, name in self._classes.items() if not kept or name in kept]
        names = (self._classes[kind] for kind in kinds)
        self.names = tuple(kinds if level == "kind" else kept or dict.fromkeys(names))
        self.min_visible, self.min_size_px, self.ignore_standing = min_visible, min_size_px, ignore_standing
        self.left_out = 0

    def class_of(self, kind: str) -> str:
        """Return the name of the class of a kind. Raises ValueError for a kind that the scene does not list."""
        check("kind", kind in self._classes, f"one that {self._scenario} lists in its classes", repr(kind))
        return self._classes[kind] if self.level == "class" else kind

    def takes(self, instance: Instance) -> bool:
        """Return whether an instance is a label: it shows enough, and does not stand about where that is ignored.

        This is the one rule of all formats for what is left out, or marked so that evaluation ignores it.
        """
        size_px = (instance.visible_xyxy[2:] - instance.visible_xyxy[:2]).min() if instance.is_seen else 0.0
        shown = instance.visible_fraction * (1.0 - instance.glare_fraction)
        small = shown < self.min_visible or size_px < self.min_size_px
        return not (small or (instance.stands and self.ignore_standing))

    def seen(self, stored: StoredFrame) -> Iterator[tuple[Instance, bool]]:
        """Yield each object of which a frame shows a pixel, and whether it is a label; others are counted."""
        for each in self.instances(stored):
            if each.is_seen:
                taken = self.takes(each)
                self.left_out += not taken
                yield each, taken

    def instances(self, stored: StoredFrame) -> Iterator[Instance]:
        """Yield all objects of a frame whose classes are kept, then those that stand about."""
        truth = stored.frame.truth
        states = states_of(stored.camera, truth.standing_box_xyxy, truth.standing_visible_fraction)
        # One that reaches behind the camera has no box, and is seen.
        states[np.isnan(truth.standing_box_xyxy).any(axis=1)] = PARTIAL
        columns = (
            (*truth.names, *truth.standing_names),
            (*truth.kinds, *truth.standing_kinds),
            (*truth.instance_id.tolist(), *truth.standing_id.tolist()),
            (*truth.state.tolist(), *states.tolist()),
            (*truth.box_xyxy, *truth.standing_box_xyxy),
            (*stored.visible_xyxy, *stored.standing_visible_xyxy),
            (*truth.visible_fraction.tolist(), *truth.standing_visible_fraction.tolist()),
            (*truth.glare_fraction.tolist(), *[0.0] * len(states)),
            (*truth.T_world_object, *truth.T_world_standing),
            (*truth.bounds_m, *truth.standing_bounds_m),
            (*[False] * len(truth.names), *[True] * len(states)),
        )
        for name, kind, *rest in zip(*columns, strict=True):
            label = self.class_of(kind)
            if label in self.names:
                yield Instance(name, kind, self.names.index(label), *rest)


def as_text(numbers: Iterable[float]) -> str:
    """Return numbers with commas between them, each with as few digits as tell it from all others."""
    return ",".join(repr(float(number)) for number in numbers)


def as_xywh(box_xyxy: NDArray[np.float64], first: float = 0.0) -> list[float]:
    """Return a box (4,) as left, top, width, height, where the picture's top left corner is at (first, first)."""
    x_min, y_min, x_max, y_max = box_xyxy.tolist()
    return [x_min + first, y_min + first, x_max - x_min, y_max - y_min]
