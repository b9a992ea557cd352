"""Detection of the target's presence: true positive and true negative rates after OxUvA."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from benchmarks.contract.judging import Score
from benchmarks.contract.metric import Mean, Metric, Quantity
from benchmarks.statistics.pooling import GeometricMean

_SEEN_AT_LEAST = 0.1


def present_and_absent(
    state: NDArray[np.str_], visible_fraction: NDArray[np.float64]
) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
    """Return (F,) present and (F,) absent, from the target's state (F,) and visible fraction (F,).

    Present: state ``in`` (whole, at least half of it visible). Absent: state ``out``, or less than a tenth of it
    visible. A frame between the two (target half across the border, or half behind a tree) counts in neither rate.
    """
    present = state == "in"
    return present, ((state == "out") | (visible_fraction < _SEEN_AT_LEAST)) & ~present


def oxuva_scores(
    present: NDArray[np.bool_],
    absent: NDArray[np.bool_],
    says_in_view: NDArray[np.bool_],
    on_target: NDArray[np.bool_],
    failed: NDArray[np.bool_],
) -> Iterator[Score]:
    """Yield ``in_view_tpr`` and ``in_view_tnr`` of frames (F,); each frame after a failure is wrong.

    Valmadre et al., Long-term Tracking in the Wild (OxUvA), ECCV 2018, eq. 1, with ``localisation.on_object`` for their
    IoU >= 0.5. TPR: share of the present frames on which the tracker says "in view" and is on the target. TNR: share of
    the absent frames on which it says "not in view", wherever its position is. NaN without such frames.
    """
    rights = {"in_view_tpr": (present, says_in_view & on_target), "in_view_tnr": (absent, ~says_in_view)}
    for name, (among, right) in rights.items():
        share = float((right & ~failed)[among].mean()) if among.any() else float("nan")
        yield Score(name, share, float(among.sum()))


def failed_frames(frame_count: int, failed_at_frame: int | None) -> NDArray[np.bool_]:
    """Return (F,): a tracker has failed on this frame or before."""
    return np.arange(frame_count) >= (frame_count if failed_at_frame is None else failed_at_frame)


_OXUVA = "OxUvA: Valmadre et al., Long-term tracking in the wild: a benchmark, ECCV 2018"
_DEFINED_BY = present_and_absent, oxuva_scores
_PRESENT = "frames with the whole target in the picture, at least half of it seen"
_ABSENT = "frames with the target outside, or less than a tenth of it seen"
TPR = Quantity("in_view_tpr", 0, 1, _PRESENT, _OXUVA, _DEFINED_BY)
TNR = Quantity("in_view_tnr", 0, 1, _ABSENT, _OXUVA, _DEFINED_BY)
_TPR_WORDS = 'frames in view on which the answer is "in view" and on the target'
_TNR_WORDS = 'frames with the target absent on which the answer is "not in view"'
_GM_WORDS = "geometric mean of in_view_tpr and in_view_tnr (OxUvA)"
IN_VIEW = (
    Metric("in_view_tpr", _TPR_WORDS, "fraction", "higher", Mean(TPR)),
    Metric("in_view_tnr", _TNR_WORDS, "fraction", "higher", Mean(TNR)),
    Metric("in_view_gm", _GM_WORDS, "fraction", "higher", GeometricMean(TPR, TNR)),
)
