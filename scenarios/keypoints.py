"""Named points of bodies, joints of people and the middle line of fish: what they are called, how they are scored."""

from __future__ import annotations

from dataclasses import dataclass

from sim.motion.keypoints import PERSON_POINTS
from sim.motion.swim import CENTRE_LINE_POINTS


@dataclass(frozen=True)
class Keypoints:
    """K points of the objects of a class.

    Attributes:
        names: (K,). links: pairs of points, from 0, that a drawing joins.
        sigmas: (K,) spreads for COCO's object keypoint similarity.
        flesh: (K,) how deep a point may lie below the visible surface to count as seen, shares of the object's longest
            side; a limb's depth, with clothes.
        place_m: field of truth with their places, (N, K, 3); NaN for objects of other classes. place_px: field with
            those in the picture; "": where a pinhole camera sees them.
    """

    names: tuple[str, ...]
    links: tuple[tuple[int, int], ...]
    sigmas: tuple[float, ...]
    flesh: tuple[float, ...]
    place_m: str
    place_px: str = ""


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

FISH = Keypoints(
    names=("snout", *(f"body-{k}" for k in range(1, CENTRE_LINE_POINTS - 1)), "tail"),
    links=tuple((k, k + 1) for k in range(CENTRE_LINE_POINTS - 1)),
    sigmas=(0.05,) * CENTRE_LINE_POINTS,
    flesh=(0.2,) * CENTRE_LINE_POINTS,
    place_m="centre_line_m",
    place_px="centre_line_px",
)
"""Points at equal distances from snout to the end of the tail fin; the spreads are our own choice."""
