"""COCO's keypoints: named points of people and fish, with what hides them (https://cocodataset.org/#format-data)."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from benchmarks.data.exports.coco import Coco, head_of
from benchmarks.data.exports.exporter import export_format
from benchmarks.data.exports.labels import Instance, StoredFrame
from scenarios import catalog
from scenarios.truth import Keypoints
from sim.checks import check
from sim.optics import project

UNLABELLED, HIDDEN, SEEN = 0, 1, 2
_AROUND = [(x, y) for y in (-1, 0, 1) for x in (-1, 0, 1)]


@export_format("coco-keypoints")
class CocoKeypoints(Coco):
    """Named points of people or fish, with boxes and masks of what is seen, in JSON files.

    Format: https://cocodataset.org/#format-data, keypoint detection. `annotations/person_keypoints.json` (so called for
    fish, too; one for each split as in the format `coco`) names the pictures in `images/`. Annotations are those of the
    format `coco`, of the classes that have named points, with `keypoints`, x, y and v of each, and `num_keypoints`, how
    many have v > 0. x and y begin at the top left corner of the picture, as boxes do. v is 0 outside of the picture or
    behind the camera (x and y are 0, too), 1 where it is hidden, 2 where it is seen. What only stands about, such as a
    boat's crew, has `num_keypoints` 0 and `iscrowd` 1: COCO's sign for what is neither missed nor wrong to find.

    Points lie inside of bodies. One is seen if one of the nine pixels about it shows this object at a depth that is
    less than a limb's above the point: a share of the object's longest side (a person's height, a fish's length), which
    `flesh` of the category tells for each point. So a hand behind the own back is hidden, a hip under cloth is not.

    People have the 17 points of COCO; left and right are their own. Fish have nine at equal distances along the middle
    of the body, from the snout to the end of the tail fin, where they are seen through the water. `sigmas` of the
    category are what pycocotools needs for the similarity of points (`COCOeval(…).params.kpt_oks_sigmas`): COCO's own
    of people, our choice for fish. `attributes` holds more of each object:
    """

    channels = ("image_rgb", "instance_map", "depth_m")
    file_name = "person_keypoints"

    def begin(self) -> None:
        """Begin the lists of the JSON files."""
        super().begin()
        scenario = catalog.scenario(self.data.request.scenario)
        known = scenario.truth.keypoints
        check("data", bool(known), "a scene whose objects have named points, for coco-keypoints", scenario.id)
        self._points = {kind: known[each] for kind, each in scenario.classes.items() if each in known}

    def annotation(self, stored: StoredFrame, instance: Instance, taken: bool) -> dict[str, Any] | None:
        """See ``Coco``: None for objects of classes without points."""
        points, truth = self._points.get(instance.kind), stored.frame.truth
        if points is None:
            return None
        if instance.stands:
            unknown = {"keypoints": [0] * (3 * len(points.names)), "num_keypoints": 0}
            return (super().annotation(stored, instance, taken=False) or {}) | unknown
        k = truth.names.index(instance.name)
        places_m = getattr(truth, points.place_m)[k]
        new = "a set with named points (`frameout generate` into another folder makes it)"
        check("data", bool(np.isfinite(places_m).all()), new, f"one that lacks {points.place_m}")
        pixels, depth_m = project(stored.camera, truth.T_world_camera, places_m)
        if points.place_px:
            pixels = getattr(truth, points.place_px)[k]
        flesh_m = np.array(points.flesh) * truth.size_m[k].max()
        v = visibilities(pixels, depth_m - flesh_m, truth.instance_map == instance.instance_id, truth.depth_m)
        told = np.column_stack([np.where(v[:, None] > 0, pixels, 0.0), v])
        values = [value for x, y, seen in told.tolist() for value in (round(x, 3), round(y, 3), int(seen))]
        annotation = super().annotation(stored, instance, taken)
        return (annotation or {}) | {"keypoints": values, "num_keypoints": int((v > 0).sum())}

    def head(self) -> dict[str, Any]:
        """See ``Coco``."""
        head, classes = head_of(self), {self.labels.class_of(kind): each for kind, each in self._points.items()}
        head["categories"] = [
            each | _described(classes[each["name"]]) for each in head["categories"] if each["name"] in classes
        ]
        return head


def _described(points: Keypoints) -> Mapping[str, Any]:
    return {
        "keypoints": [name.replace(" ", "_") for name in points.names],
        "skeleton": [[a + 1, b + 1] for a, b in points.links],
        "sigmas": points.sigmas,
        "flesh": points.flesh,
    }


def visibilities(
    pixels: NDArray[np.float64], least_m: NDArray[np.float64], own: NDArray[np.bool_], depth_m: NDArray[np.float32]
) -> NDArray[np.int64]:
    """Return whether points of an object are seen (K,): 0, 1 or 2, see ``CocoKeypoints``.

    Args:
        pixels: (K, 2), NaN behind the camera. least_m: (K,) depth from which on the object's surface is at the point.
        own: (H, W) the pixels that show the object. depth_m: (H, W).
    """
    height, width = own.shape
    inside = ((pixels >= 0) & (pixels < (width, height))).all(axis=1)
    v = np.where(inside, HIDDEN, UNLABELLED)
    at = np.floor(pixels[inside]).astype(int)[:, None] + _AROUND
    x, y = np.clip(at[..., 0], 0, width - 1), np.clip(at[..., 1], 0, height - 1)
    seen = (own[y, x] & (depth_m[y, x] >= least_m[inside, None])).any(axis=1)
    v[inside] += seen
    return v
