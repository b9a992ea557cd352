"""A data set as a recording for the Rerun viewer: pictures, maps, boxes, objects and camera over time.

Each episode is a tree of entities ``seed-000003/…`` in its world (metres, z up): ``camera`` moves in it, and
``camera/picture`` is its picture plane with boxes and maps. A stereo pair has ``camera/right`` likewise. The time lines
are ``frame`` and ``time``. Two recordings of the same set hold the same values; the files differ in the identities that
Rerun gives to rows by the clock.
"""

from __future__ import annotations

import importlib
from collections.abc import Sequence
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from benchmarks.data.exports.exporter import Exporter, export_format
from benchmarks.data.exports.labels import ABSENT, Instance
from benchmarks.data.sets.channels import CODINGS, COUNTS, PICTURES, channel_picture, value_of
from benchmarks.data.sets.stored_episode import StoredEpisode
from benchmarks.show.video import marks
from scenarios.scenario import Frame
from scenarios.truth import INSIDE, Truth, meanings
from trackers.types import CameraModel

if TYPE_CHECKING:
    import rerun

RIGHT = "right_rgb"
"""The channel of a stereo pair's right camera."""
_MEDIA_TYPES = {"png": "image/png", "jpeg": "image/jpeg"}
_GROUND = (40, 42, 48)
"""Colour of what is no object."""
RECORDING = "recording.rrd"


@export_format("rerun")
class Rerun(Exporter):
    """A recording for the Rerun viewer: pictures, maps, boxes, objects and camera over time.

    Format: https://rerun.io/docs. `rerun recording.rrd` opens it. Each episode is a tree `seed-NNNNNN/` in its world
    (metres, z up), over the time lines `frame` and `time`; pixel coordinates begin at the top left corner of the
    picture.
    """

    packages = ("rerun",)
    extra = "rerun"

    def begin(self) -> None:
        """Begin the recording."""
        self._sdk = importlib.import_module("rerun")
        self.reads = self.data.request.channels
        name = f"{self.data.request.scenario}-{self.data.request.preset}"
        # Its own properties are the time of writing.
        self._stream: rerun.RecordingStream = self._sdk.RecordingStream(
            f"frameout-{self.data.request.scenario}", recording_id=name, send_properties=False
        )
        self._stream.save(self.folder / RECORDING)
        self.stack.callback(self._stream.disconnect)

    def end(self) -> None:
        """Finish the recording."""
        self._stream.flush()

    def write_episode(self, episode: StoredEpisode) -> None:
        """Write all frames."""
        self._episode = episode
        self._root = f"seed-{episode.seed:06d}"
        self._names_at: dict[str, tuple[str, ...]] = {}
        self._log("", self._sdk.ViewCoordinates.RIGHT_HAND_Z_UP, static=True)
        for stored in self.frames(episode):
            index, frame = stored.index, stored.frame
            instances = list(self.labels.instances(stored))
            self._stream.set_time("frame", sequence=index)
            self._stream.set_time("time", duration=frame.truth.time_s)
            self._write_camera(frame)
            self._write_boxes(instances)
            self._write_objects(instances)
            for channel in self.data.request.channels:
                place = f"camera/{'right/' if channel == RIGHT else ''}picture/{channel}"
                self._log(place, self._drawn(channel, place, index, frame))

    def _log(self, place: str, *what: Any, static: bool = False) -> None:
        self._stream.log(f"{self._root}/{place}".rstrip("/"), *what, static=static, strict=True)

    def _write_camera(self, frame: Frame) -> None:
        sdk, camera, pose = self._sdk, frame.observation.camera, frame.truth.T_world_camera
        self._log("camera", sdk.Transform3D(translation=pose[:3, 3], mat3x3=pose[:3, :3]))
        self._log("camera/picture", self._pinhole(camera))
        if camera.baseline_m is not None:
            self._log("camera/right", sdk.Transform3D(translation=(camera.baseline_m, 0.0, 0.0)))
            self._log("camera/right/picture", self._pinhole(camera))

    def _pinhole(self, camera: CameraModel) -> Any:
        # The principal point is the middle in our coordinates, which Rerun shares: pixel centres at halves.
        return self._sdk.Pinhole(focal_length=camera.focal_px, width=camera.width_px, height=camera.height_px)

    def _write_boxes(self, instances: Sequence[Instance]) -> None:
        visible = [(each, each.visible_xyxy) for each in instances]
        amodal = [(each, each.box_xyxy) for each in instances if each.state in INSIDE]
        for name, boxed, colour in (("visible", visible, marks.TRUTH), ("amodal", amodal, marks.ESTIMATE)):
            known = [(each, box) for each, box in boxed if np.isfinite(box).all()]
            drawn = self._sdk.Boxes2D(
                array=np.array([box for _, box in known]).reshape(-1, 4),
                array_format=self._sdk.Box2DFormat.XYXY,
                labels=[f"{each.name} {each.state}" for each, _ in known],
                colors=np.tile(np.array(colour, np.uint8), (len(known), 1)),
                show_labels=name == "visible",
            )
            self._log(f"camera/picture/boxes/{name}", drawn)

    def _write_objects(self, instances: Sequence[Instance]) -> None:
        known = [each for each in instances if each.state != ABSENT and np.isfinite(each.T_world_object).all()]
        poses = np.array([each.T_world_object for each in known]).reshape(-1, 4, 4)
        low_m, high_m = np.array([each.bounds_m for each in known]).reshape(-1, 2, 3).transpose(1, 0, 2)
        boxes = self._sdk.Boxes3D(
            centers=poses[:, :3, 3] + np.einsum("nij,nj->ni", poses[:, :3, :3], 0.5 * (low_m + high_m)),
            half_sizes=0.5 * (high_m - low_m),
            quaternions=Rotation.from_matrix(poses[:, :3, :3]).as_quat() if len(known) else np.empty((0, 4)),
            labels=[each.name for each in known],
        )
        self._log("objects", boxes)

    def _drawn(self, channel: str, place: str, index: int, frame: Frame) -> Any:
        """Return what shows a channel."""
        sdk, truth = self._sdk, frame.truth
        value = value_of(frame, channel, partial(self._episode.normals_of, index))
        meaning = meanings(truth).get(channel)
        if value is None:
            # A picture that was lost must not leave that of the frame before in view.
            return sdk.Clear(recursive=False)
        if channel == COUNTS:
            return sdk.Image(value, color_model="L")
        if channel in PICTURES:
            coding, content = self._episode.coded(index, channel) or ("", b"")
            if coding in _MEDIA_TYPES:
                return sdk.EncodedImage(contents=content, media_type=_MEDIA_TYPES[coding])
        elif meaning is not None and meaning.unit == "id":
            return sdk.SegmentationImage(self._classes(place, value, truth))
        elif meaning is not None and meaning.unit == "m" and value.ndim == 2:
            # Rerun takes 0 for no depth.
            return sdk.DepthImage(np.where(np.isfinite(value), value, 0.0).astype(np.float32), meter=1.0)
        else:
            value = channel_picture(channel, value, meaning, truth.instance_id)[0]
        return sdk.EncodedImage(contents=CODINGS["png"].encode(value), media_type=_MEDIA_TYPES["png"])

    def _classes(self, place: str, value: NDArray[Any], truth: Truth) -> NDArray[np.uint16]:
        """Return a map of ids (H, W) as classes: 0 for what is no object, else 1 + the object's index; then, with one
        class for all of them, what stands about.
        """
        names = [(0, "no object", _GROUND), *enumerate((*truth.names, "standing about"), start=1)]
        if self._names_at.get(place) != truth.names:
            self._names_at[place] = truth.names
            self._log(place, self._sdk.AnnotationContext(names))
        classes = np.where(np.isin(value, truth.standing_id), len(truth.names) + 1, 0).astype(np.uint16)
        for k, number in enumerate(truth.instance_id, start=1):
            classes[value == number] = k
        return classes
