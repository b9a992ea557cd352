"""Ground truth: scores use it; no tracker, controller or observation space ever gets it.

``truth_field`` declares each field once. Stripping, checks, the ``info`` of envs and data sets follow from that.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, ClassVar, Literal, TypeVar, get_args, get_type_hints

import numpy as np
from numpy.typing import NDArray

VisibilityState = Literal["in", "partial", "occluded", "out", "absent"]
INSIDE: tuple[VisibilityState, ...] = ("in", "partial", "occluded")
"""States of objects that are in the picture, whatever stands before them."""
Side = Literal["left", "right", "top", "bottom"]
TruthExtent = Literal["all", "target"]
"""How much truth an episode's frames hold, see ``Truth``."""

_MEANING = "truth"
_T = TypeVar("_T", bound="Truth")


@dataclass(frozen=True, slots=True)
class Meaning:
    """Unit, shape and coding of a field of truth.

    Attributes:
        unit: ``m``, ``px``, ``s`` …; ``fraction`` of 0 to 1, ``id``, ``word``, ``class`` (its number in ``coding``),
            or ``1`` for a number without unit.
        shape: its axes; ``N`` objects, ``S`` standing ones, ``H`` rows and ``W`` columns of the picture.
        coding: the meaning of single values, where the unit does not give it.
        left_out: whether episodes with ``truth="target"`` leave it out: a field per pixel or per standing object
            wholly, a field per object for all objects but the target (NaN, or -1 for integers).
        judged: whether judges may read it. What is a label of data sets alone is in no edition of a scene.
    """

    unit: str
    shape: tuple[str | int, ...] = ()
    coding: str = ""
    left_out: bool = False
    judged: bool = True

    @property
    def table(self) -> str:
        """Table of a data set that holds it: ``objects``, ``standing`` or ``frames``; "" for a field per pixel."""
        if self.per_pixel:
            return ""
        return {"N": "objects", "S": "standing"}.get(str(self.shape[0]) if self.shape else "", "frames")

    @property
    def per_pixel(self) -> bool:
        """Whether it has an entry for each pixel."""
        return self.shape[:2] == ("H", "W")


def truth_field(
    unit: str,
    *shape: str | int,
    coding: str = "",
    left_out: bool = False,
    unjudged: Any = None,
) -> Any:
    """Declare a field of truth, see ``Meaning``.

    Args:
        unjudged: an empty value, for a field that judges do not read: a truth made without the field has that.
    """
    metadata = {_MEANING: Meaning(unit, shape, coding, left_out, unjudged is None)}
    if unjudged is None:
        return dataclasses.field(metadata=metadata)
    return dataclasses.field(default_factory=lambda: unjudged, kw_only=True, metadata=metadata)


@dataclass(frozen=True)
class Keypoints:
    """K points of the objects of a class.

    Attributes:
        names: (K,). links: pairs of points, from 0, that a drawing joins.
        sigmas: (K,) spreads for COCO's object keypoint similarity.
        flesh: (K,) how deep a point may lie below the visible surface to count as seen, shares of the object's longest
            side; a limb's depth, with clothes.
        place_m: field of truth with their places, (N, K, 3); NaN for objects of other classes. place_px: field with
            those in the picture; "": where a pinhole camera sees them.
    """

    names: tuple[str, ...]
    links: tuple[tuple[int, int], ...]
    sigmas: tuple[float, ...]
    flesh: tuple[float, ...]
    place_m: str
    place_px: str = ""


def keypoints_field(keypoints: Keypoints) -> Any:
    """Declare the field ``keypoints_m`` (N, K, 3): places of objects' named points in the world, also hidden ones."""
    shape, coding = (len(keypoints.names), 3), f"{', '.join(keypoints.names)}; NaN: has none, or is absent"
    return truth_field("m", "N", *shape, coding=coding, unjudged=np.empty((0, *shape)))


@dataclass(frozen=True, slots=True)
class Truth:
    """Truth of one frame with N objects. It does not mark targets; each scenario adds its own fields.

    Boxes are amodal: they enclose the whole object, also where it is hidden or outside the picture.

    The N objects are those that suites judge. S standing ones, of the same kinds, are only labelled: parked cars,
    moored boats, passers-by and crews. A frame holds those of them of which it shows at least one pixel.

    Scores of following one target do not use the most expensive fields. An episode with ``truth="target"`` leaves
    them out, see ``Meaning.left_out``; the state of all other objects then follows from their boxes alone, as if none
    were hidden. All else, the pictures included, is the same byte for byte.

    Attributes:
        pinhole: of the kind of truth: whether places are seen where a pinhole camera sees them. False: light is bent on
            its way. keypoints: likewise: class -> its named points; a kind of truth with ``PERSON`` has a field
            ``keypoints_m``, see ``keypoints_field``. passing: likewise: kinds of standing objects that walk or ride by,
            whose limbs have no pose here.
        frame: index from 0.
        time_s: seconds since frame 0.
        T_world_camera: (4, 4), the true pose.
        names: (N,) e.g. ``target``, ``traffic-3``.
        kinds: (N,) e.g. the vehicle's model.
        T_world_object: (N, 4, 4), origin on the ground under the object's centre, x forward, z up.
        size_m: (N, 3) length, width, height; of people who stand, and of straight fish.
        speed_mps: (N,).
        position_px: (N, 2) projection of the objects' centres (half their height up), also outside the picture; NaN
            behind the camera.
        box_xyxy: (N, 4) amodal box in pixels, also outside; NaN where any corner is behind the camera.
        instance_id: (N,) id of each object in ``instance_map``.
        visible_fraction: (N,) visible share of the object's own pixels (rendered alone on an unbounded picture).
        state: (N,) ``in`` (its box inside the borders, at least half of its own pixels seen), ``partial`` (cut by the
            border, however much of it is seen), ``occluded`` (inside, less than half seen), ``out`` (its box entirely
            outside), ``absent`` (not in the world now).
        side: (N,) side of the object's latest exit; "" before the first.
        frames_since_exit: (N,) 0 on the first frame that the object is out; -1 while it is not out.
        instance_map: (H, W) int32.
        depth_m: (H, W) float32.
        exposure_s, gain: the camera's settings for this picture.
        bounds_m: (N, 2, 3) least and greatest x, y, z in the frame of ``T_world_object`` of the body as it is posed
            now, limbs and bend included: its 3-D box. NaN while it is absent. Where a scene does not measure it, that
            of ``size_m``.
        glare_fraction: (N,) share of the object's seen pixels where the picture shows the mirror image of a lamp
            instead; 0 where nothing mirrors. ``visible_fraction`` and ``state`` leave it out of account.
        standing_names: (S,) e.g. ``parked-3``, the same on all frames. standing_kinds: (S,) as ``kinds``.
        standing_id: (S,) ids in ``instance_map``. T_world_standing: (S, 4, 4), standing_bounds_m: (S, 2, 3),
            standing_box_xyxy: (S, 4), standing_visible_fraction: (S,) as those of objects; but
            the pose of one of a crew is that of the pelvis, in whose frame the bounds are.
    """

    pinhole: ClassVar[bool] = True
    keypoints: ClassVar[Mapping[str, Keypoints]] = {}
    passing: ClassVar[tuple[str, ...]] = ()

    frame: int = truth_field("1", coding="index from 0")
    time_s: float = truth_field("s", coding="since frame 0")
    T_world_camera: NDArray[np.float64] = truth_field("m", 4, 4)
    names: tuple[str, ...] = truth_field("word", "N")
    kinds: tuple[str, ...] = truth_field("word", "N")
    T_world_object: NDArray[np.float64] = truth_field("m", "N", 4, 4)
    size_m: NDArray[np.float64] = truth_field("m", "N", 3)
    speed_mps: NDArray[np.float64] = truth_field("m/s", "N")
    position_px: NDArray[np.float64] = truth_field("px", "N", 2, coding="x, y of the centre; NaN behind the camera")
    box_xyxy: NDArray[np.float64] = truth_field(
        "px", "N", 4, coding="x_min, y_min, x_max, y_max; NaN behind the camera"
    )
    instance_id: NDArray[np.int64] = truth_field("id", "N")
    visible_fraction: NDArray[np.float64] = truth_field("fraction", "N", left_out=True)
    state: NDArray[np.str_] = truth_field("word", "N", coding="in, partial, occluded, out or absent")
    side: NDArray[np.str_] = truth_field("word", "N", coding="left, right, top or bottom; empty before the first exit")
    frames_since_exit: NDArray[np.int64] = truth_field("frames", "N", coding="-1 while it is not out")
    instance_map: NDArray[np.int32] = truth_field(
        "id", "H", "W", coding="instance_id of the object seen, others for what is no object"
    )
    depth_m: NDArray[np.float32] = truth_field(
        "m", "H", "W", coding="along the optical axis; infinite where nothing is seen"
    )
    exposure_s: float = truth_field("s")
    gain: float = truth_field("1", coding="1 is none")
    bounds_m: NDArray[np.float64] = truth_field(
        "m", "N", 2, 3, coding="least and greatest x, y, z; NaN while absent", unjudged=np.empty((0, 2, 3))
    )
    glare_fraction: NDArray[np.float64] = truth_field("fraction", "N", unjudged=np.empty(0))
    standing_names: tuple[str, ...] = truth_field("word", "S", left_out=True, unjudged=())
    standing_kinds: tuple[str, ...] = truth_field("word", "S", left_out=True, unjudged=())
    standing_id: NDArray[np.int64] = truth_field("id", "S", left_out=True, unjudged=np.empty(0, np.int64))
    T_world_standing: NDArray[np.float64] = truth_field("m", "S", 4, 4, left_out=True, unjudged=np.empty((0, 4, 4)))
    standing_bounds_m: NDArray[np.float64] = truth_field(
        "m", "S", 2, 3, coding="as bounds_m", left_out=True, unjudged=np.empty((0, 2, 3))
    )
    standing_box_xyxy: NDArray[np.float64] = truth_field(
        "px", "S", 4, coding="as box_xyxy", left_out=True, unjudged=np.empty((0, 4))
    )
    standing_visible_fraction: NDArray[np.float64] = truth_field("fraction", "S", left_out=True, unjudged=np.empty(0))

    def __post_init__(self) -> None:
        """Where nothing is given, take bounds from sizes, no glare, and no keypoints."""
        if len(self.bounds_m) == 0 < len(self.size_m):
            half_m = 0.5 * self.size_m * (1.0, 1.0, 0.0)
            object.__setattr__(self, "bounds_m", np.stack([-half_m, self.size_m - half_m], axis=1))
        if len(self.glare_fraction) == 0 < len(self.names):
            object.__setattr__(self, "glare_fraction", np.zeros(len(self.names)))
        points_m = getattr(self, "keypoints_m", None)
        if points_m is not None and len(points_m) == 0 < len(self.names):
            object.__setattr__(self, "keypoints_m", np.full((len(self.names), *points_m.shape[1:]), np.nan))

    def index_of(self, name: str) -> int:
        """Return the index of the object of this name. Raises ValueError if there is none."""
        if name not in self.names:
            raise ValueError(f"object: expected one of {', '.join(self.names)}; got {name!r}")
        return self.names.index(name)


def meanings(kind: type[Truth] | Truth) -> dict[str, Meaning]:
    """Return the meaning of each field of a kind of truth, by name."""
    return {field.name: field.metadata[_MEANING] for field in dataclasses.fields(kind)}


def dtype_of(kind: type[Truth], name: str) -> np.dtype[Any]:
    """Return the dtype of a field, an array or a plain number, from its annotation."""
    hint = get_type_hints(kind)[name]
    return np.dtype(get_args(get_args(hint)[1])[0] if get_args(hint) else hint)


def without_standing(truth: _T) -> _T:
    """Return a frame's truth without standing objects, which another camera would see elsewhere."""
    none: dict[str, Any] = {
        name: getattr(truth, name)[:0] for name, meaning in meanings(truth).items() if meaning.table == "standing"
    }
    return dataclasses.replace(truth, **none)


def without_pixels(truth: _T) -> _T:
    """Return a frame's truth with empty fields per pixel; for a whole episode those exceed a gigabyte."""
    changes: dict[str, Any] = {
        name: nothing_of(truth, name) for name, meaning in meanings(truth).items() if meaning.per_pixel
    }
    return dataclasses.replace(truth, **changes)


def nothing_of(truth: Truth, name: str) -> NDArray[Any]:
    """Return an empty map (0, 0, ...) with the dtype and trailing axes of a field per pixel."""
    held = getattr(truth, name)
    return np.empty((0, 0, *held.shape[2:]), held.dtype)


def check_truth(truth: Truth) -> None:
    """Raise ValueError, naming the field, what was expected and what came, if a field differs from its meaning.

    Fields per pixel may be empty.
    """
    height, width = (*truth.instance_map.shape, 0, 0)[:2]
    axes: dict[str | int, int] = {
        "N": len(truth.names),
        "S": len(truth.standing_names),
        "H": height,
        "W": width,
    }
    for name, meaning in meanings(truth).items():
        value = getattr(truth, name)
        expected = tuple(axes.get(axis, axis) for axis in meaning.shape)
        came = np.shape(value)
        if came != expected and not (meaning.per_pixel and came[:2] == (0, 0)):
            raise ValueError(f"{name}: expected the shape {expected}, got {came}")
        if meaning.unit == "fraction":
            shares = np.asarray(value, dtype=float)
            if not (np.isnan(shares) | ((shares >= 0) & (shares <= 1))).all():
                low, high = np.nanmin(shares), np.nanmax(shares)
                raise ValueError(f"{name}: expected numbers from 0 to 1, got {low:g} to {high:g}")
