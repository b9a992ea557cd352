"""Drawings of a scenario's instants: picture, words and legend; the larger view serves those without their own.

An instant is shown as the observed frame inside the larger view, with truth and estimate drawn on it.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Self

import cv2
import numpy as np
from numpy.typing import ArrayLike, NDArray

from benchmarks.contract.text import counted
from benchmarks.show.video import marks
from scenarios.scenario import Frame
from sim.optics import intersect_plane, project
from trackers.types import Answer, Estimate

_SHADE: dict[str, marks.Rgb] = {
    "in": marks.CALM,
    "partial": (120, 84, 104),
    "occluded": (96, 96, 96),
    "out": (204, 121, 167),
    "absent": (30, 32, 36),
    "unlabelled": marks.CALM,
}
_WORDS = {
    "in": "in view",
    "partial": "cut by the border",
    "occluded": "hidden",
    "absent": "absent",
    "unlabelled": "not labelled",
}
"""Of states in the picture or in none; "unlabelled" is of real sequences, see ``SequenceTruth``."""
_GAP_PX, _STRIP_PX = 6, 28
"""Distance of the pictures of a sheet, and height of the text above each."""
_DIMMED = 0.66
"""Brightness of the surroundings of the observed frame."""
_TINT = 0.45
"""Opacity of a mask."""
_NARROWEST_PX, _WIDE_PX = 960, 1600
"""Widths of pictures whose lines are 2 and 3 pixels wide; narrower ones are enlarged."""
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
        zoom: pixels of the larger view over those of the observed frame.
        paths: (K, 2) places of earlier estimates in this picture, oldest first, by identity ('' of one target).
    """

    frame: Frame
    targets: tuple[int, ...]
    answer: Answer | None
    larger_view_rgb: NDArray[np.uint8]
    decides_at: float = 0.0
    zoom: float = 1.0
    paths: Mapping[str, NDArray[np.float64]] = field(default_factory=dict)

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
        if isinstance(self.answer, Estimate):
            return (("", self.answer),)
        return tuple((str(track.identity), track.estimate) for track in self.answer or ())


@dataclass(frozen=True, slots=True, eq=False)
class Canvas:
    """A picture to draw on, and where the points p of a scene lie in it: at ``turn p + corner_px``.

    Attributes:
        image: (H, W, 3) uint8.
        turn: (2, 2), e.g. the zoom of a picture on the diagonal. corner_px: (2,)
    """

    image: NDArray[np.uint8]
    turn: NDArray[np.float64]
    corner_px: NDArray[np.float64]

    @classmethod
    def of(
        cls, image_rgb: NDArray[np.uint8], width_px: int, corner: ArrayLike = (0.0, 0.0), scale: float = 1.0
    ) -> Self:
        """Return a canvas with a picture at another width.

        Points are relative to a ``corner`` in the picture; ``scale``: its pixels over theirs.
        """
        zoom = width_px / image_rgb.shape[1]
        how = cv2.INTER_AREA if zoom < 1 else cv2.INTER_CUBIC
        size = width_px, round(image_rgb.shape[0] * zoom)
        image = np.array(cv2.resize(image_rgb, size, interpolation=how), dtype=np.uint8)
        return cls(image, zoom * scale * np.eye(2), zoom * np.asarray(corner))

    def at(self, points: ArrayLike) -> NDArray[np.float64]:
        """Return points (..., 2 or more) of the scene in the picture (..., 2)."""
        return np.asarray(points, float)[..., :2] @ self.turn.T + self.corner_px

    def box(self, box_xyxy: ArrayLike) -> NDArray[np.float64]:
        """Return a box (4,) of the scene in the picture."""
        return self.at(np.reshape(box_xyxy, (2, 2))).ravel()

    @property
    def stroke_px(self) -> int:
        """Width of the lines on the target, thin enough not to hide it."""
        width_px = self.image.shape[1]
        return 3 if width_px >= _WIDE_PX else 2 if self.turn[0, 0] >= 1 or width_px >= _NARROWEST_PX else 1


def draw_instant(canvas: Canvas, instant: Instant) -> None:
    """Draw the view of a steered camera, paths, posteriors, the targets' true boxes, and estimates."""
    draw_steered(canvas, instant.frame)
    for identity, path in instant.paths.items():
        marks.draw_path(canvas.image, canvas.at(path), _colour_of(identity), max(1, canvas.stroke_px - 1))
    for _, estimate in instant.estimates:
        draw_posterior(canvas, estimate)
    truth = instant.frame.truth
    for target in instant.targets:
        marks.draw_box(canvas.image, canvas.box(truth.box_xyxy[target]), marks.TRUTH, canvas.stroke_px)
        marks.draw_pointer(canvas.image, canvas.at(truth.position_px[target]), marks.TRUTH)
    for identity, estimate in instant.estimates:
        draw_estimate(canvas, estimate, identity, _colour_of(identity))


def _colour_of(identity: str) -> marks.Rgb:
    return marks.colour_of(int(identity)) if identity else marks.ESTIMATE


def draw_steered(canvas: Canvas, frame: Frame) -> None:
    """Outline the steered camera's view of the ground (z = 0), if it is another camera."""
    if frame.steered is None:
        return
    truth, camera = frame.judged
    sides = ((0.5, 1, 1, 0, 0, 0.5), (0, 0, 1, 1, 0, 0))
    border = np.stack([np.interp(np.linspace(0, 5, 201), range(6), side) for side in sides], axis=1)
    ground_m = intersect_plane(camera, truth.T_world_camera, border * (camera.width_px, camera.height_px), 0.0)
    outline = canvas.at(project(frame.camera, frame.truth.T_world_camera, np.insert(ground_m, 2, 0.0, axis=1))[0])
    marks.draw_lines(canvas.image, [outline[np.isfinite(outline).all(axis=1)]], marks.OBSERVED, 1)


def draw_posterior(canvas: Canvas, estimate: Estimate, colour: marks.Rgb = marks.PARTICLE) -> None:
    """Draw the particles of an estimate, or its 95 % ellipse."""
    if estimate.particles_px is not None:
        marks.draw_particles(canvas.image, canvas.at(estimate.particles_px), estimate.weights, colour)
    elif estimate.covariance_px is not None and _has_ellipse(estimate):
        covariance = canvas.turn @ estimate.covariance_px @ canvas.turn.T
        marks.draw_ellipse(canvas.image, canvas.at(estimate.position_px), covariance, colour)


def posterior_signs(instant: Instant) -> Mapping[str, marks.Rgb]:
    """Return the entry of the legend for posteriors, if ``draw_posterior`` draws some."""
    drawn = any(each.particles_px is not None or _has_ellipse(each) for _, each in instant.estimates)
    return {"particles or 95 % ellipse": marks.PARTICLE} if drawn else {}


def _has_ellipse(estimate: Estimate) -> bool:
    covariance_px = estimate.covariance_px
    return covariance_px is not None and bool(np.isfinite([estimate.position_px, *covariance_px]).all())


def draw_estimate(canvas: Canvas, estimate: Estimate, name: str = "", colour: marks.Rgb = marks.ESTIMATE) -> None:
    """Draw the mask of an estimate, its box by its corners, a cross, and its name; nothing of one that is no answer."""
    if not np.isfinite(estimate.position_px).all():
        return
    if estimate.mask is not None:
        draw_mask(canvas, estimate.mask, colour)
    position = corner = canvas.at(estimate.position_px)
    if estimate.box_xyxy is not None:
        box = canvas.box(estimate.box_xyxy)
        marks.draw_corners(canvas.image, box, colour, canvas.stroke_px)
        corner = box[2:]
    marks.draw_cross(canvas.image, position, colour, stroke_px=canvas.stroke_px)
    marks.draw_pointer(canvas.image, position, colour)
    draw_name(canvas, corner, name, colour)


def draw_mask(canvas: Canvas, mask: NDArray[np.bool_], colour: marks.Rgb) -> None:
    """Tint the pixels of a mask (H, W) of the scene."""
    # OpenCV counts from the middles of pixels.
    place = np.column_stack((canvas.turn, canvas.at((0.5, 0.5)) - 0.5))
    size = canvas.image.shape[1], canvas.image.shape[0]
    there = cv2.warpAffine(mask.astype(np.uint8), place, size, flags=cv2.INTER_NEAREST).astype(bool)
    canvas.image[there] = np.round(canvas.image[there] + _TINT * (np.array(colour) - canvas.image[there]))


def draw_name(canvas: Canvas, corner_px: NDArray[np.float64], name: str, colour: marks.Rgb) -> None:
    """Write a name beside the lower right corner (2,) of what it is the name of."""
    if name and np.isfinite(corner_px).all():
        x, y = np.clip(corner_px + _LABEL_PX, -_FAR_PX, _FAR_PX).astype(int)
        marks.draw_label(canvas.image, (x, y), name, colour, size=17, weight=600)


class Drawing(ABC):
    """Draws the instants of one episode, which come in order.

    Attributes:
        uses_larger_view: whether it shows the surroundings of the observed frame.
        signs: entries of the legend, with their colours. answers: further ones, with a tracker; see ``occasional``.
    """

    uses_larger_view = False
    signs: Mapping[str, marks.Rgb]
    answers: Mapping[str, marks.Rgb] = {"estimate, probability of being in view": marks.ESTIMATE}

    def occasional(self, instant: Instant) -> Mapping[str, marks.Rgb]:
        """Return entries of the legend that it has from this instant on, if it did not have them before."""
        return {}

    @abstractmethod
    def picture(self, instant: Instant) -> NDArray[np.uint8]:
        """Return the picture (H, W, 3) of an instant; all have one size."""

    @abstractmethod
    def describe(self, instant: Instant) -> str:
        """Return its description in a few words."""

    @abstractmethod
    def shades(self, instant: Instant) -> tuple[marks.Rgb, ...]:
        """Return its colours on the time line, bands of equal height from the top; equally many for all instants."""


class InLargerView(Drawing):
    """Shows the observed frame in the middle of a larger view, as in the papers, so that a target outside is seen."""

    uses_larger_view = True
    signs: Mapping[str, marks.Rgb] = {
        "the camera's picture": marks.OBSERVED,
        "truth": marks.TRUTH,
        "out of view": _SHADE["out"],
    }
    answers: Mapping[str, marks.Rgb] = {"estimate, its path, probability of being in view": marks.ESTIMATE}

    def __init__(self, width_px: int | None = None) -> None:
        """``width_px``: of the picture; None enlarges small views by a whole factor."""
        self._width_px = width_px

    def occasional(self, instant: Instant) -> Mapping[str, marks.Rgb]:
        """See ``Drawing``."""
        return posterior_signs(instant)

    def picture(self, instant: Instant) -> NDArray[np.uint8]:
        """See ``Drawing``."""
        view, observed = instant.larger_view_rgb, instant.frame.observation.image_rgb
        seen_px = np.array(observed.shape[:2])
        if instant.zoom != 1.0:
            height, width = np.round(seen_px * instant.zoom).astype(int)
            observed = np.asarray(cv2.resize(observed, (width, height), interpolation=cv2.INTER_AREA), np.uint8)
        height, width = observed.shape[:2]
        row, column = ((np.array(view.shape[:2]) - observed.shape[:2]) / 2).astype(int)
        image = (view * np.float32(_DIMMED)).astype(np.uint8)
        image[row : row + height, column : column + width] = observed
        width_px = self._width_px or view.shape[1] * max(1, -(-_NARROWEST_PX // view.shape[1]))
        canvas = Canvas.of(image, width_px, (column, row), instant.zoom)
        marks.draw_box(canvas.image, canvas.box([0, 0, *seen_px[::-1]]), marks.OBSERVED)
        draw_instant(canvas, instant)
        return canvas.image

    def describe(self, instant: Instant) -> str:
        """See ``Drawing``: ``out of view for 12 frames, over the right edge``; of many targets how many are in view."""
        if len(instant.targets) != 1:
            states = instant.frame.truth.state[list(instant.targets)]
            return f"{int(np.isin(states, ('in', 'partial')).sum())} of {len(states)} targets in view"
        truth, target = instant.frame.judged[0], instant.target
        state = str(truth.state[target])
        if state == "out":
            frames = counted(int(truth.frames_since_exit[target]) + 1, "frame")
            over = f", over the {truth.side[target]} edge" if truth.side[target] else ""
            return f"out of view for {frames}{over}"
        return _WORDS[state]

    def shades(self, instant: Instant) -> tuple[marks.Rgb, ...]:
        """See ``Drawing``."""
        one = len(instant.targets) == 1
        return (_SHADE[str(instant.frame.judged[0].state[instant.target])] if one else marks.CALM,)


class OfFootage(InLargerView):
    """Shows footage, of which no truth is known: what is said of an instant comes from the tracker alone."""

    signs: Mapping[str, marks.Rgb] = {"the picture": marks.OBSERVED}

    def occasional(self, instant: Instant) -> Mapping[str, marks.Rgb]:
        """See ``Drawing``."""
        outside = {"estimate outside it": _SHADE["out"]} if _beyond(instant) else {}
        return {**super().occasional(instant), **outside}

    def picture(self, instant: Instant) -> NDArray[np.uint8]:
        """See ``Drawing``."""
        if instant.estimate is None:
            self.answers = {"tracks and their paths, a colour for each identity": marks.colour_of(0)}
        return super().picture(instant)

    def describe(self, instant: Instant) -> str:
        """See ``Drawing``: ``estimate over the left edge``; of a tracker of many how many tracks there are."""
        if instant.estimate is None:
            return counted(len(instant.estimates), "track")
        beyond = _beyond(instant)
        return f"estimate over the {beyond} edge" if beyond else ""

    def shades(self, instant: Instant) -> tuple[marks.Rgb, ...]:
        """See ``Drawing``."""
        return (_SHADE["out"] if _beyond(instant) else marks.CALM,)


def _beyond(instant: Instant) -> str:
    """Return the edge of the picture beyond which the estimate of the one target lies; "" if it is inside or none."""
    if instant.estimate is None:
        return ""
    (x, y), camera = instant.estimate.position_px, instant.frame.camera
    past_px = {"left": -x, "top": -y, "right": x - camera.width_px, "bottom": y - camera.height_px}
    edge = max(past_px, key=lambda name: past_px[name])
    return edge if past_px[edge] > 0 else ""


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
