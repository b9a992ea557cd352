"""``eigen_swarm``: intruders before a thermal camera at rest, as paper D finds them.

Paper D: eigenspaces of blocks as the likelihood of three-dimensional particles, in sets on a stack (`SYSTEMS.md`, D).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from trackers.eigen_swarm.eigenspaces import BLOCK_PX, ENLARGED, BlockEigenspaces, learn, likelihood
from trackers.eigen_swarm.swarm import ParticleSet, Swarm, SwarmParameters
from trackers.registry import register, register_variant, tunable
from trackers.site import Site, SiteView, Surveyed, placed
from trackers.site_model_file import Form, load_model, save_model
from trackers.types import CameraModel, Observation, Track

_KIND = "eigen_swarm-2"
_LONGEST_INTERVAL_S = 10.0
"""Particles are not moved on for longer: after a gap in the video nothing is known of the objects' places."""


@dataclass(frozen=True)
class EigenSwarmParameters(SwarmParameters):
    """Parameters of ``eigen_swarm``; see ``SwarmParameters`` for those of the particle sets.

    Attributes:
        contribution: share of the variance that the eigenvectors of a block must make up, which gives D. The paper is
            silent; chosen on development seeds.
        gain: alpha of the sigmoid.
        few_dimensions, threshold_few, threshold_many: v_D is ``threshold_few`` for D <= ``few_dimensions``, and
            ``threshold_many`` above.
    """

    contribution: float = tunable(0.9995, 0.9, 0.9999)
    gain: float = 0.6
    few_dimensions: int = 20
    threshold_few: float = 15.0
    threshold_many: float = 9.0


@register(
    "eigen_swarm",
    role="as-written",
    summary="block eigenspaces of the 8-bit picture, sets of 3-D particles on a stack, of paper D",
    suites=("harbour",),
)
class EigenSwarm(Surveyed):
    """A ``SiteTracker`` of all that is not background. Without pictures of the background it answers nothing.

    It reads the picture after automatic gain control, 8 bits, as the paper's program did; all others read the counts.

    The paper is silent on W, on how long a set detects, on the share of variance that gives D, on velocities at first,
    on the limit of the stack and on a confidence. Chosen on development seeds of ``paper-d``, by what is found as the
    paper counts it and by the area under the FROC curve: 60 settings on seeds 0 and 1 of an earlier version of the
    scene, then shares from 0.998 to 1 (below 0.999 people are lost in the daily course of the background, above 0.9998
    in noise) and eight changes of the other numbers on seeds 20 to 25; the confidence, of ten ways to rank that alter
    no answer: the mean likelihood of a set's particles before resampling. The limit was never reached:
    19 sets at most. Particles outside the watched volume have the likelihood 0: the paper's clouds are as long as a
    line of sight inside it.

    Source: paper D, see ``trackers.papers``.
    """

    Parameters = EigenSwarmParameters

    def __init__(self, parameters: EigenSwarmParameters, rng: np.random.Generator) -> None:
        self._parameters, self._rng = parameters, rng
        self._begin(None, None, (0, 0))

    def start(self, background: Sequence[Observation], camera: CameraModel) -> None:
        """See ``MultiTracker``."""
        size = (camera.height_px, camera.width_px)
        greys = [each.image_rgb[..., 0] for each in background if each.image_rgb.shape[:2] == size]
        spaces = learn(greys, self._parameters.contribution) if len(greys) > 1 else None
        self._begin(spaces, self._site_of(camera, background), size)

    def save_background(self, path: Path) -> Path:
        """Write what ``start`` learnt, and the camera's calibration with it, and return the path.

        Raises:
            ValueError: before ``start``, or if it got no pictures or no pose of the camera.
        """
        if self._spaces is None or self._site is None:
            raise ValueError("background: expected pictures and a pose to have been learnt from, got none")
        spaces = self._spaces
        arrays: dict[str, NDArray[Any]] = {"mean": spaces.mean, "axes": spaces.axes, "first": spaces.first}
        return save_model(path, _KIND, self._site.view, arrays)

    def start_from(self, path: Path, camera: CameraModel, T_world_camera: NDArray[np.float64]) -> None:
        """Start with a background that was saved before, in place of ``start``.

        Raises:
            ValueError: as ``load_model``, e.g. for the background of another camera; and as ``place``.
        """
        site = placed(self._known(), camera, T_world_camera)
        rows, columns = (ENLARGED * side_px // BLOCK_PX for side_px in (camera.height_px, camera.width_px))
        forms = {
            "mean": Form("float32", (rows * columns, BLOCK_PX**2)),
            "axes": Form("float32", ("axes", BLOCK_PX**2)),
            "first": Form("int64", (rows * columns + 1,)),
        }
        arrays = load_model(path, _KIND, site.view, forms)
        first = arrays["first"]
        if first[0] != 0 or first[-1] != len(arrays["axes"]) or (np.diff(first) < 1).any():
            raise ValueError(f"model: expected axes for each block, got {str(path)!r} with others")
        self._begin(BlockEigenspaces(rows, columns, **arrays), site, (camera.height_px, camera.width_px))

    def _begin(self, spaces: BlockEigenspaces | None, site: Site | None, size: tuple[int, int]) -> None:
        self._spaces, self._site, self._size = spaces, site, size
        self._swarm: Swarm | None = None
        self._time_s = 0.0

    def update(self, observation: Observation) -> list[Track]:
        """See ``MultiTracker``. A picture of another size than those of the background has no answer."""
        p, spaces, camera = self._parameters, self._spaces, observation.camera
        if spaces is None or observation.image_rgb.shape[:2] != self._size:
            return []
        if self._site is None:
            self._site = self._site_of(camera, [observation])
            if self._site is None:
                return []
        if self._swarm is None:
            self._swarm = Swarm(p, self._site.volume, blocks_from_metres(self._site.view), self._rng)
            self._time_s = observation.time_s
        r = spaces.relative_variation(observation.image_rgb[..., 0])
        dimensions = spaces.dimensions.reshape(r.shape)
        f = likelihood(r, dimensions, p.gain, p.threshold_few, p.threshold_many, p.few_dimensions)
        interval_s = min(max(observation.time_s - self._time_s, 0.0), _LONGEST_INTERVAL_S)
        self._time_s = observation.time_s
        tracks = [track_of(each, self._site.view) for each in self._swarm.step(f, interval_s)]
        return [track for track in tracks if track is not None]


def blocks_from_metres(view: SiteView) -> NDArray[np.float64]:
    """Return the projection (3, 4) from the world in metres to columns and rows of blocks."""
    camera = view.camera
    R, C = view.T_world_camera[:3, :3], view.place_m
    a_block_px = BLOCK_PX / ENLARGED
    K = np.array(
        [
            [camera.focal_px / a_block_px, 0.0, 0.5 * camera.width_px / a_block_px],
            [0.0, camera.focal_px / a_block_px, 0.5 * camera.height_px / a_block_px],
            [0.0, 0.0, 1.0],
        ]
    )
    return K @ np.column_stack([R.T, -R.T @ C])


def track_of(each: ParticleSet, view: SiteView) -> Track | None:
    """Return a set that tracks as a track; None if its region reaches behind the camera."""
    region = each.region
    if region is None:
        return None
    heading_rad = float(np.arctan2(region.a1[1], region.a1[0]))
    estimate = view.estimate_of(region.centre_m, region.size_m, heading_rad)
    if estimate is None:
        return None
    return Track(each.number, estimate, size_m=region.size_m, confidence=each.mean_likelihood)


register_variant("eigen_swarm_no_direction", "eigen_swarm", summary="duplicates by (8) alone", uses_direction=False)
register_variant("eigen_swarm_no_distance", "eigen_swarm", summary="duplicates by (7) alone", uses_distance=False)
register_variant(
    "eigen_swarm_duplicates",
    "eigen_swarm",
    summary="no duplicate is removed",
    uses_direction=False,
    uses_distance=False,
)
