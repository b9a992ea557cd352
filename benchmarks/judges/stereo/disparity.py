"""Errors of the disparity that trackers match from the pair: rows of an episode."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator
from math import inf
from typing import Any

from benchmarks.contract.judging import Score, truth_as
from benchmarks.contract.metric import Better, Mean, Metric, Quantity
from benchmarks.judges.stereo.metrics import disparity
from benchmarks.judges.stereo.metrics.disparity import DisparityErrors, disparity_error_px, seen_by_both
from scenarios.scenario import Frame
from scenarios.stereo_follow.truth import StereoTruth
from trackers.light_adaptive_stereo.matching import StereoMatcher

EVERY_FRAMES = 10
"""Matching costs as much as a tracker, so one picture of ten is measured."""
ALL_PIXELS, TARGET_PIXELS = "all", "target"


class DisparityMeasurement:
    """Matches every tenth pair of an episode as stereo trackers do, unless the right picture is lost."""

    def __init__(self, target: str) -> None:
        """``target``: name of the object whose pixels are also measured separately."""
        self._target = target
        self._matcher = StereoMatcher()
        self._errors: dict[str, DisparityErrors] = defaultdict(DisparityErrors)

    def see(self, frame: Frame) -> None:
        """Take one frame."""
        seen, truth = frame.observation, truth_as(frame.truth, StereoTruth)
        if truth.frame % EVERY_FRAMES or seen.right_rgb is None:
            return
        error_px = disparity_error_px(frame, self._matcher.depth_m(seen.image_rgb, seen.right_rgb, seen.camera))
        counts = seen_by_both(frame)
        on_target = truth.instance_map == truth.instance_id[truth.index_of(self._target)]
        self._errors[ALL_PIXELS].add(error_px[counts])
        self._errors[TARGET_PIXELS].add(error_px[counts & on_target])
        self._errors[truth.place].add(error_px[counts])

    def scores(self) -> Iterator[Score]:
        """Yield the rows of the episode."""
        for pixels, errors in self._errors.items():
            yield Score(f"disparity_error_px_{pixels}", errors.median_px, float(errors.known))
            yield Score(f"disparity_bad_1_{pixels}", errors.bad_1, float(errors.known))
            yield Score(f"disparity_bad_3_{pixels}", errors.bad_3, float(errors.known))
            yield Score(f"disparity_density_{pixels}", errors.density, float(errors.pixels))


_PIXELS = "every tenth pair whose right picture is not lost: pixels that both cameras see"
_MIDDLEBURY = "Middlebury: Scharstein and Szeliski, A taxonomy and evaluation of dense two-frame stereo, IJCV 47, 2002"


def _metric(name: str, summary: str, unit: str, better: Better, defined_by: Any) -> Metric:
    high = 1.0 if unit == "fraction" else inf
    quantity = Quantity(f"disparity_{name}", 0, high, _PIXELS, _MIDDLEBURY, (disparity, defined_by))
    return Metric(name, summary, unit, better, Mean(quantity))


DISPARITY = (
    _metric("error_px", "median absolute error", "px", "lower", DisparityErrors.median_px),
    _metric("bad_1", "disparities off by more than 1 pixel", "fraction", "lower", DisparityErrors.bad_1),
    _metric("bad_3", "disparities off by more than 3 pixels", "fraction", "lower", DisparityErrors.bad_3),
    _metric("density", "pixels that have a disparity", "fraction", "higher", DisparityErrors.density),
)
"""Metrics of the rows of one line, without its suffix."""
