"""Drawings of a scenario's instants: picture, words and legend; the larger view serves those without their own.

An instant is shown as the observed frame inside the larger view, with truth and estimate drawn on it.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Protocol

import cv2
import numpy as np
from numpy.typing import ArrayLike, NDArray

from benchmarks.show.video import marks
from scenarios.scenario import Frame
from sim.optics import intersect_plane, project
from trackers.types import Answer, Estimate

_SIGN_PX, _RISE_PX, _DROP_PX = 20, 12, 2
"""Width of a sign, and its extent above and below the baseline of the text."""
_SHADE: dict[str, marks.Rgb] = {
    "in": (54, 58, 66),
    "partial": (120, 84, 104),
    "occluded": (96, 96, 96),
    "out": (204, 121, 167),
    "absent": (30, 32, 36),
}
_GAP_PX, _STRIP_PX = 6, 28
"""Distance of the pictures of a sheet, and height of the text above each."""
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


@dataclass(frozen=True, slots=True)
class Sign:
    """A sign and its meaning.

    Attributes:
        words: its meaning.
        draw: draws it on a picture with the lower left corner at (x, y) of the baseline.
        of_tracker: whether it is drawn only with a tracker.
    """

    words: str
    draw: Callable[[marks.Image, int, int], None]
    of_tracker: bool = False


def outlined(words: str, colour: marks.Rgb) -> Sign:
    """Return the sign of an outline in a colour."""

    def draw(image: marks.Image, x: int, y: int) -> None:
        marks.draw_box(image, np.array([x, y - _RISE_PX, x + _SIGN_PX, y + float(_DROP_PX)]), colour)

    return Sign(words, draw)


def shaded(words: str, colour: marks.Rgb) -> Sign:
    """Return the sign of a shade on the time line."""

    def draw(image: marks.Image, x: int, y: int) -> None:
        image[y - _RISE_PX : y + _DROP_PX, x : x + _SIGN_PX] = colour

    return Sign(words, draw)


def _estimate_sign(image: marks.Image, x: int, y: int) -> None:
    marks.draw_corners(image, np.array([x, y - _RISE_PX, x + _SIGN_PX, y + float(_DROP_PX)]), marks.ESTIMATE)
    marks.draw_cross(image, np.array([x + 10.0, y - 5.0]), marks.ESTIMATE, stroke_px=1)


def _posterior_sign(image: marks.Image, x: int, y: int) -> None:
    cloud = np.array([[2.0, -3], [7, -8], [9, -1], [13, -6], [18, -4]]) + np.array([x, y])
    marks.draw_particles(image, cloud, None, marks.PARTICLE)


def _probability_sign(image: marks.Image, x: int, y: int) -> None:
    marks.draw_lines(image, [[(x, y - 5.0), (x + _SIGN_PX, y - 5.0)]], marks.ESTIMATE)


TRUTH_SIGN = outlined("truth", marks.TRUTH)
ESTIMATE_SIGN = Sign("estimate", _estimate_sign, of_tracker=True)
POSTERIOR_SIGN = Sign("particles or 95 % ellipse", _posterior_sign, of_tracker=True)
PROBABILITY_SIGN = Sign("tracker's probability of being in view", _probability_sign, of_tracker=True)


def draw_legend(image: marks.Image, at_px: tuple[int, int], signs: Sequence[Sign], *, with_tracker: bool) -> None:
    """Draw signs in a row, each before its text; the baseline begins at ``at_px``."""
    x, y = at_px
    for sign in signs:
        if with_tracker or not sign.of_tracker:
            sign.draw(image, x, y)
            x = marks.draw_text(image, (x + 28, y), sign.words, marks.QUIET, size=14) + 24


class Drawing(Protocol):
    """Draws the instants of one episode.

    Attributes:
        uses_larger_view: whether it shows the surroundings of the observed frame.
        signs: entries of the legend.
    """

    uses_larger_view: bool
    signs: tuple[Sign, ...]

    def picture(self, instant: Instant) -> NDArray[np.uint8]:
        """Return the picture (H, W, 3) of an instant; all have one size."""
        ...

    def describe(self, instant: Instant) -> str:
        """Return its description in a few words."""
        ...

    def shades(self, instant: Instant) -> tuple[marks.Rgb, ...]:
        """Return its colours on the time line, bands of equal height from the top; equally many for all instants."""
        ...


class InLargerView:
    """Shows the observed frame in the middle of a larger view, as in the papers, so that a target outside is seen."""

    uses_larger_view = True

    def __init__(self, width_px: int | None = None) -> None:
        """``width_px``: of the picture; None enlarges small views by a whole factor."""
        self._width_px = width_px

    signs: tuple[Sign, ...] = (
        outlined("the camera's picture", marks.OBSERVED),
        TRUTH_SIGN,
        shaded("out of view", _SHADE["out"]),
        ESTIMATE_SIGN,
        POSTERIOR_SIGN,
        PROBABILITY_SIGN,
    )

    def picture(self, instant: Instant) -> NDArray[np.uint8]:
        """See ``Drawing``."""
        zoom = None if self._width_px is None else self._width_px / instant.larger_view_rgb.shape[1]
        return draw_instant(instant, zoom)

    def describe(self, instant: Instant) -> str:
        """See ``Drawing``."""
        return describe_state(instant)

    def shades(self, instant: Instant) -> tuple[marks.Rgb, ...]:
        """See ``Drawing``."""
        if len(instant.targets) != 1:
            return (_SHADE["in"],)
        return (_SHADE[str(instant.frame.judged[0].state[instant.target])],)


def picture_sheet(
    rows: Sequence[Sequence[tuple[str, NDArray[np.uint8]]]], cell_width_px: int = 240
) -> NDArray[np.uint8]:
    """Return pictures (h, w, 3), all of one size, under their text: (H, W, 3) uint8.

    Args:
        rows: of (text, picture), equally many in each.
        cell_width_px: width of one picture.
    """
    cells = [np.hstack([_cell(words, image, cell_width_px) for words, image in row]) for row in rows]
    return np.vstack(cells)[:-_GAP_PX, :-_GAP_PX]


def _cell(words: str, image_rgb: NDArray[np.uint8], width_px: int) -> NDArray[np.uint8]:
    height_px = round(width_px * image_rgb.shape[0] / image_rgb.shape[1])
    cell = np.full((_STRIP_PX + height_px + _GAP_PX, width_px + _GAP_PX, 3), marks.GROUND, dtype=np.uint8)
    small = cv2.resize(image_rgb, (width_px, height_px), interpolation=cv2.INTER_AREA)
    cell[_STRIP_PX : _STRIP_PX + height_px, :width_px] = small
    marks.draw_text(cell, (4, 20), words, marks.INK, size=14, weight=600)
    return cell
