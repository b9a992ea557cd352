"""Chains of fish's segments: they hold together, and the centre line lies on them."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh
from hypothesis import given, settings
from hypothesis import strategies as st

from sim.motion.swim import CENTRE_LINE_POINTS, JOINT_COUNT, MIDDLE, SEGMENT_ENDS, swim_pose

joints = st.lists(st.floats(-0.6, 0.6), min_size=JOINT_COUNT, max_size=JOINT_COUNT)
poses = st.tuples(st.floats(-7.0, 7.0), st.floats(-0.5, 0.5), joints, st.floats(0.01, 0.2))


def one(yaw_rad, pitch_rad, joints_rad, length_m, place_m=(0.1, -0.2, 0.05)):
    made = swim_pose(
        np.array([length_m]),
        np.array([place_m]),
        np.array([yaw_rad]),
        np.array([pitch_rad]),
        np.array([joints_rad], dtype=float),
    )
    return made.T_world_segment[0], made.centre_line_m[0]


def chained(yaw_rad, pitch_rad, joints_rad, length_m, place_m):
    """The poses again, from products of transforms by another library, joint after joint from head to tail."""
    turn, move = trimesh.transformations.rotation_matrix, trimesh.transformations.translation_matrix
    lengths = np.diff(SEGMENT_ENDS) * length_m
    chain = [np.eye(4)]
    for k, angle in enumerate(joints_rad):
        chain.append(chain[-1] @ move([-lengths[k], 0, 0]) @ turn(-angle, [0, 0, 1]))
    middle = next(k for k, end in enumerate(SEGMENT_ENDS[1:]) if end > MIDDLE)
    anchor = chain[middle] @ move([-(MIDDLE - SEGMENT_ENDS[middle]) * length_m, 0, 0])
    body = move(place_m) @ turn(yaw_rad, [0, 0, 1]) @ turn(-pitch_rad, [0, 1, 0])
    return np.array([body @ np.linalg.inv(anchor) @ T for T in chain])


@given(poses)
@settings(max_examples=80, deadline=None)
def test_poses_are_those_of_a_chain_of_joints(pose):
    T, _ = one(*pose)
    np.testing.assert_allclose(T, chained(*pose, (0.1, -0.2, 0.05)), atol=1e-12)


@given(poses)
@settings(max_examples=80, deadline=None)
def test_centre_line_lies_on_the_segments_axes_at_equal_distances_along_them(pose):
    T, line_m = one(*pose)
    length_m = pose[3]
    for n, share in enumerate(np.linspace(0.0, 1.0, CENTRE_LINE_POINTS)):
        k = min(int(np.searchsorted(SEGMENT_ENDS, share, side="right")) - 1, len(T) - 1)
        here = T[k] @ [-(share - SEGMENT_ENDS[k]) * length_m, 0.0, 0.0, 1.0]
        np.testing.assert_allclose(line_m[n], here[:3], atol=1e-12)
    np.testing.assert_allclose(line_m[CENTRE_LINE_POINTS // 2], (0.1, -0.2, 0.05), atol=1e-12)


def test_a_fish_bent_to_its_left_has_both_ends_there():
    _, line_m = one(0.0, 0.0, [0.2] * JOINT_COUNT, 0.035, (0.0, 0.0, 0.0))
    assert line_m[0, 1] > 0.003
    assert line_m[-1, 1] > 0.003
    assert line_m[0, 0] > line_m[-1, 0]


def test_a_snout_rises_with_positive_pitch():
    _, line_m = one(1.0, 0.2, [0.0] * JOINT_COUNT, 0.035)
    assert line_m[0, 2] > line_m[4, 2] > line_m[-1, 2]


def test_shapes_that_do_not_fit_are_named():
    good = [np.ones(2), np.zeros((2, 3)), np.zeros(2), np.zeros(2), np.zeros((2, JOINT_COUNT))]
    for place, name in enumerate(("position_m", "yaw_rad", "pitch_rad", "joints_rad"), start=1):
        bad = list(good)
        bad[place] = bad[place][:1]
        with pytest.raises(ValueError, match=f"^{name}: expected shape"):
            swim_pose(*bad)
