"""Truth of people made by hand, a few frames long."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from benchmarks.judges.stereo.metrics.people import PeopleSeries

OTHER_M = (2.0, 0.0)
"""Where another person stands, from the target."""
NOWHERE = (np.nan, np.nan)


def people_of(
    visible: Sequence[float],
    *,
    others_m: NDArray[np.float64] | None = None,
    out: Sequence[int] = (),
    lights: Mapping[int, str] | None = None,
    near: Sequence[int] = (),
    rate_hz: float = 5.0,
) -> PeopleSeries:
    """Return a truth whose target stands at the origin; the others at ``others_m`` (M, 2), one at ``OTHER_M``."""
    frames = np.arange(len(visible))
    people_m = np.vstack([np.zeros((1, 2)), [OTHER_M] if others_m is None else others_m])
    return PeopleSeries(
        rate_hz=rate_hz,
        target=0,
        ground_m=np.tile(people_m, (len(visible), 1, 1)),
        visible_fraction=np.array(visible, dtype=float),
        out=np.isin(frames, out),
        place=np.array(["hall"] * len(visible)),
        light_event=np.array([(lights or {}).get(k, "") for k in frames]),
        near_person=np.isin(frames, near),
    )
