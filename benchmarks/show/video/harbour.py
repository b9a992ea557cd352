"""Videos of a harbour: the thermal picture with 3-D boxes, a plan view beside it, false alarms by cause.

Tracks do not say where in the world they head: their boxes are drawn with the length along the line of sight.
"""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import ArrayLike, NDArray

from benchmarks.contract.judging import truth_as
from benchmarks.judges.harbour.alarms import CAUSES, Clutter
from benchmarks.judges.harbour.answers import Answers, answers_of, objects_of
from benchmarks.judges.harbour.matching import Matcher, Matches
from benchmarks.judges.harbour.streaks import RUNNING
from benchmarks.show.video import marks
from benchmarks.show.video.drawing import ESTIMATE_SIGN, TRUTH_SIGN, Instant, Sign, draw_steered, shaded
from scenarios.harbour.truth import HarbourMap, HarbourTruth
from scenarios.scenario import Episode
from sim.optics import project
from trackers.types import Estimate

_WIDTH_PX = 960
_MARGIN_M = 6.0
_SEA, _LAND = (36, 48, 62), (62, 60, 56)
_ALARM: marks.Rgb = (213, 94, 0)
_NEITHER: marks.Rgb = (182, 186, 194)
_CALM, _THERE = (54, 58, 66), (86, 140, 180)
_SIDES = np.array([(-0.5, -0.5), (0.5, -0.5), (0.5, 0.5), (-0.5, 0.5), (-0.5, -0.5)])
_NAMED_AT_MOST = 20
"""Words at more false tracks than this would hide the picture."""


def _box_sign(words: str, colour: marks.Rgb) -> Sign:
    def draw(image: marks.Image, x: int, y: int) -> None:
        marks.draw_lines(image, [_SIDES * (18, 12) + (x + 10, y - 5)], colour, 1)
        marks.draw_lines(image, [_SIDES * (18, 12) + (x + 14, y - 8)], colour, 1)

    return Sign(words, draw, of_tracker=True)


_INTRUDERS = shaded("intruders in view", _THERE)


class HarbourDrawing:
    """See ``Drawing``. Instants come in order, as alarms are raised by four of them."""

    uses_larger_view = False
    signs: tuple[Sign, ...] = (
        TRUTH_SIGN,
        _INTRUDERS,
        _box_sign("track on an intruder", marks.ESTIMATE),
        _box_sign(f"track on nothing, a false alarm from its {RUNNING}th frame on", _ALARM),
        _box_sign("at an intruder, but not counted", _NEITHER),
    )

    def __init__(self, episode: Episode) -> None:
        self._map: HarbourMap = episode.map_of()
        self._clutter = Clutter(self._map.clutter)
        self._matcher = Matcher()
        self._alarms = _Alarms()

    def picture(self, instant: Instant) -> NDArray[np.uint8]:
        """See ``Drawing``."""
        truth = truth_as(instant.frame.truth, HarbourTruth)
        observed = instant.frame.observation.image_rgb
        self._zoom = _WIDTH_PX / observed.shape[1]
        size = _WIDTH_PX, round(observed.shape[0] * self._zoom)
        image = np.asarray(cv2.resize(observed, size, interpolation=cv2.INTER_CUBIC), np.uint8)
        self._plan = PlanView(self._map, size[1])
        plan = self._plan.ground
        for k in np.flatnonzero(truth.state != "absent"):
            T = truth.T_world_object[k]
            corners = np.pad(_SIDES, ((0, 0), (0, 1))) * truth.size_m[k]
            self._draw_box(image, instant, corners @ T[:3, :3].T + T[:3, 3], T[:3, 2] * truth.size_m[k, 2], marks.TRUTH)
            marks.draw_lines(plan, [self._plan.at(corners @ T[:3, :3].T + T[:3, 3])], marks.TRUTH, 1)
        draw_steered(image, instant.frame, self._zoom)
        if isinstance(instant.answer, Estimate):
            self._draw_one(image, instant.answer)
        elif instant.answer is not None:
            answers = answers_of(instant.answer, instant.frame.camera, truth.T_world_camera)
            answers = answers.only(answers.confidence >= instant.decides_at)
            matches = self._matcher.match(objects_of(truth), answers)
            causes = self._clutter.causes(truth.instance_map, answers.box_xyxy[matches.false])
            words = self._alarms.words(answers.identity[matches.false], causes, truth.agc_step)
            self._draw_tracks(image, plan, instant, answers, matches, words)
        return np.hstack([image, plan])

    def _draw_one(self, image: marks.Image, estimate: Estimate) -> None:
        """Draw the answer of a tracker that follows one target."""
        self.signs = (TRUTH_SIGN, _INTRUDERS, ESTIMATE_SIGN)
        if estimate.box_xyxy is not None:
            marks.draw_corners(image, estimate.box_xyxy * self._zoom, marks.ESTIMATE)
        if np.isfinite(estimate.position_px).all():
            marks.draw_cross(image, estimate.position_px * self._zoom, marks.ESTIMATE)

    def _draw_tracks(
        self,
        image: marks.Image,
        plan: marks.Image,
        instant: Instant,
        answers: Answers,
        matches: Matches,
        words: dict[int, str],
    ) -> None:
        for row, identity in enumerate(answers.identity.tolist()):
            false, on = matches.false[row], matches.target[row] >= 0
            colour = _ALARM if false else marks.ESTIMATE if on else _NEITHER
            place_m, size_m = answers.place_m[row], answers.size_m[row]
            if np.isfinite([*place_m, *size_m]).all():
                ahead = place_m[:2] - instant.frame.truth.T_world_camera[:2, 3]
                turn = np.stack([ahead, [-ahead[1], ahead[0]]]) / np.linalg.norm(ahead)
                low = np.append(place_m[:2], place_m[2] - 0.5 * size_m[2])
                base = np.pad(_SIDES * size_m[:2] @ turn, ((0, 0), (0, 1))) + low
                self._draw_box(image, instant, base, np.array([0.0, 0.0, size_m[2]]), colour)
                marks.draw_lines(plan, [self._plan.at(base)], colour, 1)
            else:
                marks.draw_corners(image, answers.box_xyxy[row] * self._zoom, colour, 1)
            words_of_cause = words.get(identity, "") if len(words) <= _NAMED_AT_MOST else ""
            label = words_of_cause or answers.kind[row]
            if label and (words_of_cause or on):
                x, y = (answers.box_xyxy[row, 2:] * self._zoom).clip(-1e4, 1e4).astype(int)
                marks.draw_label(image, (x + 3, y + 3), label, colour, size=15, weight=600)
            if words_of_cause and np.isfinite(place_m).all():
                x, y = self._plan.at(place_m).clip(-1e4, 1e4).astype(int)
                marks.draw_text(plan, (x + 6, y + 4), words_of_cause, colour, size=13)

    def _draw_box(
        self,
        image: marks.Image,
        instant: Instant,
        base_m: NDArray[np.float64],
        up_m: NDArray[np.float64],
        colour: marks.Rgb,
    ) -> None:
        """Draw an upright box with the base (5, 3), a closed line; nothing if part of it is behind the camera."""
        both_m = np.stack([base_m, base_m + up_m])
        px = project(instant.frame.camera, instant.frame.truth.T_world_camera, both_m)[0] * self._zoom
        if np.isfinite(px).all():
            marks.draw_lines(image, px, colour, 1)
            marks.draw_lines(image, np.stack([px[0, :4], px[1, :4]], axis=1), colour, 1)

    def describe(self, instant: Instant) -> str:
        """See ``Drawing``."""
        truth = truth_as(instant.frame.truth, HarbourTruth)
        here = int(objects_of(truth).seen.sum())
        step = ", the picture's gain steps" if truth.agc_step else ""
        return f"{here or 'no'} intruder{'' if here == 1 else 's'} in view, tide {truth.tide_m:+.2f} m{step}"

    def shades(self, instant: Instant) -> tuple[marks.Rgb, ...]:
        """See ``Drawing``."""
        return (_THERE if objects_of(truth_as(instant.frame.truth, HarbourTruth)).seen.any() else _CALM,)


class _Alarms:
    """Which tracks on nothing are alarms by now, and why: from the fourth frame running on, see ``alarms``."""

    def __init__(self) -> None:
        self._running: dict[int, tuple[int, bool]] = {}
        self._stepped = False

    def words(self, identities: NDArray[np.int64], causes: NDArray[np.uint8], agc_step: bool) -> dict[int, str]:
        """Take the tracks on nothing (F,) of the next frame; return the causes of those that are alarms, in words."""
        first = 1, bool(agc_step or self._stepped)
        self._stepped = bool(agc_step)
        before, self._running = self._running, {}
        alarms = {}
        for identity, cause in zip(identities.tolist(), causes.tolist(), strict=True):
            frames, by_step = before.get(identity, (0, False))
            self._running[identity] = (frames + 1, by_step) if frames else first
            if frames + 1 >= RUNNING:
                by_step = self._running[identity][1]
                alarms[identity] = ("agc_step" if by_step else CAUSES[cause]).replace("_", " ")
        return alarms


class PlanView:
    """A harbour from above, to draw on; the camera is below the picture, its line of sight points upwards.

    Attributes:
        ground: picture (H, W, 3) of land, sea, the quay's edge and the watched volume.
    """

    def __init__(self, site: HarbourMap, height_px: int) -> None:
        """``height_px``: of the picture; the watched volume fills it but for a margin."""
        depth_m, width_m = site.volume_m[:2]
        self._px_per_m = height_px / (depth_m + 2.0 * _MARGIN_M)
        self._top_left_m = site.volume_centre_m[:2] + 0.5 * site.volume_m[:2] + _MARGIN_M
        shape = height_px, round((width_m + 2.0 * _MARGIN_M) * self._px_per_m), 3
        self.ground = np.full(shape, _SEA, np.uint8)
        cv2.fillPoly(self.ground, [marks.fixed_point(self.at(site.land_m))], _LAND, cv2.LINE_AA, 4)
        marks.draw_lines(self.ground, [self.at(site.wall_m)], marks.QUIET, 1)
        corners = np.array([(-1, -1), (1, -1), (1, 1), (-1, 1), (-1, -1)]) * 0.5 * site.volume_m[:2]
        marks.draw_lines(self.ground, [self.at(site.volume_centre_m[:2] + corners)], marks.QUIET, 1)
        words = f"watched from above: {depth_m:g} m × {width_m:g} m"
        marks.draw_text(self.ground, (8, 18), words, marks.QUIET, size=13)

    def at(self, places_m: ArrayLike) -> NDArray[np.float64]:
        """Return places (..., 2) of the world in the picture."""
        return (self._top_left_m - np.asarray(places_m, float)[..., :2])[..., ::-1] * self._px_per_m
