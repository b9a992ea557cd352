"""Does a tracker know whether its target is in view? True positive and true negative rates after OxUvA."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

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
    """Return TPR in [0, 1]: share of the present frames on which the tracker says "in view" and is on the
    car.

    Valmadre et al., Long-term Tracking in the Wild (OxUvA), ECCV 2018, eq. 1, with ``localisation.on_object``
    for their IoU >= 0.5. NaN without present frames.
    """
    return _share(says_in_view & on_target, present)


def true_negative_rate(absent: NDArray[np.bool_], says_in_view: NDArray[np.bool_]) -> float:
    """Return TNR in [0, 1]: share of the absent frames on which the tracker says "not in view" (OxUvA, eq.
    1).

    The position of the estimate does not matter. NaN without absent frames.
    """
    return _share(~says_in_view, absent)


def geometric_mean(tpr: NDArray[np.float64], tnr: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return ``sqrt(TPR * TNR)`` in [0, 1] (OxUvA, eq. 2 without its random abstention)."""
    return np.sqrt(tpr * tnr)


def _share(hits: NDArray[np.bool_], among: NDArray[np.bool_]) -> float:
    return float(hits[among].mean()) if among.any() else float("nan")
