"""Drawings of a person followed by a stereo camera: both pictures, disparity, and all people from above."""

from __future__ import annotations

from typing import Self

import cv2
import numpy as np
from numpy.typing import NDArray

from benchmarks.contract.judging import truth_as
from benchmarks.judges.stereo.metrics.people import SEEN_AT_LEAST, answered_place_m
from benchmarks.show.video import marks
from benchmarks.show.video.drawing import ESTIMATE_SIGN, PROBABILITY_SIGN, TRUTH_SIGN, Instant, Sign, shaded
from scenarios.scenario import Episode
from scenarios.stereo_follow.floor_plan import Area, RoomPlan
from scenarios.stereo_follow.truth import PeopleTruth, StereoTruth
from sim.optics import rays
from trackers.light_adaptive_stereo.matching import StereoMatcher
from trackers.types import CameraRegisters

_CELL_PX = (640, 480)
_PLAN_PX_PER_M = 40.0
_CAPTION_AT = (16, 28)
_GROUND, _ROOM, _WALL = (30, 33, 38), (52, 56, 63), (150, 156, 166)
_OTHERS, _SIGHT = (182, 186, 194), (74, 80, 92)
_LARGEST_DISPARITY_PX = 64.0
_BODY_M = 0.25
_CALM, _HIDDEN, _NEW_LIGHT = (54, 58, 66), (130, 84, 118), (120, 170, 90)
_WHOLE = 0.9
"""Visible share from which no occluder is named."""


class StereoDrawing:
    """See ``Drawing``."""

    uses_larger_view = False
    signs: tuple[Sign, ...] = (
        TRUTH_SIGN,
        shaded("light has changed", _NEW_LIGHT),
        shaded("hidden", _HIDDEN),
        ESTIMATE_SIGN,
        PROBABILITY_SIGN,
    )

    def __init__(self, plan: RoomPlan) -> None:
        self._plan = plan
        self._matcher = StereoMatcher()

    @classmethod
    def of(cls, episode: Episode) -> Self:
        """Return the drawing of an episode of either scenario of the suite."""
        return cls(episode.map_of().plan)

    def picture(self, instant: Instant) -> NDArray[np.uint8]:
        """See ``Drawing``; (960, 1280, 3): left and right above, disparity and plan view below.

        The disparity is matched from the pair, as by trackers; the plan view shows the truth and the tracker's answer.
        """
        right = instant.frame.observation.right_rgb
        upper = [_left(instant), _lost() if right is None else _enlarged(right)]
        for picture, words in zip(upper, ("left picture", "right picture"), strict=True):
            marks.draw_label(picture, _CAPTION_AT, words, marks.INK)
        lower = [_disparity(instant, self._matcher), _plan_view(instant, self._plan)]
        return np.vstack([np.hstack(upper), np.hstack(lower)])

    def describe(self, instant: Instant) -> str:
        """See ``Drawing``."""
        return describe_person(instant)

    def shades(self, instant: Instant) -> tuple[marks.Rgb, ...]:
        """See ``Drawing``: light above, visibility of the target below."""
        truth = truth_as(instant.frame.truth, StereoTruth)
        is_seen = truth.visible_fraction[instant.target] >= SEEN_AT_LEAST
        return (_CALM if truth.light_event is None else _NEW_LIGHT, _CALM if is_seen else _HIDDEN)


def describe_person(instant: Instant) -> str:
    """Return visibility, occluder and change of light in words: ``9 % seen, behind crosser-3, lamp off``."""
    truth = truth_as(instant.frame.truth, StereoTruth)
    if truth.state[instant.target] == "out":
        words = "out of view"
    else:
        seen = truth.visible_fraction[instant.target]
        occluder = truth.occluder[instant.target] if isinstance(truth, PeopleTruth) else -1
        words = f"{seen:.0%} seen"
        words += f", behind {truth.names[occluder]}" if occluder >= 0 and seen < _WHOLE else ""
    return words if truth.light_event is None else f"{words}, {truth.light_event}"


class LeftAndPlan(StereoDrawing):
    """The left picture beside the plan view alone."""

    def picture(self, instant: Instant) -> NDArray[np.uint8]:
        """See ``Drawing``; (480, 1280, 3)."""
        return np.hstack([_left(instant), _plan_view(instant, self._plan)])


def _left(instant: Instant) -> NDArray[np.uint8]:
    left = _enlarged(instant.frame.observation.image_rgb)
    zoom = left.shape[1] / instant.frame.observation.image_rgb.shape[1]
    truth = instant.frame.truth
    marks.draw_box(left, truth.box_xyxy[instant.target] * zoom, marks.TRUTH)
    estimate = instant.estimate
    if estimate is not None and np.isfinite(estimate.position_px).all():
        if estimate.box_xyxy is not None:
            marks.draw_corners(left, estimate.box_xyxy * zoom, marks.ESTIMATE)
        marks.draw_cross(left, estimate.position_px * zoom, marks.ESTIMATE)
    return left


def _enlarged(image: NDArray[np.uint8]) -> NDArray[np.uint8]:
    how = cv2.INTER_NEAREST if image.shape[1] < _CELL_PX[0] else cv2.INTER_AREA
    return np.asarray(cv2.resize(image, _CELL_PX, interpolation=how), dtype=np.uint8).copy()


def _lost() -> NDArray[np.uint8]:
    nothing = np.full((_CELL_PX[1], _CELL_PX[0], 3), _GROUND, dtype=np.uint8)
    marks.draw_text(nothing, (24, 64), "picture lost", _WALL)
    return nothing


def _disparity(instant: Instant, matcher: StereoMatcher) -> NDArray[np.uint8]:
    observation = instant.frame.observation
    if observation.right_rgb is None:
        return _lost()
    camera = observation.camera
    depth_m = matcher.depth_m(observation.image_rgb, observation.right_rgb, camera)
    assert camera.baseline_m is not None
    disparity = np.nan_to_num(_CELL_PX[0] / camera.width_px * camera.focal_px * camera.baseline_m / depth_m)
    level = np.clip(255.0 * np.sqrt(disparity / _LARGEST_DISPARITY_PX), 0, 255).astype(np.uint8)
    coloured = cv2.applyColorMap(level, cv2.COLORMAP_VIRIDIS)[..., ::-1]
    coloured = np.where((disparity > 0)[..., None], coloured, np.array(_GROUND, np.uint8))
    picture = _enlarged(np.ascontiguousarray(coloured))
    marks.draw_label(picture, _CAPTION_AT, "disparity, matched from the pair", marks.INK)
    return picture


def _plan_view(instant: Instant, plan: RoomPlan) -> NDArray[np.uint8]:
    """Draw all people from above, x of the world to the right, the camera in the middle."""
    truth = truth_as(instant.frame.truth, StereoTruth)
    picture = np.full((_CELL_PX[1], _CELL_PX[0], 3), _GROUND, dtype=np.uint8)
    place_m = truth.T_world_camera[:2, 3]

    def at(points_m: NDArray[np.float64]) -> NDArray[np.float64]:
        return 0.5 * np.array(_CELL_PX) + (np.asarray(points_m) - place_m) * (_PLAN_PX_PER_M, -_PLAN_PX_PER_M)

    def fill(area: Area) -> None:
        corners = np.array([(area.x0, area.y0), (area.x1, area.y0), (area.x1, area.y1), (area.x0, area.y1)])
        cv2.fillPoly(picture, [marks.fixed_point(at(corners))], _ROOM, cv2.LINE_AA, 4)
        marks.draw_lines(picture, [at(np.vstack([corners, corners[:1]]))], _WALL, 1)

    for room in plan.rooms.values():
        fill(room)
    for opening in plan.openings:
        cv2.fillPoly(picture, [marks.fixed_point(at(_wider(opening)))], _ROOM, cv2.LINE_AA, 4)
    camera = instant.frame.camera
    borders = rays(camera, truth.T_world_camera, np.array([[0.0, 0.5 * camera.height_px], [camera.width_px, 0.0]]))
    for border in borders[:, :2] / np.linalg.norm(borders[:, :2], axis=1, keepdims=True):
        marks.draw_lines(picture, [at(np.array([place_m, place_m + 12.0 * border]))], _SIGHT, 1)
    for k, pose in enumerate(truth.T_world_object):
        colour = marks.TRUTH if k == instant.target else _OTHERS
        centre = marks.fixed_point(at(pose[:2, 3]))
        cv2.circle(picture, centre, round(_BODY_M * _PLAN_PX_PER_M * 16), colour, -1, cv2.LINE_AA, 4)
        marks.draw_lines(picture, [at(np.array([pose[:2, 3], pose[:2, 3] + 0.45 * pose[:2, 0]]))], colour)
    if instant.estimate is not None:
        answer_m = answered_place_m(instant.estimate, truth, instant.frame.camera)
        if np.isfinite(answer_m).all():
            marks.draw_cross(picture, at(answer_m), marks.ESTIMATE)
    lux = truth.illuminance_lx[instant.target]
    event = f", {truth.light_event}" if truth.light_event else ""
    marks.draw_label(picture, _CAPTION_AT, f"from above: {truth.place}, {lux:,.0f} lx on the target{event}", marks.INK)
    marks.draw_label(picture, (16, _CELL_PX[1] - 14), settings_in_words(truth.registers), marks.INK)
    return picture


def settings_in_words(registers: CameraRegisters) -> str:
    """Return a camera's settings by name, in the camera's own steps."""
    balance = f"white balance red {registers.red}, blue {registers.blue}"
    return f"camera: {balance}; shutter {registers.shutter}, gain {registers.gain}"


def _wider(opening: Area) -> NDArray[np.float64]:
    """Return an opening's corners (4, 2), wide enough to break the lines of the walls."""
    x0, x1 = opening.x0 - 0.06, opening.x1 + 0.06
    return np.array([(x0, opening.y0), (x1, opening.y0), (x1, opening.y1), (x0, opening.y1)])
