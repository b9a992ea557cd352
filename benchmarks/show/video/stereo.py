"""Drawings of a person followed by a stereo camera: the left picture, and all people from above."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Self

import cv2
import numpy as np
from numpy.typing import NDArray

from benchmarks.contract.judging import truth_as
from benchmarks.judges.stereo.metrics.people import SEEN_AT_LEAST, answered_place_m
from benchmarks.show.video import marks
from benchmarks.show.video.drawing import Canvas, Drawing, InLargerView, Instant, draw_instant, posterior_signs
from scenarios.scenario import Episode
from scenarios.stereo_follow.floor_plan import RoomPlan
from scenarios.stereo_follow.truth import PeopleTruth, StereoTruth
from sim.optics import rays

_CELL_PX = (640, 480)
_PLAN_PX_PER_M = 40.0
_GROUND, _ROOM, _WALL = (30, 33, 38), (52, 56, 63), (150, 156, 166)
_OTHERS, _SIGHT = (182, 186, 194), (74, 80, 92)
_BODY_M = 0.25
_HIDDEN, _NEW_LIGHT = (130, 84, 118), (120, 170, 90)
_WHOLE = 0.9
"""Visible share from which no occluder is named."""


class StereoDrawing(Drawing):
    """See ``Drawing``."""

    signs: Mapping[str, marks.Rgb] = {"truth": marks.TRUTH, "light has changed": _NEW_LIGHT, "hidden": _HIDDEN}
    answers = InLargerView.answers

    def __init__(self, plan: RoomPlan) -> None:
        self._plan = plan

    @classmethod
    def of(cls, episode: Episode) -> Self:
        """Return the drawing of an episode of either scenario of the suite."""
        return cls(episode.map_of().plan)

    def picture(self, instant: Instant) -> NDArray[np.uint8]:
        """See ``Drawing``; (480, 1280, 3): the left picture, and a plan with the truth and the tracker's answer."""
        canvas = Canvas.of(instant.frame.observation.image_rgb, _CELL_PX[0])
        draw_instant(canvas, instant)
        return np.hstack([canvas.image, _plan_view(instant, self._plan)])

    def occasional(self, instant: Instant) -> Mapping[str, marks.Rgb]:
        """See ``Drawing``."""
        return posterior_signs(instant)

    def describe(self, instant: Instant) -> str:
        """See ``Drawing``: visibility, occluder and change of light, ``9 % seen, behind crosser-3, lamp off``."""
        truth, target = truth_as(instant.frame.truth, StereoTruth), instant.target
        seen = truth.visible_fraction[target]
        words = "out of view" if truth.state[target] == "out" else f"{seen:.0%} seen"
        if isinstance(truth, PeopleTruth) and truth.occluder[target] >= 0 and seen < _WHOLE:
            words += f", behind {truth.names[truth.occluder[target]]}"
        return words if truth.light_event is None else f"{words}, {truth.light_event}"

    def shades(self, instant: Instant) -> tuple[marks.Rgb, ...]:
        """See ``Drawing``: light above, visibility of the target below."""
        truth = truth_as(instant.frame.truth, StereoTruth)
        is_seen = truth.visible_fraction[instant.target] >= SEEN_AT_LEAST
        return (marks.CALM if truth.light_event is None else _NEW_LIGHT, marks.CALM if is_seen else _HIDDEN)


def _plan_view(instant: Instant, plan: RoomPlan) -> NDArray[np.uint8]:
    """Draw all people from above, x of the world to the right, the camera in the middle."""
    truth, camera = truth_as(instant.frame.truth, StereoTruth), instant.frame.camera
    picture = np.full((*_CELL_PX[::-1], 3), _GROUND, dtype=np.uint8)
    place_m, turn = truth.T_world_camera[:2, 3], np.diag([_PLAN_PX_PER_M, -_PLAN_PX_PER_M])
    at = Canvas(picture, turn, 0.5 * np.array(_CELL_PX) - turn @ place_m).at
    # Openings are wide enough to break the lines of the walls.
    for areas, wider_m, wall in ((plan.rooms.values(), 0.0, _WALL), (plan.openings, 0.06, _ROOM)):
        for area in areas:
            x0, x1 = area.x0 - wider_m, area.x1 + wider_m
            corners = at([(x0, area.y0), (x1, area.y0), (x1, area.y1), (x0, area.y1)])
            cv2.fillPoly(picture, [marks.fixed_point(corners)], _ROOM, cv2.LINE_AA, 4)
            cv2.polylines(picture, [marks.fixed_point(corners)], True, wall, 1, cv2.LINE_AA, 4)
    borders = rays(camera, truth.T_world_camera, np.array([[0.0, 0.5 * camera.height_px], [camera.width_px, 0.0]]))
    for border in borders[:, :2] / np.linalg.norm(borders[:, :2], axis=1, keepdims=True):
        marks.draw_lines(picture, [at([place_m, place_m + 12.0 * border])], _SIGHT, 1)
    for k, pose in enumerate(truth.T_world_object):
        colour = marks.TRUTH if k == instant.target else _OTHERS
        radius = round(_BODY_M * _PLAN_PX_PER_M * 16)
        cv2.circle(picture, marks.fixed_point(at(pose[:2, 3])), radius, colour, -1, cv2.LINE_AA, 4)
        marks.draw_lines(picture, [at([pose[:2, 3], pose[:2, 3] + 0.45 * pose[:2, 0]])], colour)
    if instant.estimate is not None:
        answer_m = answered_place_m(instant.estimate, truth, camera)
        if np.isfinite(answer_m).all():
            marks.draw_cross(picture, at(answer_m), marks.ESTIMATE)
    words = f"from above: {truth.place}, {truth.illuminance_lx[instant.target]:,.0f} lx on the target"
    marks.draw_label(picture, (16, 28), words, marks.INK)
    return picture
