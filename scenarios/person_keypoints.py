"""The named points of people, as COCO has them."""

from __future__ import annotations

from scenarios.truth import Keypoints
from sim.motion.keypoints import PERSON_POINTS


def _sides(of_head: tuple[float, ...], of_limbs: tuple[float, ...]) -> tuple[float, ...]:
    """Return values of nose, eyes, ears and of all joints, of which left and right are alike."""
    return (of_head[0], *(value for value in (*of_head[1:], *of_limbs) for _ in range(2)))


PERSON = Keypoints(
    names=PERSON_POINTS,
    # Of COCO, which counts them from 1.
    links=tuple(
        (a - 1, b - 1)
        for a, b in (
            *((16, 14), (14, 12), (17, 15), (15, 13), (12, 13), (6, 12), (7, 13), (6, 7), (6, 8), (7, 9)),
            *((8, 10), (9, 11), (2, 3), (1, 2), (1, 3), (2, 4), (3, 5), (4, 6), (5, 7)),
        )
    ),
    sigmas=_sides((0.026, 0.025, 0.035), (0.079, 0.072, 0.062, 0.107, 0.087, 0.089)),
    flesh=_sides((0.02, 0.02, 0.02), (0.07, 0.04, 0.035, 0.12, 0.05, 0.05)),
    place_m="keypoints_m",
)
"""The 17 points of COCO, with its spreads (https://cocodataset.org/#keypoints-eval)."""
