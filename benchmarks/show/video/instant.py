"""One instant as a picture: the observed frame inside the larger view, truth and estimate drawn on it."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import ArrayLike, NDArray

from benchmarks.show.video import marks
from scenarios.scenario import Frame
from sim.optics import intersect_plane, project
from trackers.types import Answer, Estimate

_DIMMED = 0.66
"""Brightness of the surroundings of the observed frame."""
_NARROWEST_PX = 960
_LABEL_PX, _FAR_PX = 4, 1e4
"""Offset of an identity from its box, and limit of its place."""


@dataclass(frozen=True, slots=True)
class Instant:
    """A frame with the answer to it, for drawing.

    Attributes:
        frame: observation and truth.
        targets: indices of the targets among the objects.
        answer: the tracker's estimate, or its tracks of many targets; None without a tracker.
        larger_view_rgb: (H, W, 3) uint8, the observed frame in its middle.
        decides_at: confidence from which on tracks are the tracker's decision.
    """

    frame: Frame
    targets: tuple[int, ...]
    answer: Answer | None
    larger_view_rgb: NDArray[np.uint8]
    decides_at: float = 0.0

    @property
    def target(self) -> int:
        """Index of the only target."""
        return self.targets[0]

    @property
    def estimate(self) -> Estimate | None:
        """Estimate of a tracker of one target."""
        return self.answer if isinstance(self.answer, Estimate) else None

    @property
    def estimates(self) -> tuple[tuple[str, Estimate], ...]:
        """All estimates with their tracks' identities; the identity is '' for a tracker of one target."""
        if self.answer is None or isinstance(self.answer, Estimate):
            return () if self.answer is None else (("", self.answer),)
        return tuple((str(track.identity), track.estimate) for track in self.answer)


@dataclass(frozen=True, slots=True)
class _Canvas:
    """The larger view at ``zoom`` times its size, and where the observed frame's corner lies in it."""

    image: NDArray[np.uint8]
    corner_px: NDArray[np.float64]
    zoom: float

    @property
    def stroke_px(self) -> int:
        """Width of the lines on the car, thin enough not to hide it."""
        return 2 if self.zoom >= 1 else 1

    def point(self, picture_px: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return points (..., 2) of the observed picture on the canvas."""
        return np.asarray(picture_px) * self.zoom + self.corner_px

    def box(self, picture_xyxy: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return a box (4,) of the observed picture on the canvas."""
        return self.point(np.reshape(picture_xyxy, (2, 2))).ravel()


def draw_instant(instant: Instant, zoom: float | None = None) -> NDArray[np.uint8]:
    """Return the larger view with the observed frame's outline, particles, truth, estimate; (H, W, 3) uint8.

    The view is scaled by ``zoom``, marks are not; None enlarges small views by a whole factor.
    """
    canvas = _lay_out(instant, zoom)
    image = canvas.image
    height, width = instant.frame.observation.image_rgb.shape[:2]
    marks.draw_box(image, canvas.box(np.array([0.0, 0.0, width, height])), marks.OBSERVED)
    draw_steered(image, instant.frame, canvas.zoom, canvas.corner_px)
    for _, estimate in instant.estimates:
        _draw_posterior(canvas, estimate)
    truth = instant.frame.truth
    for target in instant.targets:
        marks.draw_box(image, canvas.box(truth.box_xyxy[target]), marks.TRUTH, canvas.stroke_px)
        marks.draw_pointer(image, canvas.point(truth.position_px[target]), marks.TRUTH)
    for identity, estimate in instant.estimates:
        _draw_estimate(canvas, estimate, identity)
    return image


def _lay_out(instant: Instant, zoom: float | None) -> _Canvas:
    view, observed = instant.larger_view_rgb, instant.frame.observation.image_rgb
    row, column = ((np.array(view.shape[:2]) - observed.shape[:2]) / 2).astype(int)
    image = (view * np.float32(_DIMMED)).astype(np.uint8)
    image[row : row + observed.shape[0], column : column + observed.shape[1]] = observed
    if zoom is None:
        zoom = max(1, -(-_NARROWEST_PX // view.shape[1]))
    if zoom != 1:
        how = cv2.INTER_AREA if zoom < 1 else cv2.INTER_NEAREST if zoom == int(zoom) else cv2.INTER_CUBIC
        image = np.asarray(cv2.resize(image, None, fx=zoom, fy=zoom, interpolation=how), dtype=np.uint8)
    return _Canvas(image, np.array([column, row], dtype=float) * zoom, zoom)


def _draw_posterior(canvas: _Canvas, estimate: Estimate) -> None:
    if estimate.particles_px is not None:
        points = canvas.point(estimate.particles_px)
        marks.draw_particles(canvas.image, points, estimate.weights, marks.PARTICLE)
    elif estimate.covariance_px is not None and np.isfinite(estimate.covariance_px).all():
        covariance = estimate.covariance_px * canvas.zoom**2
        marks.draw_ellipse(canvas.image, canvas.point(estimate.position_px), covariance, marks.PARTICLE)


def _draw_estimate(canvas: _Canvas, estimate: Estimate, identity: str) -> None:
    if not np.isfinite(estimate.position_px).all():
        return
    if estimate.box_xyxy is not None:
        marks.draw_corners(canvas.image, canvas.box(estimate.box_xyxy), marks.ESTIMATE, canvas.stroke_px)
    position = canvas.point(estimate.position_px)
    marks.draw_cross(canvas.image, position, marks.ESTIMATE, stroke_px=canvas.stroke_px)
    marks.draw_pointer(canvas.image, position, marks.ESTIMATE)
    if identity:
        corner = position if estimate.box_xyxy is None else canvas.point(estimate.box_xyxy[2:])
        x, y = np.clip(corner + _LABEL_PX, -_FAR_PX, _FAR_PX).astype(int)
        marks.draw_label(canvas.image, (x, y), identity, marks.ESTIMATE, size=19, weight=600)


def draw_steered(image: marks.Image, frame: Frame, zoom: float, corner_px: ArrayLike = (0.0, 0.0)) -> None:
    """Outline the steered camera's view of the ground (z = 0), if it is another camera.

    Args:
        image: shows the observed picture at ``zoom`` times its size, its corner at ``corner_px``.
    """
    if frame.steered is None:
        return
    truth, camera = frame.judged
    sides = ((0.5, 1, 1, 0, 0, 0.5), (0, 0, 1, 1, 0, 0))
    border = np.stack([np.interp(np.linspace(0, 5, 201), range(6), side) for side in sides], axis=1)
    ground_m = intersect_plane(camera, truth.T_world_camera, border * (camera.width_px, camera.height_px), 0.0)
    outline = project(frame.camera, frame.truth.T_world_camera, np.insert(ground_m, 2, 0.0, axis=1))[0]
    seen = outline[np.isfinite(outline).all(axis=1)] * zoom + np.asarray(corner_px)
    marks.draw_lines(image, [seen], marks.OBSERVED, 1)


def describe_state(instant: Instant) -> str:
    """Return the target's state in words, ``out of view for 12 frames, over the right edge``; for many a number."""
    truth = instant.frame.truth if len(instant.targets) != 1 else instant.frame.judged[0]
    if len(instant.targets) != 1:
        states = truth.state[list(instant.targets)]
        return f"{int(np.isin(states, ('in', 'partial')).sum())} of {len(states)} targets in view"
    state, side = str(truth.state[instant.target]), truth.side[instant.target]
    if state == "out":
        frames = truth.frames_since_exit[instant.target] + 1
        return f"out of view for {frames} frame{'s' if frames > 1 else ''}, over the {side} edge"
    return {"in": "in view", "partial": "cut by the border", "occluded": "hidden", "absent": "absent"}[state]
