"""Segments of a standing person: which rigid parts there are and where their joints lie."""

from __future__ import annotations

from typing import NamedTuple

from sim.checks import check

PART_NAMES = (
    "pelvis",
    "torso",
    "head",
    "left_upper_arm",
    "left_forearm",
    "right_upper_arm",
    "right_forearm",
    "left_thigh",
    "left_shin",
    "left_foot",
    "right_thigh",
    "right_shin",
    "right_foot",
)
"""Every rigid part, in the order of all arrays of parts.

A part's frame has its origin in the joint that it hangs from (the pelvis: between the hip joints) and, in a person who
stands upright with hanging arms, x ahead, y left and z up. Hands belong to the forearms, the neck to the head.
"""

STATURE_M = (1.05, 2.07)
"""Least and greatest stature; children of five years and more are among them."""
BUILD = (0.8, 1.2)
"""Least and greatest factor of girths."""


class Figure(NamedTuple):
    """Proportions of a body relative to those of the average one, of the same stature and ``build``.

    Attributes:
        shoulders, hips: factors of breadths, within [0.8, 1.25].
        waist: factor of breadth and depth there, within [0.75, 1.5].
        belly, bust: how much farther ahead these reach, as shares of the depth there, within [0, 0.8].
        limbs: factor of the lengths of legs and arms, within [0.88, 1.08]; the trunk makes up for it.
        head: factor of its size, within [0.9, 1.45].
    """

    shoulders: float = 1.0
    hips: float = 1.0
    waist: float = 1.0
    belly: float = 0.0
    bust: float = 0.0
    limbs: float = 1.0
    head: float = 1.0

    @property
    def trunk(self) -> float:
        """Factor of the trunk's length: all heights add up to the stature."""
        return 1.0 - (_LEG * (self.limbs - 1.0) + _HEAD * (self.head - 1.0)) / _TRUNK

    @property
    def elbow_room(self) -> float:
        """Factor by which the shoulders' joints move apart beside a wide waist."""
        return max(1.0, 0.6 + 0.4 * self.waist)


AVERAGE = Figure()
_WITHIN = {
    "shoulders": (0.8, 1.25),
    "hips": (0.8, 1.25),
    "waist": (0.75, 1.5),
    "belly": (0.0, 0.8),
    "bust": (0.0, 0.8),
    "limbs": (0.88, 1.08),
    "head": (0.9, 1.45),
}
_LEG, _TRUNK, _HEAD = 0.491, 0.315, 0.155
"""Heights as shares of stature: hip to ankle, hip to the joint of the head, that joint to the crown."""


class Skeleton(NamedTuple):
    """Lengths in metres, all floats. Heights add up to the stature: ankle, shin, thigh, pelvis, neck, head.

    Attributes:
        stature: from sole to crown.
        shin, thigh, upper_arm, forearm: from joint to joint; the forearm ends at the wrist.
        ankle: height of the ankle above the flat sole.
        pelvis: from between the hips up to the joint of the torso.
        shoulder, neck: from the torso's joint up to the shoulders and to the joint of the head.
        half_hips, half_shoulders: from the middle to a hip joint, and to a shoulder joint.
        half_track: from the middle to the line that a foot walks on.
        heel, ball, toe: how far the sole reaches behind the ankle, lies flat before it, and reaches in all.
        toe_rise: height of the shoe's tip when the sole lies flat.
    """

    stature: float
    shin: float
    thigh: float
    upper_arm: float
    forearm: float
    ankle: float
    pelvis: float
    shoulder: float
    neck: float
    half_hips: float
    half_shoulders: float
    half_track: float
    heel: float
    ball: float
    toe: float
    toe_rise: float


def skeleton(stature_m: float, build: float, figure: Figure = AVERAGE) -> Skeleton:
    """Return the segments of a person.

    Shares of stature after Drillis and Contini (1966), in Winter, "Biomechanics and motor control of human movement":
    ankle 0.039, knee 0.285, hip 0.530, shoulder 0.818, upper arm 0.186, forearm 0.146, foot 0.152. Our own choice are
    the joint of the torso at 0.620, that of the head at 0.845, and joints that lie further inside than the shoulders'
    and hips' outlines (0.129 and 0.096 from the middle). The shoe is 4 mm longer than the foot.

    Args:
        stature_m: within ``STATURE_M``.
        build: factor of girths within ``BUILD``; hips move apart by 0.4 of it, shoulders by 0.7.
        figure: proportions other than these.

    Raises:
        ValueError: for a size outside these.
    """
    check("stature_m", STATURE_M[0] <= stature_m <= STATURE_M[1], f"a length within {STATURE_M} m", stature_m)
    check("build", BUILD[0] <= build <= BUILD[1], f"a factor within {BUILD}", build)
    for name, (low, high) in _WITHIN.items():
        got = getattr(figure, name)
        check(f"figure.{name}", low <= got <= high, f"a number within [{low:g}, {high:g}]", got)
    apart = 0.6 + 0.4 * build
    shares = {
        "stature": 1.0,
        "shin": 0.246 * figure.limbs,
        "thigh": 0.245 * figure.limbs,
        "upper_arm": 0.186 * figure.limbs,
        "forearm": 0.146 * figure.limbs,
        "ankle": 0.039,
        "pelvis": 0.090 * figure.trunk,
        "shoulder": 0.198 * figure.trunk,
        "neck": 0.225 * figure.trunk,
        "half_hips": 0.048 * apart * figure.hips,
        "half_shoulders": 0.108 * (0.3 + 0.7 * build) * figure.shoulders * figure.elbow_room,
        "half_track": 0.030 * apart,
        "heel": 0.040,
        "ball": 0.074,
        "toe": 0.1145,
        "toe_rise": 0.009,
    }
    return Skeleton(**{name: share * stature_m for name, share in shares.items()})
