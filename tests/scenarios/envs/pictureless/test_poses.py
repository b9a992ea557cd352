from __future__ import annotations

import numpy as np
from scipy.spatial.transform import Rotation

from scenarios.envs.pictureless.poses import turned


def test_small_turns_are_rotations() -> None:
    rng = np.random.default_rng(6)
    for scale in (1e-14, 1e-3, 2.0):
        R, vector, out = Rotation.random(rng=rng).as_matrix(), rng.normal(0, scale, 3), np.zeros((3, 3))
        turned(R, vector, out)
        np.testing.assert_allclose(out, R @ Rotation.from_rotvec(vector).as_matrix(), atol=1e-12)
