"""Truth of what is real: what files say in pixels, of one target or of many, or nothing."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from scenarios.truth import Truth, truth_field

DISTRACTOR, OTHER = "distractor", "other"
"""Kinds of objects of real sequences that are no targets: what a tracker may take for one, and what else has a box."""


@dataclass(frozen=True, slots=True)
class SequenceTruth(Truth):
    """Truth of one frame of a real sequence. All that is in metres is NaN.

    ``state`` is ``in`` or ``partial`` (the border cuts it) where the target has a box; ``occluded`` where files say so,
    with a box if a part of it is seen; ``out`` where it is outside the picture, or has no box and no file says why.
    A frame of which no file tells anything is ``unlabelled``: it is shown to trackers and no score counts it.
    ``box_xyxy`` is NaN where the target is not seen, ``visible_fraction`` is 0 there and else NaN.

    Attributes:
        outside: (N,) whether files say that it is outside the picture; false where it may be hidden.
    """

    outside: NDArray[np.bool_] = truth_field("1", "N")


_Kind = TypeVar("_Kind", bound=Truth)


def truth_in_pixels(
    kind: type[_Kind],
    frame: int,
    time_s: float,
    names: tuple[str, ...],
    kinds: tuple[str, ...],
    box_xyxy: NDArray[np.float64],
    state: NDArray[np.str_],
    **known: Any,
) -> _Kind:
    """Return the truth of N objects of which boxes (N, 4) and states (N,) are known.

    Args:
        kind: its class. known: further fields; the others are NaN, -1 or empty, and identities are counted.
    """
    count = len(names)
    unknown: dict[str, Any] = {
        "T_world_camera": np.full((4, 4), np.nan),
        "T_world_object": np.full((count, 4, 4), np.nan),
        "size_m": np.full((count, 3), np.nan),
        "speed_mps": np.full(count, np.nan),
        "position_px": 0.5 * (box_xyxy[:, :2] + box_xyxy[:, 2:]),
        "instance_id": np.arange(count),
        "visible_fraction": np.full(count, np.nan),
        "side": np.full(count, ""),
        "frames_since_exit": np.full(count, -1),
        "instance_map": np.empty((0, 0), np.int32),
        "depth_m": np.empty((0, 0), np.float32),
        "exposure_s": float("nan"),
        "gain": float("nan"),
    }
    given = {"frame": frame, "time_s": time_s, "names": names, "kinds": kinds, "box_xyxy": box_xyxy, "state": state}
    return kind(**unknown | given | known)
