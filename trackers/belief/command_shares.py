"""Commands as shares of a carrier's limits, and whether a tracker sees its target."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from trackers.belief.kernel import SEEN_PROBABILITY
from trackers.types import CameraCommand, Carrier, Estimate


def command_of(carrier: Carrier, shares: NDArray[np.float64]) -> CameraCommand:
    """Return the command of shares (A,) of the limits, in the order of the carrier's axes, clipped to [-1, 1]."""
    values = np.clip(shares, -1.0, 1.0)
    return CameraCommand(**{axis.name: axis.limit * float(v) for axis, v in zip(carrier.axes, values, strict=True)})


def shares_of(carrier: Carrier, command: CameraCommand) -> NDArray[np.float64]:
    """Return a command as shares (A,) of the carrier's limits, clipped to [-1, 1]."""
    return np.clip([getattr(command, axis.name) / axis.limit for axis in carrier.axes], -1.0, 1.0)


def is_seen(estimate: Estimate) -> bool:
    """Return whether the tracker sees its target; without an in-view probability any finite estimate counts."""
    if not np.isfinite(estimate.position_px).all():
        return False
    return estimate.in_view_probability is None or estimate.in_view_probability >= SEEN_PROBABILITY
