"""Following a person by colour and position, weighted by the camera's automatic settings (paper B as written).

The paper compares two methods, which differ only in the weight W between colour and position: the older one detects a
change of the light by the white balance, the paper's also by shutter and gain, and by the trend of the exposure when
the template was taken.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from trackers.kernels.boxes import box_centre
from trackers.kernels.histogram import histogram_of, hs_bins
from trackers.light_adaptive_stereo.candidates import Candidate, CandidateParameters, candidate_in_box
from trackers.light_adaptive_stereo.light_change import (
    LightTrend,
    brightness_change,
    camera_registers,
    colour_change,
    dissimilarity,
    white_balance_change,
)
from trackers.light_adaptive_stereo.matching import StereoMatcher, baseline_m
from trackers.light_adaptive_stereo.occlusion import (
    Occlusion,
    OcclusionParameters,
    OcclusionState,
    OtherPeople,
    share_before,
)
from trackers.light_adaptive_stereo.person_kalman import PersonKalman
from trackers.light_adaptive_stereo.stereo_view import StereoView, first_mounting, see, usual_depth_m
from trackers.registry import register, tunable
from trackers.types import CameraModel, CameraRegisters, Estimate, Observation

_PLACE_WEIGHT_PER_M = 1.0
"""k of equation 6."""
_MIDDLE_SHARE = 0.6
"""Share of the first box that is taken for the person if there is no candidate in it."""
_NEAREST_M = 0.1


def position_dissimilarity(places_m: NDArray[np.float64], expected_m: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return ``R_position = k sqrt((X_s - X_e)² + (Y_s - Y_e)²)``, k = 1 m⁻¹, of positions (N, 2) (equation 6)."""
    return _PLACE_WEIGHT_PER_M * np.linalg.norm(places_m - expected_m, axis=1)


def brightness_weight(colour: float, brightness: float, learnt: float) -> float:
    """Return ``W = P_c + P_l`` where ``D_l >= 0``, else ``P_c + P_l - D_l`` (equation 7)."""
    return colour + brightness - min(learnt, 0.0)


def combined_dissimilarity(
    weight: float, by_colour: NDArray[np.float64], by_place: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Return ``D = (1 - W) R_color + W R_position`` if ``W <= 1``, else ``R_position`` (equation 8), N of each."""
    return (1.0 - weight) * by_colour + weight * by_place if weight <= 1.0 else by_place


@dataclass(frozen=True)
class StereoColourParameters:
    """Settings of both methods that the paper does not give.

    The unit of equation 9, ``P_c = 0.4 (|R - R'| + |B - B'|)``:

    * Read from the paper: the factor; gains from 0 to 1,023 (Table 1); ``0 <= P_c <= 1`` (section 3.2.2). It gives no
      unit: in equation 10 S and G are shares of their range, in equation 9 R and B are not.
    * Ours: how a camera's gains become registers. As register values P_c would be at 1 after a change by 3; as shares
      of the range it would not pass 0.13 in the whole of experiment I, and the older method would be colour alone.
    * Fitted: 128, an eighth of the range, so that P_c has its whole range in experiment I, from 0 at the greatest
      illuminance to nearly 1 at the least (0.97 to 0.99 on development seeds). B1 shows P_c there, B3 what other units
      would change.

    Attributes:
        threshold: largest dissimilarity D of the target.
        acceleration_mps2: standard deviation of a person's acceleration in the robot's frame.
        place_noise_m: standard deviation of a candidate's position.
        predicted_s: how long a target that is not found and not occluded is predicted; then it is lost.
        predicted_hidden_s: the same while the state of occlusion is not ``NONE``. A lost target's position stays.
        white_balance_unit: change of R and B together, in register values, that equation 9 has as 1.
    """

    threshold: float = tunable(0.62, 0.2, 0.9)
    acceleration_mps2: float = tunable(2.0, 0.3, 10.0, log=True)
    place_noise_m: float = tunable(0.1, 0.02, 0.5, log=True)
    predicted_s: float = tunable(1.0, 0.2, 5.0, log=True)
    predicted_hidden_s: float = tunable(3.0, 0.5, 10.0, log=True)
    white_balance_unit: float = tunable(128.0, 1.0, 1023.0, log=True)


class StereoColour(ABC):
    """What both methods share, sections 3.1 to 3.3. As in the paper, positions are in the robot's frame, so they move
    when the robot turns.

    The paper's numbers: those of equations 4 to 10 (``light_change``, k = 1 m⁻¹). Fitted on development seeds, alike
    for both methods: ``StereoColourParameters``, of which the threshold so that the methods scored about as in the
    paper in the scene's first edition, and the unit of the white balance by experiment I. All else are readings:

    * Colours are compared in 16 bins of hue times 8 of saturation over all pixels of a candidate; a new template
      replaces the old one.
    * "It sets when the template may be updated": whenever D is under the threshold and the state of occlusion is
      ``NONE``, since with an occluder at or near the line of sight a candidate may hold pixels of both.
    * "And how long prediction alone goes on": so a target that is not found is answered by its prediction, for
      ``predicted_s`` or, in an occlusion, ``predicted_hidden_s``. The paper's counts do not say whether such a frame
      is one with a detection; here it counts as an answer, right or wrong. A prediction outside the picture is none.
    * After that there is no expected position and so no R_position, and D = R_color until the target is found again.
      (With W R_position in D, and the position where prediction ended, a target that has walked on is not found while
      the light stays changed.)
    * Without a template only the position counts.
    """

    Parameters = StereoColourParameters

    def __init__(self, parameters: StereoColourParameters, rng: np.random.Generator) -> None:
        self._parameters = parameters
        self._candidates = CandidateParameters()
        self._occlusions = OcclusionParameters()
        self._matcher = StereoMatcher()

    @abstractmethod
    def weight(self, colour: float, brightness: float, learnt: float) -> float:
        """Return the weight W >= 0 of position against colour.

        Args:
            colour, brightness: P_c and P_l since the template was taken.
            learnt: D_l when the template was taken.
        """

    def initialise(self, observation: Observation, box_xyxy: NDArray[np.float64]) -> None:
        """Start on the candidate in the box, or without one on the middle of the box."""
        p = self._parameters
        baseline_m(observation.camera)
        registers = self._registers = camera_registers(observation)
        self._mounting = first_mounting(observation, box_xyxy, self._matcher, self._candidates.usual_height_m)
        self._trend = LightTrend()
        self._state = OcclusionState(self._occlusions)
        self._others = OtherPeople(self._occlusions, p.acceleration_mps2, p.place_noise_m)
        self._time_s, self._unfound_s = observation.time_s, 0.0
        self._found_last, self._lost = True, False
        self._height_m = self._candidates.usual_height_m
        view, self.elsewhere_cpu_s = see(observation, self._matcher, self._mounting, self._candidates)
        bins = hs_bins(self._matcher.smaller(observation.image_rgb))
        first = candidate_in_box(view.candidates if view else [], box_xyxy)
        if first is not None:
            place_m, template = first.place_m, histogram_of(bins.ravel()[first.pixels])
        else:
            depth_m = usual_depth_m(observation.camera, box_xyxy, self._height_m)
            place_m = self._mounting.place_at(box_centre(box_xyxy), depth_m, observation.camera)[:2]
            template = histogram_of(_middle(bins, box_xyxy * bins.shape[1] / observation.camera.width_px))
        self._filter = PersonKalman(place_m, p.acceleration_mps2, p.place_noise_m)
        self._learn(template, registers, self._trend.update(registers))

    def update(self, observation: Observation) -> Estimate:
        """Return the target among the candidates of the next stereo pair, or its prediction, or NaN."""
        registers = self._registers = camera_registers(observation, self._registers)
        trend = self._trend.update(registers)
        self._predict(observation.time_s)
        view, self.elsewhere_cpu_s = see(observation, self._matcher, self._mounting, self._candidates)
        found = self._find(observation, view, registers, trend) if view else None
        self._found_last = found is not None
        if found is None:
            return self._predicted(observation.camera)
        return Estimate(found.centre_px, found.box_xyxy.copy(), in_view_probability=1.0, depth_m=found.depth_m)

    def _predicted(self, camera: CameraModel) -> Estimate:
        """Return the predicted position of a target that was not found; NaN once it is lost, or outside the picture."""
        box, depth_m = self._mounting.standing_box(
            self._filter.place_m, self._candidates.usual_width_m, self._height_m, camera
        )
        centre_px = box_centre(box)
        if self._lost or depth_m <= _NEAREST_M or not 0.0 <= centre_px[0] < camera.width_px:
            return Estimate(np.full(2, np.nan), in_view_probability=0.0)
        return Estimate(centre_px, box, in_view_probability=1.0, depth_m=depth_m)

    def _predict(self, time_s: float) -> None:
        """Predict (section 3.2.1), for a time that depends on the state of occlusion (section 3.3)."""
        p = self._parameters
        seconds, self._time_s = max(time_s - self._time_s, 0.0), time_s
        self._unfound_s += seconds
        limit_s = p.predicted_s if self._state.now is Occlusion.NONE else p.predicted_hidden_s
        # An occluder at the last position of a lost target does not make it valid again.
        self._lost = self._lost or self._unfound_s > limit_s
        if self._lost:
            self._filter.stand_still()
            self._state.reset()
        self._filter.predict(seconds)
        self._others.predict(seconds)

    def _find(
        self, observation: Observation, view: StereoView, registers: CameraRegisters, trend: float
    ) -> Candidate | None:
        """Return the target's candidate and learn from it (sections 3.2.2 and 3.3)."""
        expected_m = self._filter.place_m.copy()
        self._update_state(observation, view, expected_m)
        bins = hs_bins(self._matcher.smaller(observation.image_rgb)).ravel()
        histograms = [histogram_of(bins[candidate.pixels]) for candidate in view.candidates]
        costs = self._dissimilarities(view.candidates, histograms, expected_m, registers)
        target, others = self._others.associate(view.candidates, costs, self._parameters.threshold, _PLACE_WEIGHT_PER_M)
        if self._state.now is Occlusion.NONE:
            self._others.clear()
        else:
            self._others.correct(view.candidates, target, others, expected_m)
        if target is None:
            return None
        found = view.candidates[target]
        self._correct(found)
        if self._state.template_may_change:
            self._learn(histograms[target], registers, trend)
        return found

    def _update_state(self, observation: Observation, view: StereoView, expected_m: NDArray[np.float64]) -> None:
        o = self._occlusions
        hidden, beside = (
            share_before(view.depth_m, expected_m, self._height_m, width_m, self._mounting, observation.camera, o)
            for width_m in (o.body_width_m, o.body_width_m + 2.0 * o.margin_m)
        )
        self._state.update(hidden, beside, self._found_last)

    def _dissimilarities(
        self,
        candidates: list[Candidate],
        histograms: list[NDArray[np.float64]],
        expected_m: NDArray[np.float64],
        registers: CameraRegisters,
    ) -> NDArray[np.float64]:
        """Return D (N,) of the candidates."""
        places_m = np.array([candidate.place_m for candidate in candidates]).reshape(-1, 2)
        by_place = position_dissimilarity(places_m, expected_m)
        if not self._template.any():
            return by_place
        by_colour = np.array([dissimilarity(histogram, self._template) for histogram in histograms])
        change = white_balance_change(registers, self._learnt_at)
        colour = colour_change(change, self._parameters.white_balance_unit)
        brightness = brightness_change(registers, self._learnt_at)
        weight = 0.0 if self._lost else self.weight(colour, brightness, self._learnt)
        return combined_dissimilarity(weight, by_colour, by_place)

    def _correct(self, found: Candidate) -> None:
        p = self._parameters
        if self._lost:
            # The prediction from before the loss is no longer valid.
            self._filter = PersonKalman(found.place_m, p.acceleration_mps2, p.place_noise_m)
        else:
            self._filter.correct(found.place_m)
        self._unfound_s, self._lost = 0.0, False
        if not found.top_cut:
            self._height_m = found.height_m

    def _learn(self, template: NDArray[np.float64], registers: CameraRegisters, trend: float) -> None:
        """Take a colour template, with D_l of now; P_c and P_l are relative to the settings of now."""
        self._template, self._learnt_at, self._learnt = template, registers, trend


@register(
    "stereo_wb",
    role="as-written",
    summary="stereo; colour and position weighted by the white balance (the older method of paper B)",
    suites=("stereo",),
    edition=2,
)
class StereoWb(StereoColour):
    """The older method: ``W = P_c``. Source: paper B, see ``trackers.papers``."""

    def weight(self, colour: float, brightness: float, learnt: float) -> float:
        """Return P_c."""
        return colour


@register(
    "stereo_wb_shutter_gain",
    role="as-written",
    summary="stereo; colour and position weighted by white balance, shutter and gain (paper B)",
    suites=("stereo",),
    edition=2,
)
class StereoWbShutterGain(StereoColour):
    """The paper's method: W by equation 7. Source: paper B, see ``trackers.papers``."""

    def weight(self, colour: float, brightness: float, learnt: float) -> float:
        """Return ``brightness_weight``."""
        return brightness_weight(colour, brightness, learnt)


def _middle(bins: NDArray[np.uint8], box_xyxy: NDArray[np.float64]) -> NDArray[np.uint8]:
    """Return the bins in the middle of a box."""
    half = 0.5 * _MIDDLE_SHARE * (box_xyxy[2:] - box_xyxy[:2])
    low, high = (
        np.clip(np.round(box_centre(box_xyxy) + side * half), 0, bins.shape[::-1]).astype(int) for side in (-1, 1)
    )
    return bins[low[1] : high[1], low[0] : high[0]]
