"""Ranges, conditions and sources of the rows of suite ``frame-out``."""

from __future__ import annotations

from math import inf

from benchmarks.contract.metric import OWN, RowMeaning
from benchmarks.judges.frame_out.episode_scores import NEES_CAP
from benchmarks.judges.frame_out.metrics.offscreen import WORST_ERROR_M
from benchmarks.judges.row_meanings import IN_VIEW, KAPLAN_MEIER, SPEED, time_in_view

_JUDGED = (
    "frame-outs with at least 5 frames and a second of the episode after the whole car is back; in closed loop after "
    "it left"
)
_OUT = "frames with the car wholly outside the picture"
_POSTERIOR = f"{_OUT}, of trackers that give a posterior in the episode"
_OTB = "OTB: Wu, Lim and Yang, Online object tracking: a benchmark, CVPR 2013"
_VOT_LT = "VOT-LT: Lukezic et al., Now you see me: evaluating performance in long-term visual tracking, 2018"
_NEES = "Bar-Shalom, Li and Kirubarajan, Estimation with applications to tracking and navigation, 2001; cap: Frameout"
_ON_CAR = "on the car: IoU of the boxes at least 0.5, or centre within half a car's length on the ground"
_SEEN = "frames with the whole car in the picture, at least half of it seen"

ROW_MEANINGS = (
    RowMeaning(("recovered", "kept", "locked_on_wrong_car"), 0, 1, f"{_JUDGED}; {_ON_CAR}", OWN),
    RowMeaning(("run_kept",), 0, 1, "episodes with such a frame-out", OWN),
    RowMeaning(("recovery_frames", "watched_frames"), 0, inf, "frame-outs after which the car is back", KAPLAN_MEIER),
    RowMeaning(("had",), 0, 1, f"the last frame before each exit and the first one outside; {_ON_CAR}", OWN),
    *(
        RowMeaning((f"offscreen_error{row}{ending}",), 0, WORST_ERROR_M, frames + condition, OWN)
        for ending, condition in (("_m", ""), ("_if_had_m", ", where the tracker had the car at the exit"))
        for row, frames in (
            ("", _OUT),
            ("_30", "frame-outs of more than 30 frames"),
            ("_100", "frame-outs of more than 100 frames"),
        )
    ),
    RowMeaning(("offscreen_error_car_lengths",), 0, inf, _OUT, OWN),
    RowMeaning(("reentry_error_m",), 0, WORST_ERROR_M, "the last frame of each frame-out", OWN),
    RowMeaning(("coverage_50", "coverage_90", "coverage_95"), 0, 1, _POSTERIOR, OWN),
    RowMeaning(("nees",), 0, NEES_CAP, _POSTERIOR, _NEES),
    *IN_VIEW,
    RowMeaning(("precision_curve",), 0, 1, "frames with an answer inside the picture", _VOT_LT),
    RowMeaning(("recall_curve",), 0, 1, "frames with the car at least partly seen", _VOT_LT),
    RowMeaning(("centre_error_px",), 0, inf, _SEEN, f"{_OTB}, there without a cap"),
    RowMeaning(("precision_20_px", "success_auc"), 0, 1, _SEEN, _OTB),
    *time_in_view("presets in closed loop"),
    SPEED,
)
