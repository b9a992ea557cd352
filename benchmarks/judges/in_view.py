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


def true_positive_rate(
    present: NDArray[np.bool_], says_in_view: NDArray[np.bool_], on_target: NDArray[np.bool_]
) -> float:
    """Return TPR in [0, 1]: share of the present frames on which the tracker says "in view" and is on the target.

    Valmadre et al., Long-term Tracking in the Wild (OxUvA), ECCV 2018, eq. 1, with ``localisation.on_object``
    for their IoU >= 0.5. NaN without present frames.
    """
    return _share(says_in_view & on_target, present)


def true_negative_rate(absent: NDArray[np.bool_], says_in_view: NDArray[np.bool_]) -> float:
    """Return TNR in [0, 1]: share of the absent frames on which the tracker says "not in view" (OxUvA, eq. 1).

    The position of the estimate does not matter. NaN without absent frames.
    """
    return _share(~says_in_view, absent)


def oxuva_scores(
    present: NDArray[np.bool_],
    absent: NDArray[np.bool_],
    says_in_view: NDArray[np.bool_],
    on_target: NDArray[np.bool_],
    failed: NDArray[np.bool_],
) -> Iterator[Score]:
    """Yield ``in_view_tpr`` and ``in_view_tnr`` of frames (F,); each frame after a failure is wrong."""
    tpr = true_positive_rate(present, says_in_view & ~failed, on_target)
    yield Score("in_view_tpr", tpr, float(present.sum()))
    yield Score("in_view_tnr", true_negative_rate(absent, says_in_view | failed), float(absent.sum()))


def failed_frames(frame_count: int, failed_at_frame: int | None) -> NDArray[np.bool_]:
    """Return (F,): a tracker has failed on this frame or before."""
    return np.arange(frame_count) >= (frame_count if failed_at_frame is None else failed_at_frame)


def _share(hits: NDArray[np.bool_], among: NDArray[np.bool_]) -> float:
    return float(hits[among].mean()) if among.any() else float("nan")


_OXUVA = "OxUvA: Valmadre et al., Long-term tracking in the wild: a benchmark, ECCV 2018"
TPR = Quantity(
    "in_view_tpr",
    0,
    1,
    "frames with the whole target in the picture, at least half of it seen",
    _OXUVA,
    (present_and_absent, true_positive_rate),
)
TNR = Quantity(
    "in_view_tnr",
    0,
    1,
    "frames with the target outside, or less than a tenth of it seen",
    _OXUVA,
    (present_and_absent, true_negative_rate),
)
IN_VIEW = (
    Metric(
        "in_view_tpr",
        'frames in view on which the answer is "in view" and on the target',
        "fraction",
        "higher",
        Mean(TPR),
    ),
    Metric(
        "in_view_tnr",
        'frames with the target absent on which the answer is "not in view"',
        "fraction",
        "higher",
        Mean(TNR),
    ),
    Metric(
        "in_view_gm",
        "geometric mean of in_view_tpr and in_view_tnr (OxUvA)",
        "fraction",
        "higher",
        GeometricMean(TPR, TNR),
    ),
)
