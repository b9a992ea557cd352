"""What a driver by hand wants from moment to moment, and how he errs, drawn for a whole episode beforehand.

So the same driver can drive again among other people and differs only where he sees something else.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter1d

from scenarios.stereo_follow.walks import held_values

_REACTION_S = (0.2, 0.4)
_WISH_M, _WISH_S = (1.2, 3.7), (2.5, 5.0)
_BURST_MPS, _BURST_S = (1.0, 1.6), (0.8, 2.0)
_SLACK_M = (0.2, 0.7)
_AIM_RAD, _AIM_S = (-0.36, 0.36), (1.5, 3.5)
_TOLERANCE_RAD = (0.10, 0.26)
_ATTENDS_S, _LOOKS_AWAY_S = (2.0, 5.0), (0.4, 1.1)
_RANGE_ERROR, _BEARING_ERROR_RAD, _ERRORS_LAST_S = 0.08, 0.02, 0.8
_CARRY, _CARRY_RAD, _CARRY_LASTS_S = (0.5, 1.2), (-0.35, 0.35), (0.5, 1.5)
_UNSTEADY_MPS, _UNSTEADY_RAD_S, _UNSTEADY_S = 0.05, 0.06, 0.3


@dataclass(frozen=True, slots=True)
class Whims:
    """A driver over F frames; all but the first are (F,) arrays.

    Attributes:
        reaction_frames: from a picture to his hand.
        distance_m: that he wants to the target. slack_m: by which the target walks on before he drives off.
        burst_mps: speed at which he drives.
        aim_rad: bearing at which he leaves the target in the picture. tolerance_rad: around it, before he turns.
        attends: whether he looks at the picture.
        range_error, bearing_error_rad: of his judgement, the first as a share of the distance.
        carry, carry_rad: share of the target's speed, and turn of its direction, with which he imagines it to walk on
            while he does not see it.
        unsteady_mps, unsteady_rad_s: of his hand.
    """

    reaction_frames: int
    distance_m: NDArray[np.float64]
    slack_m: NDArray[np.float64]
    burst_mps: NDArray[np.float64]
    aim_rad: NDArray[np.float64]
    tolerance_rad: NDArray[np.float64]
    attends: NDArray[np.bool_]
    range_error: NDArray[np.float64]
    bearing_error_rad: NDArray[np.float64]
    carry: NDArray[np.float64]
    carry_rad: NDArray[np.float64]
    unsteady_mps: NDArray[np.float64]
    unsteady_rad_s: NDArray[np.float64]


def draw_whims(frames: int, rate_hz: float, rng: np.random.Generator) -> Whims:
    """Draw the whims of F frames."""

    def held(values: tuple[float, float], lasting_s: tuple[float, float]) -> NDArray[np.float64]:
        return held_values(values, lasting_s, frames, rate_hz, rng)

    def wandering(deviation: float, lasting_s: float) -> NDArray[np.float64]:
        noise = gaussian_filter1d(rng.normal(size=frames), lasting_s * rate_hz, mode="wrap")
        # The filter leaves this share of the deviation.
        return noise * deviation * np.sqrt(2.0 * np.sqrt(np.pi) * lasting_s * rate_hz)

    return Whims(
        reaction_frames=round(rng.uniform(*_REACTION_S) * rate_hz),
        distance_m=held(_WISH_M, _WISH_S),
        slack_m=held(_SLACK_M, _WISH_S),
        burst_mps=held(_BURST_MPS, _BURST_S),
        aim_rad=held(_AIM_RAD, _AIM_S),
        tolerance_rad=held(_TOLERANCE_RAD, _AIM_S),
        attends=_attention(frames, rate_hz, rng),
        range_error=wandering(_RANGE_ERROR, _ERRORS_LAST_S),
        bearing_error_rad=wandering(_BEARING_ERROR_RAD, _ERRORS_LAST_S),
        carry=held(_CARRY, _CARRY_LASTS_S),
        carry_rad=held(_CARRY_RAD, _CARRY_LASTS_S),
        unsteady_mps=wandering(_UNSTEADY_MPS, _UNSTEADY_S),
        unsteady_rad_s=wandering(_UNSTEADY_RAD_S, _UNSTEADY_S),
    )


def _attention(frames: int, rate_hz: float, rng: np.random.Generator) -> NDArray[np.bool_]:
    """Return whether he looks at the picture on each frame (F,); he does so at first."""
    attends = np.ones(frames, dtype=np.bool_)
    begin = 0
    while begin < frames:
        begin += int(rng.uniform(*_ATTENDS_S) * rate_hz)
        end = begin + int(rng.uniform(*_LOOKS_AWAY_S) * rate_hz)
        attends[begin:end] = False
        # At few pictures a second both last less than one.
        begin = max(end, begin + 1)
    return attends
