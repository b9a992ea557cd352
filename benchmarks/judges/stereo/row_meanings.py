"""Ranges, conditions and sources of the rows of suite ``stereo``."""

from __future__ import annotations

from math import inf

from benchmarks.contract.metric import OWN, RowMeaning
from benchmarks.judges.row_meanings import KAPLAN_MEIER, SPEED
from benchmarks.judges.stereo.events import EVENT_COUNTS
from benchmarks.judges.stereo.metrics.people import RIGHT_WITHIN_M, WORST_ERROR_M

_COUNTED = "frames but the first on which the person is seen at all"
_OCCLUSIONS = "occlusions with at least 10 frames of the episode after half of the person is seen again"
_SEEN = "frames but the first with at least a tenth of the person seen"
_BACK = "occlusions after which half of the person is seen again"
_PIXELS = "every tenth pair whose right picture is not lost: pixels that both cameras see"
_MIDDLEBURY = "Middlebury: Scharstein and Szeliski, A taxonomy and evaluation of dense two-frame stereo, IJCV 47, 2002"

ROW_MEANINGS = (
    RowMeaning(("right_frames", "wrong_frames", "missed_frames"), 0, inf, _COUNTED, "paper B; detection_f1: Frameout"),
    RowMeaning(EVENT_COUNTS, 0, inf, f"{_COUNTED}, of the event", OWN),
    RowMeaning(("wrong_person_rate",), 0, 1, "every frame but the first", OWN),
    RowMeaning(("event_wrong_person_rate",), 0, 1, "frames of the event", OWN),
    RowMeaning(("position_error_m",), 0, WORST_ERROR_M, _SEEN, OWN),
    RowMeaning(("position_error_found_m",), 0, RIGHT_WITHIN_M, "frames with a right answer", OWN),
    RowMeaning(("recovered", "locked_on_wrong_person"), 0, 1, _OCCLUSIONS, OWN),
    RowMeaning(("recovery_frames", "watched_frames"), 0, inf, _BACK, KAPLAN_MEIER),
    RowMeaning(("rate_hz",), 0, inf, "", OWN),
    RowMeaning(("disparity_error_px",), 0, inf, _PIXELS, _MIDDLEBURY),
    RowMeaning(("disparity_bad_1", "disparity_bad_3", "disparity_density"), 0, 1, _PIXELS, _MIDDLEBURY),
    SPEED,
)
