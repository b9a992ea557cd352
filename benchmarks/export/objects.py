"""What several formats say of objects: their classes, boxes, visibilities, identities."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any, Literal, get_args

import numpy as np
from numpy.typing import NDArray

from benchmarks.data_sets.data_set import DataSet
from benchmarks.export.frames import PARTIAL, StoredFrame
from scenarios import catalog
from scenarios.visibility import MOSTLY_SEEN, states_of
from sim.checks import check
from sim.choices import check_choice

ClassLevel = Literal["class", "kind"]


@dataclass(frozen=True)
class Instance:
    """One object of one frame: of those that a scene asks about, or of those that stand about.

    Attributes:
        name, kind: see ``Truth``. class_number: from 0, see ``Labels``.
        instance_id: in ``instance_map``.
        state: see ``Truth``; of those that stand about it follows from the box and what is seen.
        box_xyxy: (4,) amodal, visible_xyxy: (4,) around what is seen; NaN where there is none.
        visible_fraction: seen share of its own pixels, less those that glare covers.
        T_world_object: (4, 4). bounds_m: (2, 3), see ``Truth``.
    """

    name: str
    kind: str
    class_number: int
    instance_id: int
    state: str
    box_xyxy: NDArray[np.float64]
    visible_xyxy: NDArray[np.float64]
    visible_fraction: float
    T_world_object: NDArray[np.float64]
    bounds_m: NDArray[np.float64]

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
        seen = round(self.visible_fraction, 5)
        values = (self.name, self.kind, self.role, seen, seen < MOSTLY_SEEN, self.state == PARTIAL)
        return dict(zip(ATTRIBUTES, values, strict=True))


ATTRIBUTES = ("name", "kind", "role", "visible_fraction", "occluded", "truncated")
"""Keys of ``Instance.attributes``."""
ATTRIBUTES_NOTE = """
`name` is the same in all frames of an episode; `kind` is finer than the class (the model of a car, a person's part in
the script); `role` says what it does (`target`, `traffic`, `parked`, `moored`, …). `visible_fraction` is the seen share
of the object's own pixels, also of those beyond the border, 0 to 1; `occluded` says that it is less than half;
`truncated` that the border cuts the whole object. Pixels that show the mirror image of a lamp do not count as seen.
"""


class Labels:
    """Which number each class has, and what is left out.

    Numbers are those of the scene's own full list, so that they are the same in all exports of its data sets.

    Attributes:
        names: of the classes, in the order of their numbers, which begin with 0.
        left_out: instances that ``takes`` has refused so far.
    """

    def __init__(
        self, data: DataSet, level: ClassLevel = "class", min_visible: float = 0.0, min_size_px: float = 0.0
    ) -> None:
        """Read the classes of a data set's scene.

        Args:
            level: ``class`` (car, person, …) or ``kind``, see ``Scenario.classes``.
            min_visible: least visible fraction of a label, 0 to 1.
            min_size_px: least shorter side of a label's visible box, pixels.

        Raises:
            ValueError: for a value that is not possible.
        """
        check_choice("classes", level, get_args(ClassLevel))
        check("min_visible", 0.0 <= min_visible <= 1.0, "a share of 0 to 1", min_visible)
        check("min_size", 0.0 <= min_size_px < np.inf, "a number of pixels >= 0", min_size_px)
        scenario = catalog.scenario(data.request.scenario)
        self._classes: Mapping[str, str] = getattr(scenario, "classes", {})
        self._scenario, self._level = scenario.id, level
        self.names = tuple(dict.fromkeys(self._classes.values() if level == "class" else self._classes))
        self._min_visible, self._min_size_px = min_visible, min_size_px
        self.left_out = 0

    def class_of(self, kind: str) -> str:
        """Return the name of the class of a kind. Raises ValueError for a kind that the scene does not list."""
        check("kind", kind in self._classes, f"one that {self._scenario} lists in its classes", repr(kind))
        return self._classes[kind] if self._level == "class" else kind

    def takes(self, instance: Instance) -> bool:
        """Return whether enough of an instance is seen for a label; one that is not is counted."""
        size_px = (instance.visible_xyxy[2:] - instance.visible_xyxy[:2]).min()
        enough = instance.visible_fraction >= self._min_visible and size_px >= self._min_size_px
        self.left_out += not enough
        return bool(enough)

    def instances(self, stored: StoredFrame) -> Iterator[Instance]:
        """Yield all objects of a frame, then those that stand about."""
        truth = stored.frame.truth
        for k, kind in enumerate(truth.kinds):
            yield Instance(
                truth.names[k],
                kind,
                self.names.index(self.class_of(kind)),
                int(truth.instance_id[k]),
                str(truth.state[k]),
                truth.box_xyxy[k],
                stored.visible_xyxy[k],
                float(truth.visible_fraction[k] * (1.0 - truth.glare_fraction[k])),
                truth.T_world_object[k],
                truth.bounds_m[k],
            )
        states = states_of(stored.frame.camera, truth.standing_box_xyxy, truth.standing_visible_fraction)
        # One that reaches behind the camera has no box, and is seen.
        states[np.isnan(truth.standing_box_xyxy).any(axis=1)] = PARTIAL
        for k, kind in enumerate(truth.standing_kinds):
            yield Instance(
                truth.standing_names[k],
                kind,
                self.names.index(self.class_of(kind)),
                int(truth.standing_id[k]),
                str(states[k]),
                truth.standing_box_xyxy[k],
                stored.standing_visible_xyxy[k],
                float(truth.standing_visible_fraction[k]),
                truth.T_world_standing[k],
                truth.standing_bounds_m[k],
            )


def check_objects(data: DataSet) -> None:
    """Raise ValueError if a data set has no objects."""
    check("data", data.count_rows("objects") > 0, "a data set with objects", f"{data.url} without any")


def as_xywh(box_xyxy: NDArray[np.float64], first: float = 0.0) -> list[float]:
    """Return a box (4,) as left, top, width, height, where the picture's top left corner is at (first, first)."""
    x_min, y_min, x_max, y_max = box_xyxy.tolist()
    return [x_min + first, y_min + first, x_max - x_min, y_max - y_min]


class Identities:
    """Numbers the objects of an episode by name, from 1 on, in order of their appearance."""

    def __init__(self) -> None:
        self.numbers: dict[str, int] = {}

    def of(self, name: str) -> int:
        """Return an object's number."""
        return self.numbers.setdefault(name, 1 + len(self.numbers))
