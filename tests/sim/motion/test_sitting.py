"""People who sit: bones keep their lengths, soles are on the floor, hips just over the seat."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from sim.motion.gait import part_poses
from sim.motion.sitting import seated_poses
from sim.motion.skeleton import PART_NAMES, skeleton

AT = {name: k for k, name in enumerate(PART_NAMES)}


@given(st.floats(1.4, 2.05), st.floats(0.8, 1.2), st.floats(0.25, 0.5))
def test_bones_keep_their_lengths_and_the_soles_are_on_the_floor(stature_m: float, build: float, seat_m: float) -> None:
    bones = skeleton(stature_m, build)
    poses = seated_poses(bones, np.eye(4), seat_m)
    place = poses[:, :3, 3]
    np.testing.assert_allclose(np.linalg.det(poses[:, :3, :3]), 1.0, atol=1e-9)
    for side in ("left", "right"):
        thigh, shin, foot = (AT[f"{side}_{name}"] for name in ("thigh", "shin", "foot"))
        assert np.linalg.norm(place[shin] - place[thigh]) == pytest.approx(bones.thigh)
        assert np.linalg.norm(place[foot] - place[shin]) == pytest.approx(bones.shin)
        # A thigh's own frame leads from the hip down to the knee.
        np.testing.assert_allclose(place[thigh] - bones.thigh * poses[thigh, :3, 2], place[shin], atol=1e-9)
        assert place[foot, 2] == pytest.approx(bones.ankle)
        assert 0.02 < place[thigh, 2] - seat_m < 0.13
        assert place[shin, 0] > place[thigh, 0] + 0.15


def test_the_trunk_is_as_it_is_standing_but_lower() -> None:
    bones = skeleton(1.75, 1.0)
    T = np.eye(4)
    T[:3, 3] = (3.0, -2.0, 0.5)
    stands, sits = part_poses(bones, T, 0.0, 0.0), seated_poses(bones, T, 0.4)
    lower = (sits - stands)[[AT[name] for name in ("pelvis", "torso", "head")]]
    np.testing.assert_allclose(lower[:, :2], 0.0, atol=1e-12)
    assert np.ptp(lower[:, 2, 3]) < 1e-12
    assert lower[0, 2, 3] < -0.3


def test_a_seat_that_is_too_high_is_named() -> None:
    with pytest.raises(ValueError, match=r"seat_m: expected a height that a person of 1\.75 m sits on, got 1\.2"):
        seated_poses(skeleton(1.75, 1.0), np.eye(4), 1.2)
