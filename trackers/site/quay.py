"""A level quay with a straight edge above the water, as it is surveyed, before a camera."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from trackers.site.view import SiteView
from trackers.types import SiteSurvey


def shows_water(survey: SiteSurvey, view: SiteView) -> NDArray[np.bool_]:
    """Return where a picture (H, W) shows water when it is at its mean level, and what is afloat there."""
    rows, columns = np.mgrid[0 : view.camera.height_px, 0 : view.camera.width_px] + 0.5
    on_water = view.on_plane(np.column_stack([columns.ravel(), rows.ravel()]), survey.mean_water_m)
    return np.nan_to_num(_off_m(survey, on_water), nan=-1.0).reshape(rows.shape) > 0.0


def stood_on(survey: SiteSurvey, view: SiteView, px: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the points (N, 3) of the quay, its wall or the mean water that are seen at pixels (N, 2).

    NaN where neither plane is seen. Of a quay that hides its own wall from the camera nothing else is known.
    """
    on_quay, on_water = view.on_plane(px, 0.0), view.on_plane(px, survey.mean_water_m)
    off_m, far_off_m = (_off_m(survey, each) for each in (on_quay, on_water))
    # Between the edge and the water the line of sight meets the wall.
    share = np.divide(off_m, off_m - far_off_m, out=np.ones_like(off_m), where=(off_m > 0) & (far_off_m < 0))
    share[off_m <= 0.0] = 0.0
    points: NDArray[np.float64] = on_quay + share[:, None] * (on_water - on_quay)
    return points


def _off_m(survey: SiteSurvey, points_m: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return how far (N,) points (N, 3) lie off the quay's edge, towards the water."""
    off_m: NDArray[np.float64] = (points_m[:, :2] - np.array(survey.edge_m)) @ np.array(survey.seaward)
    return off_m
