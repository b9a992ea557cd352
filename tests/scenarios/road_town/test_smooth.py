"""Motion that starts and ends at rest."""

from __future__ import annotations

import numpy as np

from scenarios.road_town.swing_geometry import smooth_step


def test_a_smooth_step_goes_from_rest_to_rest() -> None:
    t, dt = np.linspace(-0.5, 1.5, 20_001, retstep=True)
    place = smooth_step(t)
    speed = np.gradient(place, dt)
    acceleration = np.gradient(speed, dt)
    assert (place[t <= 0] == 0).all()
    assert (place[t >= 1] == 1).all()
    assert (speed >= 0).all()
    # Speed 1.875 in the middle is the polynomial's; neither it nor the acceleration jumps.
    assert abs(speed.max() - 1.875) < 1e-6
    assert np.abs(np.diff(acceleration)).max() < 0.01
