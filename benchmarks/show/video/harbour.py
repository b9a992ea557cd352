"""Videos of a harbour: the thermal picture with 3-D boxes, a plan view beside it, tracks on nothing by cause.

Tracks do not say where in the world they head: their boxes are drawn with the length along the line of sight.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import cv2
import numpy as np
from numpy.typing import NDArray

from benchmarks.contract.judging import truth_as
from benchmarks.contract.text import counted
from benchmarks.judges.harbour.alarms import CAUSES, Clutter
from benchmarks.judges.harbour.answers import answers_of, objects_of
from benchmarks.judges.harbour.matching import match_frame
from benchmarks.judges.harbour.streaks import RUNNING
from benchmarks.show.video import marks
from benchmarks.show.video.drawing import Canvas, Drawing, Instant, draw_estimate, draw_name, draw_steered
from scenarios.harbour.truth import HarbourMap, HarbourTruth
from scenarios.scenario import Episode, Frame
from sim.optics import project
from trackers.types import Estimate, Track

_WIDTH_PX = 960
_MARGIN_M = 6.0
_SEA, _LAND = (36, 48, 62), (62, 60, 56)
_ALARM: marks.Rgb = (213, 94, 0)
_NEITHER: marks.Rgb = (182, 186, 194)
_THERE = (86, 140, 180)
_SIDES = np.array([(-0.5, -0.5), (0.5, -0.5), (0.5, 0.5), (-0.5, 0.5), (-0.5, -0.5)])
_NAMED_AT_MOST = 20
"""Words at more false tracks than this would hide the picture."""


class HarbourDrawing(Drawing):
    """See ``Drawing``."""

    signs: Mapping[str, marks.Rgb] = {"truth": marks.TRUTH, "intruders in view": _THERE}
    answers: Mapping[str, marks.Rgb] = {
        "track on an intruder": marks.ESTIMATE,
        f"track on nothing, a false alarm from its {RUNNING}th frame on": _ALARM,
        "at an intruder, but not counted": _NEITHER,
    }

    def __init__(self, episode: Episode) -> None:
        self._map: HarbourMap = episode.map_of()
        self._clutter = Clutter(self._map.clutter)

    def picture(self, instant: Instant) -> NDArray[np.uint8]:
        """See ``Drawing``."""
        frame, truth = instant.frame, truth_as(instant.frame.truth, HarbourTruth)
        canvas = Canvas.of(frame.observation.image_rgb, _WIDTH_PX)
        plan = plan_of(self._map, canvas.image.shape[0])
        for k in np.flatnonzero(truth.state != "absent"):
            T = truth.T_world_object[k]
            corners = np.pad(_SIDES, ((0, 0), (0, 1))) * truth.size_m[k]
            up_m = T[:3, 2] * truth.size_m[k, 2]
            _draw_box(canvas, plan, frame, corners @ T[:3, :3].T + T[:3, 3], up_m, marks.TRUTH)
        draw_steered(canvas, frame)
        if isinstance(instant.answer, Estimate):
            self.answers = Drawing.answers
            draw_estimate(canvas, instant.answer)
        elif instant.answer is not None:
            self._draw_tracks(canvas, plan, frame, instant.answer, instant.decides_at)
        return np.hstack([canvas.image, plan.image])

    def _draw_tracks(
        self, canvas: Canvas, plan: Canvas, frame: Frame, tracks: Sequence[Track], decides_at: float
    ) -> None:
        truth = truth_as(frame.truth, HarbourTruth)
        answers = answers_of(tracks, frame.camera, truth.T_world_camera)
        answers, objects = answers.only(answers.confidence >= decides_at), objects_of(truth)
        matches = match_frame(objects, answers, np.full(len(objects.judged), -1))
        causes = iter(self._clutter.causes(truth.instance_map, answers.box_xyxy[matches.false]))
        for row, (false, on) in enumerate(zip(matches.false, matches.target >= 0, strict=True)):
            colour = _ALARM if false else marks.ESTIMATE if on else _NEITHER
            words = CAUSES[next(causes)].replace("_", " ") if false else answers.kind[row] if on else ""
            place_m, size_m, box = answers.place_m[row], answers.size_m[row], canvas.box(answers.box_xyxy[row])
            if np.isfinite([*place_m, *size_m]).all():
                ahead = place_m[:2] - truth.T_world_camera[:2, 3]
                turn = np.stack([ahead, [-ahead[1], ahead[0]]]) / np.linalg.norm(ahead)
                low = np.append(place_m[:2], place_m[2] - 0.5 * size_m[2])
                base_m = np.pad(_SIDES * size_m[:2] @ turn, ((0, 0), (0, 1))) + low
                _draw_box(canvas, plan, frame, base_m, np.array([0.0, 0.0, size_m[2]]), colour)
            else:
                marks.draw_corners(canvas.image, box, colour, 1)
            if on or matches.false.sum() <= _NAMED_AT_MOST:
                draw_name(canvas, box[2:], words, colour)

    def describe(self, instant: Instant) -> str:
        """See ``Drawing``."""
        truth = truth_as(instant.frame.truth, HarbourTruth)
        step = ", the picture's gain steps" if truth.agc_step else ""
        here = counted(int(objects_of(truth).seen.sum()), "intruder")
        return f"{here} in view, tide {truth.tide_m:+.2f} m{step}"

    def shades(self, instant: Instant) -> tuple[marks.Rgb, ...]:
        """See ``Drawing``."""
        return (_THERE if objects_of(truth_as(instant.frame.truth, HarbourTruth)).seen.any() else marks.CALM,)


def _draw_box(
    canvas: Canvas,
    plan: Canvas,
    frame: Frame,
    base_m: NDArray[np.float64],
    up_m: NDArray[np.float64],
    colour: marks.Rgb,
) -> None:
    """Draw a box with the base (5, 3), a closed line, in both pictures; in the camera's none that is partly behind."""
    px = canvas.at(project(frame.camera, frame.truth.T_world_camera, np.stack([base_m, base_m + up_m]))[0])
    if np.isfinite(px).all():
        marks.draw_lines(canvas.image, px, colour, 1)
        marks.draw_lines(canvas.image, np.stack([px[0, :4], px[1, :4]], axis=1), colour, 1)
    marks.draw_lines(plan.image, [plan.at(base_m)], colour, 1)


def plan_of(site: HarbourMap, height_px: int) -> Canvas:
    """Return land, sea, the quay's edge and the watched volume from above, the line of sight upwards.

    ``height_px``: of the picture; the watched volume fills it but for a margin.
    """
    depth_m, width_m = site.volume_m[:2]
    px_per_m = height_px / (depth_m + 2.0 * _MARGIN_M)
    image = np.full((height_px, round((width_m + 2.0 * _MARGIN_M) * px_per_m), 3), _SEA, np.uint8)
    turn = np.array([[0.0, -px_per_m], [-px_per_m, 0.0]]) @ site.volume_axes
    top_left_m = site.volume_centre_m[:2] + (0.5 * site.volume_m[:2] + _MARGIN_M) @ site.volume_axes
    plan = Canvas(image, turn, -turn @ top_left_m)
    cv2.fillPoly(image, [marks.fixed_point(plan.at(site.land_m))], _LAND, cv2.LINE_AA, 4)
    volume_m = site.volume_centre_m[:2] + _SIDES * site.volume_m[:2] @ site.volume_axes
    for line_m in (site.wall_m, volume_m):
        marks.draw_lines(image, [plan.at(line_m)], marks.QUIET, 1)
    marks.draw_text(image, (8, 18), f"watched from above: {depth_m:g} m × {width_m:g} m", marks.QUIET, size=13)
    return plan
