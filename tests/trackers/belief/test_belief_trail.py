"""The belief's trail of its target, and its velocity over a gap in the estimates."""

from __future__ import annotations

import numpy as np

from trackers.belief.kernel import BELIEF, SIGHTING, TRAIL, TRAIL_STEP_M, update_beliefs


def _seen(x_m, y_m, known=1.0):
    sighting = np.zeros(1, SIGHTING)
    for name, value in (("known", known), ("in_view_probability", known), ("x_m", x_m), ("y_m", y_m)):
        sighting[name] = value
    return sighting


def test_the_trail_holds_the_latest_places_a_step_apart():
    belief = np.zeros(1, BELIEF)
    for step in range(400):
        update_beliefs(belief, _seen(0.05 * step, 1.0), 0.1)
    trail_m = np.column_stack([belief["trail_x_m"][0], belief["trail_y_m"][0]])
    assert belief["trail_places"][0] == TRAIL
    assert abs(trail_m[0, 0] - 0.05 * 399) < TRAIL_STEP_M
    steps_m = np.linalg.norm(np.diff(trail_m, axis=0), axis=1)
    assert ((steps_m > TRAIL_STEP_M - 1e-9) & (steps_m < TRAIL_STEP_M + 0.06)).all()
    assert (np.diff(trail_m[:, 0]) < 0).all()


def test_a_target_found_again_elsewhere_keeps_its_velocity():
    belief = np.zeros(1, BELIEF)
    for step in range(60):
        update_beliefs(belief, _seen(0.1 * step, 0.0), 0.1)
    before_mps = float(belief["velocity_x_mps"][0])
    for _ in range(20):
        update_beliefs(belief, _seen(0.0, 0.0, known=0.0), 0.1)
    update_beliefs(belief, _seen(8.0, 2.0), 0.1)
    assert abs(before_mps - 1.0) < 0.05
    assert belief["velocity_x_mps"][0] == before_mps
    assert belief["velocity_y_mps"][0] == 0.0
