"""A bridge that breaks its contract is refused, and the message names what was expected."""

from __future__ import annotations

import numpy as np
import pytest

from trackers.gaps import Bridge, check_bridge

GOOD = Bridge(np.zeros((3, 2)), np.tile(np.eye(2), (3, 1, 1)))


def test_a_bridge_with_and_without_covariance_passes() -> None:
    check_bridge(GOOD, 3)
    check_bridge(Bridge(np.zeros((0, 2))), 0)
    check_bridge(Bridge(np.ones((2, 2)), np.zeros((2, 2, 2))), 2)


@pytest.mark.parametrize(
    ("bridge", "message"),
    [
        (np.zeros((3, 2)), "bridge: expected a Bridge or None, got ndarray"),
        (Bridge(np.zeros((2, 2))), r"position_px: expected floating-point numbers of shape \(3, 2\)"),
        (Bridge(np.full((3, 2), "a")), "position_px: expected floating-point numbers"),
        (Bridge(np.full((3, 2), np.nan)), "position_px: expected finite numbers, got 6 that are not"),
        (Bridge(np.zeros((3, 2)), np.eye(2)), "covariance_px: expected floating-point numbers of shape"),
        (Bridge(np.zeros((3, 2)), np.tile(-np.eye(2), (3, 1, 1))), "covariance_px: expected symmetric matrices"),
        (Bridge(np.zeros((3, 2)), np.full((3, 2, 2), [[1.0, 0.5], [0.0, 1.0]])), "covariance_px: expected symmetric"),
    ],
)
def test_a_broken_one_is_named(bridge: Bridge, message: str) -> None:
    with pytest.raises(ValueError, match=message):
        check_bridge(bridge, 3)
