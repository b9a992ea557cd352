"""What trackers of a harbour are told of it beside the calibration of the camera: the survey of its quay."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from trackers.site.view import SiteView


@dataclass(frozen=True)
class Quay:
    """A level quay with a straight edge above the water; the defaults are the survey of the benchmark's harbour.

    Attributes:
        edge_m: (2,) a point of the edge, in the world. seaward: (2,) horizontal unit vector from the edge to the water.
        mean_water_m: mean sea level above the quay, < 0. How high the tide is at a time is not surveyed.
    """

    edge_m: tuple[float, float] = (-15.0, 0.0)
    seaward: tuple[float, float] = (-1.0, 0.0)
    mean_water_m: float = -1.8

    def __post_init__(self) -> None:
        """Raise ValueError for water that is not below the quay, and for a direction that is not one long."""
        if not -np.inf < self.mean_water_m < 0.0:
            raise ValueError(f"mean_water_m: expected a finite number of metres < 0, got {self.mean_water_m}")
        if not abs(float(np.hypot(*self.seaward)) - 1.0) < 1e-6:
            raise ValueError(f"seaward: expected a vector of length 1, got {self.seaward}")
        if not np.isfinite(self.edge_m).all():
            raise ValueError(f"edge_m: expected finite numbers of metres, got {self.edge_m}")

    def shows_water(self, view: SiteView) -> NDArray[np.bool_]:
        """Return where a picture (H, W) shows water when it is at its mean level, and what is afloat there."""
        rows, columns = np.mgrid[0 : view.camera.height_px, 0 : view.camera.width_px] + 0.5
        on_water = view.on_plane(np.column_stack([columns.ravel(), rows.ravel()]), self.mean_water_m)
        off_m = (on_water[:, :2] - np.array(self.edge_m)) @ np.array(self.seaward)
        return np.nan_to_num(off_m, nan=-1.0).reshape(rows.shape) > 0.0

    def stood_on(self, view: SiteView, px: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the points (N, 3) of the quay, its wall or the mean water that are seen at pixels (N, 2).

        NaN where neither plane is seen. Of a quay that hides its own wall from the camera nothing else is known.
        """
        on_quay, on_water = view.on_plane(px, 0.0), view.on_plane(px, self.mean_water_m)
        off_m, far_off_m = (
            (each[:, :2] - np.array(self.edge_m)) @ np.array(self.seaward) for each in (on_quay, on_water)
        )
        # Between the edge and the water the line of sight meets the wall.
        share = np.divide(off_m, off_m - far_off_m, out=np.ones_like(off_m), where=(off_m > 0) & (far_off_m < 0))
        share[off_m <= 0.0] = 0.0
        points: NDArray[np.float64] = on_quay + share[:, None] * (on_water - on_quay)
        return points
