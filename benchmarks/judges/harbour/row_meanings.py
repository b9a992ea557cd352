"""Ranges, conditions and sources of the rows of suite ``harbour``."""

from __future__ import annotations

from math import inf

from benchmarks.contract.metric import OWN, RowMeaning
from benchmarks.judges.harbour.alarms import CAUSES
from benchmarks.judges.harbour.matching import RADIUS_M
from benchmarks.judges.harbour.sizes import AT_100_M, DIMENSIONS
from benchmarks.judges.row_meanings import SPEED, identities

_GOSPA = "Rahmathullah, García-Fernández and Svensson, Generalized optimal sub-pattern assignment metric, FUSION 2017"
_SEEN = "intruders that can be seen, on the frames on which they are judged"
_TRACKED = "frames of intruders with a track on them"
_FRAMES = "frames on which intruders are judged; what is neither right nor wrong is left out"
_NEAR = f"{_TRACKED}, {AT_100_M[0]:g} to {AT_100_M[1]:g} m from the camera"
_CHANCE = "Frameout; chance taken off after Abbott, 1925"
_FROC = "FROC: Bunch et al., 1978; chance taken off after Abbott, 1925"
_SINGLE = "intruders that are judged, on every frame"
_COCO = "COCO: Lin et al., Microsoft COCO: common objects in context, ECCV 2014"
_ALARMS = ("false_alarms_per_hour", *(f"false_alarms_per_hour_{cause}" for cause in CAUSES))

ROW_MEANINGS = (
    RowMeaning(("found",), -inf, 1, _SEEN, _CHANCE),
    RowMeaning(("chance_rate",), 0, 1, _SEEN, _CHANCE),
    RowMeaning(("found_unseen",), -inf, 1, "intruders that cannot be seen", _CHANCE),
    RowMeaning(("froc_found",), -inf, inf, _SEEN, _FROC),
    RowMeaning(("froc_findable", "froc_alarms", "watched_hours"), 0, inf, _SEEN, _FROC),
    RowMeaning(("boxes_right", "boxes_told", "boxes_true"), 0, inf, _SINGLE, _COCO),
    RowMeaning(("found_as_in_paper",), 0, 1, "every intruder", "paper D"),
    RowMeaning(("time_to_detect_s",), 0, inf, "intruders that are found", OWN),
    RowMeaning(_ALARMS, 0, inf, "whole episodes", OWN),
    RowMeaning(("false_tracks_per_frame",), 0, inf, "every frame", OWN),
    RowMeaning(("position_error_m",), 0, RADIUS_M, _TRACKED, OWN),
    RowMeaning(("beyond_m",), -inf, inf, "tracks that paper D counts as found", OWN),
    RowMeaning(tuple(f"{name}_error" for name in DIMENSIONS), 0, inf, _TRACKED, "paper D"),
    RowMeaning(tuple(f"{name}_error_at_100_m" for name in DIMENSIONS), 0, inf, _NEAR, "paper D"),
    RowMeaning(tuple(f"{name}_error_of_mean" for name in DIMENSIONS), 0, inf, _NEAR, OWN),
    RowMeaning(("kind_right",), 0, 1, f"{_TRACKED} that names a class", OWN),
    RowMeaning(("duplicate_rate",), 0, 1, _TRACKED, OWN),
    *identities(_FRAMES),
    RowMeaning(("gospa_m",), 0, inf, _FRAMES, _GOSPA),
    SPEED,
)
