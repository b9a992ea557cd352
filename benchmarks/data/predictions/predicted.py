"""Trackers that ran elsewhere: they answer from files of predictions, and are judged like all others."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from benchmarks.contract.rows import Row
from benchmarks.contract.tracker_spec import EpisodeName, TrackerSpec
from benchmarks.data.predictions.formats import SequenceFile, read_predictions
from scenarios.loop import FromPictures, LoopTracker, ManyFromPictures
from scenarios.scenario import Episode
from sim.checks import check
from trackers.follow_one import FollowOne
from trackers.kernels.boxes import box_iou
from trackers.regions import Rectangle, Region, estimate_of
from trackers.registry import NoParameters
from trackers.types import CameraModel, Estimate, Observation, Track

_NONE = Estimate(np.full(2, np.nan))
_LEAST_IOU = 0.5
"""Of the first box with the given one."""


@dataclass(frozen=True, kw_only=True)
class Predicted(TrackerSpec):
    """A tracker that answers from files, see ``TrackerSpec``.

    In a sequence of one target, of tracks of several identities one is followed as that of any tracker of many; the
    only one is the target's; of detections without identities the likeliest in each picture is. The first answer is the
    box that trackers are given.

    Attributes:
        files: preset and seed of an episode → its file. digests: of the same.
        recorded: arguments of ``frameout score`` that say which predictions.
    """

    role: str = "external"
    summary: str = "predictions made elsewhere"
    suites: tuple[str, ...] = ()
    parameters: Any = field(default_factory=NoParameters)
    module: str = __name__
    timed: bool = False
    files: Mapping[tuple[str, int], SequenceFile]
    digests: Mapping[tuple[str, int], str]
    recorded: tuple[str, ...] = ()

    def create(
        self, named: EpisodeName, episode: Episode, rng: np.random.Generator, *, many: bool = False
    ) -> LoopTracker:
        """See ``TrackerSpec``. Raises ValueError for a sequence without a file, and for one that has changed."""
        file = self.files[named.preset, named.seed]
        wanted = f"a file for the sequence {file.sequence}"
        check("predictions", file.path is not None, wanted, "none")
        found = read_predictions(file)
        wanted = f"{file.path} as it was when the run began"
        check("predictions", found.digest == self.content(named), wanted, "another content")
        if many:
            return ManyFromPictures(Recalled(found.tracks or {}, found.masks))
        if found.regions is not None:
            return _FromRegions(RecalledRegions(found.regions, found.confidence))
        if found.detections is not None:
            return FromPictures(Likeliest(found.detections))
        tracks = found.tracks or {}
        alone = len({each.identity for some in tracks.values() for each in some}) == 1
        return FromPictures(Likeliest(tracks, found.masks) if alone else FollowOne(Recalled(tracks, found.masks)))

    @property
    def columns(self) -> Row:
        """See ``TrackerSpec``."""
        return {"predicted": list(self.recorded)}

    def content(self, named: EpisodeName) -> str:
        """See ``TrackerSpec``."""
        return self.digests[named.preset, named.seed]


class Recalled:
    """Tracks of many targets from a file, see ``trackers.protocols.MultiTracker``."""

    def __init__(
        self, tracks: Mapping[int, Sequence[Track]], masks: Mapping[int, Sequence[Mapping[str, Any]]] | None = None
    ) -> None:
        """``masks``: see ``Predictions``; those of a picture are made when it comes."""
        self._tracks, self._masks, self._next = tracks, masks, 0

    def start(self, background: Sequence[Observation], camera: CameraModel) -> None:
        """See ``MultiTracker``."""

    def update(self, observation: Observation) -> Sequence[Track]:
        """See ``MultiTracker``."""
        self._next += 1
        tracks = self._tracks.get(self._next - 1, ())
        if self._masks is None:
            return tracks
        # Here, since it imports the packages of the extra.
        from benchmarks.data.codec import mask_of

        masks = map(mask_of, self._masks.get(self._next - 1, ()))
        pairs = zip(tracks, masks, strict=True)
        return [replace(track, estimate=replace(track.estimate, mask=mask)) for track, mask in pairs]


class Likeliest(Recalled):
    """The likeliest track or detection of each picture, see ``trackers.protocols.Tracker``; NaN without one."""

    def initialise(self, observation: Observation, box_xyxy: NDArray[np.float64]) -> None:
        """See ``Tracker``."""
        super().update(observation)

    def update(self, observation: Observation) -> Estimate:  # type: ignore[override]
        """See ``Tracker``."""
        found = super().update(observation)
        best = max(found, key=lambda each: 0.0 if each.confidence is None else each.confidence, default=None)
        return _NONE if best is None else best.estimate


class RecalledRegions:
    """Regions of one target from a file, see ``trackers.protocols.Tracker``.

    Attributes:
        begins_elsewhere: whether the first region is a rectangle, but not the given box.
    """

    def __init__(self, regions: Sequence[Region], confidence: Sequence[float]) -> None:
        self._said = iter(zip(regions, confidence, strict=True))
        self.begins_elsewhere = False

    def initialise(self, observation: Observation, box_xyxy: NDArray[np.float64]) -> None:
        """See ``Tracker``. The first region is that of the box."""
        first, _ = next(self._said)
        self.begins_elsewhere = isinstance(first, Rectangle) and bool(box_iou(first.box_xyxy, box_xyxy) < _LEAST_IOU)

    def update(self, observation: Observation) -> Estimate:
        """See ``Tracker``."""
        region, confidence = next(self._said)
        estimate = estimate_of(region, observation.camera.height_px, observation.camera.width_px)
        known = None if np.isnan(confidence) else confidence
        return replace(estimate, in_view_probability=known)


class _FromRegions(FromPictures):
    def __init__(self, recalled: RecalledRegions) -> None:
        super().__init__(recalled)
        self._recalled = recalled

    def release(self, whole: bool) -> list[str]:
        """See ``ReleasedLoopTracker``."""
        odd = "begins with another box than the given one (is it x1,y1,x2,y2 in place of left,top,width,height?)"
        return [odd] if self._recalled.begins_elsewhere else []
