"""Walking people: joints that hold together, feet that stay where they stand, angles as measured on people."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from sim.meshes.person import person_parts
from sim.meshes.person_parts import PersonLook
from sim.motion.gait import STANCE, part_poses, phase_rate_radps, stride_length_m
from sim.motion.skeleton import PART_NAMES, Skeleton, skeleton
from sim.pose import pose_on_ground

HERE = np.eye(4)
PART = {name: index for index, name in enumerate(PART_NAMES)}
MIRROR = np.diag([1.0, -1.0, 1.0, 1.0])
OTHER_SIDE = [PART[name.replace("left", "*").replace("right", "left").replace("*", "right")] for name in PART_NAMES]
PHASES_RAD = 2.0 * np.pi * np.arange(48) / 48

bones = st.builds(skeleton, st.floats(1.37, 2.07), st.floats(0.8, 1.2))
phases = st.floats(-20.0, 20.0)
speeds = st.one_of(st.just(0.0), st.floats(0.0, 2.5), st.floats(0.0, 1e-6))


def sole_m(body: Skeleton) -> NDArray[np.float64]:
    """Return the lower vertices of a shoe's mesh (V, 4), homogeneous, in the foot's frame."""
    mesh = person_parts(PersonLook(stature_m=body.stature), np.random.default_rng(0))["left_foot"]
    low = mesh.vertices_m[mesh.vertices_m[:, 2] < -0.5 * body.ankle].astype(float)
    return np.column_stack([low, np.ones(len(low))])


def flexion_deg(poses: NDArray[np.float64], part: str) -> NDArray[np.float64]:
    """Return how far forward the lower ends of a part (N,) are turned, from its poses (N, P, 4, 4)."""
    R = poses[:, PART[part]]
    return np.rad2deg(np.arctan2(-R[:, 0, 2], R[:, 2, 2]))


@given(bones, phases, speeds, st.floats(-3.2, 3.2))
@settings(max_examples=150, deadline=None)
def test_parts_hang_together_at_their_joints(body, phase_rad, speed_mps, yaw_rad):
    poses = part_poses(body, pose_on_ground(3.0, -2.0, yaw_rad), phase_rad, speed_mps)
    np.testing.assert_allclose(np.linalg.det(poses[:, :3, :3]), 1.0)
    np.testing.assert_allclose(
        poses[:, :3, :3] @ poses[:, :3, :3].transpose(0, 2, 1), np.tile(np.eye(3), (13, 1, 1)), atol=1e-12
    )
    joints = [("pelvis", (0, 0, body.pelvis), "torso"), ("torso", (0, 0, body.neck), "head")]
    for side, sign in (("left", 1), ("right", -1)):
        joints += [
            ("torso", (0, sign * body.half_shoulders, body.shoulder), f"{side}_upper_arm"),
            (f"{side}_upper_arm", (0, 0, -body.upper_arm), f"{side}_forearm"),
            ("pelvis", (0, sign * body.half_hips, 0), f"{side}_thigh"),
            (f"{side}_thigh", (0, 0, -body.thigh), f"{side}_shin"),
            (f"{side}_shin", (0, 0, -body.shin), f"{side}_foot"),
        ]
    for upper, place_m, lower in joints:
        joint_m = poses[PART[upper]] @ np.array([*place_m, 1.0])
        np.testing.assert_allclose(joint_m, poses[PART[lower]][:, 3], atol=1e-3, err_msg=f"{upper}, {lower}")


@pytest.mark.parametrize("speed_mps", [0.0, 0.05, 0.5, 1.0, 1.4, 2.2])
@pytest.mark.parametrize("stature_m", [1.37, 1.75, 2.07])
def test_soles_are_on_the_ground_and_never_under_it(stature_m, speed_mps):
    body = skeleton(stature_m, 1.0)
    sole = sole_m(body)
    for phase_rad in PHASES_RAD:
        poses = part_poses(body, HERE, phase_rad, speed_mps)
        lowest_m = [float((sole @ poses[PART[f"{side}_foot"]].T)[:, 2].min()) for side in ("left", "right")]
        assert min(lowest_m) == pytest.approx(0.0, abs=0.005)
        for foot, share in enumerate((phase_rad / (2 * np.pi) % 1.0, (phase_rad / (2 * np.pi) + 0.5) % 1.0)):
            if share <= STANCE:
                assert lowest_m[foot] == pytest.approx(0.0, abs=0.005)


@pytest.mark.parametrize("speed_mps", [0.2, 0.8, 1.3, 2.0])
def test_what_touches_the_ground_does_not_slide(speed_mps):
    body = skeleton(1.75, 1.0)
    sole, step_s = sole_m(body), 0.004
    rate_radps = phase_rate_radps(body.stature, speed_mps)
    touched = 0
    for phase_rad in PHASES_RAD:
        before = part_poses(body, HERE, phase_rad, speed_mps)
        after = part_poses(
            body, pose_on_ground(speed_mps * step_s, 0.0, 0.0), phase_rad + rate_radps * step_s, speed_mps
        )
        for foot, begin in ((PART["left_foot"], 0.0), (PART["right_foot"], 0.5)):
            shares = (np.array([phase_rad, phase_rad + rate_radps * step_s]) / (2 * np.pi) + begin) % 1.0
            if not shares[0] < shares[1] < STANCE:
                continue
            then, now = sole @ before[foot].T, sole @ after[foot].T
            touching = (then[:, 2] < 0.001) & (now[:, 2] < 0.001)
            touched += int(touching.any())
            slid_m = np.linalg.norm((now - then)[touching, :2], axis=1)
            assert (slid_m < 0.1 * speed_mps * step_s).all()
    assert touched > 0.8 * len(PHASES_RAD)


@given(bones, phases, speeds)
@settings(max_examples=60, deadline=None)
def test_left_does_what_right_does_half_a_stride_later(body, phase_rad, speed_mps):
    one = part_poses(body, HERE, phase_rad, speed_mps)
    other = part_poses(body, HERE, phase_rad + np.pi, speed_mps)
    np.testing.assert_allclose(MIRROR @ one[OTHER_SIDE] @ MIRROR, other, atol=1e-6)


@given(bones, phases)
@settings(max_examples=40, deadline=None)
def test_at_no_speed_everybody_stands_still_and_upright(body, phase_rad):
    standing = part_poses(body, HERE, phase_rad, 0.0)
    np.testing.assert_allclose(standing, part_poses(body, HERE, 0.0, 0.0), atol=1e-12)
    np.testing.assert_allclose(MIRROR @ standing[OTHER_SIDE] @ MIRROR, standing, atol=1e-12)
    # 0.845 of the stature are below the head's joint; knees are never quite straight.
    assert standing[PART["head"], 2, 3] == pytest.approx(0.845 * body.stature, abs=0.004 * body.stature)
    assert np.abs(standing[:, 0, 3]).max() < 0.06 * body.stature
    slowest = part_poses(body, HERE, phase_rad, 1e-9)
    np.testing.assert_allclose(slowest, standing, atol=1e-3)


@given(bones, phases, speeds)
@settings(max_examples=60, deadline=None)
def test_nothing_jumps(body, phase_rad, speed_mps):
    """However slow or fast: joints move at less than 8 statures a stride, parts turn at less than 6 turns."""
    step_rad = 2.0 * np.pi / 2000
    one, next_one = (part_poses(body, HERE, phase_rad + k * step_rad, speed_mps) for k in (0, 1))
    assert np.abs(next_one[:, :3, 3] - one[:, :3, 3]).max() < 8.0 * body.stature / 2000
    assert np.abs(next_one[:, :3, :3] - one[:, :3, :3]).max() < 6.0 * 2.0 * np.pi / 2000


def test_the_same_phase_is_the_same_pose():
    np.testing.assert_array_equal(*(part_poses(skeleton(1.7, 1.0), HERE, 1.0, 1.3) for _ in range(2)))


def test_strides_grow_with_stature_and_the_root_of_speed():
    assert stride_length_m(1.72, 1.3) == pytest.approx(2 * 0.71, abs=0.02)
    assert stride_length_m(1.9, 1.3) / stride_length_m(1.7, 1.3) == pytest.approx(1.9 / 1.7)
    assert phase_rate_radps(1.7, 1.1) * stride_length_m(1.7, 1.1) == pytest.approx(2 * np.pi * 1.1)
    assert phase_rate_radps(1.7, 0.0) == 0.0
    assert stride_length_m(1.7, 9.0) == pytest.approx(1.05 * 1.7)


def test_hips_knees_and_ankles_bend_as_measured():
    """Against the mean curves of Winter 1991 at natural cadence, read at single percent of the stride."""
    body = skeleton(1.75, 1.0)
    poses = np.array([part_poses(body, HERE, 2 * np.pi * k / 100, 1.3) for k in range(100)])
    thigh, shin, foot = (flexion_deg(poses, f"left_{part}") for part in ("thigh", "shin", "foot"))
    hip, knee, ankle = thigh, thigh - shin, foot - shin
    measured_hip = {0: 21, 10: 20, 20: 12, 30: 3, 40: -6, 50: -11, 60: -6, 80: 20, 90: 22}
    measured_knee = {0: 4, 15: 20, 30: 13, 40: 8, 60: 37, 75: 63, 85: 38, 95: 5}
    assert all(abs(hip[percent] - angle) < 9 for percent, angle in measured_hip.items())
    assert all(abs(knee[percent] - angle) < 12 for percent, angle in measured_knee.items())
    assert knee.min() > 0.0
    assert 55 < knee.max() < 70
    assert 10 < ankle[30:50].max() < 20
    assert -15 < ankle[55:75].min() < 0


def test_arms_swing_against_the_legs():
    body = skeleton(1.75, 1.0)
    poses = np.array([part_poses(body, HERE, phase_rad, 1.3) for phase_rad in PHASES_RAD])
    for side in ("left", "right"):
        arm, leg = flexion_deg(poses, f"{side}_upper_arm"), flexion_deg(poses, f"{side}_thigh")
        assert np.corrcoef(arm, leg)[0, 1] < -0.8
        assert 25 < np.ptp(arm) < 45
        elbow = flexion_deg(poses, f"{side}_forearm") - arm
        assert 10 < elbow.min() < elbow.max() < 50


def test_the_pelvis_goes_up_and_down_twice_a_stride():
    body = skeleton(1.75, 1.0)
    height_m = np.array([part_poses(body, HERE, phase_rad, 1.3)[0, 2, 3] for phase_rad in PHASES_RAD])
    assert 0.02 < np.ptp(height_m) < 0.05
    assert np.abs(np.fft.rfft(height_m - height_m.mean())).argmax() == 2
    assert height_m.max() < part_poses(body, HERE, 0.0, 0.0)[0, 2, 3]


def test_impossible_people_and_speeds_are_named():
    with pytest.raises(ValueError, match="stature_m: expected a length within"):
        skeleton(2.4, 1.0)
    with pytest.raises(ValueError, match="build: expected a factor within"):
        skeleton(1.7, 2.0)
    with pytest.raises(ValueError, match="speed_mps: expected a speed >= 0 m/s, got -1"):
        part_poses(skeleton(1.7, 1.0), HERE, 0.0, -1.0)
